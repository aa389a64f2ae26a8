"""One Taylor step of one parameter set: its end, its first switch, its extremes.

`c` are the coefficients of x and y, unscaled, one row a degree.
"""

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import LEAST, pull
from fivtui.taylor import Constants

from .bounds import CUBIC, DEGREES, SLOPE_CUBIC
from .expansion import GROUP, ROWS
from .jit import inner, part, plain
from .polynomials import CALLER, PRECISE, WORK_SIZE, sign_roots, transform, turns, variations, widen
from .vectors import (
    absolute,
    behind,
    bits,
    element,
    fold,
    greatest,
    least,
    load_lanes,
    load_pair,
    memory,
    powers,
    store_lanes,
    store_pair,
)

# One row of extremes.
EXTREMES: Final = ("x_min", "y_min", "x_max", "y_max", "vx_max")
NO_EXTREMES: Final = np.array([np.inf, np.inf, -np.inf, -np.inf, -np.inf])
VX_MAX: Final = 4
CONTACT: Final = 1


def _grouped(weights: NDArray[np.float64]) -> NDArray[np.float64]:
    # One weight for x and one for y, from the first group of rows on.
    return np.repeat(weights[2:], 2)


# Beside `polynomials`, the rates of change of x and y are worked on.
SCRATCH: Final = WORK_SIZE + 2 * (ROWS + GROUP)
# A change of this part of the step at an extremum changes its value by the cube of it.
_EXTREME: Final = 4e-6
_ITERATIONS: Final = 100
# A change that is less than this part of a root, and that Newton's method would not make, is none.
STILL: Final = 1e-6
# Weights of the terms in the derivatives.
_SLOPE: Final = _grouped(DEGREES)
_CURVE: Final = _grouped(DEGREES * (DEGREES - 1.0) / 2.0)
_OFF: Final = _grouped(CUBIC)
_SLOPE_OFF: Final = _grouped(SLOPE_CUBIC)
_THIRD: Final = 1.0 / 3.0
_YX, _YY, _YVY = (Constants._fields.index(name) for name in ("yx", "yy", "yvy"))
_pull: Final = plain(pull)


@part
def at(c: Any, degree: int, t: float) -> Any:
    """Values and derivatives of x and y at `t`."""
    groups, slopes = behind(c, 4), memory(_SLOPE)
    square = t * t
    fourth, parts = square * square, powers(t, square)
    top = (degree - 1) // GROUP - 1
    value = load_lanes(groups, top)
    slope = value * load_lanes(slopes, top)
    for k in range(top - 1, -1, -1):
        term = load_lanes(groups, k)
        value = value * fourth + term
        slope = slope * fourth + term * load_lanes(slopes, k)
    first, rate = load_pair(c, 0), load_pair(c, 1)
    return first + rate * t + fold(value * parts) * square, rate + fold(slope * parts) * t


@part
def ends_of(c: Any, degree: int, h: float) -> Any:
    """As `at`, and how far x and y, and their slopes times h, leave on [0, h] those of cubics.

    The cubics have the values and slopes of x and y at both ends.
    """
    value, slope = at(c, degree, h)
    groups, weights, slope_weights = behind(c, 4), memory(_OFF), memory(_SLOPE_OFF)
    square = h * h
    fourth, parts = square * square, powers(h, square)
    top = (degree - 1) // GROUP - 1
    size = absolute(load_lanes(groups, top))
    off, slope_off = size * load_lanes(weights, top), size * load_lanes(slope_weights, top)
    for k in range(top - 1, -1, -1):
        size = absolute(load_lanes(groups, k))
        off = off * fourth + size * load_lanes(weights, k)
        slope_off = slope_off * fourth + size * load_lanes(slope_weights, k)
    return value, slope, fold(off * parts) * square, fold(slope_off * parts) * square


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
    # Values, derivatives and half the second derivatives of x and y.
    groups, slopes, curves = behind(c, 4), memory(_SLOPE), memory(_CURVE)
    square = t * t
    fourth, parts = square * square, powers(t, square)
    top = (degree - 1) // GROUP - 1
    value = load_lanes(groups, top)
    slope, bend = value * load_lanes(slopes, top), value * load_lanes(curves, top)
    for k in range(top - 1, -1, -1):
        term = load_lanes(groups, k)
        value = value * fourth + term
        slope = slope * fourth + term * load_lanes(slopes, k)
        bend = bend * fourth + term * load_lanes(curves, k)
    first, rate = load_pair(c, 0), load_pair(c, 1)
    return (
        first + rate * t + fold(value * parts) * square,
        rate + fold(slope * parts) * t,
        fold(bend * parts),
    )


@part
def first_root(c: Any, degree: int, h: float, side: float, ends: Any, work: Any) -> float:
    """The first switch in (0, h], s, or -1.

    `side` is 1 above the belt and -1 in contact.
    """
    values, slopes, offs, slope_offs = ends
    # What follows is about the distance from the belt; after a switch that starts from zero, and
    # it is about the distance over θ, for which the bounds are good enough.
    first, final = side * c[1], side * element(values, 1)
    slope, last_slope = side * h * c[3], side * h * element(slopes, 1)
    if first == 0.0:
        first, slope, last_slope = slope, side * h * h * c[5], last_slope - final
    near, far = first + slope * _THIRD, final - last_slope * _THIRD
    off = element(offs, 1)
    if min(first, near, far, final) > off:
        return -1.0
    curve = (first, near, far, final), (slope, last_slope)
    return _settled(c, degree, h, side, curve, element(slope_offs, 1), work)


@inner
def _settled(
    c: Any, degree: int, h: float, side: float, curve: Any, slope_off: float, work: Any
) -> float:
    # The first switch, where the values alone do not rule it out.
    (first, near, far, final), (slope, last_slope) = curve
    fresh, b = c[1] == 0.0, behind(work, CALLER)
    falls = first > 0.0 and final < 0.0
    if first > 0.0 and final != 0.0 and _is_monotone(near, far, slope, last_slope, slope_off):
        found = 1 if falls else 0
    else:
        skipped = 1 if fresh else 0
        transform(behind(c, 2 * skipped + 1), 2, degree + 1 - skipped, h, b)
        found = variations(b, degree + 1 - skipped)
    if falls and found == 1:
        guess = _guess(first, final, slope, last_slope)
        return _refined(c, degree, h, side, fresh, guess * h)
    if found > 0:
        scale_column(c, 1, degree, h, b)
        if sign_roots(b, degree + 1, 1, work) > 0:
            return work[0] * h
    # A root that rounded out of the step is at its end.
    return h if final <= 0.0 else -1.0


@part
def _is_monotone(
    near: float, far: float, slope: float, last_slope: float, slope_off: float
) -> bool:
    # Whether the slope, near to that of a cubic, keeps its sign.
    middle = 3.0 * (far - near)
    return max(slope, last_slope, middle) < -slope_off or min(slope, last_slope, middle) > slope_off


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
        step = value * slope / (slope * slope - value * bend)
        new = t - step
        change = abs(new - t)
        # Halley's method stands still at an extremum too: there Newton's would not.
        near = abs(value) <= 2.0 * abs(step * slope)
        if near and change <= t * PRECISE:
            return min(max(new, left), right)
        if left < new < right and (near or change > STILL * t):
            t = new
            # Changes shrink cubically: the next is about change (change/last)².
            if near and change < 1e-3 * last and change * (change / last) ** 2 <= t * PRECISE:
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
    """The mode in which the motion goes on from y = 0: `slider_belt.mode_of` there."""
    direction = vy
    if direction == 0.0:
        direction = _pull(coupling, preload, x)
    if direction == 0.0 and abs(coupling * vx) > LEAST:
        direction = coupling * vx
    if direction == 0.0:
        direction = -coupling * x
    return 0 if direction > 0.0 else CONTACT


@inner
def settle(
    y: Any, stride: int, x: float, vx: float, forces: tuple[float, float], given: Any, apart: int
) -> None:
    """Acceleration and jerk at y = 0, where the forces balance to rounding: `taylor.stepper` there.

    `y` are its coefficients, `stride` apart, and `given` the `Constants`, `apart`.
    """
    if _pull(forces[0], forces[1], x) == 0.0:
        vy, damping = y[stride], given[_YVY * apart]
        half = 0.5 * damping * vy
        y[2 * stride] = half
        sixth = given[_YX * apart] * vx + given[_YY * apart] * vy + 2.0 * damping * half
        y[3 * stride] = sixth / 6.0


@part
def include(c: Any, degree: int, h: float, ends: Any, extremes: Any, work: Any) -> None:
    """Take the motion over [0, h] into one row of the extremes."""
    final, last_slope, off, slope_off = ends
    first, slope, last_slope = load_pair(c, 0), load_pair(c, 1) * h, last_slope * h
    # The cubic through both ends lies between these and the values there.
    near, far = first + slope * _THIRD, final - last_slope * _THIRD
    low = least(least(first, near), least(far, final)) - off
    high = greatest(greatest(first, near), greatest(far, final)) + off
    wanted = bits(low < load_pair(extremes, 0)) | bits(high > load_pair(extremes, 1))
    if wanted != 0:
        _include_values(c, degree, h, ends, extremes, wanted, work)
    middle = (far - near) * 3.0
    fastest = greatest(greatest(slope, last_slope), middle) + slope_off
    if element(fastest, 0) > extremes[VX_MAX] * h:
        _include_speed(c, degree, h, extremes, work)


@inner
def _include_values(
    c: Any, degree: int, h: float, ends: Any, extremes: Any, wanted: int, work: Any
) -> None:
    for column in range(2):
        if wanted >> column & 1:
            seen = extremes[column], extremes[2 + column]
            low, high = _widened(c, column, degree, h, ends, seen, work)
            extremes[column], extremes[2 + column] = low, high


@inner
def _include_speed(c: Any, degree: int, h: float, extremes: Any, work: Any) -> None:
    # The rates of change are polynomials with a zero for their last coefficient.
    rates, slopes = behind(work, WORK_SIZE), memory(_SLOPE)
    store_pair(rates, 0, load_pair(c, 1))
    store_pair(rates, 1, load_pair(c, 2) * 2.0)
    for k in range((degree - 1) // GROUP):
        term = load_lanes(behind(c, 6), k) * (load_lanes(slopes, k) + 1.0)
        store_lanes(behind(rates, 4), k, term)
    store_pair(rates, degree, load_pair(rates, 0) * 0.0)
    seen = -np.inf, extremes[VX_MAX]
    ends = ends_of(rates, degree, h)
    extremes[VX_MAX] = _widened(rates, 0, degree, h, ends, seen, work)[1]


@inner
def _widened(
    c: Any, column: int, degree: int, h: float, ends: Any, seen: tuple[float, float], work: Any
) -> tuple[float, float]:
    # A range widened so that it holds that of x (0) or y (1) on [0, h].
    values, slopes, offs, slope_offs = ends
    first, final = c[column], element(values, column)
    low, high = min(seen[0], first, final), max(seen[1], first, final)
    slope, last_slope = c[2 + column] * h, element(slopes, column) * h
    near, far = first + slope * _THIRD, final - last_slope * _THIRD
    off, slope_off = element(offs, column), element(slope_offs, column)
    if min(near, far) - off >= low and max(near, far) + off <= high:
        return low, high
    if _is_monotone(near, far, slope, last_slope, slope_off):
        return low, high
    turning = (slope > 0.0) != (last_slope > 0.0)
    crest = 0.5
    if turning:
        change = final - first
        crest = _crest(change, slope, last_slope)
        cube, square = slope + last_slope - 2.0 * change, 3.0 * change - 2.0 * slope - last_slope
        value = first + crest * (slope + crest * (square + crest * cube))
        if not 0.0 < crest < 1.0:
            crest = 0.5
        elif low <= value - off and value + off <= high:
            return low, high
    b = behind(work, CALLER)
    transform(behind(c, column), 2, degree + 1, h, b)
    found = turns(b, degree + 1)
    if found == 0:
        return low, high
    if found == 1 and turning:
        value = _extremum(c, column, degree, h, crest)
        return min(low, value), max(high, value)
    scale_column(c, column, degree, h, b)
    return widen(b, degree + 1, low, high, work)


@inner
def _crest(change: float, slope: float, last_slope: float) -> float:
    # Where the slope of the cubic through both ends vanishes, if slopes there differ in sign; not
    # in (0, 1) where rounding hides it.
    cube = 3.0 * (slope + last_slope - 2.0 * change)
    half = 3.0 * change - 2.0 * slope - last_slope
    sign = 1.0 if slope > 0.0 else -1.0
    root = math.sqrt(max(half * half - cube * slope, 0.0))
    # Two forms of the same, each of which cancels where the other does not.
    if half * sign > 0.0:
        return -(half + sign * root) / cube
    return abs(slope) / (root - half * sign)


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
    include(shifted, degree, h, ends_of(shifted, degree, h), extremes, work)
