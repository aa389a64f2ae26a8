"""An independent model of a slider on a belt of finite speed: mode by mode with `solve_ivp`.

A state z is (x, ẋ, y, ẏ). Modes are "separated", "stick", and slip "forward" or "backward".
"""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from fivtui import Parameters

FloatArray = NDArray[np.float64]
EventFunction = Callable[[float, FloatArray], float]
# Rows of time, s, and value by parameter.
Tables = Mapping[str, Sequence[tuple[float, float]]]


@dataclass(frozen=True)
class IndependentBelt:
    """A system whose preload, friction and belt speed may follow tables."""

    p: Parameters
    separation: bool = True
    tables: Tables = field(default_factory=dict)

    def at(self, name: str, t: float) -> float:
        """Value of a parameter at time `t`, from its table if it has one."""
        if name in self.tables:
            return float(np.interp(t, *np.array(self.tables[name]).T))
        return float(getattr(self.p, name) or 0.0)

    def belt_acceleration(self, t: float) -> float:
        """Acceleration of the belt, m/s²."""
        for (begin, begin_speed), (end, end_speed) in itertools.pairwise(
            self.tables.get("v_belt", [])
        ):
            if begin <= t < end:
                return (end_speed - begin_speed) / (end - begin)
        return 0.0

    def contact_spring_force(self, y: float) -> float:
        """Contact force P of a slider in contact."""
        return -self.p.k2 * y - self.p.k_nl * y**3

    def static_limit(self, t: float, y: float) -> float:
        """The limit of static friction."""
        static = self.at("mu", t) if self.p.mu_s is None else self.p.mu_s
        return static * self.contact_spring_force(y)

    def sticking_force(self, t: float, z: FloatArray) -> float:
        """Friction force while the slider sticks."""
        p, (x, _, y, _) = self.p, z
        drive = p.c1 * self.at("v_belt", t) + p.m * self.belt_acceleration(t)
        return float(drive + p.k1 * x + 0.5 * p.k3 * (x - y))

    def rate(self, mode: str, t: float, z: FloatArray) -> list[float]:
        """Derivative of (x, ẋ, y, ẏ)."""
        p, (x, vx, y, vy) = self.p, z.tolist()
        P = 0.0 if mode == "separated" else self.contact_spring_force(y)
        sign = {"forward": 1.0, "backward": -1.0}.get(mode, 0.0)
        mu = self.at("mu", t)
        if p.v_s is not None and p.mu_s is not None:
            # Minus the sliding speed, m/s. Trial steps of the solver may pass the stop, where the
            # sign changes: the limit then bounds the exponential.
            negative_speed = min(-sign * (self.at("v_belt", t) - vx), 0.01)
            mu += (p.mu_s - mu) * float(np.exp(negative_speed / p.v_s))
        spring = 0.5 * p.k3 * (x - y)
        ax = (sign * mu * P - p.c1 * vx - p.k1 * x - spring) / p.m
        ay = (P - self.at("F", t) - p.c2 * vy + spring) / p.m
        return [vx, self.belt_acceleration(t) if mode == "stick" else ax, vy, ay]

    def end_events(self, mode: str) -> dict[str, EventFunction]:
        """Event functions of a mode; the mode ends where one of them falls through zero."""
        if mode == "separated":
            return {"lands": lambda _, z: float(z[2])}
        ends: dict[str, EventFunction] = {}
        if self.separation:
            ends["lifts"] = lambda _, z: float(-z[2])
        if mode == "stick":
            ends["forward"] = lambda t, z: self.static_limit(t, z[2]) - self.sticking_force(t, z)
            ends["backward"] = lambda t, z: self.static_limit(t, z[2]) + self.sticking_force(t, z)
        else:
            sign = 1.0 if mode == "forward" else -1.0
            ends["stops"] = lambda t, z: float(sign * (self.at("v_belt", t) - z[1]))
        return ends

    def mode_at(self, t: float, z: FloatArray) -> str:
        """The mode of a state; at y = 0 the slider is in contact."""
        belt_speed = self.at("v_belt", t)
        _, vx, y, _ = z
        if self.separation and y > 0.0:
            return "separated"
        if vx != belt_speed:
            return "forward" if vx < belt_speed else "backward"
        holding_force = self.sticking_force(t, z)
        if abs(holding_force) <= self.static_limit(t, y):
            return "stick"
        return "forward" if holding_force > 0.0 else "backward"

    def next_mode(self, mode: str, end: str, t: float, z: FloatArray) -> str:
        """Mode after an event, or after a table row if `end` is empty; `z` is set to the switch."""
        if end in ("lands", "lifts"):
            z[2] = 0.0
        if end == "stops" or mode == "stick":
            z[1] = self.at("v_belt", t)
        if end in ("forward", "backward"):
            return end
        continues_flight = mode == "separated" and not end
        if end == "lifts" or continues_flight:
            return "separated"
        return self.mode_at(t, z)


def integrate(
    belt: IndependentBelt, start: FloatArray, t_end: float
) -> tuple[FloatArray, list[str]]:
    """Integrate to `t_end`; return the final state and the sequence of modes."""
    solve: Any = solve_ivp
    t, z, mode = 0.0, np.array(start), belt.mode_at(0.0, np.array(start))
    modes = [mode]
    row_times = {time for table in belt.tables.values() for time, _ in table if 0.0 < time < t_end}
    for segment_end in [*sorted(row_times), t_end]:
        while t < segment_end:
            ends = belt.end_events(mode)
            # `solve_ivp` reads attributes of the events, and a `partial` object can have some.
            events = [partial(event_function) for event_function in ends.values()]
            for event in events:
                event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
            run = solve(
                partial(belt.rate, mode),
                (t, segment_end),
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
                name = ""
                t = segment_end
            else:
                name = next(
                    event_name
                    for event_name, times in zip(ends, run.t_events, strict=True)
                    if times.size
                )
            mode = belt.next_mode(mode, name, t, z)
            if mode != modes[-1]:
                modes.append(mode)
    return z, modes
