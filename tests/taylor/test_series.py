"""The Taylor coefficients solve the equations of motion.

Modes are those on a belt that is always faster than the slider: contact and separation.
"""

import pytest
from hypothesis import given, strategies as st

from fivtui.model.field import field as equation_coefficients
from fivtui.model.modes import ALWAYS_SLIDING, Mode
from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import State, accelerations
from fivtui.taylor.series import (
    coefficient_function,
    right_hand_side,
    state_function,
)
from tests.support.strategies import moderate_parameters, states


@given(moderate_parameters(), states(), st.sampled_from(ALWAYS_SLIDING))
def test_the_coefficients_solve_the_equations_of_motion(
    p: Parameters, state: State, mode: Mode
) -> None:
    order, t, step = 20, 0.01, 1e-4
    expand = coefficient_function(right_hand_side(p, mode), order)
    x, y = expand(*state, *equation_coefficients(p, mode))
    before, middle, after = (
        state_function(order + 1)(x, y, t + shift) for shift in (-step, 0.0, step)
    )
    ax, ay = accelerations(p, middle, mode)
    scale = 1.0 + max(map(abs, (ax, ay)))
    (_, vx_before, _, vy_before), (_, vx_after, _, vy_after) = before, after
    assert (vx_after - vx_before) / (2.0 * step) == pytest.approx(ax, abs=1e-4 * scale)
    assert (vy_after - vy_before) / (2.0 * step) == pytest.approx(ay, abs=1e-4 * scale)


@given(moderate_parameters(), states())
def test_the_second_coefficients_are_half_the_accelerations(p: Parameters, state: State) -> None:
    linear = p.with_values({"k_nl": 0.0})
    cases = [(p, Mode.CONTACT), (p, Mode.SEPARATED), (linear, Mode.CONTACT)]
    for parameters, mode in cases:
        expand = coefficient_function(right_hand_side(parameters, mode), 2)
        x, y = expand(*state, *equation_coefficients(parameters, mode))
        assert len(x) == len(y) == 4
        ax, ay = accelerations(parameters, state, mode)
        assert 2.0 * x[2] == pytest.approx(ax, rel=1e-12, abs=1e-10)
        assert 2.0 * y[2] == pytest.approx(ay, rel=1e-12, abs=1e-10)


def test_state_function_is_horners_rule_for_value_and_slope() -> None:
    x, vx, y, vy = state_function(3)([1.0, 2.0, 3.0, 4.0], [0.0, 0.0, 0.0, 1.0], 0.5)
    assert (x, vx, y, vy) == (1 + 1 + 0.75 + 0.5, 2 + 3 + 3, 0.125, 0.75)
