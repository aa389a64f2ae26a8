"""Errors of a transient, when two runs of it diverge, and tolerances for target errors.

The error of a run is measured against a reference run of the same request, with a finer tolerance.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray

from fivtui.model import ComputationError, Mode, State, jacobian, time_scale as time_scale_of

from .request import TOL_RANGE
from .result import Transient
from .settings.checks import QUANTITIES

# Relative error of a rounded number, 2⁻⁵².
_EPSILON: Final = float(np.finfo(float).eps)
# Least difference of diverging runs: of states relative to the amplitude, of switch times relative
# to √(m/(k1 + k2 + k3)).
MIN_DIVERGENCE: Final = 0.01
# Ratio of a target error to the first tolerance; errors of a run are up to 20 times its tolerance.
_FIRST_TOL_RATIO: Final = 100.0
# Ratio of a tolerance to that of the verifying run, and the least ratio that verifies a run.
_FINER_TOL_RATIO: Final = 100.0
_MIN_TOL_RATIO: Final = 10.0


@dataclass(frozen=True, slots=True)
class Deviation:
    """Errors of a transient.

    Attributes
    ----------
    final : float
        Greatest difference of a component of the final state, relative to the greatest component.
    peak : float
        Difference of the peaks of |y|, relative to that of the reference.
    half_range : float
        Difference of half peak-to-peak over the second half, relative to the peak of |y|.
    events : float
        Greatest difference in the time of a switch, s; infinite if the numbers of switches differ.
    separations : int
        Number of separations less that of the reference.
    sticks : int
        Number of sticks to a belt of finite speed less that of the reference.
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
        errors: dict[str, Any] = {
            name: max(self.of(name), lower_bound.of(name)) for name in QUANTITIES
        }
        return replace(self, **errors)

    def within(self, limit: Self) -> bool:
        """Whether no error exceeds that of `limit`."""
        return all(self.of(name) <= limit.of(name) for name in QUANTITIES)


@dataclass(frozen=True, slots=True)
class Observation:
    """The results of a run that a comparison uses."""

    final: State
    peak: float
    half_range: float
    switch_times: NDArray[np.float64]
    separations: int
    sticks: int = 0


def observation(run: Transient) -> Observation:
    """The results of a transient that a comparison uses."""
    return Observation(
        final=(run.final.x, run.final.vx, run.final.y, run.final.vy),
        peak=run.peak.y_abs,
        half_range=run.steady.y_half_range,
        switch_times=run.switch_times,
        separations=run.events.separations,
        sticks=run.events.sticks,
    )


def deviation(run: Observation, reference: Observation) -> Deviation:
    """Errors of a run against a reference run of the same request."""
    difference = max(abs(a - b) for a, b in zip(run.final, reference.final, strict=True))
    events = math.inf
    if run.switch_times.size == reference.switch_times.size:
        events = float(np.abs(run.switch_times - reference.switch_times).max(initial=0.0))
    return Deviation(
        final=_relative_error(difference, max(map(abs, reference.final))),
        peak=_relative_error(abs(run.peak - reference.peak), reference.peak),
        half_range=_relative_error(abs(run.half_range - reference.half_range), reference.peak),
        events=events,
        separations=run.separations - reference.separations,
        sticks=run.sticks - reference.sticks,
    )


def _relative_error(difference: float, scale: float) -> float:
    if difference == 0.0:
        return 0.0
    return difference / scale if scale > 0.0 else math.inf


def rounding_error(run: Transient) -> Deviation:
    """Rounding errors of a linear scene that the kernel "exact" solves; zero for other runs.

    Runs of a linear scene at two tolerances share them, so that their difference does not show
    them. As the parameters are rounded, the frequency ω has the relative error ε. After a time t
    the phase has the error ω t ε, and the state has that fraction of the vibration as its error.
    """
    _t, *final_state = run.final
    size = max(map(abs, final_state))
    if run.stats.kernel != "exact" or size == 0.0:
        return Deviation(0.0, 0.0, 0.0, 0.0, 0)
    p, omega = run.parameters, 1.0 / time_scale_of(run.parameters)
    # The Jacobian of a linear scene is the same at any y.
    matrix = np.array(jacobian(p, y=0.0, mode=Mode.CONTACT))
    growth_rate = float(np.linalg.eigvals(matrix).real.max())
    # The greatest displacement or velocity; velocities are about ω times displacements.
    amplitude = max(run.peak.x_abs, run.peak.y_abs) * max(1.0, omega)
    # Share of vibration in the final state, and the time for which the vibration stays large.
    share, duration = 1.0, run.t_end
    if growth_rate < 0.0:
        share = min(1.0, math.exp(growth_rate * run.t_end) * amplitude / size)
        duration = min(run.t_end, -1.0 / growth_rate)
    # Rounding of the result, of the greatest amplitude and of the phase.
    final_error = _EPSILON * (1.0 + amplitude / size + omega * run.t_end * share)
    peak_error = _EPSILON * (1.0 + omega * duration)
    return Deviation(final_error, peak_error, peak_error, 0.0, 0)


@dataclass(frozen=True, slots=True)
class Divergence:
    """Time in s from which two runs of the same request differ, and how they differ."""

    t: float
    reason: str

    def error(self) -> ComputationError:
        """The error for a run whose results after this time cannot be verified."""
        return ComputationError(
            f"two runs at different accuracy diverge at t = {self.t:.6g} s: {self.reason}; later "
            "results cannot be verified",
            f"shorten the run to less than {self.t:.6g} s",
        )


def divergence(
    run: Observation, reference: Observation, *, t_end: float, time_scale: float
) -> Divergence | None:
    """The time from which two runs of the same request differ; None if they agree.

    `t_end` is the horizon, s, and `time_scale` is √(m/(k1 + k2 + k3)), s.
    """
    times, reference_times = run.switch_times.tolist(), reference.switch_times.tolist()
    divergence_time = _first_difference(times, reference_times, MIN_DIVERGENCE * time_scale)
    if divergence_time is not None:
        counts = f"{len(times)} and {len(reference_times)} in all"
        return Divergence(divergence_time, f"their switches differ from that time on ({counts})")
    # Velocities times the time scale compare with displacements.
    weights = (1.0, time_scale, 1.0, time_scale)
    triples = list(zip(run.final, reference.final, weights, strict=True))
    difference = max(abs(value - target) * weight for value, target, weight in triples)
    size = max(reference.peak, *(abs(target) * weight for _, target, weight in triples))
    if difference <= MIN_DIVERGENCE * size:
        return None
    return Divergence(t_end, f"their states differ by {difference / size:.1%} of the amplitude")


def _first_difference(
    times: Sequence[float], reference_times: Sequence[float], threshold: float
) -> float | None:
    for time, reference_time in zip(times, reference_times, strict=False):
        if abs(time - reference_time) > threshold:
            return min(time, reference_time)
    count = min(len(times), len(reference_times))
    return next(iter((*times[count:], *reference_times[count:])), None)


def first_tol(errors: Mapping[str, float]) -> float:
    """Tolerance of the first run: a hundredth of the least error, within `TOL_RANGE`."""
    least_error = min(errors.values(), default=TOL_RANGE[1])
    return min(max(least_error / _FIRST_TOL_RATIO, TOL_RANGE[0] * _FINER_TOL_RATIO), TOL_RANGE[1])


def finer_tol(tol: float) -> float:
    """Tolerance of the run that verifies a run of the tolerance `tol`.

    A hundredth of `tol`; if the hundredth is at most ten times the finest tolerance, the finest.
    """
    finer, finest = tol / _FINER_TOL_RATIO, TOL_RANGE[0]
    return finer if finer > _MIN_TOL_RATIO * finest else finest
