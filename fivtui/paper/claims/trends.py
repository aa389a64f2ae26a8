"""How a computed line runs: what claims say of the lines of a figure."""

import numpy as np

from fivtui.paper import FloatArray


def rises(values: FloatArray) -> bool:
    """Whether values rise from each to the next."""
    return bool(np.all(np.diff(values) > 0.0))


def falls(values: FloatArray) -> bool:
    """Whether values fall from each to the next."""
    return bool(np.all(np.diff(values) < 0.0))


def falls_then_rises(values: FloatArray) -> bool:
    """Whether values fall to their least, which is not the last, and rise from there."""
    place = int(np.argmin(values))
    inside = 0 < place < values.size - 1
    return inside and falls(values[: place + 1]) and rises(values[place:])


def crossing(along: FloatArray, excess: FloatArray) -> float | None:
    """Where values that are negative or zero at first come to be positive, once.

    Parameters
    ----------
    along : ndarray, shape (n,)
        Ascending places.
    excess : ndarray, shape (n,)
        Values there.

    Returns
    -------
    float or None
        The place, interpolated; None if there is none, or more than one change of sign.
    """
    high = excess > 0.0
    if high[0] or np.count_nonzero(np.diff(high)) != 1:
        return None
    place = int(np.argmax(high)) - 1
    share = excess[place] / (excess[place] - excess[place + 1])
    return float(along[place] + share * (along[place + 1] - along[place]))
