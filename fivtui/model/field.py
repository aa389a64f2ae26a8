"""The equations of the slider on the belt, for any number type.

The functions take numbers, NumPy arrays, `Fraction`, complex numbers, or any other type with the
operators of arithmetic. `p` has the parameters as attributes of that type, and `mu_static`: μ_s, or
μ if `mu_s` is None. Entries of the stiffness matrix are a = k1 + k3/2 and h = k3/2. Equations are
numbered as in the paper "Nonlinear friction-induced vibration of a slider-belt system".
"""

import math
from typing import Any, Final, NamedTuple, TypeVar

from .modes import MODES, Guard, Mode

# Step s of complex-step derivatives: f(x + i s d) = f(x) + i s f′(x) d to rounding, as s² is
# negligible. A power of two scales without rounding.
DERIVATIVE_STEP: Final = 2.0**-130
# ln 2 in two parts, the first short enough that its multiples are exact.
_LN2_HIGH: Final = 6.93147180369123816490e-01
_LN2_LOW: Final = 1.90821492927058770002e-10
_LOG2_E: Final = 1.44269504088896338700
_EXP_COEFFICIENTS: Final = tuple(1.0 / math.factorial(n) for n in range(14))
# exp(−700) is still far above subnormal numbers.
_MAX_EXPONENT: Final = 700.0

Number = TypeVar("Number")


class Rates(NamedTuple):
    """Rates of change of F, N/s, μ and μ_s, 1/s, and the speed of the belt, m/s²."""

    F: float = 0.0
    mu: float = 0.0
    mu_static: float = 0.0
    v_belt: float = 0.0


CONSTANT: Final = Rates()


class Field(NamedTuple):
    """The coefficients of the equations of motion in a mode, SI units.

    A factor is named after the acceleration, ẍ or ÿ, and what it multiplies: `xy` is the factor of
    y in ẍ, and `xvx` that of ẋ in ẍ. Then follow the signed friction coefficient, k_nl/m, and the
    downward load divided by the mass.
    """

    xx: Any
    xy: Any
    yx: Any
    yy: Any
    xvx: Any
    yvy: Any
    friction: Any
    cubic: Any
    load: Any


def derivative(value: Any) -> float:
    """The derivative in the imaginary part of a complex number, see `DERIVATIVE_STEP`."""
    slope: float = value.imag / DERIVATIVE_STEP
    return slope


def load(p: Any) -> Any:
    """Downward force on the slider, N."""
    return p.F


def spring_force(p: Any, y: Number) -> Number:
    """Force of the contact spring in N: P of Eq. 1, whether in contact or not."""
    force: Number = -p.k2 * y - p.k_nl * y * y * y
    return force


def tangent_stiffness(p: Any, y: Number) -> Number:
    """Tangent contact stiffness k_t = k2 + 3 k_nl y² in N/m."""
    stiffness: Number = p.k2 + 3 * p.k_nl * y * y
    return stiffness


def tangent_slope(p: Any, y: Number) -> Number:
    """Derivative of `tangent_stiffness` by y in N/m²."""
    slope: Number = 6 * p.k_nl * y
    return slope


def horizontal_acceleration(p: Any, x: Any, vx: Any, y: Any, friction: Any) -> Any:
    """ẍ in m/s² under a friction force in N (Eqs. 2 and 5)."""
    return (friction - p.c1 * vx - p.k1 * x - coupling_stiffness(p) * (x - y)) / p.m


def vertical_acceleration(p: Any, x: Any, y: Any, vy: Any, force: Any) -> Any:
    """ÿ in m/s² under the force P − F, N (Eqs. 2 and 5)."""
    return (force - p.c2 * vy + coupling_stiffness(p) * (x - y)) / p.m


def coupling_stiffness(p: Any) -> Any:
    """Stiffness h = k3/2 in N/m that couples x and y."""
    return p.k3 / 2


def horizontal_stiffness(p: Any) -> Any:
    """Stiffness a = k1 + h of the horizontal motion in N/m."""
    return p.k1 + coupling_stiffness(p)


def holding_force(p: Any, x: Any, y: Any, rates: Rates = CONSTANT) -> Any:
    """Friction force f = c1 v_belt + m v̇_belt + a x − h y in N on a slider that sticks.

    It gives the slider the acceleration of the belt.
    """
    drive = p.c1 * (p.v_belt or 0.0) + p.m * rates.v_belt
    return drive + horizontal_stiffness(p) * x - coupling_stiffness(p) * y


def holding_force_rate(p: Any, acceleration: Any, vx: Any, vy: Any) -> Any:
    """Derivative of `holding_force` by time, N/s, on a belt of constant acceleration, m/s²."""
    return p.c1 * acceleration + horizontal_stiffness(p) * vx - coupling_stiffness(p) * vy


def holding_force_size(p: Any, x: float, y: float, rates: Rates = CONSTANT) -> float:
    """Sum of the absolute terms of `holding_force`, N, to which its rounding error is relative."""
    drive = abs(p.c1 * (p.v_belt or 0.0)) + abs(p.m * rates.v_belt)
    size: float = drive + abs(horizontal_stiffness(p) * x) + abs(coupling_stiffness(p) * y)
    return size


def friction_coefficient(p: Any, speed: Any) -> Any:
    """The friction coefficient μ + (μ_s − μ) exp(−v/v_s) at a sliding speed v ≥ 0, m/s."""
    if p.mu_s is None or p.v_s is None:
        return p.mu
    return p.mu + (p.mu_static - p.mu) * exponential(-speed / p.v_s)


def friction_slope(p: Any, speed: Any) -> Any:
    """The derivative of the friction coefficient by a sliding speed v ≥ 0, s/m."""
    return derivative(friction_coefficient(p, speed + complex(0.0, DERIVATIVE_STEP)))


def friction_derivatives(p: Any, speed: float, order: int) -> tuple[float, ...]:
    """The friction coefficient μ and its derivatives μ′, μ″, … by a sliding speed v ≥ 0, m/s.

    There are `order` derivatives, at least one.
    """
    # Imported late: the Python FMU contains a copy of this module, but not of `power_series`.
    from .power_series import PowerSeries

    friction = friction_coefficient(p, PowerSeries.variable(speed, order))
    if isinstance(friction, PowerSeries):
        return friction.derivatives()
    return (friction, *[0.0] * order)


def depends_on_speed(p: Any) -> bool:
    """Whether friction depends on the sliding speed: μ′ or μ″ at speed zero is not zero.

    A law other than the exponential one may begin with μ′ = 0.
    """
    return any(friction_derivatives(p, 0.0, 2)[1:])


def sliding_friction(p: Any, vx: Any, force: Any, mode: Mode) -> Any:
    """Friction force on a slider that slides, N, under a contact force, N."""
    if p.v_belt is None or mode is Mode.SEPARATED:
        return p.mu * force
    sign = MODES[mode].friction_sign
    speed = sign * (p.v_belt - vx)
    if isinstance(speed, float | complex) and speed.real < 0.0:
        # Negative by rounding: set to zero.
        speed = 0.0 * speed
    return sign * friction_coefficient(p, speed) * force


def guard_value(p: Any, state: Any, guard: Guard, rates: Rates = CONSTANT) -> Any:
    """Value of a guard, positive while its mode lasts; in m, m/s or N."""
    x, vx, y, _ = state
    if guard is Guard.HEIGHT or guard is Guard.DEPTH:
        return y if guard is Guard.HEIGHT else -y
    if guard is Guard.BELT_FASTER or guard is Guard.BELT_SLOWER:
        v_r = (p.v_belt or 0.0) - vx
        return v_r if guard is Guard.BELT_FASTER else -v_r
    grip, holding = p.mu_static * spring_force(p, y), holding_force(p, x, y, rates)
    return grip - holding if guard is Guard.HELD_FORWARD else grip + holding


def field(p: Any, mode: Mode) -> Field:
    """The coefficients of the motion in a mode.

    If friction depends on the speed, `friction` and `xy` have its constant part.
    """
    row = MODES[mode]
    k2, k_nl = (p.k2, p.k_nl) if row.in_contact else (0.0, 0.0)
    friction = row.friction_sign * p.mu
    # A factor is the acceleration where its variable is 1 and the others are 0. The linear contact
    # force is −k2 at y = 1.
    yx = vertical_acceleration(p, 1.0, 0.0, 0.0, 0.0)
    yy = vertical_acceleration(p, 0.0, 1.0, 0.0, -k2)
    yvy = vertical_acceleration(p, 0.0, 0.0, 1.0, 0.0)
    xx = xy = xvx = 0.0
    if not row.sticks:
        xx = horizontal_acceleration(p, 1.0, 0.0, 0.0, 0.0)
        xy = horizontal_acceleration(p, 0.0, 0.0, 1.0, friction * -k2)
        xvx = horizontal_acceleration(p, 0.0, 1.0, 0.0, 0.0)
    return Field(xx, xy, yx, yy, xvx, yvy, friction, k_nl / p.m, load(p) / p.m)


def rest_coefficients(p: Any, mu: Any) -> tuple[Any, Any, Any]:
    """α, β and the load of the cubic α y³ + β y + load = 0 of the equilibrium in contact (Eq. 6).

    x is eliminated; `rest_position` returns it.
    """
    friction = 1.0 + mu * coupling_stiffness(p) / horizontal_stiffness(p)
    return friction * p.k_nl, friction * p.k2 + suspension_stiffness(p), load(p)


def suspension_stiffness(p: Any) -> Any:
    """Stiffness h k1/a in N/m of k1 and k3 against y, if x = h y/a is at rest without friction."""
    return coupling_stiffness(p) * p.k1 / horizontal_stiffness(p)


def rest_position(p: Any, y: Any, friction: Any) -> Any:
    """Displacement x in m of a slider at rest at y under a friction force, N."""
    return (coupling_stiffness(p) * y + friction) / horizontal_stiffness(p)


def flutter_boundary(p: Any, kt: Number) -> Number:
    """The value of μ h k_t in N²/m² above which the equilibrium is unstable (Routh–Hurwitz).

    Without damping it is the limit for c1 = c2 → 0.
    """
    h, a, share = coupling_stiffness(p), horizontal_stiffness(p), damping_share(p)
    detuning = kt + h - a
    detuning_term = share * (1.0 - share) * detuning * detuning
    boundary: Number = detuning_term + h * h + (a + share * detuning) * p.c1 * p.c2 / p.m
    return boundary


def flutter_boundary_slope(p: Any, kt: Number) -> Number:
    """Derivative of `flutter_boundary` by k_t, N/m."""
    share = damping_share(p)
    detuning = kt + coupling_stiffness(p) - horizontal_stiffness(p)
    slope: Number = 2.0 * (share * (1.0 - share)) * detuning + share * p.c1 * p.c2 / p.m
    return slope


def total_stiffness(p: Any) -> Any:
    """Stiffness of all linear springs in parallel, N/m: scale of frequencies and deflections."""
    return p.k1 + p.k2 + p.k3


def damping_share(p: Any) -> Any:
    """c1/(c1 + c2), and 1/2 without damping."""
    damping = p.c1 + p.c2
    # A truth value, or an array of them, counts as 0 or 1.
    is_undamped = damping == 0.0
    return (p.c1 + 0.5 * is_undamped) / (damping + is_undamped)


def exponential(exponent: Any) -> Any:
    """The exponential function by arithmetic alone, with the same bits on every machine and in C.

    It is zero up to −700, and at most exp(700). It takes complex numbers with a derivative in the
    imaginary part, and types with a method `exp`, too.
    """
    if isinstance(exponent, complex):
        size = exponential(exponent.real)
        return complex(size, size * exponent.imag)
    if not isinstance(exponent, int | float):
        return exponent.exp()
    if not exponent > -_MAX_EXPONENT:
        return 0.0
    exponent = min(exponent, _MAX_EXPONENT)
    power = math.floor(0.5 + exponent * _LOG2_E)
    remainder = (exponent - power * _LN2_HIGH) - power * _LN2_LOW
    value = 0.0
    for coefficient in reversed(_EXP_COEFFICIENTS):
        value = value * remainder + coefficient
    return math.ldexp(value, power)
