"""One Taylor step in every lane: the arithmetic of `steps` on vectors.

A lane's numbers depend on that lane alone, to the last bit, whatever its neighbours do.
"""

from typing import Any, Final

import numpy as np

from fivtui.taylor import EXP2_BIAS

from .bounds import CUBIC, RECIPROCAL, SLOPE_CHORD, SLOPE_SWAY, SWAY
from .expansion import ROWS
from .jit import inner
from .vectors import (
    absolute,
    bit_numbers,
    choose,
    from_bit_numbers,
    greatest,
    least,
    load_lanes,
    memory,
    splat,
)


def _sharing() -> float:
    # What a bound by `CUBIC` is multiplied by for the polynomial and the cubic divided by θ.
    n, part = np.arange(4.0, ROWS)[:, None], np.linspace(0.0, 1.0, 4097)
    there = part * ((3.0 - 2.0 * part) + n * (part - 1.0))
    off = np.abs(part ** (n - 1.0) - there).max(axis=1)
    return float(1.0001 * (off / CUBIC[4:]).max())


SHARING: Final = _sharing()
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
    """Value and slope as from `values_at`, and `cubic_bound`."""
    weights = memory(CUBIC)
    square = t * t
    top = degree // 2
    even = load_lanes(c, first + stride * (2 * top))
    odd = load_lanes(c, first + stride * (2 * top + 1))
    even_slope, odd_slope = splat(0.0), splat(0.0)
    even_off, odd_off = absolute(even) * weights[2 * top], absolute(odd) * weights[2 * top + 1]
    for k in range(2 * top - 2, -1, -2):
        even_slope = even_slope * square + even
        odd_slope = odd_slope * square + odd
        term, next_term = load_lanes(c, first + stride * k), load_lanes(c, first + stride * (k + 1))
        even = even * square + term
        odd = odd * square + next_term
        # Up to degree three there is nothing to leave.
        if k > 3:
            even_off = even_off * square + absolute(term) * weights[k]
            odd_off = odd_off * square + absolute(next_term) * weights[k + 1]
    slope = odd + (even_slope + odd_slope * t) * (t * 2.0)
    return even + odd * t, slope, (even_off + odd_off * t) * (square * square)


@inner
def hull(start: Any, slope: Any, final: Any, last_slope: Any) -> Any:
    """Numbers between which the cubic with these values and slopes at 0 and 1 lies."""
    near, far = start + slope * (1.0 / 3.0), final - last_slope * (1.0 / 3.0)
    return least(least(start, final), least(near, far)), greatest(
        greatest(start, final), greatest(near, far)
    )


@inner
def hull_of_share(slope: Any, final: Any, last_slope: Any) -> Any:
    """As `hull`, for the cubic from zero divided by its argument."""
    middle = final * 1.5 - last_slope * 0.5
    return least(least(slope, final), middle), greatest(greatest(slope, final), middle)


@inner
def _weighed_at(weights: Any, c: Any, first: int, stride: int, degree: int, t: Any) -> Any:
    square = t * t
    top = degree // 2
    even = absolute(load_lanes(c, first + stride * (2 * top))) * weights[2 * top]
    odd = absolute(load_lanes(c, first + stride * (2 * top + 1))) * weights[2 * top + 1]
    for k in range(2 * top - 2, -1, -2):
        even = even * square + absolute(load_lanes(c, first + stride * k)) * weights[k]
        odd = odd * square + absolute(load_lanes(c, first + stride * (k + 1))) * weights[k + 1]
    return even + odd * t


@inner
def slope_bound(c: Any, first: int, stride: int, degree: int, t: Any) -> Any:
    """How far the slope, times t, leaves its chord on [0, t] at most."""
    return _weighed_at(memory(SLOPE_CHORD), c, first, stride, degree, t)


@inner
def sway(c: Any, first: int, stride: int, degree: int, t: Any) -> Any:
    """How far the slope, times t, leaves that of the polynomial's chord on [0, t] at most."""
    return _weighed_at(memory(SWAY), c, first, stride, degree, t)


@inner
def slope_sway(c: Any, first: int, stride: int, degree: int, t: Any) -> Any:
    """How far the second derivative, times t², leaves the slope of the slope's chord at most."""
    return _weighed_at(memory(SLOPE_SWAY), c, first, stride, degree, t)


@inner
def cubic_bound(c: Any, first: int, stride: int, degree: int, t: Any) -> Any:
    """How far the polynomial leaves the cubic through both of its ends on [0, t] at most."""
    return _weighed_at(memory(CUBIC), c, first, stride, degree, t)


@inner
def curved_at(c: Any, first: int, stride: int, degree: int, t: Any) -> Any:
    """Value, slope and half the second derivative, as `values_at`."""
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
