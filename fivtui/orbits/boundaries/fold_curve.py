"""Curves of folds of limit cycles over two parameters.

The unknowns are state, period and both parameters, each divided by its unit. The closure error is
the end of a period less its start. At a fold the closure error's derivatives by state and period,
with a row that fixes the phase, are singular. One row and one column more, a border, give a matrix
that is regular there too. The last element of its inverse is zero exactly where the inner matrix is
singular: this is the equation of folds.
"""

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

from .plane import (
    FIRST_PARAMETER,
    SECOND_PARAMETER,
    STATE,
    STATE_AND_PERIOD,
    UNKNOWN_COUNT,
    ParameterPlane,
)

_STATE_COUNT: Final = 4
# Null vectors have a component for each state variable and for the period.
_NULL_SIZE: Final = 5
# Rows of the equations: the orbit closes, its phase is fixed, it is at a fold, and it is in the
# plane in which it is sought.
_CLOSURE_ROWS: Final = slice(0, 4)
_PHASE_ROW, _FOLD_ROW, _PLANE_ROW = 4, 5, 6
# Residuals relative to the state: iteration stops below `negligible`, a root is below `accepted`.
_NEWTON_LIMITS: Final = NewtonLimits(iterations=12, negligible=3e-13, accepted=1e-9)
# Step of the differences for second derivatives, relative to the state. With separation it is at
# most `_STEP_PER_HEIGHT` times the distance of the highest point from y = 0.
_DIFFERENCE_STEP: Final = 1e-5
_STEP_PER_HEIGHT: Final = 0.05
# Height of the highest point, relative to the length, at which a curve of separating cycles ends.
# At zero height the cycles cease to separate, and the curve has a corner.
_CORNER_HEIGHT: Final = 1e-4


@dataclass(frozen=True, slots=True)
class FoldOnCurve(OrbitOnCurve):
    """A limit cycle at a fold, with null vectors of the Jacobian.

    `curvature` is the derivative of the fold's equation along the null vector, zero at a cusp.
    """

    null_vector: FloatArray
    left_null_vector: FloatArray
    curvature: float


class _Border(NamedTuple):
    # Vectors of a fold nearby that border the Jacobian: direction of the motion, and null vectors.
    flow_direction: FloatArray
    null_vector: FloatArray
    left_null_vector: FloatArray


class _Fold(NamedTuple):
    # Motion over a period, and null vectors of the Jacobian.
    motion: MotionEnd
    null_vector: FloatArray
    left_null_vector: FloatArray


class _FoldTest(NamedTuple):
    # A function of the unknowns that is zero at folds, its derivatives, the closure error's
    # derivatives, and the null vectors.
    value: float
    derivatives: FloatArray
    closure_derivatives: FloatArray
    null_vector: FloatArray
    left_null_vector: FloatArray


class FoldCurve(CycleCurve[FoldOnCurve]):
    """The equations of folds: closure, and a function of the bordered matrix that is zero there.

    Second derivatives of the flow are differences of first derivatives along the null vector.
    `separation` replaces that of the plane's system: folds in contact ignore separation.
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
        super().__init__(scales, plane.bounds((FIRST_PARAMETER, SECOND_PARAMETER)))
        corner_height = _CORNER_HEIGHT * length if separation else 0.0
        # Each event is where its test is zero.
        self.tests = {EventKind.CUSP: lambda fold: fold.curvature}
        if plane.system.separation:
            self.tests[EventKind.TOUCH] = lambda fold: fold.y_max - corner_height
        flow = SliderBeltFlow(replace(plane.system, separation=separation), plane.names)
        self._orbits, self._work = OrbitCurve(flow, scales, work), work
        self._separation = separation

    def correct(
        self,
        guess: FloatArray,
        neighbour: FoldOnCurve,
        normal: FloatArray,
        heading: FloatArray | None = None,
    ) -> FoldOnCurve | None:
        """The fold near a guess, in the hyperplane through it with this normal.

        The tangent points to the side of `heading`, by default of the normal. The null vectors of
        `neighbour`, a fold nearby, border the Jacobian.
        """
        border = _Border(
            neighbour.flow_direction, neighbour.null_vector, neighbour.left_null_vector
        )
        return self._solve(guess, normal, normal if heading is None else heading, border)

    def fold_at(self, unknowns: FloatArray, fixed_index: int) -> FoldOnCurve | None:
        """The fold near a limit cycle at the same value of the unknown with this index."""
        motion = self._orbits.motion(unknowns)
        if motion is None:
            return None
        direction = motion.rate / self.scales[STATE]
        direction /= np.linalg.norm(direction)
        jacobian = self._orbits.jacobian(motion)[:, STATE_AND_PERIOD]
        left_vectors, _, right_vectors = np.linalg.svd(np.vstack([jacobian, [*direction, 0.0]]))
        # The last singular vectors belong to the least singular value, zero at a fold.
        border = _Border(direction, right_vectors[-1], left_vectors[:, -1])
        normal = np.eye(UNKNOWN_COUNT)[fixed_index]
        return self._solve(unknowns, normal, normal, border)

    def _solve(
        self, guess: FloatArray, normal: FloatArray, heading: FloatArray, border: _Border
    ) -> FoldOnCurve | None:
        self._work.check()

        def equations(unknowns: FloatArray) -> tuple[FloatArray, FloatArray, _Fold] | None:
            motion = self._orbits.motion(unknowns)
            fold_test = None if motion is None else self._fold_test(unknowns, motion, border)
            if motion is None or fold_test is None:
                return None
            derivatives = np.zeros((UNKNOWN_COUNT, UNKNOWN_COUNT))
            derivatives[_CLOSURE_ROWS] = fold_test.closure_derivatives
            derivatives[_PHASE_ROW, STATE] = border.flow_direction
            derivatives[_FOLD_ROW] = fold_test.derivatives
            derivatives[_PLANE_ROW] = normal
            deviation = unknowns - guess
            phase_error = float(border.flow_direction @ deviation[STATE])
            residuals = np.append(
                self._orbits.closure_error(unknowns, motion),
                [phase_error, fold_test.value, float(normal @ deviation)],
            )
            fold = _Fold(motion, fold_test.null_vector, fold_test.left_null_vector)
            return residuals, derivatives, fold

        root = find_root(equations, guess, state_count=_STATE_COUNT, limits=_NEWTON_LIMITS)
        if root is None:
            return None
        motion, null_vector, left_null_vector = root.data
        orbit = self._orbits.orbit_with_tangent(root, motion, heading=heading)
        if orbit is None:
            return None
        return FoldOnCurve(
            **{field.name: getattr(orbit, field.name) for field in fields(orbit)},
            null_vector=null_vector,
            left_null_vector=left_null_vector,
            curvature=float(root.derivatives[_FOLD_ROW, STATE_AND_PERIOD] @ null_vector),
        )

    def _fold_test(
        self, unknowns: FloatArray, motion: MotionEnd, border: _Border
    ) -> _FoldTest | None:
        # The test is the last element of the inverse of the bordered matrix. This is zero if and
        # only if the Jacobian by state and period, with the row that fixes the phase, is singular.
        # Let v and w be the solutions of the equations of the bordered matrix M and of its
        # transpose. The derivative of the test is −wᵀ(dM)v; v is `scale` times the null vector.
        closure_derivatives = self._orbits.jacobian(motion)
        bordered = np.zeros((_NULL_SIZE + 1, _NULL_SIZE + 1))
        bordered[_CLOSURE_ROWS, :_NULL_SIZE] = closure_derivatives[:, STATE_AND_PERIOD]
        bordered[_PHASE_ROW, STATE] = border.flow_direction
        bordered[:_NULL_SIZE, -1] = border.left_null_vector
        bordered[-1, :_NULL_SIZE] = border.null_vector
        last_unit_vector = np.eye(_NULL_SIZE + 1)[-1]
        try:
            right_solution = np.linalg.solve(bordered, last_unit_vector)
            left_solution = np.linalg.solve(bordered.T, last_unit_vector)[:_NULL_SIZE]
        except np.linalg.LinAlgError:
            return None
        scale = float(np.linalg.norm(right_solution[:_NULL_SIZE]))
        null_vector = right_solution[:_NULL_SIZE] / scale
        jacobian_derivative = self._jacobian_derivative(unknowns, null_vector, motion)
        if jacobian_derivative is None:
            return None
        return _FoldTest(
            value=float(right_solution[-1]),
            derivatives=-scale * (left_solution[_CLOSURE_ROWS] @ jacobian_derivative),
            closure_derivatives=closure_derivatives,
            null_vector=null_vector,
            left_null_vector=left_solution / np.linalg.norm(left_solution),
        )

    def _jacobian_derivative(
        self, unknowns: FloatArray, direction: FloatArray, motion: MotionEnd
    ) -> FloatArray | None:
        # Derivative of the closure's Jacobian in a direction of state and period.
        step = _DIFFERENCE_STEP * float(np.abs(unknowns[STATE]).max())
        if self._separation:
            height = abs(motion.y_max) / float(self.scales[0])
            if height > 0.0:
                step = min(step, _STEP_PER_HEIGHT * height)
        change = np.zeros(UNKNOWN_COUNT)
        change[STATE_AND_PERIOD] = step * direction
        ahead, behind = (self._orbits.motion(unknowns + sign * change) for sign in (1.0, -1.0))
        if ahead is None or behind is None:
            return None
        jacobian = self._orbits.jacobian
        return (jacobian(ahead) - jacobian(behind)) / (2.0 * step)
