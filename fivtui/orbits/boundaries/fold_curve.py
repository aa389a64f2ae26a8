"""Curves of folds of limit cycles over two parameters."""

from dataclasses import dataclass, fields, replace
from typing import Final, NamedTuple

import numpy as np

from fivtui.model import Progress
from fivtui.orbits.curves.arclength import (
    CycleCurve,
    Limits,
    OrbitCurve,
    OrbitOnCurve,
    cycle_scales,
    find_root,
)
from fivtui.orbits.curves.events import EventKind
from fivtui.orbits.curves.flow import FloatArray, Return, SliderBeltFlow

from .plane import FIRST, SECOND, ParameterPlane

# Unknowns are the state, the period and two parameters; a null vector has the first five.
_COUNT: Final = 7
_NULL: Final = 5
_LIMITS: Final = Limits(iterations=12, exact=3e-13, converged=1e-9)
# Step of the differences for second derivatives: relative to the orbit's size, and at most this
# part of its height above y = 0.
_DIFFERENCE: Final = 1e-5
_PART_OFF: Final = 0.05
# Height above y = 0, relative to the length, at which a curve off the belt ends: it has a corner at
# y = 0.
_NEAR_CORNER: Final = 1e-4


@dataclass(frozen=True, slots=True)
class FoldOnCurve(OrbitOnCurve):
    """A limit cycle with a multiplier 1, its null vectors, and the bend of the branch."""

    null: FloatArray
    left_null: FloatArray
    bend: float


class _Borders(NamedTuple):
    # Direction across the orbit, and null vectors, of a fold nearby.
    across: FloatArray
    null: FloatArray
    left_null: FloatArray


class _Fold(NamedTuple):
    motion: Return
    null: FloatArray
    left_null: FloatArray


class FoldCurve(CycleCurve[FoldOnCurve]):
    """The equations of folds: shooting, and a bordered determinant that vanishes at folds.

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
        height = _NEAR_CORNER * length if separation else 0.0
        self.tests = {EventKind.CUSP: lambda fold: fold.bend}
        if plane.system.separation:
            self.tests[EventKind.TOUCH] = lambda fold: float(fold.extremes[3]) - height
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
        borders = _Borders(near.across, near.null, near.left_null)
        return self._solve(guess, along, along if tangent is None else tangent, borders)

    def begin(self, unknowns: FloatArray, index: int) -> FoldOnCurve | None:
        """The fold near a limit cycle, with the value of one of the unknowns."""
        motion = self._orbits.motion(unknowns)
        if motion is None:
            return None
        across = motion.rate / self.scales[:4]
        across /= np.linalg.norm(across)
        matrix = np.vstack([self._orbits.shooting(motion)[:, :_NULL], [*across, 0.0]])
        lefts, _, nulls = np.linalg.svd(matrix)
        fixed = np.eye(_COUNT)[index]
        return self._solve(unknowns, fixed, fixed, _Borders(across, nulls[-1], lefts[:, -1]))

    def _solve(
        self, guess: FloatArray, along: FloatArray, tangent: FloatArray, borders: _Borders
    ) -> FoldOnCurve | None:
        self._work.check()

        def equations(unknowns: FloatArray) -> tuple[FloatArray, FloatArray, _Fold] | None:
            motion = self._orbits.motion(unknowns)
            solved = None if motion is None else self._bordered(unknowns, motion, borders)
            if motion is None or solved is None:
                return None
            system, determinant, null, left_null = solved
            system[4, :4], system[6] = borders.across, along
            away = unknowns - guess
            error = self._orbits.closure_error(unknowns, motion)
            across, ahead = float(borders.across @ away[:4]), float(along @ away)
            return (
                np.append(error, [across, determinant, ahead]),
                system,
                _Fold(motion, null, left_null),
            )

        root = find_root(equations, guess, 4, _LIMITS)
        if root is None:
            return None
        motion, null, left_null = root.belonging
        orbit = self._orbits.with_tangent(root, motion, tangent)
        if orbit is None:
            return None
        bend = float(root.derivatives[5, :_NULL] @ null)
        values = {field.name: getattr(orbit, field.name) for field in fields(orbit)}
        return FoldOnCurve(**values, null=null, left_null=left_null, bend=bend)

    def _bordered(
        self, unknowns: FloatArray, motion: Return, borders: _Borders
    ) -> tuple[FloatArray, float, FloatArray, FloatArray] | None:
        # Derivatives of the equations, the corner element of the inverse bordered matrix, and the
        # null vectors.
        system = np.zeros((_COUNT, _COUNT))
        system[:4] = self._orbits.shooting(motion)
        bordered = np.zeros((_NULL + 1, _NULL + 1))
        bordered[:4, :_NULL] = system[:4, :_NULL]
        bordered[4, :4] = borders.across
        bordered[:_NULL, _NULL], bordered[_NULL, :_NULL] = borders.left_null, borders.null
        corner = np.eye(_NULL + 1)[-1]
        try:
            null, left_null = np.linalg.solve(bordered, corner), np.linalg.solve(bordered.T, corner)
        except np.linalg.LinAlgError:
            return None
        determinant, scale = float(null[-1]), float(np.linalg.norm(null[:_NULL]))
        right, left_null = null[:_NULL] / scale, left_null[:_NULL]
        second = self._shooting_derivative(unknowns, right, motion)
        if second is None:
            return None
        system[5] = -scale * (left_null[:4] @ second)
        return system, determinant, right, left_null / np.linalg.norm(left_null)

    def _shooting_derivative(
        self, unknowns: FloatArray, direction: FloatArray, motion: Return
    ) -> FloatArray | None:
        # Directional derivative of the Jacobian of shooting, in state and period.
        step = _DIFFERENCE * float(np.abs(unknowns[:4]).max())
        if self._separation:
            off = abs(float(motion.extremes[3])) / float(self.scales[0])
            step = min(step, _PART_OFF * off) or step
        change = np.zeros(_COUNT)
        change[:_NULL] = step * direction
        ahead, behind = (self._orbits.motion(unknowns + sign * change) for sign in (1.0, -1.0))
        if ahead is None or behind is None:
            return None
        shooting = self._orbits.shooting
        return (shooting(ahead) - shooting(behind)) / (2.0 * step)
