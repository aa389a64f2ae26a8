"""Charts as displayed, as a matplotlib figure or as columns. Imports no Textual."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, TwoSlopeNorm
from matplotlib.figure import Figure

from fivtui.io import write_table
from fivtui.model import Column
from fivtui.plotting import OFF_BELT, STUCK, STYLE, WIDTH, new_figure, shade_times
from fivtui.tui.chart import Axis, Backdrop, Chart, Guide, Trace, View, VisibleCharts, reduced
from fivtui.tui.session import COLOURS

# Markers per line, and columns that a long line is reduced to (several per pixel).
_MARKS: Final = 12
_COLUMNS: Final = 4000
_ROW: Final = 2.0
_LEAST_HEIGHT: Final = 3.4
_SQUARE: Final = 3.6
_MARKERS: Final[Mapping[str, str]] = {
    "●": "o", "○": "o", "■": "s", "□": "s", "▲": "^", "△": "^", "▼": "v", "▽": "v",
    "◆": "D", "◇": "D", "★": "*", "☆": "*", "×": "x", "+": "+",
}  # fmt: skip
_HOLLOW: Final = "○□△▽◇☆"
# Dash patterns tell lines apart without colour.
_LINES: Final = ("-", (0.0, (5.0, 1.5)), (0.0, (1.0, 1.2)), (0.0, (5.0, 1.2, 1.0, 1.2)))
_NO_VALUE: Final = "0.85"
# Shades of strips, from the first.
_STRIPS: Final = (OFF_BELT, STUCK)


def charts_figure(charts: VisibleCharts, names: Mapping[str, str] | None = None) -> Figure:
    """A matplotlib figure of the displayed charts; `names` replaces legend entries."""
    count = len(charts.panels)
    rows, columns = (1, count) if charts.across else (count, 1)
    height = _SQUARE if charts.across else max(_ROW * rows, _LEAST_HEIGHT)
    with mpl.rc_context(STYLE):
        figure = new_figure(WIDTH, height)
        grid = figure.subplots(rows, columns, squeeze=False)
        panels = [axes for row in grid for axes in row]
        for axes, (chart, view) in zip(panels, charts.panels, strict=True):
            _draw(axes, chart, view, names or {})
        figure.align_ylabels()
        _add_legends(figure, panels)
    return figure


def _draw(axes: Axes, chart: Chart, view: View, names: Mapping[str, str]) -> None:
    x, y = view.axes(chart)
    if chart.backdrop is not None:
        _shade(axes, chart.backdrop)
    for guide in chart.guides:
        _guide(axes, guide)
    for number, strip in enumerate(chart.strips):
        shade_times(axes, strip.intervals, _STRIPS[number % len(_STRIPS)], strip.meaning)
    several = len(chart.traces) > 1
    for index, trace in view.visible(chart):
        look = _look(trace, index, several=several)
        across, up = reduced(trace, x, _COLUMNS)
        if several and trace.look == "line" and look["marker"]:
            every = max(across.size // _MARKS, 1)
            look["markevery"] = (every * index // len(chart.traces), every)
        axes.plot(across, up, label=names.get(trace.name, trace.name) or "_", **look)
    for scale, limits, axis in (
        (axes.set_xscale, axes.set_xlim, x),
        (axes.set_yscale, axes.set_ylim, y),
    ):
        if axis.log:
            scale("log")
        limits(axis.low, axis.high)
    if chart.x_axis:
        axes.set_xlabel(chart.x_label, parse_math=False)
    else:
        axes.tick_params(labelbottom=False)
    axes.set_ylabel(chart.y_label, parse_math=False)
    if chart.note and chart.backdrop is None:
        axes.set_title(chart.note, parse_math=False)


def _look(trace: Trace, index: int, *, several: bool) -> dict[str, Any]:
    mark = trace.mark if several or trace.look != "line" else ""
    look: dict[str, Any] = {
        "color": trace.colour or ("black" if trace.look == "points" else _colour(index)),
        "linestyle": "none" if trace.look in ("points", "dots") else "-",
        "linewidth": 1.0,
        "marker": "." if trace.look == "dots" else _MARKERS.get(mark, ""),
        "markersize": 2.0 if trace.look == "dots" else 4.5,
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


def _guide(axes: Axes, guide: Guide) -> None:
    line = axes.axvline if guide.vertical else axes.axhline
    line(guide.value, color="0.4", linewidth=0.6, zorder=1.0, label="_")
    if guide.label:
        where = (guide.value, 1.0) if guide.vertical else (1.0, guide.value)
        axes.annotate(
            guide.label,
            where,
            xycoords=axes.get_xaxis_transform() if guide.vertical else axes.get_yaxis_transform(),
            textcoords="offset points",
            xytext=(2.0, -2.0) if guide.vertical else (-2.0, 2.0),
            ha="left" if guide.vertical else "right",
            va="top" if guide.vertical else "bottom",
            fontsize=7.5,
            color="0.25",
            annotation_clip=True,
            parse_math=False,
        )


def _shade(axes: Axes, backdrop: Backdrop) -> None:
    # Green and red in a terminal are the two signs.
    values = np.ma.masked_invalid(backdrop.values.T)
    signed = any(style == "unstable" for _, style in backdrop.shades)
    norm: Any = None
    colours: Any = "viridis"
    if signed:
        whole = bool(np.all(values.compressed() == np.round(values.compressed())))
        if whole and values.compressed().min(initial=0.0) >= 0.0:
            colours, norm = (
                ListedColormap(["white", "#f2b48a"]),
                mpl.colors.BoundaryNorm([-0.5, 0.5, 1.5], 2),
            )
        else:
            largest = max(float(np.abs(values.compressed()).max(initial=0.0)), 1e-300)
            colours, norm = "RdBu_r", TwoSlopeNorm(0.0, -largest, largest)
    axes.set_facecolor(_NO_VALUE)
    axes.grid(visible=False)
    mesh = axes.pcolormesh(
        backdrop.x,
        backdrop.y,
        values,
        shading="nearest",
        cmap=colours,
        norm=norm,
        rasterized=True,
        zorder=0.0,
    )
    figure = axes.get_figure(root=True)
    assert figure is not None  # noqa: S101
    figure.colorbar(mesh, ax=axes).set_label(backdrop.label, parse_math=False)


def _add_legends(figure: Figure, panels: Sequence[Axes]) -> None:
    # One legend for all panels, each name once.
    known: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            known.setdefault(label, handle)
    if known:
        longest = max(map(len, known))
        legend = figure.legend(
            list(known.values()),
            list(known),
            loc="outside lower center",
            ncols=max(1, min(4, 100 // (longest + 8))),
            frameon=False,
        )
        for text in legend.get_texts():
            text.set_parse_math(False)


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
