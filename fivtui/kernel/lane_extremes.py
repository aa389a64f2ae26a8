"""Running extremes of the lanes, exact to rounding: `steps.include` on vectors.

Steps that may reach beyond what was seen wait in a queue, from whatever lanes they come, until
there are eight. What the bounds leave open is settled by `polynomials`, for one step alone.
"""

from typing import Any, Final

import numpy as np

from . import rows
from .jit import inner
from .lane_members import lane_of
from .lane_steps import cubic_bound, curved_at, hull, slope_bound, slope_sway, values_at
from .polynomials import CALLER, widen
from .rows import BLOCKS
from .steps import EXTREMES, NO_EXTREMES, include_part
from .vectors import (
    LANE_BITS,
    LANES,
    absolute,
    behind,
    bits,
    choose,
    greatest,
    lanes_of,
    least,
    load_lanes,
    lowest,
    negated,
    root,
    splat,
    store_lanes,
)

# Which extremes: of x, y and ẋ.
OF_X, OF_Y, OF_VX = range(3)
# A change of this part of the step at an extremum changes its value by the cube of it.
_CLOSE: Final = 4e-6
_ITERATIONS: Final = 100


@inner
def observe(
    work: Any, degree: int, half: float, amplitude: bool, peak: bool, steady: bool, live: int
) -> None:
    """Take the steps of the lanes that are live into what is wanted of the extremes.

    Those are of y over the run, of x and ẋ, and of y after half the horizon.
    """
    of_x, of_y, of_vx, crossing = 0, 0, 0, 0
    for block in range(BLOCKS):
        first = block * LANES
        here = live >> first & LANE_BITS
        if here != 0:
            w = behind(work, block * rows.BLOCK)
            t = load_lanes(w, rows.T)
            if steady:
                end = t + (load_lanes(w, rows.STEP) + load_lanes(w, rows.REST))
                halved = here & bits((t < half) & (end > half))
                crossing |= halved << first
                here &= ~halved
            if amplitude or steady:
                late = here if amplitude else here & bits(t >= half)
                of_y |= _reaching(w, 1, late) << first
            if peak:
                of_x |= _reaching(w, 0, here) << first
                of_vx |= _speeding(w, here) << first
    while crossing != 0:
        _settle_half(work, lowest(crossing), degree, half)
        crossing &= crossing - 1
    waiting = 0
    for extreme in range(3):
        found = of_x if extreme == OF_X else (of_y if extreme == OF_Y else of_vx)
        while found != 0:
            _queue(work, waiting, lowest(found), extreme, degree)
            found &= found - 1
            waiting += 1
            if waiting == LANES:
                _settle(work, degree, waiting)
                waiting = 0
    if waiting > 0:
        _settle(work, degree, waiting)


@inner
def _settle_half(work: Any, place: int, degree: int, half: float) -> None:
    # Take the step in which half the horizon lies into the extremes, which begin anew there.
    w = lane_of(work, place)
    c, row = behind(work, rows.SINGLE), behind(work, rows.ROW)
    scratch, shifted = behind(work, rows.SCRATCH), behind(work, rows.SHIFTED)
    h = w[rows.STEP * LANES]
    middle = min((half - w[rows.T * LANES]) - w[rows.REST * LANES], h)
    for n in range(2 * degree + 2):
        c[n] = w[(rows.SERIES + n) * LANES]
    for n in range(len(EXTREMES)):
        row[n] = w[(rows.SEEN + n) * LANES]
    include_part(c, degree, 0.0, middle, row, scratch, shifted)
    for n in range(len(EXTREMES)):
        w[(rows.EARLIER + n) * LANES] = row[n]
        row[n] = NO_EXTREMES[n]
    include_part(c, degree, middle, h, row, scratch, shifted)
    for n in range(len(EXTREMES)):
        w[(rows.SEEN + n) * LANES] = row[n]


@inner
def _reaching(w: Any, column: int, wanted: int) -> int:
    # Take the ends of the wanted steps of a block into the extremes of x (0) or y (1); returns
    # which may reach beyond in between.
    start, final = load_lanes(w, rows.SERIES + column), load_lanes(w, rows.X + column)
    slope, last_slope = load_lanes(w, rows.SERIES + 2 + column), load_lanes(w, rows.VX + column)
    h, off = load_lanes(w, rows.STEP), load_lanes(w, rows.X_OFF + column)
    low, high = load_lanes(w, rows.SEEN + column), load_lanes(w, rows.SEEN + 2 + column)
    here = lanes_of(wanted)
    low = choose(here, least(low, least(start, final)), low)
    high = choose(here, greatest(high, greatest(start, final)), high)
    store_lanes(w, rows.SEEN + column, low)
    store_lanes(w, rows.SEEN + 2 + column, high)
    bottom, top = hull(start, slope * h, final, last_slope * h)
    return wanted & bits((bottom - off < low) | (top + off > high))


@inner
def _speeding(w: Any, wanted: int) -> int:
    # Which of the wanted steps of a block may reach beyond what was seen of ẋ.
    h, fastest = load_lanes(w, rows.STEP), load_lanes(w, rows.VX_HIGH)
    speed = greatest(load_lanes(w, rows.SERIES + 2), load_lanes(w, rows.VX))
    return wanted & bits(speed * h + load_lanes(w, rows.VX_OFF) > fastest * h)


@inner
def _queue(work: Any, slot: int, place: int, extreme: int, degree: int) -> None:
    # Put the step of a lane into a slot of the queue, for one of its extremes.
    w = lane_of(work, place)
    q = behind(work, rows.CRESTS + slot)
    q[rows.PLACE * LANES] = float(place)
    q[rows.LENGTH * LANES] = w[rows.STEP * LANES]
    q[rows.EXTREME * LANES] = float(extreme)
    if extreme == OF_VX:
        q[rows.LOW * LANES] = -np.inf
        q[rows.HIGH * LANES] = w[rows.VX_HIGH * LANES]
        for n in range(degree):
            q[(rows.QUEUED + n) * LANES] = w[(rows.SERIES + 2 * n + 2) * LANES] * (n + 1.0)
        q[(rows.QUEUED + degree) * LANES] = 0.0
    else:
        q[rows.LOW * LANES] = w[(rows.SEEN + extreme) * LANES]
        q[rows.HIGH * LANES] = w[(rows.SEEN + 2 + extreme) * LANES]
        for n in range(degree + 1):
            q[(rows.QUEUED + n) * LANES] = w[(rows.SERIES + 2 * n + extreme) * LANES]


@inner
def _settle(work: Any, degree: int, count: int) -> None:
    # Take the steps in the first slots into the extremes of where they come from.
    q = behind(work, rows.CRESTS)
    doubtful = _widened(q, degree, (1 << count) - 1)
    scratch = behind(work, rows.SCRATCH)
    while doubtful != 0:
        slot = lowest(doubtful)
        doubtful &= doubtful - 1
        _settle_range(behind(q, slot), degree, scratch)
    for slot in range(count):
        place, extreme = int(q[rows.PLACE * LANES + slot]), int(q[rows.EXTREME * LANES + slot])
        w = lane_of(work, place)
        high = q[rows.HIGH * LANES + slot]
        if extreme == OF_VX:
            w[rows.VX_HIGH * LANES] = high
        else:
            w[(rows.SEEN + extreme) * LANES] = q[rows.LOW * LANES + slot]
            w[(rows.SEEN + 2 + extreme) * LANES] = high


@inner
def _widened(q: Any, degree: int, wanted: int) -> int:
    # Widens the ranges so that they hold those of the polynomials; returns which are in doubt.
    h, c = load_lanes(q, rows.LENGTH), behind(q, rows.QUEUED * LANES)
    start, slope = load_lanes(c, 0), load_lanes(c, 1) * h
    final, last_slope = values_at(c, 0, 1, degree, h)
    last_slope = last_slope * h
    low = least(load_lanes(q, rows.LOW), least(start, final))
    high = greatest(load_lanes(q, rows.HIGH), greatest(start, final))
    store_lanes(q, rows.LOW, low)
    store_lanes(q, rows.HIGH, high)
    slack = cubic_bound(c, 0, 1, degree, h)
    least_value, greatest_value = hull(start, slope, final, last_slope)
    wanted &= bits((least_value - slack < low) | (greatest_value + slack > high))
    if wanted == 0:
        return 0
    turning = (slope > 0.0) ^ (last_slope > 0.0)
    bent = absolute(last_slope - slope) > slope_sway(c, 0, 1, degree, h)
    settled = bent
    if wanted & ~bits(bent) != 0:
        twist = slope_bound(c, 0, 1, degree, h)
        level = (absolute(slope) > twist) & (absolute(last_slope) > twist)
        settled = bent | (level & negated(turning))
    # Where the slope of the cubic vanishes, and what it is there.
    change = final - start
    cube = slope + last_slope - change * 2.0
    half = change * 3.0 - slope * 2.0 - last_slope
    sign = choose(slope > 0.0, 1.0, -1.0)
    square = root(greatest(half * half - cube * slope * 3.0, splat(0.0)))
    crest = absolute(slope) / (square - half * sign)
    crest = choose((crest > 0.0) & (crest < 1.0), crest, 0.5)
    value = start + crest * (slope + crest * (half + crest * cube))
    outside = (value - slack < low) | (value + slack > high)
    single = wanted & bits(bent & turning & outside)
    if single != 0:
        value = _extremum(c, degree, h, crest, sign, single)
        found = lanes_of(single)
        store_lanes(q, rows.LOW, choose(found, least(low, value), low))
        store_lanes(q, rows.HIGH, choose(found, greatest(high, value), high))
    return wanted & ~bits(settled)


@inner
def _extremum(c: Any, degree: int, h: Any, guess: Any, sign: Any, wanted: int) -> Any:
    # The value where the slope, of `sign` at first, vanishes.
    left, right, t, result = splat(0.0), h, guess * h, splat(0.0)
    searching = wanted
    for _ in range(_ITERATIONS):
        value, slope, bend = curved_at(c, 0, 1, degree, t)
        rising = slope * sign > 0.0
        left = choose(rising, t, left)
        right = choose(rising, right, t)
        change = (splat(0.0) - slope) / (bend * 2.0)
        new = t + change
        within = (new > left) & (new < right)
        middle = (left + right) * 0.5
        still = slope == 0.0
        stuck = negated(within) & ((middle <= left) | (middle >= right))
        close = absolute(change) <= h * _CLOSE
        best = choose(close & negated(still), value + slope * change * 0.5, value)
        result = choose(lanes_of(searching), best, result)
        t = choose(within, new, middle)
        searching &= ~bits(still | close | stuck)
        if searching == 0:
            break
    return result


@inner
def _settle_range(q: Any, degree: int, scratch: Any) -> None:
    # Exact extremes of one step.
    h, polynomial = q[rows.LENGTH * LANES], behind(scratch, CALLER)
    power = 1.0
    for n in range(degree + 1):
        polynomial[n] = q[(rows.QUEUED + n) * LANES] * power
        power *= h
    polynomial[degree + 1] = 0.0
    low, high = q[rows.LOW * LANES], q[rows.HIGH * LANES]
    low, high = widen(polynomial, degree + 1, low, high, scratch)
    q[rows.LOW * LANES], q[rows.HIGH * LANES] = low, high
