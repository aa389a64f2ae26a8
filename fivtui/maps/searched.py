"""Points of a map at which a global search was made, and what it says of the points around them."""

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
        The μ up to which the search confirms what continuation says.
    """

    place: tuple[int, ...]
    limit: float


def searched_places(shape: Sequence[int]) -> list[tuple[int, ...]]:
    """The corners and the centre of a grid."""
    corners = product(*(sorted({0, size - 1}) for size in shape))
    return list(dict.fromkeys([*corners, tuple(size // 2 for size in shape)]))


def limits(points: Sequence[SearchedPoint], shape: Sequence[int]) -> NDArray[np.float64]:
    """The limit at every point of a grid: that of the nearest point searched, in shares of axes."""
    if not points:
        return np.full(shape, PARAMETERS["mu"].upper)
    grids = np.meshgrid(*(np.linspace(0.0, 1.0, size) for size in shape), indexing="ij")
    nearest, at = np.full(shape, math.inf), np.full(shape, math.inf)
    for point in points:
        distance = np.sqrt(
            sum(
                (grid - index / max(size - 1, 1)) ** 2
                for grid, index, size in zip(grids, point.place, shape, strict=True)
            )
        )
        # Of points that are equally near the least limit counts.
        nearer = (distance < nearest) | ((distance == nearest) & (point.limit < at))
        nearest[nearer], at[nearer] = distance[nearer], point.limit
    return at
