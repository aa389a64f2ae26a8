"""Status codes of the compiled kernel."""

from enum import IntEnum


class Status(IntEnum):
    """How the transient of a member of a batch ended.

    Attributes
    ----------
    DONE
        At the horizon.
    OVERFLOW
        The motion left the range of numbers.
    STALLED
        It changed faster than the spacing of time.
    STEP_LIMIT
        It took too many steps.
    NO_START
        F < 0 and no equilibrium to start from.
    RUNNING
        It has not ended.
    UNBOUNDED
        Its derivatives cannot be followed on: they leave the range of numbers or change too fast.
    """

    DONE = 0
    OVERFLOW = 1
    STALLED = 2
    STEP_LIMIT = 3
    NO_START = 4
    RUNNING = 5
    UNBOUNDED = 6
