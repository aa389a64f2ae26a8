"""Progress of a computation: how much of it is done, and whether it is to stop."""

from collections.abc import Callable

from .errors import Cancelled

# Takes the fraction done, and returns whether to continue.
OnProgress = Callable[[float], bool]


class Progress:
    """The completed fraction of a computation, reported to an optional callback."""

    __slots__ = ("_callback", "_fraction")

    def __init__(self, callback: OnProgress | None) -> None:
        self._callback, self._fraction = callback, 0.0

    def report(self, fraction: float) -> None:
        """Report the fraction done; raise `Cancelled` if the computation is to stop."""
        self._fraction = fraction
        if self._callback is not None and not self._callback(fraction):
            raise Cancelled

    def advance(self, fraction: float) -> bool:
        """Report the fraction done, and return whether to continue."""
        self._fraction = fraction
        return self.go_on()

    def go_on(self) -> bool:
        """Whether to continue, at the fraction last reported."""
        return self._callback is None or self._callback(self._fraction)

    @property
    def callback(self) -> OnProgress | None:
        """The callback to pass to a function; None without a callback."""
        return None if self._callback is None else self.advance

    def part(self, begin: float, end: float) -> "Progress":
        """The progress of a part of the computation, between two fractions of it."""
        if self._callback is None:
            return self
        return Progress(lambda fraction: self.advance(begin + (end - begin) * fraction))

    def check(self) -> None:
        """Raise `Cancelled` if the computation is to stop, at the fraction last reported."""
        if not self.go_on():
            raise Cancelled
