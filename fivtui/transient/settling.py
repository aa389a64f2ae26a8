"""Whether a run has settled: its amplitude beside that of the motion that follows its end."""

import math
from typing import Final, NamedTuple

from fivtui.model import ComputationError, InputError

from .native import integrate
from .request import Request
from .result import Transient

# Periods that are computed after the end of a run; the amplitude is that of their second half.
_PERIODS: Final = 20
# Change of the amplitude, relative, from which on a run has not settled; amplitudes below this part
# of the peak are at rest.
_LEAST_CHANGE: Final = 0.01
_AT_REST: Final = 1e-6
_TOL: Final = 1e-9
_MAX_STEPS: Final = 20_000


class LaterAmplitude(NamedTuple):
    """Half peak-to-peak of y, m, around so many seconds after the end of a run."""

    y_half_range: float
    after: float


def later_amplitude(result: Transient) -> LaterAmplitude | None:
    """The amplitude after the end of a run that has not settled.

    The motion is followed from the final state for at most 20 periods, and no longer than the run.

    Parameters
    ----------
    result : Transient
        The run.

    Returns
    -------
    LaterAmplitude or None
        None if the amplitude of the second half of the run stays within 1 %, if parameters change
        over time, or if the motion cannot be followed.
    """
    if result.over_time:
        return None
    p, final, before = result.parameters, result.final, result.steady.y_half_range
    period = 2.0 * math.pi * math.sqrt(p.m / (p.k1 + 0.5 * p.k3))
    t_end = min(_PERIODS * period, result.t_end)
    try:
        motion = integrate(
            Request(
                p,
                t_end=t_end,
                tol=_TOL,
                separation=result.separation,
                start=(final.x, final.vx, final.y, final.vy),
                max_steps=_MAX_STEPS,
            )
        )
    except (ComputationError, InputError):
        return None
    later = motion.steady.y_half_range
    greatest = max(before, later)
    if greatest < _AT_REST * result.peak.y_abs or abs(later - before) <= _LEAST_CHANGE * greatest:
        return None
    return LaterAmplitude(later, t_end)
