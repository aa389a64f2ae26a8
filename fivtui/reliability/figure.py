"""Figures of uncertainty studies: histograms by region, Sobol indices, scatter matrix."""

import textwrap
from collections.abc import Collection
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from fivtui.charts import STYLE, WIDTH, math_symbol, math_unit, new_figure, parameter_line
from fivtui.sweeps import OUTPUTS, VARIABLES

from .result import Uncertainty
from .statistics import ranked

# Which samples are in a region, and its fill, hatching and marker.
_Region = tuple[NDArray[np.bool_], tuple[str, str, str]]
# Fill, hatching and marker of regions, from the safest on; of two, the first and the last.
_LOOKS: Final = (("#a8c8a0", "", "o"), ("#e0b080", "...", "s"), ("#8fa8e0", "///", "^"))
_BINS: Final = 40
# How far beyond 0 and 1 indices are drawn.
_BEYOND: Final = 0.2
# An index that far beyond them is evident in the figure.
_EVIDENT: Final = 0.005
_ACROSS: Final = 3
# Letters of a line of a panel's title.
_TITLE: Final = 30
_ROW_HEIGHT: Final = 1.75
_BAR_HEIGHT: Final = 0.19
_CELL: Final = 1.35
# Points of a panel of the scatter matrix, and inputs that it has at most.
_DOTS: Final = 400
_MOST_INPUTS: Final = 6
_SMALL: Final = 7.5


def uncertainty_figure(result: Uncertainty) -> Figure:
    """Draw histograms of outputs by region, Sobol indices with intervals, and inputs by region.

    Agg canvas, no window.
    """
    outputs = [name for name, found in result.quantiles.items() if found]
    inputs = list(result.inputs)[:_MOST_INPUTS]
    heights = [_ROW_HEIGHT * _rows(len(outputs))]
    if result.indices:
        heights.append((0.85 + _BAR_HEIGHT * len(result.inputs)) * _rows(len(result.indices)))
    heights.append(_CELL * max(len(inputs), 1.3))
    with mpl.rc_context(STYLE | {"hatch.linewidth": 0.3, "axes.titlesize": 8.0}):
        figure = new_figure(WIDTH, sum(heights) + 0.7)
        grid: Any = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)
        parts = list(grid.ravel())
        _draw_histograms(parts[0], result, outputs)
        if result.indices:
            _draw_tornado(parts[1], result)
        _draw_matrix(parts[-1], result, inputs)
        handles = [
            Patch(facecolor=fill, hatch=hatch, edgecolor="black", linewidth=0.5, label=name)
            for name, (_, (fill, hatch, _)) in _looks(result).items()
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
        figure.suptitle(
            parameter_line(result.study.parameters, tuple(result.inputs)), fontsize=_SMALL
        )
    return figure


def _looks(result: Uncertainty) -> dict[str, _Region]:
    regions = result.regions()
    looks = _LOOKS if len(regions) == len(_LOOKS) else (_LOOKS[0], _LOOKS[-1])
    return {name: (here, look) for (name, here), look in zip(regions.items(), looks, strict=True)}


def _rows(panels: int) -> int:
    return -(-panels // _ACROSS)


def _panels(part: SubFigure, count: int) -> list[Axes]:
    # Four panels are two and two.
    across = min(_ACROSS, -(-count // _rows(count)))
    grid = part.subplots(_rows(count), across, squeeze=False).ravel().tolist()
    for axes in grid[count:]:
        axes.set_axis_off()
    return grid[:count]


def _draw_histograms(part: SubFigure, result: Uncertainty, outputs: list[str]) -> None:
    regions = _looks(result)
    for axes, name in zip(_panels(part, len(outputs)), outputs, strict=True):
        values, column = result.samples(name), OUTPUTS[name]
        known = ~np.isnan(values)
        low, high = float(values[known].min()), float(values[known].max())
        if low == high:
            low, high = low - 0.5 * abs(low) - 1e-9, high + 0.5 * abs(high) + 1e-9
        bottom: NDArray[Any] = np.zeros(_BINS)
        for here, (fill, hatch, _) in regions.values():
            counts, edges = np.histogram(values[known & here], bins=_BINS, range=(low, high))
            share = counts / known.sum()
            axes.bar(
                edges[:-1],
                share,
                width=np.diff(edges),
                bottom=bottom,
                align="edge",
                color=fill,
                hatch=hatch,
                edgecolor="0.35",
                linewidth=0.2,
            )
            bottom = bottom + share
        unit = f" ({math_unit(column.unit)})" if column.unit else ""
        axes.set_xlabel(f"{column.meaning[0].upper()}{column.meaning[1:]}{unit}", fontsize=_SMALL)
        axes.tick_params(labelsize=_SMALL)
        axes.locator_params(axis="x", nbins=4)
    part.supylabel("Share of samples", fontsize=_SMALL)


def _draw_tornado(part: SubFigure, result: Uncertainty) -> None:
    panels = list(zip(_panels(part, len(result.indices)), result.indices, strict=True))
    for axes, output in panels:
        indices = result.indices[output]
        rows = list(reversed(ranked(indices)))
        places = np.arange(len(rows))
        for shift, kind, fill in ((0.2, "first", "#1f4fd8"), (-0.2, "total", "0.75")):
            found = [getattr(index, kind) for _, index in rows]
            axes.barh(
                places + shift,
                [each.value for each in found],
                0.36,
                xerr=np.transpose([(e.value - e.low, e.high - e.value) for e in found]),
                color=fill,
                edgecolor="black",
                linewidth=0.4,
                error_kw={"linewidth": 0.8, "capsize": 1.5},
                label="alone" if kind == "first" else "with others",
            )
        shares = [(result.local.get(output, {}).get(name), y) for y, (name, _) in enumerate(rows)]
        known = [(each.share, y) for each, y in shares if each is not None]
        if known:
            axes.plot(
                *zip(*known, strict=True),
                linestyle="none",
                marker="D",
                markersize=3.5,
                markerfacecolor="white",
                color="black",
                label="if linear",
            )
        axes.set_yticks(places, [math_symbol(VARIABLES[name].symbol) for name, _ in rows])
        low, high = axes.get_xlim()
        # Indices of next to no variance may be anything.
        axes.set_xlim(max(min(low, 0.0), -_BEYOND), min(max(high, 1.0), 1.0 + _BEYOND))
        title = textwrap.fill(f"Sobol indices of: {output_words(output)}", _TITLE)
        values = [each.value for _, index in rows for each in (index.first, index.total)]
        if not -_EVIDENT <= min(values) <= max(values) <= 1.0 + _EVIDENT:
            title += "\n(beyond 0 to 1: sampling error)"
        axes.set_title(title, fontsize=_SMALL)
        axes.tick_params(labelsize=_SMALL)
        axes.grid(visible=False, axis="y")
    if panels:
        axes = next((one for one, name in panels if name in result.local), panels[0][0])
        axes.legend(frameon=False, fontsize=6.5, loc="lower right")


def output_words(name: str) -> str:
    """An output, or what has a probability, in words."""
    return OUTPUTS[name].meaning if name in OUTPUTS else name.replace("_", " ")


def _draw_matrix(part: SubFigure, result: Uncertainty, inputs: list[str]) -> None:
    count = len(inputs)
    panels = part.subplots(count, count, squeeze=False, sharex="col")
    regions = _looks(result)
    columns = {name: result.samples(name) for name in inputs}
    count_of = columns[inputs[0]].size
    chosen = np.linspace(0, count_of - 1, min(_DOTS, count_of)).astype(int)
    for row, vertical in enumerate(inputs):
        for column, horizontal in enumerate(inputs):
            axes = panels[row, column]
            if column > row:
                axes.set_axis_off()
                continue
            _draw_cell(axes, columns[horizontal], columns[vertical], regions.values(), chosen)
            axes.tick_params(labelsize=6.5)
            if row == count - 1:
                axes.set_xlabel(_axis_words(horizontal), fontsize=_SMALL)
            if column == 0 and row > 0:
                axes.set_ylabel(_axis_words(vertical), fontsize=_SMALL)
            if row == column:
                axes.set_yticks([])


def _draw_cell(
    axes: Axes,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    regions: Collection[_Region],
    chosen: NDArray[np.int64],
) -> None:
    if x is y:
        shown = [x[here] for here, _ in regions]
        axes.hist(shown, bins=_BINS // 2, stacked=True, color=[look[0] for _, look in regions])
        return
    for here, (fill, _, marker) in regions:
        dots = chosen[here[chosen]]
        axes.scatter(
            x[dots], y[dots], s=5.0, marker=marker, color=fill, edgecolor="0.3", linewidth=0.2
        )


def _axis_words(name: str) -> str:
    spec = VARIABLES[name]
    unit = f" ({math_unit(spec.unit)})" if spec.unit else ""
    return f"{math_symbol(spec.symbol)}{unit}"
