"""Taylor coefficients of sliding with the friction law μ + (μ_s − μ) exp(−v/v_s).

With v = ±v_r ≥ 0, v_r = v_belt − ẋ, e = exp(−v/v_s) obeys ė = ±(ẍ/v_s) e: a recurrence of its own.
"""

import math
from collections.abc import Sequence
from typing import Any, Final, NamedTuple

from fivtui.model.field import field
from fivtui.model.modes import MODES, Mode
from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import State

from .series import Coefficients

# ln 2 in two parts, the first short enough that its multiples are exact.
_LN2_HIGH: Final = 6.93147180369123816490e-01
_LN2_LOW: Final = 1.90821492927058770002e-10
_LOG2_E: Final = 1.44269504088896338700
_FACTORS: Final = tuple(1.0 / math.factorial(n) for n in range(14))
# Beyond this exponent e is zero, and still far above the least normal number.
_MOST: Final = 700.0
# Over a step v/v_s changes by so much at most, the more the smaller e is. From 37 on e is below
# rounding, and left out where a step keeps so far that this allows a longer one.
_CHANGE: Final = 12.0
_WIDENING: Final = 0.09
_NEGLIGIBLE: Final = 37.0
_FAR: Final = (_NEGLIGIBLE + _CHANGE) / (1.0 - _WIDENING)
_SHRINKING: Final = 0.75


class Law(NamedTuple):
    """The friction law in a mode: sign of the friction, its constant part, its fall, and 1/v_s."""

    sign: float
    mu: float
    fall: float
    per_speed: float


def decay(exponent: Any) -> Any:
    """exp(−exponent) by arithmetic alone, as in C; below zero, by rounding, not beyond −700.

    Of a complex number that carries a derivative, too.
    """
    if isinstance(exponent, complex):
        value = decay(exponent.real)
        return complex(value, -value * exponent.imag)
    if not exponent < _MOST:
        return 0.0
    exponent = max(exponent, -_MOST)
    count = math.floor(0.5 - exponent * _LOG2_E)
    rest = (-exponent - count * _LN2_HIGH) - count * _LN2_LOW
    value = _FACTORS[13]
    for n in range(12, -1, -1):
        value = value * rest + _FACTORS[n]
    return math.ldexp(value, count)


def law_of(p: Parameters, mode: Mode) -> Law | None:
    """The law by which friction falls with the sliding speed; None where it is constant."""
    row = MODES[mode]
    if p.speed_law is None or not row.finite_belt or row.sticks:
        return None
    return Law(row.friction_sign, p.mu, p.mu_static - p.mu, 1.0 / p.speed_law)


def law_coefficients(p: Parameters, mode: Mode, law: Law, state: State, order: int) -> Coefficients:
    """Taylor coefficients of x and of y, `order` + 2 each, in m/sⁿ."""
    given = field(p, mode)
    linear, coupling = -p.k2 / p.m, given.yx
    x, y = [state[0], state[1]], [state[2], state[3]]
    speed = law.sign * ((p.v_belt or 0.0) - state[1])
    e = [decay(speed * law.per_speed)]
    rate = law.sign * law.per_speed
    square: list[float] = []
    force: list[float] = []
    ax: list[float] = []
    for n in range(order):
        square.append(_product(y, y, n))
        force.append(linear * y[n] - given.cubic * _product(y, square, n))
        if n > 0:
            e.append(rate * _product(ax, e, n - 1) / n)
        friction = law.sign * (law.mu * force[n] + law.fall * _product(e, force, n))
        ax.append(friction + given.xx * x[n] + coupling * y[n] + given.xvx * ((n + 1) * x[n + 1]))
        ay = force[n] + coupling * (x[n] - y[n]) + given.yvy * ((n + 1) * y[n + 1])
        share = 1.0 / ((n + 1) * (n + 2))
        x.append(ax[n] * share)
        y.append((ay - given.load if n == 0 else ay) * share)
    return tuple(x), tuple(y)


def _product(a: Sequence[float], b: Sequence[float], n: int) -> float:
    # The n-th coefficient of a product.
    total = 0.0
    for i in range(n + 1):
        total += a[i] * b[n - i]
    return total


def is_far(law: Law, speed: float) -> bool:
    """Whether friction is constant for steps as long as `limited` allows."""
    return speed.real * law.per_speed.real > _FAR


def limited(duration: float, x: Sequence[float], law: Law, speed: float) -> float:
    """The part of a step, s, over which the expansion of e holds, or e stays below rounding.

    `speed` is v at its start.
    """
    exponent = max(speed * law.per_speed, 0.0)
    allowed = max(_CHANGE + _WIDENING * exponent, exponent - _NEGLIGIBLE) / law.per_speed
    while _change(x, duration) > allowed:
        duration *= _SHRINKING
    return duration


def _change(x: Sequence[float], duration: float) -> float:
    # A bound of how much ẋ changes over a step.
    total = 0.0
    for n in range(len(x) - 1, 1, -1):
        total = (total + n * abs(x[n])) * duration
    return total
