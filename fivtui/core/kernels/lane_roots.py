"""The first switches of steps, eight steps at a time: `steps.first_root` on vectors.

Steps that may switch wait in a queue, from whatever lanes they come, until there are eight. What
the bounds leave open is settled by `polynomials`, for one step alone.
"""

from typing import Any, Final

from . import rows
from .jit import inner
from .lane_steps import curved_at, slope_bound, sways, values_at
from .polynomials import CALLER, PRECISE, sign_roots
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
def queue_root(work: Any, slot: int, place: int, degree: int) -> None:
    """Put the step of a lane into a slot of the queue."""
    w = behind(work, place // LANES * rows.BLOCK + place % LANES)
    q = behind(work, rows.ROOTS + slot)
    q[rows.PLACE * LANES] = float(place)
    q[rows.LENGTH * LANES] = w[rows.STEP * LANES]
    q[rows.ASIDE * LANES] = w[rows.SIDE * LANES]
    q[rows.FINAL * LANES] = w[rows.Y * LANES]
    q[rows.FINAL_SLOPE * LANES] = w[rows.VY * LANES]
    for n in range(2 * degree + 2):
        q[(rows.QUEUED + n) * LANES] = w[(rows.SERIES + n) * LANES]


@inner
def settle_roots(work: Any, degree: int, count: int) -> int:
    """End the steps in the first slots at their first switches; returns the places that do."""
    q = behind(work, rows.ROOTS)
    doubtful, found = _first_roots(q, degree, (1 << count) - 1)
    scratch = behind(work, rows.SCRATCH)
    while doubtful != 0:
        slot = lowest(doubtful)
        doubtful &= doubtful - 1
        if _settle_root(behind(q, slot), degree, scratch):
            found |= 1 << slot
    h, c = load_lanes(q, rows.LENGTH), behind(q, rows.QUEUED * LANES)
    x, vx = values_at(c, 0, 2, degree, h)
    _, vy = values_at(c, 1, 2, degree, h)
    # The steps' ends, where they began.
    store_lanes(q, rows.QUEUED, x)
    store_lanes(q, rows.QUEUED + 1, vx)
    store_lanes(q, rows.QUEUED + 2, vy)
    places = 0
    while found != 0:
        slot = lowest(found)
        found &= found - 1
        place = int(q[rows.PLACE * LANES + slot])
        places |= 1 << place
        w = behind(work, place // LANES * rows.BLOCK + place % LANES)
        w[rows.STEP * LANES] = q[rows.LENGTH * LANES + slot]
        w[rows.X * LANES] = q[rows.QUEUED * LANES + slot]
        w[rows.VX * LANES] = q[(rows.QUEUED + 1) * LANES + slot]
        w[rows.Y * LANES] = 0.0
        w[rows.VY * LANES] = q[(rows.QUEUED + 2) * LANES + slot]
    return places


@inner
def _first_roots(q: Any, degree: int, wanted: int) -> Any:
    # Shortens the steps that end at a root; returns which are in doubt and which do.
    c = behind(q, rows.QUEUED * LANES)
    h, side = load_lanes(q, rows.LENGTH), load_lanes(q, rows.ASIDE)
    final, last_slope = load_lanes(q, rows.FINAL), load_lanes(q, rows.FINAL_SLOPE) * h
    start, start_slope = load_lanes(c, 1), load_lanes(c, 3) * h
    twist = slope_bound(c, 1, 2, degree, h)
    sway, slope_sway = sways(c, 1, 2, degree, h)
    # After a switch all this is about y/θ, for which the bounds of y are good enough.
    fresh = start == 0.0
    first = choose(fresh, start_slope, start)
    slope = choose(fresh, load_lanes(c, 5) * (h * h), start_slope)
    last_slope = choose(fresh, last_slope - final, last_slope)
    change = final - first
    level = (absolute(slope) > twist) & (absolute(last_slope) > twist)
    turning = (slope > 0.0) ^ (last_slope > 0.0)
    monotone = (absolute(change) > sway) | (level & negated(turning))
    bent = absolute(last_slope - slope) > slope_sway
    # Between the tangents at its ends lies all of a curve that bends one way.
    lowest_value = first + slope * ((change - last_slope) / (slope - last_slope))
    clear = negated(turning) | (side * slope > 0.0) | (side * lowest_value > 0.0)
    inside = side * first > 0.0
    none = bits(inside & (side * final > 0.0) & (monotone | (bent & clear)))
    one = wanted & bits(inside & (side * final < 0.0) & (monotone | bent))
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
        y[n] = q[(rows.QUEUED + 2 * n + 1) * LANES] * power
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
        value, slope, bend = curved_at(c, 1, 2, degree, t)
        going = lanes_of(searching)
        inside = side * value > 0.0
        left = choose(inside, t, left)
        right = choose(inside, right, t)
        # Of y/t, after a switch.
        share = value / t
        bend = choose(fresh, bend - (slope - share) / t, bend)
        slope = choose(fresh, slope - share, slope)
        newton = (splat(0.0) - value) / slope
        new = t + newton / (1.0 + newton * (bend / slope))
        change = absolute(new - t)
        ratio = change / last
        within = (new > left) & (new < right)
        close = change <= t * PRECISE
        next_is_none = (change < last * 1e-3) & (change * ratio * ratio <= t * PRECISE)
        accepted = close | (within & next_is_none)
        middle = (left + right) * 0.5
        stuck = (value == 0.0) | (negated(within | close) & ((middle <= left) | (middle >= right)))
        moved = choose(accepted, least(greatest(new, left), right), choose(within, new, middle))
        t = choose(going & negated(stuck), moved, t)
        last = choose(within, change, 0.0)
        searching &= ~bits(accepted | stuck)
        if searching == 0:
            break
    return t
