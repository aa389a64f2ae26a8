"""Derivatives of a motion by parameters and start: of its coefficients, and across a switch.

`mode_coefficients` are those of the equations of motion in a mode. `derivative` reads derivatives
off the imaginary parts of numbers.
"""

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

from fivtui.model.field import derivative, field as mode_coefficients
from fivtui.model.modes import ALWAYS_SLIDING, Mode
from fivtui.model.parameters import PARAMETERS, Parameters
from fivtui.taylor.variation import apply_saltation
from tests.support.strategies import moderate_parameters


# `ALWAYS_SLIDING` are the modes of a belt that is always faster than the slider. `PARAMETERS` are
# those of such a belt.
@settings(max_examples=10)
@given(moderate_parameters())
@pytest.mark.parametrize("mode", ALWAYS_SLIDING)
@pytest.mark.parametrize("name", PARAMETERS)
def test_derivatives_of_the_coefficients_equal_their_differences(
    mode: Mode, name: str, p: Parameters
) -> None:
    value = getattr(p, name)
    step = 1e-6 * (1.0 + value)
    changed_parameters = dataclasses.replace(p, **{name: value + step})
    difference = (
        np.array(mode_coefficients(changed_parameters, mode)) - np.array(mode_coefficients(p, mode))
    ) / step
    # The perturbed parameter has an imaginary part, which carries the derivative (complex step).
    change = derivative(np.array(mode_coefficients(p.perturbed({name: 1.0}), mode)))
    assert change == pytest.approx(difference, rel=1e-4, abs=1e-7)


def test_saltation_is_exact_for_constant_rates_on_both_sides_of_a_switch() -> None:
    # The state z has constant rates before and after the plane n·z = 1 + q, where the guard
    # n·z - 1 - q vanishes. `start_change` and `guard_change` are the derivatives by q of the start
    # and, at constant z, of the guard.
    rng = np.random.default_rng(1)
    start, normal, before, after = rng.normal(size=(4, 4))
    horizon, start_change, guard_change = 5.0, rng.normal(size=4), -1.0

    def final_state(q: float) -> Any:
        z = start + q * start_change
        crossing_time = (1.0 + q - normal @ z) / (normal @ before)
        return z + before * crossing_time + after * (horizon - crossing_time)

    difference = (final_state(1e-3) - final_state(-1e-3)) / 2e-3
    x, vx, y, vy = start_change.tolist()
    rate = float(normal @ before)
    deviation = apply_saltation(
        (x, vx, y, vy),
        jumps=after - before,
        guard_change=normal @ start_change + guard_change,
        rate=rate,
    )
    assert deviation == pytest.approx(difference, rel=1e-10)


def test_a_deviation_is_unchanged_at_a_switch_at_which_no_rate_jumps() -> None:
    deviation = (1.0, -2.0, 3.0, 0.5)
    unchanged = apply_saltation(deviation, jumps=(0.0,) * 4, guard_change=3.0, rate=0.0)
    assert unchanged == deviation
