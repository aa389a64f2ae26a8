"""Estimates from scattered members, with 95 % intervals from independent scramblings."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.sweeps import Scatter

Floats = NDArray[np.float64]

LEVEL: Final = 0.95
QUANTILES: Final = (0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99)


@dataclass(frozen=True, slots=True)
class SampleEstimate:
    """An estimate and the ends of its 95 % interval."""

    value: float
    low: float
    high: float

    @property
    def error(self) -> float:
        """Half the width of the interval."""
        return 0.5 * (self.high - self.low)

    def to_dict(self) -> dict[str, float]:
        """As data for JSON."""
        return {"value": self.value, "low": self.low, "high": self.high}


@dataclass(frozen=True, slots=True)
class SobolIndex:
    """Sobol indices of an output by one input: the shares of its variance, with intervals.

    Attributes
    ----------
    first : SampleEstimate
        What the input explains alone.
    total : SampleEstimate
        What it explains alone and together with others.
    """

    first: SampleEstimate
    total: SampleEstimate

    def to_dict(self) -> dict[str, float]:
        """As data for JSON: ``low`` and ``high`` are those of ``first``."""
        return {
            "first": self.first.value,
            "total": self.total.value,
            "low": self.first.low,
            "high": self.first.high,
            "total_low": self.total.low,
            "total_high": self.total.high,
        }


def estimate(values: Floats) -> SampleEstimate:
    """The mean of independent estimates of the same, with Student's interval."""
    from scipy.special import stdtrit

    mean, count = float(values.mean()), values.size
    spread = float(values.std(ddof=1)) / math.sqrt(count)
    half = float(stdtrit(count - 1, 0.5 + 0.5 * LEVEL)) * spread
    return SampleEstimate(mean, mean - half, mean + half)


def probability(hits: Floats, counts: Floats) -> SampleEstimate:
    """A probability from the hits and members of each scrambling.

    Where all scramblings have the same share, the interval is as wide as what they do not resolve:
    that of none hit among as many independent members, or of one more hit in a part of them.
    """
    found = estimate(hits / counts)
    low, high = found.low, found.high
    if np.ptp(hits / counts) == 0.0:
        rare = math.log(1.0 - LEVEL)
        least = max(
            -math.expm1(rare / float(counts.sum())),
            -math.expm1(rare / hits.size) / float(counts.min()),
        )
        low, high = found.value - least, found.value + least
    return SampleEstimate(found.value, max(low, 0.0), min(high, 1.0))


def probability_of(truths: Floats) -> SampleEstimate | None:
    """The probability that what is 0 or 1 is 1, a row per scrambling; NaN does not count."""
    known = ~np.isnan(truths)
    counts = known.sum(axis=1).astype(float)
    if not counts.all():
        return None
    return probability(np.where(known, truths, 0.0).sum(axis=1), counts)


def quantiles_of(values: Floats) -> dict[str, SampleEstimate]:
    """Quantiles of values, a row per scrambling, by their level as text; NaN does not count."""
    if np.isnan(values).all(axis=1).any():
        return {}
    found = np.nanquantile(values, QUANTILES, axis=1)
    return {f"{level:g}": estimate(row) for level, row in zip(QUANTILES, found, strict=True)}


def mean_of(values: Floats) -> SampleEstimate | None:
    """The mean of values, a row per scrambling; NaN does not count."""
    if np.isnan(values).all(axis=1).any():
        return None
    return estimate(np.nanmean(values, axis=1))


def sobol_of(scatter: Scatter, values: Floats) -> dict[str, SobolIndex]:
    """Sobol indices by input of the values of all members; none where a member has no value."""
    from scipy.stats import sobol_indices

    if np.isnan(values).any():
        return {}
    parts: Any = scatter.parts_of(values).transpose(2, 1, 0)
    # Scramblings are what SciPy calls outputs.
    given: Any = {"f_A": parts[0], "f_B": parts[1], "f_AB": parts[2:]}
    found = sobol_indices(func=given, n=scatter.count)
    shape = scatter.repeats, len(scatter.axes)
    first, total = (np.reshape(each, shape).T for each in (found.first_order, found.total_order))
    return {
        name: SobolIndex(estimate(one), estimate(all_))
        for name, one, all_ in zip(scatter.axes, first, total, strict=True)
    }


def dicts(given: Mapping[str, Any]) -> dict[str, Any]:
    """Estimates or indices by name as data for JSON."""
    return {name: each.to_dict() for name, each in given.items()}


def ranked(indices: Mapping[str, SobolIndex]) -> Sequence[tuple[str, SobolIndex]]:
    """Inputs and their indices by falling total index."""
    return sorted(indices.items(), key=lambda item: -item[1].total.value)
