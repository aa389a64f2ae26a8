"""Points of a map at which a global search checks safe μ.

Continuation, which gives safe μ at every point, may miss limit cycles. A search finds up to which μ
its results hold; this limit is applied to all points that are nearest to the searched one.
"""

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
    indices : tuple of int
        Indices of the point along the axes.
    confirmed_to : float
        The μ up to which the search confirms the safe μ that continuation gives.
    """

    indices: tuple[int, ...]
    confirmed_to: float


def searched_indices(shape: Sequence[int]) -> list[tuple[int, ...]]:
    """Indices of the corners and of the centre of a grid."""
    corners = product(*(sorted({0, size - 1}) for size in shape))
    return list(dict.fromkeys([*corners, tuple(size // 2 for size in shape)]))


def nearest_limits(points: Sequence[SearchedPoint], shape: Sequence[int]) -> NDArray[np.float64]:
    """For every point of a grid the μ up to which the nearest search confirms safe μ.

    Distances are those on a grid whose axes have the length 1. Without searches there is no limit:
    the result is the greatest μ.
    """
    if not points:
        return np.full(shape, PARAMETERS["mu"].upper)
    positions = np.meshgrid(*(np.linspace(0.0, 1.0, size) for size in shape), indexing="ij")
    least_distance, limits = np.full(shape, math.inf), np.full(shape, math.inf)
    for point in points:
        distance = np.sqrt(
            sum(
                (position - index / max(size - 1, 1)) ** 2
                for position, index, size in zip(positions, point.indices, shape, strict=True)
            )
        )
        # At equal distances the lowest limit counts.
        is_lower = (distance == least_distance) & (point.confirmed_to < limits)
        is_nearer = (distance < least_distance) | is_lower
        least_distance[is_nearer], limits[is_nearer] = distance[is_nearer], point.confirmed_to
    return limits
