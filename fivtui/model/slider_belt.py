"""Equations of the slider-belt model: contact law, motion, equilibrium, Jacobian, energy.

Symbols as in the paper; `a` = k1 + k3/2 and `h` = k3/2 are entries of its stiffness matrix.
A state is (x, ẋ, y, ẏ) in m and m/s.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, Protocol, TypeVar

from .errors import ComputationError
from .modes import IN_CONTACT, Guard, Mode
from .parameters import Parameters

# Forces whose difference is below this part of them balance: it is their rounding. Below the other
# number, N or N/s, what they do to a mass may be lost to underflow.
BALANCED: Final = 2.0**-49
LEAST: Final = 1e-280
State = tuple[float, float, float, float]
Matrix = tuple[State, State, State, State]
# A number, or an array of numbers.
Number = TypeVar("Number")


class ContactSpring(Protocol):
    """Stiffnesses of the contact, N/m and N/m³: of one parameter set, or arrays of many."""

    @property
    def k2(self) -> Any:
        """Linear stiffness."""

    @property
    def k_nl(self) -> Any:
        """Cubic stiffness."""


def contact_force(p: Parameters, y: float, mode: Mode) -> float:
    """Contact force P in N (Eq. 1), positive in compression, zero when separated.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    y : float
        Vertical displacement, m.
    mode : Mode
        The mode, see `MODES`.
    """
    return spring_force(p, y) if mode in IN_CONTACT else 0.0


def spring_force(spring: ContactSpring, y: Number) -> Number:
    """Force of the contact spring in N, P of Eq. 1 as if in contact; of numbers or arrays y, m."""
    force: Number = -spring.k2 * y - spring.k_nl * y * y * y
    return force


class Rates(NamedTuple):
    """How fast F, N/s, μ, 1/s, and the belt's speed, m/s², change with time."""

    F: float = 0.0
    mu: float = 0.0
    v_belt: float = 0.0


CONSTANT: Final = Rates()


def accelerations(
    p: Parameters, state: State, mode: Mode, rates: Rates = CONSTANT
) -> tuple[float, float]:
    """Accelerations (ẍ, ÿ) in m/s²: Eq. 5 when separated, Eq. 2 with the friction of the mode else.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    state : State
        (x, ẋ, y, ẏ) in m and m/s.
    mode : Mode
        The mode, see `MODES`.
    rates : Rates
        How parameters change with time.
    """
    x, vx, y, vy = state
    force = contact_force(p, y, mode)
    coupling = 0.5 * p.k3 * (x - y)
    if mode is Mode.STICK:
        return rates.v_belt, (force - p.F - p.c2 * vy + coupling) / p.m
    return (
        (_sliding_friction(p, vx, force, mode) - p.c1 * vx - p.k1 * x - coupling) / p.m,
        (force - p.F - p.c2 * vy + coupling) / p.m,
    )


def friction_coefficient(p: Parameters, speed: float) -> float:
    """The friction coefficient μ + (μ_s − μ) exp(−v/v_s) at a sliding speed v ≥ 0, m/s."""
    if p.speed_law is None:
        return p.mu
    return p.mu + (p.mu_static - p.mu) * math.exp(-speed / p.speed_law)


def friction_slope(p: Parameters, speed: float) -> float:
    """The derivative of the friction coefficient by a sliding speed v ≥ 0, s/m."""
    if p.speed_law is None:
        return 0.0
    return -(p.mu_static - p.mu) / p.speed_law * math.exp(-speed / p.speed_law)


def sliding(p: Parameters, y: float, mode: Mode) -> tuple[float, float]:
    """Friction coefficient, and horizontal damping in N s/m, about an equilibrium at y, m.

    On a belt of finite speed friction falls with the sliding speed, and takes damping away.
    """
    if p.v_belt is None or mode is Mode.SEPARATED:
        return p.mu, p.c1
    slope = friction_slope(p, p.v_belt)
    return friction_coefficient(p, p.v_belt), p.c1 + spring_force(p, y) * slope


def friction_force(p: Parameters, state: State, mode: Mode, rates: Rates = CONSTANT) -> float:
    """Friction force on the slider in N; where it sticks, what the belt has to exert.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    state : State
        (x, ẋ, y, ẏ) in m and m/s.
    mode : Mode
        The mode, see `MODES`.
    rates : Rates
        How parameters change with time.
    """
    x, vx, y, _ = state
    if mode is Mode.STICK:
        return holding_force(p, x, y, rates)
    return _sliding_friction(p, vx, contact_force(p, y, mode), mode)


def _sliding_friction(p: Parameters, vx: float, force: float, mode: Mode) -> float:
    if p.v_belt is None or mode is Mode.SEPARATED:
        return p.mu * force
    if mode is Mode.BACKWARD:
        return -friction_coefficient(p, max(vx - p.v_belt, 0.0)) * force
    return friction_coefficient(p, max(p.v_belt - vx, 0.0)) * force


def holding_force(p: Parameters, x: float, y: float, rates: Rates = CONSTANT) -> float:
    """Force f = c1 v_belt + m v̇_belt + a x − h y in N that the belt exerts while it holds."""
    h, speed = 0.5 * p.k3, p.v_belt or 0.0
    return (p.c1 * speed + p.m * rates.v_belt) + (p.k1 + h) * x - h * y


def guard_value(p: Parameters, state: State, guard: Guard, rates: Rates = CONSTANT) -> float:
    """Value of a guard, positive while its mode lasts; in m, m/s or N."""
    x, vx, y, _ = state
    if guard is Guard.HEIGHT or guard is Guard.DEPTH:
        return y if guard is Guard.HEIGHT else -y
    if guard is Guard.AHEAD or guard is Guard.BEHIND:
        ahead = (p.v_belt or 0.0) - vx
        return ahead if guard is Guard.AHEAD else -ahead
    grip, held = p.mu_static * spring_force(p, y), holding_force(p, x, y, rates)
    return grip - held if guard is Guard.HELD_FORWARD else grip + held


def mode_of(p: Parameters, state: State, *, separation: bool, rates: Rates = CONSTANT) -> Mode:
    """The mode in which the motion continues from a state (Eqs. 3 and 4), see `MODES`.

    At y = 0 the first nonzero time derivative of y decides; it is the same in both modes. A second
    derivative within rounding counts as zero (see `lift`). A slider at rest at y = 0 is in contact.
    On a belt of finite speed a slider of its very speed sticks while the belt can hold it; in
    tension, P < 0 with separation ignored, it cannot.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    state : State
        (x, ẋ, y, ẏ) in m and m/s.
    separation : bool
        Whether separation is considered; if not, the mode is always contact.
    rates : Rates
        How parameters change with time.
    """
    if separation and _is_off(p, state, rates):
        return Mode.SEPARATED
    return Mode.CONTACT if p.v_belt is None else _mode_on_belt(p, state, p.v_belt, rates)


def _is_off(p: Parameters, state: State, rates: Rates) -> bool:
    # Whether the slider goes on off the belt.
    x, vx, y, vy = state
    if y != 0.0:
        return y > 0.0
    h = 0.5 * p.k3
    push = h * vx - rates.F
    derivatives = (vy, lift(p, x), push if abs(push) > LEAST else 0.0, -h * x)
    direction = next((value for value in derivatives if value != 0.0), -1.0)
    return direction > 0.0


def _mode_on_belt(p: Parameters, state: State, speed: float, rates: Rates) -> Mode:
    # Of a slider in contact. At the speed of the belt the first derivative of a margin that is not
    # zero to rounding says whether the belt holds; each is given with the size of its terms.
    x, vx, y, vy = state
    if vx != speed:
        return Mode.FORWARD if vx < speed else Mode.BACKWARD
    h = 0.5 * p.k3
    a, grip, force = p.k1 + h, p.mu_static, spring_force(p, y)
    kt = tangent_stiffness(p, y)
    ay = (force - p.F - p.c2 * vy + h * (x - y)) / p.m
    bend = 6.0 * p.k_nl * y * vy * vy
    driven = p.c1 * rates.v_belt
    held = (holding_force(p, x, y, rates), driven + a * speed - h * vy, a * rates.v_belt - h * ay)
    forces = (force, -kt * vy, -kt * ay - bend)
    # What the preload gives is known to rounding, too.
    of_forces = (
        abs(force) + abs(p.F),
        kt * (abs(vy) + static_deflection(p) / time_scale(p)),
        kt * (abs(ay) + abs(p.F) / p.m) + abs(bend),
    )
    of_held = (
        p.c1 * speed + abs(p.m * rates.v_belt) + abs(a * x) + abs(h * y),
        abs(driven) + a * speed + abs(h * vy),
        abs(a * rates.v_belt) + abs(h * ay),
    )
    more = rates.mu if p.mu_s is None else 0.0
    grips = _times_line(grip, more, forces)
    of_grips = _times_line(grip, abs(more), of_forces)
    sizes = [one + other for one, other in zip(of_held, of_grips, strict=True)]
    if _falls(forces, of_forces):
        return Mode.BACKWARD if _falls(held, sizes) else Mode.FORWARD
    if _falls([g - f for g, f in zip(grips, held, strict=True)], sizes):
        return Mode.FORWARD
    if _falls([g + f for g, f in zip(grips, held, strict=True)], sizes):
        return Mode.BACKWARD
    return Mode.STICK


def _times_line(value: float, slope: float, of: tuple[float, float, float]) -> list[float]:
    # Of a function times a line: both, and their first and second derivative.
    first, second, third = of
    return [value * first, slope * first + value * second, 2.0 * slope * second + value * third]


def _falls(derivatives: Sequence[float], sizes: Sequence[float]) -> bool:
    # Whether a function is negative now or soon: by the first derivative beyond rounding.
    for value, size in zip(derivatives, sizes, strict=True):
        if abs(value) > max(BALANCED * size, LEAST):
            return value < 0.0
    return False


def lift(p: Parameters, x: float) -> float:
    """Force (k3/2) x − F in N that lifts a slider at rest at y = 0; 0 if within rounding."""
    held, load = 0.5 * p.k3 * x, p.F
    difference = held - load
    known = abs(difference) > max(BALANCED * (abs(held) + abs(load)), LEAST)
    return difference if known else 0.0


@dataclass(frozen=True, slots=True)
class Equilibrium:
    """An equilibrium (Eq. 6): position x, y in m, contact force P in N, and mode."""

    x: float
    y: float
    P: float
    mode: Mode


def equilibrium(p: Parameters, *, separation: bool = True, mu: float | None = None) -> Equilibrium:
    """The unique equilibrium (Eq. 6).

    Eliminating x gives the monotone cubic α y³ + β y + F = 0 with α = (1 + μ h/a) k_nl and
    β = (1 + μ h/a) k2 + h k1/a.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    separation : bool
        Whether separation is considered; if so, the equilibrium for F < 0 is off the belt.
    mu : float, optional
        Friction coefficient to use instead of that of `p`, on a belt of finite speed μ(v_belt).

    Raises
    ------
    ComputationError
        If F < 0 lifts the slider off the belt and no spring holds it (k3 = 0), or the belt is at
        rest: then the slider sticks where it is.
    """
    h = 0.5 * p.k3
    a = p.k1 + h
    in_contact = Mode.CONTACT if p.v_belt is None else Mode.FORWARD
    if p.v_belt == 0.0 and not (separation and p.F < 0.0):
        raise ComputationError(
            "no equilibrium of sliding: the belt is at rest, v_belt = 0, and the slider sticks",
            "use v_belt above 0",
        )
    if mu is None:
        mu = p.mu if p.v_belt is None else friction_coefficient(p, p.v_belt)
    y = resting_height(h, (p.k1, p.k2, p.k_nl), p.F, mu, separation)
    if not math.isfinite(y):
        raise no_equilibrium_error(p.F)
    if separation and p.F < 0.0:
        return Equilibrium(x=h * y / a, y=y, P=0.0, mode=Mode.SEPARATED)
    force = contact_force(p, y, in_contact)
    return Equilibrium(x=(h * y + mu * force) / a, y=y, P=force, mode=in_contact)


def resting_height(
    h: float, k: tuple[float, float, float], force: float, mu: float, separation: bool
) -> float:
    """Height y of the equilibrium in m; not finite if the slider is lifted and not held.

    `h` = k3/2, `k` = (k1, k2, k_nl).
    """
    k1, k2, k_nl = k
    a = k1 + h
    if separation and force < 0.0:
        held = h * k1 / a
        return -force / held if held > 0.0 else math.inf
    friction = 1.0 + mu * h / a
    alpha, beta = friction * k_nl, friction * k2 + h * k1 / a
    y = -force / beta
    if alpha > 0.0:
        bound = max(1.0, abs(force) / alpha)
        y = min(max(y, -bound), bound)
    # Newton's method from beyond the root, until it comes no nearer: by arithmetic alone, which has
    # the same bits everywhere.
    while True:
        new = y - (alpha * y * y * y + beta * y + force) / (3.0 * alpha * y * y + beta)
        if not abs(new) < abs(y):
            return y
        y = new


def no_equilibrium_error(force: float) -> ComputationError:
    """The error for a slider that F < 0 lifts off the belt and no spring holds."""
    return ComputationError(
        f"no equilibrium: F = {force:g} N lifts the slider and no spring holds it vertically",
        "use F >= 0, a larger k3, or ignore separation",
    )


def static_start(p: Parameters, *, separation: bool = True) -> State:
    """The state at rest at the equilibrium of μ = 0 under F, before the belt moves.

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
        If there is no such equilibrium.
    """
    h = 0.5 * p.k3
    y = resting_height(h, (p.k1, p.k2, p.k_nl), p.F, 0.0, separation)
    if not math.isfinite(y):
        raise no_equilibrium_error(p.F)
    return (h * y / (p.k1 + h), 0.0, y, 0.0)


def static_start_change(p: Parameters, name: str, *, separation: bool = True) -> State:
    """The derivative of the static start by a parameter.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    name : str
        Name of the parameter.
    separation : bool
        Whether separation is considered.

    Returns
    -------
    State
        (∂x, 0, ∂y, 0), m per unit of the parameter; towards greater F at F = 0.

    Raises
    ------
    ComputationError
        If there is no such start.
    """
    _, _, y, _ = static_start(p, separation=separation)
    h = 0.5 * p.k3
    a = p.k1 + h
    off = separation and p.F < 0.0
    k2, k_nl = (0.0, 0.0) if off else (p.k2, p.k_nl)
    by_h = 0.5 if name == "k3" else 0.0
    by_k1 = 1.0 if name == "k1" else 0.0
    # Of the force balance k_nl y³ + (k2 + h k1/a) y + F = 0, and of x = h y/a.
    push = {"F": 1.0, "k2": 0.0 if off else y, "k_nl": 0.0 if off else y * y * y}.get(name, 0.0)
    push += y * (by_h * p.k1 * p.k1 + by_k1 * h * h) / (a * a)
    dy = -push / (3.0 * k_nl * y * y + k2 + h * p.k1 / a)
    dx = h * dy / a + y * (by_h * p.k1 - by_k1 * h) / (a * a)
    return (dx, 0.0, dy, 0.0)


def jacobian(p: Parameters, y: float, mode: Mode) -> Matrix:
    """Jacobian (4 × 4, SI units) of the first-order system (Eq. 8) in (x, ẋ, y, ẏ).

    Parameters
    ----------
    p : Parameters
        The parameter set.
    y : float
        Vertical displacement at which to linearise, m.
    mode : Mode
        The mode, see `MODES`.
    """
    h = 0.5 * p.k3
    kt = tangent_stiffness(p, y) if mode in IN_CONTACT else 0.0
    mu, c1 = sliding(p, y, mode)
    return (
        (0.0, 1.0, 0.0, 0.0),
        (-(p.k1 + h) / p.m, -c1 / p.m, (h - mu * kt) / p.m, 0.0),
        (0.0, 0.0, 0.0, 1.0),
        (h / p.m, 0.0, -(kt + h) / p.m, -p.c2 / p.m),
    )


def tangent_stiffness(spring: ContactSpring, y: Number) -> Number:
    """Tangent contact stiffness k_t = k2 + 3 k_nl y² in N/m; of numbers or arrays y, m."""
    stiffness: Number = spring.k2 + 3.0 * spring.k_nl * y * y
    return stiffness


def time_scale(p: Parameters, y: float = 0.0) -> float:
    """√(m/stiffness), s, with all springs in parallel: the scale of step sizes near y, m."""
    return math.sqrt(p.m / (p.k1 + tangent_stiffness(p, y) + p.k3))


def static_deflection(p: Parameters) -> float:
    """|F|/stiffness, m, with all linear springs in parallel: the scale of displacements."""
    return abs(p.F) / (p.k1 + p.k2 + p.k3)


def mechanical_energy(p: Parameters, state: State, mode: Mode) -> float:
    """Energy in J: kinetic, of the springs and of the preload.

    Continuous at separation and reattachment; zero at rest in the undeformed position.
    """
    x, vx, y, vy = state
    kinetic = 0.5 * p.m * (vx * vx + vy * vy)
    springs = 0.5 * p.k1 * x * x + 0.25 * p.k3 * (x - y) * (x - y)
    square = y * y
    contact = (0.5 * p.k2 + 0.25 * p.k_nl * square) * square if mode in IN_CONTACT else 0.0
    return kinetic + springs + contact + p.F * y


def power(p: Parameters, state: State, mode: Mode) -> tuple[float, float]:
    """Input by friction and loss by damping in W; their difference is d(energy)/dt."""
    _, vx, _, vy = state
    friction = friction_force(p, state, mode) * vx
    return friction, p.c1 * vx * vx + p.c2 * vy * vy
