"""Tests of the roots of polynomials in rational numbers."""

from fractions import Fraction

from hypothesis import given, strategies as st

from fivtui.equilibrium.exact import integers, product, real_roots, total, value_at

LOW, HIGH = Fraction(-10), Fraction(10)
NARROW = Fraction(1, 2**70)
rationals = st.fractions(Fraction(-12), Fraction(12), max_denominator=1000)


def polynomial(roots: list[Fraction], pairs: list[tuple[Fraction, Fraction]]) -> list[Fraction]:
    factors = [[-root, Fraction(1)] for root in roots]
    # Without real roots, and as near to them as the second number is small.
    factors += [[real * real + gap * gap, -2 * real, Fraction(1)] for real, gap in pairs if gap]
    return product([Fraction(3)], *factors)


@given(st.lists(rationals, max_size=6), st.lists(st.tuples(rationals, rationals), max_size=2))
def test_every_root_is_bracketed_once_whatever_its_multiplicity(
    roots: list[Fraction], pairs: list[tuple[Fraction, Fraction]]
) -> None:
    c = polynomial(roots, pairs)
    known = sorted({root for root in roots if LOW < root < HIGH})
    found = list(real_roots(c, LOW, HIGH, lambda left, right: right - left < NARROW))
    assert len(found) == len(known)
    for root, (left, right) in zip(known, found, strict=True):
        assert left <= root <= right
        assert right - left < NARROW


def test_roots_closer_than_floats_resolve_are_two_and_a_double_one_is_one() -> None:
    here, gap = Fraction(1, 3), Fraction(1, 2**200)
    for roots, count in (([here, here + gap], 2), ([here, here], 1)):
        brackets = real_roots(polynomial(roots, []), LOW, HIGH, lambda a, b: b - a < gap)
        assert len(list(brackets)) == count


@given(st.lists(rationals, min_size=1, max_size=5), rationals)
def test_values_by_integers_have_the_sign_of_those_in_fractions(
    c: list[Fraction], x: Fraction
) -> None:
    exact = sum((coefficient * x**n for n, coefficient in enumerate(c)), Fraction(0))
    (whole,) = integers(c)
    value = value_at(whole, x)
    assert (value > 0, value < 0) == (exact > 0, exact < 0)
    assert total(c, product([Fraction(-1)], c)) == [0] * len(c)
