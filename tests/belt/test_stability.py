"""Tests of the stability of sliding on a belt of finite speed."""

import math

import numpy as np
import pytest
from hypothesis import given, settings

from fivtui import Parameters, stability
from fivtui.equilibrium.eigenvalues import judge_growth
from fivtui.model.errors import ComputationError
from fivtui.model.slider_belt import State, accelerations, equilibrium, jacobian

from .test_model import belts

# Without coupling the slider moves along the belt alone.
ALONG = Parameters(
    k3=0.0, c1=10.0, c2=5.0, mu=0.3, mu_s=0.5, v_s=0.4, v_belt=0.4, F=80.0, k_nl=100.0
)


def test_without_coupling_the_critical_speed_is_that_in_closed_form() -> None:
    known = 0.4 * math.log(80.0 * (0.5 - 0.3) / (10.0 * 0.4))
    (critical,) = stability(ALONG).critical_speed
    assert critical.v_belt == pytest.approx(known, rel=1e-14)
    assert critical.becomes == "stable"
    for factor in (0.999, 1.001):
        beside = ALONG.with_values({"v_belt": known * factor})
        assert stability(beside).stable == (factor > 1.0)
    assert stability(ALONG.with_values({"c1": 100.0})).critical_speed == ()
    assert stability(ALONG.with_values({"v_s": None})).critical_speed == ()


def test_with_coupling_critical_speeds_are_where_the_growth_rate_changes_sign() -> None:
    coupled = ALONG.with_values({"k3": 60.0, "mu": 0.2, "mu_s": 0.4})
    found = stability(coupled).critical_speed
    assert found
    for critical in found:
        before, after = (
            stability(coupled.with_values({"v_belt": critical.v_belt * factor}))
            for factor in (1.0 - 1e-6, 1.0 + 1e-6)
        )
        assert before.growth_rate * after.growth_rate < 0.0
        assert after.stable == (critical.becomes == "stable")


def test_every_critical_mu_is_listed_where_friction_falls_with_the_speed() -> None:
    # Falling friction takes damping away at small μ, mode coupling at large μ.
    p = Parameters(
        k3=75.4, c1=8.025, c2=1.26, F=52.4, k_nl=187.0, mu=0.2, v_belt=0.868, mu_s=0.719, v_s=0.635
    )
    found = stability(p).critical_mu
    mus = np.linspace(0.0, 0.719, 201)
    stable = [judge_growth(p.with_values({"mu": float(mu)}))[1] for mu in mus]
    changes = [
        (float(mus[n]), float(mus[n + 1]), "stable" if stable[n + 1] else "unstable")
        for n in range(200)
        if stable[n] != stable[n + 1]
    ]
    assert len(found) == len(changes) == 2
    for critical, (low, high, becomes) in zip(found, changes, strict=True):
        assert low <= critical.mu <= high
        assert critical.becomes == becomes


@given(belts())
@settings(max_examples=30)
def test_the_linearisation_is_the_derivative_of_the_accelerations(p: Parameters) -> None:
    p = p.with_values({"v_belt": 0.2 + (p.v_belt or 0.0), "F": 10.0 + p.F})
    point = equilibrium(p)
    x, y = point.x, point.y
    matrix, step = np.array(jacobian(p, y, point.mode)), 1e-6
    assert accelerations(p, (x, 0.0, y, 0.0), point.mode) == pytest.approx((0.0, 0.0), abs=1e-9)
    for column in range(4):
        ends = []
        for by in (-step, step):
            state = [x, 0.0, y, 0.0]
            state[column] += by
            moved: State = (state[0], state[1], state[2], state[3])
            ends.append(np.array(accelerations(p, moved, point.mode)))
        slope = (ends[1] - ends[0]) / (2.0 * step)
        scale = 1.0 + np.abs(matrix).max()
        assert slope.tolist() == pytest.approx(matrix[[1, 3], column].tolist(), abs=1e-6 * scale)


def test_constant_friction_has_the_critical_mu_of_a_belt_that_is_always_faster() -> None:
    assert stability(Parameters(v_belt=1.0)).critical_mu == stability(Parameters()).critical_mu
    with pytest.raises(ComputationError, match="no equilibrium of sliding: the belt is at rest"):
        stability(Parameters(v_belt=0.0))
