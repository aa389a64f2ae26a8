"""An independent NumPy model of the paper, for checks of figures and printed reports.

The paper is *Nonlinear friction-induced vibration of a slider-belt system*. Its equations of motion
(Eq. 2) for a slider on a belt that is always faster, with P = −k2 y − k_nl y³ in contact, are

    m ẍ + c1 ẋ + kx x − (k3/2) y = μ P      with kx = k1 + k3/2,
    m ÿ + c2 ẏ + (k3/2) (y − x) = P − F.

The spring k3 stands at 45°, so half of its stiffness acts along x and y and couples them.
"""

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
    """x, y and P at rest, from the only real root of the cubic equation for y (Eq. 6).

    At rest kx x = k y + μ P with k = k3/2, so the vertical equation, P − F + k (x − y) = 0, becomes
    (1 + k μ/kx) P = F + (k − k²/kx) y. With P by y it contains y alone.
    """
    p = BASE | changes
    kx, coupling, mu = p["k1"] + p["k3"] / 2, p["k3"] / 2, p["mu"]
    # The factor of P.
    contact_factor = 1 + coupling * mu / kx
    # cubic y³ + linear y + F = 0.
    cubic = p["k_nl"] * contact_factor
    linear = p["k2"] * contact_factor + coupling - coupling**2 / kx
    roots = np.roots([cubic, 0.0, linear, p["F"]]) if cubic else np.array([-p["F"] / linear])
    y = float(roots[np.abs(roots.imag).argmin()].real)
    # The contact force P.
    force = -p["k2"] * y - p["k_nl"] * y**3
    return (coupling * y + mu * force) / kx, y, force


def eigenvalues(**changes: float) -> NDArray[np.complex128]:
    """The four eigenvalues at the equilibrium (Eq. 8), unsorted."""
    p = BASE | changes
    kx, coupling, m = p["k1"] + p["k3"] / 2, p["k3"] / 2, p["m"]
    _, y, _ = equilibrium(**changes)
    # Tangent stiffness of the contact, −dP/dy.
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
    """Times, and rows of x, vx, y, vy and P, by RK4 from the static start.

    The static start is at rest at the equilibrium for μ = 0: the belt starts to move at t = 0.
    """
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

    frictionless = {**changes, "mu": 0.0}
    x, y, _ = equilibrium(**frictionless)
    state, rows = np.array([x, 0.0, y, 0.0]), []
    count = math.ceil(t_end / step)
    for _ in range(count + 1):
        rows.append([*state.tolist(), force(float(state[2]))])
        rate_1 = state_rate(state)
        rate_2 = state_rate(state + step / 2 * rate_1)
        rate_3 = state_rate(state + step / 2 * rate_2)
        rate_4 = state_rate(state + step * rate_3)
        state = state + step / 6 * (rate_1 + 2 * rate_2 + 2 * rate_3 + rate_4)
    times: FloatArray = np.linspace(0.0, step * count, count + 1)
    return times, np.array(rows)
