"""Many transients, eight at a time: Taylor steps of as many parameter sets, one in each lane.

Every lane has its own time, step, mode and problem; all run the cubic field, whose contact terms
are zero off the belt. What the bounds of `lane_steps` leave open is settled by `polynomials`, for
that lane alone. A lane that is done takes the next problem.
"""

import sys
from typing import Any, Final

import numba
import numpy as np

from .. import batch_result, model, parameters, polynomial, recurrences, taylor
from ..batch_result import Status
from ..parameters import PARAMETERS
from ..taylor import MAX_STALLED
from . import (
    expansion,
    lane_extremes,
    lane_steps,
    polynomials,
    rows,
    steps,
    variations,
    vectors,
)
from .expansion import expand_cubic_lanes, expand_linear_lanes
from .jit import inner, kernel
from .lane_extremes import observe_column, observe_speed, settle_half
from .lane_steps import bounded_at, first_roots, step_sizes, values_at
from .polynomials import CALLER, sign_roots
from .rows import MEMBER_COLUMNS, OUTCOME_COLUMNS
from .steps import EXTREMES, NO_EXTREMES, is_finite, mode_after
from .vectors import (
    LANES,
    behind,
    bits,
    choose,
    lanes_of,
    least,
    load_lanes,
    memory,
    negated,
    splat,
    store_lanes,
)

DONE, OVERFLOW, STALLED, STEP_LIMIT = (
    int(status) for status in (Status.DONE, Status.OVERFLOW, Status.STALLED, Status.STEP_LIMIT)
)
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
    batch_result,
    model,
    parameters,
    polynomial,
    recurrences,
    taylor,
    expansion,
    lane_extremes,
    lane_steps,
    polynomials,
    rows,
    steps,
    variations,
    vectors,
    sys.modules[inner.__module__],
)


@inner
def _begin(w: Any, lane: int, member: Any) -> None:
    # Put a problem into a lane.
    for n in range(rows.FIXED):
        w[(rows.CONTACT + n) * LANES + lane] = member[n]
    for n in range(rows.MOVING, rows.STEP):
        w[n * LANES + lane] = 0.0
    w[rows.FIRST * LANES + lane] = w[rows.LAST * LANES + lane] = np.nan
    for n in range(len(EXTREMES)):
        w[(rows.SEEN + n) * LANES + lane] = NO_EXTREMES[n]
        w[(rows.EARLIER + n) * LANES + lane] = NO_EXTREMES[n]
    x, vx, y, vy = (
        member[rows.FIXED],
        member[rows.FIXED + 1],
        member[rows.FIXED + 2],
        member[rows.FIXED + 3],
    )
    series = behind(w, rows.SERIES * LANES)
    series[lane], series[LANES + lane] = x, y
    series[2 * LANES + lane], series[3 * LANES + lane] = vx, vy
    above = y > 0.0
    if y == 0.0:
        coupling, preload = w[rows.COUPLING * LANES + lane], w[rows.PRELOAD * LANES + lane]
        above = mode_after(x, vx, vy, coupling, preload) == 0
    w[rows.SIDE * LANES + lane] = 1.0 if above and w[rows.GUARDED * LANES + lane] > 0.0 else -1.0


@inner
def _end(w: Any, lane: int, status: int, outcome: Any) -> None:
    # Write the result of a lane and empty it.
    series = behind(w, rows.SERIES * LANES)
    outcome[0], outcome[1] = series[lane], series[2 * LANES + lane]
    outcome[2], outcome[3] = series[LANES + lane], series[3 * LANES + lane]
    outcome[4], outcome[5] = w[rows.T * LANES + lane], status
    outcome[6] = w[rows.STEPS * LANES + lane]
    outcome[7], outcome[8] = w[rows.LIFTS * LANES + lane], w[rows.LANDINGS * LANES + lane]
    outcome[9] = w[rows.AIR * LANES + lane]
    outcome[10], outcome[11] = w[rows.FIRST * LANES + lane], w[rows.LAST * LANES + lane]
    for n in range(len(EXTREMES)):
        one, other = w[(rows.SEEN + n) * LANES + lane], w[(rows.EARLIER + n) * LANES + lane]
        outcome[12 + n] = min(one, other) if n < 2 else max(one, other)
    outcome[17], outcome[18] = w[rows.Y_LOW * LANES + lane], w[rows.Y_HIGH * LANES + lane]
    # What has no problem stands still.
    for n in range(rows.STEP):
        w[n * LANES + lane] = 0.0
    for n in range(4):
        series[n * LANES + lane] = 0.0
    w[rows.LONGEST * LANES + lane] = 1.0


@inner
def _settle_root(w: Any, degree: int, lane: int) -> bool:
    # The first switch of a lane's step, exactly; the step ends at it.
    c, scratch = behind(w, rows.SERIES * LANES), behind(w, rows.SCRATCH)
    side, h = w[rows.SIDE * LANES + lane], w[rows.STEP * LANES + lane]
    y = behind(scratch, CALLER)
    power, final = 1.0, 0.0
    for n in range(degree + 1):
        y[n] = c[(2 * n + 1) * LANES + lane] * power
        final += y[n]
        power *= h
    y[degree + 1] = 0.0
    if sign_roots(y, degree + 1, 1, scratch) > 0:
        w[rows.STEP * LANES + lane] = h * scratch[0]
        return True
    # A root that rounded out of the step is at its end.
    return side * final <= 0.0


@inner
def _switch(w: Any, end: Any, state: Any, cut: Any, going: Any) -> None:
    # Change the mode of the lanes that are `cut` at a root, by the first derivative that is not 0.
    x, vx, vy = state
    side = load_lanes(w, rows.SIDE)
    coupling = load_lanes(w, rows.COUPLING)
    pull = coupling * x - load_lanes(w, rows.PRELOAD)
    push = coupling * vx
    third = choose(push != 0.0, push, splat(0.0) - coupling * x)
    direction = choose(vy != 0.0, vy, choose(pull != 0.0, pull, third))
    new_side = choose(cut, choose(direction > 0.0, 1.0, -1.0), side)
    switched = (new_side != side) & going
    lifted = choose(switched & (side < 0.0), 1.0, 0.0)
    landed = choose(switched & (side > 0.0), 1.0, 0.0)
    lifts, landings = load_lanes(w, rows.LIFTS), load_lanes(w, rows.LANDINGS)
    none_yet = switched & (lifts + landings == 0.0)
    store_lanes(w, rows.LIFTS, lifts + lifted)
    store_lanes(w, rows.LANDINGS, landings + landed)
    store_lanes(w, rows.FIRST, choose(none_yet, end, load_lanes(w, rows.FIRST)))
    store_lanes(w, rows.LAST, choose(switched, end, load_lanes(w, rows.LAST)))
    store_lanes(w, rows.SIDE, new_side)


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
    c = behind(w, rows.SERIES * LANES)
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
        t, rest, side = load_lanes(w, rows.T), load_lanes(w, rows.REST), load_lanes(w, rows.SIDE)
        for n in range(rows.CONSTANTS):
            store_lanes(w, n, load_lanes(w, rows.CONTACT + n))
        off = side > 0.0
        store_lanes(
            w,
            rows.XY,
            choose(off, load_lanes(w, rows.XY_OFF), load_lanes(w, rows.CONTACT + rows.XY)),
        )
        store_lanes(
            w,
            rows.YY,
            choose(off, load_lanes(w, rows.YY_OFF), load_lanes(w, rows.CONTACT + rows.YY)),
        )
        store_lanes(w, rows.CUBIC, choose(off, 0.0, load_lanes(w, rows.CONTACT + rows.CUBIC)))
        if cubic:
            expand_cubic_lanes(c, w, order)
        else:
            expand_linear_lanes(c, w, order)
        h = step_sizes(
            c,
            degree,
            tol,
            load_lanes(w, rows.DEFLECTION),
            load_lanes(w, rows.FREQUENCY),
            load_lanes(w, rows.LONGEST),
        )
        ahead = (t_end - t) - rest
        reaching = negated(h < ahead)
        h = least(h, ahead)
        guarded = bits(load_lanes(w, rows.GUARDED) > 0.0) & occupied
        rooted = 0
        if guarded != 0:
            h, rooted, doubtful = first_roots(c, degree, h, side, guarded)
            if doubtful != 0:
                store_lanes(w, rows.STEP, h)
                for lane in range(LANES):
                    if doubtful >> lane & 1 and _settle_root(w, degree, lane):
                        rooted |= 1 << lane
                h = load_lanes(w, rows.STEP)
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
                    store_lanes(w, rows.STEP, h)
                    for lane in range(LANES):
                        if crossing >> lane & 1:
                            middle = (half - w[rows.T * LANES + lane]) - w[rows.REST * LANES + lane]
                            duration = w[rows.STEP * LANES + lane]
                            settle_half(w, degree, lane, min(middle, duration), duration)
                    observed &= ~crossing
            if peak:
                observe_column(w, degree, h, 0, x_ends, observed)
                observe_speed(w, degree, h, vx, x_ends[3], observed)
            if not amplitude:
                observed &= bits(t >= half)
            if (amplitude or steady) and observed != 0:
                observe_column(w, degree, h, 1, y_ends, observed)
        # The switches.
        y = choose(cut, 0.0, y)
        if rooted != 0:
            _switch(w, end, (x, vx, vy), cut, lanes_of(live))
        going = lanes_of(live)
        part = choose(off & going, h, 0.0) + load_lanes(w, rows.AIR_REST)
        air = load_lanes(w, rows.AIR)
        longer = air + part
        store_lanes(w, rows.AIR_REST, part - (longer - air))
        store_lanes(w, rows.AIR, longer)
        made = load_lanes(w, rows.STEPS) + choose(going, 1.0, 0.0)
        stuck = choose(end == t, load_lanes(w, rows.STUCK) + 1.0, 0.0)
        store_lanes(w, rows.STEPS, made)
        store_lanes(w, rows.STUCK, stuck)
        store_lanes(w, rows.T, choose(going, end, t))
        store_lanes(w, rows.REST, new_rest)
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
            occupied &= ~leaving
    cursor[OCCUPIED] = occupied
    behind_us = float(cursor[ENDED])
    for lane in range(LANES):
        if occupied >> lane & 1:
            behind_us += w[rows.T * LANES + lane] / t_end
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
