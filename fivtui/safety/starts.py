"""Starts of the global search: Sobol points over states and sizes of disturbances."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats.qmc import Sobol

from fivtui.model import Parameters, equilibrium
from fivtui.orbits import length_scale, slowest_period

FloatArray = NDArray[np.float64]

_DIMENSIONS: Final = 5
# Disturbances, in characteristic lengths.
_SMALLEST: Final = 0.1
_DECADES: Final = 3.0


def disturbed(p: Parameters, count: int, *, separation: bool) -> FloatArray:
    """Start states around the equilibrium, shape (count, 4), m and m/s.

    Displacements are up to a size between 0.1 and 100 characteristic lengths, velocities up to
    that size times the slowest angular frequency.
    """
    # The first point of the sequence is its origin.
    points = Sobol(_DIMENSIONS, scramble=False).fast_forward(1).random(count)
    rest = equilibrium(p, separation=separation)
    speed = 2.0 * math.pi / slowest_period(p)
    size = length_scale(p, separation=separation) * _SMALLEST * 10.0 ** (_DECADES * points[:, 4])
    away: FloatArray = (2.0 * points[:, :4] - 1.0) * size[:, None]
    return away * [1.0, speed, 1.0, speed] + [rest.x, 0.0, rest.y, 0.0]
