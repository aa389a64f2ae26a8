"""One Taylor step in every lane: the arithmetic of `steps` on vectors.

A lane's numbers depend on that lane alone, to the last bit, whatever its neighbours do. Where a
bound does not settle a lane, a bit of the result says so; it is left to `polynomials`.
"""

from typing import Any, Final

from ..taylor import EXP2_BIAS
from .jit import inner
from .polynomials import PRECISE
from .steps import BEND, RECIPROCAL, TWIST
from .variations import slope_variations
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

_ITERATIONS: Final = 100
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
    """Value and slope of a polynomial at `t`, even and odd terms side by side.

    Its coefficients are every `stride`-th vector; an even degree has a zero after the last.
    """
    square = t * t
    top = degree // 2
    even = load_lanes(c, first + stride * (2 * top))
    odd = load_lanes(c, first + stride * (2 * top + 1))
    even_slope, odd_slope = splat(0.0), splat(0.0)
    for k in range(2 * top - 2, -1, -2):
        even_slope = even_slope * square + even
        odd_slope = odd_slope * square + odd
        even = even * square + load_lanes(c, first + stride * k)
        odd = odd * square + load_lanes(c, first + stride * (k + 1))
    return even + odd * t, odd + (even_slope + odd_slope * t) * (t * 2.0)


@inner
def bounded_at(c: Any, first: int, stride: int, degree: int, t: Any) -> Any:
    """Value and slope as from `values_at`, and the bounds of `steps.at`."""
    bends, twists = memory(BEND), memory(TWIST)
    square = t * t
    top = degree // 2
    even = load_lanes(c, first + stride * (2 * top))
    odd = load_lanes(c, first + stride * (2 * top + 1))
    even_slope, odd_slope = splat(0.0), splat(0.0)
    even_size, odd_size = absolute(even), absolute(odd)
    even_bend, odd_bend = even_size * bends[2 * top], odd_size * bends[2 * top + 1]
    even_twist, odd_twist = even_size * twists[2 * top], odd_size * twists[2 * top + 1]
    for k in range(2 * top - 2, -1, -2):
        even_slope = even_slope * square + even
        odd_slope = odd_slope * square + odd
        term, next_term = load_lanes(c, first + stride * k), load_lanes(c, first + stride * (k + 1))
        even = even * square + term
        odd = odd * square + next_term
        even_size, odd_size = absolute(term), absolute(next_term)
        even_bend = even_bend * square + even_size * bends[k]
        odd_bend = odd_bend * square + odd_size * bends[k + 1]
        even_twist = even_twist * square + even_size * twists[k]
        odd_twist = odd_twist * square + odd_size * twists[k + 1]
    value = even + odd * t
    slope = odd + (even_slope + odd_slope * t) * (t * 2.0)
    return value, slope, even_bend + odd_bend * t, even_twist + odd_twist * t


@inner
def _curved_at(c: Any, first: int, stride: int, degree: int, t: Any) -> Any:
    # Value, slope and half the second derivative, as `values_at`.
    square = t * t
    top = degree // 2
    even = load_lanes(c, first + stride * (2 * top))
    odd = load_lanes(c, first + stride * (2 * top + 1))
    even_slope, odd_slope, even_bend, odd_bend = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for k in range(2 * top - 2, -1, -2):
        even_bend = even_bend * square + even_slope
        odd_bend = odd_bend * square + odd_slope
        even_slope = even_slope * square + even
        odd_slope = odd_slope * square + odd
        even = even * square + load_lanes(c, first + stride * k)
        odd = odd * square + load_lanes(c, first + stride * (k + 1))
    value = even + odd * t
    slope = odd + (even_slope + odd_slope * t) * (t * 2.0)
    bend = even_slope + odd_slope * (t * 3.0) + (even_bend + odd_bend * t) * (square * 4.0)
    return value, slope, bend


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
    # Halley's method, kept inside; a lane that is done stands still.
    left, right, last = splat(0.0), h, splat(0.0)
    t = guess * h
    searching = wanted
    for _ in range(_ITERATIONS):
        value, slope, bend = _curved_at(c, 1, 2, degree, t)
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
    the least and greatest so far. Returns these, and the bits of the lanes that are
    not settled.
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
    if doubtful != 0:
        variations = slope_variations(c, first, stride, h)
        wanted |= doubtful & bits(variations == 1.0)
        doubtful &= bits(variations > 1.0)
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
    for _ in range(_ITERATIONS):
        value, slope, bend = _curved_at(c, first, stride, degree, t)
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
