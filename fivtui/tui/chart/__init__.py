"""Charts in characters: axes, traces, drawing; and the input of texts."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .axis import Axis as Axis
    from .chart import (
        Backdrop as Backdrop,
        Chart as Chart,
        Cursors as Cursors,
        Guide as Guide,
        Look as Look,
        Strip as Strip,
        Trace as Trace,
        View as View,
        VisibleCharts as VisibleCharts,
        reduced as reduced,
    )
    from .reading import (
        NearestPoint as NearestPoint,
        crosshair as crosshair,
        cursor_words as cursor_words,
        heading as heading,
        nearest as nearest,
    )
    from .widget.chart_view import ChartView as ChartView
    from .widget.text_input import TextInput as TextInput
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
