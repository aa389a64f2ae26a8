"""Roots, extremes and changes of variable of polynomials."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, strategies as st

from fivtui.taylor.polynomial import (
    bernstein,
    derivative,
    evaluate,
    first_root,
    minimum_maximum,
    restrict,
    roots,
    scale,
)

coefficients = st.lists(st.floats(-10.0, 10.0, allow_subnormal=False), min_size=2, max_size=18)


def polynomial_with_roots(*positions: float, factor: float = 1.0) -> list[float]:
    polynomial = np.polynomial.Polynomial.fromroots(positions) * factor
    return polynomial.coef.tolist()


@given(st.lists(st.integers(1, 99), min_size=1, max_size=6, unique=True), st.integers(0, 3))
def test_all_simple_roots_are_found_in_order(hundredths: list[int], outside: int) -> None:
    inside = sorted(number / 100.0 for number in hundredths)
    c = polynomial_with_roots(*inside, *(2.0 + n for n in range(outside)), factor=-3.0)
    computed_roots = list(roots(c))
    assert len(computed_roots) == len(inside)
    for root, expected in zip(computed_roots, inside, strict=True):
        # Rounded coefficients move a root by their error over the slope at the root.
        rounding_error = 1e-14 * sum(abs(a) * expected**n for n, a in enumerate(c))
        slope = abs(evaluate(derivative(c), expected))
        assert root == pytest.approx(expected, abs=1e-13 + rounding_error / slope)


@given(coefficients)
def test_signs_between_successive_roots_alternate(c: list[float]) -> None:
    assume(c[0] != 0.0)
    bounds = [0.0, *roots(c), 1.0]
    rounding_error = 1e-12 * sum(map(abs, c))
    sign = math.copysign(1.0, c[0])
    for start, end in pairwise(bounds):
        for fraction in (0.1, 0.5, 0.9):
            value = evaluate(c, start + fraction * (end - start))
            assert value * sign >= -rounding_error
        sign = -sign


@pytest.mark.parametrize("depth", [10.0**-n for n in range(2, 13)])
@pytest.mark.parametrize("position", [0.05, 0.37, 0.5, 0.93])
def test_a_shallow_crossing_and_return_has_two_roots(depth: float, position: float) -> None:
    # (t − position)² − depth, with zero coefficients of higher order.
    c = [position * position - depth, -2.0 * position, 1.0, 0.0, 0.0]
    computed_roots = list(roots(c))
    half_distance = math.sqrt(depth)
    expected = [t for t in (position - half_distance, position + half_distance) if 0.0 < t <= 1.0]
    assert computed_roots == pytest.approx(expected, abs=1e-15 / half_distance + 1e-15)


@pytest.mark.parametrize("position", [0.25, 0.5, 0.7])
def test_a_minimum_just_above_zero_has_no_root(position: float) -> None:
    assert first_root([position * position + 1e-13, -2.0 * position, 1.0]) is None


def test_a_root_at_zero_does_not_count_whatever_its_multiplicity() -> None:
    assert first_root([0.0, 1.0, 1.0]) is None
    assert first_root([0.0, 0.0, -0.5, 1.0]) == pytest.approx(0.5)
    assert first_root([0.0, 0.0, 0.0]) is None


def test_a_root_exactly_at_the_end_counts() -> None:
    assert first_root([-1.0, 1.0]) == 1.0


# `roots` cuts an interval in two at 0.5 of its length, or at 0.4375 if a root is exactly there.
@pytest.mark.parametrize("cut", [0.5, 0.25, 0.75, 0.4375])
def test_a_root_exactly_on_a_cut_is_found_once(cut: float) -> None:
    c = polynomial_with_roots(cut, 0.9, 0.91)
    assert list(roots(c)) == pytest.approx([cut, 0.9, 0.91], abs=1e-12)


def test_roots_very_near_zero_are_found() -> None:
    assert first_root(polynomial_with_roots(1e-9, 3.0)) == pytest.approx(1e-9, rel=1e-9)


@given(coefficients)
def test_extremes_bound_the_polynomial_and_are_attained(c: list[float]) -> None:
    least, greatest = minimum_maximum(c)
    values = [evaluate(c, t) for t in np.linspace(0.0, 1.0, 400)]
    rounding_error = 1e-12 * sum(map(abs, c))
    assert least - rounding_error <= min(values)
    assert max(values) <= greatest + rounding_error
    # Sampling misses an extremum by less than the squared spacing times the greatest curvature.
    curvature_bound = sum(n * (n - 1) * abs(a) for n, a in enumerate(c))
    sampling_error = curvature_bound * (1.0 / 399.0) ** 2 + rounding_error
    assert min(values) - least <= sampling_error
    assert greatest - max(values) <= sampling_error


@given(coefficients, st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_a_restricted_polynomial_has_the_same_values(
    c: list[float], first_end: float, second_end: float, fraction: float
) -> None:
    start, end = min(first_end, second_end), max(first_end, second_end)
    value = evaluate(restrict(c, start, end), fraction)
    expected = evaluate(c, start + fraction * (end - start))
    assert value == pytest.approx(expected, abs=1e-10 * (1.0 + sum(map(abs, c))))


@given(coefficients, st.floats(0.1, 10.0), st.floats(0.0, 1.0))
def test_scaling_maps_the_interval_to_the_unit_interval(
    c: list[float], h: float, fraction: float
) -> None:
    size = sum(abs(a) * h**n for n, a in enumerate(c))
    assert evaluate(scale(c, h), fraction) == pytest.approx(
        evaluate(c, h * fraction), abs=1e-13 * size
    )


@given(coefficients)
def test_bernstein_coefficients_enclose_the_values_and_meet_them_at_the_ends(
    c: list[float],
) -> None:
    b = bernstein(c)
    rounding_error = 1e-13 * sum(map(abs, c))
    assert b[0] == c[0]
    assert b[-1] == pytest.approx(sum(c), abs=rounding_error)
    for t in np.linspace(0.0, 1.0, 21):
        assert min(b) - rounding_error <= evaluate(c, float(t)) <= max(b) + rounding_error


def test_derivative_of_a_power() -> None:
    assert derivative([7.0, 1.0, 2.0, 3.0]) == [1.0, 4.0, 9.0]
