"""Charts as displayed, as a matplotlib figure or as columns. Imports no Textual."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, to_rgb
from matplotlib.figure import Figure

from fivtui.io import write_table
from fivtui.model import Column

from .axis import Axis
from .chart import (
    COLOURS,
    WIDTH,
    Backdrop,
    Chart,
    Guide,
    Heading,
    Trace,
    View,
    VisibleCharts,
    reduced,
)
from .labels import parameter_line
from .plotting import (
    STYLE,
    new_figure,
)
from .reading import crosshair, cursor_words, heading, nearest
from .shades import Shade
from .sheet import add_legend, draw_strips

# Markers per line, and columns that a long line is reduced to (several per pixel).
_MARKS: Final = 12
_COLUMNS: Final = 4000
_ROW: Final = 2.0
_LEAST_HEIGHT: Final = 3.4
_SQUARE: Final = 3.6
_MARKERS: Final[Mapping[str, str]] = {
    "●": "o", "○": "o", "■": "s", "□": "s", "▲": "^", "△": "^", "▼": "v", "▽": "v",
    "◆": "D", "◇": "D", "★": "*", "☆": "*", "×": "x", "+": "+", "▫": "s", "▬": "_",
}  # fmt: skip
_HOLLOW: Final = "○□△▽◇☆▫"
_NOW: Final = "◆"
# The first cursor and the second.
_CURSORS: Final[Sequence[Mapping[str, str]]] = (
    {"linestyle": "-", "markerfacecolor": "0.1"},
    {"linestyle": ":", "markerfacecolor": "white"},
)
# Points from which on they are small.
_MANY: Final = 300
# Dash patterns tell lines apart without colour.
_LINES: Final = ("-", (0.0, (5.0, 1.5)), (0.0, (1.0, 1.2)), (0.0, (5.0, 1.2, 1.0, 1.2)))
# Colours of the styles of shades, and how dark the characters are.
_SHADE_COLOURS: Final[Mapping[str, str]] = {
    "stable": "#009E73", "unstable": "#D55E00", "trace-1": "#0072B2", "trace-2": "#E69F00",
    "hidden": "#808080",
}  # fmt: skip
_DARKNESS: Final[Mapping[str, float]] = {
    " ": 0.0, "·": 0.15, ":": 0.3, "?": 0.35, "×": 0.6, "░": 0.35, "▒": 0.55, "▓": 0.75, "█": 1.0,
}  # fmt: skip
# Height of a figure around its panels, and letters of their labels an inch; letters of a title;
# height of a line of labels.
_AROUND_IN: Final = 1.2
_LETTERS_IN: Final = 14.0
_TITLE: Final = 84
_LINE_PT: Final = 9.5
# Width of a character of a guide's label, as a share of a panel over the whole width.
_LETTER: Final = 0.0095


def charts_figure(charts: VisibleCharts, heading: Heading | None = None) -> Figure:
    """A matplotlib figure of the displayed charts."""
    count = len(charts.panels)
    rows, columns = (1, count) if charts.across else (count, 1)
    height = _SQUARE if charts.across else max(_ROW * rows, _LEAST_HEIGHT)
    with mpl.rc_context(STYLE):
        figure = new_figure(WIDTH, height)
        grid = figure.subplots(rows, columns, squeeze=False)
        panels = [axes for row in grid for axes in row]
        for axes, (chart, view) in zip(panels, charts.panels, strict=True):
            limits = view.axes(chart)
            _limit(axes, limits)
            _draw(axes, chart, view)
            _guides(axes, chart, limits, columns)
            read = _cursors(axes, chart, view, first=axes is panels[0])
            _label(axes, chart, int(_LETTERS_IN * (height - _AROUND_IN) / rows))
            _title(axes, chart, read, _TITLE // columns)
        figure.align_ylabels()
        alone = [chart.traces[0].name for chart, _ in charts.panels if len(chart.traces) == 1]
        add_legend(figure, panels, without=alone)
        if heading is not None:
            figure.suptitle(_words(heading), fontsize=mpl.rcParams["font.size"])
    return figure


def _words(heading: Heading) -> str:
    first, *others = heading.parameters
    varied = [n for n in first.as_dict() if any(getattr(p, n) != getattr(first, n) for p in others)]
    line = parameter_line(first, [*heading.without, *varied])
    return f"{line}, separation ignored" if heading.ignored else line


def _limit(axes: Axes, limits: tuple[Axis, Axis]) -> None:
    # What has no place on a logarithmic axis is left out.
    x, y = limits
    if x.log:
        axes.set_xscale("log", nonpositive="mask")
    if y.log:
        axes.set_yscale("log", nonpositive="mask")
    axes.set_xlim(x.low, x.high)
    axes.set_ylim(y.low, y.high)


def _label(axes: Axes, chart: Chart, letters: int) -> None:
    # The label of the y axis has so many letters a line.
    axes.set_ylabel(fill(chart.y_label, letters), parse_math=False)
    if chart.x_axis:
        axes.set_xlabel(chart.x_label, parse_math=False)
    else:
        axes.tick_params(labelbottom=False)


def _title(axes: Axes, chart: Chart, read: str, letters: int) -> None:
    # The note, unless the scale of shades has it, and what the cursors read.
    note = "" if chart.backdrop is not None and chart.note == chart.backdrop.label else chart.note
    lines = [fill(words, letters) for words in (note, read) if words]
    if lines:
        axes.set_title("\n".join(lines), parse_math=False)


def _cursors(axes: Axes, chart: Chart, view: View, *, first: bool) -> str:
    """Draw the cursors and the points at them. Returns what they read, how far apart at `first`."""
    places = (view.cursors.first, view.cursors.second)
    found = [nearest(chart, view, place) for place in places]
    for place, points, look in zip(places, found, _CURSORS, strict=True):
        if place is None:
            continue
        line: dict[str, Any] = {
            "color": "0.1",
            "linewidth": 0.8,
            "linestyle": look["linestyle"],
            "label": "_",
        }
        across, up = crosshair(chart, place, points)
        if not chart.along:
            axes.axvline(across, **line)
        if chart.plane and not chart.along:
            axes.axhline(up, **line)
        axes.plot(
            [point.x for point in points],
            [point.y for point in points],
            "D",
            color="0.1",
            markerfacecolor=look["markerfacecolor"],
            markersize=5,
            zorder=4,
            label="_",
        )
    if not any(found):
        return ""
    spans, count = heading(chart, view, found[0], found[1])
    words = [text.strip() for text, _ in spans[:count]]
    label, (one, other) = chart.cursor_label, places
    if first and label and one is not None and other is not None:
        words = [*cursor_words(label, one[0], other[0]), *words]
    return ", ".join(filter(None, words))


def _draw(axes: Axes, chart: Chart, view: View) -> None:
    x, _ = view.axes(chart)
    if chart.backdrop is not None:
        _shade(axes, chart.backdrop)
    draw_strips(axes, chart)
    several = len(chart.traces) > 1
    # Runs of a smaller range are over those of a greater one, which would hide them.
    ranges = sorted({_range(trace) for trace in chart.traces if trace.number}, reverse=True)
    for index, trace in view.visible(chart):
        look = _look(trace, index, several=several)
        if trace.number:
            look["zorder"] += ranges.index(_range(trace)) / len(ranges)
        across, up = reduced(trace, x, _COLUMNS)
        if chart.to_scale:
            look |= {"linestyle": "-", "markevery": [across.size - 1]}
        elif several and trace.look == "line" and look["marker"]:
            every = max(across.size // _MARKS, 1)
            look["markevery"] = (every * index // len(chart.traces), every)
        axes.plot(across, up, label=trace.name.replace("$", r"\$") or "_", **look)
    if chart.to_scale:
        axes.set_aspect("equal")


def _range(trace: Trace) -> float:
    finite = trace.y[np.isfinite(trace.y)]
    return float(np.ptp(finite)) if finite.size else 0.0


def _look(trace: Trace, index: int, *, several: bool) -> dict[str, Any]:
    mark = trace.mark if several or trace.look != "line" else ""
    # Letters, and the point of now, lie on lines and shades of all colours.
    points = trace.look == "points"
    letter, small = mark.isalnum(), points and trace.x.size > _MANY
    marker = f"$\\mathrm{{{mark}}}$" if letter else _MARKERS.get(mark, "")
    look: dict[str, Any] = {
        "color": trace.colour
        or ("black" if letter or (points and mark == _NOW) else _colour(index)),
        "linestyle": "none" if trace.look in ("points", "dots") else "-",
        "linewidth": 1.0,
        "marker": "." if trace.look == "dots" else marker,
        "markersize": 2.0 if trace.look == "dots" else 7.0 if letter else 2.5 if small else 4.5,
        "zorder": 3.0 if trace.look == "points" else 2.0,
    }
    if trace.look in ("points", "marked") and not look["marker"]:
        look["marker"] = "o"
    if mark and mark in _HOLLOW:
        look["markerfacecolor"] = "white"
    if trace.look == "line" and not trace.mark:
        look["linestyle"] = _LINES[index % len(_LINES)]
    return look


def _colour(index: int) -> str:
    return COLOURS[index % len(COLOURS)]


def _guides(axes: Axes, chart: Chart, limits: tuple[Axis, Axis], columns: int) -> None:
    # Labels of neighbours stand on rows of their own.
    ends: list[float] = []
    for guide in chart.guides:
        start = float(limits[0 if guide.vertical else 1].place([guide.value])[0])
        if not 0.0 <= start <= 1.0:
            continue
        row = 0
        if guide.vertical and guide.label:
            row = next((row for row, end in enumerate(ends) if start > end), len(ends))
            ends[row : row + 1] = [start + (len(guide.label) + 1) * _LETTER * columns]
        _guide(axes, guide, row)


def _guide(axes: Axes, guide: Guide, row: int) -> None:
    line = axes.axvline if guide.vertical else axes.axhline
    line(guide.value, color="0.4", linewidth=0.6, zorder=1.0, label="_")
    if guide.label:
        where = (guide.value, 1.0) if guide.vertical else (1.0, guide.value)
        axes.annotate(
            guide.label,
            where,
            xycoords=axes.get_xaxis_transform() if guide.vertical else axes.get_yaxis_transform(),
            textcoords="offset points",
            xytext=(2.0, -2.0 - _LINE_PT * row) if guide.vertical else (-2.0, 2.0),
            ha="left" if guide.vertical else "right",
            va="top" if guide.vertical else "bottom",
            fontsize=7.5,
            color="0.25",
            annotation_clip=True,
            parse_math=False,
        )


def _shade(axes: Axes, backdrop: Backdrop) -> None:
    # The levels in use, from light to dark as on the screen, with their values beside.
    used = [level for level, shade in enumerate(backdrop.shades) if shade.words]
    places = np.zeros(len(backdrop.shades))
    places[used] = np.arange(len(used))
    colours = ListedColormap([_shade_colour(backdrop.shades[level]) for level in used])
    axes.grid(visible=False)
    mesh = axes.pcolormesh(
        backdrop.x,
        backdrop.y,
        places[backdrop.levels].T,
        shading="nearest",
        cmap=colours,
        norm=BoundaryNorm(np.arange(len(used) + 1) - 0.5, len(used)),
        rasterized=True,
        zorder=0.0,
    )
    figure = axes.get_figure(root=True)
    assert figure is not None  # noqa: S101
    bar = figure.colorbar(mesh, ax=axes, ticks=np.arange(len(used)), drawedges=True)
    bar.ax.set_yticklabels([backdrop.shades[level].words for level in used], parse_math=False)
    bar.ax.tick_params(length=0.0)
    bar.set_label(backdrop.label, parse_math=False)


def _shade_colour(shade: Shade) -> tuple[float, ...]:
    dark = _DARKNESS[shade.character]
    return tuple(1.0 - dark * (1.0 - part) for part in to_rgb(_SHADE_COLOURS[shade.style]))


def save_charts(charts: VisibleCharts, path: Path, *, force: bool = False) -> None:
    """Save the visible points of the displayed charts as CSV, NPZ or Parquet."""
    parts: list[tuple[float, float, np.ndarray[Any, np.dtype[np.float64]], Any]] = []
    panels = []
    for number, (chart, view) in enumerate(charts.panels, start=1):
        x, y = view.axes(chart)
        names = {}
        for index, trace in view.visible(chart):
            inside = _inside(trace.x, x) & _inside(trace.y, y)
            parts.append((number, index + 1.0, trace.x[inside], trace.y[inside]))
            names[str(index + 1)] = trace.name or chart.note
        panels.append({"x": chart.x_label, "y": chart.y_label, "traces": names})
    columns = {
        "panel": _joined([np.full(part[2].size, part[0]) for part in parts]),
        "trace": _joined([np.full(part[2].size, part[1]) for part in parts]),
        "x": _joined([part[2] for part in parts]),
        "y": _joined([part[3] for part in parts]),
    }
    described = [
        Column("panel", "1", "number of the chart, from the first"),
        Column("trace", "1", "number of the trace in its chart"),
        Column("x", "see panels", "along the x axis of the chart"),
        Column("y", "see panels", "along the y axis of the chart"),
    ]
    write_table(path, "chart's data", described, columns, {"panels": panels}, force=force)


def _joined(parts: Sequence[Any]) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.concatenate(parts) if parts else np.empty(0)


def _inside(values: np.ndarray[Any, np.dtype[np.float64]], axis: Axis) -> Any:
    with np.errstate(invalid="ignore"):
        return (values >= axis.low) & (values <= axis.high)
