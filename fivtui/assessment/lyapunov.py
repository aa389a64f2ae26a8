"""Growth of small errors along a motion, and the largest Lyapunov exponent.

Benettin's method (Meccanica 15, 1980): a deviation from the motion is followed by the variational
equations and scaled to length one at regular intervals. The right-hand side is continuous at
separation and reattachment: deviations do not jump there. They jump where the slider begins to
stick, and where friction jumps, as from μ_s to μ when it begins to slide. Without `v_belt` the belt
is always faster than the slider, which then never sticks. Lengths are measured in (x, ẋ/ω, y, ẏ/ω)
with ω² = (k1 + k2 + k3)/m.
"""

import enum
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from fivtui.model import (
    ComputationError,
    OnProgress,
    Progress,
    State,
    System,
    time_scale,
)
from fivtui.taylor import Seed
from fivtui.transient import Request, compute_variation

# Number of intervals of a run, after each of which the deviation is scaled to length 1.
_INTERVALS: Final = 400
# Over one or two cycles a periodic motion increases a deviation by less than this factor.
_BOUNDED_FACTOR: Final = 1e3
# An error has decayed if its factor at the end is below this.
_DECAYED_FACTOR: Final = 1e-2
# A motion has settled if its size grows at most by this factor from the third quarter to the last.
_SETTLED_RATIO: Final = 1.3
# Least length of a deviation, whose logarithm is finite; greatest logarithm of a growth factor,
# whose exponential is finite.
_LEAST_LENGTH: Final = 1e-300
_MAX_LOG_GROWTH: Final = 700.0


class Fate(enum.StrEnum):
    """Behaviour of a small error in the long run."""

    DECAYS = "decays"
    BOUNDED = "stays bounded"
    SENSITIVE = "grows: sensitive dependence"
    UNBOUNDED = "grows with the motion, which has not settled"
    UNDECIDED = "not settled: use a longer run"


@dataclass(frozen=True, slots=True)
class ErrorGrowth:
    """Growth of small errors along a motion.

    Attributes
    ----------
    exponent : float
        Estimate of the largest Lyapunov exponent, 1/s, over the second half of `duration`.
    uncertainty : float
        Resolution of the exponent, 1/s: a smaller exponent may come from the growth within one or
        two cycles of a periodic motion.
    fate : Fate
        Behaviour of a small error in the long run.
    greatest : float
        Greatest factor of an initial error during the run.
    final : float
        Factor of an initial error at the end of the run.
    duration : float
        Length of the run, s.
    """

    exponent: float
    uncertainty: float
    fate: Fate
    greatest: float
    final: float
    duration: float


def error_growth(request: Request, *, progress: OnProgress | None = None) -> ErrorGrowth:
    """Follow a deviation from a motion over the whole run and measure its growth.

    Uses the Taylor method at the request's tolerance. Raises `ComputationError` if the run cannot
    be finished, and `Cancelled` if `progress`, called with the fraction done, returns False.
    """
    p, system = request.parameters, System(request.parameters, request.separation)
    frequency = 1.0 / time_scale(p)
    interval = request.t_end / _INTERVALS

    def follow_interval(state: State, deviation: State) -> tuple[State, State]:
        # The state and the deviation at the end of an interval.
        try:
            part = Request(system, t_end=interval, tol=request.tol, start=state)
            varied = compute_variation(part, [Seed(deviation)])
        except ComputationError as error:
            begin = (len(sizes) - 1) * interval
            raise ComputationError(
                f"in the interval from t = {begin:.6g} s on: {error.why}", error.advice
            ) from error
        dx, dvx, dy, dvy = varied.derivatives[:, 0].tolist()
        return varied.final, (dx, dvx, dy, dvy)

    def length_of(state: State) -> float:
        x, vx, y, vy = state
        return math.hypot(x, vx / frequency, y, vy / frequency)

    state = request.initial
    deviation: State = (0.5, 0.5 * frequency, 0.5, 0.5 * frequency)
    # Logarithm of the length of the deviation without scaling, and length of the state.
    log_growth, sizes, work = [0.0], [length_of(state)], Progress(progress)
    for count in range(_INTERVALS):
        work.report(count / _INTERVALS)
        state, (dx, dvx, dy, dvy) = follow_interval(state, deviation)
        length = max(length_of((dx, dvx, dy, dvy)), _LEAST_LENGTH)
        log_growth.append(log_growth[-1] + math.log(length))
        deviation = (dx / length, dvx / length, dy / length, dvy / length)
        sizes.append(length_of(state))
    half = _INTERVALS // 2
    duration = request.t_end - half * interval
    late_growth = log_growth[-1] - log_growth[half]
    last_quarter = half + half // 2
    size_ratio = max(sizes[last_quarter:]) / (max(sizes[half:last_quarter]) or 1.0)
    return ErrorGrowth(
        exponent=late_growth / duration,
        uncertainty=math.log(_BOUNDED_FACTOR) / duration,
        fate=_classify(log_growth, late_growth, size_ratio),
        greatest=math.exp(min(max(log_growth), _MAX_LOG_GROWTH)),
        final=math.exp(min(log_growth[-1], _MAX_LOG_GROWTH)),
        duration=request.t_end,
    )


def _classify(log_growth: Sequence[float], late_growth: float, size_ratio: float) -> Fate:
    # `late_growth` is that of the second half of the run; `size_ratio` is the growth of the motion.
    log_bound = math.log(_BOUNDED_FACTOR)
    if log_growth[-1] < math.log(_DECAYED_FACTOR) and late_growth < 0.0:
        return Fate.DECAYS
    if late_growth > log_bound:
        return Fate.UNBOUNDED if size_ratio > _SETTLED_RATIO else Fate.SENSITIVE
    return Fate.BOUNDED if max(log_growth) < 2.0 * log_bound else Fate.UNDECIDED
