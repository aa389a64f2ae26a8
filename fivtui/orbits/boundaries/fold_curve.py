"""Curves of folds of limit cycles over two parameters."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from fivtui.model import Cancelled
from fivtui.orbits.curves.arclength import OrbitOnCurve
from fivtui.orbits.curves.events import EventKind
from fivtui.orbits.curves.flow import FloatArray, Return, SliderBeltFlow

from .plane import FIRST, SECOND, ParameterPlane

# Unknowns are the state, the period and two parameters; those of a null vector are the first five.
_COUNT: Final = 7
_NULL: Final = 5
_MOST_ITERATIONS: Final = 12
_CONVERGED: Final = 1e-9
_EXACT: Final = 3e-13
# Second derivatives are differences over this part of the orbit's size, and of its height above 0.
_DIFFERENCE: Final = 1e-5
_PART_OFF: Final = 0.05
# Off the belt the curve is followed as far as the highest point is above y = 0 by this part of the
# length: at y = 0 it has a corner.
NEAR_CORNER: Final = 1e-4


@dataclass(frozen=True, slots=True)
class FoldOnCurve(OrbitOnCurve):
    """A limit cycle with a multiplier 1."""

    null: FloatArray
    left: FloatArray
    bend: float


class FoldCurve:
    """The equations of folds: shooting, and a bordered determinant that vanishes at folds.

    Second derivatives of the flow are differences of its first ones along the null vector.
    """

    def __init__(
        self,
        plane: ParameterPlane,
        length: float,
        period: float,
        *,
        separation: bool,
        go_on: Callable[[], bool] = lambda: True,
    ) -> None:
        speed = 2.0 * math.pi * length / period
        self.scales = np.array([length, speed, length, speed, period, *plane.units])
        self.bounds = plane.bounds((FIRST, SECOND))
        height = NEAR_CORNER * length if separation else 0.0
        self.tests: Mapping[EventKind, Callable[[FoldOnCurve], float]] = {
            EventKind.CUSP: lambda fold: fold.bend
        }
        if plane.system.separation:
            self.tests = {
                **self.tests,
                EventKind.TOUCH: lambda fold: float(fold.extremes[3]) - height,
            }
        self._flow = SliderBeltFlow(replace(plane.system, separation=separation), plane.names)
        self._go_on, self._separation = go_on, separation

    def correct(
        self,
        guess: FloatArray,
        here: FoldOnCurve,
        along: FloatArray,
        tangent: FloatArray | None = None,
    ) -> FoldOnCurve | None:
        """The fold near a guess in the plane with the normal `along`: see `Curve`."""
        way = along if tangent is None else tangent
        return self._solve(guess, along, way, (here.across, here.null, here.left))

    def begin(self, orbit: OrbitOnCurve, place: int) -> FoldOnCurve | None:
        """The fold near a limit cycle, with the value of the unknown at `place`."""
        there = self._return(orbit.unknowns)
        if there is None:
            return None
        system = self._shooting(there)
        across = there.rate / self.scales[:4]
        across /= np.linalg.norm(across)
        matrix = np.vstack([system[:, :_NULL], [*across, 0.0]])
        lefts, _, nulls = np.linalg.svd(matrix)
        fixed = np.eye(_COUNT)[place]
        return self._solve(orbit.unknowns, fixed, fixed, (across, nulls[-1], lefts[:, -1]))

    def size(self, point: FoldOnCurve) -> float:
        """Amplitude of both displacements, scaled."""
        x_min, x_max, y_min, y_max = (point.extremes[:4] / self.scales[0]).tolist()
        return 0.5 * math.hypot(x_max - x_min, y_max - y_min)

    def features(self, point: FoldOnCurve) -> FloatArray:
        """What does not depend on the phase."""
        return np.concatenate([point.unknowns[4:], point.extremes[:4] / self.scales[0]])

    def confirmed(self, kind: EventKind, point: FoldOnCurve) -> bool:  # noqa: ARG002
        """Whether an event is what its test looked for."""
        return True

    def _solve(
        self,
        guess: FloatArray,
        along: FloatArray,
        tangent: FloatArray,
        borders: tuple[FloatArray, FloatArray, FloatArray],
    ) -> FoldOnCurve | None:
        if not self._go_on():
            raise Cancelled
        across = borders[0]
        unknowns, least, best = guess.copy(), np.inf, None
        for iteration in range(_MOST_ITERATIONS):
            there = self._return(unknowns)
            found = None if there is None else self._equations(unknowns, there, borders)
            if there is None or found is None:
                break
            system, null, left, determinant = found
            system[4, :4], system[6] = across, along
            away = unknowns - guess
            missed = np.array(
                [
                    *(there.final / self.scales[:4] - unknowns[:4]),
                    across @ away[:4],
                    determinant,
                    along @ away,
                ]
            )
            residual = float(np.abs(missed).max())
            size = float(np.abs(unknowns[:4]).max())
            if residual < least:
                least, best = residual, (unknowns, there, system, null, left, iteration, size)
            elif least < _CONVERGED * size:
                break
            if residual < _EXACT * size:
                break
            try:
                unknowns = unknowns - np.linalg.solve(system, missed)
            except np.linalg.LinAlgError:
                break
        if best is None or not least < _CONVERGED * best[-1]:
            return None
        return self._completed(best[:-1], tangent)

    def _completed(
        self,
        found: tuple[FloatArray, Return, FloatArray, FloatArray, FloatArray, int],
        tangent: FloatArray,
    ) -> FoldOnCurve | None:
        unknowns, there, system, null, left, iterations = found
        rate = there.rate / self.scales[:4]
        across = rate / np.linalg.norm(rate)
        system = system.copy()
        system[4, :4], system[6] = across, tangent
        try:
            way = np.linalg.solve(system, np.eye(_COUNT)[-1])
        except np.linalg.LinAlgError:
            return None
        way /= np.linalg.norm(way)
        system[6] = way
        basis = np.linalg.qr(np.column_stack([across, np.eye(4)]))[0][:, 1:4]
        return FoldOnCurve(
            unknowns=unknowns,
            tangent=way,
            across=across,
            monodromy=basis.T @ (system[:4, :4] + np.eye(4)) @ basis,
            extremes=there.extremes,
            determinant=float(np.linalg.det(system)),
            iterations=iterations,
            null=null,
            left=left,
            bend=float(system[5, :_NULL] @ null),
        )

    def _return(self, unknowns: FloatArray) -> Return | None:
        values = unknowns * self.scales
        if not np.isfinite(values).all() or not values[4] > 0.0:
            return None
        return self._flow.follow(values[:4], float(values[4]), values[FIRST:])

    def _shooting(self, there: Return) -> FloatArray:
        # How the return to the start changes with the unknowns.
        scales, units = self.scales, self.scales[:4, None]
        rows = np.empty((4, _COUNT))
        rows[:, :4] = there.derivatives[:, :4] * scales[:4] / units - np.eye(4)
        rows[:, 4] = there.rate * scales[4] / scales[:4]
        rows[:, FIRST:] = there.derivatives[:, 4:] * scales[FIRST:] / units
        return rows

    def _equations(
        self,
        unknowns: FloatArray,
        there: Return,
        borders: tuple[FloatArray, FloatArray, FloatArray],
    ) -> tuple[FloatArray, FloatArray, FloatArray, float] | None:
        # Their derivatives, the null vectors of the bordered matrix, and the number in its corner.
        across, old_null, old_left = borders
        system = np.zeros((_COUNT, _COUNT))
        system[:4] = self._shooting(there)
        bordered = np.zeros((_NULL + 1, _NULL + 1))
        bordered[:4, :_NULL] = system[:4, :_NULL]
        bordered[4, :4] = across
        bordered[:_NULL, _NULL], bordered[_NULL, :_NULL] = old_left, old_null
        corner = np.eye(_NULL + 1)[-1]
        try:
            null, left = np.linalg.solve(bordered, corner), np.linalg.solve(bordered.T, corner)
        except np.linalg.LinAlgError:
            return None
        determinant = float(null[-1])
        right, left = null[:_NULL], left[:_NULL]
        right = right / np.linalg.norm(right)
        second = self._second(unknowns, right, there)
        if second is None:
            return None
        scale = float(np.linalg.norm(null[:_NULL]))
        system[5] = -scale * (left[:4] @ second)
        return system, right, left / np.linalg.norm(left), determinant

    def _second(self, unknowns: FloatArray, way: FloatArray, there: Return) -> FloatArray | None:
        # Derivative of the shooting equations' derivatives along a direction in state and period.
        step = _DIFFERENCE * float(np.abs(unknowns[:4]).max())
        if self._separation:
            off = abs(float(there.extremes[3])) / float(self.scales[0])
            step = min(step, _PART_OFF * off) or step
        change = np.zeros(_COUNT)
        change[:_NULL] = step * way
        ahead, behind = self._return(unknowns + change), self._return(unknowns - change)
        if ahead is None or behind is None:
            return None
        return (self._shooting(ahead) - self._shooting(behind)) / (2.0 * step)
