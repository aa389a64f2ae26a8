"""Derivatives of the safe friction coefficient against differences of folds.

At the safe μ the branch of limit cycles from the Hopf point folds: below it there are none. If the
Hopf point is supercritical, the branch has no lower μ than the critical one.
"""

import numpy as np
import pytest

from fivtui.equilibrium.critical import critical_mu_derivatives
from fivtui.model import System
from fivtui.model.parameters import Parameters
from fivtui.safety.hopf_branch import safe_mu_derivatives
from fivtui.safety.table import safe_mus


@pytest.mark.parametrize("p", [Parameters(), Parameters(F=62.0, c1=0.5, k2=70.0)], ids=str)
def test_derivatives_at_a_fold_agree_with_differences(p: Parameters) -> None:
    derivatives = safe_mu_derivatives(System(p))
    assert derivatives is not None
    for name in ("m", "k1", "k2", "k3", "c1", "F"):
        value = getattr(p, name)
        varied_values = value * np.array([1.0 - 1e-3, 1.0 + 1e-3])
        separation = np.ones(2, dtype=bool)
        low, high = safe_mus(p, {name: varied_values}, separation).tolist()
        assert derivatives[name] == pytest.approx((high - low) / (2e-3 * value), rel=1e-4)
    # Safe μ depends on k_nl and F only by k_nl F².
    assert derivatives["k_nl"] == pytest.approx(derivatives["F"] * p.F / (2.0 * p.k_nl), rel=1e-5)


def test_derivatives_at_a_supercritical_hopf_point_are_those_of_the_critical_mu() -> None:
    p = Parameters(F=40.0)
    assert safe_mu_derivatives(System(p)) == critical_mu_derivatives(System(p))
    linear = Parameters(k_nl=0.0)
    assert safe_mu_derivatives(System(linear, separation=False)) == critical_mu_derivatives(
        System(linear)
    )
    assert safe_mu_derivatives(System(Parameters(k3=0.0))) is None
