"""Growth of large motions with a linear contact spring, at rates independent of their size.

With k_nl = 0 the preload is small compared with the forces of a large motion. Without the preload
the equations are homogeneous: a motion times any factor is a motion. Whether large motions grow
then depends only on μ and on the direction of the state. Once the direction is periodic in time, a
motion grows or dies out at a constant mean rate.
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

# Number of values of μ, and of start directions per value.
_MU_COUNT: Final = 32
_DIRECTION_COUNT: Final = 32
# Durations in slowest periods: until directions have settled, and to measure a growth rate.
_SETTLING_PERIODS: Final = 100.0
_MEASURED_PERIODS: Final = 100.0
_TOL: Final = 1e-8
_MAX_STEPS: Final = 100_000
# Accuracy of the result, relative to the upper limit of μ.
_MU_ACCURACY: Final = 1e-7


def least_growth_mu(p: Parameters, mu_limit: float) -> float | None:
    """The least μ below `mu_limit` at which large motions grow without bounds; None if none grow.

    The contact spring must be linear (k_nl = 0), with separation. Motions in 32 directions are
    followed at 32 values of μ; a root finder gives the zero of the growth rate between two values.
    """
    # The preload at which the load is zero; the load may get further terms, such as a weight.
    without_load = p.with_values({"F": p.F - load(p)})
    mus = mu_limit * (np.arange(_MU_COUNT) + 1.0) / _MU_COUNT
    starts = _fastest_growing_states(without_load, mus)
    rates = [
        _growth_rate(without_load, mu, start)
        for mu, start in zip(mus.tolist(), starts, strict=True)
    ]
    first_growing = next((index for index, rate in enumerate(rates) if rate > 0.0), None)
    if first_growing is None:
        return None
    lower_mu = float(mus[first_growing - 1]) if first_growing else 0.0
    start = starts[first_growing]
    # This motion may grow even at the lower μ, unlike the one followed there: no zero lies between.
    if _growth_rate(without_load, lower_mu, start) > 0.0:
        return lower_mu
    return float(
        brentq(
            lambda mu: _growth_rate(without_load, mu, start),
            lower_mu,
            mus[first_growing],
            xtol=_MU_ACCURACY * mu_limit,
        )
    )


def _fastest_growing_states(p: Parameters, mus: Floats) -> list[State]:
    # For each μ the final state, scaled to size one, of the motion that grows most.
    frequency = math.tau / slowest_period(p)
    units = [1.0, frequency, 1.0, frequency]
    # Skip the first two points of the sequence, a corner and the centre of the cube: the centre has
    # no direction.
    points = 2.0 * Sobol(4, scramble=False).fast_forward(2).random(_DIRECTION_COUNT) - 1.0
    directions = points / np.linalg.norm(points, axis=1)[:, None] * units
    run = simulate_batch(
        {"mu": np.repeat(mus, _DIRECTION_COUNT)},
        base=p,
        t_end=_SETTLING_PERIODS * slowest_period(p),
        tol=_TOL,
        start=np.tile(directions, (mus.size, 1)),
        require={"final"},
        max_steps=_MAX_STEPS,
    )
    sizes = np.linalg.norm(run.final / units, axis=1)
    # Overflow is the fastest growth.
    sizes = np.where(np.isfinite(sizes), sizes, np.inf).reshape(mus.size, _DIRECTION_COUNT)
    fastest = sizes.argmax(axis=1)
    final_states = run.final.reshape(mus.size, _DIRECTION_COUNT, 4)
    states = np.where(np.isfinite(final_states), final_states, directions)
    return [_normalise(states[index, fastest[index]]) for index in range(mus.size)]


def _growth_rate(p: Parameters, mu: float, start: State) -> float:
    # Mean growth rate, 1/s, of a motion whose direction has settled. Measured between switches
    # of one kind, where directions are alike, or over the whole duration if there are no two.
    at_mu = p.with_values({"mu": mu})
    period = slowest_period(p)
    state = start
    try:
        for duration in (_SETTLING_PERIODS * period, _MEASURED_PERIODS * period):
            request = Request(
                System(at_mu),
                t_end=duration,
                tol=_TOL,
                start=state,
                samples="dense",
                max_steps=_MAX_STEPS,
            )
            run = integrate(request)
            final = run.final
            state = _normalise(np.array([final.x, final.vx, final.y, final.vy]))
    except ComputationError:
        # Overflow is growth.
        return math.inf
    assert run.solution is not None  # noqa: S101
    # Every second switch is of the same kind, separation or reattachment.
    same_kind_times = run.switch_times[::2]
    times = same_kind_times[[0, -1]] if same_kind_times.size > 1 else np.array([0.0, run.t_end])
    states = run.solution(times)
    frequency = math.tau / period
    sizes = np.linalg.norm(
        [states.x, states.vx / frequency, states.y, states.vy / frequency], axis=0
    )
    (begin, end), (first_size, last_size) = times, sizes
    return float(np.log(last_size / first_size) / (end - begin))


def _normalise(state: Floats) -> State:
    # The state, scaled so that its greatest component is 1 or -1.
    x, vx, y, vy = (state / np.abs(state).max()).tolist()
    return (x, vx, y, vy)
