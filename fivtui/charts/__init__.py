"""Charts as data, their values at cursors, and their figures by matplotlib."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .axis import LIMITS_FORMAT, Axis, AxisTicks, parse_limits
    from .chart import (
        CASE_COLOURS,
        FIGURE_WIDTH,
        LINE_COLOURS,
        MAX_JOINED_SAMPLES,
        Backdrop,
        Chart,
        Contours,
        Cursors,
        Guide,
        Heading,
        Look,
        Position,
        Sheet,
        Strip,
        Trace,
        View,
        VisibleCharts,
        column_edges,
        guide_style,
        trace_mark,
        trace_style,
    )
    from .colours import (
        INKS,
        STRONG,
        PlotColours,
        figure_colour,
        mix,
        screen_colours,
        series_role,
    )
    from .displayed_charts import charts_figure, plot_pixels, save_charts
    from .figure_style import (
        FORMATS,
        OFF_BELT_COLOUR,
        STYLE,
        check_figure_path,
        drawing_settings,
        new_figure,
        save_figure,
        shade_times,
    )
    from .labels import (
        Label,
        axis_label,
        label_with_unit,
        math_symbol,
        math_unit,
        meaning_label,
        parameter_text,
        value_label,
    )
    from .plot_data import covered_shares, dense_band, envelope, shade_text
    from .readout import (
        CURSOR_SIGNS,
        NearestPoint,
        Span,
        crosshair,
        cursor_points,
        cursor_texts,
        has_long_heading,
        heading_spans,
        nearest_curve_value,
        nearest_index,
        nearest_indices,
        points_at,
    )
    from .shades import (
        BLANK,
        NO_VALUE,
        Band,
        Grading,
        Shade,
        Shades,
        colour_scale_of,
        grade,
        grade_values,
        hide_unused,
        plateau_labels,
        scale_swatches,
        shade_bands,
    )
    from .sheet import sheet_figure
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
