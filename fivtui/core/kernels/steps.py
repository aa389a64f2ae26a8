"""One Taylor step of one parameter set: its end, its first switch, its extremes.

`c` are the coefficients of x and y, unscaled, one row a degree.
"""

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .expansion import ROWS
from .jit import inner, part
from .polynomials import CALLER, PRECISE, WORK_SIZE, sign_roots, widen
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


def _chord(n: NDArray[np.float64]) -> NDArray[np.float64]:
    # max|θⁿ − θ|
    n = np.maximum(n, 1.0)
    return np.where(n > 1.0, (n - 1.0) * n ** (-n / np.maximum(n - 1.0, 1.0)), 0.0)


def _cubic(n: NDArray[np.float64]) -> NDArray[np.float64]:
    # max|θⁿ − H(θ)| where H has the values and slopes of θⁿ at 0 and 1, from a fine grid.
    part = np.linspace(0.0, 1.0, 4097)
    power = part ** n[:, None]
    there = part * part * ((3.0 - 2.0 * part) + n[:, None] * (part - 1.0))
    return np.where(n > 3.0, 1.0001 * np.abs(power - there).max(axis=1), 0.0)


_N: Final = np.arange(ROWS, dtype=float)
# Bounds of |second derivative|/8 of a polynomial on [0, 1], and of its derivative.
BEND: Final = _N * (_N - 1.0) / 8.0
TWIST: Final = _N * (_N - 1.0) * (_N - 2.0) / 8.0
# Beside `polynomials`, the rates of change of x and y are worked on.
SCRATCH: Final = WORK_SIZE + 2 * ROWS
# A change of this part of the step at an extremum changes its value by the cube of it.
_EXTREME: Final = 4e-6
_ITERATIONS: Final = 100
# Weights of the sizes of a polynomial's terms. Summed, they bound how far it leaves on [0, 1] its
# chord; its slope the chord of that; its slope that of its chord; its second derivative the slope
# of its slope's chord; and itself the cubic with its values and slopes at both ends.
CHORD: Final = _chord(_N)
SLOPE_CHORD: Final = _N * _chord(_N - 1.0)
SWAY: Final = np.maximum(_N - 1.0, 0.0)
SLOPE_SWAY: Final = np.where(_N > 2.0, _N * (_N - 2.0), 0.0)
CUBIC: Final = _cubic(_N)
RECIPROCAL: Final = np.array([0.0, *(1.0 / _N[1:])])


@part
def at(c: Any, degree: int, t: float) -> Any:
    """Values and derivatives of x and y at `t`, and how far they leave their chords on [0, t].

    The last are bounds: of the values, and of the derivatives times t.
    """
    bends, twists = memory(CHORD), memory(SLOPE_CHORD)
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
def _deviations(c: Any, degree: int, t: float) -> Any:
    # Bounds by `SWAY`, `SLOPE_SWAY` and `CUBIC` on [0, t] for x and y.
    sways, slope_sways, cubics = memory(SWAY), memory(SLOPE_SWAY), memory(CUBIC)
    square = t * t
    top = degree // 2
    even, odd = absolute(load_pair(c, 2 * top)), absolute(load_pair(c, 2 * top + 1))
    even_sway, odd_sway = even * sways[2 * top], odd * sways[2 * top + 1]
    even_slope, odd_slope = even * slope_sways[2 * top], odd * slope_sways[2 * top + 1]
    even_cubic, odd_cubic = even * cubics[2 * top], odd * cubics[2 * top + 1]
    for k in range(2 * top - 2, -1, -2):
        even, odd = absolute(load_pair(c, k)), absolute(load_pair(c, k + 1))
        even_sway = even_sway * square + even * sways[k]
        odd_sway = odd_sway * square + odd * sways[k + 1]
        even_slope = even_slope * square + even * slope_sways[k]
        odd_slope = odd_slope * square + odd * slope_sways[k + 1]
        even_cubic = even_cubic * square + even * cubics[k]
        odd_cubic = odd_cubic * square + odd * cubics[k + 1]
    return even_sway + odd_sway * t, even_slope + odd_slope * t, even_cubic + odd_cubic * t


@inner
def scale_column(c: Any, column: int, degree: int, t: float, out: Any) -> None:
    """Coefficients of x (0) or y (1) in θ = time/t."""
    power = 1.0
    for n in range(degree + 1):
        out[n] = c[2 * n + column] * power
        power *= t
    out[degree + 1] = 0.0


@inner
def _curved_at(c: Any, degree: int, t: float) -> Any:
    # Values, derivatives and half the second derivatives of x and y, as `at`.
    square = t * t
    top = degree // 2
    even, odd = load_pair(c, 2 * top), load_pair(c, 2 * top + 1)
    even_slope, odd_slope = even * 0.0, odd * 0.0
    even_bend, odd_bend = even_slope, odd_slope
    for k in range(2 * top - 2, -1, -2):
        even_bend, odd_bend = even_bend * square + even_slope, odd_bend * square + odd_slope
        even_slope, odd_slope = even_slope * square + even, odd_slope * square + odd
        even, odd = even * square + load_pair(c, k), odd * square + load_pair(c, k + 1)
    value = even + odd * t
    slope = odd + (even_slope + odd_slope * t) * (2.0 * t)
    bend = even_slope + odd_slope * (3.0 * t) + (even_bend + odd_bend * t) * (4.0 * square)
    return value, slope, bend


@inner
def first_root(c: Any, degree: int, h: float, side: float, ends: Any, work: Any) -> float:
    """The first switch in (0, h], s, or -1.

    `side` is 1 above the belt and -1 in contact.
    """
    value, slope, bends, twists = ends
    final, bend, twist = element(value, 1), element(bends, 1), element(twists, 1)
    # |y − chord| <= bend; after a switch y starts from zero and the same holds for y/θ.
    fresh = c[1] == 0.0
    first = c[3] * h if fresh else c[1]
    if min(side * first, side * final) > bend:
        return -1.0
    # After a switch all this is about y/θ, for which the bounds of y are good enough.
    last_slope = element(slope, 1) * h
    first_slope = c[5] * h * h if fresh else c[3] * h
    if fresh:
        last_slope -= final
    change = final - first
    turning = (first_slope > 0.0) != (last_slope > 0.0)
    sways, slope_sways, _ = _deviations(c, degree, h)
    monotone = abs(change) > element(sways, 1) or (
        not turning and min(abs(first_slope), abs(last_slope)) > twist
    )
    bent = abs(last_slope - first_slope) > element(slope_sways, 1)
    if side * first > 0.0 and (monotone or bent):
        if side * final < 0.0:
            guess = _guess(first, final, first_slope, last_slope)
            return _refined(c, degree, h, side, fresh, guess * h)
        # Between the tangents at its ends lies all of a curve that bends one way.
        if side * final > 0.0 and (
            monotone
            or not turning
            or side * first_slope > 0.0
            or side * (first + first_slope * ((change - last_slope) / (first_slope - last_slope)))
            > 0.0
        ):
            return -1.0
    y = behind(work, CALLER)
    scale_column(c, 1, degree, h, y)
    if sign_roots(y, degree + 1, 1, work) > 0:
        return work[0] * h
    # A root that rounded out of the step is at its end.
    return h if side * final <= 0.0 else -1.0


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
def _refined(c: Any, degree: int, h: float, side: float, fresh: bool, guess: float) -> float:
    # The root of y, or of y/t after a switch, by Halley's method, kept inside (0, h].
    left, right, last, t = 0.0, h, 0.0, guess
    for _ in range(_ITERATIONS):
        values, slopes, bends = _curved_at(c, degree, t)
        value, slope, bend = element(values, 1), element(slopes, 1), element(bends, 1)
        if value == 0.0:
            break
        if side * value > 0.0:
            left = t
        else:
            right = t
        if fresh:
            share = value / t
            bend -= (slope - share) / t
            slope -= share
        # Equal to -newton / (1 + newton bend / slope) with newton = -value / slope.
        new = t - value * slope / (slope * slope - value * bend)
        change = abs(new - t)
        if change <= t * PRECISE:
            return min(max(new, left), right)
        if left < new < right:
            t = new
            # Changes shrink cubically: the next is about change (change/last)².
            if change < 1e-3 * last and change * (change / last) ** 2 <= t * PRECISE:
                break
            last = change
        else:
            t = 0.5 * (left + right)
            if t <= left or t >= right:
                break
            last = 0.0
    return t


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
    wanted = bits(too_low) | bits(too_high)
    if wanted != 0:
        off = _deviations(c, degree, h)
        for column in range(2):
            if wanted >> column & 1:
                seen = extremes[column], extremes[2 + column]
                low, high = _widened(c, column, degree, h, ends, off, seen, work)
                extremes[column], extremes[2 + column] = low, high
    fastest = extremes[VX_MAX]
    if max(c[2], element(slope, 0)) * h + element(twist, 0) > fastest * h:
        rates = behind(work, WORK_SIZE)
        for n in range(degree):
            store_pair(rates, n, load_pair(c, n + 1) * (n + 1.0))
        store_pair(rates, degree, first * 0.0)
        seen = -np.inf, fastest
        there = at(rates, degree - 1, h)
        off = _deviations(rates, degree - 1, h)
        extremes[VX_MAX] = _widened(rates, 0, degree - 1, h, there, off, seen, work)[1]


@inner
def _widened(
    c: Any,
    column: int,
    degree: int,
    h: float,
    ends: Any,
    off: Any,
    seen: tuple[float, float],
    work: Any,
) -> tuple[float, float]:
    # A range widened so that it holds that of x (0) or y (1) on [0, h].
    first, final = c[column], element(ends[0], column)
    low, high = min(seen[0], first, final), max(seen[1], first, final)
    slope, last_slope = c[2 + column] * h, element(ends[1], column) * h
    # The cubic through both ends lies between these and the values there.
    near, far = first + slope * (1.0 / 3.0), final - last_slope * (1.0 / 3.0)
    slack = element(off[2], column)
    if min(near, far) - slack >= low and max(near, far) + slack <= high:
        return low, high
    turning = (slope > 0.0) != (last_slope > 0.0)
    if not turning and min(abs(slope), abs(last_slope)) > element(ends[3], column):
        return low, high
    if abs(last_slope - slope) > element(off[1], column):
        if not turning:
            return low, high
        change = final - first
        part = _crest(change, slope, last_slope)
        cube, square = slope + last_slope - 2.0 * change, 3.0 * change - 2.0 * slope - last_slope
        value = first + part * (slope + part * (square + part * cube))
        if low <= value - slack and value + slack <= high:
            return low, high
        value = _extremum(c, column, degree, h, part)
        return min(low, value), max(high, value)
    q = behind(work, CALLER)
    scale_column(c, column, degree, h, q)
    return widen(q, degree + 1, low, high, work)


@inner
def _crest(change: float, slope: float, last_slope: float) -> float:
    # Where the slope of the cubic through both ends vanishes, if slopes there differ in sign.
    cube = 3.0 * (slope + last_slope - 2.0 * change)
    half = 3.0 * change - 2.0 * slope - last_slope
    sign = 1.0 if slope > 0.0 else -1.0
    root = math.sqrt(max(half * half - cube * slope, 0.0))
    guess = abs(slope) / (root - half * sign)
    return guess if 0.0 < guess < 1.0 else 0.5


@inner
def _extremum(c: Any, column: int, degree: int, h: float, guess: float) -> float:
    # The value where the slope, which changes sign once, vanishes.
    left, right, t = 0.0, h, guess * h
    rises = c[2 + column] > 0.0
    value = c[column]
    for _ in range(_ITERATIONS):
        values, slopes, bends = _curved_at(c, degree, t)
        value, slope = element(values, column), element(slopes, column)
        if slope == 0.0:
            break
        if (slope > 0.0) == rises:
            left = t
        else:
            right = t
        change = -0.5 * slope / element(bends, column)
        if abs(change) <= h * _EXTREME:
            return value + 0.5 * slope * change
        t += change
        if not left < t < right:
            t = 0.5 * (left + right)
            if t <= left or t >= right:
                break
    return value


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
