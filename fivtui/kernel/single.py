"""One transient: Taylor steps, switches, exact extremes and samples, in one compiled loop.

Step for step the same as `taylor.stepper` under `transient.recorder`; kept apart from them because
a compiler wants flat data. `c` are the coefficients of x and y, unscaled, one row a degree.
"""

import struct
import sys
from typing import Any, Final, NamedTuple

import numba
import numpy as np

from fivtui.model import slider_belt as model
from fivtui.taylor import (
    EXP2_BIAS,
    LONGEST_STEP,
    MAX_STALLED,
    SHORTEST_FLIGHT,
    Constants,
    polynomial,
    series,
    stepper as taylor,
)

from . import bounds, expansion, linear_tables, polynomials, steps, vectors
from .bounds import RECIPROCAL
from .expansion import ROWS, expand_cubic
from .jit import inner, kernel, part
from .linear_tables import TABLE_SIZE, constants_of, expand_tabulated, tabulate
from .steps import (
    CONTACT,
    EXTREMES,
    NO_EXTREMES,
    SCRATCH,
    at,
    ends_of,
    first_root,
    include,
    include_part,
    is_finite,
    mode_after,
    scale_column,
    settle,
)
from .vectors import LANES, aligned, as_float, as_integer, behind, element, memory, store_pair

# How a call ends. Only the first three can be continued.
DONE: Final = 0
PAUSED: Final = 1
FULL: Final = 2
OVERFLOW: Final = 3
STALLED: Final = 4


class Request(NamedTuple):
    """What is asked, SI units; the constants of both modes follow it."""

    t_end: float
    tol: float
    coupling: float
    preload: float
    deflection: float
    frequency: float
    order: int
    separation: bool
    cubic: bool


class Run(NamedTuple):
    """Where a run has arrived, SI units.

    `switches`, `segments` and `samples` count what waits in the buffers.
    """

    x: float
    vx: float
    y: float
    vy: float
    mode: float
    t: float
    remainder: float
    separated: float
    separated_remainder: float
    stalled: float
    steps: float
    separations: float
    switches: float
    segments: float
    samples: float


# A block holds what is asked, the constants of the modes, where the run is, a row of extremes for
# each half of the horizon, and room to work.
(T_END, TOL, COUPLING, PRELOAD, DEFLECTION, FREQUENCY, ORDER, SEPARATION, CUBIC) = range(
    len(Request._fields)
)
_CONSTANTS: Final = len(Constants._fields)
GIVEN: Final = len(Request._fields)
RUN: Final = GIVEN + 2 * _CONSTANTS
SEEN: Final = RUN + len(Run._fields)
_WORK: Final = SEEN + 2 * len(EXTREMES)
(
    _X,
    _VX,
    _Y,
    _VY,
    _MODE,
    _T,
    _REMAINDER,
    _SEPARATED,
    _SEPARATED_REMAINDER,
    _STALLED,
    _STEPS,
    _SEPARATIONS,
    SWITCHES,
    SEGMENTS,
    _SAMPLES,
) = range(RUN, SEEN)
# Columns of a sample: x, y, ẋ, ẏ, mode and one unused.
SAMPLE_COLUMNS: Final = 6
# Columns of a stored segment before its coefficients in θ = time/duration, those of x first.
SEGMENT_COLUMNS: Final = ("start", "remainder", "duration", "end", "mode")
_HEAD: Final = len(SEGMENT_COLUMNS)
# Beside the scratch of a step there are two series of coefficients, whose groups of rows begin
# behind the first two, and a table for each mode; both aligned.
_FIRST_GROUP: Final = 4
BLOCK_SIZE: Final = _WORK + SCRATCH + 4 * ROWS + 2 * TABLE_SIZE + 3 * LANES
# What a block begins with, and what of it a call changes.
BEGIN: Final = struct.Struct(f"={_WORK}d")
ARRIVED: Final = struct.Struct(f"={_WORK - RUN}d")
RUN_SIZE: Final = len(Run._fields)
RUN_BYTES: Final = 8 * RUN
# Behind the state and the mode of a run.
NOT_BEGUN: Final = (0.0,) * (RUN_SIZE - 5)
NOTHING_SEEN: Final = (*NO_EXTREMES.tolist(), *NO_EXTREMES.tolist())

# Of `rough_exp2` in the bits of a float.
_EXP2_ZERO: Final = (1023 << 52) - round(EXP2_BIAS * 2.0**52)


@part
def step_size(c: Any, degree: int, block: Any) -> float:
    """Length of the next step, s."""
    frequency = block[FREQUENCY]
    displacement = max(abs(c[0]), abs(c[1]), block[DEFLECTION])
    speed = max(abs(c[2]), abs(c[3]), displacement * frequency)
    allowed = block[TOL] * speed
    longest = LONGEST_STEP / frequency
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
    value, slope = at(c, degree, t)
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


_matrix = numba.types.Array(numba.float64, 2, "C")
_row = numba.types.Array(numba.float64, 1, "C")


@kernel(
    numba.int64(_row, _row, _row, _matrix, _matrix, numba.boolean, numba.int64),
    model,
    polynomial,
    series,
    taylor,
    bounds,
    expansion,
    linear_tables,
    polynomials,
    steps,
    vectors,
    sys.modules[inner.__module__],
)
def advance(
    block: Any,
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
    block : ndarray, shape (BLOCK_SIZE,)
        The `Request`, the `Constants` of both modes, and from `RUN` on what is updated: the `Run`,
        and the extremes in the two halves of the horizon.
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
    b = memory(block)
    order, t_end = int(b[ORDER]), b[T_END]
    degree = order + 1
    separation = b[SEPARATION] != 0.0
    scratch = behind(b, _WORK)
    c = behind(aligned(behind(scratch, SCRATCH)), LANES - _FIRST_GROUP)
    for n in range(4 * ROWS):
        c[n] = 0.0
    stage = (0.5 * t_end, behind(b, SEEN), scratch)
    forces, shortest = (b[COUPLING], b[PRELOAD]), SHORTEST_FLIGHT / b[FREQUENCY]
    x, vx, y, vy, mode = b[_X], b[_VX], b[_Y], b[_VY], int(b[_MODE])
    t, remainder = b[_T], b[_REMAINDER]
    switched, stored, sampled = int(b[SWITCHES]), int(b[SEGMENTS]), int(b[_SAMPLES])
    stalled = int(b[_STALLED])
    tables, cubic = aligned(behind(c, 4 * ROWS)), b[CUBIC] != 0.0
    tabulated = True
    for n in range(2):
        if (separation or n == CONTACT) and not (cubic and n == CONTACT):
            constants = behind(b, GIVEN + n * _CONSTANTS)
            tabulated &= tabulate(behind(tables, n * TABLE_SIZE), constants, order, c)
    contact = constants_of(behind(b, GIVEN + CONTACT * _CONSTANTS))
    ending = PAUSED
    for _ in range(budget):
        if switched == switches.size or (dense and stored == segments.shape[0]):
            ending = FULL
            break
        c[0], c[1], c[2], c[3] = x, y, vx, vy
        if cubic and mode == CONTACT:
            expand_cubic(c, contact, order)
        else:
            constants = behind(b, GIVEN + mode * _CONSTANTS)
            expand_tabulated(c, constants, behind(tables, mode * TABLE_SIZE), tabulated, order)
        if y == 0.0 and separation:
            settle(behind(c, 1), 2, x, vx, forces, behind(b, GIVEN + mode * _CONSTANTS), 1)
        h = step_size(c, degree, b)
        ends = ends_of(c, degree, h)
        root = -1.0
        if separation:
            root = first_root(c, degree, h, -1.0 if mode == CONTACT else 1.0, ends, scratch)
            if root >= 0.0:
                h = root
                ends = ends_of(c, degree, h)
        increment = h + remainder
        end = t + increment
        rest = (t - (end - (end - t))) + (increment - (end - t))
        beyond, last = end > t_end, end >= t_end
        if beyond:
            h = (t_end - t) - remainder
            ends = ends_of(c, degree, h)
        x, y = element(ends[0], 0), element(ends[0], 1)
        vx, vy = element(ends[1], 0), element(ends[1], 1)
        if not is_finite(x + y + vx + vy) or h == 0.0:
            x, y, vx, vy = c[0], c[1], c[2], c[3]
            ending = OVERFLOW
            break
        new_mode = mode
        if root >= 0.0 and not beyond:
            y = 0.0
            new_mode = mode_after(x, vx, vy, b[COUPLING], b[PRELOAD])
            if new_mode != mode:
                switches[switched] = end
                switched += 1
                b[_SEPARATIONS] += mode
        here = (t, remainder, min(end, t_end))
        observe(c, degree, h, ends, here, stage)
        if mode != CONTACT:
            part = h + b[_SEPARATED_REMAINDER]
            longer = b[_SEPARATED] + part
            b[_SEPARATED_REMAINDER] = part - (longer - b[_SEPARATED])
            b[_SEPARATED] = longer
        while sampled < times.size and (times[sampled] < end or last):
            row = behind(memory(samples), sampled * SAMPLE_COLUMNS)
            store_sample(c, degree, (times[sampled] - t) - remainder, mode, row)
            sampled += 1
        if dense:
            row = behind(memory(segments), stored * segments.shape[1])
            store_segment(c, degree, h, here, mode, row)
            stored += 1
        b[_STEPS] += 1.0
        stalled = stalled + 1 if end == t or (root >= 0.0 and h < shortest) else 0
        t, remainder, mode = end, rest, new_mode
        if last:
            ending = DONE
            break
        if stalled > MAX_STALLED:
            ending = STALLED
            break
    b[_X], b[_VX], b[_Y], b[_VY], b[_MODE] = x, vx, y, vy, mode
    b[_T], b[_REMAINDER], b[_STALLED] = t, remainder, stalled
    b[SWITCHES], b[SEGMENTS], b[_SAMPLES] = switched, stored, sampled
    return ending
