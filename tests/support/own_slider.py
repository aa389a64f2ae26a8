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
    kx, coupling, mu = p["k1"] + p["k3"] / 2, p["k3"] / 2, p["mu"]
    cubic = p["k_nl"] * (1 + coupling * mu / kx)
    linear = p["k2"] + coupling - coupling * coupling / kx + coupling * mu * p["k2"] / kx
    roots = np.roots([cubic, 0.0, linear, p["F"]]) if cubic else np.array([-p["F"] / linear])
    y = float(roots[np.abs(roots.imag).argmin()].real)
    force = -p["k2"] * y - p["k_nl"] * y**3
    return (coupling * y + mu * force) / kx, y, force


def eigenvalues(**changes: float) -> NDArray[np.complex128]:
    """The four eigenvalues at the equilibrium (Eq. 8), unsorted."""
    p = BASE | changes
    kx, coupling, m = p["k1"] + p["k3"] / 2, p["k3"] / 2, p["m"]
    _, y, _ = equilibrium(**changes)
    kt = p["k2"] + 3 * p["k_nl"] * y * y
    matrix = [
        [0, 1, 0, 0],
        [-kx / m, -p["c1"] / m, (coupling - p["mu"] * kt) / m, 0],
        [0, 0, 0, 1],
        [coupling / m, 0, -(kt + coupling) / m, -p["c2"] / m],
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
    kx, coupling, m = p["k1"] + p["k3"] / 2, p["k3"] / 2, p["m"]

    def force(y: float) -> float:
        return 0.0 if separation and y > 0 else -p["k2"] * y - p["k_nl"] * y**3

    def state_rate(s: FloatArray) -> FloatArray:
        x, vx, y, vy = s.tolist()
        normal = force(y)
        x_acceleration = (p["mu"] * normal - p["c1"] * vx - kx * x + coupling * y) / m
        y_acceleration = (normal - p["F"] - p["c2"] * vy - coupling * y + coupling * x) / m
        return np.array([vx, x_acceleration, vy, y_acceleration])

    x, y, _ = equilibrium(**{**changes, "mu": 0.0})
    state, rows = np.array([x, 0.0, y, 0.0]), []
    count = math.ceil(t_end / step)
    for _ in range(count + 1):
        rows.append([*state.tolist(), force(float(state[2]))])
        k1 = state_rate(state)
        k2 = state_rate(state + step / 2 * k1)
        k3 = state_rate(state + step / 2 * k2)
        k4 = state_rate(state + step * k3)
        state = state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    times: FloatArray = np.linspace(0.0, step * count, count + 1)
    return times, np.array(rows)
