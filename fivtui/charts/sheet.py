"""Figures of the charts of a result, drawn by matplotlib.

A sheet arranges charts in columns, or other sheets, its parts, one below the other. Each chart
becomes a panel, which is an `Axes` of matplotlib. The role of a trace or guide names its style in
`ROLES`.
"""

import math
import re
from collections.abc import Collection, Mapping, Sequence
from textwrap import fill
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap, Normalize
from matplotlib.figure import Figure, FigureBase
from matplotlib.gridspec import SubplotSpec
from matplotlib.patches import Rectangle
from matplotlib.patheffects import AbstractPathEffect, withStroke

from .axis import Axis
from .chart import (
    CASE_COLOURS,
    CASE_LINES,
    FIGURE_WIDTH,
    LINE_COLOURS,
    Backdrop,
    Chart,
    Contours,
    FloatArray,
    Guide,
    Sheet,
    Trace,
    column_edges,
)
from .colours import STRONG, figure_colour, grey, series_role
from .figure_style import (
    OFF_BELT_COLOUR,
    STUCK_COLOUR,
    STYLE,
    drawing_settings,
    new_figure,
    shade_times,
)
from .labels import Label
from .plot_data import envelope
from .shades import ColourScale

# Font sizes, pt.
_TITLE_SIZE: Final = 7.5
_LEGEND_SIZE_INSIDE: Final = 8.0
_LEGEND_SIZE_ABOVE: Final = 6.0
_CONTOUR_LABEL_SIZE: Final = 6.5
_PLATEAU_LABEL_SIZE: Final = 7.5
# Gap between panels side by side, relative to the figure's width.
_PANEL_GAP: Final = 0.06
# Styles of the traces of the role "series", in turn: distinct even in black and white.
_SERIES_STYLES: Final[tuple[Mapping[str, Any], ...]] = tuple(
    {"color": figure_colour(series_role(index)), "marker": marker, "linestyle": dashes}
    for index, (marker, dashes) in enumerate(
        zip("os^vDx+*P", ("-", "--", "-", "--", "-", "-", "--", ":", ":"), strict=True)
    )
)
# Strength of the colours of areas, which have lines and hatches over them.
_AREA_STRENGTH: Final = 0.45
# Dashes of the roles "line 1" to "line 4".
_DASHES: Final = ("-", (0.0, (6.0, 2.0)), (0.0, (6.0, 1.5, 1.0, 1.5)), (0.0, (1.2, 1.2)))
# Cases in the names of roles, such as "peak, considered": separation considered (True) or ignored.
_CASE_NAMES: Final = {True: "considered", False: "ignored"}


def _line(colour: str, dashes: Any, width: float, **properties: float) -> Mapping[str, Any]:
    # The properties of a line in the colour of a role, or black.
    code = colour if colour == "black" else figure_colour(colour)
    return {"color": code, "linestyle": dashes, "linewidth": width, **properties}


def _points(colour: str, marker: str, size: float, **properties: Any) -> Mapping[str, Any]:
    # The properties of points without lines; black points are hollow.
    style = {"linestyle": "none", "marker": marker, "markersize": size, **properties}
    if colour == "black":
        return {"color": colour, "markerfacecolor": "white", **style}
    return {"color": figure_colour(colour), **style}


def _area(colour: str, marker: str) -> Mapping[str, Any]:
    # The properties of points of a region, in the colour of its area.
    edge = {"markeredgecolor": "0.3", "markeredgewidth": 0.2}
    return {**_points(colour, marker, 2.2, **edge), "color": figure_colour(colour, _AREA_STRENGTH)}


def _case_lines(quantity: str, dashes: Any, width: float, **properties: float) -> dict[str, Any]:
    # The properties of an output of a sweep by role, one per case. The first colour of a case is
    # enough here; several colours distinguish runs over time.
    return {
        f"{quantity}, {name}": _line(
            CASE_COLOURS[case][0], dashes or CASE_LINES[case], width, **properties
        )
        for case, name in _CASE_NAMES.items()
    }


# Matplotlib's properties of traces and guides, by role.
ROLES: Final[Mapping[str, Mapping[str, Any]]] = {
    "Pareto front": {"color": "0.8", "linewidth": 4.0, "zorder": 1.0},
    "mode 1": _line("series-1", "-", 1.4),
    "mode 2": _line("series-2", (0.0, (4.0, 1.5)), 1.4),
    "path": _points("ghost", ".", 2.0),
    # The eigenvalues at the μ of the parameter set, in the complex plane.
    "present point": _points("black", "D", 4.5),
    "stable": {"color": figure_colour("series-1"), "linestyle": "-"},
    "unstable": {"color": figure_colour("series-2"), "linestyle": "--"},
    "event": {"color": "black", "linestyle": "none", "markersize": 5.0, "markerfacecolor": "white"},
    "chosen cycle": {"marker": ".", "markersize": 4.0, "zorder": 3.0},
    "stable orbit": {"linestyle": "-", "linewidth": 0.9},
    "unstable orbit": {"linestyle": "--", "linewidth": 0.9},
    "unit circle": {"color": figure_colour("ghost"), "linewidth": 0.6},
    "stable multipliers": _points("series-1", ".", 2.0, markeredgewidth=0.4),
    "unstable multipliers": _points("series-2", "x", 2.0, markeredgewidth=0.4),
    "critical": _line("danger", ":", 1.0, zorder=1.5),
    "safe": _line("safe", "-.", 1.0, zorder=1.5),
    # The μ of the parameter set.
    "present": _line("reference", "-.", 0.8, zorder=1.4),
    "attractor": {"linestyle": "none", "markersize": 4.5, "markerfacecolor": "none"},
    "safe region": _area("safe", "o"),
    "knock region": _area("warning", "s"),
    "squeal region": _area("danger", "^"),
    # First and total Sobol indices of an input, and its index if the output were linear.
    "alone": {"color": figure_colour("series-1"), "edgecolor": "black", "linewidth": 0.4},
    "with others": {"color": "0.75", "edgecolor": "black", "linewidth": 0.4},
    "linear": _points("black", "D", 3.5),
    "boundary": _line("black", "-", 1.4),
    # Outputs of a sweep: peak and half range of y, or any other output; and the output on a belt
    # that is always faster than the slider.
    **_case_lines("peak", None, 1.4),
    **_case_lines("half range", None, 0.7),
    **_case_lines("output", None, 1.0),
    **_case_lines("limit", ":", 0.8, zorder=1.5),
    # Runs over time. Thin lines: the whole run, beside its last cycles. Fine lines: the same where
    # dashes would be too narrow to be seen.
    **{
        f"{name}{suffix}": {
            "linestyle": "-" if suffix == ", fine" else CASE_LINES[separation],
            "linewidth": width,
            "markersize": 3.5,
            "zorder": 2.5 if separation else 2.0,
        }
        for suffix, width in (("", 1.1), (", thin", 0.6), (", fine", 0.6))
        for separation, name in _CASE_NAMES.items()
    },
    **{
        f"line {number}": _line(colour, dashes, 1.3)
        for number, (colour, dashes) in enumerate(zip(LINE_COLOURS, _DASHES, strict=True), 1)
    },
    "critical point": _points("black", "o", 4.5, zorder=3.0),
    "computed": {"color": figure_colour("series-1"), "linewidth": 1.1},
    "measured": _line(STRONG, "--", 0.9),
    "deviation": {"color": "0.25", "linewidth": 0.8},
    "tolerance": {"alpha": 0.18, "linewidth": 0.0},
    "belt": _line("belt", ":", 0.5, zorder=1.0),
    "contours": {"color": "0.25", "linestyle": "dashed", "linewidth": 0.5},
    "99 % of critical μ": _line("black", "-", 1.2),
    "50 % of critical μ": _line("black", (0.0, (1.0, 1.5)), 1.2),
}
# Style of guides without a role.
_PLAIN_GUIDE: Final[Mapping[str, Any]] = {
    "color": figure_colour("reference"),
    "linewidth": 0.5,
    "zorder": 1.0,
}
# Hatches of stacked areas, by role.
_HATCHES: Final[Mapping[str, str]] = {
    "safe region": "",
    "knock region": "...",
    "squeal region": "///",
}
# Font sizes, and number of intervals between ticks of x, of sheets with many panels.
_SMALL_TEXT: Final[dict[Any, Any]] = {
    "axes.labelsize": 7.5,
    "axes.titlesize": 7.5,
    "xtick.labelsize": 6.5,
    "ytick.labelsize": 6.5,
}
_SMALL_TEXT_X_INTERVALS: Final = 5
# Height of a bar relative to the distance between bars.
_BAR_HEIGHT: Final = 0.36
# Colour of the edges of hatched areas in the legend.
_EDGE_COLOUR: Final = "black"
# Area of a point that is coloured by its value, pt².
_POINT_AREA: Final = 9.0
# Traces of the look "marked" with at most this number of points have a marker at each point.
_MAX_MARKED: Final = 60
# Number of markers of an ordered line.
_MARKERS_PER_LINE: Final = 12
# Columns to which a line is reduced, several per pixel.
_REDUCED_COLUMNS: Final = 4000
# Characters in a line of a legend of full width, and width of the sample of a line beside a name.
_LEGEND_CHARACTERS: Final = 100
_SAMPLE_CHARACTERS: Final = 8
# Markup of mathtext, which takes no width.
_MATH_MARKUP: Final = re.compile(r"\\mathrm|[${}_^]")
# Height of a line of the legend, inches.
_LEGEND_LINE_HEIGHT: Final = 0.18
# Label of lines that have no entry in the legend: matplotlib omits labels with an underscore.
_NO_ENTRY: Final = "_"
# Colours of a chart's strips in their order, such as separation and stick.
_STRIP_COLOURS: Final = (OFF_BELT_COLOUR, STUCK_COLOUR)


def sheet_figure(sheet: Sheet, omitted: Collection[str] = ()) -> Figure:
    """Draw the charts of a sheet; the figure has an Agg canvas.

    Charts over the same quantity and limits share their x axis; charts of the same quantity in a
    row share their y axis. The legend omits the names in `omitted`.
    """
    with drawing_settings(STYLE | (_SMALL_TEXT if sheet.small_text else {})):
        gap = _PANEL_GAP if len(sheet.columns) > 1 else None
        figure = new_figure(*sheet.size, wspace=gap)
        panels: list[tuple[Axes, Chart]] = []
        if sheet.parts:
            heights = [part.size[1] for part in sheet.parts]
            areas = figure.subfigures(len(heights), height_ratios=heights, squeeze=False)
            for area, part in zip(areas.ravel(), sheet.parts, strict=True):
                panels += _draw_panels(area, part)
        else:
            panels = _draw_panels(figure, sheet)
        if sheet.small_text:
            for axes, _ in panels:
                axes.locator_params(axis="x", nbins=_SMALL_TEXT_X_INTERVALS)
        _add_title(figure, [axes for axes, _ in panels], sheet.title)
        legend_axes = [axes for axes, chart in panels if chart.legend == "below"]
        _add_legend(figure, legend_axes, omitted)
    return figure


def _draw_panels(figure: FigureBase, sheet: Sheet) -> list[tuple[Axes, Chart]]:
    """Draw the columns of a sheet. Returns the panels with their charts."""
    cells = _grid_cells(figure, sheet)
    panels: list[tuple[Axes, Chart]] = []
    axes_by_x: dict[Any, Axes] = {}
    axes_by_y: dict[Any, Axes] = {}
    # For each colour scale the panels that use it, and an artist in its colours.
    scale_users: dict[ColourScale, tuple[list[Axes], ScalarMappable]] = {}
    for column, charts in enumerate(sheet.columns):
        start = len(panels)
        for row, chart in enumerate(charts):
            if chart is None:
                continue
            x_key = chart.x_label, chart.figure_x, "x" in chart.log
            shared_x = axes_by_x.get(x_key) if chart.x_label else None
            y_key = row, chart.y_label, chart.figure_y
            shared_y = axes_by_y.get(y_key) if chart.y_label else None
            axes = figure.add_subplot(cells[column][row], sharex=shared_x, sharey=shared_y)
            axes_by_x.setdefault(x_key, axes)
            axes_by_y.setdefault(y_key, axes)
            scale, mappable = draw_chart(axes, chart)
            if shared_y is not None:
                axes.set_ylabel("")
                axes.tick_params(labelleft=False)
            if scale is not None and mappable is not None:
                users, _ = scale_users.setdefault(scale, ([], mappable))
                users.append(axes)
            panels.append((axes, chart))
        # Align per column: if every column has a grid of its own, matplotlib would align the labels
        # of all columns together.
        figure.align_ylabels([axes for axes, _ in panels[start:]])
    for scale, (users, mappable) in scale_users.items():
        # A tuple of colours is a scale of steps, with edges between them.
        has_edges = not isinstance(scale.colour_map, str)
        bar = figure.colorbar(mappable, ax=users, label=_math(scale.label), drawedges=has_edges)
        if scale.ticks:
            bar.set_ticks(scale.ticks, labels=list(map(_math, scale.names)) or None)
    return panels


def _grid_cells(figure: FigureBase, sheet: Sheet) -> list[list[SubplotSpec]]:
    """The grid cells of the charts of every column; columns may have different numbers of rows."""
    count, widths, heights = len(sheet.columns), sheet.widths or None, sheet.heights or None
    row_counts = [len(charts) for charts in sheet.columns]
    if len(set(row_counts)) == 1:
        rows = row_counts[0]
        grid = figure.add_gridspec(rows, count, width_ratios=widths, height_ratios=heights)
        return [[grid[row, column] for row in range(rows)] for column in range(count)]
    columns = figure.add_gridspec(1, count, width_ratios=widths)
    cells = []
    for column, rows in enumerate(row_counts):
        column_grid = columns[0, column].subgridspec(rows, 1)
        cells.append([column_grid[row, 0] for row in range(rows)])
    return cells


def _add_title(figure: Figure, panels: Sequence[Axes], title: str) -> None:
    if title and len(panels) > 1:
        figure.suptitle(title, fontsize=_TITLE_SIZE)
    elif title:
        panels[0].set_title(title, fontsize=_TITLE_SIZE)


def _add_legend(figure: Figure, panels: Sequence[Axes], omitted: Collection[str]) -> None:
    """Add a legend for all panels: each name once, in the style of the last panel that has it."""
    handles: dict[str, Any] = {}
    for axes in panels:
        artists, names = axes.get_legend_handles_labels()
        handles.update(zip(names, artists, strict=True))
    for name in omitted:
        handles.pop(name, None)
    if not handles:
        return
    entry_width = max(len(_MATH_MARKUP.sub("", name)) for name in handles) + _SAMPLE_CHARACTERS
    legend_width = int(_LEGEND_CHARACTERS * figure.get_figwidth() / FIGURE_WIDTH)
    max_columns = max(1, legend_width // entry_width)
    # The fewest columns for the needed number of rows.
    columns = math.ceil(len(handles) / math.ceil(len(handles) / max_columns))
    wrapped_names = [
        fill(name, _LEGEND_CHARACTERS, break_on_hyphens=False, break_long_words=False)
        for name in handles
    ]
    # The figure's height has room for one line of the legend.
    lines = math.ceil(sum(name.count("\n") + 1 for name in wrapped_names) / columns)
    figure.set_figheight(figure.get_figheight() + _LEGEND_LINE_HEIGHT * (lines - 1))
    figure.legend(
        list(handles.values()),
        wrapped_names,
        loc="outside lower center",
        ncols=columns,
        frameon=False,
        handlelength=3.0,
    )


def draw_chart(axes: Axes, chart: Chart) -> tuple[ColourScale | None, ScalarMappable | None]:
    """Draw a chart. Returns the scale of its colours, and the artist in these colours, if any."""
    _set_scales(axes, chart)
    scale, mappable = chart.colour_scale, None
    if chart.backdrop is not None:
        scale, mappable = _draw_backdrop(axes, chart.backdrop)
    if scale is not None or chart.backdrop is not None:
        axes.grid(visible=False)
    if chart.stacked:
        _draw_stacked_areas(axes, chart.traces)
    else:
        mappable = _draw_traces(axes, chart) or mappable
    for number, strip in enumerate(chart.strips):
        shade_times(
            axes, strip.intervals, _STRIP_COLOURS[number % len(_STRIP_COLOURS)], strip.meaning
        )
    _set_limits(axes, chart)
    for guide in chart.guides:
        _draw_guide(axes, guide)
    _set_labels(axes, chart)
    return scale, mappable


def _set_labels(axes: Axes, chart: Chart) -> None:
    if chart.x_axis:
        axes.set_xlabel(_math(chart.x_label))
    else:
        axes.tick_params(labelbottom=False)
    if chart.y_names:
        axes.set_yticks(range(len(chart.y_names)), [_math(name) for name in chart.y_names])
        axes.grid(visible=False, axis="y")
    axes.set_ylabel(_math(chart.y_label))
    axes.set_title(_math(chart.title))
    if chart.legend == "above":
        axes.legend(
            loc="lower center",
            bbox_to_anchor=(0.5, 1.0),
            ncols=2,
            fontsize=_LEGEND_SIZE_ABOVE,
            frameon=False,
            handlelength=1.5,
        )
    elif chart.legend == "inside":
        axes.legend(frameon=False, fontsize=_LEGEND_SIZE_INSIDE, handlelength=3.0)


def _draw_traces(axes: Axes, chart: Chart) -> ScalarMappable | None:
    mappable, series_index = None, 0
    for index, trace in enumerate(chart.traces):
        if trace.values is not None and chart.colour_scale is not None:
            colours = _colour_properties(chart.colour_scale)
            mappable = axes.scatter(
                trace.x, trace.y, _POINT_AREA, trace.values, linewidths=0.0, **colours
            )
        # A trace without points is in the legend only if it brings properties of its own.
        elif trace.x.size or trace.style:
            properties = _trace_properties(trace, series_index)
            if trace.look == "bars":
                _draw_bars(axes, trace, properties)
            elif trace.look == "area":
                axes.fill(trace.x, trace.y, label=_math(trace.name), **properties)
            else:
                x, y = _drawn_points(trace, chart)
                if trace.marker and trace.ordered:
                    # Markers of different traces are at different points.
                    spacing = max(x.size // _MARKERS_PER_LINE, 1)
                    properties["markevery"] = (spacing * index // len(chart.traces), spacing)
                axes.plot(x, y, label=_math(trace.name) or _NO_ENTRY, **properties)
        series_index += trace.role == "series" and trace.x.size > 0
    return mappable


def _drawn_points(trace: Trace, chart: Chart) -> tuple[FloatArray, FloatArray]:
    """The points of a trace to draw: an ordered line is reduced within the limits of x."""
    if not trace.ordered or trace.look != "line":
        return trace.x, trace.y
    low, high = chart.figure_x
    x_axis = Axis(
        trace.x[0] if low is None else low,
        trace.x[-1] if high is None else high,
        log="x" in chart.log,
    )
    return envelope(trace.x, trace.y, column_edges(x_axis, _REDUCED_COLUMNS))


def _draw_bars(axes: Axes, trace: Trace, properties: Mapping[str, Any]) -> None:
    # Lengths of the error bars below and above the values, shape (2, n).
    errors = None if trace.intervals is None else np.abs(np.array(trace.intervals) - trace.x)
    axes.barh(
        trace.y,
        trace.x,
        _BAR_HEIGHT,
        xerr=errors,
        error_kw={"linewidth": 0.8, "capsize": 1.5},
        label=_math(trace.name),
        **properties,
    )


def _draw_stacked_areas(axes: Axes, traces: Sequence[Trace]) -> None:
    bottom = np.zeros(traces[0].x.size)
    for trace in traces:
        top = bottom + trace.y
        axes.fill_between(
            trace.x,
            bottom,
            top,
            label=_math(trace.name),
            facecolor=figure_colour(trace.colour, _AREA_STRENGTH),
            hatch=_HATCHES[trace.role],
            edgecolor="0.35",
            linewidth=0.2,
        )
        bottom = top


def _trace_properties(trace: Trace, series_index: int) -> dict[str, Any]:
    properties = dict(ROLES.get(trace.role, {}))
    if trace.role == "series":
        properties = {
            "markersize": 4.5,
            "linewidth": 0.9,
            **_SERIES_STYLES[series_index % len(_SERIES_STYLES)],
        }
    elif trace.look == "marked" and trace.x.size <= _MAX_MARKED:
        properties |= {"marker": ".", "markersize": 4.0}
    if trace.colour:
        properties["color"] = figure_colour(trace.colour)
    if trace.marker:
        properties["marker"] = trace.marker
    return properties | dict(trace.style)


def _colour_properties(scale: ColourScale) -> dict[str, Any]:
    colours = scale.colour_map
    cmap = colours if isinstance(colours, str) else ListedColormap(colours)
    return {"cmap": cmap, "norm": Normalize(scale.low, scale.high)}


def _draw_backdrop(
    axes: Axes, backdrop: Backdrop
) -> tuple[ColourScale | None, ScalarMappable | None]:
    """Colour the plane by its levels; over it draw hatches, contours and labels.

    Returns the scale of the levels without a name, if any, and its colours.
    """
    x, y, levels = backdrop.x, backdrop.y, backdrop.levels.T
    is_shown = [bool(shade.text) for shade in backdrop.shades]
    numbers = np.cumsum(is_shown) - 1.0
    colours = [shade.figure_colour for shade in backdrop.shades if shade.text]
    norm = BoundaryNorm(np.arange(len(colours) + 1) - 0.5, len(colours))
    options: dict[str, Any] = {"cmap": ListedColormap(colours), "norm": norm, "zorder": 0.0}
    scale = _level_scale(backdrop)
    mappable = None if scale is None else ScalarMappable(**_colour_properties(scale))
    if min(levels.shape) < 2:
        # A single row or column of points has no area, thus no contours either.
        point_x, point_y = map(np.ravel, np.meshgrid(x, y))
        options |= {"edgecolors": grey(0.4), "linewidths": 0.3}
        axes.scatter(point_x, point_y, _POINT_AREA, numbers[levels].ravel(), **options)
        return scale, mappable
    axes.pcolormesh(x, y, numbers[levels], shading="nearest", rasterized=True, **options)
    legend_shades = {}
    for level, shade in enumerate(backdrop.shades):
        inside = np.equal(levels, level).astype(float)
        if inside.any() and shade.name:
            legend_shades[shade.name] = shade
        if inside.any() and shade.hatch and not inside.all():
            axes.contourf(x, y, inside, levels=[0.5, 1.5], colors="none", hatches=[shade.hatch])
            axes.contour(x, y, inside, levels=[0.5], colors="black", linewidths=0.8)
    for name, shade in legend_shades.items():
        patch = Rectangle((0.0, 0.0), 0.0, 0.0, facecolor=shade.figure_colour, hatch=shade.hatch)
        patch.set(label=_math(name), edgecolor=_EDGE_COLOUR, linewidth=0.5)
        axes.add_patch(patch)
    for contours in backdrop.contours:
        _draw_contours(axes, backdrop, contours)
    for label_x, label_y, text in backdrop.labels:
        label = axes.text(label_x, label_y, text, fontsize=_PLATEAU_LABEL_SIZE)
        label.set(ha="center", va="center", path_effects=_outline())
    return scale, mappable


def _outline() -> list[AbstractPathEffect]:
    # The outline of labels on colours.
    return [withStroke(linewidth=2.0, foreground=grey(1.0), alpha=0.8)]


def _level_scale(backdrop: Backdrop) -> ColourScale | None:
    """The scale of the levels without a name, by their numbers; None without such levels."""
    shades = [shade for shade in backdrop.shades if shade.text and not shade.name]
    if not shades:
        return None
    return ColourScale(
        backdrop.label,
        tuple(shade.figure_colour for shade in shades),
        -0.5,
        len(shades) - 0.5,
        tuple(range(len(shades))),
        tuple(shade.text for shade in shades),
    )


def _draw_contours(axes: Axes, backdrop: Backdrop, contours: Contours) -> None:
    values = np.ma.masked_invalid(contours.values.T)
    finite = values.compressed()
    if not finite.size:
        return
    low, high = float(finite.min()), float(finite.max())
    levels = [level for level in contours.line_values if low < level < high]
    if not levels:
        return
    style = ROLES[contours.role]
    lines = axes.contour(
        backdrop.x,
        backdrop.y,
        values,
        levels=levels,
        colors=style["color"],
        linewidths=style["linewidth"],
        linestyles=[style["linestyle"]],
    )
    if contours.label:
        for text in axes.clabel(lines, fontsize=_CONTOUR_LABEL_SIZE, fmt=contours.label):
            text.set_path_effects(_outline())
    if contours.name:
        axes.plot([], [], label=_math(contours.name), **style)


def _set_scales(axes: Axes, chart: Chart) -> None:
    # Set scales before drawing: data may be invalid on a logarithmic axis.
    if "x" in chart.log:
        axes.set_xscale("log", nonpositive="mask")
    if "y" in chart.log:
        axes.set_yscale("log", nonpositive="mask")
    # Fixed limits hold while the chart is drawn; `_set_limits` repeats them after changing x.
    if None not in chart.figure_x:
        axes.set_xlim(*chart.figure_x)
    if None not in chart.figure_y:
        axes.set_ylim(*chart.figure_y)


def _set_limits(axes: Axes, chart: Chart) -> None:
    if not (chart.x_margins or chart.is_plane) and chart.traces:
        axes.set_xlim(chart.traces[0].x[0], chart.traces[0].x[-1])
    if chart.linear_within:
        axes.set_xscale("symlog", linthresh=chart.linear_within)
    elif chart.to_scale:
        is_fixed = None not in chart.figure_x
        axes.set_aspect("equal", adjustable="box" if is_fixed else "datalim")
    if any(limit is not None for limit in chart.figure_x):
        axes.set_xlim(*chart.figure_x)
    if any(limit is not None for limit in chart.figure_y):
        axes.set_ylim(*chart.figure_y)


def _draw_guide(axes: Axes, guide: Guide) -> None:
    if guide.role == "floor":
        # Shade the errors that are too small to be measured, below the guide.
        axes.axhspan(axes.get_ylim()[0], guide.value, color="0.93", zorder=0.0)
        return
    line = axes.axvline if guide.vertical else axes.axhline
    style = ROLES.get(guide.role)
    if style is None:
        line(guide.value, label=_NO_ENTRY, **_PLAIN_GUIDE)
    else:
        line(guide.value, label=_math(guide.label), **style)


def _math(label: str) -> str:
    """A label in matplotlib's mathtext."""
    return label.math if isinstance(label, Label) else label.replace("$", r"\$")
