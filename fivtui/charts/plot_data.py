"""Plot geometry: reduction to columns, limits, ticks. Imports no Textual."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_SHADE_CHARACTERS: Final = " ░▒▓█"
_FULL_SHARE: Final = 1.0 - 1e-12
_RELATIVE_MARGIN: Final = 0.05
# A signal with a smaller relative range is drawn as constant.
_MIN_RANGE: Final = 1e-9


def envelope(x: FloatArray, values: FloatArray, edges: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Reduce a signal of ascending `x` to at most four samples per column between `edges`.

    Selects the first, last, smallest and largest sample of every column, in order: a line through
    them covers the same dots as a line through all samples. Includes one sample beyond each end.
    """
    first = max(int(np.searchsorted(x, edges[0], side="left")) - 1, 0)
    stop = min(int(np.searchsorted(x, edges[-1], side="right")) + 1, x.size)
    if stop - first <= 4 * (edges.size - 1):
        return x[first:stop], values[first:stop]
    column_starts = np.searchsorted(x[first:stop], edges) + first
    bounds = np.unique(np.concatenate(([first], column_starts, [stop]))).tolist()
    selected: list[int] = []
    for begin, end in pairwise(bounds):
        column = values[begin:end]
        selected += sorted(
            {begin, begin + int(column.argmin()), begin + int(column.argmax()), end - 1}
        )
    return x[selected], values[selected]


def covered_shares(
    intervals: Sequence[tuple[float, float]], window: tuple[float, float], columns: int
) -> FloatArray:
    """Fraction of every column's time covered by intervals, shape (columns,)."""
    if not intervals:
        return np.zeros(columns)
    bounds = np.array(intervals)
    edges = np.linspace(*window, columns + 1)
    # Covered time up to each edge: complete intervals plus a part of the current interval.
    complete = np.searchsorted(bounds[:, 1], edges, side="right")
    length_sums = np.concatenate(([0.0], np.cumsum(bounds[:, 1] - bounds[:, 0])))
    starts = np.append(bounds[:, 0], np.inf)
    covered_time = length_sums[complete] + np.maximum(edges - starts[complete], 0.0)
    shares: FloatArray = np.clip(np.diff(covered_time) / np.diff(edges), 0.0, 1.0)
    return shares


def shade_text(shares: FloatArray) -> str:
    """One character per column, denser with its share: blank only at 0, full only at 1."""
    count = len(_SHADE_CHARACTERS) - 2
    partial = 1 + np.floor(np.minimum(shares, _FULL_SHARE) * count)
    levels = np.select([shares <= 0.0, shares > _FULL_SHARE], [0, count + 1], partial)
    return "".join(_SHADE_CHARACTERS[int(level)] for level in levels)


def axis_limits(low: float, high: float) -> tuple[float, float]:
    """Limits with a margin around a range; they are distinct even if the range is empty."""
    min_length = max(_MIN_RANGE * max(abs(low), abs(high)), 1e-300)
    if high - low < min_length:
        middle, half_length = 0.5 * (low + high), max(0.05 * abs(high), 0.5 * min_length)
        return (middle - half_length, middle + half_length) if high != 0.0 else (-1.0, 1.0)
    margin = _RELATIVE_MARGIN * (high - low)
    return low - margin, high + margin


def round_ticks(low: float, high: float, max_count: int) -> list[float]:
    """At most `max_count` evenly spaced ticks at 1, 2 or 5 times a power of ten."""
    decade = 10.0 ** math.floor(math.log10((high - low) / max_count))
    for factor in (1.0, 2.0, 5.0, 10.0, 20.0):
        spacing = factor * decade
        first_multiple, last_multiple = math.ceil(low / spacing), math.floor(high / spacing)
        if last_multiple - first_multiple < max_count:
            break
    return [multiple * spacing for multiple in range(first_multiple, last_multiple + 1)]


def tick_labels(ticks: Sequence[float]) -> list[str]:
    """Labels of evenly spaced ticks, with the fewest digits that distinguish them."""
    spacing = ticks[1] - ticks[0] if len(ticks) > 1 else 0.0
    exact_ticks = [0.0 if abs(tick) < 1e-6 * spacing else tick for tick in ticks]
    for digits in range(1, 8):
        labels = [f"{tick:.{digits}g}" for tick in exact_ticks]
        plain_labels = [f"{float(label):g}" for label in labels]
        if all(
            abs(float(label) - tick) <= 0.01 * spacing
            for label, tick in zip(labels, exact_ticks, strict=True)
        ):
            return plain_labels
    return [f"{tick:.7g}" for tick in exact_ticks]
