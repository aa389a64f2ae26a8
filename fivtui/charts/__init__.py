"""Charts as data, read at cursors, and drawn by matplotlib; style and files of all figures."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .axis import Axis, parse_limits
    from .chart import (
        CASE_COLOURS,
        COLOURS,
        LINE_COLOURS,
        MOST_JOINED,
        WIDTH,
        Backdrop,
        Chart,
        Contours,
        Cursors,
        Guide,
        Heading,
        Look,
        Place,
        Sheet,
        Strip,
        Trace,
        View,
        VisibleCharts,
        reduced,
        trace_mark,
        trace_style,
    )
    from .figure import charts_figure, save_charts
    from .labels import (
        Label,
        axis_label,
        column_label,
        math_symbol,
        math_unit,
        parameter_line,
        value_label,
        with_unit,
    )
    from .plot_data import shading, share_of_time
    from .plotting import (
        FORMATS,
        OFF_BELT,
        STYLE,
        check_figure_path,
        new_figure,
        save_figure,
        shade_times,
    )
    from .reading import (
        CURSOR_SIGNS,
        NearestPoint,
        Span,
        crosshair,
        cursor_words,
        heading,
        is_long,
        nearest,
        nearest_along,
        nearest_index,
    )
    from .shades import (
        NO_VALUE,
        Colours,
        Levels,
        Shade,
        Shades,
        colours_of,
        graded,
        in_words,
        ranks,
        scale_words,
    )
    from .sheet import sheet_figure
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
