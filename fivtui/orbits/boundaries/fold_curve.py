"""Curves of folds of limit cycles over two parameters."""

from dataclasses import dataclass, fields, replace
from typing import Final, NamedTuple

import numpy as np

from fivtui.model import Progress
from fivtui.orbits.curves.arclength import (
    CycleCurve,
    NewtonLimits,
    OrbitCurve,
    OrbitOnCurve,
    cycle_scales,
    find_root,
)
from fivtui.orbits.curves.events import EventKind
from fivtui.orbits.curves.flow import FloatArray, MotionEnd, SliderBeltFlow

from .plane import FIRST, SECOND, ParameterPlane

# Unknowns are the state, the period and two parameters; null vectors have the first five alone.
_UNKNOWN_COUNT: Final = 7
_NULL: Final = 5
_NEWTON_LIMITS: Final = NewtonLimits(iterations=12, negligible=3e-13, accepted=1e-9)
# Step of the differences for second derivatives, relative to the state. With separation it is at
# most a part of the distance of the highest point from y = 0.
_DIFFERENCE: Final = 1e-5
_HEIGHT_PART: Final = 0.05
# Height of the highest point, relative to the length, at which a curve of separating cycles ends:
# the curve has a corner at zero height.
_CORNER_HEIGHT: Final = 1e-4


@dataclass(frozen=True, slots=True)
class FoldOnCurve(OrbitOnCurve):
    """A limit cycle at a fold: null vectors of the Jacobian, and second derivative along them."""

    null: FloatArray
    left_null: FloatArray
    curvature: float


class _Border(NamedTuple):
    # Vectors of a fold nearby that border the Jacobian: direction of the motion, and null vectors.
    flow_direction: FloatArray
    null: FloatArray
    left_null: FloatArray


class _Fold(NamedTuple):
    motion: MotionEnd
    null: FloatArray
    left_null: FloatArray


class FoldCurve(CycleCurve[FoldOnCurve]):
    """The equations of folds: closure, and a bordered determinant that vanishes at folds.

    Second derivatives of the flow are differences of first derivatives along the null vector.
    """

    def __init__(
        self,
        plane: ParameterPlane,
        length: float,
        period: float,
        work: Progress,
        *,
        separation: bool,
    ) -> None:
        scales = cycle_scales(length, period, *plane.units)
        super().__init__(scales, plane.bounds((FIRST, SECOND)))
        corner_height = _CORNER_HEIGHT * length if separation else 0.0
        self.tests = {EventKind.CUSP: lambda fold: fold.curvature}
        if plane.system.separation:
            self.tests[EventKind.TOUCH] = lambda fold: float(fold.extremes[3]) - corner_height
        flow = SliderBeltFlow(replace(plane.system, separation=separation), plane.names)
        self._orbits, self._work = OrbitCurve(flow, scales, work), work
        self._separation = separation

    def correct(
        self,
        guess: FloatArray,
        near: FoldOnCurve,
        along: FloatArray,
        tangent: FloatArray | None = None,
    ) -> FoldOnCurve | None:
        """The fold near a guess in the plane with the normal `along`: see `Curve`."""
        border = _Border(near.flow_direction, near.null, near.left_null)
        return self._solve(guess, along, along if tangent is None else tangent, border)

    def fold_at(self, unknowns: FloatArray, index: int) -> FoldOnCurve | None:
        """The fold near a limit cycle at the same value of the unknown with this index."""
        motion = self._orbits.motion(unknowns)
        if motion is None:
            return None
        direction = motion.rate / self.scales[:4]
        direction /= np.linalg.norm(direction)
        matrix = np.vstack([self._orbits.jacobian(motion)[:, :_NULL], [*direction, 0.0]])
        lefts, _, rights = np.linalg.svd(matrix)
        fixed = np.eye(_UNKNOWN_COUNT)[index]
        return self._solve(unknowns, fixed, fixed, _Border(direction, rights[-1], lefts[:, -1]))

    def _solve(
        self, guess: FloatArray, along: FloatArray, tangent: FloatArray, border: _Border
    ) -> FoldOnCurve | None:
        self._work.check()

        def equations(unknowns: FloatArray) -> tuple[FloatArray, FloatArray, _Fold] | None:
            motion = self._orbits.motion(unknowns)
            solved = None if motion is None else self._solve_bordered(unknowns, motion, border)
            if motion is None or solved is None:
                return None
            system, determinant, null, left_null = solved
            system[4, :4], system[6] = border.flow_direction, along
            deviation = unknowns - guess
            error = self._orbits.closure_error(unknowns, motion)
            phase, advance = float(border.flow_direction @ deviation[:4]), float(along @ deviation)
            return (
                np.append(error, [phase, determinant, advance]),
                system,
                _Fold(motion, null, left_null),
            )

        root = find_root(equations, guess, 4, _NEWTON_LIMITS)
        if root is None:
            return None
        motion, null, left_null = root.data
        orbit = self._orbits.orbit_with_tangent(root, motion, tangent)
        if orbit is None:
            return None
        curvature = float(root.derivatives[5, :_NULL] @ null)
        values = {field.name: getattr(orbit, field.name) for field in fields(orbit)}
        return FoldOnCurve(**values, null=null, left_null=left_null, curvature=curvature)

    def _solve_bordered(
        self, unknowns: FloatArray, motion: MotionEnd, border: _Border
    ) -> tuple[FloatArray, float, FloatArray, FloatArray] | None:
        # Derivatives of the equations, the last element of the inverse bordered matrix, which is
        # zero at folds, and the null vectors.
        system = np.zeros((_UNKNOWN_COUNT, _UNKNOWN_COUNT))
        system[:4] = self._orbits.jacobian(motion)
        bordered = np.zeros((_NULL + 1, _NULL + 1))
        bordered[:4, :_NULL] = system[:4, :_NULL]
        bordered[4, :4] = border.flow_direction
        bordered[:_NULL, _NULL], bordered[_NULL, :_NULL] = border.left_null, border.null
        corner = np.eye(_NULL + 1)[-1]
        try:
            null, left_null = np.linalg.solve(bordered, corner), np.linalg.solve(bordered.T, corner)
        except np.linalg.LinAlgError:
            return None
        determinant, scale = float(null[-1]), float(np.linalg.norm(null[:_NULL]))
        right_null, left_null = null[:_NULL] / scale, left_null[:_NULL]
        derivative = self._jacobian_derivative(unknowns, right_null, motion)
        if derivative is None:
            return None
        system[5] = -scale * (left_null[:4] @ derivative)
        return system, determinant, right_null, left_null / np.linalg.norm(left_null)

    def _jacobian_derivative(
        self, unknowns: FloatArray, direction: FloatArray, motion: MotionEnd
    ) -> FloatArray | None:
        # Derivative of the closure's Jacobian in a direction of state and period.
        step = _DIFFERENCE * float(np.abs(unknowns[:4]).max())
        if self._separation:
            height = abs(float(motion.extremes[3])) / float(self.scales[0])
            step = min(step, _HEIGHT_PART * height) or step
        change = np.zeros(_UNKNOWN_COUNT)
        change[:_NULL] = step * direction
        ahead, behind = (self._orbits.motion(unknowns + sign * change) for sign in (1.0, -1.0))
        if ahead is None or behind is None:
            return None
        jacobian = self._orbits.jacobian
        return (jacobian(ahead) - jacobian(behind)) / (2.0 * step)
