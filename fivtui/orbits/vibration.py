"""Whether motions end in vibration or at rest.

A motion is followed over windows of equal duration. It ends at rest once its decay is proven. It
vibrates if its amplitude, half peak-to-peak of y, is the same in two successive windows: a decaying
motion loses most of its amplitude in a window. Until either is true, it is undecided.
"""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.batch import simulate_batch
from fivtui.kernel import Status
from fivtui.model import ALL_PARAMETERS, OnProgress, Progress
from fivtui.transient import MAX_T_END

from .explorer import UNBOUNDED_EXTENT, Explorer

Floats = NDArray[np.float64]

# Number of windows, and least durations of a window: in slowest periods and in decay times of small
# disturbances. A motion is not followed if a window takes longer than the limit, in periods.
_WINDOWS: Final = 12
_PERIODS: Final = 50.0
_DECAY_TIMES: Final = 5.0
_PERIOD_LIMIT: Final = 20_000.0
# Limit of integration steps of a window, and greatest tolerance.
_MAX_STEPS: Final = 500_000
_TOL: Final = 1e-10
# Relative change of the amplitude between two windows up to which a motion is steady, and least
# amplitude of a vibration in characteristic lengths.
_STEADY_CHANGE: Final = 1e-8
_LEAST_AMPLITUDE: Final = 1e-6


def vibration_flags(
    explorers: Sequence[Explorer],
    starts: Floats,
    *,
    t_end: float,
    tol: float,
    progress: OnProgress | None = None,
) -> Floats:
    """1 for each motion that ends in vibration, 0 for one that ends at rest, NaN if undecided.

    Row n of `starts` is the start of a motion of system n. A window takes `t_end` or longer.
    Unbounded growth is vibration, and so is any motion beside an unstable equilibrium.
    """
    work, states = Progress(progress), starts.copy()
    lengths = np.array([explorer.length for explorer in explorers])
    windows = np.array([_window(explorer, t_end) for explorer in explorers])
    extents = np.array([explorers[n].extent(start) for n, start in enumerate(starts)])
    flags, amplitudes = np.full((2, len(explorers)), np.nan)
    flags[(windows < 0.0) & (extents > 0.0)] = 1.0
    for number in range(_WINDOWS + 1):
        work.report(number / (_WINDOWS + 1))
        for index in np.flatnonzero(np.isnan(flags)).tolist():
            if explorers[index].comes_to_rest(states[index]):
                flags[index] = 0.0
        followed = np.isnan(flags) & (windows > 0.0) & (number < _WINDOWS)
        # Motions with windows of the same duration are one batch.
        for window in np.unique(windows[followed]).tolist():
            members = np.flatnonzero(followed & (windows == window))
            systems = [explorers[index].system for index in members.tolist()]
            run = simulate_batch(
                {
                    name: np.array([getattr(system.parameters, name) for system in systems])
                    for name in ALL_PARAMETERS
                    if getattr(systems[0].parameters, name) is not None
                },
                t_end=window,
                tol=min(tol, _TOL),
                separation=np.array([system.separation for system in systems]),
                start=states[members],
                require={"final", "peak", "steady"},
                max_steps=_MAX_STEPS,
                workers=1,
                progress=lambda _fraction: work.should_continue(),
            )
            amplitude = run.steady.y_half_range
            vibrates = np.abs(amplitude - amplitudes[members]) <= _STEADY_CHANGE * amplitude
            vibrates &= amplitude > _LEAST_AMPLITUDE * lengths[members]
            limits = UNBOUNDED_EXTENT * np.maximum(lengths, extents)[members]
            vibrates |= np.maximum(run.peak.x_abs, run.peak.y_abs) > limits
            flags[members[vibrates | (run.status == Status.OVERFLOW)]] = 1.0
            states[members], amplitudes[members] = run.final, amplitude
            # A run that failed has no final state from which to follow the motion.
            windows[members[run.failed]] = 0.0
    return flags


def _window(explorer: Explorer, t_end: float) -> float:
    # Duration, s: a power of two, so that many motions have the same. 0 if disturbances decay too
    # slowly to be followed, -1 if they grow.
    region, period, decay_time = explorer.decay_region, explorer.slowest_period, 0.0
    if region is not None and region.growth >= 0.0:
        return -1.0 if region.unstable else 0.0
    if region is not None:
        decay_time = -1.0 / region.growth
    duration = max(t_end, _PERIODS * period, _DECAY_TIMES * decay_time)
    if duration > max(t_end, _PERIOD_LIMIT * period):
        return 0.0
    return min(2.0 ** math.ceil(math.log2(duration)), MAX_T_END)
