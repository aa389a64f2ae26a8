"""Charts in characters: axes, traces, drawing."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .axis import Axis as Axis
    from .chart import (
        Backdrop as Backdrop,
        Chart as Chart,
        Guide as Guide,
        Look as Look,
        NearestPoint as NearestPoint,
        Strip as Strip,
        Trace as Trace,
        View as View,
        VisibleCharts as VisibleCharts,
        reduced as reduced,
    )
    from .widget.chart_view import ChartView as ChartView
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
