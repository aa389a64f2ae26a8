"""Points of a map with a global search, whose results also hold for the points nearest to them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from fivtui.model import PARAMETERS


@dataclass(frozen=True, slots=True)
class SearchedPoint:
    """A point of a map at which a global search was made.

    Attributes
    ----------
    place : tuple of int
        Indices of the point along the axes.
    limit : float
        The μ up to which the search confirms continuation.
    """

    place: tuple[int, ...]
    limit: float


def searched_indices(shape: Sequence[int]) -> list[tuple[int, ...]]:
    """Indices of the corners and of the centre of a grid."""
    corners = product(*(sorted({0, size - 1}) for size in shape))
    return list(dict.fromkeys([*corners, tuple(size // 2 for size in shape)]))


def nearest_limits(points: Sequence[SearchedPoint], shape: Sequence[int]) -> NDArray[np.float64]:
    """For every point the limit of the nearest searched point, with axes of equal length."""
    if not points:
        return np.full(shape, PARAMETERS["mu"].upper)
    grids = np.meshgrid(*(np.linspace(0.0, 1.0, size) for size in shape), indexing="ij")
    nearest, limit = np.full(shape, math.inf), np.full(shape, math.inf)
    for point in points:
        distance = np.sqrt(
            sum(
                (grid - index / max(size - 1, 1)) ** 2
                for grid, index, size in zip(grids, point.place, shape, strict=True)
            )
        )
        # At equal distances the lowest limit counts.
        nearer = (distance < nearest) | ((distance == nearest) & (point.limit < limit))
        nearest[nearer], limit[nearer] = distance[nearer], point.limit
    return limit
