"""The slider on the belt in motion: its shapes at a time, and films of them."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .figure import animate as animate, check_film_path as check_film_path
    from .shapes import (
        MODE_NAMES as MODE_NAMES,
        Layout as Layout,
        Shape as Shape,
        layout_of as layout_of,
        shapes_at as shapes_at,
    )
    from .timing import (
        Timing as Timing,
        usual_speed as usual_speed,
    )
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
