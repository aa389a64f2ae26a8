"""Many transients at once: Taylor steps of as many parameter sets, one in each lane.

Every lane has its own time, step, mode and problem; all run the cubic field, whose contact terms
are zero off the belt. A lane that is done takes the next problem. The lanes are stepped block by
block; first switches and extrema, which few of the steps have, are then looked for together.
"""

import sys
from typing import Any, Final

import numba

from fivtui.model import PARAMETERS, parameters, slider_belt as model
from fivtui.taylor import polynomial, series, stepper as taylor

from . import (
    bounds,
    expansion,
    lane_blocks,
    lane_extremes,
    lane_members,
    lane_roots,
    lane_steps,
    polynomials,
    rows,
    status,
    steps,
    vectors,
)
from .expansion import expand_cubic_lanes, expand_linear_lanes
from .jit import inner, kernel
from .lane_blocks import go_on, is_sound, may_switch, set_steps, step_x, step_y
from .lane_extremes import observe
from .lane_members import begin, end, lane_of, move
from .lane_roots import settle_roots
from .rows import MEMBER_COLUMNS, OUTCOME_COLUMNS, PLACES
from .status import Status
from .steps import is_finite
from .vectors import LANE_BITS, LANES, behind, lowest, memory, ones

DONE, OVERFLOW, STALLED, STEP_LIMIT = (
    int(code) for code in (Status.DONE, Status.OVERFLOW, Status.STALLED, Status.STEP_LIMIT)
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
    status,
    model,
    parameters,
    polynomial,
    series,
    taylor,
    bounds,
    expansion,
    lane_blocks,
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
        # All blocks before the last are full.
        blocks = (ones(occupied) + LANES - 1) // LANES
        for block in range(blocks):
            w = behind(lanes, block * rows.BLOCK)
            if cubic:
                expand_cubic_lanes(behind(w, rows.SERIES * LANES), w, order)
            else:
                expand_linear_lanes(behind(w, rows.SERIES * LANES), w, order)
        for block in range(blocks):
            set_steps(behind(lanes, block * rows.BLOCK), t_end, tol, degree)
        for block in range(blocks):
            step_y(behind(lanes, block * rows.BLOCK), degree)
        near = 0
        for block in range(blocks):
            near |= may_switch(behind(lanes, block * rows.BLOCK)) << block * LANES
        rooted = settle_roots(lanes, degree, near & occupied)
        for block in range(blocks):
            step_x(behind(lanes, block * rows.BLOCK), degree, peak)
        live = 0
        for block in range(blocks):
            live |= is_sound(behind(lanes, block * rows.BLOCK)) << block * LANES
        live &= occupied
        if amplitude or peak or steady:
            observe(lanes, degree, half, amplitude, peak, steady, live)
        leaving = occupied & ~live
        done, stalled, halted = 0, 0, 0
        for block in range(blocks):
            first = block * LANES
            cut, going = rooted >> first & LANE_BITS, live >> first & LANE_BITS
            at_end, stuck, late = go_on(
                behind(lanes, block * rows.BLOCK), t_end, cut, going, max_steps
            )
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
    """The states at rest at the equilibria of μ = 0: `slider_belt.static_start`.

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
