"""Critical friction coefficients in closed form: Hopf boundary and mode coalescence.

Equations have their numbers in the paper. The spring k3 at 45° has the stiffness h = k3/2 along x
and along y. With a = k1 + h, b = k_t + h and the tangent contact stiffness k_t, the characteristic
polynomial of Eq. 8 is

    (m λ² + c1 λ + a) (m λ² + c2 λ + b) − h² + h μ k_t

Only its last coefficient contains μ, so that the Routh–Hurwitz criterion gives the boundary in
closed form (Eq. 9).
"""

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from fivtui.model import (
    DERIVATIVE_STEP,
    PARAMETERS,
    Mode,
    Parameters,
    System,
    check_has_verdict,
    check_off_edge,
    coupling_stiffness,
    derivative,
    equilibrium,
    flutter_boundary,
    load,
    rest_coefficients,
    resting_height,
    tangent_stiffness,
)

Becomes = Literal["stable", "unstable"]
_MAX_SECANTS: Final = 30
_SECANT_TOLERANCE: Final = 1e-15


@dataclass(frozen=True, slots=True)
class CriticalMu:
    """A critical friction coefficient μ_c and what the equilibrium becomes above it."""

    mu: float
    becomes: Becomes


def linear_critical_mu(p: Parameters) -> float | None:
    """μ_c of the linear system (k_nl = 0); None without coupling, k3 k2 = 0 to double precision."""
    coupling = coupling_stiffness(p) * p.k2
    mu_c = flutter_boundary(p, p.k2) / coupling if coupling > 0.0 else math.inf
    return mu_c if math.isfinite(mu_c) else None


def critical_mu(system: System) -> tuple[CriticalMu, ...]:
    """Every μ > 0 in range at which the growth rate changes sign, ascending and to the last bit.

    Friction is constant. The boundary has a closed form for a given k_t, and F fixes k_t by one
    scalar equation. At most one μ is critical; none where F < 0 lifts the slider off the belt, with
    separation, and on a belt that runs backward, whose friction moves the frequencies apart.
    Raises `ComputationError` on a belt at rest, and at F = 0 with separation.
    """
    # A critical μ solves μ h k_t = B, the boundary. With s = μ h/a and ε = −d ln k_t/d ln μ, the
    # balance of forces gives ε ≤ (3/4) s/(1 + s), where 3/4 is the maximum of 6u(u + 1)/(3u + 1)²
    # over u = k_nl y²/k2. By ln μ the left-hand side grows at the rate B (1 − ε), and B at most at
    # the rate (a/2) k_t ε. As s = B/(a k_t), the first is faster: there is one crossing at most.
    check_has_verdict(system)
    p = system.parameters
    is_backward = p.v_belt is not None and p.v_belt < 0.0
    if p.k3 == 0.0 or is_backward or (system.separation and load(p) < 0.0):
        return ()
    h, in_contact = coupling_stiffness(p), System(p, separation=False)

    def excess(mu: float) -> float:
        kt = tangent_stiffness(p, resting_height(in_contact, mu))
        return float(mu * h * kt - flutter_boundary(p, kt))

    mu_c = _least_nonnegative(excess, 0.0, PARAMETERS["mu"].upper)
    return () if mu_c is None else (CriticalMu(mu_c, "unstable"),)


def lowest_critical_mu(system: System) -> float | None:
    """The least critical friction coefficient in range, if any."""
    critical = critical_mu(system)
    return critical[0].mu if critical else None


def flutter_margin(system: System) -> float | None:
    """Distance of μ h k_t below the Hopf boundary, N²/m²; None for an equilibrium off the belt.

    Negative where the equilibrium is unstable, zero at a Hopf point. Raises `ComputationError` if
    there is no equilibrium, or eigenvalues decide nothing.
    """
    check_off_edge(system)
    p, point = system.parameters, equilibrium(system)
    if point.mode is Mode.SEPARATED:
        return None
    kt = tangent_stiffness(p, point.y)
    return float(flutter_boundary(p, kt) - p.mu * coupling_stiffness(p) * kt)


def _least_nonnegative(function: Callable[[float], float], low: float, high: float) -> float | None:
    # The least number at which an increasing function is nonnegative; None if the function is
    # nonnegative at `low` or negative at `high`. Secants (Illinois) approach this number, values a
    # few bits away bracket it, and bisection finds its last bit. If a secant replaces the same end
    # of the bracket as `previous` did, the Illinois method halves the value at the other end.
    below, above = function(low), function(high)
    if below >= 0.0 or above < 0.0:
        return None
    previous, guess = low, high
    for _ in range(_MAX_SECANTS):
        previous, guess = guess, low - below * (high - low) / (above - below)
        if not low < guess < high or abs(guess - previous) <= _SECANT_TOLERANCE * guess:
            break
        value = function(guess)
        if value < 0.0:
            low, below, above = guess, value, above * (0.5 if previous < guess else 1.0)
        else:
            high, above, below = guess, value, below * (0.5 if previous > guess else 1.0)
    width = max(_SECANT_TOLERANCE * guess, math.ulp(0.0))
    while width < 0.25 * (high - low):
        for end in (guess - width, guess + width):
            if low < end < high:
                low, high = (end, high) if function(end) < 0.0 else (low, end)
        width *= 16.0
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if function(middle) < 0.0 else (low, middle)
    return high


def coalescence_mu(system: System) -> float | None:
    """The μ at which the undamped frequencies coalesce; None if they do not at any μ in range.

    They coalesce where h μ k_t = (a − b)²/4 + h², which is the boundary without damping.
    """
    return lowest_critical_mu(system.with_values({"c1": 0.0, "c2": 0.0}))


def critical_mu_derivatives(
    system: System, names: Collection[str] = tuple(PARAMETERS)
) -> dict[str, float] | None:
    """Derivatives of μ_c by all `names` except μ, per unit of each.

    None without μ_c, and where friction falls with the sliding speed. The equilibrium y and μ_c
    solve two equations in closed form. Their derivatives by complex steps are exact to rounding,
    and the implicit function theorem gives those of μ_c. The derivatives by dampings are NaN where
    both dampings are zero.
    """
    p, critical = system.parameters, critical_mu(system)
    if not critical or (p.v_belt is not None and p.speed_law is not None):
        return None
    mu = critical[0].mu
    y = equilibrium(System(p, separation=False), mu=mu).y
    # Complex parameters: an imaginary part is `DERIVATIVE_STEP` times the number given by name.
    unperturbed = p.perturbed({})
    step = complex(0.0, DERIVATIVE_STEP)
    jacobian = np.array([_slopes(unperturbed, y + step, mu), _slopes(unperturbed, y, mu + step)]).T
    derivatives = {}
    for name in names:
        if name == "mu":
            continue
        change = np.array(_slopes(p.perturbed({name: 1.0}), y, mu))
        derivatives[name] = float(np.linalg.solve(jacobian, -change)[1])
        if name in ("c1", "c2") and p.c1 + p.c2 == 0.0:
            derivatives[name] = np.nan
    return derivatives


def _slopes(p: Parameters, y: complex, mu: complex) -> tuple[float, float]:
    # Derivatives of two equations of μ_c: the balance of forces, and μ h k_t less the boundary.
    alpha, beta, load = rest_coefficients(p, mu)
    kt = tangent_stiffness(p, y)
    return (
        derivative(alpha * y * y * y + beta * y + load),
        derivative(mu * coupling_stiffness(p) * kt - flutter_boundary(p, kt)),
    )
