"""Matplotlib figures of maps."""

from collections.abc import Sequence
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, Normalize, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from fivtui.charts import (
    STYLE,
    math_unit,
    new_figure,
    parameter_line,
    quantity_label,
    value_label,
    value_limits,
)
from fivtui.model import ALL_PARAMETERS

from .result import NOT_KNOWN, REGIONS, StabilityMap

# Least difference that is drawn, as a share of the greatest value: that of three-digit numbers.
LEAST_CONTRAST: Final = 1e-3
Floats = NDArray[np.float64]
_SIZE: Final = (5.2, 4.2)
_NO_VALUE: Final = "0.85"
_NOT_KNOWN: Final = "0.65"
_COLOURS: Final = ("#e8f1ea", "#f7d9a0", "#d98880")
_CONTOURS: Final[dict[str, Any]] = {"colors": "0.25", "linewidths": 0.6, "linestyles": "dashed"}
# Parts of the critical μ at which lines are drawn.
_SHARES: Final = (
    (0.99, (0.0, ()), "1 % below the critical $\\mu$"),
    (0.5, (0.0, (1.0, 1.5)), "half the critical $\\mu$"),
)
# Displacements at which contours are drawn, in a decade.
_STEPS: Final = (1.0, 2.0, 5.0)


def safety_map_figure(result: StabilityMap) -> Figure:
    """Figure of a map: the safe μ in colours, or three regions with the offset that escapes.

    The map must have two or more values along both axes. The figure has an Agg canvas and no
    window.
    """
    with mpl.rc_context({**STYLE, "axes.grid": False}):
        figure = new_figure(*_SIZE)
        axes = figure.subplots()
        axes.set_facecolor(_NO_VALUE)
        handles = _safe_mu(figure, axes, result) if result.escape is None else _three(axes, result)
        handles += _without_value(axes, result)
        for axis, name, values in zip(
            (axes.xaxis, axes.yaxis), result.names, result.axes, strict=True
        ):
            axis.set_label_text(quantity_label(ALL_PARAMETERS[name]))
            if is_logarithmic(values):
                (axes.set_xscale if axis is axes.xaxis else axes.set_yscale)("log")
        unused = ("mu",) if result.escape is None else ()
        line = parameter_line(result.parameters, (*result.names, *unused))
        axes.set_title(f"{line}\ncycles by {result.basis}", fontsize=7.5)
        if handles:
            figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False)
    return figure


def _safe_mu(figure: Figure, axes: Axes, result: StabilityMap) -> list[Any]:
    colours = axes.pcolormesh(
        *result.axes,
        result.safe_mu.T,
        shading="nearest",
        cmap="viridis",
        norm=Normalize(*value_limits(result.safe_mu, LEAST_CONTRAST)),
        rasterized=True,
    )
    figure.colorbar(colours, ax=axes).set_label("Safe friction coefficient")
    draw_contours(axes, result.axes, result.safe_mu, "%.3g")
    share = np.ma.masked_invalid((result.safe_mu / result.critical_mu).T)
    handles: list[Any] = []
    for level, dashes, label in _SHARES:
        if share.compressed().size and share.min() < level < share.max():
            axes.contour(
                *result.axes,
                share,
                levels=[level],
                colors="black",
                linewidths=1.2,
                linestyles=[dashes],
            )
            handles.append(Line2D([], [], color="black", linestyle=dashes, label=label))
    return handles


def _without_value(axes: Axes, result: StabilityMap) -> list[Any]:
    # Two greys: points without a value, and points whose value is not known.
    missing = np.isnan(result.values)
    unknown = missing & result.unknown
    handles: list[Any] = []
    if unknown.any():
        axes.pcolormesh(
            *result.axes,
            np.where(unknown, 0.0, np.nan).T,
            shading="nearest",
            cmap=ListedColormap([_NOT_KNOWN]),
            rasterized=True,
        )
        handles.append(Patch(facecolor=_NOT_KNOWN, edgecolor="0.5", label=NOT_KNOWN))
    if (missing & ~unknown).any():
        handles.append(Patch(facecolor=_NO_VALUE, edgecolor="0.5", label=result.missing))
    return handles


def _three(axes: Axes, result: StabilityMap) -> list[Any]:
    axes.pcolormesh(
        *result.axes,
        result.values.T,
        shading="nearest",
        cmap=ListedColormap(_COLOURS),
        norm=BoundaryNorm([-0.5, 0.5, 1.5, 2.5], 3),
        rasterized=True,
    )
    handles: list[Any] = [
        Patch(facecolor=colour, edgecolor="0.5", label=region)
        for colour, region in zip(_COLOURS, REGIONS, strict=True)
    ]
    if result.escape is not None:
        offsets = np.ma.masked_invalid(result.escape.T)
        known = offsets.compressed()
        levels = _levels(float(known.min()), float(known.max())) if known.size else []
        if levels:
            lines = axes.contour(*result.axes, offsets, levels=levels, **_CONTOURS)
            axes.clabel(lines, fontsize=6.5, fmt="%g m")
            handles.append(
                Line2D(
                    [], [], color="0.25", linestyle="dashed", label="offset from rest that escapes"
                )
            )
    return handles


def _levels(low: float, high: float) -> list[float]:
    decades = range(int(np.floor(np.log10(low))), int(np.floor(np.log10(high))) + 1)
    every = (step * 10.0**decade for decade in decades for step in _STEPS)
    return [level for level in every if low < level < high]


_SIZE_OF_STABILITY: Final = (4.8, 3.9)
_COLOURS_OF_STABILITY: Final[dict[str, Any]] = {
    "growth-rate": "RdBu_r",
    "critical-mu": "viridis",
    "unstable-modes": ListedColormap(["white", "#f2b48a"]),
}
_BOUNDARY: Final[dict[str, Any]] = {"colors": "black", "linewidths": 1.4}
_LINES: Final[dict[str, Any]] = {
    "colors": "0.25",
    "linewidths": 0.5,
    "linestyles": "dashed",
    "negative_linestyles": "dashed",
}
_LEVELS: Final = 7


def map_figure(result: StabilityMap) -> Figure:
    """Figure of a stability map in colours, with the stability boundary; no value is grey.

    The map must have two or more values along both axes. The figure has an Agg canvas and no
    window.
    """
    first, second = result.axes
    with mpl.rc_context({**STYLE, "axes.grid": False}):
        figure = new_figure(*_SIZE_OF_STABILITY)
        axes = figure.subplots()
        axes.set_facecolor(_NO_VALUE)
        colours = axes.pcolormesh(
            first,
            second,
            result.values.T,
            shading="nearest",
            cmap=_COLOURS_OF_STABILITY[result.value],
            norm=_norm(result),
            rasterized=True,
        )
        bar = figure.colorbar(colours, ax=axes)
        column = result.column
        unit = f" ({math_unit(column.unit)})" if column.unit else ""
        bar.set_label(column.meaning.capitalize() + unit)
        if result.value == "unstable-modes":
            bar.set_ticks([0.0, 1.0])
        _draw_levels(axes, result)
        handles = _draw_boundary(axes, result)
        for axis, name, values in zip(
            (axes.xaxis, axes.yaxis), result.names, result.axes, strict=True
        ):
            axis.set_label_text(quantity_label(ALL_PARAMETERS[name]))
            if is_logarithmic(values):
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
        # Zero is the middle of the colour map, between stable and unstable.
        finite = result.values[np.isfinite(result.values)]
        largest = max(float(np.abs(finite).max(initial=0.0)), np.finfo(float).tiny)
        return TwoSlopeNorm(0.0, -largest, largest)
    return Normalize(*value_limits(result.values, LEAST_CONTRAST))


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
    if result.value != "unstable-modes":
        draw_contours(axes, result.axes, result.values, "%g")


def draw_contours(axes: Axes, over: Sequence[Floats], values: Floats, label: str) -> None:
    """Draw labelled contour lines of mapped values, no closer than `LEAST_CONTRAST` allows."""
    finite = values[np.isfinite(values)]
    least = LEAST_CONTRAST * float(np.abs(finite).max(initial=0.0))
    count = min(float(np.ptp(finite)) / least, _LEVELS) if least > 0.0 else 0.0
    if count >= 1.0:
        grid = np.ma.masked_invalid(values.T)
        lines = axes.contour(*over, grid, levels=int(count), **_LINES)
        axes.clabel(lines, fontsize=6.5, fmt=label)


def is_logarithmic(values: Floats) -> bool:
    """Whether three or more values are spaced logarithmically."""
    if values.size < 3 or values.min() <= 0.0:
        return False
    steps = np.diff(np.log(values))
    return bool(np.allclose(steps, steps[0], rtol=1e-6))
