"""Curves of touching cycles over two parameters: limit cycles in contact that just reach y = 0.

The unknowns are state, period and both parameters, each divided by its unit.
"""

from dataclasses import replace
from typing import Final

import numpy as np

from fivtui.model import Progress
from fivtui.orbits.curves.arclength import CycleCurve, OrbitCurve, OrbitOnCurve, cycle_scales
from fivtui.orbits.curves.events import EventKind
from fivtui.orbits.curves.flow import FLOW_TOL, Y_MAX, FloatArray, SliderBeltFlow
from fivtui.transient import START_SEEDS, Request, compute_variation

from .plane import FIRST_PARAMETER, IN_PLANE, SECOND_PARAMETER, UNKNOWN_COUNT, ParameterPlane

# Unit vectors of the unknowns. A touching cycle starts at its highest point, where y = ẏ = 0.
_UNIT_VECTORS: Final = np.eye(UNKNOWN_COUNT)
_Y_AXIS, _VY_AXIS = _UNIT_VECTORS[2], _UNIT_VECTORS[3]
# Greatest y_max of a touching cycle, relative to |y_min|. The start is at y = 0 by the equations; a
# cycle that rises above it elsewhere leaves the belt.
_MAX_HEIGHT: Final = 1e-9
# `vary` gives the times of extremes with derivatives by a direction of the start, unused here.
_UNUSED_DIRECTION: Final = START_SEEDS[:1]


class TouchCurve(CycleCurve[OrbitOnCurve]):
    """The equations of cycles that start at their highest point, y = 0.

    These cycles stay in contact, so that separation has no effect.
    """

    def __init__(self, plane: ParameterPlane, length: float, period: float, work: Progress) -> None:
        scales = cycle_scales(length, period, *plane.units)
        super().__init__(scales, plane.bounds((FIRST_PARAMETER, SECOND_PARAMETER)))
        # Folds are where the test is zero: one of the three multipliers is 1. They are eigenvalues
        # of the monodromy matrix, which acts on deviations normal to the motion.
        self.tests = {
            EventKind.FOLD: lambda orbit: float(np.linalg.det(orbit.monodromy - np.eye(3)))
        }
        self._plane = plane
        flow = SliderBeltFlow(replace(plane.system, separation=False), plane.names)
        self._orbits = OrbitCurve(flow, scales, work)

    def touching_cycle(
        self,
        cycle: FloatArray,
        fixed_index: int = FIRST_PARAMETER,
        scaled_values: FloatArray | None = None,
    ) -> OrbitOnCurve | None:
        """The touching cycle near a cycle in contact.

        `cycle` are the unknowns of that cycle in SI units. `scaled_values`, in units of the plane,
        replace its parameters if given. The unknown with the index `fixed_index` keeps its value.
        """
        x, vx = self._highest_point(cycle)
        _, _, _, _, *period_and_values = cycle
        guess = np.array([x, vx, 0.0, 0.0, *period_and_values]) / self.scales
        if scaled_values is not None:
            guess[IN_PLANE] = scaled_values
        return self.correct(guess, None, _UNIT_VECTORS[fixed_index])

    def correct(
        self,
        guess: FloatArray,
        neighbour: OrbitOnCurve | None,  # noqa: ARG002
        normal: FloatArray,
        heading: FloatArray | None = None,
    ) -> OrbitOnCurve | None:
        """The cycle near a guess, in the hyperplane through it with this normal.

        The tangent points to the side of `heading`, by default of the normal. `neighbour` is an
        argument of `Curve.correct` that touching cycles do not need.
        """
        # y and ẏ of the start remain zero along the curve: they fix the phase, not the flow.
        normals = np.array([_Y_AXIS, _VY_AXIS, normal])
        orbit = self._orbits.solve(guess, normals, heading, is_normal_to_flow=False)
        if orbit is None or orbit.y_max > _MAX_HEIGHT * abs(orbit.y_min):
            return None
        return orbit

    def _highest_point(self, cycle: FloatArray) -> tuple[float, float]:
        # x and ẋ at the highest point of a cycle.
        x, vx, y, vy, period, *values = cycle.tolist()
        state = (x, vx, y, vy)
        system = replace(self._plane.system_at(values), separation=False)
        cycle_run = Request(system, t_end=period, tol=FLOW_TOL, start=state)
        time_of_y_max = float(compute_variation(cycle_run, _UNUSED_DIRECTION).extreme_times[Y_MAX])
        if 0.0 < time_of_y_max < period:
            rise = Request(system, t_end=time_of_y_max, tol=FLOW_TOL, start=state)
            x, vx, _, _ = compute_variation(rise, _UNUSED_DIRECTION).final
        return x, vx
