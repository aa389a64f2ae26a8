"""Intervals of uncertainty studies contain exact values as often as they promise."""

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

# Of 200 intervals of 95 %, fewer than 180 contain the exact value in 1 of 500 tests, if they are
# independent; of 20, fewer than 16 in 1 of 380.
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


def critical(values: Mapping[str, Floats]) -> Floats:
    """The critical μ where other parameters scatter."""
    size = len(next(iter(values.values())))
    return critical_mus(Parameters(), values, np.ones(size, dtype=bool))


def _of_preload() -> Case:
    # The critical μ rises with F.
    force = parse_distribution("uniform:70:120")
    nodes, weights = np.polynomial.legendre.leggauss(40)
    mean = 0.5 * float(weights @ critical({"F": force.at(0.5 + 0.5 * nodes)}))
    quantiles = tuple(critical({"F": force.at(QUANTILES)}).tolist())
    return Case({"F": "uniform:70:120"}, critical, mean, quantiles, {"F": (1.0, 1.0)})


def _of_both() -> Case:
    # By midpoints in both directions; the critical μ is that of F, and uniform μ.
    cells = (np.arange(2**12) + 0.5) / 2**12
    thresholds = critical({"F": parse_distribution("normal:80:8").at(cells)})
    by_force = np.clip((0.8 - thresholds) / 0.6, 0.0, 1.0)
    by_friction = np.searchsorted(np.sort(thresholds), 0.2 + 0.6 * cells) / cells.size
    mean = float(by_force.mean())
    force, friction = (
        float(shares.var()) / (mean * (1.0 - mean)) for shares in (by_force, by_friction)
    )
    return Case(
        {"mu": "uniform:0.2:0.8", "F": "normal:80:8"},
        lambda values: (values["mu"] > critical({"F": values["F"]})).astype(float),
        mean,
        indices={"mu": (friction, 1.0 - force), "F": (force, 1.0 - friction)},
    )


def _of_sum() -> Case:
    variance = 1.0 + 0.03**2
    share = 1.0 / variance
    return Case(
        {"x0": "normal:0:1", "y0": "normal:0:1"},
        lambda values: values["x0"] + 0.03 * values["y0"],
        0.0,
        tuple(np.multiply(math.sqrt(variance), stats.norm.ppf(QUANTILES)).tolist()),
        {"x0": (share, share), "y0": (1.0 - share, 1.0 - share)},
    )


def _of_excess() -> Case:
    # Values that are 0 for five of six samples.
    level = 1.0
    mean = float(stats.norm.pdf(level) - level * stats.norm.sf(level))
    quantiles = np.maximum(stats.norm.ppf(QUANTILES) - level, 0.0)
    return Case(
        {"x0": "normal:0:1", "y0": "normal:0:1"},
        lambda values: np.maximum(values["x0"] - level, 0.0),
        mean,
        tuple(quantiles.tolist()),
        {"x0": (1.0, 1.0), "y0": (0.0, 0.0)},
    )


def _of_skewed() -> Case:
    # Most values are small compared with their range.
    quantiles = parse_distribution("lognormal:1:1").at(QUANTILES)
    return Case(
        {"x0": "lognormal:1:1"},
        lambda values: values["x0"],
        1.0,
        tuple(quantiles.tolist()),
        {"x0": (1.0, 1.0)},
    )


def _of_rare(probability: float) -> Case:
    threshold = math.sqrt(2.0) * float(stats.norm.isf(probability))
    return Case(
        {"x0": "normal:0:1", "y0": "normal:0:1"},
        lambda values: (values["x0"] + values["y0"] > threshold).astype(float),
        probability,
    )


CASES: Final[Mapping[str, Callable[[], Case]]] = {
    "critical μ of F": _of_preload,
    "unstable of μ and F": _of_both,
    "sum": _of_sum,
    "excess": _of_excess,
    "skewed": _of_skewed,
    "1 of 10": lambda: _of_rare(0.1),
    "1 of 1000": lambda: _of_rare(1e-3),
    "1 of 100000": lambda: _of_rare(1e-5),
}


def coverage(
    case: Case, kind: Literal["sobol", "lhs"], *, samples: int, repeats: int, seeds: int
) -> tuple[Counter[str], Counter[str]]:
    """Count how often intervals contain the exact value, and how often there is an interval."""
    contained: Counter[str] = Counter()
    counted: Counter[str] = Counter()
    axes = {name: parse_distribution(text) for name, text in case.vary.items()}

    def compare(name: str, interval: SampleEstimate | None, exact: float) -> None:
        if interval is not None:
            counted[name] += 1
            # The tolerance includes rounding of the exact values.
            contained[name] += interval.low - 1e-12 <= exact <= interval.high + 1e-12

    for seed in range(seeds):
        # Scramblings of different seeds are different ones.
        scatter = Scatter(axes, kind, samples // (2 * repeats), seed * repeats, repeats)
        values = case.function(scatter.columns(np.arange(scatter.size)))
        rows = np.asarray(scatter.sample_values(values), dtype=float)
        if case.quantiles:
            compare("mean", mean_of(rows), case.mean)
            quantiles = quantiles_of(rows)
            for level, exact in zip(QUANTILES, case.quantiles, strict=True):
                compare(f"quantile {level:g}", quantiles[f"{level:g}"], exact)
        else:
            compare("probability", probability_of(rows), case.mean)
        indices = sobol_of(scatter, values)
        for name, (first, total) in case.indices.items():
            if name in indices:
                compare(f"first {name}", indices[name].first, first)
                compare(f"total {name}", indices[name].total, total)
    return contained, counted


def check(
    case: Case,
    kind: Literal["sobol", "lhs"],
    extent: str,
    *,
    samples: int,
    repeats: int = 16,
) -> None:
    """Hold every interval of a case to the promised coverage."""
    seeds, least = SEEDS[extent]
    contained, counted = coverage(case, kind, samples=samples, repeats=repeats, seeds=seeds)
    refused = {
        name: (contained[name], count)
        for name, count in counted.items()
        if contained[name] < count - (seeds - least)
    }
    assert not refused


@pytest.mark.parametrize(
    ("name", "kind"), [*((name, "sobol") for name in CASES), ("critical μ of F", "lhs")]
)
def test_intervals_contain_the_exact_values(name: str, kind: Literal["sobol", "lhs"]) -> None:
    check(CASES[name](), kind, "reduced", samples=512)


@pytest.mark.whole
@pytest.mark.parametrize("samples", [256, 1024, 16384])
@pytest.mark.parametrize("kind", ["sobol", "lhs"])
@pytest.mark.parametrize("name", CASES)
def test_intervals_contain_the_exact_values_of_200_seeds(
    kind: Literal["sobol", "lhs"], name: str, samples: int
) -> None:
    check(CASES[name](), kind, "all", samples=samples)


@pytest.mark.whole
@pytest.mark.parametrize("repeats", [2, 4, 64])
@pytest.mark.parametrize("name", CASES)
def test_intervals_of_other_numbers_of_scramblings(name: str, repeats: int) -> None:
    check(CASES[name](), "sobol", "all", samples=4096, repeats=repeats)
