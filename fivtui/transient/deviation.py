"""How far one transient is from another: the error of a number, when the other is the truth."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from fivtui.model.slider_belt import State

from .result import Transient

# What has an error, and in which measure.
QUANTITIES: Final[Mapping[str, str]] = {
    "final": "state at the end, relative to its greatest component",
    "peak": "peak of |y|, relative",
    "half_range": "half peak-to-peak of y over the second half of the run, relative to peak |y|",
    "events": "times of separation and reattachment, s",
}


@dataclass(frozen=True, slots=True)
class Deviation:
    """Errors of a transient.

    Attributes
    ----------
    final : float
        Greatest difference of a component of the final state, relative to the greatest component.
    peak : float
        Difference of the peak of |y|, relative to it.
    half_range : float
        Difference of half peak-to-peak over the second half, relative to the peak of |y|.
    events : float
        Greatest difference in the time of a switch, s; infinite if their numbers differ.
    separations : int
        Separations too many (positive) or missing (negative).
    """

    final: float
    peak: float
    half_range: float
    events: float
    separations: int

    def of(self, quantity: str) -> float:
        """The error of one of `QUANTITIES`."""
        return float(getattr(self, quantity))

    def within(self, other: Self) -> bool:
        """Whether no error is greater than another's."""
        return all(self.of(name) <= other.of(name) for name in QUANTITIES)


@dataclass(frozen=True, slots=True)
class Observation:
    """What of a run is compared.

    Attributes
    ----------
    final : tuple of four floats
        (x, ẋ, y, ẏ) at the horizon, m and m/s.
    peak : float
        Peak of |y|, m.
    half_range : float
        Half peak-to-peak of y over the second half of the run, m.
    switch_times : ndarray, shape (n,)
        Times of all switches, s.
    separations : int
        How many of them left the belt.
    """

    final: State
    peak: float
    half_range: float
    switch_times: NDArray[np.float64]
    separations: int


def observation(run: Transient) -> Observation:
    """What of a transient is compared.

    Parameters
    ----------
    run : Transient
        Any transient.

    Returns
    -------
    Observation
        Its final state, peak, half peak-to-peak and switches.
    """
    return Observation(
        final=(run.final.x, run.final.vx, run.final.y, run.final.vy),
        peak=run.peak.y_abs,
        half_range=run.steady.y_half_range,
        switch_times=run.switch_times,
        separations=run.events.separations,
    )


def deviation(run: Observation, truth: Observation) -> Deviation:
    """Compare a run with a better one of the same problem.

    Parameters
    ----------
    run : Observation
        Of the run to be judged.
    truth : Observation
        What it is held against.

    Returns
    -------
    Deviation
        Its errors.
    """
    apart = max(abs(a - b) for a, b in zip(run.final, truth.final, strict=True))
    missing = run.switch_times.size != truth.switch_times.size
    late = np.empty(0) if missing else np.abs(run.switch_times - truth.switch_times)
    return Deviation(
        final=_relative(apart, max(map(abs, truth.final))),
        peak=_relative(abs(run.peak - truth.peak), truth.peak),
        half_range=_relative(abs(run.half_range - truth.half_range), truth.peak),
        events=math.inf if missing else float(late.max(initial=0.0)),
        separations=run.separations - truth.separations,
    )


def _relative(difference: float, size: float) -> float:
    if difference == 0.0:
        return 0.0
    return difference / size if size > 0.0 else math.inf
