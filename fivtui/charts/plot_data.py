"""Plot geometry: reduction to columns, limits, ticks. Imports no Textual."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_SHADES: Final = " ░▒▓█"
_NEARLY_ALL: Final = 1.0 - 1e-12
_PADDING: Final = 0.05
# A signal with a smaller relative range is drawn as constant.
_MIN_RANGE: Final = 1e-9


def envelope(x: FloatArray, values: FloatArray, edges: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Reduce a signal of ascending `x` to what the columns between `edges` can resolve.

    Selects the first, last, smallest and largest sample of every column, in order: a line through
    them covers the same dots as a line through all. One sample beyond each end is included.
    """
    first = max(int(np.searchsorted(x, edges[0], side="left")) - 1, 0)
    stop = min(int(np.searchsorted(x, edges[-1], side="right")) + 1, x.size)
    if stop - first <= 4 * (edges.size - 1):
        return x[first:stop], values[first:stop]
    inner = np.searchsorted(x[first:stop], edges) + first
    bounds = np.unique(np.concatenate(([first], inner, [stop]))).tolist()
    selected: list[int] = []
    for begin, end in pairwise(bounds):
        part = values[begin:end]
        selected += sorted({begin, begin + int(part.argmin()), begin + int(part.argmax()), end - 1})
    return x[selected], values[selected]


def share_of_time(
    intervals: Sequence[tuple[float, float]], window: tuple[float, float], columns: int
) -> FloatArray:
    """Fraction of every column's time covered by intervals, shape (columns,)."""
    if not intervals:
        return np.zeros(columns)
    bounds = np.array(intervals)
    edges = np.linspace(*window, columns + 1)
    # Covered time up to an edge: complete intervals plus a part of the current interval.
    ended = np.searchsorted(bounds[:, 1], edges, side="right")
    sums = np.concatenate(([0.0], np.cumsum(bounds[:, 1] - bounds[:, 0])))
    starts = np.append(bounds[:, 0], np.inf)
    until = sums[ended] + np.maximum(edges - starts[ended], 0.0)
    shares: FloatArray = np.clip(np.diff(until) / np.diff(edges), 0.0, 1.0)
    return shares


def shading(shares: FloatArray) -> str:
    """One character a column, denser with the share; blank and full only at 0 and 1."""
    inner = len(_SHADES) - 2
    partly = 1 + np.floor(np.minimum(shares, _NEARLY_ALL) * inner)
    levels = np.select([shares <= 0.0, shares > _NEARLY_ALL], [0, inner + 1], partly)
    return "".join(_SHADES[int(level)] for level in levels)


def axis_limits(low: float, high: float) -> tuple[float, float]:
    """Limits with a margin around a range; never an empty range."""
    least = max(_MIN_RANGE * max(abs(low), abs(high)), 1e-300)
    if high - low < least:
        middle, half = 0.5 * (low + high), max(0.05 * abs(high), 0.5 * least)
        return (middle - half, middle + half) if high != 0.0 else (-1.0, 1.0)
    room = _PADDING * (high - low)
    return low - room, high + room


def round_ticks(low: float, high: float, limit: int) -> list[float]:
    """At most `limit` evenly spaced ticks at 1, 2 or 5 times a power of ten."""
    decade = 10.0 ** math.floor(math.log10((high - low) / limit))
    for factor in (1.0, 2.0, 5.0, 10.0, 20.0):
        spacing = factor * decade
        first_number, last_number = math.ceil(low / spacing), math.floor(high / spacing)
        if last_number - first_number < limit:
            break
    return [number * spacing for number in range(first_number, last_number + 1)]


def tick_labels(ticks: Sequence[float]) -> list[str]:
    """Labels of evenly spaced ticks, with the fewest digits that distinguish them."""
    spacing = ticks[1] - ticks[0] if len(ticks) > 1 else 0.0
    clean = [0.0 if abs(tick) < 1e-6 * spacing else tick for tick in ticks]
    for digits in range(1, 8):
        labels = [f"{tick:.{digits}g}" for tick in clean]
        plain = [f"{float(label):g}" for label in labels]
        if all(
            abs(float(label) - tick) <= 0.01 * spacing
            for label, tick in zip(labels, clean, strict=True)
        ):
            return plain
    return [f"{tick:.7g}" for tick in clean]
