"""Transients of linear scenes, by the exponential of the matrix: exact, without steps."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import ComputationError, Mode, Progress
from fivtui.transient.request import Request
from fivtui.transient.result import Stats, Transient, assemble
from fivtui.transient.trajectory import DenseSolution, Trajectory, trajectory_of

from .exponential import DEGREE, LinearMotion, Walk
from .extremes import Search

# Sample times per progress report.
_TIMES: Final = 4096


def is_linear(request: Request) -> bool:
    """Whether the scene is linear: no cubic term, separation ignored, a belt that is faster."""
    system = request.system
    p = system.parameters
    return not system.separation and p.k_nl == 0.0 and p.v_belt is None and not system.over_time


def run(request: Request, work: Progress) -> Transient:
    """Compute the transient of a linear scene; its tolerance is not used.

    The cost does not grow with the horizon, except where the motion neither grows nor decays: then
    its extremes are searched for in all of it. `max_steps` limits the spans of time looked at or
    stored. Exact except for rounding errors, as large as the effect of the parameters' last digits.
    """
    p, t_end = request.parameters, request.t_end
    times = request.times
    motion = LinearMotion(p, t_end)
    start = motion.scaled(request.initial)
    walk = Walk(motion, p, request.initial)
    first = walk.to(0.5 * t_end)
    middle = walk.z
    second = walk.to(t_end)
    search = Search(motion, t_end, request.max_steps, work)
    second_half = search.over(second, walk.z)
    extremes = search.over(first, middle)
    x, vx, y, vy = motion.states(walk.z)[0].tolist()
    transient = assemble(
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
    for first in range(0, times.size, _TIMES):
        work.report(1.0)
        part = slice(first, first + _TIMES)
        states[part] = motion.states(motion.at(start, times[part]))
    x, vx, y, vy = states.T.copy()
    contact = np.full(times.size, Mode.CONTACT, dtype=np.int8)
    return trajectory_of(request.parameters, times, (x, vx, y, vy), contact)


def _solution(request: Request, motion: LinearMotion, start: NDArray[np.float64]) -> DenseSolution:
    t_end, max_steps, span = request.t_end, request.max_steps, float(motion.spans[motion.base])
    count = math.ceil(t_end / span)
    if count > max_steps:
        raise ComputationError(
            f"the motion takes {count} polynomials, more than {max_steps}",
            "use a shorter horizon, or ask for samples",
        )
    begin: NDArray[np.float64] = np.arange(count, dtype=float) * span
    end = np.minimum(begin + span, t_end)
    duration = end - begin
    series = motion.series(motion.at(start, begin))
    powers = (duration / span) ** np.arange(DEGREE + 1)[:, None]
    contact = np.full(count, float(Mode.CONTACT))
    rows = np.stack([begin, np.zeros(count), duration, end, contact], axis=1)
    x, y = series[:, :, 0] * powers, series[:, :, 2] * powers
    return DenseSolution.from_arrays(request.parameters, rows, x, y)
