"""The slider on the belt in motion: its shapes at a time, and films of them."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .charts import belt_chart
    from .figure import animate, check_film_path
    from .shapes import Layout, layout_of
    from .timing import Timing, watchable_speed
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
