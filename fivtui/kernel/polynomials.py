"""Real roots and extreme values of polynomials on [0, 1], as in `taylor.polynomial`.

A polynomial is its coefficients in memory, constant term first, and a zero after the last. `work`
is scratch memory of `WORK_SIZE` numbers, in rows.
"""

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.taylor import MAX_DEPTH

from .expansion import ROWS
from .jit import inner, part
from .vectors import (
    LANES,
    behind,
    bits,
    element,
    load_lanes,
    load_pair,
    memory,
    ones,
    splat,
    store_lanes,
)

# Relative errors of a root that are as good as none: for its own sake, and for the value of a
# function at its extremum, which depends on their square.
PRECISE: Final = 2.0**-53
EXTREME: Final = 1e-9
_NEWTON_STEPS: Final = 100

_VECTORS: Final = 3
_PADDED: Final = _VECTORS * LANES
# A row of `work` holds the Bernstein coefficients on a subinterval, then its ends and its depth.
_LEFT, _RIGHT, _DEPTH = _PADDED, _PADDED + 1, _PADDED + 2
_WIDTH: Final = _PADDED + LANES
# The first rows are for the roots found, for scratch, a derivative, and for the caller; the others
# are the stack of subintervals.
_FOUND: Final = 0
_SPARE: Final = _WIDTH
_SLOPE: Final = 2 * _WIDTH
CALLER: Final = 3 * _WIDTH
_STACK: Final = 4 * _WIDTH
WORK_SIZE: Final = _STACK + (MAX_DEPTH + 4) * _WIDTH


def _to_bernstein() -> NDArray[np.float64]:
    # For every size: power coefficients down, Bernstein coefficients across.
    table = np.zeros((ROWS + 1, _PADDED, _PADDED))
    for size in range(1, ROWS + 1):
        for n in range(size):
            for i in range(n, size):
                table[size, n, i] = math.comb(i, n) / math.comb(size - 1, n)
    return table


_TO_BERNSTEIN: Final = _to_bernstein().ravel()
_NOTHING: Final = np.zeros(_PADDED)


@inner
def evaluate(c: Any, size: int, t: float) -> float:
    """Value by Horner's rule, even and odd terms side by side."""
    square = t * t
    top = (size - 1) // 2
    value = load_pair(c, top)
    for k in range(top - 1, -1, -1):
        value = value * square + load_pair(c, k)
    return element(value, 0) + element(value, 1) * t


@inner
def refine(
    c: Any, size: int, bracket: tuple[float, float], negative: bool, guess: float, close: float
) -> float:
    """The root in a bracket over which the sign changes once: Newton's method, kept inside.

    `negative` says that the polynomial is negative at the left end; `close` is the relative error
    allowed.
    """
    left, right = bracket
    t = guess
    if not left < t < right:
        t = 0.5 * (left + right)
    last = 0.0
    top = (size - 1) // 2
    for _ in range(_NEWTON_STEPS):
        square = t * t
        terms = load_pair(c, top)
        changes = terms * 0.0
        for k in range(top - 1, -1, -1):
            changes = changes * square + terms
            terms = terms * square + load_pair(c, k)
        value = element(terms, 0) + element(terms, 1) * t
        slope = element(terms, 1) + 2.0 * t * (element(changes, 0) + element(changes, 1) * t)
        if value == 0.0:
            break
        if (value < 0.0) == negative:
            left = t
        else:
            right = t
        new = t - value / slope if slope != 0.0 else left
        change = abs(new - t)
        if change <= close * t:
            return min(max(new, left), right)
        if left < new < right:
            t = new
            # Newton's changes shrink quadratically: the next is about change³/last².
            if change < 1e-3 * last and change * (change / last) ** 2 <= close * t:
                break
            last = change
        else:
            t = 0.5 * (left + right)
            if t <= left or t >= right:
                break
            last = 0.0
    return t


@part
def transform(c: Any, stride: int, size: int, h: float, b: Any) -> None:
    """Bernstein coefficients on [0, h] of the polynomial whose coefficients are every `stride`-th.

    They are followed by zeros up to the end of a row.
    """
    table = behind(memory(_TO_BERNSTEIN), size * _PADDED * _PADDED)
    first, second, third, power = splat(0.0), splat(0.0), splat(0.0), 1.0
    for n in range(size):
        factor = c[stride * n] * power
        first = first + load_lanes(table, _VECTORS * n) * factor
        second = second + load_lanes(table, _VECTORS * n + 1) * factor
        third = third + load_lanes(table, _VECTORS * n + 2) * factor
        power *= h
    store_lanes(b, 0, first)
    store_lanes(b, 1, second)
    store_lanes(b, 2, third)


@part
def below(b: Any, bound: Any) -> int:
    """Which numbers of a row are less than a bound, or than those of another row, as bits."""
    return (
        bits(load_lanes(b, 0) < load_lanes(bound, 0))
        | bits(load_lanes(b, 1) < load_lanes(bound, 1)) << LANES
        | bits(load_lanes(b, 2) < load_lanes(bound, 2)) << 2 * LANES
    )


@part
def changes(negative: int, positive: int, size: int) -> int:
    """Changes of sign in a row of numbers, `size` if one of them is zero."""
    if (negative | positive) & ((1 << size) - 1) != (1 << size) - 1:
        return size
    return ones((negative ^ (negative >> 1)) & ((1 << (size - 1)) - 1))


@inner
def bernstein(c: Any, size: int, b: Any) -> int:
    """Bernstein coefficients; returns the variations of their signs, or `size` if one is zero.

    Without a variation there is no root inside; with one there is exactly one.
    """
    transform(c, 1, size, 1.0, b)
    return variations(b, size)


@inner
def variations(b: Any, size: int) -> int:
    """Variations of sign in a row, `size` if a number is zero."""
    nothing = memory(_NOTHING)
    return changes(below(b, nothing), below(nothing, b), size)


@inner
def turns(b: Any, size: int) -> int:
    """Variations of sign of the differences in a row, `size` if one of them is zero."""
    after = behind(b, 1)
    return changes(below(after, b), below(b, after), size - 1)


@inner
def sign_roots(c: Any, size: int, limit: int, work: Any) -> int:
    """Roots in (0, 1] at which the sign changes, ascending; a root at 0 does not count.

    At most `limit` of them are written to the beginning of `work`.
    """
    while size > 0 and c[0] == 0.0:
        c = behind(c, 1)
        size -= 1
    if size < 2:
        return 0
    others = 0.0
    for n in range(1, size):
        others += abs(c[n])
    if abs(c[0]) > others:
        return 0
    b = behind(work, _STACK)
    if bernstein(c, size, b) == 0:
        return 0
    negative = c[0] < 0.0
    at_end = b[size - 1] == 0.0
    b[_LEFT], b[_RIGHT], b[_DEPTH] = 0.0, 1.0, 0.0
    count, top = 0, 1
    while top > 0 and count < limit:
        top -= 1
        b = behind(work, _STACK + top * _WIDTH)
        left, right, depth = b[_LEFT], b[_RIGHT], b[_DEPTH]
        count_here = _variations(b, size)
        if count_here > 1 and depth < MAX_DEPTH:
            # The lower part is taken first: it goes on top.
            lower = behind(b, _WIDTH)
            part = _split(b, lower, behind(work, _SPARE), size)
            middle = left + part * (right - left)
            b[_LEFT], b[_RIGHT], b[_DEPTH] = middle, right, depth + 1.0
            lower[_LEFT], lower[_RIGHT], lower[_DEPTH] = left, middle, depth + 1.0
            top += 2
        elif count_here % 2 == 1:
            middle = 0.5 * (left + right)
            work[_FOUND + count] = refine(c, size, (left, right), negative, middle, PRECISE)
            negative = not negative
            count += 1
    if at_end and count < limit:
        work[_FOUND + count] = 1.0
        count += 1
    return count


@inner
def _variations(b: Any, size: int) -> int:
    count, sign = 0, 0
    for n in range(size):
        new = 1 if b[n] > 0.0 else (-1 if b[n] < 0.0 else 0)
        if new != 0:
            if new == -sign:
                count += 1
            sign = new
    return count


@inner
def _split(b: Any, lower: Any, upper: Any, size: int) -> float:
    # de Casteljau's rule, away from a root; the upper part replaces `b`.
    part = 0.5
    for attempt in range(3):
        part = 0.5 if attempt == 0 else (0.4375 if attempt == 1 else 0.5625)
        for n in range(size):
            upper[n] = b[n]
        for level in range(size):
            lower[level] = upper[0]
            for n in range(size - 1 - level):
                upper[n] = (1.0 - part) * upper[n] + part * upper[n + 1]
        if lower[size - 1] != 0.0:
            break
    for n in range(size):
        b[n] = upper[n]
    return part


@inner
def widen(c: Any, size: int, low: float, high: float, work: Any) -> tuple[float, float]:
    """Widen the range (`low`, `high`) so that it holds the polynomial's on [0, 1]."""
    first, slope, last, last_slope, bulge = c[0], c[1], c[0], 0.0, 0.0
    for n in range(1, size):
        last += c[n]
        last_slope += n * c[n]
        bulge += abs(c[n]) * (n * (n - 1) * (n - 2))
    bulge *= 0.125
    low, high = min(low, first, last), max(high, first, last)
    # The slope leaves its chord by `bulge` at most, and its derivative that of its chord by four
    # times as much.
    turning = (slope > 0.0) != (last_slope > 0.0)
    if turning:
        # The only extremum of a slope that falls or rises throughout lies between the tangents.
        bound = first + slope * ((last - last_slope - first) / (slope - last_slope))
        if low <= bound <= high and abs(last_slope - slope) > 4.0 * bulge:
            return low, high
    elif min(abs(slope), abs(last_slope)) > bulge:
        return low, high
    d = behind(work, _SLOPE)
    for n in range(1, size):
        d[n - 1] = n * c[n]
    d[size - 1] = 0.0
    found = bernstein(d, size - 1, behind(work, _STACK))
    if found == 0:
        return low, high
    if found == 1:
        guess = slope / (slope - last_slope)
        place = refine(d, size - 1, (0.0, 1.0), slope < 0.0, guess, EXTREME)
        value = evaluate(c, size, place)
        return min(low, value), max(high, value)
    for index in range(sign_roots(d, size - 1, size, work)):
        value = evaluate(c, size, work[_FOUND + index])
        low, high = min(low, value), max(high, value)
    return low, high
