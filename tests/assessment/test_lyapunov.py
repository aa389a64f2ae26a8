"""Growth of small errors: the largest Lyapunov exponent and the fate of errors."""

import numpy as np
import pytest

from fivtui import Parameters, simulate
from fivtui.assessment.lyapunov import ErrorGrowth, Fate, error_growth
from fivtui.equilibrium.eigenvalues import growth_rate
from fivtui.model import System
from fivtui.model.errors import Cancelled, ComputationError
from fivtui.transient.request import Request


def growth_of_errors(p: Parameters, t_end: float, *, separation: bool = True) -> ErrorGrowth:
    return error_growth(Request(System(p, separation), t_end=t_end, tol=1e-10))


def test_at_a_stable_equilibrium_the_exponent_is_the_growth_rate() -> None:
    p = Parameters(mu=0.2)
    result = growth_of_errors(p, 400.0)
    assert result.fate is Fate.DECAYS
    assert result.exponent == pytest.approx(growth_rate(System(p)), abs=result.uncertainty / 5.0)
    assert result.final < 1e-3


def test_in_a_growing_linear_scene_the_exponent_is_the_greatest_real_part() -> None:
    p = Parameters(k_nl=0.0, mu=2.0)
    result = growth_of_errors(p, 200.0, separation=False)
    assert result.fate is Fate.UNBOUNDED
    assert result.exponent == pytest.approx(growth_rate(System(p, separation=False)), rel=0.02)


@pytest.mark.parametrize("separation", [True, False])
def test_on_a_limit_cycle_errors_grow_at_first_and_then_stay_bounded(separation: bool) -> None:
    result = growth_of_errors(Parameters(), 500.0, separation=separation)
    assert result.fate is Fate.BOUNDED
    assert abs(result.exponent) < 0.1 * result.uncertainty
    assert 10.0 < result.greatest < 350.0


def test_the_uncertainty_is_the_rate_of_growth_by_a_thousand_in_half_the_run() -> None:
    for t_end in (100.0, 400.0):
        result = growth_of_errors(Parameters(), t_end)
        assert result.uncertainty == pytest.approx(np.log(1e3) / (0.5 * t_end), rel=1e-12)
        assert result.duration == t_end


def test_separation_without_damping_causes_sensitive_dependence() -> None:
    p = Parameters(c1=0.0, c2=0.0)
    result = growth_of_errors(p, 1500.0)
    assert result.fate is Fate.SENSITIVE
    # Over such a horizon the exponent is accurate to about a factor of two.
    assert 0.01 < result.exponent < 0.08
    # Two runs whose starts differ by 1e-14 of their size diverge within this horizon.
    start = np.array(simulate(p, t_end=1e-3).start)
    first, second = (
        simulate(p, t_end=1500.0, start=tuple(start * factor)) for factor in (1.0, 1.0 + 1e-14)
    )
    assert abs(first.final.y - second.final.y) > 0.01


def test_the_fate_is_undecided_in_a_run_that_is_too_short() -> None:
    result = growth_of_errors(Parameters(mu=5.0), 12.0)
    assert result.fate is Fate.UNDECIDED
    assert result.greatest > 1e6


def test_a_run_that_cannot_be_finished_is_refused_and_a_run_can_be_cancelled() -> None:
    with pytest.raises(ComputationError, match=r"in the interval from t = .* on: the motion grows"):
        growth_of_errors(Parameters(k2=186.0, k_nl=0.0, mu=2.0), 2000.0, separation=False)
    with pytest.raises(Cancelled):
        error_growth(Request(System(Parameters())), progress=lambda fraction: fraction < 0.1)
