"""Starts of the global search: Sobol points over states and sizes of disturbances."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Parameters, equilibrium
from fivtui.orbits import length_scale, slowest_period

FloatArray = NDArray[np.float64]

_BITS: Final = 30
# Primitive polynomials (without first and last coefficient) and first direction numbers of the
# dimensions after the first, as tabulated by Joe and Kuo.
_JOE_KUO: Final = ((0, (1,)), (1, (1, 3)), (1, (1, 3, 1)), (2, (1, 1, 1)))
DIMENSIONS: Final = 1 + len(_JOE_KUO)
# Disturbances, in characteristic lengths.
_SMALLEST: Final = 0.1
_DECADES: Final = 3.0


def sobol(count: int) -> FloatArray:
    """The first points of the Sobol sequence in five dimensions, after the origin.

    Parameters
    ----------
    count : int
        Their number.

    Returns
    -------
    ndarray, shape (count, 5)
        Coordinates from 0 to 1.
    """
    directions = [[1 << (_BITS - 1 - bit) for bit in range(_BITS)]]
    for polynomial, first in _JOE_KUO:
        degree = len(first)
        line = [number << (_BITS - 1 - bit) for bit, number in enumerate(first)]
        for bit in range(degree, _BITS):
            value = line[bit - degree] ^ (line[bit - degree] >> degree)
            for back in range(1, degree):
                if polynomial >> (degree - 1 - back) & 1:
                    value ^= line[bit - back]
            line.append(value)
        directions.append(line)
    table = np.array(directions, dtype=np.int64)
    points = np.zeros((count + 1, DIMENSIONS), dtype=np.int64)
    for place in range(1, count + 1):
        lowest_zero = (~(place - 1) & place).bit_length() - 1
        points[place] = points[place - 1] ^ table[:, lowest_zero]
    return points[1:] / float(1 << _BITS)


def disturbed(p: Parameters, count: int, *, separation: bool) -> FloatArray:
    """Start states around the equilibrium, shape (count, 4), m and m/s.

    Displacements are up to a size between 0.1 and 100 characteristic lengths, velocities up to
    that size times the slowest angular frequency.
    """
    points = sobol(count)
    rest = equilibrium(p, separation=separation)
    speed = 2.0 * math.pi / slowest_period(p)
    size = length_scale(p, separation=separation) * _SMALLEST * 10.0 ** (_DECADES * points[:, 4])
    away: FloatArray = (2.0 * points[:, :4] - 1.0) * size[:, None]
    return away * [1.0, speed, 1.0, speed] + [rest.x, 0.0, rest.y, 0.0]
