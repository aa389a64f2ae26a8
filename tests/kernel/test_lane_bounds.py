"""The bounds by which most steps of a batch are settled hold for every polynomial."""

import numpy as np
import pytest

from fivtui.kernel.bounds import CUBIC
from fivtui.kernel.lane_steps import SHARING

THETA = np.linspace(0.0, 1.0, 20_001)[1:]


def cubic_through_the_ends(c: np.ndarray) -> np.ndarray:
    n = np.arange(c.size)
    start, slope, final, last_slope = c[0], c[1], c.sum(), (n * c).sum()
    change = final - start
    square, cube = 3.0 * change - 2.0 * slope - last_slope, slope + last_slope - 2.0 * change
    return np.asarray(start + THETA * (slope + THETA * (square + THETA * cube)))


def leaving(c: np.ndarray) -> np.ndarray:
    values = np.polynomial.polynomial.polyval(THETA, c)
    return np.asarray(np.abs(values - cubic_through_the_ends(c)))


def bound(c: np.ndarray) -> float:
    return float((np.abs(c) * CUBIC[: c.size]).sum())


@pytest.mark.parametrize("degree", range(4, CUBIC.size))
def test_polynomials_stay_near_the_cubic_through_their_ends(degree: int) -> None:
    power = np.eye(degree + 1)[degree]
    # The bound of a single power is the least there is.
    assert 0.999 * bound(power) < leaving(power).max() <= bound(power)
    rng = np.random.default_rng(degree)
    for _ in range(10):
        c = rng.standard_normal(degree + 1)
        assert leaving(c).max() <= bound(c)


@pytest.mark.parametrize("degree", range(4, CUBIC.size))
def test_so_they_do_divided_by_their_argument(degree: int) -> None:
    rng = np.random.default_rng(degree)
    for c in (np.eye(degree + 1)[degree], *rng.standard_normal((10, degree + 1))):
        c[0] = 0.0
        assert (leaving(c) / THETA).max() <= SHARING * bound(c) * (1.0 + 1e-9)
