"""The curve of limit cycles along one parameter, with the tests for its events."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Progress, System

from .arclength import (
    PARAMETER,
    SILENT_PROGRESS,
    CycleCurve,
    OrbitCurve,
    OrbitOnCurve,
    cycle_scales,
)
from .events import End, EventKind
from .flow import POSITION_EXTREME_COUNT, FloatArray, Flow, ModePattern, SliderBeltFlow
from .following import Bound

# Rounding of the parameter's derivative along the curve.
_SLOPE_ROUNDING: Final = 1e-9
# Greatest distance of multipliers at a torus from the unit circle, and least imaginary part.
_CIRCLE_TOL: Final = 1e-6
# A period begins within this part of a stick, relative to the length of the stick.
_INNER_PART: Final = (0.25, 0.75)
# A stick vanishes below this part of the period. The gap between the belt speed and the greatest ẋ
# of a slip vanishes below this part of the belt speed.
_VANISHING: Final = 1e-3
# The parameter's unit is the greatest power of two up to its size, or up to its range divided by
# this where its size is smaller.
_RANGE_PER_UNIT: Final = 64.0


def touch_test(orbit: OrbitOnCurve) -> float:
    """Zero if an extreme of y is at y = 0, where contact ends; positive if y changes its sign."""
    return -orbit.y_min * orbit.y_max


def fold_test(orbit: OrbitOnCurve) -> float:
    """The derivative of the parameter along the curve; zero at a fold."""
    slope = float(orbit.tangent[PARAMETER])
    return slope if abs(slope) > _SLOPE_ROUNDING else 0.0


def period_doubling_test(orbit: OrbitOnCurve) -> float:
    """Zero where a multiplier is -1."""
    return float(np.linalg.det(orbit.monodromy + np.eye(len(orbit.monodromy))))


def torus_test(orbit: OrbitOnCurve) -> float:
    """Zero where the product of two multipliers is 1.

    The products of pairs are the eigenvalues of the second compound matrix, which has the minors of
    all pairs of rows and pairs of columns. The test is the determinant of it less the identity.
    """
    rows = orbit.monodromy.tolist()
    pairs = list(combinations(range(len(rows)), 2))
    minors_less_identity = [
        [rows[i][k] * rows[j][n] - rows[i][n] * rows[j][k] - (i == k and j == n) for k, n in pairs]
        for i, j in pairs
    ]
    return float(np.linalg.det(minors_less_identity)) if pairs else 1.0


def branch_test(orbit: OrbitOnCurve) -> float:
    """Zero where another branch crosses: the equations are singular."""
    return orbit.determinant


_TESTS: Final[dict[EventKind, Callable[[OrbitOnCurve], float]]] = {
    EventKind.TOUCH: touch_test,
    EventKind.FOLD: fold_test,
    EventKind.PERIOD_DOUBLING: period_doubling_test,
    EventKind.TORUS: torus_test,
    EventKind.BRANCH: branch_test,
}


class BranchCurve(CycleCurve[OrbitOnCurve]):
    """Periodic orbits of a flow along one parameter; events of `untested` are not searched for.

    Touches of y = 0 are searched for if `tests_touch`.
    """

    # The parameter may turn at two folds within a step: such steps are shortened.
    checks_hidden_folds = True
    untested: frozenset[EventKind] = frozenset()

    def __init__(
        self,
        flow: Flow,
        scales: FloatArray,
        bounds: tuple[float, float],
        work: Progress = SILENT_PROGRESS,
        *,
        tests_touch: bool,
    ) -> None:
        low, high = bounds
        unit = float(scales[PARAMETER])
        super().__init__(scales, (Bound(len(scales) - 1, low / unit, high / unit),))
        self.orbits = OrbitCurve(flow, scales, work)
        untested = self.untested if tests_touch else {*self.untested, EventKind.TOUCH}
        self.tests = {kind: test for kind, test in _TESTS.items() if kind not in untested}

    def correct(
        self,
        guess: FloatArray,
        neighbour: OrbitOnCurve,
        normal: FloatArray,
        heading: FloatArray | None = None,
    ) -> OrbitOnCurve | None:
        """The orbit near a guess, in the plane through it with this normal: see `Curve`."""
        flow_direction = neighbour.flow_direction
        normals = np.zeros((2, len(guess)))
        normals[0, : len(flow_direction)], normals[1] = flow_direction, normal
        return self.orbits.solve(guess, normals, heading)

    def multipliers(self, orbits: Sequence[OrbitOnCurve]) -> NDArray[np.complex128]:
        """Floquet multipliers of orbits by falling size, one row each."""
        values = np.linalg.eigvals(np.array([orbit.monodromy for orbit in orbits]))
        order = np.argsort(-np.abs(values), axis=1, kind="stable")
        return np.take_along_axis(values.astype(np.complex128), order, axis=1)

    def confirms(self, kind: EventKind, point: OrbitOnCurve) -> bool:
        """Whether an event is confirmed: at a torus the multipliers of product 1 are complex."""
        if kind is not EventKind.TORUS:
            return True
        values = point.multipliers
        complex_values = values[np.abs(values.imag) > _CIRCLE_TOL]
        distances = np.abs(np.abs(complex_values) - 1.0)
        return bool(distances.size and distances.min() < _CIRCLE_TOL)


def mode_pattern(orbit: OrbitOnCurve) -> ModePattern:
    """Sticks and order of modes in contact of a cycle on a belt of finite speed (`v_belt`)."""
    # `SliderBeltFlow` appends the pattern to the extremes of x and y.
    return ModePattern(*orbit.extremes[POSITION_EXTREME_COUNT:].tolist())


class FiniteSpeedBranchCurve(BranchCurve):
    """Periodic orbits on a belt of finite speed, to which the slider may stick.

    The curve has corners where the order of modes changes: slip forward, slip backward, stick.
    """

    # Over a stick the derivative of the motion by its start is singular, so that the sign of the
    # determinant depends on where the period begins.
    untested = frozenset({EventKind.BRANCH})

    def multipliers(self, orbits: Sequence[OrbitOnCurve]) -> NDArray[np.complex128]:
        """Multipliers as in `BranchCurve`; with sticks the last one is exactly 0."""
        values = super().multipliers(orbits)
        values[[mode_pattern(orbit).sticks > 0.0 for orbit in orbits], -1] = 0.0
        return values

    def pattern(self, point: OrbitOnCurve) -> tuple[float, ...]:
        """Numbers of sticks and reversals, and order of modes."""
        pattern = mode_pattern(point)
        return (pattern.sticks, pattern.reversals, pattern.order)

    def pattern_event(self, point: OrbitOnCurve, successor: OrbitOnCurve) -> EventKind:
        """The event between two cycles of different patterns.

        `EventKind.STICK` if the numbers of sticks differ, `REVERSE_SLIP` if those of slips backward
        do, else `ORDER`: the modes in contact have a different order.
        """
        before, after = mode_pattern(point), mode_pattern(successor)
        if before.sticks != after.sticks:
            return EventKind.STICK
        reverses = before.reversals != after.reversals
        return EventKind.REVERSE_SLIP if reverses else EventKind.ORDER

    def loss_reason(self, point: OrbitOnCurve) -> End:
        """Why the branch cannot be followed beyond its last cycle."""
        pattern = mode_pattern(point)
        if pattern.shortest_stick < _VANISHING:
            return End.STICK_ENDS
        # A slider that reaches the belt speed begins to stick, and the motion jumps.
        return End.JUMPS if 0.0 < pattern.speed_gap < _VANISHING else End.LOST

    def recentre(self, point: OrbitOnCurve) -> OrbitOnCurve:
        """The cycle, with a period that begins well inside the longest stick if it sticks.

        `Follower` calls this after each step, so that the start remains within a stick.
        """
        pattern = mode_pattern(point)
        if pattern.sticks == 0.0 or _INNER_PART[0] < pattern.start_in_stick < _INNER_PART[1]:
            return point
        moved = self.orbits.restart_later(point, pattern.longest_stick_middle)
        if moved is None or self.pattern(moved) != self.pattern(point):
            return point
        return moved if mode_pattern(moved).start_in_stick > 0.0 else point


@dataclass(frozen=True, slots=True)
class ParameterLine:
    """A parameter of a system, and the range in which it varies; `work` reports and cancels."""

    system: System
    name: str
    bounds: tuple[float, float]
    work: Progress = SILENT_PROGRESS

    @property
    def value(self) -> float:
        """The value of the parameter in the system."""
        value: float = getattr(self.system.parameters, self.name)
        return value

    def with_value(self, value: float) -> "ParameterLine":
        """The same parameter and range, for the system with a value of the parameter."""
        return replace(self, system=self.system.with_values({self.name: value}))

    def curve(self, length: float, period: float) -> BranchCurve:
        """The limit cycles along the parameter.

        State and period are scaled by a length, m, and a period, s; the parameter by a power of 2.
        """
        low, high = self.bounds
        unit = 2.0 ** math.floor(math.log2(max(abs(self.value), (high - low) / _RANGE_PER_UNIT)))
        flow = SliderBeltFlow(self.system, (self.name,))
        finite_speed = self.system.parameters.v_belt is not None
        return (FiniteSpeedBranchCurve if finite_speed else BranchCurve)(
            flow,
            cycle_scales(length, period, unit),
            self.bounds,
            self.work,
            tests_touch=self.system.separation,
        )
