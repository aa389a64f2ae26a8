"""An independent NumPy model of the paper, for checks of figures and printed reports."""

import functools
import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

BASE: Final = {
    "m": 5.0,
    "k1": 100.0,
    "k2": 50.0,
    "k3": 60.0,
    "c1": 0.32,
    "c2": 0.32,
    "F": 80.0,
    "k_nl": 100.0,
    "mu": 0.7,
}
FloatArray = NDArray[np.float64]


def equilibrium(**changes: float) -> tuple[float, float, float]:
    """x, y and P at rest, from the only real root of the cubic equation for y (Eq. 6)."""
    p = BASE | changes
    a, h, mu = p["k1"] + p["k3"] / 2, p["k3"] / 2, p["mu"]
    cubic = p["k_nl"] * (1 + h * mu / a)
    linear = p["k2"] + h - h * h / a + h * mu * p["k2"] / a
    roots = np.roots([cubic, 0.0, linear, p["F"]]) if cubic else np.array([-p["F"] / linear])
    y = float(roots[np.abs(roots.imag).argmin()].real)
    force = -p["k2"] * y - p["k_nl"] * y**3
    return (h * y + mu * force) / a, y, force


def eigenvalues(**changes: float) -> NDArray[np.complex128]:
    """The four eigenvalues at the equilibrium (Eq. 8), unsorted."""
    p = BASE | changes
    a, h, m = p["k1"] + p["k3"] / 2, p["k3"] / 2, p["m"]
    _, y, _ = equilibrium(**changes)
    kt = p["k2"] + 3 * p["k_nl"] * y * y
    matrix = [
        [0, 1, 0, 0],
        [-a / m, -p["c1"] / m, (h - p["mu"] * kt) / m, 0],
        [0, 0, 0, 1],
        [h / m, 0, -(kt + h) / m, -p["c2"] / m],
    ]
    return np.linalg.eigvals(np.array(matrix, dtype=float)).astype(np.complex128)


def growth_rate(**changes: float) -> float:
    """The largest real part of the eigenvalues, 1/s."""
    return float(eigenvalues(**changes).real.max())


@functools.cache
def critical_mu(**changes: float) -> float:
    """The friction at which the growth rate is zero, by bisection of eigenvalues."""
    low, high = 0.0, 4.0
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (
            (low, middle) if growth_rate(**{**changes, "mu": middle}) > 0 else (middle, high)
        )
    return high


@functools.cache
def motion(
    t_end: float, *, separation: bool, step: float = 0.002, **changes: float
) -> tuple[FloatArray, FloatArray]:
    """Times, and rows of x, vx, y, vy and P, by RK4 from the static start."""
    p = BASE | changes
    a, h, m = p["k1"] + p["k3"] / 2, p["k3"] / 2, p["m"]

    def force(y: float) -> float:
        return 0.0 if separation and y > 0 else -p["k2"] * y - p["k_nl"] * y**3

    def slope(s: FloatArray) -> FloatArray:
        x, vx, y, vy = s.tolist()
        normal = force(y)
        across = (p["mu"] * normal - p["c1"] * vx - a * x + h * y) / m
        along = (normal - p["F"] - p["c2"] * vy - h * y + h * x) / m
        return np.array([vx, across, vy, along])

    x, y, _ = equilibrium(**{**changes, "mu": 0.0})
    state, rows = np.array([x, 0.0, y, 0.0]), []
    count = math.ceil(t_end / step)
    for _ in range(count + 1):
        rows.append([*state.tolist(), force(float(state[2]))])
        k1 = slope(state)
        k2 = slope(state + step / 2 * k1)
        k3 = slope(state + step / 2 * k2)
        k4 = slope(state + step * k3)
        state = state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    times: FloatArray = np.linspace(0.0, step * count, count + 1)
    return times, np.array(rows)
