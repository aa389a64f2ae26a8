"""The slider on the belt in motion: its shapes at a time, and films of them."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .figure import animate as animate, check_film_path as check_film_path
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
