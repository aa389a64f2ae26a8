"""Sweeps: results of many transients as rows, in memory or in resumable files."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .charts import check_drawable, grid_chart, sweep_chart, sweep_curves
    from .cluster import cluster_engine
    from .design import Design, Range, parse_design
    from .files import read_stored_studies, read_sweep, save_sweep
    from .options import PIECE, SCHEDULER, SWEEP_PRESETS, WORKERS, SweepOptions, varied_texts
    from .pieces import SweepPiece
    from .report import SweepProgress
    from .rows import Rows, compute_rows, concatenate
    from .run import (
        Engine,
        Sweep,
        check_memory_limit,
        load_sweep,
        local_engine,
        sweep,
        sweep_in_memory,
        sweep_to_file,
    )
    from .scatter import Correlations, Scatter, ScatterKind
    from .study import OUTPUTS, VIBRATES, Study, scene_study
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
