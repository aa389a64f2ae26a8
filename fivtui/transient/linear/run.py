"""Transients of linear scenes by the matrix exponential."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import ComputationError, Mode, Progress
from fivtui.transient.request import Request
from fivtui.transient.result import Stats, Transient, build_transient
from fivtui.transient.trajectory import DenseSolution, Trajectory, build_trajectory

from .exponential import DEGREE, LinearMotion, Propagation
from .extremes import Search

# Sample times per progress report.
_TIMES_PER_REPORT: Final = 4096


def is_linear(request: Request) -> bool:
    """Whether the scene is linear: no separation, cubic term, belt speed or changing parameters."""
    system = request.system
    p = system.parameters
    return not system.separation and p.k_nl == 0.0 and p.v_belt is None and not system.over_time


def run(request: Request, work: Progress) -> Transient:
    """Compute the transient of a linear scene; its tolerance is not used.

    The cost grows with the horizon only if the motion neither grows nor decays: then extremes are
    searched over the whole run. `max_steps` limits the number of spans of time searched or stored.
    Rounding errors are as large as the effect of the last digits of the parameters.
    """
    p, t_end = request.parameters, request.t_end
    times = request.times
    motion = LinearMotion(p, t_end)
    start = motion.scaled_state(request.initial)
    propagation = Propagation(motion, p, request.initial)
    first_spans = propagation.advance_to(0.5 * t_end)
    middle_state = propagation.z
    second_spans = propagation.advance_to(t_end)
    # The search accumulates extremes: of the second half first, then of the whole run.
    search = Search(motion, t_end, request.max_steps, work)
    second_half = search.find_extremes(second_spans, propagation.z)
    extremes = search.find_extremes(first_spans, middle_state)
    x, vx, y, vy = motion.states(propagation.z)[0].tolist()
    transient = build_transient(
        request,
        final=(x, vx, y, vy),
        extremes=extremes,
        second_half=second_half,
        switches=np.empty(0),
        separations=0,
        separated_time=0.0,
        stats=Stats(steps=0, kernel="exact"),
        first_mode=Mode.CONTACT,
        trajectory=None if times is None else _trajectory(request, motion, start, times, work),
        solution=_solution(request, motion, start) if request.dense else None,
    )
    work.advance(1.0)
    return transient


def _trajectory(
    request: Request,
    motion: LinearMotion,
    start: NDArray[np.float64],
    times: NDArray[np.float64],
    work: Progress,
) -> Trajectory:
    states = np.empty((times.size, 4))
    for first in range(0, times.size, _TIMES_PER_REPORT):
        # The search for extremes has completed the progress: this only lets the user cancel.
        work.report(1.0)
        chunk = slice(first, first + _TIMES_PER_REPORT)
        states[chunk] = motion.states(motion.states_at(start, times[chunk]))
    x, vx, y, vy = states.T.copy()
    modes = np.full(times.size, Mode.CONTACT, dtype=np.int8)
    return build_trajectory(request.system, times, (x, vx, y, vy), modes)


def _solution(request: Request, motion: LinearMotion, start: NDArray[np.float64]) -> DenseSolution:
    t_end, max_steps, span = request.t_end, request.max_steps, float(motion.spans[motion.base])
    count = math.ceil(t_end / span)
    if count > max_steps:
        raise ComputationError(
            f"the dense solution needs {count} polynomials, more than {max_steps}",
            "use a shorter horizon, or sample times",
        )
    # A polynomial per base span, the longest that a Taylor series covers; the last one ends at the
    # horizon.
    begin: NDArray[np.float64] = np.arange(count, dtype=float) * span
    end = np.minimum(begin + span, t_end)
    duration = end - begin
    series = motion.series(motion.states_at(start, begin))
    powers = (duration / span) ** np.arange(DEGREE + 1)[:, None]
    modes = np.full(count, float(Mode.CONTACT))
    rows = np.stack([begin, np.zeros(count), duration, end, modes], axis=1)
    x, y = series[:, :, 0] * powers, series[:, :, 2] * powers
    return DenseSolution.from_arrays(request.system, rows, x, y)
