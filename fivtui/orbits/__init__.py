"""Limit cycles and attractors: shooting, basins of attraction, continuation."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .attractor_continuation import continuation
    from .attractor_search import Coexistence, attractors, coexistence
    from .basins import basin
    from .boundaries.fold_orbits import FoldOrbit, fold_near, stabilising_folds
    from .boundaries.result import BOUNDARIES
    from .boundaries.search import boundary
    from .curves.charts import branch_chart, branch_extents, event_name
    from .curves.cycle_branches import branch, branch_through, cycles_at
    from .curves.events import End, EventKind
    from .curves.result import CycleBranch, CyclePoint, event_at
    from .decay import DecayRegion
    from .explorer import Explorer
    from .options import BranchOptions
    from .report import coexistence_phrase, transients_phrase
    from .rest import length_scale, reference_equilibrium, slowest_period
    from .vibration import vibration_flags
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
