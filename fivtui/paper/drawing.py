"""Drawing a figure of the paper from its numbers."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from fivtui.charts import (
    CASE_COLOURS,
    CASE_LINES,
    STYLE,
    WIDTH,
    math_symbol,
    new_figure,
    parameter_line,
    quantity_label,
    sheet_figure,
    value_label,
)
from fivtui.model import PARAMETERS
from fivtui.transient import transient_sheet

from .data import FigureData, FloatArray
from .families import SEPARATION, panels_of
from .results import PaperResults

# Colour and dashes of the lines in order, as in the paper but with a darker yellow.
_LINES: Final[Sequence[tuple[str, Any]]] = (
    ("black", "-"),
    ("#1f4fd8", (0.0, (6.0, 2.0))),
    ("#c8252c", (0.0, (6.0, 1.5, 1.0, 1.5))),
    ("#b07d00", (0.0, (1.2, 1.2))),
)
_HEIGHT: Final = 3.1
_SINGLE_WIDTH: Final = 4.6
_LINE_WIDTH: Final = 1.3
_POINT: Final[Mapping[str, Any]] = {
    "marker": "o",
    "markersize": 4.5,
    "markerfacecolor": "white",
    "linestyle": "none",
}
# Curves with a smaller relative distance coincide.
_MERGED: Final = 1e-6


def draw(number: int, results: PaperResults) -> Figure:
    """Draw a figure of the paper, 2 to 16, under its fixed parameters; no window."""
    first, *others = panels_of(number)
    with mpl.rc_context(STYLE):
        if first.kind == "transient":
            figure = sheet_figure(transient_sheet(results.runs(first), [first.shown]))
        else:
            tables = [results.table(panel.key) for panel in (first, *others)]
            figure = _DRAWINGS[first.kind](tables)
        varied = [name for name in PARAMETERS if name not in first.fixed]
        figure.suptitle(parameter_line(first.lines[0].scene.parameters, varied), fontsize=7.5)
    return figure


def _new_figure(panels: int) -> tuple[Figure, list[Axes]]:
    width = WIDTH if panels > 1 else _SINGLE_WIDTH
    figure = new_figure(width, _HEIGHT, wspace=0.05)
    axes = figure.subplots(1, panels, squeeze=False)[0].tolist()
    if panels > 1:
        for letter, each in zip("ab", axes, strict=True):
            each.set_title(f"({letter})", loc="left")
    return figure, axes


def _line_label(name: str, value: float) -> str:
    if name == SEPARATION:
        return "separation considered" if value else "separation ignored"
    label = value_label(name, value)
    return f"linear, {label}" if name == "k_nl" and value == 0.0 else label


def _line_style(name: str, value: float, place: int) -> dict[str, Any]:
    if name == SEPARATION:
        colour, dashes = CASE_COLOURS[bool(value)][0], CASE_LINES[bool(value)]
    else:
        colour, dashes = _LINES[place]
    return {"color": colour, "linestyle": dashes, "linewidth": _LINE_WIDTH}


def _plot(axes: Axes, data: FigureData, names: Sequence[str], label: str) -> None:
    # One column of every line, or two that may merge, with one entry in the legend.
    for place, (value, line) in enumerate(data.lines()):
        style = _line_style(data.by, value, place)
        first, *others = names
        axes.plot(line[data.along], line[first], label=_line_label(data.by, value), **style)
        for name in others:
            apart = _where_apart(line[name], line[first])
            axes.plot(line[data.along], np.where(apart, line[name], np.nan), **style)
    axes.set_xlabel(quantity_label(PARAMETERS[data.along]))
    axes.set_ylabel(label)
    axes.set_xlim(data[data.along].min(), data[data.along].max())


def _where_apart(values: FloatArray, drawn: FloatArray) -> NDArray[np.bool_]:
    # Dashes drawn twice would look solid. The ends of a common part belong to both curves.
    apart = np.abs(values - drawn) > _MERGED * np.abs(drawn)
    return np.convolve(apart, np.ones(3), mode="same") > 0.0


def _legend(figure: Figure, axes: Axes, columns: int, *more: Line2D) -> None:
    handles, _ = axes.get_legend_handles_labels()
    figure.legend(
        handles=[*handles, *more],
        loc="outside lower center",
        ncols=columns,
        frameon=False,
        handlelength=3.0,
    )


def _equilibria(tables: Sequence[FigureData]) -> Figure:
    figure, panels = _new_figure(len(tables))
    for axes, data in zip(panels, tables, strict=True):
        _plot(axes, data, ["y_e"], f"Vertical displacement {math_symbol('y_e')} (m)")
        axes.legend(frameon=False, handlelength=3.0)
    figure.align_xlabels()
    return figure


def _eigenvalues(tables: Sequence[FigureData]) -> Figure:
    (data,) = tables
    figure, (left, right) = _new_figure(2)
    _plot(left, data, ["omega_1", "omega_2"], "Frequency Im $λ$ (rad/s)")
    _plot(right, data, ["sigma_1", "sigma_2"], "Growth rate Re $λ$ (1/s)")
    right.axhline(0.0, color="0.4", linewidth=0.5, zorder=1.0)
    for place, (_, line) in enumerate(data.lines()):
        right.plot(line["mu_c"][:1], [0.0], color=_LINES[place][0], zorder=3.0, **_POINT)
    critical = Line2D([], [], color="black", label=math_symbol("μ_c"), **_POINT)
    _legend(figure, left, 5, critical)
    return figure


def _critical(tables: Sequence[FigureData]) -> Figure:
    (data,) = tables
    figure, (axes,) = _new_figure(1)
    label = f"Critical friction coefficient {math_symbol('μ_c')}"
    _plot(axes, data, ["mu_c"], label)
    axes.set_ylim(bottom=0.0)
    _legend(figure, axes, 2)
    return figure


def _amplitudes(tables: Sequence[FigureData]) -> Figure:
    (data,) = tables
    figure, panels = _new_figure(2)
    shown = {
        "y_peak": "Peak $|y|$ (m)",
        "y_half_range": "Half peak-to-peak of $y$,\nsecond half of the run (m)",
    }
    for axes, (name, label) in zip(panels, shown.items(), strict=True):
        _plot(axes, data, [name], label)
        axes.set_ylim(bottom=0.0)
    _legend(figure, panels[0], 2)
    return figure


_DRAWINGS: Final[Mapping[str, Callable[[Sequence[FigureData]], Figure]]] = {
    "equilibrium": _equilibria,
    "eigenvalues": _eigenvalues,
    "critical mu": _critical,
    "amplitude": _amplitudes,
}
