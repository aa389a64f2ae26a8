"""Numbers behind a plot: samples reduced to columns, limits of axes, ticks and their labels.

A column is a column of characters in the terminal, or of pixels in a figure.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Longest period, in columns, of an oscillation that is too dense for a line; odd.
_MAX_DENSE_PERIOD: Final = 5
# Characters for the covered share of a column, from 0 to 1.
_SHADE_CHARACTERS: Final = " ░▒▓█"
# Share above which a column counts as fully covered: the shares have rounding errors.
_FULL_SHARE: Final = 1.0 - 1e-12
# A signal with a smaller relative range is drawn as constant.
_MIN_RANGE: Final = 1e-9
# Least number of rows between ticks, usual number of ticks, and the cost of another number relative
# to that of a longer axis.
_MIN_ROWS_PER_TICK: Final = 2
_USUAL_TICKS: Final = 6.0
_TICKS_COST: Final = 0.2
# Maximum number of significant digits of a tick label.
_MAX_TICK_DIGITS: Final = 12
# Up to this number of digits, labels have no exponent.
_USUAL_DIGITS: Final = 6


def envelope(x: FloatArray, values: FloatArray, edges: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Reduce a signal of ascending `x` to at most four samples per column between `edges`.

    Selects the first, last, smallest and largest sample of every column, in order: a line through
    them looks like a line through all samples. Includes one sample beyond each end.
    """
    first = max(int(np.searchsorted(x, edges[0], side="left")) - 1, 0)
    stop = min(int(np.searchsorted(x, edges[-1], side="right")) + 1, x.size)
    if stop - first <= 4 * (edges.size - 1):
        return x[first:stop], values[first:stop]
    column_starts = np.searchsorted(x[first:stop], edges) + first
    column_bounds = np.unique(np.concatenate(([first], column_starts, [stop]))).tolist()
    selected: list[int] = []
    for begin, end in pairwise(column_bounds):
        column = values[begin:end]
        selected += sorted(
            {begin, begin + int(column.argmin()), begin + int(column.argmax()), end - 1}
        )
    return x[selected], values[selected]


def dense_band(
    x: FloatArray, values: FloatArray, edges: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Lower and upper edge of a signal in the columns between `edges`, shape (columns,).

    They are NaN where a line shows the signal well: where a period is longer than
    `_MAX_DENSE_PERIOD` columns, or samples are few.
    """
    starts = np.searchsorted(x, edges)
    # Includes one sample beyond the last edge.
    window = values[starts[0] : starts[-1] + 1]
    if window.size <= edges.size:
        return np.full(edges.size - 1, np.nan), np.full(edges.size - 1, np.nan)
    rises, falls = values[1:] > values[:-1], values[1:] < values[:-1]
    maxima, minima = x[1:-1][rises[:-1] & ~rises[1:]], x[1:-1][falls[:-1] & ~falls[1:]]
    is_dense = _is_dense(maxima, edges) & _is_dense(minima, edges)
    crossings = np.count_nonzero(np.diff(window > window.mean()))
    # A period has two crossings.
    width = 3 if crossings >= edges.size else _MAX_DENSE_PERIOD
    starts = np.minimum(starts[:-1] - starts[0], window.size - 1)
    high = _joined_peaks(np.maximum.reduceat(window, starts), width)
    low = -_joined_peaks(-np.minimum.reduceat(window, starts), width)
    return np.where(is_dense, low, np.nan), np.where(is_dense, high, np.nan)


def _is_dense(extrema: FloatArray, edges: FloatArray) -> NDArray[np.bool_]:
    # Whether the extrema around the middle of each column are close to each other.
    centres, widths = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges)
    if extrema.size < 2:
        return np.zeros(centres.size, dtype=bool)
    after = np.clip(np.searchsorted(extrema, centres), 1, extrema.size - 1)
    start, end = extrema[after - 1], extrema[after]
    # Beyond the first and last extremum, their distance.
    gaps = np.maximum(end - start, np.maximum(start - centres, centres - end))
    return gaps <= _MAX_DENSE_PERIOD * widths


def _joined_peaks(values: FloatArray, width: int) -> FloatArray:
    # Lines over the valleys that are narrower than `width`, which is odd.
    # The minimum of the maxima of windows fills these valleys and leaves the rest.
    closed = values
    for function, padding in ((np.max, -np.inf), (np.min, np.inf)):
        padded = np.pad(closed, width // 2, constant_values=padding)
        closed = function(sliding_window_view(padded, width), axis=1)
    peaks = np.flatnonzero(values == closed)
    if not peaks.size:
        return values
    joined: FloatArray = np.interp(np.arange(values.size), peaks, values[peaks])
    return joined


def covered_shares(
    intervals: Sequence[tuple[float, float]], window: tuple[float, float], columns: int
) -> FloatArray:
    """Fraction of every column's time covered by intervals, shape (columns,).

    The columns divide the window evenly; intervals ascend and are disjoint.
    """
    if not intervals:
        return np.zeros(columns)
    starts, ends = np.array(intervals).T
    edges = np.linspace(*window, columns + 1)
    # Covered time up to each edge: complete intervals plus a part of the current interval. After
    # the end of all intervals there is none: an infinite start makes its part 0.
    complete_count = np.searchsorted(ends, edges, side="right")
    length_sums = np.concatenate(([0.0], np.cumsum(ends - starts)))
    current_start = np.append(starts, np.inf)[complete_count]
    covered_time = length_sums[complete_count] + np.maximum(edges - current_start, 0.0)
    shares: FloatArray = np.clip(np.diff(covered_time) / np.diff(edges), 0.0, 1.0)
    return shares


def shade_text(shares: FloatArray) -> str:
    """One character per column, denser with its share: blank only at 0, full only at 1."""
    full_index = len(_SHADE_CHARACTERS) - 1
    # The characters between blank and full divide the shares between 0 and 1 evenly.
    partial_indices = 1 + np.floor(shares * (full_index - 1))
    indices = np.select([shares <= 0.0, shares > _FULL_SHARE], [0, full_index], partial_indices)
    return "".join(_SHADE_CHARACTERS[int(index)] for index in indices)


def axis_limits(low: float, high: float, relative_margin: float) -> tuple[float, float]:
    """Limits with a margin around a range; they are distinct even if the range is empty."""
    min_length = max(_MIN_RANGE * max(abs(low), abs(high)), 1e-300)
    if high - low < min_length:
        if high == 0.0:
            return -1.0, 1.0
        # A constant signal is drawn in the middle, with 5 % of its value on each side.
        middle, half_length = 0.5 * (low + high), max(0.05 * abs(high), 0.5 * min_length)
        return middle - half_length, middle + half_length
    margin = relative_margin * (high - low)
    return low - margin, high + margin


def align_limits(
    low: float, high: float, rows: int, *, max_stretch: float, whole: bool
) -> tuple[float, float, float]:
    """Limits around a range, and the spacing of ticks, so that ticks are whole rows apart.

    The spacing is a round number, if `whole` an integer, and ticks are in the middle of rows. Of
    these limits, choose those that fit the range best with a usual number of ticks. If all stretch
    the axis by more than a factor of `max_stretch`, return the range with a spacing of 0.
    """
    best, best_cost = (low, high, 0.0), math.inf
    min_height = (high - low) / rows
    usual_rows = max(_MIN_ROWS_PER_TICK, rows / _USUAL_TICKS)
    for rows_per_tick in range(_MIN_ROWS_PER_TICK, rows // 2 + 1):
        decade = 10.0 ** math.floor(math.log10(min_height * rows_per_tick))
        for spacing in (factor * decade for factor in (1.0, 2.0, 2.5, 5.0, 10.0, 20.0)):
            height = spacing / rows_per_tick
            bottom = math.floor(low / height + 0.5)
            unused_rows = math.floor(bottom - 0.5 + rows - high / height)
            stretch = height / min_height
            if unused_rows < 0 or stretch > max_stretch or (whole and spacing % 1.0):
                continue
            cost = stretch + _TICKS_COST * abs(math.log(rows_per_tick / usual_rows))
            if cost < best_cost:
                aligned_low = (bottom - unused_rows // 2 - 0.5) * height
                best, best_cost = (aligned_low, aligned_low + rows * height, spacing), cost
    return best


def round_ticks(low: float, high: float, max_count: int) -> list[float]:
    """At most `max_count` evenly spaced ticks at 1, 2 or 5 times a power of ten."""
    decade = 10.0 ** math.floor(math.log10((high - low) / max_count))
    # A factor of 10 gives few enough ticks, except by rounding; then 20 does.
    for factor in (1.0, 2.0, 5.0, 10.0, 20.0):
        spacing = factor * decade
        ticks = spaced_ticks(low, high, spacing)
        if len(ticks) <= max_count:
            break
    return ticks


def spaced_ticks(low: float, high: float, spacing: float) -> list[float]:
    """The multiples of `spacing` within limits."""
    multiples = range(math.ceil(low / spacing), math.floor(high / spacing) + 1)
    return [multiple * spacing for multiple in multiples]


def tick_labels(ticks: Sequence[float]) -> list[str]:
    """Labels of evenly spaced ticks, with the fewest digits that distinguish them."""
    spacing = ticks[1] - ticks[0] if len(ticks) > 1 else 0.0
    # A tick at zero may have a rounding error.
    ticks = [0.0 if abs(tick) < 1e-6 * spacing else tick for tick in ticks]
    for digits in range(1, _MAX_TICK_DIGITS + 1):
        rounded_ticks = [float(f"{tick:.{digits}g}") for tick in ticks]
        if all(
            abs(rounded - tick) <= 0.01 * spacing
            for rounded, tick in zip(rounded_ticks, ticks, strict=True)
        ):
            shown_digits = max(digits, _USUAL_DIGITS)
            return [f"{rounded:.{shown_digits}g}" for rounded in rounded_ticks]
    return [f"{tick:.{_MAX_TICK_DIGITS}g}" for tick in ticks]
