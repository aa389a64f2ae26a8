"""A slider on a belt of finite speed, written anew: one mode after the other by `solve_ivp`."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

FloatArray = NDArray[np.float64]
Function = Callable[[float, FloatArray], float]


@dataclass(frozen=True)
class OwnBelt:
    """The parameters, SI units, as numbers; `fall` is v_s, None for constant friction."""

    m: float
    k1: float
    k2: float
    k3: float
    c1: float
    c2: float
    F: float
    k_nl: float
    mu: float
    static: float
    fall: float | None
    speed: float
    separation: bool

    def spring(self, y: float) -> float:
        """Contact force P as if in contact."""
        return -self.k2 * y - self.k_nl * y**3

    def hold(self, x: float, y: float) -> float:
        """What the belt exerts while it holds."""
        return self.c1 * self.speed + self.k1 * x + 0.5 * self.k3 * (x - y)

    def rate(self, mode: str, z: FloatArray) -> list[float]:
        """The derivative of (x, ẋ, y, ẏ)."""
        x, vx, y, vy = z.tolist()
        P = 0.0 if mode == "separated" else self.spring(y)
        sign = {"forward": 1.0, "backward": -1.0}.get(mode, 0.0)
        past = min(-sign * (self.speed - vx), 0.01)
        more = np.exp(past / self.fall) if self.fall is not None else 0.0
        friction = sign * (self.mu + (self.static - self.mu) * more) * P
        spring = 0.5 * self.k3 * (x - y)
        ax = (friction - self.c1 * vx - self.k1 * x - spring) / self.m
        ay = (P - self.F - self.c2 * vy + spring) / self.m
        return [vx, 0.0 if mode == "stick" else float(ax), vy, ay]

    def ends(self, mode: str) -> dict[str, Function]:
        """What falls through zero where a mode ends."""
        found: dict[str, Function] = {}
        if mode == "separated":
            return {"lands": lambda _, z: float(z[2])}
        if self.separation:
            found["lifts"] = lambda _, z: float(-z[2])
        if mode == "stick":
            found["forward"] = lambda _, z: float(
                self.static * self.spring(z[2]) - self.hold(z[0], z[2])
            )
            found["backward"] = lambda _, z: float(
                self.static * self.spring(z[2]) + self.hold(z[0], z[2])
            )
        elif mode == "forward":
            found["stops"] = lambda _, z: float(self.speed - z[1])
        else:
            found["stops"] = lambda _, z: float(z[1] - self.speed)
        return found

    def begin(self, z: FloatArray) -> str:
        """The mode of a state; at y = 0 the slider is landing."""
        x, vx, y, _ = z.tolist()
        if self.separation and y > 0.0:
            return "separated"
        if vx != self.speed:
            return "forward" if vx < self.speed else "backward"
        held = self.hold(x, y)
        if abs(held) <= self.static * self.spring(y):
            return "stick"
        return "forward" if held > 0.0 else "backward"


def integrate(belt: OwnBelt, start: FloatArray, t_end: float) -> tuple[FloatArray, list[str]]:
    """The state at the end, and the modes that follow each other."""
    solve: Any = solve_ivp
    t, z, mode = 0.0, np.array(start), belt.begin(start)
    modes = [mode]
    while True:
        ends = belt.ends(mode)
        events: list[Any] = []
        for function in ends.values():

            def event(time: float, state: FloatArray, function: Function = function) -> float:
                return function(time, state)

            event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
            events.append(event)
        run = solve(
            lambda _, state, mode=mode: belt.rate(mode, state),
            (t, t_end),
            z,
            method="DOP853",
            rtol=3e-13,
            atol=1e-13,
            events=events,
            max_step=0.05,
        )
        assert run.success
        z, t = run.y[:, -1].copy(), float(run.t[-1])
        if run.status == 0:
            return z, modes
        name = next(n for n, times in zip(ends, run.t_events, strict=True) if times.size)
        if name in ("lands", "lifts"):
            z[2] = 0.0
        if name == "stops" or mode == "stick":
            z[1] = belt.speed
        if mode != "stick" or name == "lifts":
            mode = "separated" if name == "lifts" else belt.begin(z)
        else:
            mode = name
        modes.append(mode)
