"""Single runs by the compiled kernel."""

import math
import struct
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .errors import Cancelled
from .extremes import Extremes
from .kernel_loader import KernelLoader
from .methods import Problem
from .model import Mode, mode_of
from .outcome import Stats, Transient, assemble
from .parameters import Parameters
from .recorder import OnSamples, Samples, sample_times
from .recurrences import Constants, Field, constants, field_of
from .stiffness import stiffness_of
from .taylor import local_tolerance, order_for, overflow_error, stall_error
from .trajectory import DenseSolution, Trajectory, trajectory_of
from .transient import Progress, step_limit_error

# Steps between two looks at the progress callback, and at the keyboard if there is none.
_REPORT: Final = 256
_PAUSE: Final = 65536
# Lengths of the buffers; a longer run empties them on its way.
_SWITCHES: Final = 256
_SEGMENTS: Final = 512
# Samples that are handed out together.
_PART: Final = 1024
# Time between two looks at the progress callback while the kernel is being loaded, s.
_WAIT_S: Final = 0.02
# What the kernel is given, as it lies in memory: the problem, the constants of both modes, and how
# a run begins: its state and its mode.
_PROBLEM: Final = struct.Struct("=7d3q")
_GIVEN: Final = struct.Struct(f"={len(Mode) * len(Constants._fields)}d")
_BEGIN: Final = struct.Struct("=4dq")
_NO_TIMES: Final = np.empty(0)

kernels: Final = KernelLoader("single")


def run(
    problem: Problem,
    samples: Samples,
    max_steps: int,
    progress: Progress | None,
    on_samples: OnSamples | None = None,
) -> Transient:
    """Compute a transient with the compiled kernel; waits for it if it is not loaded.

    Parameters
    ----------
    problem : Problem
        What is asked.
    samples : "none", "dense" or sequence of float
        What is kept of the trajectory: nothing, everything, or its values at ascending times, s.
    max_steps : int
        Steps after which the run is given up.
    progress : callable, optional
        Called now and then with the fraction done; the run is cancelled when it returns False.
    on_samples : callable, optional
        See `integrate`.

    Returns
    -------
    Transient
        Agrees with the interpreted kernel to rounding.

    Raises
    ------
    InputError
        If the sample times are wrong.
    ComputationError
        If the run cannot be finished, or the kernel not be loaded.
    Cancelled
        If `progress` returned False.
    """
    single = _loaded(progress)
    p, t_end = problem.parameters, problem.t_end
    order = order_for(local_tolerance(problem.tol))
    first_mode = mode_of(p, problem.start, separation=problem.separation)
    times = sample_times(samples, t_end)
    dense = isinstance(samples, str) and samples == "dense"
    request, given = _asked(problem, single, order)
    where = single.NOT_BEGUN.copy()
    _BEGIN.pack_into(where.data, 0, *problem.start, first_mode)
    halves = single.NOTHING_SEEN.copy()
    work = np.empty(single.WORK_SIZE)
    switches = np.empty(_SWITCHES)
    moments = _NO_TIMES if times is None else times
    states = np.empty((moments.size, single.SAMPLE_COLUMNS))
    segments = np.empty((_SEGMENTS if dense else 0, single.segment_columns(order)))
    switched: list[NDArray[np.float64]] = []
    stored: list[NDArray[np.float64]] = []
    portion = _PAUSE if progress is None and on_samples is None else _REPORT
    reached, steps, given_out, ending = 0.0, 0, 0, single.PAUSED
    while ending != single.DONE:
        if progress is not None and not progress(reached / t_end):
            raise Cancelled
        budget = min(portion, max_steps - steps)
        if budget <= 0:
            raise step_limit_error(max_steps, reached, t_end, stiffness_of(problem))
        ending = single.advance(
            request,
            given,
            where,
            halves,
            work,
            switches,
            moments,
            states,
            segments,
            dense,
            budget,
        )
        here = single.Run(*where.item())
        reached, steps = here.t, here.steps
        if on_samples is not None:
            part = slice(given_out, here.samples)
            given_out = _hand_out(p, moments, states, on_samples, part)
        if ending in (single.DONE, single.FULL):
            switched.append(switches[: here.switches].copy())
            if dense:
                stored.append(segments[: here.segments].copy())
            if ending == single.FULL:
                where["switches"] = where["segments"] = 0
        elif ending != single.PAUSED:
            overflow = ending == single.OVERFLOW
            raise overflow_error(reached, here[:4]) if overflow else stall_error(reached)
    if progress is not None:
        progress(1.0)
    earlier, later = halves.tolist()
    whole, second_half = Extremes.of(*earlier), Extremes.of(*later)
    whole.merge(second_half)
    return assemble(
        problem,
        "taylor",
        final=here[:4],
        whole=whole,
        second_half=second_half,
        switches=switched[0] if len(switched) == 1 else np.concatenate(switched),
        separations=here.separations,
        separated_time=here.separated,
        stats=Stats(steps=steps, kernel="compiled"),
        first_mode=first_mode,
        trajectory=None if times is None else _trajectory(p, times, states),
        solution=_solution(p, np.concatenate(stored), order + 1) if dense else None,
    )


def _loaded(progress: Progress | None) -> Any:
    # The kernels; who can cancel the run need not wait for them.
    while progress is not None and not kernels.wait(_WAIT_S):
        if not progress(0.0):
            raise Cancelled
    return kernels.module()


def _asked(problem: Problem, single: Any, order: int) -> tuple[NDArray[Any], NDArray[np.float64]]:
    # The problem and the constants of both modes as the kernel reads them.
    p, t_end = problem.parameters, problem.t_end
    stiffness = p.k1 + p.k2 + p.k3
    request = np.empty(1, single.PROBLEM)
    _PROBLEM.pack_into(
        request.data,
        0,
        t_end,
        0.5 * t_end,
        local_tolerance(problem.tol),
        0.5 * p.k3,
        p.F,
        abs(p.F) / stiffness,
        1.0 / math.sqrt(p.m / stiffness),
        order,
        problem.separation,
        field_of(p, Mode.CONTACT) is Field.CUBIC,
    )
    given = np.empty((len(Mode), len(Constants._fields)))
    _GIVEN.pack_into(given.data, 0, *constants(p, Mode.SEPARATED), *constants(p, Mode.CONTACT))
    return request, given


def _hand_out(
    p: Parameters,
    moments: NDArray[np.float64],
    states: NDArray[np.float64],
    on_samples: OnSamples,
    part: slice,
) -> int:
    # Gives the next samples away if they are enough; how many are given away then.
    if part.stop - part.start < _PART:
        return int(part.start)
    on_samples(_trajectory(p, moments[part], states[part]))
    return int(part.stop)


def _trajectory(
    p: Parameters, times: NDArray[np.float64], states: NDArray[np.float64]
) -> Trajectory:
    x, y, vx, vy, mode, _ = states.T.copy()
    return trajectory_of(p, times, (x, vx, y, vy), mode.astype(np.int8))


def _solution(p: Parameters, stored: NDArray[np.float64], degree: int) -> DenseSolution:
    head, size = len(kernels.module().SEGMENT_COLUMNS), degree + 1
    x, y = stored[:, head : head + size], stored[:, head + size + 1 : head + 2 * size + 1]
    return DenseSolution.from_arrays(p, stored[:, :head], x.T.copy(), y.T.copy())
