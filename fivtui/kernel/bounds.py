"""Bounds of how far a polynomial leaves what is simpler: weights of its terms by their degree.

The sum of the weighed sizes of the coefficients bounds it on [0, 1].
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from .expansion import ROWS

DEGREES: Final = np.arange(ROWS, dtype=float)


def _chord(n: NDArray[np.float64]) -> NDArray[np.float64]:
    # max|θⁿ − θ|
    n = np.maximum(n, 1.0)
    return np.where(n > 1.0, (n - 1.0) * n ** (-n / np.maximum(n - 1.0, 1.0)), 0.0)


def _cubic(derivative: int) -> NDArray[np.float64]:
    # The greatest size of θⁿ − H(θ) on [0, 1], or of its derivative, where H is the cubic with the
    # values and slopes of θⁿ at 0 and 1; from a fine grid.
    n, part = DEGREES[:, None], np.linspace(0.0, 1.0, 4097)
    if derivative == 0:
        off = part**n - part * part * ((3.0 - 2.0 * part) + n * (part - 1.0))
    else:
        slope = n * part ** np.maximum(n - 1.0, 0.0)
        off = slope - 6.0 * part * (1.0 - part) - n * part * (3.0 * part - 2.0)
    return np.where(DEGREES > 3.0, 1.0001 * np.abs(off).max(axis=1), 0.0)


# How far the slope leaves its chord; the slope that of its chord; the second derivative the slope
# of the slope's chord.
SLOPE_CHORD: Final = DEGREES * _chord(DEGREES - 1.0)
SWAY: Final = np.maximum(DEGREES - 1.0, 0.0)
SLOPE_SWAY: Final = np.where(DEGREES > 2.0, DEGREES * (DEGREES - 2.0), 0.0)
# How far polynomial and slope leave those of the cubic with its values and slopes at both ends.
CUBIC: Final = _cubic(0)
SLOPE_CUBIC: Final = _cubic(1)
RECIPROCAL: Final = np.array([0.0, *(1.0 / DEGREES[1:])])
