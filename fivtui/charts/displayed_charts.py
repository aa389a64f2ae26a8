"""The displayed charts as a matplotlib figure, or their points as a table. Imports no Textual.

A figure shows what the terminal shows: the visible traces, the chosen limits, and the cursors with
their values. Characters that mark points become markers of matplotlib.
"""

import itertools
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from textwrap import fill
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fivtui.io import write_table
from fivtui.model import Column

from .axis import Axis, AxisTicks
from .chart import (
    FIGURE_WIDTH,
    Chart,
    FloatArray,
    Guide,
    Heading,
    Sheet,
    Trace,
    View,
    VisibleCharts,
    guide_style,
    trace_style,
)
from .colours import PlotColours, figure_colour, grey, mix, screen_colours
from .figure_style import STYLE, drawing_settings, shade_times
from .labels import parameter_text
from .readout import crosshair, cursor_points, cursor_texts, readout_spans
from .sheet import draw_chart, sheet_figure

# Heights, inches: of a row, of a figure at least, and of a row of charts side by side.
_ROW_HEIGHT: Final = 2.0
_MIN_HEIGHT: Final = 3.4
_SIDE_BY_SIDE_HEIGHT: Final = 3.6
# Matplotlib's markers of the characters that mark points.
_MARKERS: Final[Mapping[str, str]] = {
    "●": "o", "○": "o", "■": "s", "□": "s", "▲": "^", "△": "^", "▼": "v", "▽": "v",
    "◆": "D", "◇": "D", "★": "*", "☆": "*", "×": "x", "+": "+", "▫": "s", "▬": "_",
}  # fmt: skip
_HOLLOW_MARKS: Final = "○□△▽◇☆▫"
# Marks the point of the parameters that are edited in the laboratory, the terminal program.
_EDITED_MARK: Final = "◆"
# Line style of the first cursor and the second, and lightness inside their markers.
_CURSOR_STYLES: Final = (("-", 0.1), (":", 1.0))
# Number of points above which the markers of a trace are small, and sizes of markers, pt.
_MANY_POINTS: Final = 300
_DOT_SIZE: Final = 2.0
_SMALL_SIZE: Final = 2.5
_MARKER_SIZE: Final = 4.5
_LETTER_SIZE: Final = 7.0
# Dash patterns distinguish lines in black and white.
_DASHES: Final = ("-", (0.0, (5.0, 1.5)), (0.0, (1.0, 1.2)), (0.0, (5.0, 1.2, 1.0, 1.2)))
# Height of a figure outside its panels, inches.
_HEIGHT_AROUND_PANELS: Final = 1.2
# Letters of an axis label per inch, and letters in a line of a title as wide as the figure.
_LETTERS_PER_INCH: Final = 14.0
_TITLE_LETTERS: Final = 84
# Strengths of the colours of grid and strips on the screen; the rest is the background.
_GRID_STRENGTH: Final = 0.15
_STRIP_STRENGTH: Final = 0.2
# Line spacing of the labels of guides, pt.
_LABEL_SPACING: Final = 9.5
# Width of a letter of a guide's label relative to a figure's width.
_LETTER_WIDTH: Final = 0.0095


def charts_figure(charts: VisibleCharts, heading: Heading | None = None) -> Figure:
    """A matplotlib figure of the displayed charts."""
    count = len(charts.panels)
    rows, columns = (1, count) if charts.side_by_side else (count, 1)
    height = _SIDE_BY_SIDE_HEIGHT if charts.side_by_side else max(_ROW_HEIGHT * rows, _MIN_HEIGHT)
    label_letters = int(_LETTERS_PER_INCH * (height - _HEIGHT_AROUND_PANELS) / rows)
    figure_charts = []
    for index, (chart, view) in enumerate(charts.panels):
        readout = _cursor_text(chart, view, first=index == 0)
        # Omit a note that repeats the label of the shades.
        note = chart.note if chart.backdrop is None or chart.note != chart.backdrop.label else ""
        title = "\n".join(fill(text, _TITLE_LETTERS // columns) for text in (note, readout) if text)
        label = fill(chart.y_label, label_letters)
        figure_charts.append(replace(_displayed_chart(chart, view), title=title, y_label=label))
    sheet = Sheet(
        [[chart] for chart in figure_charts] if charts.side_by_side else [figure_charts],
        (FIGURE_WIDTH, height),
    )
    # A single curve needs no name.
    single_names = [chart.traces[0].name for chart, _ in charts.panels if len(chart.traces) == 1]
    figure = sheet_figure(sheet, omitted=single_names)
    with drawing_settings(STYLE):
        for axes, (chart, view) in zip(figure.axes, charts.panels, strict=False):
            _draw_guides(axes, chart, view.axes(chart), columns)
            _draw_cursors(axes, chart, view)
        if heading is not None:
            figure.suptitle(_heading_text(heading), fontsize=mpl.rcParams["font.size"])
    return figure


def plot_pixels(
    chart: Chart,
    view: View,
    size: tuple[int, int],
    *,
    dpi: float,
    colours: PlotColours,
    ticks: AxisTicks,
) -> NDArray[np.uint8]:
    """Draw the plot of a displayed chart without margins: RGB pixels, shape (height, width, 3).

    `size` is width and height in pixels.
    """
    settings = STYLE | {
        "axes.facecolor": colours.background,
        "text.color": colours.foreground,
        "grid.color": mix(colours.foreground, colours.background, _GRID_STRENGTH),
    }
    with drawing_settings(settings), screen_colours(colours):
        figure = Figure((size[0] / dpi, size[1] / dpi), dpi)
        canvas: Any = FigureCanvasAgg(figure)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        displayed = _displayed_chart(chart, view)
        backdrop = displayed.backdrop
        if backdrop is not None:
            # As the characters, without contours.
            backdrop = replace(backdrop, contours=())
        draw_chart(axes, replace(displayed, backdrop=backdrop, strips=()))
        strip_colour = figure_colour("reference", _STRIP_STRENGTH)
        for strip in chart.strips:
            shade_times(axes, strip.intervals, strip_colour)
        # The screen displays the limits over the same lengths, and labels the ticks.
        axes.set_aspect("auto")
        axes.set_xticks(ticks[0], [])
        axes.set_yticks(ticks[1], [])
        axes.tick_params(which="both", length=0.0)
        axes.spines[:].set_visible(False)
        _draw_guides(axes, chart, view.axes(chart), 1)
        _draw_cursors(axes, chart, view)
        canvas.draw()
        pixels: NDArray[np.uint8] = np.array(canvas.buffer_rgba())[..., :3]
    return pixels


def _heading_text(heading: Heading) -> str:
    first, *rest = heading.parameters
    varied = [
        name
        for name, value in first.as_dict().items()
        if any(getattr(p, name) != value for p in rest)
    ]
    text = parameter_text(first, [*heading.omitted, *varied])
    if heading.ignores_separation:
        text = f"{text}, separation ignored"
    return f"{heading.text}\n{text}" if heading.text else text


def _displayed_chart(chart: Chart, view: View) -> Chart:
    """A chart with the traces, limits and shades that the terminal displays."""
    x, y = view.axes(chart)
    backdrop = chart.backdrop
    if backdrop is not None:
        backdrop = replace(backdrop, label=str(backdrop.label))
    return replace(
        chart,
        x_label=str(chart.x_label),
        traces=tuple(_styled_trace(chart, index) for index, _ in view.visible_traces(chart)),
        guides=(),
        backdrop=backdrop,
        colour_scale=None,
        y_names=(),
        x_margins=True,
        log="x" * x.log + "y" * y.log,
        linear_within=0.0,
        legend="below",
        figure_x=(x.low, x.high),
        figure_y=(y.low, y.high),
    )


def _styled_trace(chart: Chart, index: int) -> Trace:
    """A trace with the colour, dashes and marker that distinguish it in its chart."""
    trace = chart.traces[index]
    if chart.stacked:
        return replace(trace, name=str(trace.name))
    style = _trace_style(trace, index, several=len(chart.traces) > 1)
    if trace.number:
        # Draw runs of a smaller range on top: those of a greater range would hide them.
        ranges = sorted({_y_range(run) for run in chart.traces if run.number}, reverse=True)
        style["zorder"] += ranges.index(_y_range(trace)) / len(ranges)
    if chart.to_scale:
        # A displayed chart to scale is the picture of the slider on the belt: its traces are
        # outlines, with a marker at the last point.
        style |= {"linestyle": "-", "markevery": [trace.x.size - 1]}
    # Figures draw `Trace.marker` at a few points of a line, a marker in the style at all points.
    marker = style.pop("marker") if trace.look == "line" and not chart.to_scale else ""
    look = "line" if trace.look == "area" else trace.look
    return Trace(str(trace.name), trace.x, trace.y, look, trace.ordered, marker=marker, style=style)


def _y_range(trace: Trace) -> float:
    finite = trace.y[np.isfinite(trace.y)]
    return float(np.ptp(finite)) if finite.size else 0.0


def _trace_style(trace: Trace, index: int, *, several: bool) -> dict[str, Any]:
    """Matplotlib's line properties of a trace; `several` traces in a chart have marks on lines."""
    mark = trace.mark if several or trace.look != "line" else ""
    is_letter, is_points = mark.isalnum(), trace.look == "points"
    style: dict[str, Any] = {
        "color": figure_colour(trace_style(trace, index)),
        "linestyle": "none" if trace.look in ("points", "dots") else "-",
        "linewidth": 1.0,
        "marker": f"$\\mathrm{{{mark}}}$" if is_letter else _MARKERS.get(mark, ""),
        "markersize": _MARKER_SIZE,
        "zorder": 3.0 if is_points else 2.0,
    }
    # Letters and the edited point have the colour of text: they lie on all colours.
    if not trace.colour and (is_letter or (is_points and mark == _EDITED_MARK)):
        style["color"] = grey(0.0)
    if trace.look == "dots":
        style |= {"marker": ".", "markersize": _DOT_SIZE}
    elif is_letter:
        style["markersize"] = _LETTER_SIZE
    elif is_points and trace.x.size > _MANY_POINTS:
        style["markersize"] = _SMALL_SIZE
    if trace.look in ("points", "marked") and not style["marker"]:
        style["marker"] = "o"
    if mark and mark in _HOLLOW_MARKS:
        style["markerfacecolor"] = grey(1.0)
    if trace.look == "line" and not trace.mark:
        style["linestyle"] = _DASHES[index % len(_DASHES)]
    return style


def _draw_guides(axes: Axes, chart: Chart, limits: tuple[Axis, Axis], columns: int) -> None:
    # Labels that would overlap are on different rows. Positions are fractions of the axis; the
    # figure has `columns` charts side by side.
    x, y = limits
    end_by_row: dict[int, float] = {}
    for guide in chart.guides:
        position = float((x if guide.vertical else y).positions([guide.value])[0])
        if not 0.0 <= position <= 1.0:
            continue
        row = 0
        if guide.vertical and guide.label:
            row = next(row for row in itertools.count() if position > end_by_row.get(row, -1.0))
            label_width = (len(guide.label) + 1) * _LETTER_WIDTH * columns
            end_by_row[row] = position + label_width
        _draw_guide(axes, guide, row)


def _draw_guide(axes: Axes, guide: Guide, row: int) -> None:
    # Draw a guide with its label in a row from the top, at the right end of a horizontal guide.
    line = axes.axvline if guide.vertical else axes.axhline
    colour = figure_colour(guide_style(guide))
    line(guide.value, color=colour, linewidth=0.6, zorder=1.0, label="_")
    if guide.label:
        anchor = (guide.value, 1.0) if guide.vertical else (1.0, guide.value)
        axes.annotate(
            guide.label,
            anchor,
            xycoords=axes.get_xaxis_transform() if guide.vertical else axes.get_yaxis_transform(),
            textcoords="offset points",
            xytext=(2.0, -2.0 - _LABEL_SPACING * row) if guide.vertical else (-2.0, 2.0),
            ha="left" if guide.vertical else "right",
            va="top" if guide.vertical else "bottom",
            fontsize=7.5,
            color=grey(0.25),
            annotation_clip=True,
            parse_math=False,
        )


def _cursor_text(chart: Chart, view: View, *, first: bool) -> str:
    """Values at the cursors; for the first chart, also the distance between the cursors."""
    texts = [text.strip() for text, _ in readout_spans(chart, view)]
    if not texts:
        return ""
    label, start, end = chart.cursor_label, view.cursors.first, view.cursors.second
    if first and label and start is not None and end is not None:
        texts = [*cursor_texts(label, start[0], end[0]), *texts]
    return ", ".join(filter(None, texts))


def _draw_cursors(axes: Axes, chart: Chart, view: View) -> None:
    """Draw the cursors and the points at them."""
    positions = (view.cursors.first, view.cursors.second)
    for position, points, (line_style, lightness) in zip(
        positions, cursor_points(chart, view), _CURSOR_STYLES, strict=True
    ):
        if position is None:
            continue
        line: dict[str, Any] = {
            "color": grey(0.1),
            "linewidth": 0.8,
            "linestyle": line_style,
            "label": "_",
        }
        cursor_x, cursor_y = crosshair(chart, position, points)
        if not chart.curve_label:
            axes.axvline(cursor_x, **line)
        if chart.is_plane and not chart.curve_label:
            axes.axhline(cursor_y, **line)
        axes.plot(
            [point.x for point in points],
            [point.y for point in points],
            "D",
            color=grey(0.1),
            markerfacecolor=grey(lightness),
            markersize=5,
            zorder=4,
            label="_",
        )


def save_charts(charts: VisibleCharts, path: Path) -> None:
    """Save the visible points of the displayed charts as CSV, NPZ or Parquet."""
    # Columns of the table, in parts for each trace.
    parts: dict[str, list[NDArray[Any]]] = {"panel": [], "trace": [], "x": [], "y": []}
    panels = []
    for panel_number, (chart, view) in enumerate(charts.panels, start=1):
        x_axis, y_axis = view.axes(chart)
        names = {}
        for trace_number, trace in enumerate(chart.traces, start=1):
            if trace_number - 1 in view.hidden:
                continue
            inside = _is_inside(trace.x, x_axis) & _is_inside(trace.y, y_axis)
            x, y = trace.x[inside], trace.y[inside]
            parts["panel"].append(np.full(x.size, panel_number))
            parts["trace"].append(np.full(x.size, float(trace_number)))
            parts["x"].append(x)
            parts["y"].append(y)
            names[str(trace_number)] = trace.name or chart.note
        panels.append({"x": chart.x_label, "y": chart.y_label, "traces": names})
    columns = {
        name: np.concatenate(arrays) if arrays else np.empty(0) for name, arrays in parts.items()
    }
    specs = [
        Column("panel", "1", "number of the chart, from the first"),
        Column("trace", "1", "number of the trace in its chart"),
        Column("x", "see panels", "along the x axis of the chart"),
        Column("y", "see panels", "along the y axis of the chart"),
    ]
    write_table(path, "chart's data", specs, columns, {"panels": panels})


def _is_inside(values: FloatArray, axis: Axis) -> Any:
    with np.errstate(invalid="ignore"):
        return (values >= axis.low) & (values <= axis.high)
