"""Intervals of uncertainty studies contain exact values as often as their level, 95 %, states.

Tests marked `whole` repeat the reduced ones with more seeds; `pytest -m whole` runs them.
"""

import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from fivtui.distributions import parse_distribution
from fivtui.equilibrium import critical_mus
from fivtui.model import Parameters
from fivtui.reliability.statistics import (
    QUANTILES,
    SampleEstimate,
    mean_of,
    probability_of,
    quantiles_of,
    sobol_of,
)
from fivtui.sweeps.scatter import Scatter

Floats = NDArray[np.float64]

# Number of seeds, and least number of intervals that must contain the exact value. If intervals
# are independent, fewer than 180 of 200 contain it in 1 of 500 tests, and fewer than 16 of 20 in 1
# of 380.
SEEDS: Final = {"reduced": (20, 16), "all": (200, 180)}


@dataclass(frozen=True)
class Case:
    """A function of scattered inputs and its exact statistics."""

    vary: Mapping[str, str]
    function: Callable[[Mapping[str, Floats]], Floats]
    mean: float
    quantiles: tuple[float, ...] = ()
    # First and total Sobol index by input.
    indices: Mapping[str, tuple[float, float]] = field(default_factory=dict)


def critical_mu_values(values: Mapping[str, Floats]) -> Floats:
    """The critical μ of members, from the values of their scattered parameters."""
    size = len(next(iter(values.values())))
    return critical_mus(Parameters(), values, np.ones(size, dtype=bool))


def _critical_mu_case() -> Case:
    # The critical μ rises with F: each quantile of it is its value at the same quantile of F, which
    # `at` gives.
    force = parse_distribution("uniform:70:120")
    nodes, weights = np.polynomial.legendre.leggauss(40)
    mean = 0.5 * float(weights @ critical_mu_values({"F": force.at(0.5 + 0.5 * nodes)}))
    quantiles = tuple(critical_mu_values({"F": force.at(QUANTILES)}).tolist())
    return Case({"F": "uniform:70:120"}, critical_mu_values, mean, quantiles, {"F": (1.0, 1.0)})


def _instability_case() -> Case:
    # Integrals by the midpoint rule over the levels of F and of μ, which is uniform.
    cells = (np.arange(2**12) + 0.5) / 2**12
    # The variance of the probability given one input is its first index, relative to that of the
    # event. Of two inputs, the total index of one and the first of the other sum to 1.
    critical_mus_of_force = critical_mu_values({"F": parse_distribution("normal:80:8").at(cells)})
    probability_by_force = np.clip((0.8 - critical_mus_of_force) / 0.6, 0.0, 1.0)
    probability_by_friction = (
        np.searchsorted(np.sort(critical_mus_of_force), 0.2 + 0.6 * cells) / cells.size
    )
    mean = float(probability_by_force.mean())
    first_force, first_friction = (
        float(shares.var()) / (mean * (1.0 - mean))
        for shares in (probability_by_force, probability_by_friction)
    )
    return Case(
        {"mu": "uniform:0.2:0.8", "F": "normal:80:8"},
        lambda values: (values["mu"] > critical_mu_values({"F": values["F"]})).astype(float),
        mean,
        indices={
            "mu": (first_friction, 1.0 - first_force),
            "F": (first_force, 1.0 - first_friction),
        },
    )


def _sum_case() -> Case:
    variance = 1.0 + 0.03**2
    share = 1.0 / variance
    return Case(
        {"x0": "normal:0:1", "y0": "normal:0:1"},
        lambda values: values["x0"] + 0.03 * values["y0"],
        0.0,
        tuple(np.multiply(math.sqrt(variance), stats.norm.ppf(QUANTILES)).tolist()),
        {"x0": (share, share), "y0": (1.0 - share, 1.0 - share)},
    )


def _excess_case() -> Case:
    # Values that are 0 for five of six samples.
    threshold = 1.0
    mean = float(stats.norm.pdf(threshold) - threshold * stats.norm.sf(threshold))
    quantiles = np.maximum(stats.norm.ppf(QUANTILES) - threshold, 0.0)
    return Case(
        {"x0": "normal:0:1", "y0": "normal:0:1"},
        lambda values: np.maximum(values["x0"] - threshold, 0.0),
        mean,
        tuple(quantiles.tolist()),
        {"x0": (1.0, 1.0), "y0": (0.0, 0.0)},
    )


def _skewed_case() -> Case:
    # Most values are small compared with their range; mean and standard deviation are 1.
    quantiles = parse_distribution("lognormal:1:1").at(QUANTILES)
    return Case(
        {"x0": "lognormal:1:1"},
        lambda values: values["x0"],
        1.0,
        tuple(quantiles.tolist()),
        {"x0": (1.0, 1.0)},
    )


def _rare_event_case(probability: float) -> Case:
    threshold = math.sqrt(2.0) * float(stats.norm.isf(probability))
    return Case(
        {"x0": "normal:0:1", "y0": "normal:0:1"},
        lambda values: (values["x0"] + values["y0"] > threshold).astype(float),
        probability,
    )


CASES: Final[Mapping[str, Callable[[], Case]]] = {
    "critical μ of F": _critical_mu_case,
    "unstable of μ and F": _instability_case,
    "sum": _sum_case,
    "excess": _excess_case,
    "skewed": _skewed_case,
    "1 of 10": lambda: _rare_event_case(0.1),
    "1 of 1000": lambda: _rare_event_case(1e-3),
    "1 of 100000": lambda: _rare_event_case(1e-5),
}


def count_contained(
    case: Case, kind: Literal["sobol", "lhs"], *, samples: int, repeats: int, seeds: int
) -> tuple[Counter[str], Counter[str]]:
    """Count how often intervals contain the exact value, and how often there is an interval."""
    contained: Counter[str] = Counter()
    counted: Counter[str] = Counter()
    axes = {name: parse_distribution(text) for name, text in case.vary.items()}

    def count_interval(name: str, interval: SampleEstimate | None, exact: float) -> None:
        if interval is not None:
            counted[name] += 1
            # The tolerance includes rounding of the exact values.
            contained[name] += interval.low - 1e-12 <= exact <= interval.high + 1e-12

    for seed in range(seeds):
        # Every point has two samples, and further members for Sobol indices. Each scrambling has a
        # seed of its own, so designs whose first seeds are `repeats` apart share none.
        scatter = Scatter(
            axes,
            kind,
            count=samples // (2 * repeats),
            seed=seed * repeats,
            repeats=repeats,
        )
        values = case.function(scatter.columns(np.arange(scatter.size)))
        rows = np.asarray(scatter.sample_values(values), dtype=float)
        if case.quantiles:
            count_interval("mean", mean_of(rows), case.mean)
            quantiles = quantiles_of(rows)
            for level, exact in zip(QUANTILES, case.quantiles, strict=True):
                count_interval(f"quantile {level:g}", quantiles[f"{level:g}"], exact)
        else:
            count_interval("probability", probability_of(rows), case.mean)
        indices = sobol_of(scatter, values)
        for name, (first, total) in case.indices.items():
            if name in indices:
                count_interval(f"first {name}", indices[name].first, first)
                count_interval(f"total {name}", indices[name].total, total)
    return contained, counted


def check_coverage(
    case: Case,
    kind: Literal["sobol", "lhs"],
    extent: str,
    *,
    samples: int,
    repeats: int = 16,
) -> None:
    """Assert that every interval of a case contains the exact value often enough."""
    seeds, least_contained = SEEDS[extent]
    contained, counted = count_contained(case, kind, samples=samples, repeats=repeats, seeds=seeds)
    too_rarely_contained = {
        name: (contained[name], count)
        for name, count in counted.items()
        if contained[name] < count - (seeds - least_contained)
    }
    assert not too_rarely_contained


@pytest.mark.parametrize(
    ("name", "kind"), [*((name, "sobol") for name in CASES), ("critical μ of F", "lhs")]
)
def test_intervals_contain_the_exact_values(name: str, kind: Literal["sobol", "lhs"]) -> None:
    check_coverage(CASES[name](), kind, "reduced", samples=512)


@pytest.mark.whole
@pytest.mark.parametrize("samples", [256, 1024, 16384])
@pytest.mark.parametrize("kind", ["sobol", "lhs"])
@pytest.mark.parametrize("name", CASES)
def test_intervals_contain_the_exact_values_of_200_seeds(
    kind: Literal["sobol", "lhs"], name: str, samples: int
) -> None:
    check_coverage(CASES[name](), kind, "all", samples=samples)


@pytest.mark.whole
@pytest.mark.parametrize("repeats", [2, 4, 64])
@pytest.mark.parametrize("name", CASES)
def test_intervals_from_other_numbers_of_scramblings_contain_the_exact_values(
    name: str, repeats: int
) -> None:
    check_coverage(CASES[name](), "sobol", "all", samples=4096, repeats=repeats)
