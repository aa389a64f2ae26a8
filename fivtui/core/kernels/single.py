"""One transient: Taylor steps, switches, exact extremes and samples, in one compiled loop.

Step for step the same as `core.taylor` under `core.transient`; kept apart from them because a
compiler wants flat data. `c` are the coefficients of x and y, unscaled, one row a degree.
"""

import sys
from typing import Any, Final, NamedTuple

import numba
import numpy as np

from .. import polynomial, recurrences, taylor
from ..recurrences import Constants
from ..taylor import EXP2_BIAS, LONGEST_STEP, MAX_STALLED
from . import expansion, polynomials, steps, vectors
from .expansion import ROWS, expand_cubic, expand_linear
from .jit import inner, kernel
from .polynomials import WORK_SIZE as POLYNOMIAL_WORK
from .steps import (
    CONTACT,
    EXTREMES,
    NO_EXTREMES,
    RECIPROCAL,
    at,
    first_root,
    include,
    include_part,
    is_finite,
    mode_after,
    scale_column,
)
from .vectors import as_float, as_integer, behind, element, memory, store_pair

# How a call ends. Only the first three can be continued.
DONE: Final = 0
PAUSED: Final = 1
FULL: Final = 2
OVERFLOW: Final = 3
STALLED: Final = 4

PROBLEM: Final = np.dtype(
    [
        ("t_end", "f8"),
        ("half", "f8"),
        ("tol", "f8"),
        ("coupling", "f8"),
        ("preload", "f8"),
        ("deflection", "f8"),
        ("frequency", "f8"),
        ("order", "i8"),
        ("separation", "i8"),
        ("cubic", "i8"),
    ],
    align=True,
)


class Run(NamedTuple):
    """Where a run has arrived, SI units.

    `switches`, `segments` and `samples` count what waits in the buffers.
    """

    x: float
    vx: float
    y: float
    vy: float
    mode: int
    t: float = 0.0
    remainder: float = 0.0
    separated: float = 0.0
    separated_remainder: float = 0.0
    stalled: int = 0
    steps: int = 0
    separations: int = 0
    switches: int = 0
    segments: int = 0
    samples: int = 0


RUN: Final = np.dtype(list(Run.__annotations__.items()), align=True)
# One row of extremes for each half of the horizon.
NOTHING_SEEN: Final = np.tile(NO_EXTREMES, (2, 1))
# Columns of a sample: x, y, ẋ, ẏ, mode and one unused.
SAMPLE_COLUMNS: Final = 6
# Columns of a stored segment before its coefficients in θ = time/duration, those of x first.
SEGMENT_COLUMNS: Final = ("start", "remainder", "duration", "end", "mode")
_HEAD: Final = len(SEGMENT_COLUMNS)
_CONSTANTS: Final = len(Constants._fields)

# Beside polynomials, two series of coefficients are worked on.
WORK_SIZE: Final = POLYNOMIAL_WORK + 4 * ROWS

# Of `rough_exp2` in the bits of a float.
_EXP2_ZERO: Final = (1023 << 52) - round(EXP2_BIAS * 2.0**52)


@inner
def step_size(c: Any, degree: int, problem: Any) -> float:
    """Length of the next step, s."""
    displacement = max(abs(c[0]), abs(c[1]), problem.deflection)
    speed = max(abs(c[2]), abs(c[3]), displacement * problem.frequency)
    allowed = problem.tol * speed
    longest = LONGEST_STEP / problem.frequency
    exponent = np.inf
    reciprocals = memory(RECIPROCAL)
    for n in (degree, degree - 1):
        last = n * max(abs(c[2 * n]), abs(c[2 * n + 1]))
        if last > 0.0 and allowed > 0.0:
            # `rough_log2` is the bits of a float.
            ratio = float(as_integer(allowed) - as_integer(last))
            exponent = min(exponent, ratio * reciprocals[n - 1])
    if exponent == np.inf:
        return longest
    return min(longest, as_float(int(exponent) + _EXP2_ZERO))


@inner
def expand(c: Any, given: Any, mode: int, problem: Any) -> None:
    """Continue the first two coefficients to the order of the problem."""
    constants = behind(given, mode * _CONSTANTS)
    if mode == CONTACT and problem.cubic:
        expand_cubic(c, constants, problem.order)
    else:
        expand_linear(c, constants, problem.order)


@inner
def observe(
    c: Any, degree: int, h: float, ends: Any, here: tuple[float, float, float], stage: Any
) -> None:
    """Take a step into the extremes of the halves of the horizon in which it lies."""
    t, remainder, end = here
    half, extremes, work = stage
    later = behind(extremes, len(EXTREMES))
    if end <= half:
        include(c, degree, h, ends, extremes, work)
    elif t >= half:
        include(c, degree, h, ends, later, work)
    else:
        shifted = behind(c, 2 * ROWS)
        middle = (half - t) - remainder
        include_part(c, degree, 0.0, middle, extremes, work, shifted)
        include_part(c, degree, middle, h, later, work, shifted)


@inner
def store_sample(c: Any, degree: int, t: float, mode: int, row: Any) -> None:
    """Write the state at `t` into a row of samples."""
    value, slope, _, _ = at(c, degree, t)
    store_pair(row, 0, value)
    store_pair(row, 1, slope)
    row[4] = mode


@inner
def store_segment(
    c: Any, degree: int, h: float, here: tuple[float, float, float], mode: int, row: Any
) -> None:
    """Write a segment into a row of segments."""
    t, remainder, end = here
    row[0], row[1], row[2], row[3], row[4] = t, remainder, h, end, mode
    scale_column(c, 0, degree, h, behind(row, _HEAD))
    scale_column(c, 1, degree, h, behind(row, _HEAD + degree + 2))


def segment_columns(order: int) -> int:
    """Columns of the buffer of segments: the coefficients are followed by a zero."""
    return _HEAD + 2 * (order + 3)


_record = numba.from_dtype
_matrix = numba.types.Array(numba.float64, 2, "C")
_row = numba.types.Array(numba.float64, 1, "C")


@kernel(
    numba.int64(
        numba.types.Array(_record(PROBLEM), 1, "C"),
        _matrix,
        numba.types.Array(_record(RUN), 1, "C"),
        _matrix,
        _row,
        _row,
        _row,
        _matrix,
        _matrix,
        numba.boolean,
        numba.int64,
    ),
    polynomial,
    recurrences,
    taylor,
    expansion,
    polynomials,
    steps,
    vectors,
    sys.modules[inner.__module__],
)
def advance(
    problems: Any,
    given: Any,
    runs: Any,
    extremes: Any,
    work: Any,
    switches: Any,
    times: Any,
    samples: Any,
    segments: Any,
    dense: bool,
    budget: int,
) -> int:
    """Go on with a run until it is done, a buffer is full or the budget is spent.

    Parameters
    ----------
    problems : ndarray of PROBLEM, shape (1,)
        What is asked.
    given : ndarray, shape (2, 9)
        The `Constants` of both modes.
    runs : ndarray of RUN, shape (1,)
        Where the run is; updated.
    extremes : ndarray, shape (2, 5)
        Extremes in the two halves of the horizon; updated.
    work : ndarray
        See `polynomials.workspace`.
    switches : ndarray, shape (n,)
        Buffer for the times of switches, s.
    times : ndarray, shape (m,)
        Ascending sample times, s.
    samples : ndarray, shape (m, 6)
        Receives x, y, ẋ, ẏ and mode at those times.
    segments : ndarray, shape (k, segment_columns(order))
        Buffer for the segments.
    dense : bool
        Whether they are stored.
    budget : int
        Steps after which to pause.

    Returns
    -------
    int
        How it ended.
    """
    problem, run = problems[0], runs[0]
    degree, t_end = problem.order + 1, problem.t_end
    scratch = memory(work)
    c = behind(scratch, POLYNOMIAL_WORK)
    for n in range(4 * ROWS):
        c[n] = 0.0
    stage = (problem.half, memory(extremes), scratch)
    t, remainder, mode = run.t, run.remainder, run.mode
    x, vx, y, vy = run.x, run.vx, run.y, run.vy
    ending = PAUSED
    for _ in range(budget):
        if run.switches == switches.size or (dense and run.segments == segments.shape[0]):
            ending = FULL
            break
        c[0], c[1], c[2], c[3] = x, y, vx, vy
        expand(c, memory(given), mode, problem)
        h = step_size(c, degree, problem)
        ends = at(c, degree, h)
        root = -1.0
        if problem.separation:
            root = first_root(c, degree, h, -1.0 if mode == CONTACT else 1.0, ends, scratch)
            if root >= 0.0:
                h *= root
                ends = at(c, degree, h)
        increment = h + remainder
        end = t + increment
        rest = (t - (end - (end - t))) + (increment - (end - t))
        beyond, last = end > t_end, end >= t_end
        if beyond:
            h = (t_end - t) - remainder
            ends = at(c, degree, h)
        x, y = element(ends[0], 0), element(ends[0], 1)
        vx, vy = element(ends[1], 0), element(ends[1], 1)
        if not is_finite(x + y + vx + vy) or h == 0.0:
            x, y, vx, vy = c[0], c[1], c[2], c[3]
            ending = OVERFLOW
            break
        new_mode = mode
        if root >= 0.0 and not beyond:
            y = 0.0
            new_mode = mode_after(x, vx, vy, problem.coupling, problem.preload)
            if new_mode != mode:
                switches[run.switches] = end
                run.switches += 1
                run.separations += mode
        here = (t, remainder, min(end, t_end))
        observe(c, degree, h, ends, here, stage)
        if mode != CONTACT:
            part = h + run.separated_remainder
            longer = run.separated + part
            run.separated_remainder = part - (longer - run.separated)
            run.separated = longer
        while run.samples < times.size and (times[run.samples] < end or last):
            row = behind(memory(samples), run.samples * SAMPLE_COLUMNS)
            store_sample(c, degree, (times[run.samples] - t) - remainder, mode, row)
            run.samples += 1
        if dense:
            row = behind(memory(segments), run.segments * segments.shape[1])
            store_segment(c, degree, h, here, mode, row)
            run.segments += 1
        run.steps += 1
        run.stalled = run.stalled + 1 if end == t else 0
        t, remainder, mode = end, rest, new_mode
        if last:
            ending = DONE
            break
        if run.stalled > MAX_STALLED:
            ending = STALLED
            break
    run.t, run.remainder, run.mode = t, remainder, mode
    run.x, run.vx, run.y, run.vy = x, vx, y, vy
    return ending
