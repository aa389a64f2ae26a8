"""Growth of large motions with a linear contact spring, against motions of many sizes."""

import pytest

from fivtui import ComputationError, Parameters, safe_friction, simulate
from fivtui.safety.growth import least_growth_mu
from fivtui.safety.phrases import basis_rows, verdict_text

# Regression: motions with this linear contact spring were reported as limit cycles.
REGRESSION_SET = Parameters(
    m=6.315485202075405,
    k1=77.2186022588098,
    k2=53.987383566936074,
    k3=121.66370369126169,
    c1=0.6101295552948368,
    c2=1.2953091522818798,
    F=21.804007433558215,
    k_nl=0.0,
    mu=0.8,
)


def late_size_ratio(p: Parameters, size: float) -> float:
    """Late half peak-to-peak of a motion over its start size; infinite if numbers overflow."""
    try:
        return simulate(p, start=(0.0, 0.0, size, 0.0), t_end=2000.0).steady.y_half_range / size
    except ComputationError:
        return float("inf")


@pytest.mark.parametrize("p", [Parameters(k_nl=0.0), REGRESSION_SET])
def test_large_motions_grow_above_the_least_growth_mu_and_no_motion_below(
    p: Parameters,
) -> None:
    mu = least_growth_mu(p, 1.5)
    assert mu is not None
    for size in (1e3, 1e6, 1e9):
        assert late_size_ratio(p.with_values({"mu": 0.99 * mu}), size) < 1.0
    assert late_size_ratio(p.with_values({"mu": 1.01 * mu}), 1e9) > 1.0


def test_the_least_growth_mu_does_not_depend_on_the_preload_or_the_searched_range() -> None:
    p = Parameters(k_nl=0.0)
    values = [
        least_growth_mu(p.with_values({"F": F}), mu_limit)
        for F, mu_limit in ((80.0, 1.5), (5.0, 1.0))
    ]
    assert values[0] == pytest.approx(values[1], rel=1e-6)
    assert least_growth_mu(p, 0.5) is None


def test_the_verdict_reports_growth_of_large_motions_and_no_limit_cycle() -> None:
    # `basis` is the record of the search; `others` are the attractors that it found below the
    # critical μ, besides the equilibrium.
    verdict = safe_friction(REGRESSION_SET)
    mu = least_growth_mu(REGRESSION_SET, verdict.searched_to)
    assert verdict.safe_mu == verdict.basis.growth_at_any_size == mu
    assert mu == pytest.approx(0.76805, abs=1e-5)
    (attractor,) = verdict.others
    assert attractor.kind == "unbounded growth"
    search = dict(basis_rows(verdict))["global search"]
    assert "limit cycle" not in search
    assert "from μ = 0.768 on motions grow without bounds" in search
    assert "k_nl = 0" in search
    assert verdict_text(verdict) == (
        "stable to small disturbances below μ = 1.1675; to all disturbances found below μ = 0.76804"
    )
