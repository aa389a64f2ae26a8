"""Many transients, eight at a time: Taylor steps of as many parameter sets, one in each lane.

Every lane has its own time, step, mode and problem; all run the cubic field, whose contact terms
are zero off the belt. What the bounds of `lane_steps` leave open is settled by `polynomials`, for
that lane alone. A lane that is done takes the next problem.
"""

import sys
from typing import Any, Final, NamedTuple

import numba
import numpy as np

from .. import model, parameters, polynomial, recurrences, taylor
from ..parameters import PARAMETERS
from ..recurrences import Constants
from ..taylor import MAX_STALLED
from . import expansion, lane_steps, polynomials, steps, variations, vectors
from .expansion import ROWS, expand_cubic_lanes, expand_linear_lanes
from .jit import inner, kernel
from .lane_steps import bounded_at, first_roots, step_sizes, values_at, widened
from .polynomials import CALLER, sign_roots, widen
from .polynomials import WORK_SIZE as POLYNOMIAL_WORK
from .steps import EXTREMES, NO_EXTREMES, include_part, is_finite, mode_after
from .vectors import (
    LANES,
    behind,
    bits,
    choose,
    greatest,
    lanes_of,
    least,
    load_lanes,
    memory,
    negated,
    splat,
    store_lanes,
)

# How a transient ends.
DONE: Final = 0
OVERFLOW: Final = 1
STALLED: Final = 2
STEP_LIMIT: Final = 3
NO_START: Final = 4


class Member(NamedTuple):
    """Columns of the problems: what a lane keeps of its parameter set, SI units."""

    xx: float
    xy: float
    yx: float
    yy: float
    xvx: float
    yvy: float
    friction: float
    cubic: float
    load: float
    xy_off: float
    yy_off: float
    coupling: float
    preload: float
    deflection: float
    frequency: float
    longest: float
    separation: float
    x: float
    vx: float
    y: float
    vy: float


class Outcome(NamedTuple):
    """Columns of the results, SI units; `y_low` and `y_high` are of the second half."""

    x: float
    vx: float
    y: float
    vy: float
    t: float
    status: float
    steps: float
    separations: float
    reattachments: float
    separated: float
    first: float
    last: float
    x_min: float
    y_min: float
    x_max: float
    y_max: float
    vx_max: float
    y_low: float
    y_high: float


MEMBER_COLUMNS: Final = len(Member._fields)
OUTCOME_COLUMNS: Final = len(Outcome._fields)
# Rows of a lane block: the constants that the recurrences are given, then those of the problem, …
_CONSTANTS: Final = len(Constants._fields)
_CONTACT: Final = _CONSTANTS
_XY, _YY, _CUBIC = (Constants._fields.index(name) for name in ("xy", "yy", "cubic"))
_FIXED: Final = MEMBER_COLUMNS - 4
_XY_OFF, _YY_OFF, _COUPLING, _PRELOAD, _DEFLECTION, _FREQUENCY, _LONGEST, _GUARDED = (
    _CONTACT + Member._fields.index(name) for name in Member._fields[_CONSTANTS:_FIXED]
)
# … then what changes from step to step, …
_MOVING: Final = _CONTACT + _FIXED
(
    _T,
    _REST,
    _SIDE,
    _STEPS,
    _STUCK,
    _LIFTS,
    _LANDINGS,
    _AIR,
    _AIR_REST,
    _FIRST,
    _LAST,
) = range(_MOVING, _MOVING + 11)
# … the extremes in this half of the horizon and in the first, …
_SEEN: Final = _MOVING + 11
_EARLIER: Final = _SEEN + len(EXTREMES)
_X_LOW, _Y_LOW, _X_HIGH, _Y_HIGH, _VX_HIGH = range(_SEEN, _EARLIER)
# … room for the steps, and the coefficients of x and y, and of ẋ.
_STEP: Final = _EARLIER + len(EXTREMES)
_SERIES: Final = _STEP + 1
_RATES: Final = _SERIES + 2 * ROWS
_BLOCK: Final = (_RATES + ROWS) * LANES
# One lane's series and extremes, for the code that knows no lanes.
_SINGLE: Final = _BLOCK
_SHIFTED: Final = _SINGLE + 2 * ROWS
_ROW: Final = _SHIFTED + 2 * ROWS
_SCRATCH: Final = _ROW + LANES
WORK_SIZE: Final = _SCRATCH + POLYNOMIAL_WORK

# What a worker keeps between calls: members begun and ended, and the members in the lanes.
BEGUN, ENDED, OCCUPIED, MEMBERS = range(4)
CURSOR_SIZE: Final = MEMBERS + LANES

_K1, _K2, _K3, _F, _K_NL = (
    list(PARAMETERS).index(name) for name in ("k1", "k2", "k3", "F", "k_nl")
)
_ALL: Final = (1 << LANES) - 1
_resting_height: Final = inner(model.resting_height)
_row = numba.types.Array(numba.float64, 1, "C")
_table = numba.types.Array(numba.float64, 2, "C")
_flags = numba.types.Array(numba.int64, 1, "C")
_OWN: Final = (
    model,
    parameters,
    polynomial,
    recurrences,
    taylor,
    expansion,
    lane_steps,
    polynomials,
    steps,
    variations,
    vectors,
    sys.modules[inner.__module__],
)


@inner
def _begin(w: Any, lane: int, member: Any) -> None:
    # Put a problem into a lane.
    for n in range(_FIXED):
        w[(_CONTACT + n) * LANES + lane] = member[n]
    for n in range(_MOVING, _STEP):
        w[n * LANES + lane] = 0.0
    w[_FIRST * LANES + lane] = w[_LAST * LANES + lane] = np.nan
    for n in range(len(EXTREMES)):
        w[(_SEEN + n) * LANES + lane] = NO_EXTREMES[n]
        w[(_EARLIER + n) * LANES + lane] = NO_EXTREMES[n]
    x, vx, y, vy = member[_FIXED], member[_FIXED + 1], member[_FIXED + 2], member[_FIXED + 3]
    series = behind(w, _SERIES * LANES)
    series[lane], series[LANES + lane] = x, y
    series[2 * LANES + lane], series[3 * LANES + lane] = vx, vy
    above = y > 0.0
    if y == 0.0:
        coupling, preload = w[_COUPLING * LANES + lane], w[_PRELOAD * LANES + lane]
        above = mode_after(x, vx, vy, coupling, preload) == 0
    w[_SIDE * LANES + lane] = 1.0 if above and w[_GUARDED * LANES + lane] > 0.0 else -1.0


@inner
def _end(w: Any, lane: int, status: int, outcome: Any) -> None:
    # Write the result of a lane.
    series = behind(w, _SERIES * LANES)
    outcome[0], outcome[1] = series[lane], series[2 * LANES + lane]
    outcome[2], outcome[3] = series[LANES + lane], series[3 * LANES + lane]
    outcome[4], outcome[5] = w[_T * LANES + lane], status
    outcome[6] = w[_STEPS * LANES + lane]
    outcome[7], outcome[8] = w[_LIFTS * LANES + lane], w[_LANDINGS * LANES + lane]
    outcome[9] = w[_AIR * LANES + lane]
    outcome[10], outcome[11] = w[_FIRST * LANES + lane], w[_LAST * LANES + lane]
    for n in range(len(EXTREMES)):
        one, other = w[(_SEEN + n) * LANES + lane], w[(_EARLIER + n) * LANES + lane]
        outcome[12 + n] = min(one, other) if n < 2 else max(one, other)
    outcome[17], outcome[18] = w[_Y_LOW * LANES + lane], w[_Y_HIGH * LANES + lane]


@inner
def _settle_root(w: Any, degree: int, lane: int) -> bool:
    # The first switch of a lane's step, exactly; the step ends at it.
    c, scratch = behind(w, _SERIES * LANES), behind(w, _SCRATCH)
    side, h = w[_SIDE * LANES + lane], w[_STEP * LANES + lane]
    y = behind(scratch, CALLER)
    power, final = 1.0, 0.0
    for n in range(degree + 1):
        y[n] = c[(2 * n + 1) * LANES + lane] * power
        final += y[n]
        power *= h
    y[degree + 1] = 0.0
    if sign_roots(y, degree + 1, 1, scratch) > 0:
        w[_STEP * LANES + lane] = h * scratch[0]
        return True
    # A root that rounded out of the step is at its end.
    return side * final <= 0.0


@inner
def _settle_range(
    w: Any, first: int, stride: int, size: int, h: float, low: int, high: int, lane: int
) -> None:
    # Exact extremes of a lane's polynomial, into its rows.
    scratch = behind(w, _SCRATCH)
    q = behind(scratch, CALLER)
    power = 1.0
    for n in range(size):
        q[n] = w[(first + stride * n) * LANES + lane] * power
        power *= h
    q[size] = 0.0
    least_value = w[low * LANES + lane] if low >= 0 else -np.inf
    found = widen(q, size, least_value, w[high * LANES + lane], scratch)
    if low >= 0:
        w[low * LANES + lane] = found[0]
    w[high * LANES + lane] = found[1]


@inner
def _settle_half(w: Any, degree: int, lane: int, middle: float, h: float) -> None:
    # The step in which half the horizon lies: the extremes begin anew there.
    c, row, scratch = behind(w, _SINGLE), behind(w, _ROW), behind(w, _SCRATCH)
    shifted = behind(w, _SHIFTED)
    for n in range(2 * degree + 2):
        c[n] = w[(_SERIES + n) * LANES + lane]
    for n in range(len(EXTREMES)):
        row[n] = w[(_SEEN + n) * LANES + lane]
    include_part(c, degree, 0.0, middle, row, scratch, shifted)
    for n in range(len(EXTREMES)):
        w[(_EARLIER + n) * LANES + lane] = row[n]
        row[n] = NO_EXTREMES[n]
    include_part(c, degree, middle, h, row, scratch, shifted)
    for n in range(len(EXTREMES)):
        w[(_SEEN + n) * LANES + lane] = row[n]


@inner
def _observe_column(w: Any, degree: int, h: Any, column: int, ends: Any, wanted: int) -> None:
    # Take x (0) or y (1) over the steps into the extremes.
    final, final_slope, bend, twist = ends
    low, high = load_lanes(w, _SEEN + column), load_lanes(w, _SEEN + 2 + column)
    start = load_lanes(w, _SERIES + column)
    below = least(start, final) - bend < low
    wanted &= bits(below | (greatest(start, final) + bend > high))
    if wanted == 0:
        return
    slope = load_lanes(w, _SERIES + 2 + column) * h
    low, high, doubtful = widened(
        w,
        _SERIES + column,
        2,
        degree,
        h,
        (start, final, slope, final_slope * h, twist),
        (low, high),
        wanted,
    )
    there = lanes_of(wanted)
    store_lanes(w, _SEEN + column, choose(there, low, load_lanes(w, _SEEN + column)))
    store_lanes(w, _SEEN + 2 + column, choose(there, high, load_lanes(w, _SEEN + 2 + column)))
    if doubtful != 0:
        store_lanes(w, _STEP, h)
        for lane in range(LANES):
            if doubtful >> lane & 1:
                duration = w[_STEP * LANES + lane]
                low_row, high_row = _SEEN + column, _SEEN + 2 + column
                first = _SERIES + column
                _settle_range(w, first, 2, degree + 1, duration, low_row, high_row, lane)


@inner
def _observe_speed(w: Any, degree: int, h: Any, final: Any, twist: Any, wanted: int) -> None:
    # Take ẋ over the steps into its greatest value.
    high = load_lanes(w, _VX_HIGH)
    start = load_lanes(w, _SERIES + 2)
    wanted &= bits(greatest(start, final) * h + twist > high * h)
    if wanted == 0:
        return
    for n in range(degree):
        store_lanes(w, _RATES + n, load_lanes(w, _SERIES + 2 * n + 2) * (n + 1.0))
    final, final_slope, _, twist = bounded_at(w, _RATES, 1, degree - 1, h)
    slope = load_lanes(w, _RATES + 1) * h
    ends = (start, final, slope, final_slope * h, twist)
    _, found, doubtful = widened(w, _RATES, 1, degree - 1, h, ends, (splat(-np.inf), high), wanted)
    store_lanes(w, _VX_HIGH, choose(lanes_of(wanted), found, high))
    if doubtful != 0:
        store_lanes(w, _STEP, h)
        for lane in range(LANES):
            if doubtful >> lane & 1:
                duration = w[_STEP * LANES + lane]
                _settle_range(w, _RATES, 1, degree, duration, -1, _VX_HIGH, lane)


@kernel(
    numba.float64(
        _table,
        _table,
        _row,
        _flags,
        numba.float64,
        numba.float64,
        numba.int64,
        numba.boolean,
        numba.boolean,
        numba.boolean,
        numba.boolean,
        numba.float64,
        numba.int64,
    ),
    *_OWN,
)
def advance(
    members: Any,
    outcomes: Any,
    work: Any,
    cursor: Any,
    t_end: float,
    tol: float,
    order: int,
    cubic: bool,
    amplitude: bool,
    peak: bool,
    steady: bool,
    max_steps: float,
    budget: int,
) -> float:
    """Go on with a chunk of transients until all are ended or the budget is spent.

    Parameters
    ----------
    members : ndarray, shape (n, MEMBER_COLUMNS)
        The problems.
    outcomes : ndarray, shape (n, OUTCOME_COLUMNS)
        Receives the results, those of a failed member as far as it came.
    work : ndarray, shape (WORK_SIZE,)
        Zero at first; the lanes.
    cursor : ndarray of int64, shape (CURSOR_SIZE,)
        Zero at first; where the work stands. All is done once `ENDED` is n.
    t_end : float
        Horizon, s.
    tol : float
        Local tolerance.
    order : int
        Of the expansion.
    cubic : bool
        Whether the contact is cubic, of all members.
    amplitude, peak, steady : bool
        Whether the extremes of y over the run, those of x and ẋ, and those of y over its second
        half are wanted.
    max_steps : float
        Steps after which a member is given up.
    budget : int
        Steps of all lanes after which to pause.

    Returns
    -------
    float
        Members ended, those under way counted by the part of the horizon behind them.
    """
    w = memory(work)
    c = behind(w, _SERIES * LANES)
    degree, half, count = order + 1, 0.5 * t_end, members.shape[0]
    occupied = cursor[OCCUPIED]
    for _ in range(budget):
        if occupied != _ALL and cursor[BEGUN] < count:
            for lane in range(LANES):
                if occupied >> lane & 1 == 0 and cursor[BEGUN] < count:
                    index = cursor[BEGUN]
                    _begin(w, lane, behind(memory(members), index * MEMBER_COLUMNS))
                    cursor[MEMBERS + lane] = index
                    cursor[BEGUN] += 1
                    occupied |= 1 << lane
        if occupied == 0:
            break
        t, rest, side = load_lanes(w, _T), load_lanes(w, _REST), load_lanes(w, _SIDE)
        for n in range(_CONSTANTS):
            store_lanes(w, n, load_lanes(w, _CONTACT + n))
        off = side > 0.0
        store_lanes(w, _XY, choose(off, load_lanes(w, _XY_OFF), load_lanes(w, _CONTACT + _XY)))
        store_lanes(w, _YY, choose(off, load_lanes(w, _YY_OFF), load_lanes(w, _CONTACT + _YY)))
        store_lanes(w, _CUBIC, choose(off, 0.0, load_lanes(w, _CONTACT + _CUBIC)))
        if cubic:
            expand_cubic_lanes(c, w, order)
        else:
            expand_linear_lanes(c, w, order)
        h = step_sizes(
            c,
            degree,
            tol,
            load_lanes(w, _DEFLECTION),
            load_lanes(w, _FREQUENCY),
            load_lanes(w, _LONGEST),
        )
        ahead = (t_end - t) - rest
        reaching = negated(h < ahead)
        h = least(h, ahead)
        guarded = bits(load_lanes(w, _GUARDED) > 0.0) & occupied
        rooted = 0
        if guarded != 0:
            h, rooted, doubtful = first_roots(c, degree, h, side, guarded)
            if doubtful != 0:
                store_lanes(w, _STEP, h)
                for lane in range(LANES):
                    if doubtful >> lane & 1 and _settle_root(w, degree, lane):
                        rooted |= 1 << lane
                h = load_lanes(w, _STEP)
        cut = lanes_of(rooted)
        # Where the steps end.
        if amplitude or steady:
            y_ends = bounded_at(c, 1, 2, degree, h)
            y, vy = y_ends[0], y_ends[1]
        else:
            y, vy = values_at(c, 1, 2, degree, h)
            y_ends = (y, vy, y, y)
        if peak:
            x_ends = bounded_at(c, 0, 2, degree, h)
            x, vx = x_ends[0], x_ends[1]
        else:
            x, vx = values_at(c, 0, 2, degree, h)
            x_ends = (x, vx, x, x)
        total = x + y + vx + vy
        live = occupied & bits((total - total == 0.0) & (h > 0.0))
        increment = h + rest
        end = t + increment
        lost = end - t
        new_rest = (t - (end - lost)) + (increment - lost)
        last = (reaching & negated(cut)) | (end >= t_end)
        end = choose(last, t_end, end)
        # What was seen on the way.
        if amplitude or peak or steady:
            observed = live
            if steady:
                crossing = live & bits((t < half) & (end > half))
                if crossing != 0:
                    store_lanes(w, _STEP, h)
                    for lane in range(LANES):
                        if crossing >> lane & 1:
                            middle = (half - w[_T * LANES + lane]) - w[_REST * LANES + lane]
                            duration = w[_STEP * LANES + lane]
                            _settle_half(w, degree, lane, min(middle, duration), duration)
                    observed &= ~crossing
            if peak:
                _observe_column(w, degree, h, 0, x_ends, observed)
                _observe_speed(w, degree, h, vx, x_ends[3], observed)
            if not amplitude:
                observed &= bits(t >= half)
            if (amplitude or steady) and observed != 0:
                _observe_column(w, degree, h, 1, y_ends, observed)
        # The switches.
        y = choose(cut, 0.0, y)
        if rooted != 0:
            coupling = load_lanes(w, _COUPLING)
            pull = coupling * x - load_lanes(w, _PRELOAD)
            push = coupling * vx
            third = choose(push != 0.0, push, splat(0.0) - coupling * x)
            direction = choose(vy != 0.0, vy, choose(pull != 0.0, pull, third))
            new_side = choose(cut, choose(direction > 0.0, 1.0, -1.0), side)
            switched = (new_side != side) & lanes_of(live)
            lifted = choose(switched & (side < 0.0), 1.0, 0.0)
            landed = choose(switched & (side > 0.0), 1.0, 0.0)
            lifts, landings = load_lanes(w, _LIFTS), load_lanes(w, _LANDINGS)
            none_yet = switched & (lifts + landings == 0.0)
            store_lanes(w, _LIFTS, lifts + lifted)
            store_lanes(w, _LANDINGS, landings + landed)
            store_lanes(w, _FIRST, choose(none_yet, end, load_lanes(w, _FIRST)))
            store_lanes(w, _LAST, choose(switched, end, load_lanes(w, _LAST)))
            store_lanes(w, _SIDE, new_side)
        going = lanes_of(live)
        part = choose(off & going, h, 0.0) + load_lanes(w, _AIR_REST)
        air = load_lanes(w, _AIR)
        longer = air + part
        store_lanes(w, _AIR_REST, part - (longer - air))
        store_lanes(w, _AIR, longer)
        made = load_lanes(w, _STEPS) + choose(going, 1.0, 0.0)
        stuck = choose(end == t, load_lanes(w, _STUCK) + 1.0, 0.0)
        store_lanes(w, _STEPS, made)
        store_lanes(w, _STUCK, stuck)
        store_lanes(w, _T, choose(going, end, t))
        store_lanes(w, _REST, new_rest)
        for n, value in ((0, x), (1, y), (2, vx), (3, vy)):
            store_lanes(c, n, choose(going, value, load_lanes(c, n)))
        ended = live & bits(last)
        stalled = live & ~ended & bits(stuck > float(MAX_STALLED))
        halted = live & ~ended & bits(made >= max_steps)
        leaving = (occupied & ~live) | ended | stalled | halted
        if leaving != 0:
            for lane in range(LANES):
                if leaving >> lane & 1:
                    status = OVERFLOW
                    if ended >> lane & 1:
                        status = DONE
                    elif stalled >> lane & 1:
                        status = STALLED
                    elif halted >> lane & 1:
                        status = STEP_LIMIT
                    index = cursor[MEMBERS + lane]
                    _end(w, lane, status, behind(memory(outcomes), index * OUTCOME_COLUMNS))
                    cursor[ENDED] += 1
                    for n in range(_STEP):
                        w[n * LANES + lane] = 0.0
                    for n in range(4):
                        c[n * LANES + lane] = 0.0
                    w[_LONGEST * LANES + lane] = 1.0
            occupied &= ~leaving
    cursor[OCCUPIED] = occupied
    behind_us = float(cursor[ENDED])
    for lane in range(LANES):
        if occupied >> lane & 1:
            behind_us += w[_T * LANES + lane] / t_end
    return behind_us


@kernel(numba.int64(_table, numba.types.Array(numba.boolean, 1, "C"), _table), *_OWN)
def static_starts(table: Any, separation: Any, starts: Any) -> int:
    """The states at rest at the equilibria of μ = 0: `core.model.static_start`.

    Parameters
    ----------
    table : ndarray, shape (n, 9)
        Parameter sets, in the order of `Parameters`.
    separation : ndarray of bool, shape (n,)
        Whether separation is considered.
    starts : ndarray, shape (n, 4)
        Receives (x, 0, y, 0) in m and m/s, infinite where there is none.

    Returns
    -------
    int
        How many there are.
    """
    found = 0
    for index in range(table.shape[0]):
        row = table[index]
        k1, h = row[_K1], 0.5 * row[_K3]
        stiffness = (k1, row[_K2], row[_K_NL])
        y = _resting_height(h, stiffness, row[_F], 0.0, separation[index])
        starts[index, 0], starts[index, 1] = h * y / (k1 + h), 0.0
        starts[index, 2], starts[index, 3] = y, 0.0
        found += is_finite(y)
    return found
