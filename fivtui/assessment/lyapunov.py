"""Growth of small errors along a motion, and the largest Lyapunov exponent.

Benettin's method (Meccanica 15, 1980): a deviation from the motion is followed by the variational
equations and pulled back to its length at regular intervals. The right-hand side is continuous at
separation and reattachment, where deviations therefore do not jump; on a belt of finite speed they
do where the slider begins to stick, or friction jumps. They are measured in (x, ẋ/ω, y, ẏ/ω),
ω² = (k1 + k2 + k3)/m.
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
from fivtui.transient import Request, vary

_STRETCHES: Final = 400
# A periodic motion stretches a distance by less than this factor over a cycle or two.
_BOUNDED: Final = 1e3
# An error below this at the end has decayed.
_DECAYED: Final = 1e-2
# Growth between the last two quarters above which a motion has not settled.
_GROWTH: Final = 1.3


class Fate(enum.StrEnum):
    """What becomes of a small error in the long run."""

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
        Resolution of the estimate, 1/s: growth within one cycle reaches this.
    fate : Fate
        What becomes of a small error.
    greatest : float
        Greatest factor by which an error at the start grows up to any time of the run.
    final : float
        Factor at the end.
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
    """Follow a deviation from a motion over its length and measure how it grows.

    Uses the Taylor method at the request's tolerance. Raises `ComputationError` if the run cannot
    be finished, and `Cancelled` if `progress`, called with the fraction done, returns False.
    """
    p, system = request.parameters, System(request.parameters, request.separation)
    frequency = 1.0 / time_scale(p)
    stretch = request.t_end / _STRETCHES

    def after(state: State, deviation: State) -> tuple[State, State]:
        try:
            part = Request(system, t_end=stretch, tol=request.tol, start=state)
            varied = vary(part, [Seed(deviation)])
        except ComputationError as error:
            begin = (len(sizes) - 1) * stretch
            raise ComputationError(
                f"in the interval from t = {begin:.6g} s on: {error.why}", error.advice
            ) from error
        dx, dvx, dy, dvy = varied.derivatives[:, 0].tolist()
        return varied.final, (dx, dvx, dy, dvy)

    def size(state: State) -> float:
        x, vx, y, vy = state
        return math.hypot(x, vx / frequency, y, vy / frequency)

    state = request.initial
    deviation: State = (0.5, 0.5 * frequency, 0.5, 0.5 * frequency)
    growth, sizes, work = [0.0], [size(state)], Progress(progress)
    for count in range(_STRETCHES):
        work.report(count / _STRETCHES)
        state, (dx, dvx, dy, dvy) = after(state, deviation)
        length = max(size((dx, dvx, dy, dvy)), 1e-300)
        growth.append(growth[-1] + math.log(length))
        deviation = (dx / length, dvx / length, dy / length, dvy / length)
        sizes.append(size(state))
    half = _STRETCHES // 2
    duration = request.t_end - half * stretch
    gained = growth[-1] - growth[half]
    quarter = half + half // 2
    larger = max(sizes[quarter:]) / (max(sizes[half:quarter]) or 1.0)
    return ErrorGrowth(
        exponent=gained / duration,
        uncertainty=math.log(_BOUNDED) / duration,
        fate=_fate(growth, gained, larger),
        greatest=math.exp(min(max(growth), 700.0)),
        final=math.exp(min(growth[-1], 700.0)),
        duration=request.t_end,
    )


def _fate(growth: Sequence[float], gained: float, larger: float) -> Fate:
    bound = math.log(_BOUNDED)
    if growth[-1] < math.log(_DECAYED) and gained < 0.0:
        return Fate.DECAYS
    if gained > bound:
        return Fate.UNBOUNDED if larger > _GROWTH else Fate.SENSITIVE
    return Fate.BOUNDED if max(growth) < 2.0 * bound else Fate.UNDECIDED
