"""Events along curves of limit cycles and Hopf points, and reasons why the curves end."""

from enum import StrEnum
from typing import Final

# Greatest number of points of a curve.
MAX_POINTS: Final = 2000


class EventKind(StrEnum):
    """Kinds of events on a curve; `BranchEvent` and `BoundaryEvent` explain them."""

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
    """Why a branch or a curve over two parameters ends."""

    EQUILIBRIUM = "returns to the equilibrium"
    BOUND = "leaves the range"
    CLOSED = "is closed"
    UNBOUNDED = "grows without bounds"
    LOST = "cannot be followed farther"
    JUMPS = "just reaches the speed of the belt, beyond which motion jumps"
    STICK_ENDS = "has a stick that ends, beyond which motion jumps"
    DOUBLING = "meets cycles of half the period"
    EVENT = "reaches an event"
    TOO_LONG = f"has more than {MAX_POINTS} points"
