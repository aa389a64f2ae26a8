"""The slider on the belt in motion: its shapes at a time, and films of them."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .figure import animate, check_film_path
    from .shapes import MODE_NAMES, Layout, Shape, layout_of, shapes_at
    from .timing import Timing, usual_speed
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
