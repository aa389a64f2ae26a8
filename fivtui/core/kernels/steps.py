"""One Taylor step of one parameter set: its end, its first switch, its extremes.

`c` are the coefficients of x and y, unscaled, one row a degree.
"""

from typing import Any, Final

import numpy as np

from .expansion import ROWS
from .jit import inner
from .polynomials import CALLER, PRECISE, refine, sign_roots, widen
from .vectors import (
    absolute,
    behind,
    bits,
    element,
    greatest,
    least,
    load_pair,
    memory,
    store_pair,
)

# One row of extremes.
EXTREMES: Final = ("x_min", "y_min", "x_max", "y_max", "vx_max")
NO_EXTREMES: Final = np.array([np.inf, np.inf, -np.inf, -np.inf, -np.inf])
VX_MAX: Final = 4
CONTACT: Final = 1

_N: Final = np.arange(ROWS, dtype=float)
# Bounds of |second derivative|/8 of a polynomial on [0, 1], and of its derivative.
BEND: Final = _N * (_N - 1.0) / 8.0
TWIST: Final = _N * (_N - 1.0) * (_N - 2.0) / 8.0
RECIPROCAL: Final = np.array([0.0, *(1.0 / _N[1:])])


@inner
def at(c: Any, degree: int, t: float) -> Any:
    """Values and derivatives of x and y at `t`, and how far they leave their chords on [0, t].

    The last are bounds: of the values by max|second derivative|/8, and of the derivatives times
    t, likewise.
    """
    bends, twists = memory(BEND), memory(TWIST)
    square = t * t
    top = degree // 2
    even, odd = load_pair(c, 2 * top), load_pair(c, 2 * top + 1)
    even_slope, odd_slope = even * 0.0, odd * 0.0
    even_size, odd_size = absolute(even), absolute(odd)
    even_bend, odd_bend = even_size * bends[2 * top], odd_size * bends[2 * top + 1]
    even_twist, odd_twist = even_size * twists[2 * top], odd_size * twists[2 * top + 1]
    for k in range(2 * top - 2, -1, -2):
        even_slope, odd_slope = even_slope * square + even, odd_slope * square + odd
        term, next_term = load_pair(c, k), load_pair(c, k + 1)
        even, odd = even * square + term, odd * square + next_term
        even_size, odd_size = absolute(term), absolute(next_term)
        even_bend = even_bend * square + even_size * bends[k]
        odd_bend = odd_bend * square + odd_size * bends[k + 1]
        even_twist = even_twist * square + even_size * twists[k]
        odd_twist = odd_twist * square + odd_size * twists[k + 1]
    value = even + odd * t
    slope = odd + (even_slope + odd_slope * t) * (2.0 * t)
    return value, slope, even_bend + odd_bend * t, even_twist + odd_twist * t


@inner
def scale_column(c: Any, column: int, degree: int, t: float, out: Any) -> None:
    """Coefficients of x (0) or y (1) in θ = time/t."""
    power = 1.0
    for n in range(degree + 1):
        out[n] = c[2 * n + column] * power
        power *= t
    out[degree + 1] = 0.0


@inner
def first_root(c: Any, degree: int, h: float, side: float, ends: Any, work: Any) -> float:
    """The first switch in (0, h] as a part of h, or -1.

    `side` is 1 above the belt and -1 in contact.
    """
    value, slope, bend, twist = ends
    start, final = c[1], element(value, 1)
    first_slope, last_slope = c[3] * h, element(slope, 1) * h
    # |y − chord| <= bend; after a switch y starts from zero and the same holds for y/θ.
    first = side * (start if start != 0.0 else first_slope)
    if min(first, side * final) > element(bend, 1):
        return -1.0
    y = behind(work, CALLER)
    scale_column(c, 1, degree, h, y)
    monotone = abs(final - start) > 4.0 * element(bend, 1) or (
        (first_slope > 0.0) == (last_slope > 0.0)
        and min(abs(first_slope), abs(last_slope)) > element(twist, 1)
    )
    if monotone and start != 0.0:
        if side * final > 0.0:
            return -1.0
        if final == 0.0:
            return 1.0
        guess = _guess(start, final, first_slope, last_slope)
        return refine(y, degree + 1, (0.0, 1.0), start < 0.0, guess, PRECISE)
    if sign_roots(y, degree + 1, 1, work) > 0:
        return work[0]
    # A root that rounded out of the step is at its end.
    return 1.0 if side * final <= 0.0 else -1.0


@inner
def _guess(start: float, final: float, slope: float, last_slope: float) -> float:
    # Where the cubic through both ends of the inverse function says that the root is.
    change = final - start
    part = -start / change
    rest = 1.0 - part
    if slope == 0.0 or last_slope == 0.0:
        return part
    guess = part * part * (3.0 - 2.0 * part) + change * part * rest * (
        rest / slope - part / last_slope
    )
    return guess if 0.0 < guess < 1.0 else part


@inner
def is_finite(number: float) -> bool:
    """Whether a number is neither infinite nor NaN."""
    return number - number == 0.0


@inner
def mode_after(x: float, vx: float, vy: float, coupling: float, preload: float) -> int:
    """The mode in which the motion goes on from y = 0: `core.model.mode_of` there."""
    direction = vy
    if direction == 0.0:
        direction = coupling * x - preload
    if direction == 0.0:
        direction = coupling * vx
    if direction == 0.0:
        direction = -coupling * x
    return 0 if direction > 0.0 else CONTACT


@inner
def include(c: Any, degree: int, h: float, ends: Any, extremes: Any, work: Any) -> None:
    """Take the motion over [0, h] into one row of the extremes."""
    value, slope, bend, twist = ends
    first = load_pair(c, 0)
    too_low = least(first, value) - bend < load_pair(extremes, 0)
    too_high = greatest(first, value) + bend > load_pair(extremes, 1)
    q = behind(work, CALLER)
    wanted = bits(too_low) | bits(too_high)
    if wanted != 0:
        for column in range(2):
            if wanted >> column & 1:
                scale_column(c, column, degree, h, q)
                low, high = widen(q, degree + 1, extremes[column], extremes[2 + column], work)
                extremes[column], extremes[2 + column] = low, high
    fastest = extremes[VX_MAX] * h
    if max(c[2], element(slope, 0)) * h + element(twist, 0) > fastest:
        power = h
        for n in range(degree):
            q[n] = (n + 1) * c[2 * n + 2] * power
            power *= h
        q[degree] = 0.0
        extremes[VX_MAX] = widen(q, degree, -np.inf, fastest, work)[1] / h


@inner
def include_part(
    c: Any, degree: int, left: float, right: float, extremes: Any, work: Any, shifted: Any
) -> None:
    """Take the motion over [left, right] into one row of the extremes."""
    if not left < right:
        return
    for n in range(degree + 1):
        store_pair(shifted, n, load_pair(c, n))
    for start in range(degree):
        for n in range(degree - 1, start - 1, -1):
            store_pair(shifted, n, load_pair(shifted, n) + load_pair(shifted, n + 1) * left)
    h = right - left
    include(shifted, degree, h, at(shifted, degree, h), extremes, work)
