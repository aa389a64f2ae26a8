"""All real roots and the extreme values of a polynomial on an interval.

A polynomial is a sequence of coefficients, constant term first. Roots are isolated by the
sign changes of the Bernstein coefficients (Descartes' rule on an interval). None means no
root, one means exactly one root, and with more the interval is subdivided.
"""

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import accumulate, pairwise, repeat
from operator import mul
from typing import Final

# Roots closer than 2**-MAX_DEPTH of the interval are not separated: an odd number of them counts as
# one root, an even number as none.
MAX_DEPTH: Final = 48
_MAX_NEWTON_STEPS: Final = 100
_ROOT_TOLERANCE: Final = 2.0**-52
# Where an interval is cut in two: at the first fraction that is not a root.
_CUTS: Final = (0.5, 0.4375, 0.5625)


def evaluate(c: Sequence[float], t: float) -> float:
    """Value of a polynomial at t, by Horner's rule."""
    value = 0.0
    for coefficient in reversed(c):
        value = value * t + coefficient
    return value


def derivative(c: Sequence[float]) -> list[float]:
    """Coefficients of the derivative."""
    return [n * coefficient for n, coefficient in enumerate(c)][1:]


def scale(c: Sequence[float], h: float) -> list[float]:
    """Coefficients in t/h: the variable t/h maps [0, h] to [0, 1]."""
    return list(map(mul, c, accumulate(repeat(h, len(c) - 1), mul, initial=1.0)))


def first_root(c: Sequence[float]) -> float | None:
    """The first root in (0, 1] at which a polynomial changes sign; None without one.

    A root at 0 does not count, whatever its multiplicity.
    """
    return next(roots(c), None)


def roots(c: Sequence[float]) -> Iterator[float]:
    """Yield the roots in (0, 1] at which a polynomial changes sign, ascending, to rounding.

    A root at 0 does not count, whatever its multiplicity; one exactly at 1 does.
    """
    start = next((n for n, coefficient in enumerate(c) if coefficient != 0.0), len(c))
    reduced = c[start:]
    if len(reduced) < 2 or abs(reduced[0]) > math.fsum(map(abs, reduced[1:])):
        return
    is_rising = reduced[0] < 0.0
    b = bernstein(reduced)
    for low, high in _isolate_roots(b):
        yield _refine(reduced, low, high, is_rising=is_rising)
        is_rising = not is_rising
    if b[-1] == 0.0:
        yield 1.0


def minimum_maximum(c: Sequence[float]) -> tuple[float, float]:
    """Least and greatest value of a polynomial on [0, 1]."""
    values = [c[0], evaluate(c, 1.0)]
    values.extend(evaluate(c, t) for t in roots(derivative(c)))
    return min(values), max(values)


def restrict(c: Sequence[float], low: float, high: float) -> list[float]:
    """Coefficients on [low, high] in (t − low)/(high − low)."""
    if low == 0.0:
        return scale(c, high)
    # Expand about `low` by repeated synthetic division.
    shifted = list(c)
    for start in range(len(shifted) - 1):
        for n in range(len(shifted) - 2, start - 1, -1):
            shifted[n] += low * shifted[n + 1]
    return scale(shifted, high - low)


def bernstein(c: Sequence[float]) -> list[float]:
    """Bernstein coefficients on [0, 1]; the polynomial lies in their convex hull."""
    return [sum(map(mul, row, c)) for row in _to_bernstein(len(c))]


@lru_cache(maxsize=64)
def _to_bernstein(size: int) -> tuple[tuple[float, ...], ...]:
    degree = size - 1
    return tuple(
        tuple(math.comb(i, k) / math.comb(degree, k) for k in range(i + 1)) for i in range(size)
    )


def _count_sign_changes(b: Sequence[float]) -> int:
    signs = [value > 0.0 for value in b if value != 0.0]
    return sum(map(bool.__ne__, signs, signs[1:]))


def _isolate_roots(b: list[float]) -> Iterator[tuple[float, float]]:
    # Subintervals, in ascending order, over which the sign changes.
    stack = [(0.0, 1.0, b, 0)]
    while stack:
        low, high, b, depth = stack.pop()
        sign_changes = _count_sign_changes(b)
        if sign_changes > 1 and depth < MAX_DEPTH:
            cut, lower, upper = _split(b)
            middle = low + cut * (high - low)
            stack.append((middle, high, upper, depth + 1))
            stack.append((low, middle, lower, depth + 1))
        elif sign_changes % 2 == 1:
            yield low, high


def _split(b: list[float]) -> tuple[float, list[float], list[float]]:
    # A cut and the Bernstein coefficients below and above it, by De Casteljau's rule. The cut must
    # not be a root, because the sign there is needed.
    for cut in _CUTS:
        lower, upper, level = [b[0]], [b[-1]], b
        while len(level) > 1:
            level = [(1.0 - cut) * first + cut * second for first, second in pairwise(level)]
            lower.append(level[0])
            upper.append(level[-1])
        if lower[-1] != 0.0:
            break
    upper.reverse()
    return cut, lower, upper


def _refine(c: Sequence[float], low: float, high: float, *, is_rising: bool) -> float:
    # Newton's method, safeguarded by a bracket over which the sign changes once, from negative to
    # positive if `is_rising`.
    slope_coefficients = derivative(c)
    t = 0.5 * (low + high)
    for _ in range(_MAX_NEWTON_STEPS):
        value = evaluate(c, t)
        if value == 0.0:
            break
        if (value < 0.0) == is_rising:
            low = t
        else:
            high = t
        slope = evaluate(slope_coefficients, t)
        next_t = t - value / slope if slope != 0.0 else low
        if abs(next_t - t) <= _ROOT_TOLERANCE * t:
            return next_t
        if not low < next_t < high:
            next_t = 0.5 * (low + high)
            if next_t in (low, high):
                break
        t = next_t
    return t
