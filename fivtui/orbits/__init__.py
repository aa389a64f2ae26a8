"""Limit cycles and attractors: shooting, basins of attraction, continuation."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .attractor_search import (
        Coexistence as Coexistence,
        attractors as attractors,
        coexistence as coexistence,
    )
    from .basins import basin as basin
    from .boundaries.fold_orbits import (
        FoldOrbit as FoldOrbit,
        fold_near as fold_near,
        folds_of as folds_of,
    )
    from .boundaries.result import BOUNDARIES as BOUNDARIES
    from .boundaries.search import boundary as boundary
    from .branches import continuation as continuation
    from .curves.charts import (
        branch_chart as branch_chart,
        event_name as event_name,
        sizes_of as sizes_of,
    )
    from .curves.crossings import cycles_at as cycles_at
    from .curves.cycle_branches import (
        branch as branch,
        branch_through as branch_through,
    )
    from .curves.events import End as End, EventKind as EventKind
    from .curves.result import CycleBranch as CycleBranch, CyclePoint as CyclePoint
    from .decay import Attraction as Attraction
    from .explorer import Explorer as Explorer
    from .rest import length_scale as length_scale, slowest_period as slowest_period
    from .words import (
        SEARCHING as SEARCHING,
        coexistence_words as coexistence_words,
        reached_words as reached_words,
    )
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
