"""Estimates and Sobol indices against exact values."""

import numpy as np
import pytest

from fivtui.distributions import Distribution
from fivtui.reliability.statistics import (
    effective_samples,
    mark_sampling_error,
    mean_estimate,
    mean_of,
    probability_from_counts,
    probability_of,
    quantiles_of,
    sobol_of,
)
from fivtui.sweeps.scatter import Scatter

ANGLE = Distribution("uniform", (-np.pi, np.pi))
# First and total Sobol index of each input of Ishigami's function with a = 7, b = 0.1.
ISHIGAMI = {"x0": (0.3139, 0.5576), "vx0": (0.4424, 0.4424), "y0": (0.0, 0.2437)}


@pytest.mark.parametrize("kind", ["sobol", "lhs"])
def test_indices_of_the_ishigami_function_are_exact_to_one_percent(kind: str) -> None:
    count = 1024 if kind == "sobol" else 8192
    scatter = Scatter(dict.fromkeys(ISHIGAMI, ANGLE), kind, count=count)  # type: ignore[arg-type]
    x, y, z = scatter.columns(np.arange(scatter.size)).values()
    indices = sobol_of(scatter, np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x))
    for name, (first, total) in ISHIGAMI.items():
        assert indices[name].first.value == pytest.approx(first, abs=0.01)
        assert indices[name].total.value == pytest.approx(total, abs=0.01)
        assert indices[name].first.error < 0.01
        assert indices[name].total.error < 0.01
    data = indices["x0"].to_dict()
    assert data["low"] < data["first"] < data["high"]


def test_a_single_input_explains_all_variance_and_a_constant_has_no_indices() -> None:
    scatter = Scatter({"mu": Distribution("uniform", (0.0, 1.0))}, count=256, repeats=2)
    (values,) = scatter.columns(np.arange(scatter.size)).values()
    indices = sobol_of(scatter, values)["mu"]
    assert indices.first.value == pytest.approx(1.0, abs=0.01)
    assert indices.total.value == pytest.approx(1.0, abs=0.01)
    assert sobol_of(scatter, np.ones(scatter.size)) == {}
    values[3] = np.nan
    assert sobol_of(scatter, values) == {}


def test_95_percent_intervals_contain_the_mean_of_95_percent_of_draws() -> None:
    draws = np.random.default_rng(5).normal(2.0, 1.0, (4000, 8))
    intervals = [mean_estimate(row) for row in draws]
    contained = np.mean([interval.low <= 2.0 <= interval.high for interval in intervals])
    assert contained == pytest.approx(0.95, abs=0.012)


def test_zero_hits_do_not_give_a_probability_of_zero() -> None:
    no_hits = probability_from_counts(np.zeros(4), np.full(4, 250.0))
    assert (no_hits.value, no_hits.low) == (0.0, 0.0)
    assert no_hits.high == pytest.approx(1.0 - 0.05 ** (1.0 / 1000.0))
    # All four scramblings have 100 of 250 hits, but others might have 101: a share s of them is
    # unnoticed with probability (1 - s)^4, at least 0.05 at 95 % confidence.
    equal_shares = probability_from_counts(np.full(4, 100.0), np.full(4, 250.0))
    share_of_scramblings = 1.0 - 0.05 ** (1.0 / 4.0)
    assert equal_shares.value == 0.4
    assert equal_shares.error == pytest.approx(max(no_hits.high, share_of_scramblings / 250.0))
    all_hits = probability_from_counts(np.full(4, 250.0), np.full(4, 250.0))
    assert (all_hits.value, all_hits.high) == (1.0, 1.0)
    assert all_hits.low == pytest.approx(1.0 - no_hits.high)


def test_samples_of_unknown_outcome_do_not_count() -> None:
    nan = np.nan
    # A row per scrambling: 1 where the event occurred, NaN where that is not known.
    probability = probability_of(np.array([[1.0, 0.0, nan, nan], [1.0, 1.0, 0.0, 0.0]]))
    assert probability is not None
    assert probability.value == 0.5
    assert probability_of(np.array([[nan, nan], [1.0, 0.0]])) is None


def test_the_interval_of_a_quantile_beyond_all_samples_is_unbounded() -> None:
    values = np.linspace(0.0, 1.0, 64).reshape(4, 16)
    quantiles = quantiles_of(values)
    assert (quantiles["0.01"].low, quantiles["0.99"].high) == (-np.inf, np.inf)
    assert quantiles["0.99"].to_dict()["high"] is None
    assert 0.0 < quantiles["0.5"].low < 0.5 < quantiles["0.5"].high < 1.0
    # If all values are equal, each quantile is that value.
    equal = quantiles_of(np.full((16, 64), 0.1))["0.75"]
    assert (equal.low, equal.value, equal.high) == (0.1, 0.1, 0.1)
    assert quantiles_of(np.array([[np.nan, np.nan], [0.0, 1.0]])) == {}


def test_the_interval_of_a_mean_includes_its_rounding_error() -> None:
    mean = mean_of(np.full((16, 1000), 0.1))
    assert mean is not None
    assert mean.low < 0.1 < mean.high
    assert mean.error < 1e-15


def test_effective_samples_are_those_that_make_up_the_variance() -> None:
    # With deviations d from the mean their number is (Σ d²)²/Σ d⁴; NaN does not count.
    assert effective_samples(np.ones(100)) == 0.0
    assert effective_samples(np.full(3, np.nan)) == 0.0
    assert effective_samples(np.tile([0.0, 1e-200, np.nan], 50)) == pytest.approx(100.0)
    assert effective_samples(np.repeat([0.0, 1.0], [996, 4])) == pytest.approx(4.0, rel=0.01)


@pytest.mark.parametrize(
    ("printed", "remark"),
    [
        ("1.02 ± 0.03", "1.02 ± 0.03 (above 1: sampling error)"),
        ("-0.01 ± 0.02", "-0.01 ± 0.02 (below 0: sampling error)"),
        ("1 ± 0.03", "1 ± 0.03"),
        ("0.00", "0.00"),
    ],
)
def test_an_index_beyond_0_to_1_is_marked(printed: str, remark: str) -> None:
    assert mark_sampling_error(printed) == remark
