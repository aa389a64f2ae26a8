"""Frequencies, growth rates and eigenvalues at the equilibrium as a publishable figure."""

from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from fivtui.model.parameters import PARAMETERS, Parameters
from fivtui.transient.figure import STYLE, WIDTH, math_symbol, parameter_line, quantity_label

from .eigenvalues import Stability
from .scan import ModeScan

_HEIGHT: Final = 3.4
_MODES: Final[tuple[dict[str, Any], ...]] = (
    {"color": "#1f4fd8", "linestyle": "-", "linewidth": 1.4, "label": "mode 1"},
    {"color": "#b07d00", "linestyle": (0.0, (4.0, 1.5)), "linewidth": 1.4, "label": "mode 2"},
)
_CRITICAL: Final[dict[str, Any]] = {"color": "#c8252c", "linestyle": ":", "linewidth": 1.0}
_PRESENT: Final[dict[str, Any]] = {"color": "0.35", "linestyle": "-.", "linewidth": 0.8}
_ZERO: Final[dict[str, Any]] = {"color": "0.4", "linewidth": 0.5, "zorder": 1.0}


def mode_figure(p: Parameters, found: Stability, scan: ModeScan) -> Figure:
    """Frequency and growth rate of the modes over μ, and the eigenvalues in the complex plane.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    found : Stability
        Its stability.
    scan : ModeScan
        Its eigenvalues over μ.

    Returns
    -------
    Figure
        With an Agg canvas; it belongs to no window. μ and every critical one are marked.
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, _HEIGHT), layout=ConstrainedLayoutEngine(wspace=0.05))
        FigureCanvasAgg(figure)
        frequency, growth, plane = figure.subplots(1, 3)
        modes = scan.eigenvalues[:, :2]
        for axes, parts, label in (
            (frequency, modes.imag / (2.0 * np.pi), "Frequency Im $λ$/2π (Hz)"),
            (growth, modes.real, "Growth rate Re $λ$ (1/s)"),
        ):
            for part, look in zip(parts.T, _MODES, strict=True):
                axes.plot(scan.mu, part, **look)
            axes.set_xlim(scan.mu[0], scan.mu[-1])
            axes.set_xlabel(quantity_label(PARAMETERS["mu"]))
            axes.set_ylabel(label)
            _mark(axes, p, found)
        growth.axhline(0.0, **_ZERO)
        _draw_plane(plane, p, found, scan)
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
        figure.suptitle(parameter_line(p), fontsize=7.5)
    return figure


def _mark(axes: Axes, p: Parameters, found: Stability) -> None:
    for place, critical in enumerate(found.critical_mu):
        label = f"{math_symbol('μ_c')} = {critical.mu:.4g}"
        several = len(found.critical_mu) > 1
        words = f"{label}, above it {critical.becomes}" if several else label
        axes.axvline(critical.mu, label=words, zorder=1.5 + 0.01 * place, **_CRITICAL)
    axes.axvline(p.mu, label=f"$μ$ = {p.mu:.4g}", zorder=1.4, **_PRESENT)


def _draw_plane(axes: Axes, p: Parameters, found: Stability, scan: ModeScan) -> None:
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
        label=f"at $μ$ = {p.mu:.4g}",
    )
    axes.axvline(0.0, **_ZERO)
    axes.set_xlabel("Re $λ$ (1/s)")
    axes.set_ylabel("Im $λ$ (rad/s)")
