"""Curves of limit cycles that touch y = 0 from the belt's side, over two parameters."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from fivtui.model import State
from fivtui.orbits.curves.arclength import OrbitCurve, OrbitOnCurve
from fivtui.orbits.curves.events import EventKind
from fivtui.orbits.curves.flow import FLOW_TOL, FloatArray, SliderBeltFlow
from fivtui.transient import START_SEEDS, Request, vary

from .plane import FIRST, SECOND, ParameterPlane

_UNKNOWNS = 7
# A cycle that is above y = 0 elsewhere by more than this part of its size does not touch first.
_ABOVE = 1e-9


class TouchCurve:
    """The equations of cycles whose highest point is at y = 0, where they start.

    They stay on the belt: separation plays no part.
    """

    def __init__(
        self,
        plane: ParameterPlane,
        length: float,
        period: float,
        *,
        go_on: Callable[[], bool] = lambda: True,
    ) -> None:
        speed = 2.0 * math.pi * length / period
        self.scales = np.array([length, speed, length, speed, period, *plane.units])
        self.bounds = plane.bounds((FIRST, SECOND))
        self.tests: Mapping[EventKind, Callable[[OrbitOnCurve], float]] = {
            EventKind.FOLD: lambda orbit: float(np.linalg.det(orbit.monodromy - np.eye(3)))
        }
        self._orbits = OrbitCurve(
            SliderBeltFlow(replace(plane.system, separation=False), plane.names),
            self.scales,
            go_on=go_on,
        )

    def begin(self, state: State, period: float, values: FloatArray) -> OrbitOnCurve | None:
        """The touching cycle near one with a state at its highest point."""
        x, vx, _, _ = state
        guess = np.array([x, vx, 0.0, 0.0, period, *values]) / self.scales
        return self.at(guess, FIRST)

    def at(self, guess: FloatArray, place: int) -> OrbitOnCurve | None:
        """The touching cycle near a guess, with its value of the unknown at `place`."""
        return self._solve(guess, np.eye(_UNKNOWNS)[place])

    def correct(
        self,
        guess: FloatArray,
        here: OrbitOnCurve,  # noqa: ARG002
        along: FloatArray,
        tangent: FloatArray | None = None,
    ) -> OrbitOnCurve | None:
        """The cycle near a guess in the plane with the normal `along`: see `Curve`."""
        return self._solve(guess, along, tangent)

    def size(self, point: OrbitOnCurve) -> float:
        """Amplitude of both displacements, scaled."""
        x_min, x_max, y_min, y_max = (point.extremes[:4] / self.scales[0]).tolist()
        return 0.5 * math.hypot(x_max - x_min, y_max - y_min)

    def features(self, point: OrbitOnCurve) -> FloatArray:
        """What does not depend on the phase."""
        return np.concatenate([point.unknowns[4:], point.extremes[:4] / self.scales[0]])

    def confirmed(self, kind: EventKind, point: OrbitOnCurve) -> bool:  # noqa: ARG002
        """Whether an event is what its test looked for."""
        return True

    def _solve(
        self, guess: FloatArray, along: FloatArray, tangent: FloatArray | None = None
    ) -> OrbitOnCurve | None:
        planes = np.zeros((3, _UNKNOWNS))
        planes[0, 2] = planes[1, 3] = 1.0
        planes[2] = along
        found = self._orbits.solve(guess, planes, tangent, turning=False)
        if found is None:
            return None
        low, high = found.extremes[2:4].tolist()
        return None if high > _ABOVE * abs(low) else found


def highest_point(plane: ParameterPlane, state: State, period: float, values: FloatArray) -> State:
    """The state at the highest point of a cycle on the belt."""
    system = replace(plane.at(values.tolist()), separation=False)
    run = Request(system, t_end=period, tol=FLOW_TOL, start=state)
    moment = float(vary(run, START_SEEDS[:1]).moments[3])
    if not 0.0 < moment < period:
        return state
    part = Request(system, t_end=moment, tol=FLOW_TOL, start=state)
    return vary(part, START_SEEDS[:1]).final
