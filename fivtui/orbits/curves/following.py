"""Following a curve of periodic orbits: step control, events on the way, and where it ends."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

import numpy as np

from .arclength import VALUE, FloatArray, OrbitCurve, OrbitOnCurve

MOST_POINTS: Final = 2000
# Distances along the curve are in units of its scales. A step is at most this part of the distance
# from the equilibrium, for a large orbit at most the second, and passes at most the fourth of the
# range of the parameter; it turns the tangent by at most this angle, rad. The last is given up.
_PART: Final = 0.4
_PART_OF_LARGE: Final = 0.1
_LONGEST: Final = 0.25
_PART_OF_RANGE: Final = 0.02
_TURN: Final = 0.25
_SHORTEST: Final = 1e-9
# Orbits this far from the equilibrium are as good as unbounded.
_LARGEST: Final = 1e4
_GROWTH: Final = 1.5
_EASY: Final = 4
# The part of its distance from the equilibrium that an orbit may lose in a step.
_KEPT: Final = 0.3
# Derivatives of the parameter along the curve below this are rounding.
_LEVEL: Final = 1e-9
# Orbits closer to the curve than this part of a step are on it, and the same if that close.
_NEAR: Final = 0.1
_SAME: Final = 1e-6
_ON_CIRCLE: Final = 1e-6


class EventKind(StrEnum):
    """What happens at a point of a branch."""

    HOPF = "hopf"
    TOUCH = "touch"
    FOLD = "fold"
    PERIOD_DOUBLING = "period-doubling"
    TORUS = "torus"
    BRANCH = "branch"


class End(StrEnum):
    """Why a branch ends."""

    EQUILIBRIUM = "returns to the equilibrium"
    BOUND = "leaves the range"
    CLOSED = "is closed"
    UNBOUNDED = "grows without bounds"
    LOST = "cannot be followed farther"
    LONG = f"has more than {MOST_POINTS} points"


@dataclass(frozen=True, slots=True)
class Followed:
    """A part of a branch: its orbits after the first, the events at some of them, and its end."""

    orbits: tuple[OrbitOnCurve, ...]
    events: dict[int, EventKind]
    end: End


_Test = Callable[[OrbitOnCurve], float]


def _touch(orbit: OrbitOnCurve) -> float:
    # Zero where the highest or the lowest point is at y = 0; positive if the cycle crosses it.
    low, high = orbit.flow.extremes[2:4].tolist()
    return float(-low * high)


def _level(orbit: OrbitOnCurve) -> float:
    change = float(orbit.tangent[VALUE])
    return change if abs(change) > _LEVEL else 0.0


def _flip(orbit: OrbitOnCurve) -> float:
    return float(np.linalg.det(orbit.monodromy + np.eye(3)))


def _pairs(orbit: OrbitOnCurve) -> float:
    # Zero where the product of two multipliers is 1.
    one, two, three = np.linalg.eigvals(orbit.monodromy).tolist()
    return float(((one * two - 1.0) * (one * three - 1.0) * (two * three - 1.0)).real)


_TESTS: Final[dict[EventKind, _Test]] = {
    EventKind.TOUCH: _touch,
    EventKind.FOLD: _level,
    EventKind.PERIOD_DOUBLING: _flip,
    EventKind.TORUS: _pairs,
    EventKind.BRANCH: lambda orbit: orbit.determinant,
}


@dataclass(frozen=True, slots=True)
class _Place:
    # An orbit, what the tests say of it, and its scaled distance from the equilibrium.
    orbit: OrbitOnCurve
    values: dict[EventKind, float]
    distance: float


def _angle(one: _Place, other: _Place) -> float:
    return float(np.arccos(np.clip(one.orbit.tangent @ other.orbit.tangent, -1.0, 1.0)))


def _missed_folds(here: _Place, there: _Place) -> bool:
    # Whether the parabola through the slopes of the parameter at both ends, and with its mean over
    # the step, has two zeros in between.
    one, other = here.values[EventKind.FOLD], there.values[EventKind.FOLD]
    if not one * other > 0.0:
        return False
    change = there.orbit.unknowns - here.orbit.unknowns
    mean = float(change[VALUE]) / float(np.linalg.norm(change))
    sign = np.sign(one)
    one, other, mean = one * sign, other * sign, mean * sign
    bend = 3.0 * (one + other - 2.0 * mean)
    if bend <= 0.0:
        return False
    slope = other - one - bend
    turn = -0.5 * slope / bend
    return bool(0.0 < turn < 1.0 and one - 0.25 * slope * slope / bend < 0.0)


class Follower:
    """Follows a curve from an orbit to its end.

    Parameters
    ----------
    curve : OrbitCurve
        The curve.
    low, high : float
        Bounds of the parameter, scaled.
    nearest : float
        Scaled distance from the equilibrium at which the branch has returned to it.
    tell : callable
        Called with the number of points after every step.
    touches : bool
        Whether y = 0 means anything: whether separation is considered.
    """

    def __init__(
        self,
        curve: OrbitCurve,
        low: float,
        high: float,
        nearest: float,
        tell: Callable[[int], None],
        *,
        touches: bool,
    ) -> None:
        self._curve, self._low, self._high, self._nearest = curve, low, high, nearest
        self._tell = tell
        self._tests = {
            kind: test for kind, test in _TESTS.items() if touches or kind is not EventKind.TOUCH
        }

    def follow(self, start: OrbitOnCurve) -> Followed:
        """Follow the curve from an orbit, in the direction of its tangent."""
        orbits: list[OrbitOnCurve] = []
        events: dict[int, EventKind] = {}
        here = self._place(start)
        step = _PART * here.distance
        outward = self._high if start.tangent[VALUE] > 0.0 else self._low
        end = End.BOUND if start.unknowns[VALUE] == outward else None
        while end is None:
            self._tell(len(orbits))
            step = min(step, self._longest(here))
            if step < _SHORTEST:
                end = End.LOST
                continue
            there, event = self._next(here, step)
            if there is None:
                step *= 0.5
                continue
            if orbits and self._closes(start, here.orbit, there.orbit):
                there, event, end = self._place(start), None, End.CLOSED
            else:
                end = self._end(here, there, len(orbits))
            if event is not None:
                there.values[event] = 0.0
                events[len(orbits)] = event
                step *= 0.5
            elif there.orbit.iterations <= _EASY and _angle(here, there) < 0.5 * _TURN:
                step *= _GROWTH
            orbits.append(there.orbit)
            here = there
        return Followed(tuple(orbits), events, end)

    def _place(self, orbit: OrbitOnCurve) -> _Place:
        values = {kind: test(orbit) for kind, test in self._tests.items()}
        return _Place(orbit, values, self._curve.from_rest(orbit.unknowns))

    def _longest(self, here: _Place) -> float:
        level = abs(float(here.orbit.tangent[VALUE])) + _LEVEL
        return min(
            _PART * here.distance,
            max(_LONGEST, _PART_OF_LARGE * here.distance),
            _PART_OF_RANGE * (self._high - self._low) / level,
        )

    def _next(self, here: _Place, step: float) -> tuple[_Place | None, EventKind | None]:
        # The next orbit, or the first event before it; no orbit if the step is too long.
        guess = here.orbit.unknowns + step * here.orbit.tangent
        orbit = self._curve.solve(guess, here.orbit.across, here.orbit.tangent)
        if orbit is None or not self._low <= orbit.unknowns[VALUE] <= self._high:
            orbit = self._at_bound(here.orbit, guess if orbit is None else orbit.unknowns)
        if orbit is None:
            return None, None
        there = self._place(orbit)
        lost = there.distance < _KEPT * here.distance
        if lost or _angle(here, there) > _TURN or _missed_folds(here, there):
            return None, None
        event = self._first_event(here, there)
        return (there, None) if event is None else (self._place(event[1]), event[0])

    def _end(self, here: _Place, there: _Place, before: int) -> End | None:
        if not self._low < there.orbit.unknowns[VALUE] < self._high:
            return End.BOUND
        if there.distance < min(self._nearest, here.distance):
            return End.EQUILIBRIUM
        if there.distance > _LARGEST:
            return End.UNBOUNDED
        return End.LONG if before + 1 >= MOST_POINTS else None

    def _at_bound(self, here: OrbitOnCurve, target: FloatArray) -> OrbitOnCurve | None:
        # The orbit at the bound between an orbit and the unknowns of one beyond it.
        change = target - here.unknowns
        bound = self._high if change[VALUE] > 0.0 else self._low
        if not (here.unknowns[VALUE] - bound) * (target[VALUE] - bound) < 0.0:
            return None
        guess = here.unknowns + change * (bound - here.unknowns[VALUE]) / change[VALUE]
        guess[VALUE] = bound
        return self._curve.solve(guess, here.across, np.eye(6)[VALUE], here.tangent)

    def _first_event(self, here: _Place, there: _Place) -> tuple[EventKind, OrbitOnCurve] | None:
        found: list[tuple[float, EventKind, OrbitOnCurve]] = []
        for kind, test in self._tests.items():
            if here.values[kind] * there.values[kind] < 0.0:
                located = self._locate(here.orbit, there.orbit, test, here.values[kind])
                if located is not None and _confirmed(kind, located[1]):
                    found.append((located[0], kind, located[1]))
        if not found:
            return None
        _, kind, orbit = min(found, key=lambda one: one[0])
        return kind, orbit

    def _locate(
        self, here: OrbitOnCurve, there: OrbitOnCurve, test: _Test, begin: float
    ) -> tuple[float, OrbitOnCurve] | None:
        # The orbit at which a test is zero, and its distance along the tangent.
        from scipy.optimize import brentq

        step = float(here.tangent @ (there.unknowns - here.unknowns))
        orbits = {0.0: here, step: there}

        def value(at: float) -> float:
            if at == 0.0:
                return begin
            if at not in orbits:
                low = max(one for one in orbits if one < at)
                high = min(one for one in orbits if one > at)
                share = (at - low) / (high - low)
                ends = orbits[low].unknowns, orbits[high].unknowns
                guess = ends[0] + share * (ends[1] - ends[0])
                orbit = self._curve.solve(guess, here.across, here.tangent)
                if orbit is None:
                    raise _NotFoundError
                orbits[at] = orbit
            return test(orbits[at])

        try:
            place = float(brentq(value, 0.0, step, xtol=1e-14 * step + 1e-15, rtol=1e-14))
        except _NotFoundError:
            return None
        value(place)
        return place, orbits[place]

    def _closes(self, start: OrbitOnCurve, here: OrbitOnCurve, there: OrbitOnCurve) -> bool:
        # Whether the branch passes the orbit that it began with, in the same direction.
        first, one, other = (self._features(orbit) for orbit in (start, here, there))
        way = other - one
        length = float(np.linalg.norm(way))
        share = float((first - one) @ way) / (length * length) if length > 0.0 else -1.0
        if not 0.0 < share <= 1.0:
            return False
        if float(np.linalg.norm(first - one - share * way)) > _NEAR * length:
            return False
        guess = here.unknowns + share * (there.unknowns - here.unknowns)
        guess[VALUE] = start.unknowns[VALUE]
        found = self._curve.solve(guess, here.across, np.eye(6)[VALUE], here.tangent)
        return found is not None and bool(
            np.abs(self._features(found) - first).max() < _SAME * np.abs(first).max()
        )

    def _features(self, orbit: OrbitOnCurve) -> FloatArray:
        # What does not depend on the phase.
        extremes = orbit.flow.extremes[:4] / self._curve.scales[[0, 0, 2, 2]]
        return np.concatenate([orbit.unknowns[4:], extremes])


class _NotFoundError(Exception):
    """No orbit was found where an event is looked for."""


def _confirmed(kind: EventKind, orbit: OrbitOnCurve) -> bool:
    # A product of two real multipliers that is 1 is no torus.
    if kind is not EventKind.TORUS:
        return True
    values = orbit.multipliers
    turning = values[np.abs(values.imag) > _ON_CIRCLE]
    return bool(turning.size and np.abs(np.abs(turning) - 1.0).min() < _ON_CIRCLE)
