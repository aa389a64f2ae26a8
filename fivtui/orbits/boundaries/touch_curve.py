"""Curves of limit cycles that touch y = 0 from the belt's side, over two parameters."""

from dataclasses import replace
from typing import Final

import numpy as np

from fivtui.model import Progress
from fivtui.orbits.curves.arclength import CycleCurve, OrbitCurve, OrbitOnCurve, cycle_scales
from fivtui.orbits.curves.events import EventKind
from fivtui.orbits.curves.flow import FLOW_TOL, FloatArray, SliderBeltFlow
from fivtui.transient import START_SEEDS, Request, vary

from .plane import FIRST, SECOND, ParameterPlane

_UNKNOWN_COUNT: Final = 7
# Greatest height of a touching cycle's highest point, relative to the depth of its lowest point.
_MAX_HEIGHT: Final = 1e-9


class TouchCurve(CycleCurve[OrbitOnCurve]):
    """The equations of cycles that start at their highest point, y = 0.

    These cycles stay in contact, so that separation has no effect.
    """

    def __init__(self, plane: ParameterPlane, length: float, period: float, work: Progress) -> None:
        scales = cycle_scales(length, period, *plane.units)
        super().__init__(scales, plane.bounds((FIRST, SECOND)))
        self.tests = {
            EventKind.FOLD: lambda orbit: float(np.linalg.det(orbit.monodromy - np.eye(3)))
        }
        self._plane = plane
        flow = SliderBeltFlow(replace(plane.system, separation=False), plane.names)
        self._orbits = OrbitCurve(flow, scales, work)

    def touching_cycle(
        self, cycle: FloatArray, index: int = FIRST, values: FloatArray | None = None
    ) -> OrbitOnCurve | None:
        """The touching cycle near a cycle in contact, with the value of one unknown fixed.

        `cycle` are the unknowns of that cycle; `values`, scaled, replace its parameters.
        """
        x, vx = self._highest_point(cycle)
        guess = np.array([x, vx, 0.0, 0.0, *cycle[4:]]) / self.scales
        if values is not None:
            guess[FIRST:] = values
        return self.correct(guess, None, np.eye(_UNKNOWN_COUNT)[index])

    def correct(
        self,
        guess: FloatArray,
        near: OrbitOnCurve | None,  # noqa: ARG002
        along: FloatArray,
        tangent: FloatArray | None = None,
    ) -> OrbitOnCurve | None:
        """The cycle near a guess in the plane with the normal `along`: see `Curve`."""
        planes = np.zeros((3, _UNKNOWN_COUNT))
        planes[0, 2] = planes[1, 3] = 1.0
        planes[2] = along
        orbit = self._orbits.solve(guess, planes, tangent, tangent_across=False)
        if orbit is None:
            return None
        low, high = orbit.extremes[2:4].tolist()
        return None if high > _MAX_HEIGHT * abs(low) else orbit

    def _highest_point(self, cycle: FloatArray) -> tuple[float, float]:
        # x and ẋ at the highest point of a cycle.
        x, vx, y, vy, period, *values = cycle.tolist()
        state = (x, vx, y, vy)
        system = replace(self._plane.system_at(values), separation=False)
        cycle_run = Request(system, t_end=period, tol=FLOW_TOL, start=state)
        moment = float(vary(cycle_run, START_SEEDS[:1]).extreme_times[3])
        if 0.0 < moment < period:
            rise = Request(system, t_end=moment, tol=FLOW_TOL, start=state)
            state = vary(rise, START_SEEDS[:1]).final
        return state[0], state[1]
