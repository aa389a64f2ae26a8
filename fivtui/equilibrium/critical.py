"""Critical friction coefficients in closed form: Hopf boundary (Eq. 9) and coalescence of modes.

With a = k1 + h, h = k3/2, b = k_t + h and the tangent contact stiffness k_t, the characteristic
polynomial of Eq. 8 is

    (m λ² + c1 λ + a) (m λ² + c2 λ + b) − h² + h μ k_t

so that μ stands in its last coefficient alone and Routh–Hurwitz gives the boundary in closed form.
"""

from dataclasses import dataclass
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from fivtui.model import PARAMETERS, Parameters, equilibrium, tangent_stiffness

Becomes = Literal["stable", "unstable"]
Real = TypeVar("Real", float, NDArray[np.float64])


@dataclass(frozen=True, slots=True)
class CriticalMu:
    """A critical friction coefficient μ_c and what the equilibrium becomes above it."""

    mu: float
    becomes: Becomes


def boundary(*, m: Real, k1: Real, k3: Real, c1: Real, c2: Real, kt: Real, share: Real) -> Real:
    """The value of μ h k_t above which the equilibrium is unstable (Routh–Hurwitz).

    Numbers, or arrays that broadcast together.

    Parameters
    ----------
    m, k1, k3, c1, c2 : float or ndarray
        Parameters of the model, SI units.
    kt : float or ndarray
        Tangent contact stiffness, N/m.
    share : float or ndarray
        c1/(c1 + c2); one half without damping, the limit of equal dampings.

    Returns
    -------
    float or ndarray
        In N²/m².
    """
    h = 0.5 * k3
    a = k1 + h
    detuning = kt + h - a
    spread = share * (1.0 - share) * detuning * detuning
    return spread + h * h + (a + share * detuning) * c1 * c2 / m


def linear_critical_mu(p: Parameters) -> float | None:
    """The critical friction coefficient of the linear system (k_nl = 0).

    Parameters
    ----------
    p : Parameters
        The parameter set; its F, k_nl and μ are not used.

    Returns
    -------
    float or None
        μ_c; None without coupling (k3 = 0).
    """
    return _boundary(p, p.k2) / (0.5 * p.k3 * p.k2) if p.k3 > 0.0 else None


def critical_mu(p: Parameters, *, separation: bool = True) -> tuple[CriticalMu, ...]:
    """Every allowed μ > 0 at which the growth rate changes sign.

    The boundary is closed for a given k_t, and F fixes k_t by one scalar equation. Along μ the
    left-hand side of μ h k_t = boundary grows faster than the right-hand side for every parameter
    set in bounds (k_t falls by less than 3/4 of its own rate): there is one crossing at most.

    Parameters
    ----------
    p : Parameters
        The parameter set; its μ is not used.
    separation : bool
        Whether separation is considered; then F < 0 has its equilibrium off the belt.

    Returns
    -------
    tuple of CriticalMu
        Ascending; μ_c to the last bit.
    """
    if p.k3 == 0.0 or (separation and p.F < 0.0):
        return ()
    h = 0.5 * p.k3

    def excess(mu: float) -> float:
        kt = tangent_stiffness(p, equilibrium(p, separation=False, mu=mu).y)
        return mu * h * kt - _boundary(p, kt)

    stable, unstable = 0.0, PARAMETERS["mu"].upper
    if excess(stable) >= 0.0 or excess(unstable) < 0.0:
        return ()
    while stable < (middle := 0.5 * (stable + unstable)) < unstable:
        stable, unstable = (middle, unstable) if excess(middle) < 0.0 else (stable, middle)
    return (CriticalMu(unstable, "unstable"),)


def coalescence_mu(p: Parameters, *, separation: bool = True) -> float | None:
    """The friction coefficient at which the two undamped frequencies coalesce.

    They do where h μ k_t = (a − b)²/4 + h², which is the boundary without damping.

    Parameters
    ----------
    p : Parameters
        The parameter set; its μ, c1 and c2 are not used.
    separation : bool
        Whether separation is considered.

    Returns
    -------
    float or None
        None if they do not at any allowed μ.
    """
    undamped = p.with_values({"c1": 0.0, "c2": 0.0})
    return next((c.mu for c in critical_mu(undamped, separation=separation)), None)


def _boundary(p: Parameters, kt: float) -> float:
    damping = p.c1 + p.c2
    share = p.c1 / damping if damping > 0.0 else 0.5
    return boundary(m=p.m, k1=p.k1, k3=p.k3, c1=p.c1, c2=p.c2, kt=kt, share=share)
