"""Segments: the motion in one mode over an interval of time, as polynomials in time."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from fivtui.model.modes import IN_CONTACT, Mode
from fivtui.model.slider_belt import State

from .series import state_function


@dataclass(frozen=True, slots=True)
class Segment:
    """The motion over an interval of time in one mode; times in s, displacements in m."""

    mode: Mode
    start: float
    # Exact start time less `start` (compensated summation).
    start_remainder: float
    # Length of the interval, more precise than end − start.
    duration: float
    end: float
    # Coefficients of x and y in θ = (time since the start)/duration, equally many.
    x: Sequence[float]
    y: Sequence[float]
    # (x, ẋ, y, ẏ) at the end.
    final: State
    # The mode after the end.
    next_mode: Mode

    @property
    def switches(self) -> bool:
        """Whether the mode changes at the end."""
        return self.next_mode is not self.mode

    @property
    def lifts_or_lands(self) -> bool:
        """Whether the slider leaves the belt or comes back to it at the end."""
        return (self.mode in IN_CONTACT) is not (self.next_mode in IN_CONTACT)

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


class Stepper(Protocol):
    """An integrator that returns the motion segment by segment."""

    def advance(self) -> Segment:
        """Compute the next segment; it starts at the end of the previous one.

        Raises `ComputationError` if the motion cannot be continued.
        """
        ...
