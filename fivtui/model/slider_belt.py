"""Modes, equilibrium and Jacobian of the slider, from the equations of `field`.

A state is (x, ẋ, y, ẏ) in m and m/s. Equations are numbered as in the paper "Nonlinear
friction-induced vibration of a slider-belt system".
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import add, sub
from typing import Any, Final

from . import field as equations
from .errors import ComputationError
from .field import CONSTANT, Rates, spring_force, tangent_stiffness
from .modes import IN_CONTACT, MODES, Mode
from .parameters import Parameters
from .system import System

# Forces balance if their sum is below this fraction of their sizes, or below MIN_FORCE, N or N/s:
# the acceleration by so small a force may underflow.
BALANCE_TOL: Final = 2.0**-49
MIN_FORCE: Final = 1e-280
State = tuple[float, float, float, float]
Matrix = tuple[State, State, State, State]


def contact_force(p: Parameters, y: float, mode: Mode) -> float:
    """Contact force P in N (Eq. 1), positive in compression, zero when separated."""
    return spring_force(p, y) if mode in IN_CONTACT else 0.0


def accelerations(
    p: Parameters, state: State, mode: Mode, rates: Rates = CONSTANT
) -> tuple[float, float]:
    """Accelerations (ẍ, ÿ) in m/s²: Eq. 5 when separated, else Eq. 2 with the mode's friction."""
    x, vx, y, vy = state
    force = contact_force(p, y, mode)
    ay = equations.vertical_acceleration(p, x, y, vy, force - equations.load(p))
    if mode is Mode.STICK:
        return rates.v_belt, ay
    friction = equations.sliding_friction(p, vx, force, mode)
    return equations.horizontal_acceleration(p, x, vx, y, friction), ay


def sliding_coefficients(p: Parameters, y: float, mode: Mode) -> tuple[float, float]:
    """Friction coefficient, and horizontal damping in N s/m, about an equilibrium at y, m.

    On a belt of finite speed, friction that falls with the sliding speed reduces the damping.
    """
    if p.v_belt is None or mode is Mode.SEPARATED:
        return p.mu, p.c1
    slope = equations.friction_slope(p, abs(p.v_belt))
    mu: float = equations.friction_coefficient(p, abs(p.v_belt))
    return mu, p.c1 + spring_force(p, y) * slope


def sliding_mode(p: Parameters) -> Mode:
    """The mode of a slider at rest in contact with a moving belt."""
    if p.v_belt is None:
        return Mode.CONTACT
    return Mode.FORWARD if p.v_belt >= 0.0 else Mode.BACKWARD


def sliding_friction_ratio(p: Parameters) -> float:
    """Friction force on a slider at rest over the contact force; negative on a backward belt."""
    mode = sliding_mode(p)
    mu, _ = sliding_coefficients(p, 0.0, mode)
    return MODES[mode].friction_sign * mu


def friction_force(p: Parameters, state: State, mode: Mode, rates: Rates = CONSTANT) -> float:
    """Friction force on the slider in N; in stick, the holding force of the belt."""
    x, vx, y, _ = state
    if mode is Mode.STICK:
        return float(equations.holding_force(p, x, y, rates))
    return float(equations.sliding_friction(p, vx, contact_force(p, y, mode), mode))


def mode_of(p: Parameters, state: State, *, separation: bool, rates: Rates = CONSTANT) -> Mode:
    """The mode in which the motion continues from a state (Eqs. 3 and 4), see `MODES`.

    At y = 0 the sign of the first nonzero time derivative of y decides. A second derivative within
    rounding counts as zero (see `lifting_force`). A slider at rest at y = 0 is in contact. On a
    belt of finite speed, a slider at the speed of the belt sticks if |f| <= μ_s P for the holding
    force f. In tension (P < 0, with separation ignored) it never sticks.
    """
    if separation and _separates(p, state, rates):
        return Mode.SEPARATED
    return Mode.CONTACT if p.v_belt is None else _contact_mode(p, state, p.v_belt, rates)


def _separates(p: Parameters, state: State, rates: Rates) -> bool:
    # Whether the motion continues off the belt, from the first derivative of y, up to the fourth,
    # that is not zero. If the first three are zero at y = 0, no force but h x and F acts on y, and
    # F changes linearly. Then m times the fourth is h ẍ, without contact force and friction.
    x, vx, y, vy = state
    if y != 0.0:
        return y > 0.0
    h = equations.coupling_stiffness(p)
    jerk = h * vx - rates.F
    derivatives = (
        vy,
        lifting_force(p, x),
        jerk if abs(jerk) > MIN_FORCE else 0.0,
        h * equations.horizontal_acceleration(p, x, vx, 0.0, 0.0),
    )
    direction = next((value for value in derivatives if value != 0.0), -1.0)
    return direction > 0.0


def _contact_mode(p: Parameters, state: State, belt_speed: float, rates: Rates) -> Mode:
    # Mode of a slider in contact. At the speed of the belt it sticks if neither P nor μ_s P − f nor
    # μ_s P + f is or becomes negative. For each, the first of its value and two derivatives that
    # exceeds rounding decides. Rounding errors are relative to the sizes of the terms.
    x, vx, y, vy = state
    if vx != belt_speed:
        return Mode.FORWARD if vx < belt_speed else Mode.BACKWARD
    mu_static, force, preload = p.mu_static, spring_force(p, y), abs(equations.load(p))
    kt = tangent_stiffness(p, y)
    ay = equations.vertical_acceleration(p, x, y, vy, force - equations.load(p))
    slope_term = equations.tangent_slope(p, y) * vy * vy
    holding = (
        equations.holding_force(p, x, y, rates),
        equations.holding_force_rate(p, rates.v_belt, belt_speed, vy),
        # The rate is linear: from accelerations it gives the second derivative.
        equations.holding_force_rate(p, 0.0, rates.v_belt, ay),
    )
    forces = (force, -kt * vy, -kt * ay - slope_term)
    # The sizes include the preload: the rounding error of a y that balances it is relative to it.
    force_sizes = (
        abs(force) + preload,
        kt * (abs(vy) + static_deflection(p) / time_scale(p)),
        kt * (abs(ay) + preload / p.m) + abs(slope_term),
    )
    a, h = equations.horizontal_stiffness(p), equations.coupling_stiffness(p)
    holding_sizes = (
        equations.holding_force_size(p, x, y, rates),
        abs(p.c1 * rates.v_belt) + abs(a * belt_speed) + abs(h * vy),
        abs(a * rates.v_belt) + abs(h * ay),
    )
    grip_forces = _product_derivatives(mu_static, rates.mu_static, forces)
    grip_sizes = _product_derivatives(mu_static, abs(rates.mu_static), force_sizes)
    sizes = [size + grip for size, grip in zip(holding_sizes, grip_sizes, strict=True)]
    if _is_negative(forces, force_sizes):
        # In tension the direction is that without friction: it has the sign of −f.
        return Mode.BACKWARD if _is_negative(holding, sizes) else Mode.FORWARD
    if _is_negative(list(map(sub, grip_forces, holding)), sizes):
        return Mode.FORWARD
    if _is_negative(list(map(add, grip_forces, holding)), sizes):
        return Mode.BACKWARD
    return Mode.STICK


def _product_derivatives(
    value: float, slope: float, factor: tuple[float, float, float]
) -> list[float]:
    # Value and two derivatives of the product of a linear function and a factor with derivatives.
    first, second, third = factor
    return [value * first, slope * first + value * second, 2.0 * slope * second + value * third]


def _is_negative(derivatives: Sequence[float], sizes: Sequence[float]) -> bool:
    # Whether a function is or becomes negative, by its first derivative that exceeds rounding.
    for value, size in zip(derivatives, sizes, strict=True):
        if abs(value) > max(BALANCE_TOL * size, MIN_FORCE):
            return value < 0.0
    return False


def lifting_force(p: Parameters, x: float) -> float:
    """Force (k3/2) x − F in N that lifts a slider at rest at y = 0; 0 if within rounding."""
    spring, load = equations.coupling_stiffness(p) * x, equations.load(p)
    difference = spring - load
    is_significant = abs(difference) > max(BALANCE_TOL * (abs(spring) + abs(load)), MIN_FORCE)
    return difference if is_significant else 0.0


@dataclass(frozen=True, slots=True)
class Equilibrium:
    """An equilibrium (Eq. 6): position x, y in m, contact force P in N, and mode."""

    x: float
    y: float
    P: float
    mode: Mode


def equilibrium(system: System, *, mu: float | None = None) -> Equilibrium:
    """The unique equilibrium (Eq. 6).

    Eliminating x gives the cubic α y³ + β y + F = 0 with α = (1 + μ h/a) k_nl and
    β = (1 + μ h/a) k2 + h k1/a. On a belt that runs backward μ is negative in it. `mu` replaces
    the friction of the belt. Raises `ComputationError` if the cubic is not monotone, if the slider
    sticks to a belt at rest, and if no spring holds a slider that F < 0 lifts.
    """
    p, separation = system.parameters, system.separation
    load = equations.load(p)
    is_lifted = separation and load < 0.0
    _check_belt_moves(system)
    if mu is None:
        mu = sliding_friction_ratio(p)
    alpha, beta, _ = equations.rest_coefficients(p, mu)
    if not is_lifted and not (alpha >= 0.0 and beta > 0.0):
        raise ComputationError(
            f"no unique equilibrium: the belt runs backward, and friction of μ = {-mu:g} draws the "
            "slider into it",
            "use a smaller mu or a smaller k3",
        )
    # Adding 0 turns -0 into 0.
    y = resting_height(system, mu) + 0.0
    if not math.isfinite(y):
        raise no_equilibrium_error(load)
    if is_lifted:
        return Equilibrium(equations.rest_position(p, y, 0.0), y, 0.0, Mode.SEPARATED)
    mode = sliding_mode(p)
    force = contact_force(p, y, mode) + 0.0
    return Equilibrium(equations.rest_position(p, y, mu * force), y, force, mode)


def check_has_verdict(system: System) -> None:
    """Raise `ComputationError` where eigenvalues of the equilibrium decide nothing at any μ."""
    _check_belt_moves(system)
    check_off_edge(system)


def _check_belt_moves(system: System) -> None:
    p = system.parameters
    is_lifted = system.separation and equations.load(p) < 0.0
    if p.v_belt == 0.0 and not is_lifted:
        raise ComputationError(
            "no equilibrium of sliding: the belt is at rest, v_belt = 0, and the slider sticks",
            "use another v_belt",
        )


def check_off_edge(system: System) -> None:
    """Raise `ComputationError` for an equilibrium at y = 0, where contact ends."""
    if is_on_edge(system.parameters, system.separation):
        raise ComputationError(
            "no verdict at F = 0: the equilibrium is at y = 0, where contact ends, and "
            "disturbances leave the belt",
            "use F above 0, or ignore separation",
        )


def is_on_edge(p: Any, separation: Any) -> Any:
    """Whether the equilibrium is at y = 0, where contact ends; arrays give an array.

    The eigenvalues of contact decide nothing there.
    """
    return (equations.load(p) == 0.0) & separation


def resting_height(system: System, mu: float) -> float:
    """Height y of the equilibrium in m; infinite if no spring holds a slider lifted by F < 0."""
    p = system.parameters
    alpha, beta, load = equations.rest_coefficients(p, mu)
    if system.separation and load < 0.0:
        stiffness = equations.suspension_stiffness(p)
        return -load / stiffness if stiffness > 0.0 else math.inf
    y = -load / beta
    if alpha > 0.0:
        # At the root α |y|³ <= |F|, so that |y| is at most 1 or |F|/α.
        bound = max(1.0, abs(load) / alpha)
        y = min(max(y, -bound), bound)
    # Newton's method from beyond the root until |y| stops falling; plain arithmetic gives the same
    # bits everywhere.
    while True:
        y_new = y - (alpha * y * y * y + beta * y + load) / (3.0 * alpha * y * y + beta)
        if not abs(y_new) < abs(y):
            return float(y)
        y = y_new


def no_equilibrium_error(force: float) -> ComputationError:
    """The error for a slider that F < 0 lifts off the belt and no spring holds."""
    return ComputationError(
        f"no equilibrium: F = {force:g} N lifts the slider and no spring holds it vertically",
        "use F >= 0, a larger k3, or ignore separation",
    )


def static_start(system: System) -> State:
    """The state at rest at the equilibrium of μ = 0 under F, before the belt moves."""
    p = system.parameters
    y = resting_height(system, 0.0)
    if not math.isfinite(y):
        raise no_equilibrium_error(equations.load(p))
    return (equations.rest_position(p, y, 0.0), 0.0, y, 0.0)


def static_start_change(system: System, name: str) -> State:
    """The derivative of the static start by a parameter, by the implicit function theorem."""
    p, (_, _, y, _) = system.parameters, static_start(system)
    is_lifted = system.separation and equations.load(p) < 0.0
    perturbed = p.perturbed({name: 1.0})

    def residual(parameters: Parameters, height: complex) -> complex:
        if is_lifted:
            stiffness = equations.suspension_stiffness(parameters)
            return complex(stiffness * height + equations.load(parameters))
        alpha, beta, load = equations.rest_coefficients(parameters, 0.0)
        return complex(alpha * height * height * height + beta * height + load)

    slope = equations.derivative(residual(p, complex(y, equations.DERIVATIVE_STEP)))
    dy = -equations.derivative(residual(perturbed, y)) / slope
    x = equations.rest_position(perturbed, complex(y, dy * equations.DERIVATIVE_STEP), 0.0)
    return (equations.derivative(x), 0.0, dy, 0.0)


def jacobian(p: Parameters, y: float, mode: Mode) -> Matrix:
    """Jacobian (4 × 4, SI units) of the first-order system (Eq. 8) in (x, ẋ, y, ẏ)."""
    # Use a linear contact spring with the tangent stiffness.
    kt = tangent_stiffness(p, y)
    mu, c1 = sliding_coefficients(p, y, mode)
    c = equations.field(p.linearised(k2=kt, mu=mu, c1=c1), mode)
    return (
        (0.0, 1.0, 0.0, 0.0),
        (c.xx, c.xvx, c.xy, 0.0),
        (0.0, 0.0, 0.0, 1.0),
        (c.yx, 0.0, c.yy, c.yvy),
    )


def time_scale(p: Parameters, y: float = 0.0) -> float:
    """√(m/stiffness), s, with all springs in parallel: the scale of step sizes near y, m."""
    return math.sqrt(p.m / (p.k1 + tangent_stiffness(p, y) + p.k3))


def static_deflection(p: Parameters) -> float:
    """|F|/stiffness, m, with all linear springs in parallel: the scale of displacements."""
    return float(abs(equations.load(p)) / equations.total_stiffness(p))
