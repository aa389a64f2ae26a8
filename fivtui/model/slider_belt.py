"""The slider-belt model: contact law, motion, equilibrium, linearisation and energy.

Symbols are the paper's; `a` = k1 + k3/2 and `h` = k3/2 are the two entries of its stiffness matrix.
A state is (x, ẋ, y, ẏ) in m and m/s.
"""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

from .errors import ComputationError
from .parameters import Parameters

# Forces whose difference is below this part of them balance: it is their rounding. Below the other
# number, N or N/s, what they do to a mass may be lost to underflow.
BALANCED: Final = 2.0**-49
LEAST: Final = 1e-280
State = tuple[float, float, float, float]
Matrix = tuple[State, State, State, State]


class Mode(IntEnum):
    """Which field governs the motion: Eq. 5 (separated) or Eq. 2 (in contact)."""

    SEPARATED = 0
    CONTACT = 1


def contact_force(p: Parameters, y: float, mode: Mode) -> float:
    """Contact force P (Eq. 1), positive in compression.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    y : float
        Vertical displacement, m.
    mode : Mode
        Contact or separated.

    Returns
    -------
    float
        P in N; zero when separated.
    """
    if mode is Mode.SEPARATED:
        return 0.0
    return -p.k2 * y - p.k_nl * y * y * y


def accelerations(p: Parameters, state: State, mode: Mode) -> tuple[float, float]:
    """Accelerations (ẍ, ÿ) of Eq. 2 in contact and of Eq. 5 when separated.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    state : State
        (x, ẋ, y, ẏ) in m and m/s.
    mode : Mode
        Contact or separated.

    Returns
    -------
    tuple of float
        (ẍ, ÿ) in m/s².
    """
    x, vx, y, vy = state
    force = contact_force(p, y, mode)
    coupling = 0.5 * p.k3 * (x - y)
    return (
        (p.mu * force - p.c1 * vx - p.k1 * x - coupling) / p.m,
        (force - p.F - p.c2 * vy + coupling) / p.m,
    )


def mode_of(p: Parameters, state: State, *, separation: bool) -> Mode:
    """The mode in which the motion goes on from a state (Eqs. 3 and 4).

    On the switch itself (y = 0) the first nonzero derivative of y decides; both fields agree
    there, so the derivatives are those of either field. A second one within rounding is zero, see
    `pull`.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    state : State
        (x, ẋ, y, ẏ) in m and m/s.
    separation : bool
        Whether separation is considered; if not, the answer is always contact.

    Returns
    -------
    Mode
        Contact where the slider rests exactly at y = 0.
    """
    if not separation:
        return Mode.CONTACT
    x, vx, y, vy = state
    if y != 0.0:
        return Mode.SEPARATED if y > 0.0 else Mode.CONTACT
    h = 0.5 * p.k3
    push = h * vx if abs(h * vx) > LEAST else 0.0
    derivatives = (vy, pull(h, p.F, x), push, -h * x)
    direction = next((value for value in derivatives if value != 0.0), -1.0)
    return Mode.SEPARATED if direction > 0.0 else Mode.CONTACT


def pull(h: float, force: float, x: float) -> float:
    """Force that lifts the slider at rest at y = 0, on plain numbers for compilers too.

    Parameters
    ----------
    h : float
        k3/2, N/m.
    force : float
        F, N.
    x : float
        Horizontal displacement, m.

    Returns
    -------
    float
        (k3/2) x − F in N; zero if x cannot be told from the place where both forces balance.
    """
    held = h * x
    difference = held - force
    known = abs(difference) > max(BALANCED * (abs(held) + abs(force)), LEAST)
    return difference if known else 0.0


@dataclass(frozen=True, slots=True)
class Equilibrium:
    """An equilibrium point (Eq. 6).

    Attributes
    ----------
    x, y : float
        Position, m.
    P : float
        Contact force, N.
    mode : Mode
        The field it belongs to.
    """

    x: float
    y: float
    P: float
    mode: Mode


def equilibrium(p: Parameters, *, separation: bool = True, mu: float | None = None) -> Equilibrium:
    """The unique equilibrium (Eq. 6) in closed form, polished by one Newton step.

    Eliminating x leaves the monotone cubic α y³ + β y + F = 0 with α = (1 + μ h/a) k_nl and
    β = (1 + μ h/a) k2 + h k1/a, whose one real root is a hyperbolic sine.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    separation : bool
        Whether separation is considered; then F < 0 has its equilibrium off the belt.
    mu : float, optional
        Friction coefficient in place of that of `p`.

    Returns
    -------
    Equilibrium
        Position, contact force and mode.

    Raises
    ------
    ComputationError
        If F < 0 lifts the slider off the belt and nothing (k3 = 0) holds it.
    """
    h = 0.5 * p.k3
    a = p.k1 + h
    mu = p.mu if mu is None else mu
    y = resting_height(h, (p.k1, p.k2, p.k_nl), p.F, mu, separation)
    if not math.isfinite(y):
        raise no_equilibrium_error(p.F)
    if separation and p.F < 0.0:
        return Equilibrium(x=h * y / a, y=y, P=0.0, mode=Mode.SEPARATED)
    force = contact_force(p, y, Mode.CONTACT)
    return Equilibrium(x=(h * y + mu * force) / a, y=y, P=force, mode=Mode.CONTACT)


def resting_height(
    h: float, k: tuple[float, float, float], force: float, mu: float, separation: bool
) -> float:
    """Vertical position of the equilibrium, on plain numbers for compilers too.

    Parameters
    ----------
    h : float
        k3/2, N/m.
    k : tuple of float
        k1, k2 and k_nl.
    force, mu : float
        F and μ.
    separation : bool
        Whether separation is considered.

    Returns
    -------
    float
        y, m; not finite if F < 0 lifts the slider and no spring holds it.
    """
    k1, k2, k_nl = k
    a = k1 + h
    if separation and force < 0.0:
        held = h * k1 / a
        return -force / held if held > 0.0 else math.inf
    friction = 1.0 + mu * h / a
    alpha, beta = friction * k_nl, friction * k2 + h * k1 / a
    y = -force / beta
    scale = math.sqrt(3.0 * alpha / beta)
    if scale * abs(y) > 1e-4:
        # Below this the root is -F/β to rounding after the polish, and 1/scale may overflow.
        y = -2.0 / scale * math.sinh(math.asinh(1.5 * force / beta * scale) / 3.0)
    return y - (alpha * y * y * y + beta * y + force) / (3.0 * alpha * y * y + beta)


def no_equilibrium_error(force: float) -> ComputationError:
    """An error for a slider that is lifted off and not held.

    Parameters
    ----------
    force : float
        F, N.

    Returns
    -------
    ComputationError
        To be raised by the caller.
    """
    return ComputationError(
        f"no equilibrium: F = {force:g} N lifts the slider and no spring holds it vertically",
        "use F >= 0, a larger k3, or ignore separation",
    )


def static_start(p: Parameters, *, separation: bool = True) -> State:
    """The state at rest at the equilibrium of μ = 0 under F: the belt has not moved yet.

    Parameters
    ----------
    p : Parameters
        The parameter set; its μ is not used.
    separation : bool
        Whether separation is considered.

    Returns
    -------
    State
        (x, 0, y, 0) in m and m/s.

    Raises
    ------
    ComputationError
        If there is no such equilibrium, see `equilibrium`.
    """
    h = 0.5 * p.k3
    y = resting_height(h, (p.k1, p.k2, p.k_nl), p.F, 0.0, separation)
    if not math.isfinite(y):
        raise no_equilibrium_error(p.F)
    return (h * y / (p.k1 + h), 0.0, y, 0.0)


def jacobian(p: Parameters, y: float, mode: Mode) -> Matrix:
    """Jacobian of the first-order system (Eq. 8) in the order (x, ẋ, y, ẏ).

    Parameters
    ----------
    p : Parameters
        The parameter set.
    y : float
        Vertical displacement at which to linearise, m.
    mode : Mode
        Contact or separated.

    Returns
    -------
    Matrix
        Four rows of four, in SI units.
    """
    h = 0.5 * p.k3
    kt = tangent_stiffness(p, y) if mode is Mode.CONTACT else 0.0
    return (
        (0.0, 1.0, 0.0, 0.0),
        (-(p.k1 + h) / p.m, -p.c1 / p.m, (h - p.mu * kt) / p.m, 0.0),
        (0.0, 0.0, 0.0, 1.0),
        (h / p.m, 0.0, -(kt + h) / p.m, -p.c2 / p.m),
    )


def tangent_stiffness(p: Parameters, y: float) -> float:
    """Tangent contact stiffness k_t = k2 + 3 k_nl y².

    Parameters
    ----------
    p : Parameters
        The parameter set.
    y : float
        Vertical displacement, m.

    Returns
    -------
    float
        k_t in N/m.
    """
    return p.k2 + 3.0 * p.k_nl * y * y


def mechanical_energy(p: Parameters, state: State, mode: Mode) -> float:
    """Kinetic energy, energy of the springs and potential of the preload.

    Continuous across the switch; zero at rest in the undeformed position.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    state : State
        (x, ẋ, y, ẏ) in m and m/s.
    mode : Mode
        Contact or separated.

    Returns
    -------
    float
        Energy in J.
    """
    x, vx, y, vy = state
    kinetic = 0.5 * p.m * (vx * vx + vy * vy)
    springs = 0.5 * p.k1 * x * x + 0.25 * p.k3 * (x - y) * (x - y)
    square = y * y
    contact = (0.5 * p.k2 + 0.25 * p.k_nl * square) * square if mode is Mode.CONTACT else 0.0
    return kinetic + springs + contact + p.F * y


def power(p: Parameters, state: State, mode: Mode) -> tuple[float, float]:
    """The two sides of the energy balance: d(energy)/dt = friction input − damping loss.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    state : State
        (x, ẋ, y, ẏ) in m and m/s.
    mode : Mode
        Contact or separated.

    Returns
    -------
    tuple of float
        Power put in by friction, μ P ẋ, and power lost in the dampers, both in W.
    """
    _, vx, y, vy = state
    friction = p.mu * contact_force(p, y, mode) * vx
    return friction, p.c1 * vx * vx + p.c2 * vy * vy
