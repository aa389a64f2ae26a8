"""Which times of a run a film shows, and how fast."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import InputError, Parameters
from fivtui.signals import check_window, last_cycles
from fivtui.transient import Transient

FRAMES_PER_SECOND: Final = 25
# What a film lasts unless window and speed are given, s.
_LASTS: Final = 10.0
_MOST_FRAMES: Final = 1000
# A belt without a speed is drawn moving by this share of the width in a second of the film.
_DRIFT: Final = 0.25


@dataclass(frozen=True, slots=True)
class Timing:
    """Times of the frames of a film.

    Attributes
    ----------
    start, end : float
        What is shown, s.
    speed : float
        Seconds of the motion in a second of the film.
    """

    start: float
    end: float
    speed: float

    @property
    def times(self) -> NDArray[np.float64]:
        """Times of the frames, s."""
        count = math.floor((self.end - self.start) / self.speed * FRAMES_PER_SECOND + 1e-6) + 1
        step = self.speed / FRAMES_PER_SECOND
        times: NDArray[np.float64] = np.minimum(self.start + step * np.arange(count), self.end)
        return times

    def travel(self, p: Parameters, t: float, width: float) -> float:
        """How far the belt has moved at a time, m, in a picture of a width in m."""
        if p.v_belt is not None:
            return p.v_belt * t
        return _DRIFT * width * (t - self.start) / self.speed


def film_timing(run: Transient, window: tuple[float, float] | None, speed: float | None) -> Timing:
    """The times that a film shows.

    Parameters
    ----------
    run : Transient
        The run.
    window : tuple of float or None
        Start and end, s; by default the last eight cycles, or what ten seconds of film show at the
        speed given.
    speed : float or None
        Seconds of the motion in a second of the film; by default the film lasts ten seconds.

    Raises
    ------
    InputError
        If an input is wrong, or the film would have more than 1000 frames.
    """
    if speed is not None and not (math.isfinite(speed) and speed > 0.0):
        raise InputError(f"speed = {speed:g}: must be above 0")
    if window is not None:
        start, end = check_window(run, window)
    elif speed is None:
        start, end = last_cycles(run)
    else:
        start, end = max(run.t_end - _LASTS * speed, 0.0), run.t_end
    if speed is None:
        speed = float(f"{(end - start) / _LASTS:.2g}")
    frames = (end - start) / speed * FRAMES_PER_SECOND
    if frames > _MOST_FRAMES:
        raise InputError(
            f"speed = {speed:g}: {end - start:g} s would take {frames:.0f} frames; must be at most "
            f"{_MOST_FRAMES}: shorten the window or raise the speed"
        )
    return Timing(start, end, speed)


def speed_words(speed: float) -> str:
    """How fast a film is, in words."""
    if speed == 1.0:
        return "real time"
    return f"{speed:g} times real time" if speed > 1.0 else f"slowed down {1.0 / speed:.3g} times"
