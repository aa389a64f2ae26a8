"""The motion of a run at any time, its period, and windows of time."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import IN_CONTACT, InputError, Mode, spring_force, total_stiffness
from fivtui.transient import Trajectory, Transient

FloatArray = NDArray[np.float64]

# Cycles in the window of the last cycles.
_CYCLES: Final = 8
# The late part of a run in which its period is looked for: as many linear periods, samples each.
_PERIODS: Final = 64
_EACH: Final = 64
# Motion smaller than this, relative to the displacement, is rest.
_ROUNDING: Final = 1e-9


def motion_at(run: Transient, times: FloatArray) -> Trajectory:
    """The motion of a run at any times."""
    if run.solution is not None:
        return run.solution(times)
    if run.trajectory is None:
        raise InputError("samples: the transient has no trajectory; compute it with sample times")
    samples = run.trajectory
    x, vx = _hermite(times, samples.t, samples.x, samples.vx)
    y, vy = _hermite(times, samples.t, samples.y, samples.vy)
    mode = modes_at(run, times)
    force = np.asarray(spring_force(run.parameters, y))
    force[~np.isin(mode, list(IN_CONTACT))] = 0.0
    return Trajectory(times, x, vx, y, vy, force, mode)


def modes_at(run: Transient, times: FloatArray) -> NDArray[np.int8]:
    """The mode of the slider at times, s, from the switches of a run."""
    if run.mode_changes:
        edges = np.array([change.t for change in run.mode_changes])
        modes = [run.first_mode, *(change.then for change in run.mode_changes)]
    else:
        edges = run.switch_times
        second = Mode.SEPARATED if run.first_mode in IN_CONTACT else Mode.CONTACT
        modes = [run.first_mode, second] * (edges.size // 2 + 1)
    at_times: NDArray[np.int8] = np.array(modes, dtype=np.int8)[
        np.searchsorted(edges, times, side="right")
    ]
    return at_times


def _hermite(
    at: FloatArray, t: FloatArray, values: FloatArray, rates: FloatArray
) -> tuple[FloatArray, FloatArray]:
    index = np.clip(np.searchsorted(t, at, side="right") - 1, 0, max(t.size - 2, 0))
    after = np.minimum(index + 1, t.size - 1)
    h = t[after] - t[index]
    s = np.divide(at - t[index], h, out=np.zeros_like(at), where=h > 0.0)
    rise = values[after] - values[index]
    start_slope, end_slope = h * rates[index], h * rates[after]
    bend, twist = 3.0 * rise - 2.0 * start_slope - end_slope, start_slope + end_slope - 2.0 * rise
    value = values[index] + s * (start_slope + s * (bend + s * twist))
    slope = start_slope + s * (2.0 * bend + s * 3.0 * twist)
    return value, np.divide(slope, h, out=rates[index].copy(), where=h > 0.0)


def is_rest(motion: Trajectory) -> bool:
    """Whether a motion is zero to rounding."""
    moves = max(float(np.ptp(motion.x)), float(np.ptp(motion.y)))
    return moves <= _ROUNDING * float(np.abs([motion.x, motion.y]).max())


def period_of(run: Transient) -> float | None:
    """Mean time between upward crossings of the mean of y, late in the run, s; None at rest."""
    p = run.parameters
    linear = 2.0 * math.pi * math.sqrt(p.m / total_stiffness(p))
    length = min(0.5 * run.t_end, _PERIODS * linear)
    t = np.linspace(run.t_end - length, run.t_end, _PERIODS * _EACH)
    motion = motion_at(run, t)
    if is_rest(motion):
        return None
    y = motion.y
    rising = t[:-1][np.diff(np.sign(y - y.mean())) > 0]
    return float(rising[-1] - rising[0]) / (rising.size - 1) if rising.size > 1 else None


def last_cycles(run: Transient) -> tuple[float, float]:
    """Start and end of the last eight cycles of a run, s; of the whole run if it has no more."""
    period = period_of(run)
    length = run.t_end if period is None else min(_CYCLES * period, run.t_end)
    return run.t_end - length, run.t_end


def check_window(run: Transient, window: tuple[float, float]) -> tuple[float, float]:
    """A window of time, s; `InputError` if it is not within the run."""
    start, end = window
    if not 0.0 <= start < end <= run.t_end:
        raise InputError(
            f"window {start:g}:{end:g}: must be two ascending times from 0 to {run.t_end:g} s"
        )
    return start, end
