"""Charts in characters and as pictures, their colours and cursors, and an input for text."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .raster import Raster
    from .widget.chart_view import ChartView
    from .widget.drawn_chart import Control, ShadeScale, with_chart_colours
    from .widget.pictures import Pictures, TerminalReply, write_changes
    from .widget.text_input import TextInput
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
