import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fivtui.core.model import Mode, State, accelerations
from fivtui.core.parameters import Parameters
from fivtui.core.recurrences import (
    Field,
    coefficient_function,
    coefficients,
    constants,
    state_function,
)
from tests.strategies import moderate_parameters, states


@given(moderate_parameters(), states(), st.sampled_from(Field), st.integers(2, 20))
def test_straight_line_code_is_the_loop(
    p: Parameters, state: State, field: Field, order: int
) -> None:
    fast = coefficient_function(field, order)(*state, *constants(p))
    slow = coefficients(field, order, state, constants(p))
    for fast_row, slow_row in zip(fast, slow, strict=True):
        assert len(fast_row) == order + 2
        # Sums are taken in another order: rounding relative to the largest coefficient so far.
        largest = 0.0
        for one, other in zip(fast_row, slow_row, strict=True):
            largest = max(largest, abs(other), *map(abs, state))
            assert math.isclose(one, other, rel_tol=1e-9, abs_tol=1e-11 * largest)


@given(moderate_parameters(), states())
def test_the_second_coefficients_are_half_the_accelerations(p: Parameters, state: State) -> None:
    cases = [(Field.CUBIC_CONTACT, Mode.CONTACT, p), (Field.SEPARATED, Mode.SEPARATED, p)]
    linear = p.with_values({"k_nl": 0.0})
    cases.append((Field.LINEAR_CONTACT, Mode.CONTACT, linear))
    for field, mode, given_p in cases:
        x, y = coefficients(field, 2, state, constants(given_p))
        ax, ay = accelerations(given_p, state, mode)
        assert 2.0 * x[2] == pytest.approx(ax, rel=1e-12, abs=1e-10)
        assert 2.0 * y[2] == pytest.approx(ay, rel=1e-12, abs=1e-10)


def test_state_function_is_horners_rule_for_value_and_slope() -> None:
    x, vx, y, vy = state_function(3)([1.0, 2.0, 3.0, 4.0], [0.0, 0.0, 0.0, 1.0], 0.5)
    assert (x, vx, y, vy) == (1 + 1 + 0.75 + 0.5, 2 + 3 + 3, 0.125, 0.75)
