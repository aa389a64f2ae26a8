"""Hopf points, where the equilibrium loses its stability and a limit cycle begins.

The sign of the first Lyapunov coefficient says whether the cycles next to it attract.
"""

import math
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.equilibrium import (
    critical_mu_on_belt,
    critical_speeds,
    flutter_margin,
    growth_rate,
)
from fivtui.model import (
    Equilibrium,
    Parameters,
    System,
    check_off_edge,
    equilibrium,
    friction_derivatives,
    is_on_edge,
    jacobian,
    tangent_slope,
    tangent_stiffness,
)

# Intervals of the search along a parameter. They are logarithmic in a range above a decade.
_INTERVALS: Final = 512
_DECADE: Final = 10.0
# Size below which numbers count as zero: a Lyapunov coefficient relative to its terms, and y in an
# eigenvector of length 1.
_ROUNDING: Final = 1e-9
# Indices of ẋ and y in a state; the friction force depends on these two.
_VX, _Y = 1, 2


@dataclass(frozen=True, slots=True)
class HopfPoint:
    """A Hopf point: the parameter's value, and the vibration mode that begins to grow there.

    `omega` is its angular frequency, 1/s. Its eigenvector is scaled to y = 1, or to x = 1 if y is
    zero. `lyapunov` is the first Lyapunov coefficient, 1/(m² s).
    """

    value: float
    omega: float
    eigenvector: NDArray[np.complex128]
    lyapunov: float

    @property
    def direction(self) -> str:
        """Whether the cycles next to it attract: ``"supercritical"`` if so, else ``"subcritical"``.

        ``"degenerate"`` if the first Lyapunov coefficient is zero.
        """
        if self.lyapunov == 0.0:
            return "degenerate"
        return "subcritical" if self.lyapunov > 0.0 else "supercritical"


def hopf_values(system: System, name: str, low: float, high: float) -> list[float]:
    """Values of a parameter in a range at which the equilibrium has a Hopf point, ascending.

    All Hopf points are found for μ and for the belt speed. For other parameters 513 values are
    compared: two Hopf points between neighbouring values are missed. Values at which eigenvalues
    decide nothing, such as F = 0 with separation, are left out.
    """
    p = system.parameters
    if name == "mu":
        critical_values = (critical.mu for critical in critical_mu_on_belt(system))
        return [value for value in critical_values if low <= value <= high]
    if name == "v_belt":
        speeds = (change.v_belt for change in critical_speeds(system))
        return [value for value in speeds if low <= value <= high]
    from scipy.optimize import brentq

    def margin(value: float) -> float:
        # A number that changes its sign at a Hopf point; NaN without a verdict.
        system_at_value = system.with_values({name: value})
        if is_on_edge(system_at_value.parameters, system.separation):
            return math.nan
        if p.v_belt is not None:
            return -growth_rate(system_at_value)
        distance = flutter_margin(system_at_value)
        return math.nan if distance is None else distance

    # A single value F = 0 of a varied F is left out; a fixed one leaves no value.
    if name != "F":
        check_off_edge(system)
    logarithmic = low > 0.0 and high > _DECADE * low
    grid = (np.geomspace if logarithmic else np.linspace)(low, high, _INTERVALS + 1)
    grid[0], grid[-1] = low, high
    values = grid.tolist()
    margins = [margin(value) for value in values]
    zeros = []
    intervals = zip(pairwise(values), pairwise(margins), strict=True)
    for (begin, end), (first, second) in intervals:
        if not math.isnan(first + second) and (first < 0.0) != (second < 0.0):
            zeros.append(float(brentq(margin, begin, end, xtol=1e-300, rtol=1e-15)))
    return zeros


def hopf_point(system: System, name: str) -> HopfPoint:
    """The Hopf point of a system whose parameters are at a Hopf point."""
    p, point = system.parameters, equilibrium(system)
    contact_mode = point.mode
    matrix = np.array(jacobian(p, point.y, contact_mode))
    values, vectors = np.linalg.eig(matrix)
    # The vibration mode that begins to grow has the greatest growth rate.
    index = int(np.where(values.imag > 0.0, values.real, -np.inf).argmax())
    eigenvector = vectors[:, index]
    x, _, y, _ = eigenvector
    vector = eigenvector / (y if abs(y) > _ROUNDING else x)
    omega = float(values[index].imag)
    return HopfPoint(getattr(p, name), omega, vector, _lyapunov(p, point, matrix, omega, vector))


class _MultilinearForms:
    # Second and third derivatives of a state's rate of change at an equilibrium.

    def __init__(self, p: Parameters, point: Equilibrium) -> None:
        # The friction coefficient and its derivatives by ẋ; it depends on v_belt − ẋ.
        self._mu = (p.mu, 0.0, 0.0, 0.0)
        if p.v_belt is not None:
            mu, slope, second, third = friction_derivatives(p, p.v_belt, 3)
            self._mu = (mu, -slope, second, -third)
        # The contact force and its three derivatives by y. `tangent_slope` is the derivative of the
        # tangent stiffness and proportional to y, so that its value at y = 1 is its derivative.
        self._force = (
            point.P,
            -tangent_stiffness(p, point.y),
            -tangent_slope(p, point.y),
            -tangent_slope(p, 1.0),
        )
        self._m = p.m

    def at(self, *vectors: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """The second derivative in two directions, or the third in three."""
        count = len(vectors)
        horizontal = 0j
        # Product rule for μ(ẋ) P(y): each direction differentiates μ or the force P.
        for indices in product((_VX, _Y), repeat=count):
            factor = complex(
                np.prod([vector[index] for vector, index in zip(vectors, indices, strict=True)])
            )
            speed_count = indices.count(_VX)
            horizontal += self._mu[speed_count] * self._force[count - speed_count] * factor
        vertical = self._force[count] * complex(np.prod([vector[_Y] for vector in vectors]))
        return np.array([0.0, horizontal, 0.0, vertical], dtype=np.complex128) / self._m


def _lyapunov(
    p: Parameters,
    point: Equilibrium,
    matrix: NDArray[np.float64],
    omega: float,
    q: NDArray[np.complex128],
) -> float:
    # First Lyapunov coefficient by projection on the critical eigenvector q and its adjoint, as in
    # Kuznetsov, Elements of Applied Bifurcation Theory, 5.4.
    values, vectors = np.linalg.eig(matrix.T)
    adjoint = vectors[:, int(np.abs(values + 1j * omega).argmin())]
    adjoint = adjoint / np.conj(np.vdot(adjoint, q))
    forms, conjugate = _MultilinearForms(p, point), np.conj(q).astype(np.complex128)
    mean = np.linalg.solve(matrix, forms.at(q, conjugate)).astype(np.complex128)
    second = np.linalg.solve(2j * omega * np.eye(4) - matrix, forms.at(q, q)).astype(np.complex128)
    terms = [
        np.vdot(adjoint, forms.at(q, q, conjugate)),
        -2.0 * np.vdot(adjoint, forms.at(q, mean)),
        np.vdot(adjoint, forms.at(conjugate, second)),
    ]
    total = float(np.sum(terms).real) / 2.0
    return total if abs(total) > _ROUNDING * float(np.abs(terms).sum()) else 0.0
