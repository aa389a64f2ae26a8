"""The motion of a run at any time, its period, and windows of time."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import IN_CONTACT, InputError, Mode, total_stiffness
from fivtui.transient import Trajectory, Transient, build_trajectory

FloatArray = NDArray[np.float64]

# Number of cycles in the window of the last cycles.
_LAST_CYCLES: Final = 8
# The period of a run is measured at its end, over at most this many periods 2π √(m/stiffness).
_SEARCHED_PERIODS: Final = 64
_SAMPLES_PER_PERIOD: Final = 64
# A motion is at rest if its displacements vary by less than this fraction of their size.
_REST_TOLERANCE: Final = 1e-9


def motion_at(run: Transient, times: FloatArray) -> Trajectory:
    """The motion of a run at any times, s; interpolated without a dense solution.

    Raises `InputError` if the run has neither a dense solution nor samples.
    """
    if run.solution is not None:
        return run.solution(times)
    if run.trajectory is None:
        raise InputError("samples: the transient has no trajectory; compute it with sample times")
    samples = run.trajectory
    x, vx = _hermite(times, samples.t, samples.x, samples.vx)
    y, vy = _hermite(times, samples.t, samples.y, samples.vy)
    mode = modes_at(run, times)
    return build_trajectory(run.system, times, (x, vx, y, vy), mode)


def modes_at(run: Transient, times: FloatArray) -> NDArray[np.int8]:
    """The mode of the slider at times, s, from the switches of a run."""
    # On a belt that is always faster than the slider, the modes are contact and separation in turn:
    # the run has only the times of its switches.
    if run.mode_changes:
        switch_times = np.array([change.t for change in run.mode_changes])
        modes = [run.first_mode, *(change.then for change in run.mode_changes)]
    else:
        switch_times = run.switch_times
        second_mode = Mode.SEPARATED if run.first_mode in IN_CONTACT else Mode.CONTACT
        modes = [run.first_mode, second_mode] * (switch_times.size // 2 + 1)
    modes_at_times: NDArray[np.int8] = np.array(modes, dtype=np.int8)[
        np.searchsorted(switch_times, times, side="right")
    ]
    return modes_at_times


def _hermite(
    times: FloatArray, t: FloatArray, values: FloatArray, rates: FloatArray
) -> tuple[FloatArray, FloatArray]:
    # Values and rates at `times` by cubic Hermite interpolation between samples at `t`. θ is the
    # time since the sample before, relative to the step between samples, which may be zero.
    before = np.clip(np.searchsorted(t, times, side="right") - 1, 0, max(t.size - 2, 0))
    after = np.minimum(before + 1, t.size - 1)
    step = t[after] - t[before]
    theta = np.divide(times - t[before], step, out=np.zeros_like(times), where=step > 0.0)
    rise = values[after] - values[before]
    start_slope, end_slope = step * rates[before], step * rates[after]
    c2, c3 = 3.0 * rise - 2.0 * start_slope - end_slope, start_slope + end_slope - 2.0 * rise
    value = values[before] + theta * (start_slope + theta * (c2 + theta * c3))
    slope = start_slope + theta * (2.0 * c2 + theta * 3.0 * c3)
    return value, np.divide(slope, step, out=rates[before].copy(), where=step > 0.0)


def is_rest(motion: Trajectory) -> bool:
    """Whether the displacements of a motion are constant, except for rounding."""
    extent = max(float(np.ptp(motion.x)), float(np.ptp(motion.y)))
    return extent <= _REST_TOLERANCE * float(np.abs([motion.x, motion.y]).max())


def period_of(run: Transient) -> float | None:
    """Period of the motion late in a run, s; None at rest and without two crossings.

    It is the mean time between upward crossings of the mean of y.
    """
    p = run.parameters
    linear_period = 2.0 * math.pi * math.sqrt(p.m / total_stiffness(p))
    length = min(0.5 * run.t_end, _SEARCHED_PERIODS * linear_period)
    t = np.linspace(run.t_end - length, run.t_end, _SEARCHED_PERIODS * _SAMPLES_PER_PERIOD)
    motion = motion_at(run, t)
    if is_rest(motion):
        return None
    y = motion.y
    crossings = t[:-1][np.diff(np.sign(y - y.mean())) > 0]
    if crossings.size < 2:
        return None
    return float((crossings[-1] - crossings[0]) / (crossings.size - 1))


def last_cycles(run: Transient) -> tuple[float, float]:
    """Start and end of the last eight cycles of a run, s; of the whole run if it has no more."""
    period = period_of(run)
    length = run.t_end if period is None else min(_LAST_CYCLES * period, run.t_end)
    return run.t_end - length, run.t_end


def check_window(run: Transient, window: tuple[float, float]) -> tuple[float, float]:
    """A window of time, s; `InputError` if it is not within the run."""
    start, end = window
    if not 0.0 <= start < end <= run.t_end:
        raise InputError(
            f"window {start:g}:{end:g}: must be two ascending times from 0 to {run.t_end:g} s"
        )
    return start, end
