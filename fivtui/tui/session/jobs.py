"""Computations in threads that tell their progress and can be stopped. Imports no Textual."""

import threading
import time
from dataclasses import dataclass, field
from typing import Final

from fivtui.kernel import loader

# The answer to a key never takes longer than that, s; most are on the screen sooner.
_ANSWER: Final = 0.06
# Time between two looks at whether it is there, s.
_LOOK: Final = 0.005


class Precedence:
    """Whose turn it is: that of the screen for a moment after a key, else of whoever computes.

    All share one interpreter. Threads that compute in Python beside the screen would double the
    time that an answer takes.
    """

    def __init__(self) -> None:
        self._until = 0.0

    def claim(self) -> None:
        """A key was pressed: the screen has something to do."""
        self._until = time.monotonic() + _ANSWER

    def release(self) -> None:
        """The answer is on the screen."""
        self._until = 0.0

    @property
    def claimed(self) -> bool:
        """Whether the screen answers a key; what is not part of the answer can wait."""
        return time.monotonic() < self._until

    def give_way(self) -> None:
        """Let the screen go first; called by computing threads between two pieces of work.

        Nobody waits for more than one answer, however many keys are pressed.
        """
        latest = time.monotonic() + _ANSWER
        while time.monotonic() < min(self._until, latest):
            time.sleep(_LOOK)


PRECEDENCE: Final = Precedence()


def progress_words(fraction: float, remaining: float | None) -> str:
    """How far something is, and how long it still takes.

    Parameters
    ----------
    fraction : float
        Part done, 0 to 1.
    remaining : float or None
        Seconds still to go, if known.

    Returns
    -------
    str
        For example ``40 %, 2.5 s left``.
    """
    words = f"{100.0 * fraction:.0f} %"
    return words if remaining is None else f"{words}, {_duration(remaining)} left"


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes:02d} min"
    return f"{minutes} min {rest:02d} s" if minutes else f"{seconds:.1f} s"


def _waits_for_kernels() -> bool:
    return loader.single.awaited or loader.lanes.awaited


@dataclass(eq=False, slots=True)
class Job:
    """A computation under way.

    Attributes
    ----------
    fraction : float
        Part done, 0 to 1; written by the computing thread.
    stopped : bool
        Whether nobody waits for it any more.
    """

    fraction: float = 0.0
    _begin: float = field(default_factory=time.monotonic)
    _stop: threading.Event = field(default_factory=threading.Event)

    def report(self, fraction: float) -> bool:
        """Take note of progress; whether to go on. Called by the computing thread."""
        self.fraction = max(self.fraction, fraction)
        PRECEDENCE.give_way()
        return not self.stopped

    def stop(self) -> None:
        """Let the computing thread know that nobody waits for it any more."""
        self._stop.set()

    @property
    def stopped(self) -> bool:
        """Whether nobody waits for it any more."""
        return self._stop.is_set()

    @property
    def words(self) -> str:
        """How far it is, and how long it still takes; or that it waits for the compiler."""
        if self.fraction == 0.0 and _waits_for_kernels():
            return "compiling, once"
        elapsed, done = time.monotonic() - self._begin, self.fraction
        return progress_words(done, elapsed * (1.0 - done) / done if done > 0.0 else None)
