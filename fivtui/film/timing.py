"""Time window and speed of a film."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import InputError, time_scale
from fivtui.signals import check_window, last_cycles, period_of
from fivtui.transient import Transient

FRAMES_PER_SECOND: Final = 25
# Default duration of a film, s.
_DURATION: Final = 10.0
# Tolerance for rounding, in frames.
_ROUNDING: Final = 1e-6
_MAX_FRAMES: Final = 1000
# Shortest window with visible motion, relative to √(m/stiffness).
_MIN_WINDOW: Final = 1e-3
# Shortest and longest period shown in real time, s; other periods last `_SHOWN_PERIOD`, s.
_MIN_PERIOD: Final = 0.3
_MAX_PERIOD: Final = 20.0
_SHOWN_PERIOD: Final = 1.3
# Speed of a belt without a speed in the model: fraction of the picture's width per second of film.
_DEFAULT_BELT_SPEED: Final = 0.25


@dataclass(frozen=True, slots=True)
class Timing:
    """Start and end of the motion shown by a film, s, and its speed.

    `speed` is the number of seconds of motion per second of the film.
    """

    start: float
    end: float
    speed: float

    @property
    def times(self) -> NDArray[np.float64]:
        """Times of the frames, s."""
        count = math.floor((self.end - self.start) / self.speed * FRAMES_PER_SECOND + _ROUNDING) + 1
        step = self.speed / FRAMES_PER_SECOND
        times: NDArray[np.float64] = np.minimum(self.start + step * np.arange(count), self.end)
        return times

    def belt_travel(self, run: Transient, t: float, width: float) -> float:
        """Distance that the belt has moved at a time, m; `width` is that of the picture, m."""
        speed_table = run.over_time.get("v_belt")
        if speed_table is not None:
            # The speed is linear between the times of the table. `after` gives speed and slope just
            # after a time, `before` the speed just before it.
            edges = [0.0, *(time for time in speed_table.times if 0.0 < time < t), t]
            return sum(
                0.5 * (speed_table.after(begin)[0] + speed_table.before(end)) * (end - begin)
                for begin, end in pairwise(edges)
            )
        if run.parameters.v_belt is not None:
            return run.parameters.v_belt * t
        return _DEFAULT_BELT_SPEED * width * (t - self.start) / self.speed


def film_timing(run: Transient, window: tuple[float, float] | None, speed: float | None) -> Timing:
    """The window and speed of a film, by default the last cycles in ten seconds.

    Raises `InputError` if the film would have too many frames, no frame or no visible motion.
    """
    if speed is not None and not (math.isfinite(speed) and speed > 0.0):
        raise InputError(f"speed = {speed:g}: must be above 0")
    if window is not None:
        start, end = check_window(run, window)
    elif speed is None:
        start, end = last_cycles(run)
    else:
        start, end = max(run.t_end - _DURATION * speed, 0.0), run.t_end
    if speed is None:
        speed = float(f"{(end - start) / _DURATION:.2g}")
    frames = (end - start) / speed * FRAMES_PER_SECOND
    if frames > _MAX_FRAMES:
        raise InputError(
            f"speed = {speed:g}: {end - start:g} s would take {frames:.0f} frames; must be at most "
            f"{_MAX_FRAMES}: shorten the window or raise the speed"
        )
    if frames < 1.0 - _ROUNDING:
        raise InputError(
            f"speed = {speed:g}: {end - start:g} s are shorter than one frame, "
            f"{1.0 / FRAMES_PER_SECOND:g} s of the film; lengthen the window or lower the speed"
        )
    shortest = _MIN_WINDOW * time_scale(run.parameters)
    if end - start < shortest:
        raise InputError(
            f"window: {end - start:.3g} s show no motion; must be at least {shortest:.2g} s, "
            f"or without a window a speed of at least {shortest / _DURATION:.2g}"
        )
    return Timing(start, end, speed)


def watchable_speed(run: Transient) -> float:
    """A speed at which cycles can be watched: 1 (real time) unless that is too fast or slow."""
    period = period_of(run)
    if period is None or _MAX_PERIOD >= period >= _MIN_PERIOD:
        return 1.0
    return float(f"{period / _SHOWN_PERIOD:.1g}")


def speed_text(speed: float) -> str:
    """The speed of a film as text."""
    if speed == 1.0:
        return "real time"
    return f"{speed:g} times real time" if speed > 1.0 else f"slowed down {1.0 / speed:.3g} times"
