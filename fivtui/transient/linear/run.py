"""Transients of linear scenes, by the exponential of the matrix: exact, without steps."""

import math
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Cancelled, ComputationError, Mode
from fivtui.transient.methods import Problem
from fivtui.transient.recorder import Samples, sample_times
from fivtui.transient.result import Stats, Transient, assemble
from fivtui.transient.trajectory import DenseSolution, Trajectory, trajectory_of

from .exponential import DEGREE, LinearMotion, Walk
from .extremes import Search

if TYPE_CHECKING:
    from fivtui.transient.loop import Progress

# Times at which the state is computed between two looks at the progress callback.
_TIMES: Final = 4096


def is_linear(problem: Problem) -> bool:
    """Whether a scene is linear: no cubic term and separation ignored.

    Parameters
    ----------
    problem : Problem
        What is asked.

    Returns
    -------
    bool
        Whether `run` can be asked for it.
    """
    return not problem.separation and problem.parameters.k_nl == 0.0


def run(
    problem: Problem, samples: Samples, max_steps: int, progress: "Progress | None"
) -> Transient:
    """Compute the transient of a linear scene.

    The cost does not grow with the horizon, except where the motion neither grows nor decays: then
    its extremes are searched for in all of it.

    Parameters
    ----------
    problem : Problem
        What is asked, of a linear scene; its tolerance is not used.
    samples : "none", "dense" or sequence of float
        What is kept of the trajectory: nothing, everything, or its values at ascending times, s.
    max_steps : int
        Spans of time that may be looked at, or stored, before the run is given up.
    progress : callable, optional
        Called now and then with the fraction done; the run is cancelled when it returns False.

    Returns
    -------
    Transient
        Exact but for rounding: of the size that changes of the parameters in their last digit have.

    Raises
    ------
    InputError
        If the sample times are wrong.
    ComputationError
        If the motion overflows, or too many spans are needed.
    Cancelled
        If `progress` returned False.
    """
    p, t_end = problem.parameters, problem.t_end
    times = sample_times(samples, t_end)
    motion = LinearMotion(p, t_end)
    start = motion.scaled(problem.start)
    walk = Walk(motion, p, problem.start)
    first = walk.to(0.5 * t_end)
    middle = walk.z
    second = walk.to(t_end)
    report = None if progress is None else _fraction_of(t_end, progress)
    search = Search(motion, max_steps, report)
    second_half = search.over(second, walk.z)
    whole = search.over(first, middle)
    x, vx, y, vy = motion.states(walk.z)[0].tolist()
    dense = isinstance(samples, str) and samples == "dense"
    transient = assemble(
        problem,
        "taylor",
        final=(x, vx, y, vy),
        whole=whole,
        second_half=second_half,
        switches=np.empty(0),
        separations=0,
        separated_time=0.0,
        stats=Stats(steps=0, kernel="exact"),
        first_mode=Mode.CONTACT,
        trajectory=None if times is None else _trajectory(problem, motion, start, times, progress),
        solution=_solution(problem, motion, start, max_steps) if dense else None,
    )
    if progress is not None:
        progress(1.0)
    return transient


def _fraction_of(t_end: float, progress: "Progress") -> "Progress":
    return lambda seconds: progress(min(seconds / t_end, 1.0))


def _trajectory(
    problem: Problem,
    motion: LinearMotion,
    start: NDArray[np.float64],
    times: NDArray[np.float64],
    progress: "Progress | None",
) -> Trajectory:
    states = np.empty((times.size, 4))
    for first in range(0, times.size, _TIMES):
        if progress is not None and not progress(1.0):
            raise Cancelled
        part = slice(first, first + _TIMES)
        states[part] = motion.states(motion.at(start, times[part]))
    x, vx, y, vy = states.T.copy()
    contact = np.full(times.size, Mode.CONTACT, dtype=np.int8)
    return trajectory_of(problem.parameters, times, (x, vx, y, vy), contact)


def _solution(
    problem: Problem, motion: LinearMotion, start: NDArray[np.float64], max_steps: int
) -> DenseSolution:
    t_end, span = problem.t_end, float(motion.spans[motion.base])
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
    return DenseSolution.from_arrays(problem.parameters, rows, x, y)
