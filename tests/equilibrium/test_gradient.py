"""Derivatives of the critical friction coefficient against differences."""

import math

import pytest

from fivtui.equilibrium.critical import critical_mu, critical_mu_derivatives
from fivtui.model import System
from fivtui.model.parameters import Parameters

PARAMETER_SETS = [
    Parameters(),
    Parameters(F=20.0, c1=0.8),
    Parameters(F=120.0, k2=70.0, m=3.0),
    Parameters(k_nl=0.0, c2=0.0),
]


@pytest.mark.parametrize("p", PARAMETER_SETS, ids=str)
def test_derivatives_of_critical_friction_are_differences(p: Parameters) -> None:
    derivatives = critical_mu_derivatives(System(p))
    assert derivatives is not None
    for name, derivative in derivatives.items():
        value = getattr(p, name)
        step = 1e-5 * (value or 1.0)
        # A value at its bound has a one-sided difference.
        low = value - step if value > 0.0 else value
        critical_mus = [
            critical_mu(System(p.with_values({name: number})))[0].mu
            for number in (low, value + step)
        ]
        rate = (critical_mus[1] - critical_mus[0]) / (value + step - low)
        assert derivative == pytest.approx(rate, rel=2e-4, abs=1e-9)


def test_without_critical_friction_or_damping_derivatives_are_missing() -> None:
    assert critical_mu_derivatives(System(Parameters(k3=0.0))) is None
    assert critical_mu_derivatives(System(Parameters(F=-1.0))) is None
    undamped = critical_mu_derivatives(System(Parameters(c1=0.0, c2=0.0)))
    assert undamped is not None
    assert math.isnan(undamped["c1"])
    assert undamped["F"] > 0.0
