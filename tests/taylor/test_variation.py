"""Deviations: changes of coefficients against differences, switches against a solved example."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

from fivtui.model.field import derivative, field as field_of
from fivtui.model.modes import ALWAYS_SLIDING, Mode
from fivtui.model.parameters import PARAMETERS, Parameters
from fivtui.taylor.variation import apply_saltation
from tests.support.strategies import moderate_parameters


@settings(max_examples=10)
@given(moderate_parameters())
@pytest.mark.parametrize("mode", ALWAYS_SLIDING)
@pytest.mark.parametrize("name", PARAMETERS)
def test_changes_of_the_coefficients_are_their_differences(
    mode: Mode, name: str, p: Parameters
) -> None:
    value = getattr(p, name)
    nudge = 1e-6 * (1.0 + value)
    changed = dataclasses.replace(p, **{name: value + nudge})
    difference = (np.array(field_of(changed, mode)) - np.array(field_of(p, mode))) / nudge
    change = derivative(np.array(field_of(p.perturbed({name: 1.0}), mode)))
    assert change == pytest.approx(difference, rel=1e-4, abs=1e-7)


def test_a_deviation_passes_a_switch_of_any_field() -> None:
    # The state has constant rates before and after the plane n·z = 1 + q.
    rng = np.random.default_rng(1)
    start, normal, before, after = rng.normal(size=(4, 4))
    horizon, start_change, guard_change = 5.0, rng.normal(size=4), -1.0

    def end(q: float) -> Any:
        z = start + q * start_change
        crossing = (1.0 + q - normal @ z) / (normal @ before)
        return z + before * crossing + after * (horizon - crossing)

    difference = (end(1e-3) - end(-1e-3)) / 2e-3
    x, vx, y, vy = start_change.tolist()
    rate = float(normal @ before)
    deviation = apply_saltation(
        (x, vx, y, vy), after - before, normal @ start_change + guard_change, rate
    )
    assert deviation == pytest.approx(difference, rel=1e-10)


def test_where_no_rate_jumps_a_deviation_passes_unchanged_even_along_the_switch() -> None:
    deviation = (1.0, -2.0, 3.0, 0.5)
    assert apply_saltation(deviation, (0.0,) * 4, 3.0, 0.0) == deviation
