"""Errors of a transient against a reference transient, and tolerances for target errors."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from fivtui.model import ComputationError, State

from .request import TOL_RANGE
from .result import Transient
from .settings.checks import QUANTITIES


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
    sticks : int
        The same of sticks to a belt of finite speed.
    """

    final: float
    peak: float
    half_range: float
    events: float
    separations: int
    sticks: int = 0

    def of(self, quantity: str) -> float:
        """The error of one of `QUANTITIES`."""
        return float(getattr(self, quantity))

    def at_least(self, lower_bound: Self) -> Self:
        """A copy whose errors are at least those of `lower_bound`."""
        return replace(
            self,
            final=max(self.final, lower_bound.final),
            peak=max(self.peak, lower_bound.peak),
            half_range=max(self.half_range, lower_bound.half_range),
            events=max(self.events, lower_bound.events),
        )

    def within(self, limit: Self) -> bool:
        """Whether no error exceeds that of `limit`."""
        return all(self.of(name) <= limit.of(name) for name in QUANTITIES)


@dataclass(frozen=True, slots=True)
class Observation:
    """The numbers of a run that are compared."""

    final: State
    peak: float
    half_range: float
    switch_times: NDArray[np.float64]
    separations: int
    sticks: int = 0


def observation(run: Transient) -> Observation:
    """The numbers of a transient that are compared."""
    return Observation(
        final=(run.final.x, run.final.vx, run.final.y, run.final.vy),
        peak=run.peak.y_abs,
        half_range=run.steady.y_half_range,
        switch_times=run.switch_times,
        separations=run.events.separations,
        sticks=run.events.sticks,
    )


def deviation(run: Observation, truth: Observation) -> Deviation:
    """Errors of a run against a reference run of the same request."""
    difference = max(abs(a - b) for a, b in zip(run.final, truth.final, strict=True))
    missing = run.switch_times.size != truth.switch_times.size
    late = np.empty(0) if missing else np.abs(run.switch_times - truth.switch_times)
    return Deviation(
        final=_relative(difference, max(map(abs, truth.final))),
        peak=_relative(abs(run.peak - truth.peak), truth.peak),
        half_range=_relative(abs(run.half_range - truth.half_range), truth.peak),
        events=math.inf if missing else float(late.max(initial=0.0)),
        separations=run.separations - truth.separations,
        sticks=run.sticks - truth.sticks,
    )


def _relative(difference: float, size: float) -> float:
    if difference == 0.0:
        return 0.0
    return difference / size if size > 0.0 else math.inf


# Relative threshold for different motions: of the amplitude for states, of √(m/stiffness) for
# switch times.
MIN_DIVERGENCE: Final = 0.01


@dataclass(frozen=True, slots=True)
class Divergence:
    """Time in s at which two runs of the same request part, and the difference found there."""

    t: float
    reason: str

    def error(self) -> ComputationError:
        """The error that refuses to verify numbers after this time."""
        return ComputationError(
            f"two runs at different accuracy part at t = {self.t:.6g} s: {self.reason}; nothing "
            "after that can be verified",
            f"shorten the run to less than {self.t:.6g} s",
        )


def divergence(
    run: Observation, truth: Observation, *, t_end: float, time_scale: float
) -> Divergence | None:
    """The time at which two runs of the same request part; None if they do not."""
    times, truth_times = run.switch_times.tolist(), truth.switch_times.tolist()
    at = _first_difference(times, truth_times, MIN_DIVERGENCE * time_scale)
    if at is not None:
        counts = f"{len(times)} and {len(truth_times)} in all"
        return Divergence(at, f"their switches differ from there on ({counts})")
    weights = (1.0, time_scale, 1.0, time_scale)
    pairs = zip(run.final, truth.final, weights, strict=True)
    difference = max(abs(a - b) * weight for a, b, weight in pairs)
    sizes = (abs(a) * weight for a, weight in zip(truth.final, weights, strict=True))
    size = max(truth.peak, *sizes)
    if difference <= MIN_DIVERGENCE * size:
        return None
    return Divergence(t_end, f"their states differ by {difference / size:.1%} of the amplitude")


def _first_difference(
    times: Sequence[float], truth_times: Sequence[float], allowed: float
) -> float | None:
    for time, truth_time in zip(times, truth_times, strict=False):
        if abs(time - truth_time) > allowed:
            return min(time, truth_time)
    common = min(len(times), len(truth_times))
    return next(iter((*times[common:], *truth_times[common:])), None)


# Ratio of the smallest target error to the first tolerance: errors of a run are up to twenty times
# its tolerance.
_MARGIN: Final = 100.0
_FINER: Final = 100.0
_APART: Final = 10.0


def first_tol(errors: Mapping[str, float]) -> float:
    """Tolerance of the first run: a hundredth of the least error, above the finest tolerance."""
    least = min(errors.values(), default=TOL_RANGE[1])
    return min(max(least / _MARGIN, TOL_RANGE[0] * _FINER), TOL_RANGE[1])


def finer_tol(tol: float) -> float:
    """Tolerance of the run that verifies a run of this tolerance: a hundredth of it.

    It is the finest tolerance if a hundredth is close to it or below: two runs at similar
    tolerances do not verify each other.
    """
    finer, least = tol / _FINER, TOL_RANGE[0]
    return finer if finer > _APART * least else least
