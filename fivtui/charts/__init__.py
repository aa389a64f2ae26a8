"""Charts as data, read at cursors, and drawn by matplotlib; style and files of all figures."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .axis import (
        Axis as Axis,
        parse_limits as parse_limits,
    )
    from .chart import (
        COLOURS as COLOURS,
        MOST_JOINED as MOST_JOINED,
        WIDTH as WIDTH,
        Backdrop as Backdrop,
        Chart as Chart,
        Cursors as Cursors,
        Guide as Guide,
        Heading as Heading,
        Look as Look,
        Place as Place,
        Sheet as Sheet,
        Strip as Strip,
        Trace as Trace,
        View as View,
        VisibleCharts as VisibleCharts,
        reduced as reduced,
        trace_mark as trace_mark,
        trace_style as trace_style,
    )
    from .figure import (
        charts_figure as charts_figure,
        save_charts as save_charts,
    )
    from .labels import (
        Label as Label,
        axis_label as axis_label,
        math_symbol as math_symbol,
        math_unit as math_unit,
        parameter_line as parameter_line,
        quantity_label as quantity_label,
        value_label as value_label,
    )
    from .plot_data import (
        shading as shading,
        share_of_time as share_of_time,
    )
    from .plotting import (
        CASE_COLOURS as CASE_COLOURS,
        CASE_LINES as CASE_LINES,
        FORMATS as FORMATS,
        OFF_BELT as OFF_BELT,
        STUCK as STUCK,
        STYLE as STYLE,
        check_figure_path as check_figure_path,
        new_figure as new_figure,
        save_figure as save_figure,
        shade_times as shade_times,
        value_limits as value_limits,
    )
    from .reading import (
        CURSOR_SIGNS as CURSOR_SIGNS,
        NearestPoint as NearestPoint,
        Span as Span,
        crosshair as crosshair,
        cursor_words as cursor_words,
        heading as heading,
        is_long as is_long,
        nearest as nearest,
        nearest_along as nearest_along,
        nearest_index as nearest_index,
    )
    from .sheet import sheet_figure as sheet_figure
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
