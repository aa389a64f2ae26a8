"""Estimates from scattered members, with 95 % intervals from independent scramblings.

A scrambling is one randomisation of all sample points. Estimates from several scramblings are
independent, so that their spread gives the interval of their mean.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from fivtui.sweeps import Scatter

Floats = NDArray[np.float64]

# Confidence level of all intervals.
LEVEL: Final = 0.95
QUANTILES: Final = (0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99)
# Least number of effective samples for Sobol indices.
LEAST_EFFECTIVE: Final = 30.0
# Relative rounding error of a mean.
_ROUNDING_ERROR: Final = 4.0 * float(np.finfo(float).eps)
# Skewness, divided by the root of the count, below which an interval is not corrected.
_LEAST_SKEWNESS: Final = 1e-6


@dataclass(frozen=True, slots=True)
class SampleEstimate:
    """An estimate and the ends of its 95 % interval; an unbounded end is infinite."""

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


def mean_estimate(values: Floats) -> SampleEstimate:
    """The mean of independent estimates of one quantity, with its interval."""
    return SampleEstimate(*(float(value) for value in _mean_interval(values)))


def _mean_interval(values: Floats) -> tuple[Floats, Floats, Floats]:
    """Means over the first axis with the ends of their intervals.

    Student's interval, extended on the side to which the values are skewed (Hall 1992): a few
    estimates rarely include the rare large values. Its half width is at least the rounding error.
    """
    from scipy.special import stdtrit

    count = len(values)
    mean = values.mean(axis=0)
    deviations = values - mean
    moment = (deviations**2).mean(axis=0)
    standard_error = np.sqrt(moment / (count - 1))
    rounding = _ROUNDING_ERROR * np.abs(mean)
    cubed_deviation = np.where(moment > 0.0, moment, 1.0) ** 1.5
    scaled_skewness = (deviations**3).mean(axis=0) / cubed_deviation / math.sqrt(count)
    # Half widths of the interval in standard errors. The t statistic is the mean less the true
    # value: its upper quantile, `student`, gives the lower end.
    student = float(stdtrit(count - 1, 0.5 + 0.5 * LEVEL))
    below = np.maximum(student, _invert_hall(student, scaled_skewness))
    above = np.maximum(student, -_invert_hall(-student, scaled_skewness))
    low = mean - below * standard_error - rounding
    return mean, low, mean + above * standard_error + rounding


def _invert_hall(score: float, scaled_skewness: Floats) -> Floats:
    # The t statistic that Hall's transformation ((1 + a t/3)³ - 1)/a + a/6 turns into `score`; a is
    # the skewness, divided by the root of the count.
    is_skewed = np.abs(scaled_skewness) > _LEAST_SKEWNESS
    a = np.where(is_skewed, scaled_skewness, 1.0)
    root = np.cbrt(1.0 + a * (score - a / 6.0))
    return np.where(is_skewed, 3.0 * (root - 1.0) / a, score)


def probability_from_counts(hits: Floats, counts: Floats) -> SampleEstimate:
    """A probability from the numbers of hits and of members in each scrambling."""
    return SampleEstimate(*(float(value) for value in _share_interval(hits, counts)))


def _share_interval(hits: Floats, counts: Floats) -> tuple[Floats, Floats, Floats]:
    """Shares with the ends of their intervals; scramblings are the first axis of both.

    Equal shares of all scramblings have no spread. The half width is then the greatest change of
    the share that would go unnoticed with probability 1 - `LEVEL`. It consists of hits of
    independent members, or of one more hit in each of some scramblings; the greater change counts.
    """
    shares = hits / counts
    mean, low, high = _mean_interval(shares)
    # What occurs in a share p of all cases occurs in none of n with probability (1 - p)^n, here
    # 1 - LEVEL. A case is a member, which may be a hit, or a scrambling, which may have one more.
    log_probability = math.log(1.0 - LEVEL)
    share_of_members = -math.expm1(log_probability / float(counts.sum()))
    share_of_scramblings = -math.expm1(log_probability / counts.size)
    margin = max(share_of_members, share_of_scramblings / float(counts.min()))
    equal = np.ptp(shares, axis=0) == 0.0
    low, high = np.where(equal, mean - margin, low), np.where(equal, mean + margin, high)
    return mean, np.maximum(low, 0.0), np.minimum(high, 1.0)


def probability_of(flags: Floats) -> SampleEstimate | None:
    """The probability of 1 in flags 0 and 1, a row per scrambling; NaN does not count.

    None if a scrambling has no flag.
    """
    valid = ~np.isnan(flags)
    counts = valid.sum(axis=1).astype(float)
    if not counts.all():
        return None
    return probability_from_counts(np.where(valid, flags, 0.0).sum(axis=1), counts)


def probability_with_undecided(flags: Floats) -> SampleEstimate | None:
    """As `probability_of`, but the interval includes NaN, undecided, as all 0 and as all 1."""
    estimate, least, greatest = (
        probability_of(np.where(np.isnan(flags), value, flags)) for value in (np.nan, 0.0, 1.0)
    )
    if estimate is None or least is None or greatest is None:
        return None
    return SampleEstimate(estimate.value, least.low, greatest.high)


def quantiles_of(values: Floats) -> dict[str, SampleEstimate]:
    """Quantiles of values, a row per scrambling, by their level as text; NaN does not count.

    A value is in the interval of a quantile if the share of samples below it has an interval that
    contains the level. Shares of stratified points are unbiased, quantiles are not. An end beyond
    all samples is infinite.
    """
    valid = ~np.isnan(values)
    if not valid.any(axis=1).all():
        return {}
    counts = valid.sum(axis=1).astype(float)[:, np.newaxis]
    rows = [np.sort(row[mask]) for row, mask in zip(values, valid, strict=True)]
    pooled = np.sort(np.concatenate(rows))
    levels = np.array(QUANTILES)

    def hits_at(indices: NDArray[np.int64], side: Literal["left", "right"]) -> Floats:
        # Numbers of values in each scrambling below the pooled ones, or up to them ("right").
        return np.array([np.searchsorted(row, pooled[indices], side) for row in rows], dtype=float)

    def upper_end_reaches(indices: NDArray[np.int64]) -> NDArray[np.bool_]:
        return np.asarray(_share_interval(hits_at(indices, "right"), counts)[2] >= levels)

    def lower_end_exceeds(indices: NDArray[np.int64]) -> NDArray[np.bool_]:
        return np.asarray(_share_interval(hits_at(indices, "left"), counts)[1] > levels)

    # Intervals of the shares below and above all samples, 0 and 1.
    _, _, (upper_end_without_hits,) = _share_interval(np.zeros_like(counts), counts)
    _, (lower_end_of_all_hits,), _ = _share_interval(counts, counts)
    estimates = np.quantile(pooled, levels, method="hazen")
    least_index = _first_index(upper_end_reaches, pooled.size, levels.size)
    # The last value before the first one that is too great.
    greatest_index = _first_index(lower_end_exceeds, pooled.size, levels.size) - 1
    low = np.minimum(pooled[least_index], estimates)
    low = np.where(upper_end_without_hits >= levels, -np.inf, low)
    high = np.maximum(pooled[greatest_index], estimates)
    high = np.where(lower_end_of_all_hits <= levels, np.inf, high)
    return {
        f"{level:g}": SampleEstimate(*ends)
        for level, *ends in zip(
            QUANTILES, estimates.tolist(), low.tolist(), high.tolist(), strict=True
        )
    }


def _first_index(
    holds: Callable[[NDArray[np.int64]], NDArray[np.bool_]], count: int, levels: int
) -> NDArray[np.int64]:
    # For each level the first index at which `holds` is true, by bisection; `count` without one.
    low = np.zeros(levels, dtype=np.int64)
    high = np.full(levels, count, dtype=np.int64)
    while (low < high).any():
        middle = (low + high) // 2
        # Levels that have converged (low == high) do not change: their index may be `count`, which
        # has no value.
        is_true = holds(np.minimum(middle, count - 1)) | (low == high)
        low, high = np.where(is_true, low, middle + 1), np.where(is_true, middle, high)
    return low


def mean_of(values: Floats) -> SampleEstimate | None:
    """The mean of values, a row per scrambling; NaN does not count.

    None if a scrambling has no value.
    """
    if np.isnan(values).all(axis=1).any():
        return None
    return mean_estimate(np.nanmean(values, axis=1))


def sobol_of(scatter: Scatter, values: Floats) -> dict[str, SobolIndex]:
    """Sobol indices of the values of all members, by input (Saltelli 2010, Jansen 1999).

    Empty if a member has no value, or the variance comes from too few samples.
    """
    if np.isnan(values).any() or effective_samples(scatter.sample_values(values)) < LEAST_EFFECTIVE:
        return {}
    # Shape: points, scramblings, members of a point. These are samples A and B, then A with one
    # input from B.
    by_member = scatter.split_values(values)
    centred = by_member - by_member[:, :, : scatter.point_samples].mean()
    variances = (centred[:, :, : scatter.point_samples] ** 2).mean(axis=(0, 2))
    a, b, *mixed_values = np.moveaxis(centred, 2, 0)
    indices = {}
    for name, mixed in zip(scatter.axes, mixed_values, strict=True):
        first = (b * (mixed - a)).mean(axis=0)
        total = 0.5 * ((a - mixed) ** 2).mean(axis=0)
        indices[name] = SobolIndex(_ratio(first, variances), _ratio(total, variances))
    return indices


def effective_samples(values: Floats) -> float:
    """The number of samples that make up the variance: all if their deviations are equal.

    It is the squared sum of squared deviations over the sum of their squares. Zero if all values
    are equal; NaN does not count.
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
    # The ratio of two means over scramblings, with the interval of its linearised error.
    scale = float(denominators.mean())
    ratio = float(numerators.mean()) / scale
    # Its mean is 0, so that its interval is that of the error.
    deviation = mean_estimate((numerators - ratio * denominators) / scale)
    return SampleEstimate(ratio, ratio + deviation.low, ratio + deviation.high)


def excess_remark(printed: str) -> str:
    """``above 1`` or ``below 0`` for a printed Sobol index out of this range, else empty."""
    value = float(printed.partition(" ")[0])
    if value > 1.0:
        return "above 1"
    return "below 0" if value < 0.0 else ""


def mark_sampling_error(printed: str) -> str:
    """The printed value of a Sobol index, with the cause if it is above 1 or below 0."""
    remark = excess_remark(printed)
    return f"{printed} ({remark}: sampling error)" if remark else printed


def to_dicts(records: Mapping[str, Any]) -> dict[str, Any]:
    """Estimates or indices by name as data for JSON."""
    return {name: record.to_dict() for name, record in records.items()}


def rank_inputs(indices: Mapping[str, SobolIndex]) -> Sequence[tuple[str, SobolIndex]]:
    """Inputs and their indices, sorted by descending total index."""
    return sorted(indices.items(), key=lambda item: -item[1].total.value)
