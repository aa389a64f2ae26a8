"""A piece of the motion in one mode, as polynomials in time: what every integrator yields."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from fivtui.model.slider_belt import Mode, State

from .series import state_function


@dataclass(frozen=True, slots=True)
class Segment:
    """The motion over [start, end], in one mode.

    Attributes
    ----------
    mode : Mode
        The field that governs it.
    start, end : float
        Time interval, s.
    start_remainder : float
        What `start` lacks of the exact start time, s (compensated summation).
    duration : float
        Length of the interval, s; more precise than end − start.
    x, y : sequence of float
        Coefficients of x and y in θ = (time since the start)/duration, m; equally many.
    final : State
        (x, ẋ, y, ẏ) at the end, m and m/s.
    switches : bool
        Whether the mode changes at the end: separation (from contact) or reattachment.
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
        """Dense output.

        Parameters
        ----------
        t : float
            Time in [start, end], s.

        Returns
        -------
        State
            (x, ẋ, y, ẏ) in m and m/s.
        """
        if self.duration == 0.0:
            return self.final
        x, vx, y, vy = state_function(len(self.x) - 1)(self.x, self.y, self.fraction(t))
        return (x, vx / self.duration, y, vy / self.duration)

    def fraction(self, t: float) -> float:
        """θ of a time: 0 at the start of the segment, 1 at its end."""
        if self.duration == 0.0:
            return 1.0
        return ((t - self.start) - self.start_remainder) / self.duration


class Stepper(Protocol):
    """An integrator: something that yields the motion segment after segment."""

    def advance(self) -> Segment:
        """Compute the next segment.

        Returns
        -------
        Segment
            It begins where the last one ended.

        Raises
        ------
        ComputationError
            If the motion cannot be continued.
        """
        ...
