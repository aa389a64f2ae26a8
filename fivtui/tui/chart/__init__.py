"""Charts drawn in characters, their cursors, and an input for text."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .widget.chart_view import ChartView
    from .widget.text_input import TextInput
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
