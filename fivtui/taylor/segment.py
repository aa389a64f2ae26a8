"""A segment of the motion in one mode, as polynomials in time; every integrator yields these."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Protocol, Self

from fivtui.model.modes import Mode
from fivtui.model.slider_belt import State

from .series import state_function


@dataclass(frozen=True, slots=True)
class Segment:
    """The motion over [start, end], in one mode.

    Attributes
    ----------
    mode : Mode
        The mode, see `MODES`.
    start, end : float
        Time interval, s.
    start_remainder : float
        Exact start time less `start`, s (compensated summation).
    duration : float
        Length of the interval, s; more precise than end − start.
    x, y : sequence of float
        Coefficients of x and y in θ = (time since the start)/duration, m; equally many.
    final : State
        (x, ẋ, y, ẏ) at the end, m and m/s.
    switches : bool
        Whether the mode changes at the end.
    """

    mode: Mode
    start: float
    start_remainder: float
    duration: float
    end: float
    x: Sequence[float]
    y: Sequence[float]
    final: State
    switches: bool

    def state(self, t: float) -> State:
        """The state (x, ẋ, y, ẏ) in m and m/s at a time t in [start, end], s."""
        if self.duration == 0.0:
            return self.final
        x, vx, y, vy = state_function(len(self.x) - 1)(self.x, self.y, self.fraction(t))
        return (x, vx / self.duration, y, vy / self.duration)

    def fraction(self, t: float) -> float:
        """θ at a time: 0 at the start of the segment, 1 at its end."""
        if self.duration == 0.0:
            return 1.0
        return ((t - self.start) - self.start_remainder) / self.duration


@dataclass(frozen=True, slots=True)
class BeltSegment(Segment):
    """A segment of the motion on a belt of finite speed."""

    then: Mode

    @classmethod
    def of(cls, segment: Segment, then: Mode) -> Self:
        """A segment with the mode after its end."""
        values = {one.name: getattr(segment, one.name) for one in fields(Segment)}
        return cls(**values | {"switches": then is not segment.mode}, then=then)


class Stepper(Protocol):
    """An integrator that returns the motion segment by segment."""

    def advance(self) -> Segment:
        """Compute the next segment, from where the last one ended.

        Raises `ComputationError` if the motion cannot be continued.
        """
        ...
