"""Points of a map with a global search, and the limits that they set for the nearest points."""

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
        Its indices along the axes.
    limit : float
        The μ up to which the search confirms continuation.
    """

    place: tuple[int, ...]
    limit: float


def searched_indices(shape: Sequence[int]) -> list[tuple[int, ...]]:
    """The corners and the centre of a grid."""
    corners = product(*(sorted({0, size - 1}) for size in shape))
    return list(dict.fromkeys([*corners, tuple(size // 2 for size in shape)]))


def limits(points: Sequence[SearchedPoint], shape: Sequence[int]) -> NDArray[np.float64]:
    """The limit of the nearest searched point, for every point; axes are scaled to length one."""
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
        # Of equally near points the one with the lowest limit counts.
        nearer = (distance < nearest) | ((distance == nearest) & (point.limit < limit))
        nearest[nearer], limit[nearer] = distance[nearer], point.limit
    return limit
