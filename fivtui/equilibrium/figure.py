"""Figures of modes over the friction coefficient."""

from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fivtui.charts import (
    STYLE,
    WIDTH,
    math_symbol,
    new_figure,
    parameter_line,
    quantity_label,
)
from fivtui.model import PARAMETERS

from .eigenvalues import Stability
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
