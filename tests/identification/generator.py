"""Measured signals from an integrator of its own: SciPy's DOP853 with events at y = 0."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

FloatArray = np.ndarray
BASE = {"m": 5.0, "k1": 100.0, "k2": 50.0, "k3": 60.0, "c1": 0.32, "c2": 0.32, "F": 80.0,
        "k_nl": 100.0, "mu": 0.7}  # fmt: skip


def integrate(values: Mapping[str, float], t: FloatArray) -> FloatArray:
    """Rows x, ẋ, y, ẏ at times t of the run from rest without friction, piecewise by mode."""
    p = BASE | dict(values)
    a, h = p["k1"] + 0.5 * p["k3"], 0.5 * p["k3"]

    def right_side(contact: bool) -> Any:
        def rates(_t: float, z: FloatArray) -> list[float]:
            x, vx, y, vy = z
            force = -p["k2"] * y - p["k_nl"] * y**3 if contact else 0.0
            ax = (p["mu"] * force - p["c1"] * vx - a * x + h * y) / p["m"]
            ay = (force - p["F"] - p["c2"] * vy - h * y + h * x) / p["m"]
            return [vx, ax, vy, ay]

        return rates

    def balance(y: float) -> float:
        return h * y - h * h * y / a + p["k2"] * y + p["k_nl"] * y**3 + p["F"]

    y = brentq(balance, -1e3, 1e3, xtol=1e-15)
    state, begin, contact = np.array([h * y / a, 0.0, y, 0.0]), 0.0, True
    samples = np.empty((4, t.size))
    while True:

        def crossing(_t: float, z: FloatArray) -> float:
            return float(z[2])

        crossing.terminal = True  # type: ignore[attr-defined]
        crossing.direction = 1.0 if contact else -1.0  # type: ignore[attr-defined]
        part = solve_ivp(
            right_side(contact), (begin, t[-1]), state, method="DOP853", rtol=1e-12, atol=1e-13,
            events=crossing, dense_output=True,
        )  # fmt: skip
        inside = (t >= begin) & (t <= part.t[-1])
        solution: Any = part.sol
        samples[:, inside] = solution(t[inside])
        if part.status != 1:
            return samples
        state, begin, contact = part.y[:, -1], float(part.t[-1]), not contact
        state[2] = 0.0


def write_record(path: Path, t: FloatArray, **signals: FloatArray) -> Path:
    """A file with the columns t and those of the signals."""
    columns = np.column_stack([t, *signals.values()])
    np.savetxt(
        path, columns, delimiter=",", header=",".join(["t", *signals]), comments="", fmt="%.17g"
    )
    return path
