"""Figures of modes over the friction coefficient and of stability maps."""

from collections.abc import Sequence
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, Normalize, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from fivtui.model import ALL_PARAMETERS, PARAMETERS
from fivtui.plotting import (
    STYLE,
    WIDTH,
    math_symbol,
    math_unit,
    new_figure,
    parameter_line,
    quantity_label,
    value_label,
    value_limits,
)

from .eigenvalues import Stability
from .files import MAP_COLUMNS
from .map import LEAST_CONTRAST, StabilityMap
from .scan import ModeScan

Floats = NDArray[np.float64]

_HEIGHT: Final = 3.4
_MODES: Final[tuple[dict[str, Any], ...]] = (
    {"color": "#1f4fd8", "linestyle": "-", "linewidth": 1.4, "label": "mode 1"},
    {"color": "#b07d00", "linestyle": (0.0, (4.0, 1.5)), "linewidth": 1.4, "label": "mode 2"},
)
_CRITICAL: Final[dict[str, Any]] = {"color": "#c8252c", "linestyle": ":", "linewidth": 1.0}
_PRESENT: Final[dict[str, Any]] = {"color": "0.35", "linestyle": "-.", "linewidth": 0.8}
_ZERO: Final[dict[str, Any]] = {"color": "0.4", "linewidth": 0.5, "zorder": 1.0}


def mode_figure(found: Stability, scan: ModeScan) -> Figure:
    """Figure of frequency and growth rate over μ, and of the eigenvalues in the complex plane.

    μ and every critical μ are marked. The figure has an Agg canvas and no window.
    """
    with mpl.rc_context(STYLE):
        figure = new_figure(WIDTH, _HEIGHT, wspace=0.05)
        frequency, growth, plane = figure.subplots(1, 3)
        modes = scan.eigenvalues[:, :2]
        for axes, parts, label in (
            (frequency, modes.imag / (2.0 * np.pi), "Frequency Im $λ$/(2π) (Hz)"),
            (growth, modes.real, "Growth rate Re $λ$ (1/s)"),
        ):
            for part, look in zip(parts.T, _MODES, strict=True):
                axes.plot(scan.mu, part, **look)
            axes.set_xlim(scan.mu[0], scan.mu[-1])
            axes.set_xlabel(quantity_label(PARAMETERS["mu"]))
            axes.set_ylabel(label)
            _mark(axes, found)
        growth.axhline(0.0, **_ZERO)
        _draw_plane(plane, found, scan)
        handles, labels = frequency.get_legend_handles_labels()
        more, names = plane.get_legend_handles_labels()
        figure.legend(
            [*handles, *more],
            [*labels, *names],
            loc="outside lower center",
            ncols=3,
            frameon=False,
            handlelength=3.0,
        )
        figure.suptitle(parameter_line(found.parameters), fontsize=7.5)
    return figure


def _mark(axes: Axes, found: Stability) -> None:
    for place, critical in enumerate(found.critical_mu):
        label = f"{math_symbol('μ_c')} = {critical.mu:.4g}"
        several = len(found.critical_mu) > 1
        words = f"{label}, above it {critical.becomes}" if several else label
        axes.axvline(critical.mu, label=words, zorder=1.5 + 0.01 * place, **_CRITICAL)
    mu = found.parameters.mu
    axes.axvline(mu, label=f"$μ$ = {mu:.4g}", zorder=1.4, **_PRESENT)


def _draw_plane(axes: Axes, found: Stability, scan: ModeScan) -> None:
    along = scan.eigenvalues.ravel()
    name = f"eigenvalues, $μ$ = 0 to {scan.mu[-1]:g}"
    axes.plot(along.real, along.imag, ".", color="0.6", markersize=2.0, label=name)
    values = found.eigenvalues
    axes.plot(
        values.real,
        values.imag,
        "D",
        color="black",
        markersize=4.5,
        markerfacecolor="white",
        label=f"at $μ$ = {found.parameters.mu:.4g}",
    )
    axes.axvline(0.0, **_ZERO)
    axes.set_xlabel("Re $λ$ (1/s)")
    axes.set_ylabel("Im $λ$ (rad/s)")


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
    """Figure of a stability map in colours, with the stability boundary; no value is grey.

    The map must have two or more values along both axes. The figure has an Agg canvas and no
    window.
    """
    first, second = result.axes
    with mpl.rc_context({**STYLE, "axes.grid": False}):
        figure = new_figure(*_SIZE)
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
        lines = axes.contour(*over, grid, levels=int(count), **_CONTOURS)
        axes.clabel(lines, fontsize=6.5, fmt=label)


def is_logarithmic(values: NDArray[np.float64]) -> bool:
    """Whether three or more values are spaced logarithmically."""
    if values.size < 3 or values.min() <= 0.0:
        return False
    steps = np.diff(np.log(values))
    return bool(np.allclose(steps, steps[0], rtol=1e-6))
