"""Distributions: definitions, truncation, and refused texts."""

import math
import pickle

import numpy as np
import pytest
from scipy import stats

from fivtui.distributions import Distribution, parse_distribution, parse_named_distribution
from fivtui.model.errors import InputError

LEVELS = np.array([1e-6, 0.1, 0.5, 0.9, 1.0 - 1e-6])
SPREAD = math.sqrt(math.log(1.0 + 0.2**2))

SCIPY_DISTRIBUTIONS = {
    "uniform:0.2:0.8": stats.uniform(0.2, 0.6),
    "normal:80:8": stats.norm(80.0, 8.0),
    "lognormal:100:20": stats.lognorm(SPREAD, scale=100.0 * math.exp(-0.5 * SPREAD**2)),
    "triangular:1:2:5": stats.triang(0.25, 1.0, 4.0),
    "beta:-1:3:2:5": stats.beta(2.0, 5.0, -1.0, 4.0),
    "weibull_min:1.5:2:3": stats.weibull_min(1.5, 2.0, 3.0),
    "gamma:2": stats.gamma(2.0),
}


@pytest.mark.parametrize("text", SCIPY_DISTRIBUTIONS)
def test_a_distribution_agrees_with_that_of_scipy_and_prints_its_text(text: str) -> None:
    distribution = parse_distribution(text)
    assert str(distribution) == text
    np.testing.assert_allclose(
        distribution.at(LEVELS), SCIPY_DISTRIBUTIONS[text].ppf(LEVELS), rtol=1e-13
    )
    assert distribution.truncated_share == 0.0
    assert pickle.loads(pickle.dumps(distribution)) == distribution


def test_mean_and_sd_of_a_lognormal_are_those_of_the_quantity() -> None:
    # `moments` is computed from a finite number of quantiles, without the ends of the tails.
    assert parse_distribution("lognormal:100:20").moments() == pytest.approx(
        (100.0, 20.0), rel=2e-3
    )
    assert SCIPY_DISTRIBUTIONS["lognormal:100:20"].std() == pytest.approx(20.0)


def test_truncation_rescales_the_distribution() -> None:
    normal = Distribution("normal", (1.0, 2.0))
    truncated = normal.truncate(0.0, 100.0)
    assert truncated.truncated_share == pytest.approx(stats.norm.cdf(-0.5))
    expected = stats.truncnorm((0.0 - 1.0) / 2.0, (100.0 - 1.0) / 2.0, 1.0, 2.0)
    np.testing.assert_allclose(truncated.at(LEVELS), expected.ppf(LEVELS), rtol=1e-9)
    assert truncated.truncate(-5.0, 3.0) == normal.truncate(0.0, 3.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("normal:1", "normal:MEAN:SD"),
        ("normal:1:0", "SD must be above 0"),
        ("lognormal:-1:1", "must be above 0"),
        ("uniform:2:1", "LOW must be below HIGH"),
        ("triangular:1:5:2", "must ascend"),
        ("beta:0:1:0:1", "A and B above 0"),
        ("gauss:1:2", "unknown distribution 'gauss': must be uniform, normal"),
        ("norm_gen:1", "unknown distribution"),
        ("weibull_min", "must be weibull_min:C:LOC:SCALE"),
        ("weibull_min:-1", "scipy.stats.weibull_min does not allow these numbers"),
        ("normal:a:1", "not a number"),
        ("normal:1:1e999", "not a finite number"),
    ],
)
def test_invalid_distributions_are_refused(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_distribution(text)


def test_an_empty_truncation_is_refused() -> None:
    with pytest.raises(InputError, match="must have values from 0 to 100"):
        Distribution("uniform", (-2.0, -1.0)).truncate(0.0, 100.0)


@pytest.mark.parametrize("text", ["mu", "mu~", "~normal:1:2", "mu=normal:1:2"])
def test_a_scattered_quantity_has_a_name_and_a_distribution(text: str) -> None:
    with pytest.raises(InputError, match="must be NAME~DISTRIBUTION"):
        parse_named_distribution("--vary", text)
    with pytest.raises(InputError, match="did you mean mu"):
        parse_named_distribution("--vary", "Mu~normal:1:2")
