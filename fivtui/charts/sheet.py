"""Figures of results: the charts that a study declares, drawn by matplotlib."""

import math
import re
from collections.abc import Collection, Mapping, Sequence
from textwrap import fill
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap, Normalize
from matplotlib.figure import Figure, FigureBase
from matplotlib.gridspec import SubplotSpec
from matplotlib.patches import Rectangle

from .axis import Axis
from .chart import (
    CASE_COLOURS,
    CASE_LINES,
    LINE_COLOURS,
    WIDTH,
    Backdrop,
    Chart,
    Contours,
    FloatArray,
    Guide,
    Sheet,
    Trace,
    reduced,
)
from .labels import Label
from .plotting import (
    OFF_BELT,
    STUCK,
    STYLE,
    new_figure,
    shade_times,
)
from .shades import LEAST_CONTRAST, Colours

_TITLE_SIZE: Final = 7.5
_PANEL_GAP: Final = 0.06
# Markers and dashes distinguish the series of a chart also in black and white.
_SERIES: Final[tuple[Mapping[str, Any], ...]] = (
    {"color": "#12803c", "marker": "o", "linestyle": "-"},
    {"color": "#00867d", "marker": "s", "linestyle": "--"},
    {"color": "#1f4fd8", "marker": "^", "linestyle": "-"},
    {"color": "#7a3fc4", "marker": "v", "linestyle": "--"},
    {"color": "#c8252c", "marker": "D", "linestyle": "-"},
    {"color": "#b07d00", "marker": "x", "linestyle": "-"},
    {"color": "0.35", "marker": "+", "linestyle": "--"},
    {"color": "black", "marker": "*", "linestyle": ":"},
    {"color": "#c2378f", "marker": "P", "linestyle": ":"},
)
_DASHES: Final = ("-", (0.0, (6.0, 2.0)), (0.0, (6.0, 1.5, 1.0, 1.5)), (0.0, (1.2, 1.2)))
# Styles of traces and guides in figures, by role.
ROLES: Final[Mapping[str, Mapping[str, Any]]] = {
    "front": {"color": "0.8", "linewidth": 4.0, "zorder": 1.0},
    "mode 1": {"color": "#1f4fd8", "linestyle": "-", "linewidth": 1.4},
    "mode 2": {"color": "#b07d00", "linestyle": (0.0, (4.0, 1.5)), "linewidth": 1.4},
    "path": {"color": "0.6", "linestyle": "none", "marker": ".", "markersize": 2.0},
    "present point": {
        "color": "black",
        "linestyle": "none",
        "marker": "D",
        "markersize": 4.5,
        "markerfacecolor": "white",
    },
    "stable": {"color": "#12803c", "linestyle": "-"},
    "unstable": {"color": "#1f4fd8", "linestyle": "--"},
    "event": {
        "color": "black",
        "linestyle": "none",
        "markersize": 5.0,
        "markerfacecolor": "white",
    },
    "chosen cycle": {"marker": ".", "markersize": 4.0, "zorder": 3.0},
    "stable orbit": {"linestyle": "-", "linewidth": 0.9},
    "unstable orbit": {"linestyle": "--", "linewidth": 0.9},
    "unit circle": {"color": "0.6", "linewidth": 0.6},
    "stable multipliers": {
        "color": "#12803c",
        "linestyle": "none",
        "marker": ".",
        "markersize": 2.0,
    },
    "unstable multipliers": {
        "color": "#1f4fd8",
        "linestyle": "none",
        "marker": ".",
        "markersize": 2.0,
    },
    "critical": {"color": "#c8252c", "linestyle": ":", "linewidth": 1.0, "zorder": 1.5},
    "present": {"color": "0.35", "linestyle": "-.", "linewidth": 0.8, "zorder": 1.4},
    "attractor": {"linestyle": "none", "markersize": 4.5, "markerfacecolor": "none"},
    **{
        role: {
            "color": colour,
            "linestyle": "none",
            "marker": marker,
            "markersize": 2.2,
            "markeredgecolor": "0.3",
            "markeredgewidth": 0.2,
        }
        for role, colour, marker in (
            ("safe region", "#a8c8a0", "o"),
            ("knock region", "#e0b080", "s"),
            ("squeal region", "#8fa8e0", "^"),
        )
    },
    "alone": {"color": "#1f4fd8", "edgecolor": "black", "linewidth": 0.4},
    "with others": {"color": "0.75", "edgecolor": "black", "linewidth": 0.4},
    "linear": {
        "color": "black",
        "linestyle": "none",
        "marker": "D",
        "markersize": 3.5,
        "markerfacecolor": "white",
    },
    "boundary": {"color": "black", "linestyle": "-", "linewidth": 1.4},
    **{
        f"{name}, {'considered' if case else 'ignored'}": {
            "color": CASE_COLOURS[case][0],
            "linestyle": CASE_LINES[case],
            "linewidth": width,
        }
        for name, width in (("peak", 1.4), ("half range", 0.7), ("output", 1.0))
        for case in (True, False)
    },
    **{
        f"limit, {'considered' if case else 'ignored'}": {
            "color": CASE_COLOURS[case][0],
            "linestyle": ":",
            "linewidth": 0.8,
            "zorder": 1.5,
        }
        for case in (True, False)
    },
    **{
        f"{'considered' if case else 'ignored'}{name}": {
            "linestyle": "-" if name == ", fine" else CASE_LINES[case],
            "linewidth": width,
            "markersize": 3.5,
            "zorder": 2.5 if case else 2.0,
        }
        for name, width in (("", 1.1), (", thin", 0.6), (", fine", 0.6))
        for case in (True, False)
    },
    **{
        f"line {number}": {"color": colour, "linestyle": dashes, "linewidth": 1.3}
        for number, (colour, dashes) in enumerate(zip(LINE_COLOURS, _DASHES, strict=True), 1)
    },
    "critical point": {
        "color": "black",
        "linestyle": "none",
        "marker": "o",
        "markersize": 4.5,
        "markerfacecolor": "white",
        "zorder": 3.0,
    },
    "computed": {"linewidth": 1.1},
    "measured": {"color": "#c2410c", "linestyle": "--", "linewidth": 0.9},
    "deviation": {"color": "0.25", "linewidth": 0.8},
    "tolerance": {"alpha": 0.18, "linewidth": 0.0},
    "belt": {"color": "0.4", "linestyle": ":", "linewidth": 0.5, "zorder": 1.0},
    "contours": {"color": "0.25", "linestyle": "dashed", "linewidth": 0.5},
    "nearly": {"color": "black", "linestyle": "-", "linewidth": 1.2},
    "half": {"color": "black", "linestyle": (0.0, (1.0, 1.5)), "linewidth": 1.2},
}
_ZERO: Final[Mapping[str, Any]] = {"color": "0.4", "linewidth": 0.5, "zorder": 1.0}
# Hatching of areas.
_HATCHES: Final[Mapping[str, str]] = {
    "safe region": "",
    "knock region": "...",
    "squeal region": "///",
}
# Font sizes of sheets with many panels.
_SMALL: Final[dict[Any, Any]] = {
    "axes.labelsize": 7.5,
    "axes.titlesize": 7.5,
    "xtick.labelsize": 6.5,
    "ytick.labelsize": 6.5,
}
_BAR: Final = 0.36
_EDGE: Final = "black"
# Area of a coloured point, pt², and maximum number of contour lines of a kind.
_DOT: Final = 9.0
_CONTOURS: Final = 7
# Maximum number of points of a line with a mark at each.
_MARKED: Final = 60
# Marks of a line, and columns of a reduced long line (several per pixel).
_MARKS: Final = 12
_COLUMNS: Final = 4000
# Legend: characters per line of a figure of full width, width of a sample in characters, markup of
# mathtext that takes no width, and line spacing, inches.
_LEGEND_WIDTH: Final = 100
_SAMPLE: Final = 8
_MARKUP: Final = re.compile(r"\\mathrm|[${}_^]")
_LEGEND_LINE: Final = 0.18
# Shades of strips, from the first.
_STRIPS: Final = (OFF_BELT, STUCK)


def sheet_figure(sheet: Sheet, without: Collection[str] = ()) -> Figure:
    """Draw the charts of a sheet; the figure has an Agg canvas.

    Charts over the same quantity and limits share their x axis, charts of the same quantity in a
    row their y axis. Names of `without` are not in the legend.
    """
    with mpl.rc_context(STYLE | (_SMALL if sheet.small else {})):
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
        if sheet.small:
            for axes, _ in panels:
                axes.locator_params(axis="x", nbins=5)
        _add_title(figure, [axes for axes, _ in panels], sheet.title)
        below = [axes for axes, chart in panels if chart.legend == "below"]
        _add_legend(figure, below, without)
    return figure


def _draw_panels(figure: FigureBase, sheet: Sheet) -> list[tuple[Axes, Chart]]:
    cells = _places(figure, sheet)
    panels: list[tuple[Axes, Chart]] = []
    first_over: dict[Any, Axes] = {}
    first_in_row: dict[Any, Axes] = {}
    scales: dict[Colours, tuple[list[Axes], ScalarMappable]] = {}
    for column, charts in enumerate(sheet.columns):
        start = len(panels)
        for row, chart in enumerate(charts):
            if chart is None:
                continue
            key = chart.x_label, chart.figure_x, "x" in chart.log
            over = first_over.get(key) if chart.x_label else None
            row_key = row, chart.y_label, chart.figure_y
            beside = first_in_row.get(row_key) if chart.y_label else None
            axes = figure.add_subplot(cells[column][row], sharex=over, sharey=beside)
            first_over.setdefault(key, axes)
            first_in_row[row_key] = axes
            coloured = _draw_chart(axes, chart)
            if beside is not None:
                axes.set_ylabel("")
                axes.tick_params(labelleft=False)
            if chart.colours is not None and coloured is not None:
                scales.setdefault(chart.colours, ([], coloured))[0].append(axes)
            panels.append((axes, chart))
        # Align per column: matplotlib treats separate grids of columns as one column.
        figure.align_ylabels([axes for axes, _ in panels[start:]])
    for colours, (parts, coloured) in scales.items():
        edges = not isinstance(colours.colours, str)
        bar = figure.colorbar(coloured, ax=parts, label=_math(colours.label), drawedges=edges)
        if colours.ticks:
            bar.set_ticks(colours.ticks, labels=list(map(_math, colours.names)) or None)
    return panels


def _places(figure: FigureBase, sheet: Sheet) -> list[list[SubplotSpec]]:
    """The grid cells of the charts of every column."""
    count, widths, heights = len(sheet.columns), sheet.widths or None, sheet.heights or None
    rows = [len(charts) for charts in sheet.columns]
    if len(set(rows)) == 1:
        grid = figure.add_gridspec(rows[0], count, width_ratios=widths, height_ratios=heights)
        return [[grid[row, column] for row in range(rows[0])] for column in range(count)]
    columns = figure.add_gridspec(1, count, width_ratios=widths)
    parts = [columns[0, column].subgridspec(size, 1) for column, size in enumerate(rows)]
    return [[part[row, 0] for row in range(size)] for part, size in zip(parts, rows, strict=True)]


def _add_title(figure: Figure, panels: Sequence[Axes], title: str) -> None:
    if title and len(panels) > 1:
        figure.suptitle(title, fontsize=_TITLE_SIZE)
    elif title:
        panels[0].set_title(title, fontsize=_TITLE_SIZE)


def _add_legend(figure: Figure, panels: Sequence[Axes], without: Collection[str]) -> None:
    """One legend of all panels: each name once, as the last panel draws it."""
    handles: dict[str, Any] = {}
    for axes in panels:
        drawn, names = axes.get_legend_handles_labels()
        handles.update(zip(names, drawn, strict=True))
    for name in without:
        handles.pop(name, None)
    if not handles:
        return
    longest = max(len(_MARKUP.sub("", name)) for name in handles) + _SAMPLE
    fitting = max(1, int(_LEGEND_WIDTH * figure.get_figwidth() / WIDTH) // longest)
    # The fewest columns for the needed number of rows.
    columns = math.ceil(len(handles) / math.ceil(len(handles) / fitting))
    wrapped = [
        fill(name, _LEGEND_WIDTH, break_on_hyphens=False, break_long_words=False)
        for name in handles
    ]
    lines = math.ceil(sum(name.count("\n") + 1 for name in wrapped) / columns)
    figure.set_figheight(figure.get_figheight() + _LEGEND_LINE * (lines - 1))
    figure.legend(
        list(handles.values()),
        wrapped,
        loc="outside lower center",
        ncols=columns,
        frameon=False,
        handlelength=3.0,
    )


def _draw_chart(axes: Axes, chart: Chart) -> ScalarMappable | None:
    """Draw a chart. Returns the artist that is coloured by values."""
    coloured = None
    _scale(axes, chart)
    if chart.colours is not None or chart.backdrop is not None:
        axes.grid(visible=False)
    if chart.backdrop is not None:
        coloured = _shade(axes, chart.backdrop, chart.colours)
    if chart.stacked:
        _stack(axes, chart.traces)
    else:
        coloured = _draw_traces(axes, chart) or coloured
    for number, strip in enumerate(chart.strips):
        shade_times(axes, strip.intervals, _STRIPS[number % len(_STRIPS)], strip.meaning)
    _limit(axes, chart)
    for guide in chart.guides:
        _draw_guide(axes, guide)
    _label(axes, chart)
    return coloured


def _label(axes: Axes, chart: Chart) -> None:
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
            fontsize=6.0,
            frameon=False,
            handlelength=1.5,
        )
    elif chart.legend == "inside":
        axes.legend(frameon=False, fontsize=8.0, handlelength=3.0)


def _draw_traces(axes: Axes, chart: Chart) -> ScalarMappable | None:
    coloured, series = None, 0
    for index, trace in enumerate(chart.traces):
        if trace.values is not None and chart.colours is not None:
            scale = _scale_of(chart.colours)
            coloured = axes.scatter(trace.x, trace.y, _DOT, trace.values, linewidths=0.0, **scale)
        # A trace without points is not in the legend, unless it has a style.
        elif trace.x.size or trace.style:
            look = _look(trace, series)
            if trace.look == "bars":
                _draw_bars(axes, trace, look)
            elif trace.look == "area":
                axes.fill(trace.x, trace.y, label=_math(trace.name), **look)
            else:
                x, y = _points(trace, chart)
                if trace.marker and trace.ordered:
                    every = max(x.size // _MARKS, 1)
                    look["markevery"] = (every * index // len(chart.traces), every)
                axes.plot(x, y, label=_math(trace.name) or "_", **look)
        series += trace.role == "series" and trace.x.size > 0
    return coloured


def _points(trace: Trace, chart: Chart) -> tuple[FloatArray, FloatArray]:
    """The visible points of a trace within the limits of a chart."""
    low, high = chart.figure_x
    if not trace.ordered or trace.look != "line":
        return trace.x, trace.y
    ends = (trace.x[0] if low is None else low, trace.x[-1] if high is None else high)
    return reduced(trace, Axis(*ends, log="x" in chart.log), _COLUMNS)


def _draw_bars(axes: Axes, trace: Trace, look: Mapping[str, Any]) -> None:
    ends = None if trace.errors is None else np.abs(np.array(trace.errors) - trace.x)
    error = {"linewidth": 0.8, "capsize": 1.5}
    axes.barh(trace.y, trace.x, _BAR, xerr=ends, error_kw=error, label=_math(trace.name), **look)


def _stack(axes: Axes, traces: Sequence[Trace]) -> None:
    bottom = np.zeros(traces[0].x.size)
    for trace in traces:
        top = bottom + trace.y
        axes.fill_between(
            trace.x,
            bottom,
            top,
            label=_math(trace.name),
            facecolor=ROLES[trace.role]["color"],
            hatch=_HATCHES[trace.role],
            edgecolor="0.35",
            linewidth=0.2,
        )
        bottom = top


def _look(trace: Trace, series: int) -> dict[str, Any]:
    look = dict(ROLES.get(trace.role, {}))
    if trace.role == "series":
        look = {"markersize": 4.5, "linewidth": 0.9, **_SERIES[series % len(_SERIES)]}
    elif trace.look == "marked" and trace.x.size <= _MARKED:
        look |= {"marker": ".", "markersize": 4.0}
    if trace.colour:
        look["color"] = trace.colour
    if trace.marker:
        look["marker"] = trace.marker
    return look | dict(trace.style)


def _scale_of(colours: Colours) -> dict[str, Any]:
    names = colours.colours
    cmap = names if isinstance(names, str) else ListedColormap(names)
    return {"cmap": cmap, "norm": Normalize(colours.low, colours.high)}


def _shade(axes: Axes, backdrop: Backdrop, colours: Colours | None) -> ScalarMappable | None:
    """Colour the plane by values, or levels by their fills. Returns the artist of the values."""
    plane: dict[str, Any] = {"shading": "nearest", "rasterized": True, "zorder": 0.0}
    x, y, levels = backdrop.x, backdrop.y, backdrop.levels.T
    scale = {} if colours is None else _scale_of(colours)
    if min(levels.shape) < 2:
        points = np.meshgrid(x, y)
        return axes.scatter(*points, _DOT, backdrop.values.T, linewidths=0.0, **scale)
    mesh = axes.pcolormesh(x, y, backdrop.values.T, **plane, **scale) if scale else None
    filled = np.array([bool(shade.fill) for shade in backdrop.shades])
    if filled[levels].any():
        fills = [shade.fill or "none" for shade in backdrop.shades]
        shown = np.ma.masked_where(~filled[levels], levels)
        norm = BoundaryNorm(np.arange(len(fills) + 1) - 0.5, len(fills))
        axes.pcolormesh(x, y, shown, cmap=ListedColormap(fills), norm=norm, **plane)
    named = {}
    for level, shade in enumerate(backdrop.shades):
        inside = np.equal(levels, level).astype(float)
        if inside.any() and shade.fill and shade.name:
            named[shade.name] = shade
        if inside.any() and shade.hatch and not inside.all():
            axes.contourf(x, y, inside, levels=[0.5, 1.5], colors="none", hatches=[shade.hatch])
            axes.contour(x, y, inside, levels=[0.5], colors="black", linewidths=0.8)
    for name, shade in named.items():
        patch = Rectangle((0.0, 0.0), 0.0, 0.0, facecolor=shade.fill, hatch=shade.hatch)
        patch.set(label=_math(name), edgecolor=_EDGE, linewidth=0.5)
        axes.add_patch(patch)
    for contours in backdrop.contours:
        _draw_contours(axes, backdrop, contours)
    return mesh


def _draw_contours(axes: Axes, backdrop: Backdrop, contours: Contours) -> None:
    values = np.ma.masked_invalid(contours.values.T)
    finite = values.compressed()
    if not finite.size:
        return
    low, high = float(finite.min()), float(finite.max())
    levels: int | list[float] = [level for level in contours.levels if low < level < high]
    if not contours.levels:
        # Space lines at least by the smallest visible difference.
        least = LEAST_CONTRAST * max(abs(low), abs(high))
        levels = int(min((high - low) / least, _CONTOURS)) if least > 0.0 else 0
    if not levels:
        return
    look = ROLES[contours.role]
    lines = axes.contour(
        backdrop.x,
        backdrop.y,
        values,
        levels=levels,
        colors=look["color"],
        linewidths=look["linewidth"],
        linestyles=[look["linestyle"]],
    )
    if contours.label:
        axes.clabel(lines, fontsize=6.5, fmt=contours.label)
    if contours.name:
        axes.plot([], [], label=_math(contours.name), **look)


def _scale(axes: Axes, chart: Chart) -> None:
    # Set scales before drawing: data may be invalid on a logarithmic axis.
    if "x" in chart.log:
        axes.set_xscale("log", nonpositive="mask")
    if "y" in chart.log:
        axes.set_yscale("log", nonpositive="mask")
    if None not in chart.figure_x:
        axes.set_xlim(*chart.figure_x)
    if None not in chart.figure_y:
        axes.set_ylim(*chart.figure_y)


def _limit(axes: Axes, chart: Chart) -> None:
    if chart.tight and not chart.plane and chart.traces:
        axes.set_xlim(chart.traces[0].x[0], chart.traces[0].x[-1])
    if chart.linear_within:
        axes.set_xscale("symlog", linthresh=chart.linear_within)
    elif chart.to_scale:
        fixed = None not in chart.figure_x
        axes.set_aspect("equal", adjustable="box" if fixed else "datalim")
    if any(limit is not None for limit in chart.figure_x):
        axes.set_xlim(*chart.figure_x)
    if any(limit is not None for limit in chart.figure_y):
        axes.set_ylim(*chart.figure_y)


def _draw_guide(axes: Axes, guide: Guide) -> None:
    if guide.role == "floor":
        axes.axhspan(axes.get_ylim()[0], guide.value, color="0.93", zorder=0.0)
        return
    line = axes.axvline if guide.vertical else axes.axhline
    look = ROLES.get(guide.role)
    # Lines without a role have no name in the legend.
    if look is None:
        line(guide.value, label="_", **_ZERO)
    else:
        line(guide.value, label=_math(guide.label), **look)


def _math(label: str) -> str:
    return label.math if isinstance(label, Label) else label.replace("$", r"\$")
