"""The curve of limit cycles along one parameter, with the tests for its events."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Progress, System

from .arclength import UNWATCHED, VALUE, CycleCurve, OrbitCurve, OrbitOnCurve, cycle_scales
from .events import End, EventKind
from .flow import EXTREMES_KEPT, FloatArray, Flow, Makeup, SliderBeltFlow
from .following import Bound

# Derivatives of the parameter along the curve below this are rounding.
_LEVEL: Final = 1e-9
_ON_CIRCLE: Final = 1e-6
# Part of a stick in which a period may begin.
_INSIDE: Final = (0.25, 0.75)
# A stick (relative to the period) or gap to the belt speed (relative to it) below this explains a
# lost branch.
_NO_LONGER: Final = 1e-3
# The unit of the parameter, a power of two against rounding, is at least its range over this.
_LEAST_UNIT: Final = 64.0


def touch(orbit: OrbitOnCurve) -> float:
    """Zero where the highest or the lowest point is at y = 0; positive if the cycle crosses it."""
    low, high = orbit.extremes[2:4].tolist()
    return float(-low * high)


def level(orbit: OrbitOnCurve) -> float:
    """The derivative of the parameter along the curve; zero at a fold."""
    change = float(orbit.tangent[VALUE])
    return change if abs(change) > _LEVEL else 0.0


def flip(orbit: OrbitOnCurve) -> float:
    """Zero where a multiplier is -1."""
    return float(np.linalg.det(orbit.monodromy + np.eye(len(orbit.monodromy))))


def pairs(orbit: OrbitOnCurve) -> float:
    """Zero where the product of two multipliers is 1.

    The products are the eigenvalues of the matrix of all minors of two rows and columns.
    """
    rows = orbit.monodromy.tolist()
    chosen = list(combinations(range(len(rows)), 2))
    minors = [
        [rows[i][k] * rows[j][n] - rows[i][n] * rows[j][k] - (i == k and j == n) for k, n in chosen]
        for i, j in chosen
    ]
    return float(np.linalg.det(minors)) if chosen else 1.0


def crossing(orbit: OrbitOnCurve) -> float:
    """Zero where another branch crosses."""
    return orbit.determinant


_TESTS: Final[dict[EventKind, Callable[[OrbitOnCurve], float]]] = {
    EventKind.TOUCH: touch,
    EventKind.FOLD: level,
    EventKind.PERIOD_DOUBLING: flip,
    EventKind.TORUS: pairs,
    EventKind.BRANCH: crossing,
}


class BranchCurve(CycleCurve[OrbitOnCurve]):
    """Periodic orbits of a flow along one parameter."""

    turns = True
    untested: frozenset[EventKind] = frozenset()

    def __init__(
        self,
        flow: Flow,
        scales: FloatArray,
        bounds: tuple[float, float],
        work: Progress = UNWATCHED,
        *,
        touches: bool,
    ) -> None:
        low, high = bounds
        value = float(scales[VALUE])
        super().__init__(scales, (Bound(len(scales) - 1, low / value, high / value),))
        self.orbits = OrbitCurve(flow, scales, work)
        untested = self.untested if touches else {*self.untested, EventKind.TOUCH}
        self.tests = {kind: test for kind, test in _TESTS.items() if kind not in untested}

    def correct(
        self,
        guess: FloatArray,
        near: OrbitOnCurve,
        along: FloatArray,
        tangent: FloatArray | None = None,
    ) -> OrbitOnCurve | None:
        """The orbit near a guess in the plane with the normal `along`: see `Curve`."""
        planes = np.zeros((2, len(guess)))
        planes[0, : len(near.across)], planes[1] = near.across, along
        return self.orbits.solve(guess, planes, tangent)

    def multipliers(self, orbits: Sequence[OrbitOnCurve]) -> NDArray[np.complex128]:
        """Floquet multipliers of orbits by falling size, shape (n, states - 1)."""
        values = np.linalg.eigvals(np.array([orbit.monodromy for orbit in orbits]))
        order = np.argsort(-np.abs(values), axis=1, kind="stable")
        return np.take_along_axis(values.astype(np.complex128), order, axis=1)

    def confirmed(self, kind: EventKind, point: OrbitOnCurve) -> bool:
        """Whether an event is confirmed: a product 1 of real multipliers is no torus."""
        if kind is not EventKind.TORUS:
            return True
        values = point.multipliers
        turning = values[np.abs(values.imag) > _ON_CIRCLE]
        return bool(turning.size and np.abs(np.abs(turning) - 1.0).min() < _ON_CIRCLE)


def makeup(orbit: OrbitOnCurve) -> Makeup:
    """Sticks and order of modes of a cycle on a belt of finite speed."""
    return Makeup(*orbit.extremes[EXTREMES_KEPT:].tolist())


class BeltBranchCurve(BranchCurve):
    """Periodic orbits on a belt of finite speed, whose modes change their order at corners."""

    # With sticks the sign of the determinant depends on the start of the period.
    untested = frozenset({EventKind.BRANCH})

    def multipliers(self, orbits: Sequence[OrbitOnCurve]) -> NDArray[np.complex128]:
        """Multipliers as of `BranchCurve`; with sticks the last one is exactly 0."""
        values = super().multipliers(orbits)
        values[[makeup(orbit).sticks > 0.0 for orbit in orbits], -1] = 0.0
        return values

    def course(self, point: OrbitOnCurve) -> tuple[float, ...]:
        """Number of sticks and reversals, and order of modes."""
        parts = makeup(point)
        return (parts.sticks, parts.reversals, parts.order)

    def change_of_course(self, point: OrbitOnCurve, successor: OrbitOnCurve) -> EventKind:
        """The event between two cycles of different order of modes."""
        before, after = makeup(point), makeup(successor)
        if before.sticks != after.sticks:
            return EventKind.STICK
        reverses = before.reversals != after.reversals
        return EventKind.REVERSE_SLIP if reverses else EventKind.ORDER

    def why_lost(self, point: OrbitOnCurve) -> End:
        """Why the branch cannot be followed beyond the last cycle."""
        parts = makeup(point)
        if parts.least_stick < _NO_LONGER:
            return End.STICK_ENDS
        return End.JUMPS if 0.0 < parts.gap < _NO_LONGER else End.LOST

    def centred(self, point: OrbitOnCurve) -> OrbitOnCurve:
        """The same cycle; with sticks it begins inside the longest, away from its ends."""
        parts = makeup(point)
        if parts.sticks == 0.0 or _INSIDE[0] < parts.start_in_stick < _INSIDE[1]:
            return point
        moved = self.orbits.later(point, parts.middle)
        if moved is None:
            return point
        same_order = makeup(moved).start_in_stick > 0.0 and self.course(moved) == self.course(point)
        return moved if same_order else point


@dataclass(frozen=True, slots=True)
class ParameterLine:
    """A parameter of a system, and the range in which it varies."""

    system: System
    name: str
    bounds: tuple[float, float]
    work: Progress = UNWATCHED

    @property
    def value(self) -> float:
        """The value of the parameter in the system."""
        value: float = getattr(self.system.parameters, self.name)
        return value

    def at(self, value: float) -> "ParameterLine":
        """The line through the system with another value of the parameter."""
        return replace(self, system=self.system.with_values({self.name: value}))

    def curve(self, length: float, period: float) -> BranchCurve:
        """The limit cycles along the line, scaled by a length, a period and about its value."""
        low, high = self.bounds
        value = 2.0 ** math.floor(math.log2(max(abs(self.value), (high - low) / _LEAST_UNIT)))
        flow = SliderBeltFlow(self.system, (self.name,))
        on_belt = self.system.parameters.v_belt is not None
        return (BeltBranchCurve if on_belt else BranchCurve)(
            flow,
            cycle_scales(length, period, value),
            self.bounds,
            self.work,
            touches=self.system.separation,
        )
