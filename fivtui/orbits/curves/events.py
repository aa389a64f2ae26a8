"""What happens along a curve of limit cycles, and the functions that vanish there."""

from collections.abc import Callable
from enum import StrEnum
from itertools import combinations
from typing import Final

import numpy as np

from .arclength import VALUE, OrbitOnCurve
from .flow import EXTREMES_KEPT, Makeup

MOST_POINTS: Final = 2000
# Derivatives of the parameter along the curve below this are rounding.
_LEVEL: Final = 1e-9
_ON_CIRCLE: Final = 1e-6


class EventKind(StrEnum):
    """What happens at a point of a branch."""

    HOPF = "hopf"
    TOUCH = "touch"
    FOLD = "fold"
    PERIOD_DOUBLING = "period-doubling"
    TORUS = "torus"
    BRANCH = "branch"
    CUSP = "cusp"
    BAUTIN = "bautin"
    STICK = "stick"
    REVERSE_SLIP = "reverse-slip"
    ORDER = "order-of-modes"


class End(StrEnum):
    """Why a branch ends."""

    EQUILIBRIUM = "returns to the equilibrium"
    BOUND = "leaves the range"
    CLOSED = "is closed"
    UNBOUNDED = "grows without bounds"
    LOST = "cannot be followed farther"
    JUMPS = "just reaches the speed of the belt, beyond which motion jumps"
    STICK_ENDS = "has a stick that ends, beyond which motion jumps"
    DOUBLING = "meets cycles of half the period"
    EVENT = "reaches an event"
    LONG = f"has more than {MOST_POINTS} points"


OrbitTest = Callable[[OrbitOnCurve], float]


def touch(orbit: OrbitOnCurve) -> float:
    """Zero where the highest or the lowest point is at y = 0; positive if the cycle crosses it."""
    low, high = orbit.extremes[2:4].tolist()
    return float(-low * high)


def level(orbit: OrbitOnCurve) -> float:
    """The derivative of the parameter along the curve; zero at a fold."""
    change = float(orbit.tangent[VALUE])
    return change if abs(change) > _LEVEL else 0.0


def flip(orbit: OrbitOnCurve) -> float:
    """Zero where a multiplier is -1."""
    return float(np.linalg.det(orbit.monodromy + np.eye(len(orbit.monodromy))))


def pairs(orbit: OrbitOnCurve) -> float:
    """Zero where the product of two multipliers is 1.

    The products are the eigenvalues of the matrix of all minors of two rows and columns.
    """
    rows = orbit.monodromy.tolist()
    chosen = list(combinations(range(len(rows)), 2))
    minors = [
        [rows[i][k] * rows[j][n] - rows[i][n] * rows[j][k] - (i == k and j == n) for k, n in chosen]
        for i, j in chosen
    ]
    return float(np.linalg.det(minors)) if chosen else 1.0


def crossing(orbit: OrbitOnCurve) -> float:
    """Zero where another branch crosses."""
    return orbit.determinant


ORBIT_TESTS: Final[dict[EventKind, OrbitTest]] = {
    EventKind.TOUCH: touch,
    EventKind.FOLD: level,
    EventKind.PERIOD_DOUBLING: flip,
    EventKind.TORUS: pairs,
    EventKind.BRANCH: crossing,
}


# Sticks and gaps to the speed of the belt, relative to period and speed, below which a cycle that
# cannot be followed ends there.
_NO_LONGER: Final = 1e-3


def makeup(orbit: OrbitOnCurve) -> Makeup:
    """What a cycle on a belt of finite speed consists of."""
    return Makeup(*orbit.extremes[EXTREMES_KEPT:].tolist())


def course(orbit: OrbitOnCurve) -> tuple[float, ...]:
    """What changes where the order of modes of a cycle on a belt of finite speed does."""
    made = makeup(orbit)
    return (made.sticks, made.reversals, made.order)


def change_of_course(one: OrbitOnCurve, other: OrbitOnCurve) -> EventKind:
    """What happens between two cycles of different order of modes."""
    first, then = makeup(one), makeup(other)
    if first.sticks != then.sticks:
        return EventKind.STICK
    return EventKind.REVERSE_SLIP if first.reversals != then.reversals else EventKind.ORDER


def why_lost(orbit: OrbitOnCurve) -> End:
    """Why a cycle on a belt of finite speed, the last one found, is not followed farther."""
    made = makeup(orbit)
    if made.least_stick < _NO_LONGER:
        return End.STICK_ENDS
    return End.JUMPS if 0.0 < made.gap < _NO_LONGER else End.LOST


def confirmed(kind: EventKind, orbit: OrbitOnCurve) -> bool:
    """Whether an event is what its test looked for: a product of real multipliers is no torus."""
    if kind is not EventKind.TORUS:
        return True
    values = orbit.multipliers
    turning = values[np.abs(values.imag) > _ON_CIRCLE]
    return bool(turning.size and np.abs(np.abs(turning) - 1.0).min() < _ON_CIRCLE)
