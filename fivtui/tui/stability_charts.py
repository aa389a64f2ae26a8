"""The charts of the equilibrium: its modes over μ, its eigenvalues in the plane.

Imports no Textual.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.core.errors import Cancelled
from fivtui.core.model import equilibrium, jacobian
from fivtui.core.parameters import PARAMETERS, Parameters
from fivtui.core.stability import Stability

from .chart import Chart, Guide, Trace

FloatArray = NDArray[np.float64]

_POINTS: Final = 241
# Points between two looks at whether somebody still waits.
_BLOCK: Final = 24
_LEAST_TOP: Final = 1.0
_BEYOND: Final = 1.5
# Frequencies closer than this, relative to the fastest, have merged.
_MERGED: Final = 1e-6
_MODES: Final = ("mode 1", "mode 2")


@dataclass(frozen=True, slots=True, eq=False)
class ModeScan:
    """The eigenvalues at the equilibrium over μ, all else equal.

    Attributes
    ----------
    mu : ndarray, shape (n,)
        Friction coefficients, ascending from 0.
    eigenvalues : ndarray of complex, shape (n, 4)
        λ in 1/s, by falling imaginary part, of equal ones the faster growing one first.
    """

    mu: FloatArray
    eigenvalues: NDArray[np.complex128]


def scan_top(p: Parameters, found: Stability) -> float:
    """How far to look along μ.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    found : Stability
        Its stability.

    Returns
    -------
    float
        Beyond μ and every critical one; a round number, so that it stays while values change.
    """
    wanted = _BEYOND * max(_LEAST_TOP / _BEYOND, p.mu, *(c.mu for c in found.critical_mu), 0.0)
    decade = 10.0 ** np.floor(np.log10(wanted))
    top = next(f * decade for f in (1.0, 1.5, 2.0, 3.0, 5.0, 10.0) if f * decade >= wanted)
    return float(min(top, PARAMETERS["mu"].upper))


def mode_scan(
    p: Parameters,
    top: float,
    *,
    separation: bool = True,
    go_on: Callable[[], bool] = lambda: True,
) -> ModeScan:
    """Compute the eigenvalues over μ.

    Parameters
    ----------
    p : Parameters
        The parameter set; its μ does not matter.
    top : float
        Greatest friction coefficient.
    separation : bool
        Whether separation is considered.
    go_on : callable
        Asked now and then whether the scan is still wanted.

    Returns
    -------
    ModeScan
        At evenly spaced friction coefficients.

    Raises
    ------
    ComputationError
        If there is no equilibrium.
    Cancelled
        If it is no longer wanted.
    """
    mu = np.linspace(0.0, top, _POINTS)
    matrices = np.empty((_POINTS, 4, 4))
    for place, value in enumerate(mu.tolist()):
        if place % _BLOCK == 0 and not go_on():
            raise Cancelled
        there = p.with_values({"mu": value})
        point = equilibrium(there, separation=separation)
        matrices[place] = jacobian(there, point.y, point.mode)
    values = np.linalg.eigvals(matrices).astype(np.complex128)
    # Merged frequencies are equal but for rounding.
    size = _MERGED * np.abs(values).max()
    order = np.lexsort((-values.real, -np.rint(values.imag / size)), axis=-1)
    return ModeScan(mu, np.take_along_axis(values, order, axis=-1))


def _guides(p: Parameters, found: Stability) -> tuple[Guide, ...]:
    critical = tuple(Guide(c.mu, f"μ_c {c.mu:.4g}") for c in found.critical_mu)
    return (*critical, Guide(p.mu, f"μ {p.mu:.4g}"))


def _over_mu(scan: ModeScan, label: str, parts: FloatArray, guides: tuple[Guide, ...]) -> Chart:
    traces = tuple(Trace(name, scan.mu, parts[:, place]) for place, name in enumerate(_MODES))
    return Chart("μ", label, traces, guides=guides)


def growth_chart(scan: ModeScan, p: Parameters, found: Stability) -> Chart:
    """Growth rates of the modes over μ.

    Parameters
    ----------
    scan : ModeScan
        The eigenvalues over μ.
    p : Parameters
        The parameter set of now.
    found : Stability
        Its stability.

    Returns
    -------
    Chart
        With μ, every μ_c, and the line between decay and growth.
    """
    guides = (Guide(0.0, vertical=False), *_guides(p, found))
    return _over_mu(scan, "Re λ / 1/s", scan.eigenvalues[:, :2].real, guides)


def frequency_chart(scan: ModeScan, p: Parameters, found: Stability) -> Chart:
    """Frequencies of the modes over μ, Hz; see `growth_chart`."""
    parts = scan.eigenvalues[:, :2].imag / (2.0 * np.pi)
    return _over_mu(scan, "Im λ/2π / Hz", parts, _guides(p, found))


def plane_chart(found: Stability, scan: ModeScan | None) -> Chart:
    """The eigenvalues in the complex plane.

    Parameters
    ----------
    found : Stability
        Those of now.
    scan : ModeScan, optional
        Those over μ: where they come from and go to.

    Returns
    -------
    Chart
        What lies to the right of Re λ = 0 grows.
    """
    values = found.eigenvalues
    now = Trace("now", values.real, values.imag, look="points", ordered=False, mark="◆")
    paths: tuple[Trace, ...] = ()
    if scan is not None:
        along = scan.eigenvalues.ravel()
        paths = (
            Trace(f"μ 0 to {scan.mu[-1]:g}", along.real, along.imag, look="dots", ordered=False),
        )
    guides = (Guide(0.0, "grows →"), Guide(0.0, vertical=False))
    return Chart("Re λ / 1/s", "Im λ / rad/s", (*paths, now), guides=guides, tight=False)
