"""Status codes of the compiled kernel."""

from enum import IntEnum


class Status(IntEnum):
    """How a run, or the transient of a member of a batch, ended.

    Attributes
    ----------
    DONE
        At the horizon.
    OVERFLOW
        The motion exceeded the range of floating-point numbers.
    STALLED
        The motion changed faster than floating-point time resolves.
    STEP_LIMIT
        The run took too many steps.
    NO_START
        F < 0, and there is no equilibrium to start from.
    RUNNING
        The run has not ended.
    UNBOUNDED
        The derivatives of the motion exceed the range of numbers or change too fast.
    """

    DONE = 0
    OVERFLOW = 1
    STALLED = 2
    STEP_LIMIT = 3
    NO_START = 4
    RUNNING = 5
    UNBOUNDED = 6
