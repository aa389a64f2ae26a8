"""Charts as displayed, as a matplotlib figure or as columns. Imports no Textual."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from textwrap import fill
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
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
    Sheet,
    Trace,
    View,
    VisibleCharts,
)
from .labels import parameter_line
from .plotting import STYLE
from .reading import NearestPoint, crosshair, cursor_words, heading, nearest
from .shades import Colours, Shade
from .sheet import sheet_figure

# Heights of a row and of a figure, inches.
_ROW: Final = 2.0
_MIN_HEIGHT: Final = 3.4
_SQUARE: Final = 3.6
_MARKERS: Final[Mapping[str, str]] = {
    "●": "o", "○": "o", "■": "s", "□": "s", "▲": "^", "△": "^", "▼": "v", "▽": "v",
    "◆": "D", "◇": "D", "★": "*", "☆": "*", "×": "x", "+": "+", "▫": "s", "▬": "_",
}  # fmt: skip
_HOLLOW: Final = "○□△▽◇☆▫"
_PRESENT: Final = "◆"
# The first cursor and the second.
_CURSORS: Final[Sequence[Mapping[str, str]]] = (
    {"linestyle": "-", "markerfacecolor": "0.1"},
    {"linestyle": ":", "markerfacecolor": "white"},
)
# Number of points above which their marks are small.
_MANY: Final = 300
# Dash patterns distinguish lines without colour.
_LINES: Final = ("-", (0.0, (5.0, 1.5)), (0.0, (1.0, 1.2)), (0.0, (5.0, 1.2, 1.0, 1.2)))
# Colours of the styles of shades, and darkness of the characters.
_SHADE_COLOURS: Final[Mapping[str, str]] = {
    "stable": "#009E73", "unstable": "#D55E00", "trace-1": "#0072B2", "trace-2": "#E69F00",
    "hidden": "#808080",
}  # fmt: skip
_DARKNESS: Final[Mapping[str, float]] = {
    " ": 0.0, "·": 0.15, ":": 0.3, "?": 0.35, "×": 0.6, "░": 0.35, "▒": 0.55, "▓": 0.75, "█": 1.0,
}  # fmt: skip
# Height of a figure around its panels, inches; letters of a label per inch; letters of a title;
# height of a line of labels, pt.
_AROUND_IN: Final = 1.2
_LETTERS_IN: Final = 14.0
_TITLE: Final = 84
_LINE_PT: Final = 9.5
# Width of a character of a guide's label, as a share of a panel of full width.
_LETTER: Final = 0.0095


def charts_figure(charts: VisibleCharts, heading: Heading | None = None) -> Figure:
    """A matplotlib figure of the displayed charts."""
    count = len(charts.panels)
    rows, columns = (1, count) if charts.across else (count, 1)
    height = _SQUARE if charts.across else max(_ROW * rows, _MIN_HEIGHT)
    letters = int(_LETTERS_IN * (height - _AROUND_IN) / rows)
    shown = []
    for index, (chart, view) in enumerate(charts.panels):
        read = _cursor_text(chart, view, first=index == 0)
        # Omit a note that repeats the label of the shades.
        note = chart.note if chart.backdrop is None or chart.note != chart.backdrop.label else ""
        title = "\n".join(fill(text, _TITLE // columns) for text in (note, read) if text)
        label = fill(chart.y_label, letters)
        shown.append(replace(_displayed(chart, view), title=title, y_label=label))
    sheet = Sheet([[chart] for chart in shown] if charts.across else [shown], (WIDTH, height))
    # A single curve needs no name.
    alone = [chart.traces[0].name for chart, _ in charts.panels if len(chart.traces) == 1]
    figure = sheet_figure(sheet, without=alone)
    with mpl.rc_context(STYLE):
        for axes, (chart, view) in zip(figure.axes, charts.panels, strict=False):
            _guides(axes, chart, view.axes(chart), columns)
            _cursors(axes, chart, view)
        if heading is not None:
            figure.suptitle(_heading_text(heading), fontsize=mpl.rcParams["font.size"])
    return figure


def _heading_text(heading: Heading) -> str:
    first, *further = heading.parameters
    varied = [
        n for n in first.as_dict() if any(getattr(p, n) != getattr(first, n) for p in further)
    ]
    line = parameter_line(first, [*heading.without, *varied])
    return f"{line}, separation ignored" if heading.ignored else line


def _displayed(chart: Chart, view: View) -> Chart:
    """A chart as displayed in the terminal: visible traces within limits, levels as shades."""
    x, y = view.axes(chart)
    backdrop, colours = (None, None) if chart.backdrop is None else _banded(chart.backdrop)
    return replace(
        chart,
        x_label=str(chart.x_label),
        traces=tuple(_styled_trace(chart, index) for index, _ in view.visible(chart)),
        guides=(),
        backdrop=backdrop,
        colours=colours,
        y_names=(),
        stacked=False,
        tight=False,
        log="x" * x.log + "y" * y.log,
        linear_within=0.0,
        legend="below",
        figure_x=(x.low, x.high),
        figure_y=(y.low, y.high),
    )


def _styled_trace(chart: Chart, index: int) -> Trace:
    """A trace of a chart in the style that distinguishes it."""
    trace, several = chart.traces[index], len(chart.traces) > 1
    style = _style(trace, index, several=several)
    if trace.number:
        # Draw runs of a smaller range on top: those of a greater range would hide them.
        ranges = sorted(
            {_range(item) for item in chart.traces if item.number},
            reverse=True,
        )
        style["zorder"] += ranges.index(_range(trace)) / len(ranges)
    if chart.to_scale:
        style |= {"linestyle": "-", "markevery": [trace.x.size - 1]}
    marker = style.pop("marker") if trace.look == "line" and not chart.to_scale else ""
    look = "line" if trace.look == "area" else trace.look
    return Trace(str(trace.name), trace.x, trace.y, look, trace.ordered, marker=marker, style=style)


def _range(trace: Trace) -> float:
    finite = trace.y[np.isfinite(trace.y)]
    return float(np.ptp(finite)) if finite.size else 0.0


def _style(trace: Trace, index: int, *, several: bool) -> dict[str, Any]:
    mark = trace.mark if several or trace.look != "line" else ""
    # Black for letters and the present point, which lie on lines and shades of all colours.
    points = trace.look == "points"
    letter, small = mark.isalnum(), points and trace.x.size > _MANY
    marker = f"$\\mathrm{{{mark}}}$" if letter else _MARKERS.get(mark, "")
    look: dict[str, Any] = {
        "color": trace.colour
        or ("black" if letter or (points and mark == _PRESENT) else _colour(index)),
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
    # Labels of neighbours are on different rows.
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


def _banded(backdrop: Backdrop) -> tuple[Backdrop, Colours]:
    """The used levels as values, and their colours, from light to dark as on the screen."""
    used = [level for level, shade in enumerate(backdrop.shades) if shade.text]
    shades = [backdrop.shades[level] for level in used]
    numbers = np.zeros(len(backdrop.shades))
    numbers[used] = np.arange(len(used))
    plain = [shade._replace(fill="", hatch="") for shade in backdrop.shades]
    colours = Colours(
        str(backdrop.label),
        tuple(map(_shade_colour, shades)),
        -0.5,
        len(used) - 0.5,
        tuple(range(len(used))),
        tuple(shade.text for shade in shades),
    )
    values = numbers[backdrop.levels]
    return replace(backdrop, values=values, shades=plain, contours=()), colours


def _shade_colour(shade: Shade) -> str:
    dark = _DARKNESS[shade.character]
    red, green, blue = (1.0 - dark * (1.0 - c) for c in to_rgb(_SHADE_COLOURS[shade.style]))
    return to_hex((red, green, blue))


def _cursor_points(chart: Chart, view: View) -> list[list[NearestPoint]]:
    return [
        nearest(chart, view, position) for position in (view.cursors.first, view.cursors.second)
    ]


def _cursor_text(chart: Chart, view: View, *, first: bool) -> str:
    """Read-outs of the cursors; for the first chart, also their distance."""
    points = _cursor_points(chart, view)
    if not any(points):
        return ""
    spans, count = heading(chart, view, *points)
    texts = [text.strip() for text, _ in spans[:count]]
    label, (a, b) = (
        chart.cursor_label,
        (view.cursors.first, view.cursors.second),
    )
    if first and label and a is not None and b is not None:
        texts = [*cursor_words(label, a[0], b[0]), *texts]
    return ", ".join(filter(None, texts))


def _cursors(axes: Axes, chart: Chart, view: View) -> None:
    """Draw the cursors and the points at them."""
    positions = (view.cursors.first, view.cursors.second)
    for position, points, look in zip(
        positions, _cursor_points(chart, view), _CURSORS, strict=True
    ):
        if position is None:
            continue
        line: dict[str, Any] = {
            "color": "0.1",
            "linewidth": 0.8,
            "linestyle": look["linestyle"],
            "label": "_",
        }
        across, up = crosshair(chart, position, points)
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


def save_charts(charts: VisibleCharts, path: Path) -> None:
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
    write_table(path, "chart's data", described, columns, {"panels": panels})


def _joined(parts: Sequence[Any]) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.concatenate(parts) if parts else np.empty(0)


def _inside(values: np.ndarray[Any, np.dtype[np.float64]], axis: Axis) -> Any:
    with np.errstate(invalid="ignore"):
        return (values >= axis.low) & (values <= axis.high)
