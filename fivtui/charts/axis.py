"""An axis of a chart: limits, scale, ticks, zoom, typed limits. Imports no Textual."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fivtui.model import InputError, parse_number

from .plot_data import axis_limits, round_ticks, tick_labels

FloatArray = NDArray[np.float64]

# Minimum relative length of an axis: closer limits would have equal tick labels.
_MIN_LENGTH: Final = 1e-9
_WIDEST: Final = 1e300
_DECADES: Final = 20.0
_FACTORS: Final = (1.0, 2.0, 5.0)
_FORM: Final = "LOW:HIGH, or empty to fit the data"


@dataclass(frozen=True, slots=True)
class Axis:
    """Limits and scale of one axis of a chart.

    Attributes
    ----------
    low, high : float
        Limits, ``low < high``; both positive on a logarithmic scale.
    log : bool
        Whether the scale is logarithmic.
    """

    low: float
    high: float
    log: bool = False

    def place(self, values: ArrayLike) -> FloatArray:
        """Positions along the axis: 0 at `low`, 1 at `high`; NaN at or below 0 if logarithmic."""
        low, high = self._ends
        with np.errstate(invalid="ignore", divide="ignore"):
            scaled = self._scaled(np.asarray(values, dtype=float))
        positions: FloatArray = (scaled - low) / (high - low)
        return positions

    def value(self, position: float) -> float:
        """The value at a position; the inverse of `place`."""
        low, high = self._ends
        scaled = low + position * (high - low)
        return 10.0**scaled if self.log else scaled

    def _scaled(self, values: FloatArray) -> FloatArray:
        return np.log10(np.where(values > 0.0, values, np.nan)) if self.log else values

    @property
    def _ends(self) -> tuple[float, float]:
        return (math.log10(self.low), math.log10(self.high)) if self.log else (self.low, self.high)

    def moved(self, *, zoom: float = 1.0, about: float = 0.5, shift: float = 0.0) -> Self:
        """The axis zoomed about a position, then shifted by a fraction of its length.

        Returns the axis unchanged if the new limits would coincide or overflow.
        """
        first = about * (1.0 - zoom) + shift
        try:
            low, high = self.value(first), self.value(first + zoom)
        except OverflowError:
            return self
        size = max(abs(low), abs(high))
        if not _MIN_LENGTH * size < high - low or size > _WIDEST or (self.log and low <= 0.0):
            return self
        return replace(self, low=low, high=high)

    def ticks(self, limit: int) -> tuple[list[float], list[str]]:
        """At most `limit` ticks inside the limits, ascending, and their labels."""
        if self.log:
            ticks = _log_ticks(self.low, self.high, limit)
            if len(ticks) > 1:
                return ticks, [f"{tick:.4g}" for tick in ticks]
        ticks = round_ticks(self.low, self.high, limit)
        return ticks, tick_labels(ticks)


def _log_ticks(low: float, high: float, limit: int) -> list[float]:
    first_decade, last_decade = math.floor(math.log10(low)), math.ceil(math.log10(high))
    decades = range(first_decade, last_decade + 1)
    slack = 1e-12
    for factors in (_FACTORS, (1.0,)):
        ticks = [factor * 10.0**decade for decade in decades for factor in factors]
        ticks = [t for t in ticks if low * (1.0 - slack) <= t <= high * (1.0 + slack)]
        if len(ticks) <= limit:
            return ticks
    return ticks[:: math.ceil(len(ticks) / limit)]


def axis_for(values: Sequence[ArrayLike], *, log: bool = False, tight: bool = False) -> Axis:
    """An axis that shows all finite data (and, if logarithmic, positive data).

    `tight` puts the limits at the ends of the data. Without data it runs from 0 (log: 0.1) to 1.
    """
    ranges = [_range(np.asarray(part, dtype=float), log=log) for part in values]
    spans = [span for span in ranges if span is not None]
    if not spans:
        return Axis(0.1, 1.0, log=True) if log else Axis(0.0, 1.0)
    low, high = min(span[0] for span in spans), max(span[1] for span in spans)
    if log:
        # Smaller values are rounding noise.
        low = max(low, high * 10.0**-_DECADES)
        if tight and high > low * (1.0 + _MIN_LENGTH):
            return Axis(low, high, log=True)
        ends = axis_limits(math.log10(low), math.log10(high))
        return Axis(10.0 ** ends[0], 10.0 ** ends[1], log=True)
    if tight and high - low > _MIN_LENGTH * max(abs(low), abs(high)):
        return Axis(low, high)
    return Axis(*axis_limits(low, high))


def _range(values: FloatArray, *, log: bool) -> tuple[float, float] | None:
    usable = np.isfinite(values)
    if log:
        usable &= values > 0.0
    if not usable.any():
        return None
    finite = values if usable.all() else values[usable]
    return float(finite.min()), float(finite.max())


def parse_limits(name: str, text: str, *, log: bool = False) -> tuple[float, float] | None:
    """Parse ``LOW:HIGH``, also with a comma or blank between them.

    Returns None if empty; raises `InputError` if the limits are invalid.
    """
    parts = [part for part in re.split(r"\s*[:,]\s*|\s+", text.strip()) if part]
    if not parts:
        return None
    if len(parts) != 2:
        raise InputError(f"{name} {text!r}: must be {_FORM}")
    low, high = (parse_number(name, part, _FORM) for part in parts)
    if not high - low > _MIN_LENGTH * max(abs(low), abs(high)) or max(-low, high) > _WIDEST:
        raise InputError(f"{name} {text!r}: LOW must be below HIGH")
    if log and low <= 0.0:
        raise InputError(f"{name} {text!r}: on a logarithmic axis LOW must be above 0")
    return low, high
