"""Following a curve: step control, events on the way, and where it ends."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Generic, NamedTuple, Protocol, TypeVar

import numpy as np

from .arclength import VALUE
from .events import MOST_POINTS, End, EventKind
from .flow import FloatArray

# Distances along the curve are in units of its scales. A step is at most this part of the distance
# from the equilibrium, for a large orbit at most the second, and passes at most the fourth of the
# range of a parameter; it turns the tangent by at most this angle, rad. The last is given up.
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
# Components of the tangent below this are rounding.
_LEVEL: Final = 1e-9
# The bend of the curve is that of the step before unless this was shorter than this part of it.
_BENT: Final = 0.2
# Orbits closer to the curve than this part of a step are on it, and the same if that close.
_NEAR: Final = 0.1
_SAME: Final = 1e-6
# Part of a step to which a change of course is located.
_RESOLVED: Final = 1e-9
# Courses farther apart than this part of the size of a cycle are a jump.
_APART: Final = 1e-3
# Distances from a corner, over the size of its cycle, at which the curve beyond it is sought.
_BEYOND: Final = (1e-3, 1e-2, 1e-4, 0.1)
# Part of a step within which a point that is not found is as good as its neighbour.
_SINGULAR: Final = 1e-7


class PointOnCurve(Protocol):
    """A point of a curve: scaled unknowns, unit tangent, and how many iterations it took."""

    @property
    def unknowns(self) -> FloatArray:
        """Scaled unknowns."""
        ...

    @property
    def tangent(self) -> FloatArray:
        """Unit tangent."""
        ...

    @property
    def iterations(self) -> int:
        """Iterations of Newton's method."""
        ...


P = TypeVar("P", bound=PointOnCurve)


class Bound(NamedTuple):
    """The scaled range of one of the unknowns."""

    place: int
    low: float
    high: float


class Curve(Protocol[P]):
    """A curve that can be followed."""

    @property
    def bounds(self) -> Sequence[Bound]:
        """Ranges in which it is followed."""
        ...

    @property
    def tests(self) -> Mapping[EventKind, Callable[[P], float]]:
        """Functions that change their sign at events."""
        ...

    def correct(
        self, guess: FloatArray, here: P, along: FloatArray, tangent: FloatArray | None = None
    ) -> P | None:
        """The point near a guess in the plane through it with the normal `along`.

        `here` is a point nearby; `tangent` is the direction that the new one is to have, `along` if
        not given. None if there is none.
        """
        ...

    def size(self, point: P) -> float:
        """Scaled distance from where the curve begins and ends, such as the equilibrium."""
        ...

    def features(self, point: P) -> FloatArray:
        """What two points have in common if they are the same."""
        ...

    def confirmed(self, kind: EventKind, point: P) -> bool:
        """Whether an event is what its test looked for."""
        ...


class Courses(NamedTuple, Generic[P]):
    """How a motion may change its course along a curve, so that the curve has corners."""

    of: Callable[[P], object]
    named: Callable[[P, P], EventKind]
    lost: Callable[[P], End]
    centred: Callable[[P], P]


@dataclass(frozen=True, slots=True)
class Followed(Generic[P]):
    """A part of a curve: its points after the first, the events at some of them, and its end."""

    points: tuple[P, ...]
    events: dict[int, EventKind]
    end: End


@dataclass(frozen=True, slots=True)
class _Place(Generic[P]):
    # A point, what the tests say of it, its size, and what makes it known.
    point: P
    values: dict[EventKind, float]
    size: float
    features: FloatArray


def _angle(one: PointOnCurve, other: PointOnCurve) -> float:
    return float(np.arccos(min(max(float(one.tangent @ other.tangent), -1.0), 1.0)))


def _missed_folds(here: _Place[P], there: _Place[P]) -> bool:
    # Whether the parabola through the slopes of the parameter at both ends, and with its mean over
    # the step, has two zeros in between.
    one, other = here.values[EventKind.FOLD], there.values[EventKind.FOLD]
    if not one * other > 0.0:
        return False
    change = there.point.unknowns - here.point.unknowns
    mean = float(change[VALUE]) / float(np.linalg.norm(change))
    sign = np.sign(one)
    one, other, mean = one * sign, other * sign, mean * sign
    bend = 3.0 * (one + other - 2.0 * mean)
    if bend <= 0.0:
        return False
    slope = other - one - bend
    turn = -0.5 * slope / bend
    return bool(0.0 < turn < 1.0 and one - 0.25 * slope * slope / bend < 0.0)


class Follower(Generic[P]):
    """Follows a curve from a point to its end."""

    def __init__(
        self,
        curve: Curve[P],
        nearest: float,
        tell: Callable[[int], None],
        *,
        most: int = MOST_POINTS,
        turns: bool = False,
        courses: Courses[P] | None = None,
    ) -> None:
        self._curve, self._nearest, self._tell, self._most = curve, nearest, tell, most
        self._turns, self._corners = turns, courses is not None
        self._courses = courses or Courses[P](
            lambda _point: None,
            lambda _one, _other: EventKind.ORDER,
            lambda _point: End.LOST,
            lambda point: point,
        )

    def follow(
        self,
        start: P,
        *,
        step: float | None = None,
        until: EventKind | tuple[EventKind, ...] = (),
        at: EventKind | None = None,
    ) -> Followed[P]:
        """Follow the curve from a point, in the direction of its tangent."""
        ends = until if isinstance(until, tuple) else (until,)
        points: list[P] = []
        events: dict[int, EventKind] = {}
        first = here = self._place(start)
        if at is not None:
            here.values[at] = 0.0
        before: _Place[P] | None = None
        step = _PART * here.size if step is None else step
        end = End.BOUND if self._leaves(start) else None
        while end is None:
            self._tell(len(points))
            step = min(step, self._longest(here))
            if step < _SHORTEST:
                turned = self._turned(here) if points else None
                if turned is None:
                    end = self._courses.lost(here.point)
                    continue
                # The curve turns back where the course of motion changes.
                events[len(points) - 1] = self._courses.named(here.point, turned)
                step = float(np.linalg.norm(turned.unknowns - here.point.unknowns))
                points.append(turned)
                before, here = None, self._place(turned)
                continue
            there, event, jumps = self._next(here, before, step, ends)
            if there is None:
                step *= 0.5
                continue
            if points and self._closes(first, here, there):
                there, event, end = first, None, End.CLOSED
            else:
                end = End.JUMPS if jumps else None
                end = end or self._end(here, there, len(points))
            before = here
            if event is not None:
                there.values[event] = 0.0
                events[len(points)] = event
                step *= 0.5
                end = End.EVENT if event in ends else end
            elif there.point.iterations <= _EASY and _angle(here.point, there.point) < 0.5 * _TURN:
                step *= _GROWTH
            here = self._centred(there, event)
            before = before if here is there else None
            points.append(here.point)
        return Followed(tuple(points), events, end)

    def _centred(self, there: _Place[P], event: EventKind | None) -> _Place[P]:
        # A point by unknowns in a good place.
        point = self._courses.centred(there.point)
        if point is there.point:
            return there
        centred = self._place(point)
        if event is not None:
            centred.values[event] = 0.0
        return centred

    def _place(self, point: P) -> _Place[P]:
        values = {kind: test(point) for kind, test in self._curve.tests.items()}
        return _Place(point, values, self._curve.size(point), self._curve.features(point))

    def _leaves(self, start: P) -> bool:
        return any(
            start.unknowns[each.place] == (each.high if start.tangent[each.place] > 0 else each.low)
            for each in self._curve.bounds
        )

    def _longest(self, here: _Place[P]) -> float:
        tangent = here.point.tangent
        return min(
            _PART * here.size,
            max(_LONGEST, _PART_OF_LARGE * here.size),
            *(
                _PART_OF_RANGE * (high - low) / (abs(float(tangent[place])) + _LEVEL)
                for place, low, high in self._curve.bounds
            ),
        )

    def _next(
        self, here: _Place[P], before: _Place[P] | None, step: float, ends: tuple[EventKind, ...]
    ) -> tuple[_Place[P] | None, EventKind | None, bool]:
        # The next point, or the first event before it, and whether the curve ends in a jump there;
        # none if the step is too long.
        one = here.point
        guess = one.unknowns + step * one.tangent
        if before is not None:
            distance = float(np.linalg.norm(one.unknowns - before.point.unknowns))
            if distance > _BENT * step:
                guess += 0.5 * step * step / distance * (one.tangent - before.point.tangent)
        other = self._curve.correct(guess, one, one.tangent)
        if other is None or self._outside(other.unknowns):
            other = self._at_bound(one, guess if other is None else other.unknowns)
        if other is None:
            return None, None, False
        there = self._place(other)
        lost = there.size < _KEPT * here.size
        if self._courses.of(one) != self._courses.of(other):
            return (None, None, False) if lost else self._changed(here, there, ends)
        missed = self._turns and _missed_folds(here, there)
        if lost or missed or _angle(one, other) > _TURN:
            return None, None, False
        try:
            event = self._first_event(here, there, ends)
        except _NotFoundError:
            return None, None, False
        return (there, None, False) if event is None else (self._place(event[1]), event[0], False)

    def _changed(
        self, here: _Place[P], there: _Place[P], ends: tuple[EventKind, ...]
    ) -> tuple[_Place[P] | None, EventKind | None, bool]:
        # The first point of another course, or the first event before it; where motion jumps from
        # one course to the other, the last point of the first.
        one, near, far, of = here.point, here.point, there.point, self._courses.of
        length = float(one.tangent @ (far.unknowns - one.unknowns))
        while (left := float(one.tangent @ (far.unknowns - near.unknowns))) > _RESOLVED * length:
            # Half of the way ahead as the first course goes, so that Newton's method keeps to it.
            way = near.tangent / float(one.tangent @ near.tangent)
            middle = self._curve.correct(near.unknowns + 0.5 * left * way, one, one.tangent)
            if middle is None:
                return None, None, False
            if of(middle) == of(one):
                near = middle
            else:
                far = middle
        last = self._place(near)
        try:
            event = self._first_event(here, last, ends)
        except _NotFoundError:
            return None, None, False
        if event is not None:
            return self._place(event[1]), event[0], False
        if float(np.linalg.norm(far.unknowns - near.unknowns)) > _APART * here.size:
            return last, None, True
        return self._place(far), self._courses.named(one, far), False

    def _turned(self, corner: _Place[P]) -> P | None:
        # A point beyond a corner at which a curve turns back with another course: on the other side
        # of it as the curve comes.
        if not self._corners:
            return None
        at, place = corner.point, self._curve.bounds[0].place
        normal = np.eye(len(at.unknowns))[place]
        for distance in _BEYOND:
            away = distance * corner.size * at.tangent
            away[place] = -away[place]
            found = self._curve.correct(at.unknowns + away, at, normal, away)
            if found is not None and self._courses.of(found) != self._courses.of(at):
                return found
        return None

    def _outside(self, unknowns: FloatArray) -> bool:
        return not all(low <= unknowns[place] <= high for place, low, high in self._curve.bounds)

    def _end(self, here: _Place[P], there: _Place[P], before: int) -> End | None:
        unknowns = there.point.unknowns
        if not all(low < unknowns[place] < high for place, low, high in self._curve.bounds):
            return End.BOUND
        if there.size < min(self._nearest, here.size):
            return End.EQUILIBRIUM
        if there.size > _LARGEST:
            return End.UNBOUNDED
        return End.LONG if before + 1 >= self._most else None

    def _at_bound(self, here: P, target: FloatArray) -> P | None:
        # The point at the first bound between a point and the unknowns of one beyond it.
        change = target - here.unknowns
        reached = []
        for place, low, high in self._curve.bounds:
            bound = high if change[place] > 0.0 else low
            if (here.unknowns[place] - bound) * (target[place] - bound) < 0.0:
                reached.append(((bound - here.unknowns[place]) / change[place], place, bound))
        if not reached:
            return None
        share, place, bound = min(reached)
        guess = here.unknowns + change * share
        guess[place] = bound
        return self._curve.correct(guess, here, np.eye(len(guess))[place], here.tangent)

    def _first_event(
        self, here: _Place[P], there: _Place[P], ends: tuple[EventKind, ...]
    ) -> tuple[EventKind, P] | None:
        # Those at which to end must be located.
        found: list[tuple[float, EventKind, P]] = []
        for kind, test in self._curve.tests.items():
            if here.values[kind] * there.values[kind] < 0.0:
                located = self._locate(here.point, there.point, test, here.values[kind])
                if located is None and kind in ends:
                    raise _NotFoundError
                if located is not None and self._curve.confirmed(kind, located[1]):
                    found.append((located[0], kind, located[1]))
        if not found:
            return None
        found.sort(key=lambda one: one[0])
        _, kind, point = found[0]
        for _, other, place in found[1:]:
            # Where two are as near as rounding, one that has been passed at the first comes first.
            if here.values[other] * self._curve.tests[other](point) < 0.0:
                kind, point = other, place
        return kind, point

    def _locate(
        self, here: P, there: P, test: Callable[[P], float], begin: float
    ) -> tuple[float, P] | None:
        # The point at which a test is zero, and its distance along the tangent.
        from scipy.optimize import brentq

        step = float(here.tangent @ (there.unknowns - here.unknowns))
        points = {0.0: here, step: there}

        def value(at: float) -> float:
            if at == 0.0:
                return begin
            if at not in points:
                low = max(one for one in points if one < at)
                high = min(one for one in points if one > at)
                guess = _between(points[low], points[high], here.tangent, (at - low) / (high - low))
                point = self._curve.correct(guess, here, here.tangent)
                nearest = low if at - low < high - at else high
                if point is None and abs(at - nearest) > _SINGULAR * step:
                    raise _NotFoundError
                if point is None:
                    # At a branch point itself the equations are singular.
                    points[at] = points[nearest]
                    return 0.0
                points[at] = point
            return test(points[at])

        try:
            place = float(brentq(value, 0.0, step, xtol=1e-14 * step + 1e-15, rtol=1e-14))
        except _NotFoundError:
            return None
        value(place)
        return place, points[place]

    def _closes(self, start: _Place[P], here: _Place[P], there: _Place[P]) -> bool:
        # Whether the curve passes the point that it began with, in the same direction.
        first, one, other = start.features, here.features, there.features
        way = other - one
        length = float(np.linalg.norm(way))
        share = float((first - one) @ way) / (length * length) if length > 0.0 else -1.0
        if not 0.0 < share <= 1.0:
            return False
        if float(np.linalg.norm(first - one - share * way)) > _NEAR * length:
            return False
        place = self._curve.bounds[0].place
        guess = here.point.unknowns + share * (there.point.unknowns - here.point.unknowns)
        guess[place] = start.point.unknowns[place]
        normal = np.eye(len(guess))[place]
        found = self._curve.correct(guess, here.point, normal, here.point.tangent)
        return found is not None and bool(
            np.abs(self._curve.features(found) - first).max() < _SAME * np.abs(first).max()
        )


def _between(one: PointOnCurve, other: PointOnCurve, along: FloatArray, share: float) -> FloatArray:
    # The cubic through two points with their tangents, at a share of the way along a direction.
    change = other.unknowns - one.unknowns
    length = float(along @ change)
    begin, end = (each.tangent * (length / float(along @ each.tangent)) for each in (one, other))
    left = 1.0 - share
    bend = share * left * (left * (begin - change) - share * (end - change))
    guess: FloatArray = one.unknowns + share * change + bend
    return guess


class _NotFoundError(Exception):
    """No point was found where an event is looked for."""
