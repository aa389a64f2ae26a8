"""Hopf points: where the equilibrium loses its stability, and the limit cycles that begin there."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.equilibrium import critical_mu, flutter_margin
from fivtui.model import Mode, Parameters, check_always_sliding, equilibrium, jacobian

# Intervals in which a Hopf point is looked for along a parameter other than μ.
_INTERVALS: Final = 512
_DECADE: Final = 10.0
# Lyapunov coefficients below this part of their terms are rounding.
_ROUNDING: Final = 1e-9


@dataclass(frozen=True, slots=True)
class HopfPoint:
    """A Hopf point and the limit cycles next to it.

    Attributes
    ----------
    value : float
        The parameter there.
    omega : float
        Angular frequency, rad/s.
    vector : ndarray of complex, shape (4,)
        The eigenvector, with |y| = 1: cycles are the equilibrium and a small multiple of its real
        part, as it turns.
    lyapunov : float
        First Lyapunov coefficient: real part of the cubic coefficient of the normal form,
        1/(m² s); 0 if it is within rounding.
    """

    value: float
    omega: float
    vector: NDArray[np.complex128]
    lyapunov: float

    @property
    def direction(self) -> str:
        """Whether the cycles next to it attract: ``"supercritical"`` if so, else ``"subcritical"``.

        ``"degenerate"`` if the first Lyapunov coefficient is zero.
        """
        if self.lyapunov == 0.0:
            return "degenerate"
        return "subcritical" if self.lyapunov > 0.0 else "supercritical"


def hopf_values(
    p: Parameters, name: str, low: float, high: float, *, separation: bool = True
) -> list[float]:
    """Values of a parameter in a range at which the equilibrium has a Hopf point, ascending.

    In closed form for μ; for other parameters every change of stability between 512 intervals.
    """
    if name == "mu":
        found = (one.mu for one in critical_mu(p, separation=separation))
        return [value for value in found if low <= value <= high]
    from scipy.optimize import brentq

    def margin(value: float) -> float:
        found = flutter_margin(p.with_values({name: value}), separation=separation)
        return math.nan if found is None else found

    wide = low > 0.0 and high > _DECADE * low
    grid = (np.geomspace if wide else np.linspace)(low, high, _INTERVALS + 1)
    grid[0], grid[-1] = low, high
    values = grid.tolist()
    margins = [margin(value) for value in values]
    found_values = []
    for place in range(_INTERVALS):
        one, other = margins[place], margins[place + 1]
        if not math.isnan(one + other) and (one < 0.0) != (other < 0.0):
            begin, end = values[place : place + 2]
            found_values.append(float(brentq(margin, begin, end, xtol=1e-300, rtol=1e-15)))
    return found_values


def hopf_point(p: Parameters, name: str, *, separation: bool = True) -> HopfPoint:
    """The Hopf point at which a parameter set is."""
    check_always_sliding(p, "branches")
    point = equilibrium(p, separation=separation)
    matrix = np.array(jacobian(p, point.y, Mode.CONTACT))
    values, vectors = np.linalg.eig(matrix)
    place = int(np.where(values.imag > 0.0, values.real, -np.inf).argmax())
    vector = vectors[:, place] / vectors[2, place]
    omega = float(values[place].imag)
    return HopfPoint(getattr(p, name), omega, vector, _lyapunov(p, point.y, matrix, omega, vector))


def _lyapunov(
    p: Parameters,
    y: float,
    matrix: NDArray[np.float64],
    omega: float,
    q: NDArray[np.complex128],
) -> float:
    # By projection on the critical eigenvectors (Kuznetsov, Elements of Applied Bifurcation Theory,
    # 5.4). Second and third derivatives of the motion are those of the contact force alone.
    values, vectors = np.linalg.eig(matrix.T)
    adjoint = vectors[:, int(np.abs(values + 1j * omega).argmin())]
    adjoint = adjoint / np.conj(np.vdot(adjoint, q))
    push = np.array([0.0, p.mu, 0.0, 1.0]) / p.m
    second, third = -6.0 * p.k_nl * y * push, -6.0 * p.k_nl * push
    steady = np.linalg.solve(matrix, second)[2]
    double = np.linalg.solve(2j * omega * np.eye(4) - matrix, second)[2]
    # With |q_y| = 1 every product of its components of y has the size 1.
    terms = [
        np.vdot(adjoint, third),
        -2.0 * np.vdot(adjoint, second) * steady,
        np.vdot(adjoint, second) * double,
    ]
    total = float(np.sum(terms).real) / 2.0
    return total if abs(total) > _ROUNDING * float(np.abs(terms).sum()) else 0.0
