"""Maps over two parameters: stability, critical and safe friction, and coexistence."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .charts import map_chart
    from .options import MapOptions
    from .result import MAP_VALUES, StabilityMap
    from .safety import safety_map
    from .stability import (
        MU_FREE_VALUES,
        check_map,
        check_points,
        compute_map,
        parse_map_value,
        stability_map,
    )
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
