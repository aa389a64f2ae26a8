"""Heights y of many equilibria in contact at once, on arrays."""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import rest_coefficients

from .quartic import cube_root_bound

# Iterations of Newton's method, which converges quadratically from a start of the right order.
_ITERATIONS: Final = 7


def resting_heights(p: Any, mu: NDArray[np.float64]) -> NDArray[np.float64]:
    """Heights y of equilibria in contact under friction coefficients, m, shape (n,).

    As `model.resting_height`, for arrays: Newton's method on α |y|³ + β |y| = |load|. NaN where
    this is not monotone, see `model.equilibrium`. The values of `p` are numbers or arrays. Call it
    under ``np.errstate(all="ignore")``.
    """
    alpha, beta, load = rest_coefficients(p, mu)
    load_size = np.abs(load)
    linear_root = load_size / beta
    # One of the two terms has at least half of the load: the lesser of the roots of each term alone
    # is at most twice the root. `cube_root_bound` needs a positive, finite number.
    size = np.fmin(linear_root, cube_root_bound(load_size / alpha))
    size = np.where((load_size > 0.0) & (alpha > 0.0), size, linear_root)
    for _ in range(_ITERATIONS):
        residual = alpha * size * size * size + beta * size - load_size
        size = size - residual / (3.0 * alpha * size * size + beta)
    is_monotone = (alpha >= 0.0) & (beta > 0.0)
    heights: NDArray[np.float64] = np.where(is_monotone, np.copysign(size, -load), np.nan)
    return heights
