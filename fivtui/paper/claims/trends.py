"""Trends of a computed line: rising, falling, crossing."""

import numpy as np

from fivtui.paper import FloatArray


def rises(values: FloatArray) -> bool:
    """Whether each value is greater than the one before."""
    return bool(np.all(np.diff(values) > 0.0))


def falls(values: FloatArray) -> bool:
    """Whether each value is less than the one before."""
    return bool(np.all(np.diff(values) < 0.0))


def falls_then_rises(values: FloatArray) -> bool:
    """Whether values fall to a minimum before the last one, and rise from there."""
    place = int(np.argmin(values))
    inside = 0 < place < values.size - 1
    return inside and falls(values[: place + 1]) and rises(values[place:])


def crossing(along: FloatArray, excess: FloatArray) -> float | None:
    """Where values change sign from negative or zero to positive, interpolated.

    None if there is no such place, or more than one change of sign.
    """
    high = excess > 0.0
    if high[0] or np.count_nonzero(np.diff(high)) != 1:
        return None
    place = int(np.argmax(high)) - 1
    share = excess[place] / (excess[place] - excess[place + 1])
    return float(along[place] + share * (along[place + 1] - along[place]))
