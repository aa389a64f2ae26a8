"""The terminal UI: a headless session under thin Textual widgets."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .browser import serve
    from .start import run
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
