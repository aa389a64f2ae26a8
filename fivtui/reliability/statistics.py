"""Estimates from scattered members, with 95 % intervals from independent scramblings."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from fivtui.sweeps import Scatter

Floats = NDArray[np.float64]

LEVEL: Final = 0.95
QUANTILES: Final = (0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99)
# Least number of effective samples for Sobol indices.
LEAST_EFFECTIVE: Final = 30.0
# Relative rounding error of a mean.
_ROUNDING: Final = 4.0 * float(np.finfo(float).eps)
# Skewness below which an interval is not corrected.
_SYMMETRIC: Final = 1e-6


@dataclass(frozen=True, slots=True)
class SampleEstimate:
    """An estimate and the ends of its 95 % interval; an end that is not bounded is infinite."""

    value: float
    low: float
    high: float

    @property
    def error(self) -> float:
        """The distance from the value to the farther end of the interval."""
        return max(self.value - self.low, self.high - self.value)

    def to_dict(self) -> dict[str, float | None]:
        """As data for JSON: an infinite end is null."""
        low, high = (end if math.isfinite(end) else None for end in (self.low, self.high))
        return {"value": self.value, "low": low, "high": high}


@dataclass(frozen=True, slots=True)
class SobolIndex:
    """Sobol indices of an output by one input: the shares of its variance, with intervals.

    Attributes
    ----------
    first : SampleEstimate
        The share of the input alone.
    total : SampleEstimate
        The share of the input alone and in interaction with other inputs.
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
    """The mean of independent estimates of the same, with its interval."""
    return SampleEstimate(*(float(value) for value in _interval(values)))


def _interval(values: Floats) -> tuple[Floats, Floats, Floats]:
    """Means over the first axis with the ends of their intervals.

    Student's interval, extended on the side to which the values are skewed (Hall 1992), since few
    estimates seldom include the rare large values. The rounding error is the least width.
    """
    from scipy.special import stdtrit

    count = len(values)
    mean = values.mean(axis=0)
    deviations = values - mean
    moment = (deviations**2).mean(axis=0)
    spread = np.sqrt(moment / (count - 1))
    rounding = _ROUNDING * np.abs(mean)
    divisor = np.where(moment > 0.0, moment, 1.0) ** 1.5
    skewness = (deviations**3).mean(axis=0) / divisor / math.sqrt(count)
    student = float(stdtrit(count - 1, 0.5 + 0.5 * LEVEL))
    below = np.maximum(student, _without_skewness(student, skewness))
    above = np.maximum(student, -_without_skewness(-student, skewness))
    return mean, mean - below * spread - rounding, mean + above * spread + rounding


def _without_skewness(score: float, skewness: Floats) -> Floats:
    # The inverse of Hall's transformation; `skewness` is divided by the root of the count.
    divisor = np.where(np.abs(skewness) > _SYMMETRIC, skewness, 1.0)
    cubic = np.cbrt(1.0 + divisor * (score - divisor / 6.0))
    transformed = 3.0 * (cubic - 1.0) / divisor
    return np.where(np.abs(skewness) > _SYMMETRIC, transformed, score)


def probability(hits: Floats, counts: Floats) -> SampleEstimate:
    """A probability from the hits and members of each scrambling."""
    return SampleEstimate(*(float(value) for value in _shares(hits, counts)))


def _shares(hits: Floats, counts: Floats) -> tuple[Floats, Floats, Floats]:
    """Shares with the ends of their intervals; scramblings are the first axis of both.

    If all scramblings have the same share, the interval has the width of their resolution: that of
    no hit among as many independent members, or of one more hit in a part of them.
    """
    shares = hits / counts
    mean, low, high = _interval(shares)
    rare = math.log(1.0 - LEVEL)
    least = max(
        -math.expm1(rare / float(counts.sum())),
        -math.expm1(rare / counts.size) / float(counts.min()),
    )
    equal = np.ptp(shares, axis=0) == 0.0
    low, high = np.where(equal, mean - least, low), np.where(equal, mean + least, high)
    return mean, np.maximum(low, 0.0), np.minimum(high, 1.0)


def probability_of(truths: Floats) -> SampleEstimate | None:
    """The probability of 1 among values 0 and 1, a row per scrambling; NaN does not count."""
    valid = ~np.isnan(truths)
    counts = valid.sum(axis=1).astype(float)
    if not counts.all():
        return None
    return probability(np.where(valid, truths, 0.0).sum(axis=1), counts)


def quantiles_of(values: Floats) -> dict[str, SampleEstimate]:
    """Quantiles of values, a row per scrambling, by their level as text; NaN does not count.

    An interval has the values at which the interval of the share of smaller values contains the
    level: unlike quantiles, shares of stratified points are unbiased. An end beyond all samples is
    infinite.
    """
    valid = ~np.isnan(values)
    if not valid.any(axis=1).all():
        return {}
    counts = valid.sum(axis=1).astype(float)[:, np.newaxis]
    rows = [np.sort(row[mask]) for row, mask in zip(values, valid, strict=True)]
    pooled = np.sort(np.concatenate(rows))
    levels = np.array(QUANTILES)

    def hits_at(indices: NDArray[np.int64], side: Literal["left", "right"]) -> Floats:
        return np.array([np.searchsorted(row, pooled[indices], side) for row in rows], dtype=float)

    def is_reached(indices: NDArray[np.int64]) -> NDArray[np.bool_]:
        return np.asarray(_shares(hits_at(indices, "right"), counts)[2] >= levels)

    def is_passed(indices: NDArray[np.int64]) -> NDArray[np.bool_]:
        return np.asarray(_shares(hits_at(indices, "left"), counts)[1] > levels)

    lowest, highest = (
        float(_shares(hits, counts)[end][0])
        for hits, end in ((np.zeros_like(counts), 2), (counts, 1))
    )
    estimates = np.quantile(pooled, levels, method="hazen")
    first = _first_index(is_reached, pooled.size, levels.size)
    end_index = _first_index(is_passed, pooled.size, levels.size) - 1
    low = np.where(lowest >= levels, -np.inf, np.minimum(pooled[first], estimates))
    high = np.where(highest <= levels, np.inf, np.maximum(pooled[end_index], estimates))
    return {
        f"{level:g}": SampleEstimate(*ends)
        for level, *ends in zip(
            QUANTILES, estimates.tolist(), low.tolist(), high.tolist(), strict=True
        )
    }


def _first_index(
    holds: Callable[[NDArray[np.int64]], NDArray[np.bool_]], count: int, levels: int
) -> NDArray[np.int64]:
    # For each level the first index at which `holds` is true, by bisection; else the count.
    low = np.zeros(levels, dtype=np.int64)
    high = np.full(levels, count, dtype=np.int64)
    while (low < high).any():
        middle = (low + high) // 2
        true = holds(np.minimum(middle, count - 1)) | (low == high)
        low, high = np.where(true, low, middle + 1), np.where(true, middle, high)
    return low


def mean_of(values: Floats) -> SampleEstimate | None:
    """The mean of values, a row per scrambling; NaN does not count."""
    if np.isnan(values).all(axis=1).any():
        return None
    return estimate(np.nanmean(values, axis=1))


def sobol_of(scatter: Scatter, values: Floats) -> dict[str, SobolIndex]:
    """Sobol indices by input of the values of all members (Saltelli 2010, Jansen 1999).

    None if a member has no value, or the variance comes from too few samples.
    """
    if np.isnan(values).any() or effective_samples(scatter.sample_values(values)) < LEAST_EFFECTIVE:
        return {}
    parts = scatter.split_values(values)
    centred = parts - parts[:, :, :2].mean()
    variances = (centred[:, :, :2] ** 2).mean(axis=(0, 2))
    a, b = centred[:, :, 0], centred[:, :, 1]
    indices = {}
    for column, name in enumerate(scatter.axes, start=2):
        mixed = centred[:, :, column]
        first = (b * (mixed - a)).mean(axis=0)
        total = 0.5 * ((a - mixed) ** 2).mean(axis=0)
        indices[name] = SobolIndex(_ratio(first, variances), _ratio(total, variances))
    return indices


def effective_samples(values: Floats) -> float:
    """The number of samples with equal deviations from the mean that give the same variance.

    0 if all values are equal; NaN does not count.
    """
    values = values[~np.isnan(values)]
    if not values.size:
        return 0.0
    span = float(np.ptp(values))
    if span == 0.0:
        return 0.0
    squares = ((values - values.mean()) / span) ** 2
    return float(squares.sum() ** 2 / (squares**2).sum())


def _ratio(numerators: Floats, denominators: Floats) -> SampleEstimate:
    # The ratio of the means over scramblings, with the interval of its linearised error.
    scale = float(denominators.mean())
    ratio = float(numerators.mean()) / scale
    error = estimate((numerators - ratio * denominators) / scale)
    return SampleEstimate(ratio, ratio + error.low, ratio + error.high)


def beyond_share(printed: str) -> str:
    """Whether the printed value of a Sobol index is above 1 or below 0; empty if neither."""
    value = float(printed.partition(" ")[0])
    if value > 1.0:
        return "above 1"
    return "below 0" if value < 0.0 else ""


def with_remark(printed: str) -> str:
    """The printed value of a Sobol index, with the reason if it is above 1 or below 0."""
    remark = beyond_share(printed)
    return f"{printed} ({remark}: sampling error)" if remark else printed


def to_dicts(records: Mapping[str, Any]) -> dict[str, Any]:
    """Estimates or indices by name as data for JSON."""
    return {name: record.to_dict() for name, record in records.items()}


def ranked(indices: Mapping[str, SobolIndex]) -> Sequence[tuple[str, SobolIndex]]:
    """Inputs and their indices by falling total index."""
    return sorted(indices.items(), key=lambda item: -item[1].total.value)
