"""How far the expansion of a step holds where friction falls with the sliding speed."""

from collections.abc import Sequence
from typing import Final

from fivtui.model.modes import MODES, Mode
from fivtui.model.parameters import Parameters

# Over a step v/v_s changes by so much at most, the more the greater it is. From 37 on its
# exponential is below rounding, and left out where a step keeps so far that this allows a longer
# one.
_CHANGE: Final = 12.0
_WIDENING: Final = 0.09
_NEGLIGIBLE: Final = 37.0
_SHRINKING: Final = 0.75


def shortened_step(duration: float, x: Sequence[float], p: Parameters, mode: Mode) -> float:
    """The part of a step, s, over which the expansion of friction in v/v_s holds.

    `x` has the coefficients of x less those of the belt's motion from the second degree on.
    """
    assert p.v_s is not None  # noqa: S101
    speed = MODES[mode].friction_sign * ((p.v_belt or 0.0) - x[1])
    exponent = max(speed / p.v_s, 0.0)
    allowed = max(_CHANGE + _WIDENING * exponent, exponent - _NEGLIGIBLE) * p.v_s
    while _change(x, duration) > allowed:
        duration *= _SHRINKING
    return duration


def _change(x: Sequence[float], duration: float) -> float:
    # A bound of how much ẋ changes over a step.
    total = 0.0
    for n in range(len(x) - 1, 1, -1):
        total = (total + n * abs(x[n])) * duration
    return total
