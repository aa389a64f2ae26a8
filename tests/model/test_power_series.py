"""Tests of truncated power series, and of the derivatives of friction that they give."""

import math

import pytest
from hypothesis import given, strategies as st

from fivtui.model import Parameters
from fivtui.model.field import friction_coefficient, friction_derivatives, friction_slope
from fivtui.model.power_series import PowerSeries

ORDER = 4
positive_numbers = st.floats(0.25, 4.0)
nonzero_numbers = st.one_of(positive_numbers, positive_numbers.map(lambda value: -value))


def draw_series(first: st.SearchStrategy[float]) -> st.SearchStrategy[PowerSeries]:
    rest = [st.floats(-2.0, 2.0) for _ in range(ORDER)]
    return st.tuples(first, *rest).map(PowerSeries)


def assert_equal(first: PowerSeries, second: PowerSeries) -> None:
    scale = max(map(abs, (*first.coefficients, *second.coefficients)))
    assert first.coefficients == pytest.approx(
        second.coefficients, rel=1e-10, abs=1e-9 * (1.0 + scale)
    )


@given(draw_series(nonzero_numbers), draw_series(nonzero_numbers), draw_series(nonzero_numbers))
def test_products_and_quotients_obey_the_field_axioms(
    a: PowerSeries, b: PowerSeries, c: PowerSeries
) -> None:
    assert_equal(a * b, b * a)
    assert_equal(a * (b + c), a * b + a * c)
    assert_equal(a * (b - c), a * b - a * c)
    assert_equal(a / b * b, a)


@given(draw_series(positive_numbers), nonzero_numbers)
def test_numbers_act_as_constant_series(a: PowerSeries, number: float) -> None:
    constant = PowerSeries((number, *[0.0] * ORDER))
    for first, second in (
        (a + number, a + constant),
        (number + a, constant + a),
        (a - number, a - constant),
        (number - a, constant - a),
        (a * number, a * constant),
        (number * a, constant * a),
        (a / number, a / constant),
        (number / a, constant / a),
        (-a, 0.0 - a),
    ):
        assert_equal(first, second)


@given(draw_series(st.floats(-2.0, 2.0)), draw_series(st.floats(-2.0, 2.0)))
def test_the_exponential_of_a_sum_is_a_product(a: PowerSeries, b: PowerSeries) -> None:
    assert_equal((a + b).exp(), a.exp() * b.exp())
    assert_equal((-a).exp(), 1.0 / a.exp())


def test_derivatives_of_known_functions() -> None:
    x = PowerSeries.variable(0.5, 5)
    assert (x.exp()).derivatives() == pytest.approx([math.exp(0.5)] * 6, rel=1e-15)
    reciprocal = [(-1.0) ** n * math.factorial(n) / 0.5 ** (n + 1) for n in range(6)]
    assert (1.0 / x).derivatives() == pytest.approx(reciprocal, rel=1e-15)
    assert (x * x * x).derivatives() == (0.125, 0.75, 3.0, 6.0, 0.0, 0.0)


@given(st.floats(0.0, 5.0), st.floats(0.05, 5.0))
def test_derivatives_of_friction_are_those_of_its_exponential(speed: float, v_s: float) -> None:
    p = Parameters(mu=0.3, mu_s=0.5, v_s=v_s, v_belt=1.0)
    exponential_term = 0.2 * math.exp(-speed / v_s)
    derivatives = friction_derivatives(p, speed, 3)
    assert derivatives[0] == pytest.approx(friction_coefficient(p, speed), rel=1e-15)
    assert derivatives[1:] == pytest.approx(
        (-exponential_term / v_s, exponential_term / v_s**2, -exponential_term / v_s**3), rel=1e-14
    )
    assert derivatives[1] == pytest.approx(friction_slope(p, speed), rel=1e-14)


def test_constant_friction_has_no_derivatives() -> None:
    for values in ({"v_s": None}, {"mu_s": None}, {"mu_s": 0.3}):
        p = Parameters(mu=0.3, v_belt=1.0).with_values({"mu_s": 0.5, "v_s": 0.4, **values})
        assert friction_derivatives(p, 0.5, 3) == (0.3, 0.0, 0.0, 0.0)
