"""All real roots of a polynomial on an interval, without rounding: none is passed over.

Coefficients are rational numbers, constant term first. Roots are isolated by the sign changes of
the Bernstein coefficients, as integers: none means no root, one exactly one, more are subdivided. A
multiple root, which subdivision never isolates, is isolated as a root of the square-free part.
"""

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from itertools import pairwise
from math import comb, lcm
from typing import Final

Polynomial = Sequence[Fraction]
# Ends of an interval with one root inside, or equal to one.
Bracket = tuple[Fraction, Fraction]
# A part of [0, 1], and the polynomial over it in Bernstein coefficients.
_Isolated = tuple[Fraction, Fraction, list[int]]

# Roots closer than 2**-_DEPTH of the interval may be a multiple one.
_DEPTH: Final = 128
# A prime: without a common divisor in numbers modulo this there is none.
_PRIME: Final = 2**61 - 1
_HALF: Final = Fraction(1, 2)


def integers(*polynomials: Polynomial) -> list[list[int]]:
    """Polynomials times their common denominator."""
    common = lcm(*(coefficient.denominator for c in polynomials for coefficient in c))
    return [[int(coefficient * common) for coefficient in c] for c in polynomials]


def value_at(c: Sequence[int], x: Fraction) -> int:
    """Value of a polynomial at x, times the denominator of x to the power of its degree."""
    value, power = 0, 1
    for coefficient in reversed(c):
        value = value * x.numerator + coefficient * power
        power *= x.denominator
    return value


def total(*polynomials: Polynomial) -> list[Fraction]:
    """Sum of polynomials."""
    size = max(map(len, polynomials))
    padded = [[*c, *[Fraction(0)] * (size - len(c))] for c in polynomials]
    return [sum(column, Fraction(0)) for column in zip(*padded, strict=True)]


def product(*polynomials: Polynomial) -> list[Fraction]:
    """Product of polynomials; a constant is one of a single coefficient."""
    found = [Fraction(1)]
    for c in polynomials:
        terms = [Fraction(0)] * (len(found) + len(c) - 1)
        for i, one in enumerate(found):
            for j, other in enumerate(c):
                terms[i + j] += one * other
        found = terms
    return found


def real_roots(
    c: Polynomial, low: Fraction, high: Fraction, enough: Callable[[Fraction, Fraction], bool]
) -> Iterator[Bracket]:
    """Yield the roots in (low, high), ascending, each once, in brackets that are narrow enough."""

    def here(t: Fraction) -> Fraction:
        return low + t * (high - low)

    isolated = _isolated(_bernstein(c, low, high), _DEPTH)
    if isolated is None:
        once = c if _is_square_free(c) else _square_free(c)
        isolated = _isolated(_bernstein(once, low, high), None) or []
    for each in isolated:
        left, right, b = each
        while left < right and not enough(here(left), here(right)):
            left, right, b = _narrower(left, right, b)
        yield here(left), here(right)


def _narrower(left: Fraction, right: Fraction, b: list[int]) -> _Isolated:
    lower, upper = _halves(b)
    middle = _HALF * (left + right)
    if lower[-1] == 0:
        return middle, middle, b
    if _is_positive(lower) == (lower[-1] > 0):
        return middle, right, upper
    return left, middle, lower


def _is_positive(b: Sequence[int]) -> bool:
    # Whether the polynomial is positive behind the left end.
    return next(value for value in b if value != 0) > 0


def _bernstein(c: Polynomial, low: Fraction, high: Fraction) -> list[int]:
    # On [low, high], times a common denominator.
    shifted, degree, span = list(c), len(c) - 1, high - low
    for start in range(degree):
        for n in range(degree - 1, start - 1, -1):
            shifted[n] += low * shifted[n + 1]
    scaled = [coefficient * span**n for n, coefficient in enumerate(shifted)]
    found = [
        sum((Fraction(comb(i, k), comb(degree, k)) * scaled[k] for k in range(i + 1)), Fraction(0))
        for i in range(degree + 1)
    ]
    (whole,) = integers(found)
    return whole


def _isolated(b: list[int], depth: int | None) -> list[_Isolated] | None:
    # Subintervals of [0, 1] with one root each, and the polynomial over them; None where they would
    # be narrower than 2**-depth.
    found = []
    stack = [(Fraction(0), Fraction(1), b, 0)]
    while stack:
        left, right, b, level = stack.pop()
        signs = [value > 0 for value in b if value != 0]
        changes = sum(one is not other for one, other in pairwise(signs))
        if changes == 1 or left == right:
            found.append((left, right, b))
        elif changes > 1:
            if level == depth:
                return None
            lower, upper = _halves(b)
            middle = _HALF * (left + right)
            stack.append((middle, right, upper, level + 1))
            if lower[-1] == 0:
                stack.append((middle, middle, upper, level + 1))
            stack.append((left, middle, lower, level + 1))
    return found


def _halves(b: Sequence[int]) -> tuple[list[int], list[int]]:
    # de Casteljau's rule, times 2**degree.
    level, shift = list(b), len(b) - 1
    lower, upper = [level[0] << shift], [level[-1] << shift]
    while shift > 0:
        shift -= 1
        level = [one + other for one, other in pairwise(level)]
        lower.append(level[0] << shift)
        upper.append(level[-1] << shift)
    upper.reverse()
    return lower, upper


def _is_square_free(c: Polynomial) -> bool:
    # Whether c and c' are known to have no common divisor: where they have none modulo a prime.
    (whole,) = integers(_monic(c))
    one, other = whole, [n * coefficient for n, coefficient in enumerate(whole)][1:]
    if one[-1] % _PRIME == 0:
        return False
    while other:
        one, other = other, _remainder(one, other)
    return len(one) == 1


def _remainder(one: Sequence[int], other: Sequence[int]) -> list[int]:
    # Modulo the prime, without leading zeros.
    rest, inverse = [value % _PRIME for value in one], pow(other[-1], -1, _PRIME)
    for place in range(len(one) - len(other), -1, -1):
        factor = rest[place + len(other) - 1] * inverse % _PRIME
        for n, coefficient in enumerate(other):
            rest[place + n] = (rest[place + n] - factor * coefficient) % _PRIME
    return rest[: next((n for n in range(len(other) - 1, 0, -1) if rest[n - 1]), 0)]


def _square_free(c: Polynomial) -> list[Fraction]:
    # c without the multiplicity of its roots: c over its greatest common divisor with c'.
    slope = [n * coefficient for n, coefficient in enumerate(c)][1:]
    one, other = _monic(c), _monic(slope)
    while other:
        one, other = other, _monic(_divided(one, other)[1])
    return _divided(c, one)[0]


def _monic(c: Polynomial) -> list[Fraction]:
    size = next((n for n in range(len(c), 0, -1) if c[n - 1] != 0), 0)
    return [coefficient / c[size - 1] for coefficient in c[:size]]


def _divided(c: Polynomial, by: Polynomial) -> tuple[list[Fraction], list[Fraction]]:
    # Quotient and remainder.
    rest, quotient = list(c), [Fraction(0)] * max(len(c) - len(by) + 1, 1)
    for place in range(len(c) - len(by), -1, -1):
        factor = rest[place + len(by) - 1] / by[-1]
        quotient[place] = factor
        for n, coefficient in enumerate(by):
            rest[place + n] -= factor * coefficient
    return quotient, rest[: len(by) - 1]
