"""Progress of a computation, and its cancellation."""

from collections.abc import Callable

from .errors import Cancelled

# A callback that takes the completed fraction and returns whether to continue.
OnProgress = Callable[[float], bool]


class Progress:
    """The completed fraction of a computation, reported to an optional callback."""

    __slots__ = ("_callback", "_fraction")

    def __init__(self, callback: OnProgress | None) -> None:
        self._callback, self._fraction = callback, 0.0

    def report(self, fraction: float) -> None:
        """Report the completed fraction; raise `Cancelled` if the callback asks to stop."""
        self._fraction = fraction
        if self._callback is not None and not self._callback(fraction):
            raise Cancelled

    def advance(self, fraction: float) -> bool:
        """Like `report`, but return whether to continue, and never raise `Cancelled`."""
        self._fraction = fraction
        return self.should_continue()

    def should_continue(self) -> bool:
        """Repeat the last report, and return whether to continue."""
        return self._callback is None or self._callback(self._fraction)

    @property
    def callback(self) -> OnProgress | None:
        """A callback for nested computations that reports here; None without a callback."""
        return None if self._callback is None else self.advance

    def stage(self, begin: float, end: float) -> "Progress":
        """The progress of a stage, from one fraction of the computation to another."""
        if self._callback is None:
            return self
        return Progress(lambda fraction: self.advance(begin + (end - begin) * fraction))

    def check(self) -> None:
        """Repeat the last report; raise `Cancelled` if the callback asks to stop."""
        if not self.should_continue():
            raise Cancelled
