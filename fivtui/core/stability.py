"""Stability of the equilibrium: eigenvalues of Eq. 8, critical friction coefficient (Eq. 9)."""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from .errors import ComputationError
from .model import Equilibrium, equilibrium, jacobian, tangent_stiffness
from .parameters import PARAMETERS, Parameters

Becomes = Literal["stable", "unstable"]

# Growth rates below this, relative to the fastest eigenvalue, are zero to rounding.
_ROUNDING: Final = 1e-12


@dataclass(frozen=True, slots=True)
class CriticalMu:
    """A critical friction coefficient μ_c and what the equilibrium becomes above it."""

    mu: float
    becomes: Becomes


@dataclass(frozen=True, slots=True)
class Stability:
    """Stability of the equilibrium of one parameter set.

    Attributes
    ----------
    equilibrium : Equilibrium
        The point at which the system is linearised.
    eigenvalues : ndarray of complex, shape (4,)
        λ in 1/s: growth rates and angular frequencies, by falling imaginary part.
    growth_rate : float
        Greatest real part, 1/s.
    stable : bool
        Whether the growth rate is negative beyond rounding.
    critical_mu : tuple of CriticalMu
        Every allowed μ > 0 at which the growth rate changes sign, ascending.
    linear_critical_mu : float or None
        μ_c of the linear system (k_nl = 0); None if it has none.
    """

    equilibrium: Equilibrium
    eigenvalues: NDArray[np.complex128]
    growth_rate: float
    stable: bool
    critical_mu: tuple[CriticalMu, ...]
    linear_critical_mu: float | None


def stability(p: Parameters, *, separation: bool = True) -> Stability:
    """Linearise at the equilibrium and judge it.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    separation : bool
        Whether separation is considered; matters for F < 0 alone.

    Returns
    -------
    Stability
        Eigenvalues, growth rate and critical friction coefficients.

    Raises
    ------
    ComputationError
        If there is no equilibrium, or a number overflows.
    """
    point = equilibrium(p, separation=separation)
    values = _eigenvalues(p, point)
    growth, stable = _judged(values)
    return Stability(
        equilibrium=point,
        eigenvalues=values,
        growth_rate=growth,
        stable=stable,
        critical_mu=_critical_mu(p, separation=separation),
        linear_critical_mu=_linear_critical_mu(p),
    )


def growth_rate(p: Parameters, *, separation: bool = True) -> float:
    """Greatest real part of the eigenvalues at the equilibrium.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    separation : bool
        Whether separation is considered.

    Returns
    -------
    float
        Growth rate, 1/s.
    """
    return float(_eigenvalues(p, equilibrium(p, separation=separation)).real.max())


def judge_growth(p: Parameters, *, separation: bool = True) -> tuple[float, bool]:
    """Growth rate and verdict, without the critical friction coefficients.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    separation : bool
        Whether separation is considered.

    Returns
    -------
    tuple of float and bool
        Growth rate, 1/s, and whether the equilibrium is stable, as in `Stability`.
    """
    return _judged(_eigenvalues(p, equilibrium(p, separation=separation)))


def _judged(values: NDArray[np.complex128]) -> tuple[float, bool]:
    growth = float(values.real.max())
    return growth, growth < -_ROUNDING * float(np.abs(values).max())


def _eigenvalues(p: Parameters, point: Equilibrium) -> NDArray[np.complex128]:
    matrix = np.array(jacobian(p, point.y, point.mode))
    if not np.all(np.isfinite(matrix)):
        raise ComputationError(
            f"the tangent contact stiffness overflows at the equilibrium y = {point.y:.3g} m",
            "use a smaller preload or a softer contact",
        )
    values = np.linalg.eigvals(matrix).astype(np.complex128)
    order = np.lexsort((-values.real, -values.imag))
    return values[order]


def _boundary(p: Parameters, kt: float) -> float:
    # μ_c h k_t by Routh–Hurwitz on the characteristic quartic, which has μ in its last coefficient
    # alone. w is the share of c1 in the damping; without damping the limit of equal shares.
    h = 0.5 * p.k3
    a = p.k1 + h
    damping = p.c1 + p.c2
    w = p.c1 / damping if damping > 0.0 else 0.5
    detuning = kt + h - a
    return w * (1.0 - w) * detuning**2 + h * h + (a + w * detuning) * p.c1 * p.c2 / p.m


def _linear_critical_mu(p: Parameters) -> float | None:
    return _boundary(p, p.k2) / (0.5 * p.k3 * p.k2) if p.k3 > 0.0 else None


def _critical_mu(p: Parameters, *, separation: bool) -> tuple[CriticalMu, ...]:
    # Along μ the left-hand side of μ h k_t = boundary grows faster than the right-hand side, for
    # every parameter set in bounds (k_t falls by less than 3/4 of its own rate): one crossing.
    if p.k3 == 0.0 or (separation and p.F < 0.0):
        return ()
    h = 0.5 * p.k3

    def excess(mu: float) -> float:
        y = equilibrium(p, separation=False, mu=mu).y
        kt = tangent_stiffness(p, y)
        return mu * h * kt - _boundary(p, kt)

    stable, unstable = 0.0, PARAMETERS["mu"].upper
    if excess(stable) >= 0.0 or excess(unstable) < 0.0:
        return ()
    while stable < (middle := 0.5 * (stable + unstable)) < unstable:
        stable, unstable = (middle, unstable) if excess(middle) < 0.0 else (stable, middle)
    return (CriticalMu(unstable, "unstable"),)
