"""Segments from the states at two times: quintic Hermite interpolation.

For integrators that yield states only. With positions, velocities and accelerations at both ends
the error of the position is of order six in the length of the segment.
"""

from fivtui.model import Mode, Parameters, State, accelerations
from fivtui.taylor import Segment


def segment_between(
    p: Parameters,
    mode: Mode,
    times: tuple[float, float],
    states: tuple[State, State],
    *,
    switches: bool,
) -> Segment:
    """The motion between two states in one mode, as polynomials of degree five.

    Parameters
    ----------
    p : Parameters
        The parameter set, for the accelerations.
    mode : Mode
        The mode between the states.
    times : tuple of float
        Start and end, s; start < end.
    states : tuple of State
        (x, ẋ, y, ẏ) at start and end.
    switches : bool
        Whether the mode changes at the end.
    """
    start, end = times
    duration = end - start
    first, last = states
    ax0, ay0 = accelerations(p, first, mode)
    ax1, ay1 = accelerations(p, last, mode)
    return Segment(
        mode=mode,
        start=start,
        start_remainder=0.0,
        duration=duration,
        end=end,
        x=_quintic(duration, (first[0], first[1], ax0), (last[0], last[1], ax1)),
        y=_quintic(duration, (first[2], first[3], ay0), (last[2], last[3], ay1)),
        final=last,
        switches=switches,
    )


def _quintic(
    h: float, first: tuple[float, float, float], last: tuple[float, float, float]
) -> tuple[float, ...]:
    c0, c1, c2 = first[0], first[1] * h, 0.5 * first[2] * h * h
    position = last[0] - (c0 + c1 + c2)
    velocity = last[1] * h - (c1 + 2.0 * c2)
    acceleration = last[2] * h * h - 2.0 * c2
    return (
        c0,
        c1,
        c2,
        10.0 * position - 4.0 * velocity + 0.5 * acceleration,
        -15.0 * position + 7.0 * velocity - acceleration,
        6.0 * position - 3.0 * velocity + 0.5 * acceleration,
    )
