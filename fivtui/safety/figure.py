"""Matplotlib figures of maps of safe friction."""

from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from fivtui.equilibrium import LEAST_CONTRAST, draw_contours, is_logarithmic
from fivtui.model import PARAMETERS
from fivtui.plotting import STYLE, new_figure, parameter_line, quantity_label, value_limits

from .map import NOT_KNOWN, REGIONS, SafetyMap, basis_words

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


def safety_map_figure(result: SafetyMap) -> Figure:
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
            axis.set_label_text(quantity_label(PARAMETERS[name]))
            if is_logarithmic(values):
                (axes.set_xscale if axis is axes.xaxis else axes.set_yscale)("log")
        unused = ("mu",) if result.escape is None else ()
        line = parameter_line(result.parameters, (*result.names, *unused))
        axes.set_title(f"{line}\ncycles by {basis_words(result)}", fontsize=7.5)
        if handles:
            figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False)
    return figure


def _safe_mu(figure: Figure, axes: Axes, result: SafetyMap) -> list[Any]:
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


def _without_value(axes: Axes, result: SafetyMap) -> list[Any]:
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


def _three(axes: Axes, result: SafetyMap) -> list[Any]:
    axes.pcolormesh(
        *result.axes,
        result.regions.T,
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
