"""The first switches of steps, eight steps at a time: `steps.first_root` on vectors.

Steps that may switch wait in a queue, from whatever lanes they come, until there are eight. What
the bounds leave open is settled by `polynomials`, for one step alone.
"""

from typing import Any, Final

from . import rows
from .jit import inner
from .lane_members import lane_of
from .lane_steps import curved_at, slope_bound, slope_sway, sway, values_at
from .polynomials import CALLER, PRECISE, sign_roots
from .steps import STILL, settle
from .vectors import (
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
    splat,
    store_lanes,
)

_ITERATIONS: Final = 100


@inner
def settle_roots(work: Any, degree: int, near: int) -> int:
    """End the steps of the lanes in which there may be a switch at the first one, if there is one.

    Returns the lanes in which there is.
    """
    rooted, waiting = 0, 0
    while near != 0:
        _queue(work, waiting, lowest(near), degree)
        near &= near - 1
        waiting += 1
        if waiting == LANES or near == 0:
            rooted |= _settle(work, degree, waiting)
            waiting = 0
    return rooted


@inner
def _queue(work: Any, slot: int, place: int, degree: int) -> None:
    # Put the step of a lane into a slot of the queue.
    w = lane_of(work, place)
    q = behind(work, rows.ROOTS + slot)
    q[rows.PLACE * LANES] = float(place)
    q[rows.LENGTH * LANES] = w[rows.STEP * LANES]
    q[rows.ASIDE * LANES] = w[rows.SIDE * LANES]
    q[rows.FINAL * LANES] = w[rows.Y * LANES]
    q[rows.FINAL_SLOPE * LANES] = w[rows.VY * LANES]
    for n in range(degree + 1):
        q[(rows.QUEUED + n) * LANES] = w[(rows.SERIES + 2 * n + 1) * LANES]
    series = behind(w, rows.SERIES * LANES)
    if series[LANES] == 0.0:
        forces = w[rows.COUPLING * LANES], w[rows.PRELOAD * LANES]
        settle(
            behind(q, rows.QUEUED * LANES), LANES, series[0], series[2 * LANES], forces, w, LANES
        )


@inner
def _settle(work: Any, degree: int, count: int) -> int:
    # End the steps in the first slots at their first switches; returns the places that do.
    q = behind(work, rows.ROOTS)
    doubtful, found = _first_roots(q, degree, (1 << count) - 1)
    scratch = behind(work, rows.SCRATCH)
    while doubtful != 0:
        slot = lowest(doubtful)
        doubtful &= doubtful - 1
        if _settle_root(behind(q, slot), degree, scratch):
            found |= 1 << slot
    h, c = load_lanes(q, rows.LENGTH), behind(q, rows.QUEUED * LANES)
    _, vy = values_at(c, 0, 1, degree, h)
    store_lanes(q, rows.FINAL_SLOPE, vy)
    places = 0
    while found != 0:
        slot = lowest(found)
        found &= found - 1
        place = int(q[rows.PLACE * LANES + slot])
        places |= 1 << place
        w = lane_of(work, place)
        w[rows.STEP * LANES] = q[rows.LENGTH * LANES + slot]
        w[rows.Y * LANES] = 0.0
        w[rows.VY * LANES] = q[rows.FINAL_SLOPE * LANES + slot]
    return places


@inner
def _first_roots(q: Any, degree: int, wanted: int) -> Any:
    # Shortens the steps that end at a root; returns which are in doubt and which do.
    c = behind(q, rows.QUEUED * LANES)
    h, side = load_lanes(q, rows.LENGTH), load_lanes(q, rows.ASIDE)
    final, last_slope = load_lanes(q, rows.FINAL), load_lanes(q, rows.FINAL_SLOPE) * h
    start, start_slope = load_lanes(c, 0), load_lanes(c, 1) * h
    # After a switch all this is about y/θ, for which the bounds of y are good enough.
    fresh = start == 0.0
    first = choose(fresh, start_slope, start)
    slope = choose(fresh, load_lanes(c, 2) * (h * h), start_slope)
    last_slope = choose(fresh, last_slope - final, last_slope)
    change = final - first
    # Whether there is one root at most, and none if the ends are on one side.
    single = absolute(change) > sway(c, 0, 1, degree, h)
    clear = single
    if wanted & ~bits(single) != 0:
        twist = slope_bound(c, 0, 1, degree, h)
        level = (absolute(slope) > twist) & (absolute(last_slope) > twist)
        turning = (slope > 0.0) ^ (last_slope > 0.0)
        clear = clear | (level & negated(turning))
        bent = absolute(last_slope - slope) > slope_sway(c, 0, 1, degree, h)
        # Between the tangents at its ends lies all of a curve that bends one way.
        bound = first + slope * ((change - last_slope) / (slope - last_slope))
        one_sided = negated(turning) | (side * slope > 0.0) | (side * bound > 0.0)
        single = clear | bent
        clear = clear | (bent & one_sided)
    inside = side * first > 0.0
    none = bits(inside & (side * final > 0.0) & clear)
    one = wanted & bits(inside & (side * final < 0.0) & single)
    if one != 0:
        part = (splat(0.0) - first) / change
        rest = 1.0 - part
        guess = part * part * (3.0 - part * 2.0) + change * part * rest * (
            rest / slope - part / last_slope
        )
        guess = choose((guess > 0.0) & (guess < 1.0), guess, part)
        found = _root(c, degree, h, side, fresh, guess, one)
        store_lanes(q, rows.LENGTH, choose(lanes_of(one), found, h))
    return wanted & ~none & ~one, one


@inner
def _settle_root(q: Any, degree: int, scratch: Any) -> bool:
    # The first root of one step, exactly; the step ends at it.
    side, h = q[rows.ASIDE * LANES], q[rows.LENGTH * LANES]
    y = behind(scratch, CALLER)
    power, final = 1.0, 0.0
    for n in range(degree + 1):
        y[n] = q[(rows.QUEUED + n) * LANES] * power
        final += y[n]
        power *= h
    y[degree + 1] = 0.0
    if sign_roots(y, degree + 1, 1, scratch) > 0:
        q[rows.LENGTH * LANES] = h * scratch[0]
        return True
    # A root that rounded out of the step is at its end.
    return side * final <= 0.0


@inner
def _root(c: Any, degree: int, h: Any, side: Any, fresh: Any, guess: Any, wanted: int) -> Any:
    # Halley's method, kept inside; a step that is done stands still.
    left, right, last = splat(0.0), h, splat(0.0)
    t = guess * h
    searching = wanted
    for _ in range(_ITERATIONS):
        value, slope, bend = curved_at(c, 0, 1, degree, t)
        going = lanes_of(searching)
        inside = side * value > 0.0
        left = choose(inside, t, left)
        right = choose(inside, right, t)
        # Of y/t, after a switch.
        rise = slope * t - value
        slope, bend = choose(fresh, rise, slope), choose(fresh, bend * (t * t) - rise, bend)
        length = choose(fresh, t, splat(1.0))
        step = (value * slope) / (slope * slope - value * bend)
        new = t - length * step
        change = absolute(new - t)
        # Halley's method stands still at an extremum too: there Newton's would not.
        near = absolute(value) <= absolute(step * slope) * 2.0
        within = (new > left) & (new < right) & (near | (change > t * STILL))
        close = near & (change <= t * PRECISE)
        # Changes shrink cubically: the next is about change (change/last)².
        next_is_none = change * change * change <= last * last * (t * PRECISE)
        accepted = close | (near & within & (change < last * 1e-3) & next_is_none)
        middle = (left + right) * 0.5
        stuck = (value == 0.0) | (negated(within | close) & ((middle <= left) | (middle >= right)))
        moved = choose(accepted, least(greatest(new, left), right), choose(within, new, middle))
        t = choose(going & negated(stuck), moved, t)
        last = choose(within, change, 0.0)
        searching &= ~bits(accepted | stuck)
        if searching == 0:
            break
    return t
