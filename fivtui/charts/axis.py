"""An axis of a chart: limits, scale, ticks, zoom, and the parser of limits.

A position on an axis is a fraction of its length: 0 at the lower limit, 1 at the upper limit.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fivtui.model import InputError, parse_number

from .plot_data import align_limits, axis_limits, round_ticks, spaced_ticks, tick_labels

FloatArray = NDArray[np.float64]
# Values of the ticks of x and y.
AxisTicks = tuple[Sequence[float], Sequence[float]]

# Minimum length of an axis relative to its limits: closer limits would have equal tick labels.
_MIN_LENGTH: Final = 1e-9
_MAX_LIMIT: Final = 1e300
# Margin on each side relative to the range of the data, and where limits are aligned with rows.
_MARGIN: Final = 0.05
_ALIGNED_MARGIN: Final = 0.01
# Greatest factor by which an axis becomes longer so that ticks are whole rows apart.
_MAX_STRETCH: Final = 1.6
_MAX_TIGHT_STRETCH: Final = 1.08
# Number of decades of a logarithmic axis: smaller values are rounding errors.
_MAX_DECADES: Final = 20.0
# Number of decades from which ticks of a logarithmic axis are powers of ten, evenly spaced.
_MIN_DECADES: Final = 2.0
# Ticks of a logarithmic axis are these multiples of powers of ten.
_TICK_FACTORS: Final = (1.0, 2.0, 5.0)
_TICK_TOLERANCE: Final = 1e-12
LIMITS_FORMAT: Final = "LOW:HIGH, or empty to fit the data"


@dataclass(frozen=True, slots=True)
class Axis:
    """Limits and scale of one axis of a chart.

    Attributes
    ----------
    low, high : float
        Limits, ``low < high``; both positive on a logarithmic scale.
    log : bool
        Whether the scale is logarithmic.
    spacing : float
        Distance between ticks that are whole rows of characters apart, in decades on a logarithmic
        scale; 0 where they are not.
    """

    low: float
    high: float
    log: bool = False
    spacing: float = 0.0

    def positions(self, values: ArrayLike) -> FloatArray:
        """Positions of values: 0 at `low`, 1 at `high`; NaN for values ≤ 0 if logarithmic."""
        low, high = self._scaled_limits
        with np.errstate(invalid="ignore", divide="ignore"):
            scaled = self._apply_scale(np.asarray(values, dtype=float))
        positions: FloatArray = (scaled - low) / (high - low)
        return positions

    def value(self, position: float) -> float:
        """The value at a position; the inverse of `positions`."""
        low, high = self._scaled_limits
        scaled = low + position * (high - low)
        return 10.0**scaled if self.log else scaled

    def values(self, positions: FloatArray) -> FloatArray:
        """The values at positions."""
        low, high = self._scaled_limits
        scaled = low + positions * (high - low)
        return np.power(10.0, scaled) if self.log else scaled

    def _apply_scale(self, values: FloatArray) -> FloatArray:
        return np.log10(np.where(values > 0.0, values, np.nan)) if self.log else values

    @property
    def _scaled_limits(self) -> tuple[float, float]:
        return (math.log10(self.low), math.log10(self.high)) if self.log else (self.low, self.high)

    def transform(self, *, zoom: float = 1.0, centre: float = 0.5, shift: float = 0.0) -> "Axis":
        """The axis zoomed about the position `centre`, then shifted by a fraction of its length.

        Its new length is `zoom` times the old one. Returns the axis unchanged if the new limits
        would coincide or overflow.
        """
        low_position = centre * (1.0 - zoom) + shift
        try:
            low, high = self.value(low_position), self.value(low_position + zoom)
        except OverflowError:
            return self
        size = max(abs(low), abs(high))
        if not _MIN_LENGTH * size < high - low or size > _MAX_LIMIT or (self.log and low <= 0.0):
            return self
        return Axis(low, high, self.log)

    def ticks(self, max_count: int) -> tuple[list[float], list[str]]:
        """Values and labels of at most `max_count` ticks inside the limits, ascending."""
        if self.spacing:
            ticks = spaced_ticks(*self._scaled_limits, self.spacing)
            if self.log:
                return [10.0**tick for tick in ticks], [f"{10.0**tick:.4g}" for tick in ticks]
            return ticks, tick_labels(ticks)
        if self.log:
            ticks = _log_ticks(self.low, self.high, max_count)
            if len(ticks) > 1:
                return ticks, [f"{tick:.4g}" for tick in ticks]
        ticks = round_ticks(self.low, self.high, max_count)
        return ticks, tick_labels(ticks)


def _log_ticks(low: float, high: float, max_count: int) -> list[float]:
    # Ticks at 1, 2 and 5 times powers of ten, at powers of ten only, or at some of these.
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    low, high = low * (1.0 - _TICK_TOLERANCE), high * (1.0 + _TICK_TOLERANCE)
    for factors in (_TICK_FACTORS, (1.0,)):
        multiples = (factor * 10.0**decade for decade in decades for factor in factors)
        ticks = [tick for tick in multiples if low <= tick <= high]
        if len(ticks) <= max_count:
            return ticks
    return ticks[:: math.ceil(len(ticks) / max_count)]


def axis_for(
    values: Sequence[ArrayLike], *, log: bool = False, tight: bool = False, rows: int = 0
) -> Axis:
    """An axis that shows all finite values; on a logarithmic axis, all positive ones.

    `tight` puts the limits at the ends of the data; if `rows` is not 0, ticks are whole rows of
    that many apart. Without data: 0 to 1, logarithmic 0.1 to 1.
    """
    ranges = [
        value_range
        for array in values
        if (value_range := _finite_range(np.asarray(array, dtype=float), log=log)) is not None
    ]
    if not ranges:
        return Axis(0.1, 1.0, log=True) if log else Axis(0.0, 1.0)
    low, high = min(low for low, _ in ranges), max(high for _, high in ranges)
    spacing = 0.0
    if log:
        low = max(low, high * 10.0**-_MAX_DECADES)
        tight = tight and high > low * (1.0 + _MIN_LENGTH)
        low, high = math.log10(low), math.log10(high)
    else:
        tight = tight and high - low > _MIN_LENGTH * max(abs(low), abs(high))
    if not tight:
        low, high = axis_limits(low, high, _ALIGNED_MARGIN if rows else _MARGIN)
    if rows and (not log or high - low >= _MIN_DECADES):
        stretch = _MAX_TIGHT_STRETCH if tight else _MAX_STRETCH
        low, high, spacing = align_limits(low, high, rows, max_stretch=stretch, whole=log)
    return Axis(10.0**low, 10.0**high, True, spacing) if log else Axis(low, high, False, spacing)


def _finite_range(values: FloatArray, *, log: bool) -> tuple[float, float] | None:
    # Least and greatest finite value, if `log` of the positive values; None if there is none.
    usable = np.isfinite(values)
    if log:
        usable &= values > 0.0
    if not usable.any():
        return None
    finite = values if usable.all() else values[usable]
    return float(finite.min()), float(finite.max())


def parse_limits(name: str, text: str, *, log: bool = False) -> tuple[float, float] | None:
    """Limits from a text ``LOW:HIGH``; a comma or a blank may replace the colon.

    Returns None if the text is empty. Raises `InputError`, which begins with `name`, if the limits
    are invalid; `log` requires positive limits.
    """
    parts = [part for part in re.split(r"\s*[:,]\s*|\s+", text.strip()) if part]
    if not parts:
        return None
    if len(parts) != 2:
        raise InputError(f"{name} {text!r}: must be {LIMITS_FORMAT}")
    low, high = (parse_number(name, part, LIMITS_FORMAT) for part in parts)
    if not high - low > _MIN_LENGTH * max(abs(low), abs(high)) or max(-low, high) > _MAX_LIMIT:
        raise InputError(f"{name} {text!r}: LOW must be below HIGH")
    if log and low <= 0.0:
        raise InputError(f"{name} {text!r}: on a logarithmic axis LOW must be above 0")
    return low, high
