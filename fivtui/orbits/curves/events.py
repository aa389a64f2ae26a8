"""Events along curves of limit cycles and Hopf points, and reasons why the curves end."""

from enum import StrEnum
from typing import Final

# Greatest number of points of a curve.
MAX_POINTS: Final = 2000


class EventKind(StrEnum):
    """Kinds of events on a curve of limit cycles or of Hopf points."""

    # Cycles begin or end in the equilibrium.
    HOPF = "hopf"
    # The cycle begins to touch y = 0, where contact is lost.
    TOUCH = "touch"
    # The curve turns back.
    FOLD = "fold"
    # Stability passes to or from a cycle of twice the period, or a torus.
    PERIOD_DOUBLING = "period-doubling"
    TORUS = "torus"
    # Another branch crosses.
    BRANCH = "branch"
    # Two curves of folds meet and end.
    CUSP = "cusp"
    # Hopf points turn from supercritical to subcritical.
    BAUTIN = "bautin"
    # On a belt of finite speed, the cycle begins or ceases to stick.
    STICK = "stick"
    # The cycle begins or ceases to be faster than the belt in contact.
    REVERSE_SLIP = "reverse-slip"
    # The order of the cycle's modes of contact changes (stick, slip forward and backward).
    ORDER = "order-of-modes"


class End(StrEnum):
    """Why a branch or a curve over two parameters ends: each text has the curve as its subject."""

    EQUILIBRIUM = "returns to the equilibrium"
    BOUND = "leaves the range"
    CLOSED = "is closed"
    UNBOUNDED = "grows without bounds"
    LOST = "cannot be followed farther"
    # The greatest ẋ of the cycle just reaches the belt speed. Beyond, no cycle is near it: motion
    # jumps to a distant one.
    JUMPS = "just reaches the speed of the belt, beyond which motion jumps"
    # A stick of the cycle has become so short that it vanishes, with the same effect.
    STICK_ENDS = "has a stick that ends, beyond which motion jumps"
    DOUBLING = "meets cycles of half the period"
    # `Follower.follow` was to stop at such an event; the curve itself goes on.
    EVENT = "reaches an event"
    TOO_LONG = f"has more than {MAX_POINTS} points"
