"""Sweeps: many transients as rows, in memory or in resumable files."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .cluster import cluster_engine as cluster_engine
    from .design import VARIABLES as VARIABLES, Design as Design, Range as Range
    from .figure import check_drawable as check_drawable
    from .files import (
        begun_studies as begun_studies,
        read_sweep as read_sweep,
        save_sweep as save_sweep,
    )
    from .pieces import SweepPiece as SweepPiece
    from .report import SweepProgress as SweepProgress
    from .request import (
        SWEEP_PRESETS as SWEEP_PRESETS,
        parse_cases as parse_cases,
        parse_design as parse_design,
        study_of as study_of,
        varied_texts as varied_texts,
    )
    from .rows import Rows as Rows, compute_rows as compute_rows, joined as joined
    from .run import (
        Engine as Engine,
        Sweep as Sweep,
        check_in_memory as check_in_memory,
        load_sweep as load_sweep,
        local_engine as local_engine,
        sweep as sweep,
        sweep_in_memory as sweep_in_memory,
        sweep_to_file as sweep_to_file,
    )
    from .scatter import (
        Correlations as Correlations,
        Scatter as Scatter,
        ScatterKind as ScatterKind,
    )
    from .study import OUTPUTS as OUTPUTS, Study as Study
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
