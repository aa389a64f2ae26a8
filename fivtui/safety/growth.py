"""Growth of large motions with a linear contact spring, where it does not depend on their size.

With k_nl = 0 the preload is small beside the forces of a large motion. Without it the equations are
homogeneous: a motion times any factor is a motion. Whether large motions grow therefore depends on
μ and on the direction of the state alone, and a motion grows or dies out at a constant rate once
its direction recurs.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.stats.qmc import Sobol

from fivtui.batch import simulate_batch
from fivtui.model import ComputationError, Parameters, State, System, load
from fivtui.orbits import slowest_period
from fivtui.transient import Request, integrate

Floats = NDArray[np.float64]

# Values of μ, and directions per value.
_LEVELS: Final = 32
_DIRECTIONS: Final = 32
# Durations in slowest periods: for directions to settle, and for the measurement of a rate.
_SETTLING: Final = 100.0
_MEASURED: Final = 100.0
_TOL: Final = 1e-8
_MOST_STEPS: Final = 100_000
# Relative accuracy of μ.
_ACCURACY: Final = 1e-7


def least_mu_of_growth(p: Parameters, top: float) -> float | None:
    """The least μ below `top` at which large motions grow without bounds; None without one.

    For a linear contact spring (k_nl = 0) with separation. Motions in 32 directions are followed at
    32 values of μ; between two values the zero of the growth rate is solved for.
    """
    homogeneous = p.with_values({"F": p.F - load(p)})
    levels = top * (np.arange(_LEVELS) + 1.0) / _LEVELS
    starts = _growing_fastest(homogeneous, levels)
    rates = [
        _rate(homogeneous, mu, start) for mu, start in zip(levels.tolist(), starts, strict=True)
    ]
    first = next((index for index, rate in enumerate(rates) if rate > 0.0), None)
    if first is None:
        return None
    low = float(levels[first - 1]) if first else 0.0
    start = starts[first]
    if _rate(homogeneous, low, start) > 0.0:
        return low
    return float(
        brentq(lambda mu: _rate(homogeneous, mu, start), low, levels[first], xtol=_ACCURACY * top)
    )


def _growing_fastest(p: Parameters, levels: Floats) -> list[State]:
    # For each μ the final state of the direction with the greatest growth.
    speed = math.tau / slowest_period(p)
    # Skip the first two points of the sequence, its origin and its centre.
    points = 2.0 * Sobol(4, scramble=False).fast_forward(2).random(_DIRECTIONS) - 1.0
    directions = points / np.linalg.norm(points, axis=1)[:, None] * [1.0, speed, 1.0, speed]
    run = simulate_batch(
        {"mu": np.repeat(levels, _DIRECTIONS)},
        base=p,
        t_end=_SETTLING * slowest_period(p),
        tol=_TOL,
        start=np.tile(directions, (levels.size, 1)),
        require={"final"},
        max_steps=_MOST_STEPS,
    )
    size = np.linalg.norm(run.final / [1.0, speed, 1.0, speed], axis=1)
    # Overflow is the fastest growth.
    size = np.where(np.isfinite(size), size, np.inf).reshape(levels.size, _DIRECTIONS)
    fastest = size.argmax(axis=1)
    ends = run.final.reshape(levels.size, _DIRECTIONS, 4)
    begins = np.where(np.isfinite(ends), ends, directions)
    return [_unit(begins[level, fastest[level]]) for level in range(levels.size)]


def _rate(p: Parameters, mu: float, start: State) -> float:
    # Rate of growth, 1/s, between separations, after the direction has settled.
    at = p.with_values({"mu": mu})
    period = slowest_period(p)
    state = start
    try:
        for duration in (_SETTLING * period, _MEASURED * period):
            request = Request(
                System(at),
                t_end=duration,
                tol=_TOL,
                start=state,
                samples="dense",
                max_steps=_MOST_STEPS,
            )
            run = integrate(request)
            final = run.final
            state = _unit(np.array([final.x, final.vx, final.y, final.vy]))
    except ComputationError:
        # Overflow is growth.
        return math.inf
    assert run.solution is not None  # noqa: S101
    separations = run.switch_times[::2]
    times = separations[[0, -1]] if separations.size > 1 else np.array([0.0, run.t_end])
    states = run.solution(times)
    speed = math.tau / period
    size = np.linalg.norm([states.x, states.vx / speed, states.y, states.vy / speed], axis=0)
    return float(np.log(size[1] / size[0]) / (times[1] - times[0]))


def _unit(state: Floats) -> State:
    x, vx, y, vy = (state / np.abs(state).max()).tolist()
    return (x, vx, y, vy)
