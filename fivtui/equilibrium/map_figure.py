"""Stability maps as publishable figures."""

from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import BoundaryNorm, ListedColormap, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from fivtui.model.parameters import PARAMETERS
from fivtui.transient.figure import STYLE, math_unit, parameter_line, quantity_label, value_label

from .map import StabilityMap
from .map_files import MAP_COLUMNS

_SIZE: Final = (4.8, 3.9)
_COLOURS: Final[dict[str, Any]] = {
    "growth-rate": "RdBu_r",
    "critical-mu": "viridis",
    "unstable-modes": ListedColormap(["white", "#f2b48a"]),
}
_NO_VALUE: Final = "0.85"
_BOUNDARY: Final[dict[str, Any]] = {"colors": "black", "linewidths": 1.4}
_CONTOURS: Final[dict[str, Any]] = {
    "colors": "0.25",
    "linewidths": 0.5,
    "linestyles": "dashed",
    "negative_linestyles": "dashed",
}
_LEVELS: Final = 7


def map_figure(result: StabilityMap) -> Figure:
    """A stability map as colours over its two parameters, with the stability boundary.

    Parameters
    ----------
    result : StabilityMap
        The map, with two or more values along both parameters.

    Returns
    -------
    Figure
        With an Agg canvas; it belongs to no window. Points without a value are grey.
    """
    first, second = result.axes
    with mpl.rc_context({**STYLE, "axes.grid": False}):
        figure = Figure(figsize=_SIZE, layout=ConstrainedLayoutEngine())
        FigureCanvasAgg(figure)
        axes = figure.subplots()
        axes.set_facecolor(_NO_VALUE)
        colours = axes.pcolormesh(
            first,
            second,
            result.values.T,
            shading="nearest",
            cmap=_COLOURS[result.value],
            norm=_norm(result),
            rasterized=True,
        )
        bar = figure.colorbar(colours, ax=axes)
        column = MAP_COLUMNS[result.value]
        unit = f" ({math_unit(column.unit)})" if column.unit else ""
        bar.set_label(column.meaning.capitalize() + unit)
        if result.value == "unstable-modes":
            bar.set_ticks([0.0, 1.0])
        _draw_levels(axes, result)
        handles = _draw_boundary(axes, result)
        for axis, name, values in zip(
            (axes.xaxis, axes.yaxis), result.names, result.axes, strict=True
        ):
            axis.set_label_text(quantity_label(PARAMETERS[name]))
            if _is_logarithmic(values):
                (axes.set_xscale if axis is axes.xaxis else axes.set_yscale)("log")
        unused = ("mu",) if result.value == "critical-mu" else ()
        title = parameter_line(result.parameters, (*result.names, *unused))
        axes.set_title(title, fontsize=7.5)
        if handles:
            figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False)
    return figure


def _norm(result: StabilityMap) -> Any:
    if result.value == "unstable-modes":
        return BoundaryNorm([-0.5, 0.5, 1.5], 2)
    if result.value == "growth-rate":
        # Zero is the middle of the colours, so that their sides are stable and unstable.
        finite = result.values[np.isfinite(result.values)]
        largest = max(float(np.abs(finite).max(initial=0.0)), np.finfo(float).tiny)
        return TwoSlopeNorm(0.0, -largest, largest)
    return None


def _draw_boundary(axes: Axes, result: StabilityMap) -> list[Line2D]:
    excess = np.ma.masked_invalid(result.excess.T)
    if not (np.any(excess < 0.0) and np.any(excess > 0.0)):
        return []
    first, second = result.axes
    axes.contour(first, second, excess, levels=[0.0], **_BOUNDARY)
    label = "stability boundary"
    if result.value == "critical-mu" and "mu" not in result.names:
        label += f", {value_label('mu', result.parameters.mu)}"
    return [Line2D([], [], color="black", linewidth=1.4, label=label)]


def _draw_levels(axes: Axes, result: StabilityMap) -> None:
    # Contour lines, so that the map can be read without colours.
    values = np.ma.masked_invalid(result.values.T)
    if result.value == "unstable-modes" or not values.compressed().size:
        return
    lines = axes.contour(*result.axes, values, levels=_LEVELS, **_CONTOURS)
    axes.clabel(lines, fontsize=6.5, fmt="%g")


def _is_logarithmic(values: NDArray[np.float64]) -> bool:
    if values.size < 3 or values.min() <= 0.0:
        return False
    steps = np.diff(np.log(values))
    return bool(np.allclose(steps, steps[0], rtol=1e-6))
