"""Many transients at once: Taylor steps of as many parameter sets, one in each lane.

Every lane has its own time, step, mode and problem; all run the cubic field, whose contact terms
are zero off the belt. A lane that is done takes the next problem. The lanes are stepped block by
block; first switches and extrema, which few of the steps have, are then looked for together.
"""

import sys
from typing import Any, Final

import numba

from .. import batch_result, model, parameters, polynomial, recurrences, taylor
from ..batch_result import Status
from ..parameters import PARAMETERS
from ..taylor import MAX_STALLED
from . import (
    expansion,
    lane_extremes,
    lane_members,
    lane_roots,
    lane_steps,
    polynomials,
    rows,
    steps,
    vectors,
)
from .expansion import expand_cubic_lanes, expand_linear_lanes
from .jit import inner, kernel
from .lane_extremes import observe
from .lane_members import begin, end, lane_of, move
from .lane_roots import settle_roots
from .lane_steps import bounded_at, slope_bound, step_sizes, values_at
from .rows import BLOCKS, MEMBER_COLUMNS, OUTCOME_COLUMNS, PLACES
from .steps import is_finite
from .vectors import (
    LANE_BITS,
    LANES,
    behind,
    bits,
    choose,
    lanes_of,
    least,
    load_lanes,
    lowest,
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
CURSOR_SIZE: Final = MEMBERS + PLACES

_K1, _K2, _K3, _F, _K_NL = (
    list(PARAMETERS).index(name) for name in ("k1", "k2", "k3", "F", "k_nl")
)
_ALL: Final = (1 << PLACES) - 1
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
    lane_members,
    lane_roots,
    lane_steps,
    polynomials,
    rows,
    steps,
    vectors,
    sys.modules[inner.__module__],
)


@inner
def _refill(work: Any, members: Any, count: int, cursor: Any, occupied: int) -> int:
    # Give problems to empty lanes, the lowest first; without any left, keep to as few blocks as
    # can be.
    while occupied != _ALL and cursor[BEGUN] < count:
        place, index = lowest(~occupied), cursor[BEGUN]
        begin(work, place, behind(members, index * MEMBER_COLUMNS))
        cursor[MEMBERS + place] = index
        cursor[BEGUN] += 1
        occupied |= 1 << place
    for place in range(PLACES - 1, -1, -1):
        if occupied >> place & 1:
            hole = lowest(~occupied)
            if hole // LANES >= place // LANES:
                break
            move(work, place, hole)
            cursor[MEMBERS + hole] = cursor[MEMBERS + place]
            occupied ^= 1 << place | 1 << hole
    return occupied


@inner
def _predict(w: Any, t_end: float, tol: float, degree: int, occupied: int) -> int:
    # Step a block in y as far as the expansions lead; returns the lanes in which there may be a
    # switch before.
    c = behind(w, rows.SERIES * LANES)
    h = step_sizes(
        c,
        degree,
        tol,
        load_lanes(w, rows.DEFLECTION),
        load_lanes(w, rows.FREQUENCY),
        load_lanes(w, rows.LONGEST),
    )
    h = least(h, (t_end - load_lanes(w, rows.T)) - load_lanes(w, rows.REST))
    y, vy, off = bounded_at(c, 1, 2, degree, h)
    store_lanes(w, rows.STEP, h)
    store_lanes(w, rows.Y, y)
    store_lanes(w, rows.VY, vy)
    store_lanes(w, rows.Y_OFF, off)
    # After a switch y starts from zero; the same holds for y/θ.
    side, start = load_lanes(w, rows.SIDE), load_lanes(c, 1)
    first = choose(start == 0.0, load_lanes(c, 3) * h, start)
    far = least(side * first, side * y) > off
    return occupied & bits((load_lanes(w, rows.GUARDED) > 0.0) & negated(far))


@inner
def _complete(w: Any, degree: int, bounded: bool, occupied: int) -> int:
    # Step a block in x; returns the lanes in which all is finite.
    c, h = behind(w, rows.SERIES * LANES), load_lanes(w, rows.STEP)
    if bounded:
        x, vx, off = bounded_at(c, 0, 2, degree, h)
        store_lanes(w, rows.X_OFF, off)
        store_lanes(w, rows.VX_OFF, slope_bound(c, 0, 2, degree, h))
    else:
        x, vx = values_at(c, 0, 2, degree, h)
    store_lanes(w, rows.X, x)
    store_lanes(w, rows.VX, vx)
    total = (x + load_lanes(w, rows.Y)) + (vx + load_lanes(w, rows.VY))
    return occupied & bits((total - total == 0.0) & (h > 0.0))


@inner
def _switch(w: Any, end: Any, cut: Any, going: Any) -> None:
    # Change the mode of the lanes that are `cut` at a root, by the first derivative that is not 0.
    x, vx, vy = load_lanes(w, rows.X), load_lanes(w, rows.VX), load_lanes(w, rows.VY)
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
    off = new_side > 0.0
    contact = rows.CONTACT
    xy, yy = load_lanes(w, contact + rows.XY), load_lanes(w, contact + rows.YY)
    store_lanes(w, rows.XY, choose(off, load_lanes(w, rows.XY_OFF), xy))
    store_lanes(w, rows.YY, choose(off, load_lanes(w, rows.YY_OFF), yy))
    store_lanes(w, rows.CUBIC, choose(off, 0.0, load_lanes(w, contact + rows.CUBIC)))


@inner
def _go_on(w: Any, t_end: float, rooted: int, live: int, max_steps: float) -> Any:
    # End the steps of a block; returns the lanes that are at the end of the horizon, stall, or
    # have made too many steps.
    t, rest, h = load_lanes(w, rows.T), load_lanes(w, rows.REST), load_lanes(w, rows.STEP)
    cut, going = lanes_of(rooted), lanes_of(live)
    reached = negated(h < (t_end - t) - rest) & negated(cut)
    increment = h + rest
    end = t + increment
    lost = end - t
    new_rest = (t - (end - lost)) + (increment - lost)
    last = reached | (end >= t_end)
    end = choose(last, t_end, end)
    part = choose((load_lanes(w, rows.SIDE) > 0.0) & going, h, 0.0) + load_lanes(w, rows.AIR_REST)
    air = load_lanes(w, rows.AIR)
    longer = air + part
    store_lanes(w, rows.AIR_REST, part - (longer - air))
    store_lanes(w, rows.AIR, longer)
    if rooted != 0:
        _switch(w, end, cut, going)
    made = load_lanes(w, rows.STEPS) + choose(going, 1.0, 0.0)
    stuck = choose(end == t, load_lanes(w, rows.STUCK) + 1.0, 0.0)
    store_lanes(w, rows.STEPS, made)
    store_lanes(w, rows.STUCK, stuck)
    store_lanes(w, rows.T, choose(going, end, t))
    store_lanes(w, rows.REST, new_rest)
    for n, row in enumerate((rows.X, rows.Y, rows.VX, rows.VY)):
        old = load_lanes(w, rows.SERIES + n)
        store_lanes(w, rows.SERIES + n, choose(going, load_lanes(w, row), old))
    ended = live & bits(last)
    stalled = live & bits(stuck > float(MAX_STALLED))
    return ended, stalled, live & bits(made >= max_steps)


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
    lanes, degree, half, count = memory(work), order + 1, 0.5 * t_end, members.shape[0]
    occupied = cursor[OCCUPIED]
    for _ in range(budget):
        if occupied != _ALL:
            occupied = _refill(lanes, memory(members), count, cursor, occupied)
            if occupied == 0:
                break
        for block in range(BLOCKS):
            if occupied >> block * LANES & LANE_BITS != 0:
                w = behind(lanes, block * rows.BLOCK)
                if cubic:
                    expand_cubic_lanes(behind(w, rows.SERIES * LANES), w, order)
                else:
                    expand_linear_lanes(behind(w, rows.SERIES * LANES), w, order)
        near = 0
        for block in range(BLOCKS):
            here = occupied >> block * LANES & LANE_BITS
            if here != 0:
                w = behind(lanes, block * rows.BLOCK)
                near |= _predict(w, t_end, tol, degree, here) << block * LANES
        rooted = settle_roots(lanes, degree, near)
        live = 0
        for block in range(BLOCKS):
            here = occupied >> block * LANES & LANE_BITS
            if here != 0:
                w = behind(lanes, block * rows.BLOCK)
                live |= _complete(w, degree, peak, here) << block * LANES
        if amplitude or peak or steady:
            observe(lanes, degree, half, amplitude, peak, steady, live)
        leaving = occupied & ~live
        done, stalled, halted = 0, 0, 0
        for block in range(BLOCKS):
            first = block * LANES
            if occupied >> first & LANE_BITS != 0:
                w = behind(lanes, block * rows.BLOCK)
                cut, going = rooted >> first & LANE_BITS, live >> first & LANE_BITS
                at_end, stuck, late = _go_on(w, t_end, cut, going, max_steps)
                done |= at_end << first
                stalled |= stuck << first
                halted |= late << first
        leaving |= done | stalled | halted
        while leaving != 0:
            place = lowest(leaving)
            leaving &= leaving - 1
            status = OVERFLOW
            if done >> place & 1:
                status = DONE
            elif stalled >> place & 1:
                status = STALLED
            elif halted >> place & 1:
                status = STEP_LIMIT
            index = cursor[MEMBERS + place]
            end(lanes, place, status, behind(memory(outcomes), index * OUTCOME_COLUMNS))
            cursor[ENDED] += 1
            occupied ^= 1 << place
    cursor[OCCUPIED] = occupied
    behind_us = float(cursor[ENDED])
    for place in range(PLACES):
        if occupied >> place & 1:
            behind_us += lane_of(lanes, place)[rows.T * LANES] / t_end
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
