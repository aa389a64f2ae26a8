"""One Taylor step in every lane: the arithmetic of `steps` on vectors.

A lane's numbers depend on that lane alone, to the last bit, whatever its neighbours do. Where a
bound does not settle a lane, a bit of the result says so; it is left to `polynomials`.
"""

from typing import Any, Final

from ..taylor import EXP2_BIAS
from .jit import inner
from .polynomials import PRECISE
from .steps import BEND, RECIPROCAL, TWIST
from .vectors import (
    absolute,
    bit_numbers,
    bits,
    choose,
    from_bit_numbers,
    greatest,
    lanes_of,
    least,
    load_lanes,
    memory,
    negated,
    root,
    splat,
)

_NEWTON_STEPS: Final = 100
# A change of this part of the step at an extremum changes its value by the cube of it.
_EXTREME: Final = 4e-6
# Of `rough_exp2` in the bits of a float, and an exponent that no step has.
_EXP2_ZERO: Final = (1023.0 - EXP2_BIAS) * 2.0**52
_HUGE: Final = 200.0 * 2.0**52


@inner
def step_sizes(
    c: Any, degree: int, tol: float, deflection: Any, frequency: Any, longest: Any
) -> Any:
    """Lengths of the next steps, s: `single.step_size` in lanes."""
    x, y = absolute(load_lanes(c, 0)), absolute(load_lanes(c, 1))
    vx, vy = absolute(load_lanes(c, 2)), absolute(load_lanes(c, 3))
    speed = greatest(greatest(vx, vy), greatest(greatest(x, y), deflection) * frequency)
    allowed = speed * tol
    wanted = bit_numbers(allowed)
    exponent = splat(_HUGE)
    reciprocals = memory(RECIPROCAL)
    for n in (degree, degree - 1):
        size = greatest(absolute(load_lanes(c, 2 * n)), absolute(load_lanes(c, 2 * n + 1)))
        last = size * float(n)
        ratio = (wanted - bit_numbers(last)) * reciprocals[n - 1]
        exponent = least(exponent, choose(last > 0.0, ratio, _HUGE))
    exponent = choose(allowed > 0.0, exponent, _HUGE)
    return least(from_bit_numbers(exponent + _EXP2_ZERO), longest)


@inner
def values_at(c: Any, first: int, stride: int, degree: int, t: Any) -> Any:
    """Value and slope of a polynomial at `t`; its coefficients are every `stride`-th vector."""
    value, slope = load_lanes(c, first + stride * degree), splat(0.0)
    for n in range(degree - 1, -1, -1):
        slope = slope * t + value
        value = value * t + load_lanes(c, first + stride * n)
    return value, slope


@inner
def bounded_at(c: Any, first: int, stride: int, degree: int, t: Any) -> Any:
    """Value and slope at `t`, and the bounds of `steps.at`."""
    bends, twists = memory(BEND), memory(TWIST)
    value, slope = load_lanes(c, first + stride * degree), splat(0.0)
    size = absolute(value)
    bend, twist = size * bends[degree], size * twists[degree]
    for n in range(degree - 1, -1, -1):
        term = load_lanes(c, first + stride * n)
        slope = slope * t + value
        value = value * t + term
        size = absolute(term)
        bend = bend * t + size * bends[n]
        twist = twist * t + size * twists[n]
    return value, slope, bend, twist


@inner
def first_roots(c: Any, degree: int, h: Any, side: Any, guarded: int) -> Any:
    """The first switches in (0, h], s: `steps.first_root` in lanes.

    Returns times (h where there is none), the bits of the lanes that have one, and of those that
    are not settled. `side` is 1 above the belt and -1 in contact; only `guarded` lanes switch.
    """
    final, final_slope, bend, twist = bounded_at(c, 1, 2, degree, h)
    start, start_slope = load_lanes(c, 1), load_lanes(c, 3) * h
    fresh = start == 0.0
    first = choose(fresh, start_slope, start)
    near = guarded & ~bits(least(side * first, side * final) > bend)
    if near == 0:
        return h, 0, 0
    # After a switch all this is about y/θ, for which the bounds of y are good enough.
    last_slope = final_slope * h
    slope = choose(fresh, load_lanes(c, 5) * (h * h), start_slope)
    last_slope = choose(fresh, last_slope - final, last_slope)
    change = final - first
    level = (absolute(slope) > twist) & (absolute(last_slope) > twist)
    turning = (slope > 0.0) ^ (last_slope > 0.0)
    monotone = (absolute(change) > bend * 4.0) | (level & negated(turning))
    bent = absolute(last_slope - slope) > twist * 4.0
    # Between the tangents at its ends lies all of a curve that bends one way.
    lowest = first + slope * ((change - last_slope) / (slope - last_slope))
    clear = negated(turning) | (side * slope > 0.0) | (side * lowest > 0.0)
    inside = side * first > 0.0
    none = bits(inside & (side * final > 0.0) & (monotone | (bent & clear)))
    one = near & bits(inside & (side * final < 0.0) & (monotone | bent))
    doubtful = near & ~none & ~one
    if one == 0:
        return h, 0, doubtful
    part = (splat(0.0) - first) / change
    rest = 1.0 - part
    guess = part * part * (3.0 - part * 2.0) + change * part * rest * (
        rest / slope - part / last_slope
    )
    guess = choose((guess > 0.0) & (guess < 1.0), guess, part)
    found = _root(c, degree, h, side, fresh, guess, one)
    return choose(lanes_of(one), found, h), one, doubtful


@inner
def _root(c: Any, degree: int, h: Any, side: Any, fresh: Any, guess: Any, wanted: int) -> Any:
    # Newton's method as in `polynomials.refine`; a lane that is done stands still.
    left, right, last = splat(0.0), h, splat(0.0)
    t = guess * h
    searching = wanted
    for _ in range(_NEWTON_STEPS):
        value, slope = values_at(c, 1, 2, degree, t)
        going = lanes_of(searching)
        inside = side * value > 0.0
        left = choose(inside, t, left)
        right = choose(inside, right, t)
        # Of y/t, after a switch.
        new = t - value / choose(fresh, slope - value / t, slope)
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


@inner
def widened(
    c: Any,
    first: int,
    stride: int,
    degree: int,
    h: Any,
    ends: Any,
    seen: Any,
    wanted: int,
) -> Any:
    """Widen ranges so that they hold the polynomial's on [0, h]: `polynomials.widen` in lanes.

    `ends` are the values at 0 and h, the slopes there times h, and the bound of the slope; `seen`
    the least and greatest so far. Returns these, and the bits of the lanes that are not settled.
    """
    start, final, slope, last_slope, twist = ends
    low, high = least(seen[0], least(start, final)), greatest(seen[1], greatest(start, final))
    turning = (slope > 0.0) ^ (last_slope > 0.0)
    bent = absolute(last_slope - slope) > twist * 4.0
    level = (absolute(slope) > twist) & (absolute(last_slope) > twist)
    change = final - start
    bound = start + slope * ((change - last_slope) / (slope - last_slope))
    flat = negated(turning) & (bent | level)
    single = turning & bent
    doubtful = wanted & ~bits(flat | single)
    wanted &= bits(single & ((bound < low) | (bound > high)))
    if wanted != 0:
        # Where the slope of the cubic through both ends vanishes.
        cube = 3.0 * (slope + last_slope - change * 2.0)
        half = change * 3.0 - slope * 2.0 - last_slope
        sign = choose(slope > 0.0, 1.0, -1.0)
        square = root(greatest(half * half - cube * slope, splat(0.0)))
        guess = absolute(slope) / (square - half * sign)
        guess = choose((guess > 0.0) & (guess < 1.0), guess, 0.5)
        value = _extremum(c, first, stride, degree, h, guess, sign, wanted)
        found = lanes_of(wanted)
        low = choose(found, least(low, value), low)
        high = choose(found, greatest(high, value), high)
    return low, high, doubtful


@inner
def _extremum(
    c: Any, first: int, stride: int, degree: int, h: Any, guess: Any, sign: Any, wanted: int
) -> Any:
    # The value where the slope, of `sign` at first, vanishes.
    left, right, t, result = splat(0.0), h, guess * h, splat(0.0)
    searching = wanted
    for _ in range(_NEWTON_STEPS):
        value, slope, bend = load_lanes(c, first + stride * degree), splat(0.0), splat(0.0)
        for n in range(degree - 1, -1, -1):
            bend = bend * t + slope
            slope = slope * t + value
            value = value * t + load_lanes(c, first + stride * n)
        rising = slope * sign > 0.0
        left = choose(rising, t, left)
        right = choose(rising, right, t)
        change = (splat(0.0) - slope) / (bend * 2.0)
        new = t + change
        within = (new > left) & (new < right)
        middle = (left + right) * 0.5
        still = slope == 0.0
        stuck = negated(within) & ((middle <= left) | (middle >= right))
        close = absolute(change) <= h * _EXTREME
        best = choose(close & negated(still), value + slope * change * 0.5, value)
        result = choose(lanes_of(searching), best, result)
        t = choose(within, new, middle)
        searching &= ~bits(still | close | stuck)
        if searching == 0:
            break
    return result
