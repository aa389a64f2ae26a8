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
from . import expansion, polynomials, vectors
from .expansion import ROWS, expand_cubic, expand_linear
from .jit import inner, kernel
from .polynomials import CALLER, PRECISE, refine, sign_roots, widen
from .polynomials import WORK_SIZE as POLYNOMIAL_WORK
from .vectors import (
    absolute,
    as_float,
    as_integer,
    behind,
    bits,
    element,
    greatest,
    least,
    load_pair,
    memory,
    store_pair,
)

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
EXTREMES: Final = ("x_min", "y_min", "x_max", "y_max", "vx_max")
NOTHING_SEEN: Final = np.tile([np.inf, np.inf, -np.inf, -np.inf, -np.inf], (2, 1))
_VX_MAX: Final = 4
# Columns of a sample: x, y, ẋ, ẏ, mode and one unused.
SAMPLE_COLUMNS: Final = 6
# Columns of a stored segment before its coefficients in θ = time/duration, those of x first.
SEGMENT_COLUMNS: Final = ("start", "remainder", "duration", "end", "mode")
_HEAD: Final = len(SEGMENT_COLUMNS)
_CONTACT: Final = 1
_CONSTANTS: Final = len(Constants._fields)

# Beside polynomials, two series of coefficients are worked on.
WORK_SIZE: Final = POLYNOMIAL_WORK + 4 * ROWS

# Of `rough_exp2` in the bits of a float.
_EXP2_ZERO: Final = (1023 << 52) - round(EXP2_BIAS * 2.0**52)
_N: Final = np.arange(ROWS, dtype=float)
_RECIPROCAL: Final = np.array([0.0, *(1.0 / _N[1:])])
# Bounds of |second derivative|/8 of a polynomial on [0, 1], and of its derivative.
_BEND: Final = _N * (_N - 1.0) / 8.0
_TWIST: Final = _N * (_N - 1.0) * (_N - 2.0) / 8.0


@inner
def step_size(c: Any, degree: int, problem: Any) -> float:
    """Length of the next step, s."""
    displacement = max(abs(c[0]), abs(c[1]), problem.deflection)
    speed = max(abs(c[2]), abs(c[3]), displacement * problem.frequency)
    allowed = problem.tol * speed
    longest = LONGEST_STEP / problem.frequency
    exponent = np.inf
    reciprocals = memory(_RECIPROCAL)
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
def at(c: Any, degree: int, t: float) -> Any:
    """Values and derivatives of x and y at `t`, and how far they leave their chords on [0, t].

    The last are bounds: of the values by max|second derivative|/8, and of the derivatives times
    t, likewise.
    """
    bends, twists = memory(_BEND), memory(_TWIST)
    square = t * t
    top = degree // 2
    even, odd = load_pair(c, 2 * top), load_pair(c, 2 * top + 1)
    even_slope, odd_slope = even * 0.0, odd * 0.0
    even_size, odd_size = absolute(even), absolute(odd)
    even_bend, odd_bend = even_size * bends[2 * top], odd_size * bends[2 * top + 1]
    even_twist, odd_twist = even_size * twists[2 * top], odd_size * twists[2 * top + 1]
    for k in range(2 * top - 2, -1, -2):
        even_slope, odd_slope = even_slope * square + even, odd_slope * square + odd
        term, next_term = load_pair(c, k), load_pair(c, k + 1)
        even, odd = even * square + term, odd * square + next_term
        even_size, odd_size = absolute(term), absolute(next_term)
        even_bend = even_bend * square + even_size * bends[k]
        odd_bend = odd_bend * square + odd_size * bends[k + 1]
        even_twist = even_twist * square + even_size * twists[k]
        odd_twist = odd_twist * square + odd_size * twists[k + 1]
    value = even + odd * t
    slope = odd + (even_slope + odd_slope * t) * (2.0 * t)
    return value, slope, even_bend + odd_bend * t, even_twist + odd_twist * t


@inner
def scale_column(c: Any, column: int, degree: int, t: float, out: Any) -> None:
    """Coefficients of x (0) or y (1) in θ = time/t."""
    power = 1.0
    for n in range(degree + 1):
        out[n] = c[2 * n + column] * power
        power *= t
    out[degree + 1] = 0.0


@inner
def first_root(c: Any, degree: int, h: float, side: float, ends: Any, work: Any) -> float:
    """The first switch in (0, h] as a part of h, or -1.

    `side` is 1 above the belt and -1 in contact.
    """
    value, slope, bend, twist = ends
    start, final = c[1], element(value, 1)
    first_slope, last_slope = c[3] * h, element(slope, 1) * h
    # |y − chord| <= bend; after a switch y starts from zero and the same holds for y/θ.
    first = side * (start if start != 0.0 else first_slope)
    if min(first, side * final) > element(bend, 1):
        return -1.0
    y = behind(work, CALLER)
    scale_column(c, 1, degree, h, y)
    monotone = abs(final - start) > 4.0 * element(bend, 1) or (
        (first_slope > 0.0) == (last_slope > 0.0)
        and min(abs(first_slope), abs(last_slope)) > element(twist, 1)
    )
    if monotone and start != 0.0:
        if side * final > 0.0:
            return -1.0
        if final == 0.0:
            return 1.0
        guess = _guess(start, final, first_slope, last_slope)
        return refine(y, degree + 1, (0.0, 1.0), start < 0.0, guess, PRECISE)
    if sign_roots(y, degree + 1, 1, work) > 0:
        return work[0]
    # A root that rounded out of the step is at its end.
    return 1.0 if side * final <= 0.0 else -1.0


@inner
def _guess(start: float, final: float, slope: float, last_slope: float) -> float:
    # Where the cubic through both ends of the inverse function says that the root is.
    change = final - start
    part = -start / change
    rest = 1.0 - part
    if slope == 0.0 or last_slope == 0.0:
        return part
    guess = part * part * (3.0 - 2.0 * part) + change * part * rest * (
        rest / slope - part / last_slope
    )
    return guess if 0.0 < guess < 1.0 else part


@inner
def is_finite(number: float) -> bool:
    """Whether a number is neither infinite nor NaN."""
    return number - number == 0.0


@inner
def mode_after(x: float, vx: float, vy: float, problem: Any) -> int:
    """The mode in which the motion goes on from y = 0: `core.model.mode_of` there."""
    direction = vy
    if direction == 0.0:
        direction = problem.coupling * x - problem.preload
    if direction == 0.0:
        direction = problem.coupling * vx
    if direction == 0.0:
        direction = -problem.coupling * x
    return 0 if direction > 0.0 else _CONTACT


@inner
def include(c: Any, degree: int, h: float, ends: Any, extremes: Any, work: Any) -> None:
    """Take the motion over [0, h] into one row of the extremes."""
    value, slope, bend, twist = ends
    first = load_pair(c, 0)
    too_low = least(first, value) - bend < load_pair(extremes, 0)
    too_high = greatest(first, value) + bend > load_pair(extremes, 1)
    q = behind(work, CALLER)
    wanted = bits(too_low) | bits(too_high)
    if wanted != 0:
        for column in range(2):
            if wanted >> column & 1:
                scale_column(c, column, degree, h, q)
                low, high = widen(q, degree + 1, extremes[column], extremes[2 + column], work)
                extremes[column], extremes[2 + column] = low, high
    fastest = extremes[_VX_MAX] * h
    if max(c[2], element(slope, 0)) * h + element(twist, 0) > fastest:
        power = h
        for n in range(degree):
            q[n] = (n + 1) * c[2 * n + 2] * power
            power *= h
        q[degree] = 0.0
        extremes[_VX_MAX] = widen(q, degree, -np.inf, fastest, work)[1] / h


@inner
def include_part(
    c: Any, degree: int, left: float, right: float, extremes: Any, work: Any, shifted: Any
) -> None:
    """Take the motion over [left, right] into one row of the extremes."""
    if not left < right:
        return
    for n in range(degree + 1):
        store_pair(shifted, n, load_pair(c, n))
    for start in range(degree):
        for n in range(degree - 1, start - 1, -1):
            store_pair(shifted, n, load_pair(shifted, n) + load_pair(shifted, n + 1) * left)
    h = right - left
    include(shifted, degree, h, at(shifted, degree, h), extremes, work)


@inner
def expand(c: Any, given: Any, mode: int, problem: Any) -> None:
    """Continue the first two coefficients to the order of the problem."""
    constants = behind(given, mode * _CONSTANTS)
    if mode == _CONTACT and problem.cubic:
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
            root = first_root(c, degree, h, -1.0 if mode == _CONTACT else 1.0, ends, scratch)
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
            new_mode = mode_after(x, vx, vy, problem)
            if new_mode != mode:
                switches[run.switches] = end
                run.switches += 1
                run.separations += mode
        here = (t, remainder, min(end, t_end))
        observe(c, degree, h, ends, here, stage)
        if mode != _CONTACT:
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
