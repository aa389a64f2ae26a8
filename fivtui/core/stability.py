"""Stability of the equilibrium: eigenvalues of Eq. 8, critical friction coefficient (Eq. 9)."""

import math
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from .errors import ComputationError
from .model import Equilibrium, equilibrium, jacobian, tangent_stiffness
from .parameters import Parameters
from .polynomial import roots

Becomes = Literal["stable", "unstable"]

# Growth rates below this, relative to the fastest eigenvalue, are zero to rounding.
_ROUNDING: Final = 1e-12
_SIDE_STEP: Final = 1e-5


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
        Every μ > 0 at which the growth rate changes sign, ascending.
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
    growth = float(values.real.max())
    return Stability(
        equilibrium=point,
        eigenvalues=values,
        growth_rate=growth,
        stable=growth < -_ROUNDING * float(np.abs(values).max()),
        critical_mu=_critical_mu(p, separation=separation),
        linear_critical_mu=_hopf_mu(p, p.k2),
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


def _hopf_mu(p: Parameters, kt: float) -> float | None:
    # Routh–Hurwitz on the characteristic quartic, in which μ enters its last coefficient alone.
    h = 0.5 * p.k3
    if h == 0.0:
        return None
    critical = _hopf_margin(p, kt) / (h * kt)
    return critical if critical > 0.0 else None


def _hopf_margin(p: Parameters, kt: float) -> float:
    # h μ_c(k_t) k_t; r = a1/a3 is the square of the frequency on the boundary.
    h = 0.5 * p.k3
    a = p.k1 + h
    damping = p.c1 + p.c2
    r = (p.c1 * (kt + h) + p.c2 * a) / damping if damping > 0.0 else 0.5 * (kt + h + a)
    # All a_n are divided by m, so that r is a stiffness here.
    a2 = a + kt + h + p.c1 * p.c2 / p.m
    return r * (a2 - r) - a * (kt + h) + h * h


def _critical_mu(p: Parameters, *, separation: bool) -> tuple[CriticalMu, ...]:
    h = 0.5 * p.k3
    if h == 0.0 or (separation and p.F < 0.0):
        return ()
    if p.k_nl == 0.0 or p.F == 0.0:
        only = _hopf_mu(p, p.k2)
        candidates = [] if only is None else [only]
    else:
        candidates = _candidates(p)
    found = []
    for mu in sorted(candidates):
        above = growth_rate(p.with_values({"mu": mu * (1.0 + _SIDE_STEP)}), separation=separation)
        below = growth_rate(p.with_values({"mu": mu * (1.0 - _SIDE_STEP)}), separation=separation)
        if (above > 0.0) != (below > 0.0) or p.c1 + p.c2 == 0.0:
            found.append(CriticalMu(mu, "unstable" if above > below else "stable"))
    return tuple(found)


def _candidates(p: Parameters) -> list[float]:
    # On the boundary μ is a function of y through k_t, and y one of μ through the equilibrium:
    # together a polynomial in u = y/y(μ=0), which falls from 1 to 0 as μ grows.
    rest = equilibrium(p.with_values({"mu": 0.0}), separation=False).y
    h = 0.5 * p.k3
    a = p.k1 + h
    kt = np.array([p.k2, 0.0, 3.0 * p.k_nl * rest * rest])
    spring = np.array([0.0, p.k2, 0.0, p.k_nl * rest * rest]) * rest
    others = np.array([a * p.F, h * p.k1 * rest])
    damping = p.c1 + p.c2
    r = (
        0.5 * (kt + _constant(h + a))
        if damping == 0.0
        else (p.c1 * (kt + _constant(h)) + _constant(p.c2 * a)) / damping
    )
    multiply = np.convolve
    a2 = kt + _constant(a + h + p.c1 * p.c2 / p.m)
    margin = multiply(r, a2 - r)
    margin[:3] += -a * (kt + _constant(h)) + _constant(h * h)
    bracket = margin.copy()
    bracket[:3] += a * kt
    boundary = multiply(spring, bracket)
    load = multiply(kt, others)
    boundary[: load.size] += load
    size = float(np.abs(boundary).max())
    if not math.isfinite(size):
        raise ComputationError(
            "the stability boundary overflows", "use parameters of less extreme size"
        )
    mus = (_hopf_mu(p, tangent_stiffness(p, u * rest)) for u in roots((boundary / size).tolist()))
    return [mu for mu in mus if mu is not None]


def _constant(value: float) -> NDArray[np.float64]:
    return np.array([value, 0.0, 0.0])
