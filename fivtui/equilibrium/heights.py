"""Heights of many equilibria at once, on arrays."""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import rest_coefficients

from .quartic import cube_root_bound

# Steps of Newton's method, which converges quadratically from a start of the right order.
_STEPS: Final = 7


def resting_heights(p: Any, mu: NDArray[np.float64]) -> NDArray[np.float64]:
    """Heights y of equilibria in contact under friction coefficients, m, shape (n,).

    As `model.resting_height`, for arrays: Newton's method on the cubic from a start at most 2.2
    times the root. The parameters `p` are numbers or arrays. Call it under
    ``np.errstate(all="ignore")``.
    """
    alpha, beta, downward = rest_coefficients(p, mu)
    force = np.abs(downward)
    linear = force / beta
    y = np.fmin(linear, cube_root_bound(force / alpha))
    y = np.where((force > 0.0) & (alpha > 0.0), y, linear)
    for _ in range(_STEPS):
        y = y - (alpha * y * y * y + beta * y - force) / (3.0 * alpha * y * y + beta)
    heights: NDArray[np.float64] = np.copysign(y, -downward)
    return heights
