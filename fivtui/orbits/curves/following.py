"""Following a curve: step control, location of events, and ends."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Generic, NamedTuple, Self, TypeVar

import numpy as np

from .events import MOST_POINTS, End, EventKind
from .flow import FloatArray

# Limits of a step along the curve, in units of its scales: relative to the distance from the
# equilibrium, the same for large orbits, and the least value of the latter. Then the part of a
# parameter's range, the turn of the tangent in rad, and the step below which following ends.
_PART: Final = 0.4
_PART_OF_LARGE: Final = 0.1
_LONGEST: Final = 0.25
_PART_OF_RANGE: Final = 0.02
_TURN: Final = 0.25
_SHORTEST: Final = 1e-9
# Distance from the equilibrium beyond which orbits count as unbounded.
_LARGEST: Final = 1e4
_GROWTH: Final = 1.5
_EASY: Final = 4
# Least ratio of the distances from the equilibrium after and before a step.
_SHRUNK: Final = 0.3
# Components of the tangent below this are rounding.
_LEVEL: Final = 1e-9
# Length of the previous step, relative to the present, above which it gives the bend of the curve.
_BENT: Final = 0.2
# Distance from the curve, relative to a step, below which it may close, and relative tolerance of
# equal points.
_CLOSING_DISTANCE: Final = 0.1
_EQUAL_POINTS: Final = 1e-6
# Accuracy of a change of course, relative to a step.
_RESOLVED: Final = 1e-9
# Distance of two courses, relative to the size of the cycle, above which motion jumps.
_JUMP: Final = 1e-3
# Distances from a corner, relative to the size of its cycle, to search for the curve beyond it.
_CORNER_DISTANCES: Final = (1e-3, 1e-2, 1e-4, 0.1)
# Distance, relative to a step, within which a neighbour replaces a point of singular equations.
_SINGULAR: Final = 1e-7


@dataclass(frozen=True, slots=True)
class PointOnCurve:
    """A point of a curve: scaled unknowns, unit tangent, and iterations of Newton's method."""

    unknowns: FloatArray
    tangent: FloatArray
    iterations: int

    def reversed(self) -> Self:
        """The same point with the tangent the other way."""
        return replace(self, tangent=-self.tangent)


P = TypeVar("P", bound=PointOnCurve)


class Bound(NamedTuple):
    """The scaled range of one of the unknowns."""

    unknown: int
    low: float
    high: float


class Curve(ABC, Generic[P]):
    """A curve that can be followed.

    `tests` are functions that change their sign at events. A change of course, such as of the order
    of modes, is a corner of the curve; most curves have one course. If `turns`, the first parameter
    may turn back twice within a step.
    """

    bounds: Sequence[Bound]
    tests: Mapping[EventKind, Callable[[P], float]]
    turns = False

    @abstractmethod
    def correct(
        self, guess: FloatArray, near: P, along: FloatArray, tangent: FloatArray | None = None
    ) -> P | None:
        """The point near a guess in the plane through it with the normal `along`.

        `near` is a point nearby. `tangent` gives the direction of the new tangent; the default is
        `along`. None without such a point.
        """

    def size(self, point: P) -> float:  # noqa: ARG002
        """Scaled distance from the end of the curve, such as the equilibrium."""
        return 1.0

    def features(self, point: P) -> FloatArray:
        """Quantities that are equal if and only if two points are the same."""
        return point.unknowns

    def confirmed(self, kind: EventKind, point: P) -> bool:  # noqa: ARG002
        """Whether a zero of a test is an event of its kind."""
        return True

    def course(self, point: P) -> object:  # noqa: ARG002
        """The course of motion, which changes at corners of the curve."""
        return None

    def change_of_course(self, point: P, successor: P) -> EventKind:  # noqa: ARG002
        """The event between two points of different courses."""
        return EventKind.ORDER

    def why_lost(self, point: P) -> End:  # noqa: ARG002
        """Why the curve cannot be followed beyond its last point."""
        return End.LOST

    def centred(self, point: P) -> P:
        """The same point with unknowns that suit the next steps best."""
        return point


@dataclass(frozen=True, slots=True)
class Followed(Generic[P]):
    """A part of a curve: its points after the first, its events by index, and its end."""

    points: tuple[P, ...]
    events: dict[int, EventKind]
    end: End


@dataclass(frozen=True, slots=True)
class WholeCurve(Generic[P]):
    """A curve from end to end: its points, its events by index, and its ends."""

    points: tuple[P, ...]
    events: dict[int, EventKind]
    ends: tuple[End, End]


def follow_both_ways(
    follow: Callable[[P], Followed[P]], start: P, begins: End | None = None
) -> WholeCurve[P]:
    """The curve through a point; `begins` is its end at the point if it begins there."""
    ahead = follow(start)
    if begins is None and ahead.end is End.CLOSED:
        begins = End.CLOSED
    back = follow(start.reversed()) if begins is None else Followed((), {}, begins)
    count = len(back.points)
    events = {count - 1 - index: kind for index, kind in back.events.items()}
    events |= {count + 1 + index: kind for index, kind in ahead.events.items()}
    points = (*back.points[::-1], start, *ahead.points)
    return WholeCurve(points, dict(sorted(events.items())), (back.end, ahead.end))


@dataclass(frozen=True, slots=True)
class _Node(Generic[P]):
    # A point, the values of the tests, its size and features.
    point: P
    values: dict[EventKind, float]
    size: float
    features: FloatArray


class _NotFoundError(Exception):
    """No point was found: the step is too long."""


def _angle(first: PointOnCurve, second: PointOnCurve) -> float:
    return float(np.arccos(min(max(float(first.tangent @ second.tangent), -1.0), 1.0)))


class Follower(Generic[P]):
    """Follows a curve from a point to its end."""

    def __init__(
        self,
        curve: Curve[P],
        nearest: float = 0.0,
        report: Callable[[int], None] = lambda _count: None,
        *,
        max_points: int = MOST_POINTS,
    ) -> None:
        self._curve, self._nearest = curve, nearest
        self._report, self._max_points = report, max_points
        # Index of the first parameter among the unknowns.
        self._first = curve.bounds[0].unknown

    def follow(
        self,
        start: P,
        *,
        step: float | None = None,
        until: tuple[EventKind, ...] = (),
        at: EventKind | None = None,
    ) -> Followed[P]:
        """Follow the curve from a point, in the direction of its tangent, to an event of `until`.

        `at` is the event at the start itself.
        """
        points: list[P] = []
        events: dict[int, EventKind] = {}
        first = node = self._node(start, at)
        previous: _Node[P] | None = None
        step = _PART * node.size if step is None else step
        end = End.BOUND if self._starts_at_bound(start) else None
        while end is None:
            self._report(len(points))
            step = min(step, self._longest_step(node))
            if step < _SHORTEST:
                turned = self._point_beyond_corner(node) if points else None
                if turned is None:
                    end = self._curve.why_lost(node.point)
                    continue
                # At a change of course the curve turns back.
                events[len(points) - 1] = self._curve.change_of_course(node.point, turned)
                step = float(np.linalg.norm(turned.unknowns - node.point.unknowns))
                points.append(turned)
                previous, node = None, self._node(turned)
                continue
            try:
                successor, event, end = self._next_node(node, previous, step, until)
            except _NotFoundError:
                step *= 0.5
                continue
            if points and self._closes(first, node, successor):
                successor, event, end = first, None, End.CLOSED
            else:
                end = end or self._end(node, successor, len(points))
            if event is not None:
                events[len(points)] = event
                step *= 0.5
                end = End.EVENT if event in until else end
            elif (
                successor.point.iterations <= _EASY
                and _angle(node.point, successor.point) < 0.5 * _TURN
            ):
                step *= _GROWTH
            centred = self._curve.centred(successor.point)
            previous = node if centred is successor.point else None
            node = self._node(centred) if previous is None else successor
            if event is not None:
                node.values[event] = 0.0
            points.append(node.point)
        return Followed(tuple(points), events, end)

    def events_both_ways(self, start: P, kind: EventKind, step: float | None = None) -> list[P]:
        """The first points with a kind of event, ahead of a point and behind it."""
        parts = (
            self.follow(point, step=step, until=(kind,)) for point in (start, start.reversed())
        )
        return [part.points[-1] for part in parts if part.end is End.EVENT]

    def _node(self, point: P, event: EventKind | None = None) -> _Node[P]:
        values = {kind: test(point) for kind, test in self._curve.tests.items()}
        if event is not None:
            values[event] = 0.0
        return _Node(point, values, self._curve.size(point), self._curve.features(point))

    def _starts_at_bound(self, start: P) -> bool:
        return any(
            start.unknowns[index] == (high if start.tangent[index] > 0 else low)
            for index, low, high in self._curve.bounds
        )

    def _longest_step(self, node: _Node[P]) -> float:
        tangent = node.point.tangent
        return min(
            _PART * node.size,
            max(_LONGEST, _PART_OF_LARGE * node.size),
            *(
                _PART_OF_RANGE * (high - low) / (abs(float(tangent[index])) + _LEVEL)
                for index, low, high in self._curve.bounds
            ),
        )

    def _next_node(
        self,
        node: _Node[P],
        previous: _Node[P] | None,
        step: float,
        until: tuple[EventKind, ...],
    ) -> tuple[_Node[P], EventKind | None, End | None]:
        # The next point, or the first event before it, and the end if the curve ends in a jump.
        point = node.point
        guess = point.unknowns + step * point.tangent
        if previous is not None:
            distance = float(np.linalg.norm(point.unknowns - previous.point.unknowns))
            if distance > _BENT * step:
                bend = point.tangent - previous.point.tangent
                guess += 0.5 * step * step / distance * bend
        target = self._curve.correct(guess, point, point.tangent)
        if target is None or self._outside(target.unknowns):
            target = self._at_bound(point, guess if target is None else target.unknowns)
        if target is None:
            raise _NotFoundError
        successor = self._node(target)
        if successor.size < _SHRUNK * node.size:
            raise _NotFoundError
        if self._curve.course(point) != self._curve.course(target):
            return self._find_change_of_course(node, target, until)
        if _angle(point, target) > _TURN or (
            self._curve.turns and self._hides_folds(node, successor)
        ):
            raise _NotFoundError
        return *self._up_to_event(node, successor, until), None

    def _hides_folds(self, node: _Node[P], successor: _Node[P]) -> bool:
        # Whether the slope of the parameter has two zeros in the step, by the parabola with the
        # slopes at both ends and the mean slope.
        begin, end = node.values[EventKind.FOLD], successor.values[EventKind.FOLD]
        if not begin * end > 0.0:
            return False
        change = successor.point.unknowns - node.point.unknowns
        sign = np.sign(begin)
        mean = sign * float(change[self._first]) / float(np.linalg.norm(change))
        begin, end = begin * sign, end * sign
        bend = 3.0 * (begin + end - 2.0 * mean)
        if bend <= 0.0:
            return False
        slope = end - begin - bend
        turn = -0.5 * slope / bend
        return bool(0.0 < turn < 1.0 and begin - 0.25 * slope * slope / bend < 0.0)

    def _find_change_of_course(
        self, node: _Node[P], far: P, until: tuple[EventKind, ...]
    ) -> tuple[_Node[P], EventKind | None, End | None]:
        # The first point of the new course, or the first event before it; if motion jumps between
        # courses, the last point of the old course.
        point, course = node.point, self._curve.course
        near = point
        length = float(point.tangent @ (far.unknowns - point.unknowns))
        while (gap := float(point.tangent @ (far.unknowns - near.unknowns))) > _RESOLVED * length:
            # Bisect along the first course, so that Newton's method stays on it.
            direction = near.tangent / float(point.tangent @ near.tangent)
            middle = self._curve.correct(
                near.unknowns + 0.5 * gap * direction, point, point.tangent
            )
            if middle is None:
                raise _NotFoundError
            if course(middle) == course(point):
                near = middle
            else:
                far = middle
        node_before, event = self._up_to_event(node, self._node(near), until)
        if event is not None:
            return node_before, event, None
        if float(np.linalg.norm(far.unknowns - near.unknowns)) > _JUMP * node.size:
            return node_before, None, End.JUMPS
        return self._node(far), self._curve.change_of_course(point, far), None

    def _point_beyond_corner(self, corner: _Node[P]) -> P | None:
        # A point of a different course beyond a corner at which the curve turns back in the first
        # parameter.
        point, course = corner.point, self._curve.course
        normal = np.eye(len(point.unknowns))[self._first]
        for distance in _CORNER_DISTANCES:
            away = distance * corner.size * point.tangent
            away[self._first] = -away[self._first]
            beyond = self._curve.correct(point.unknowns + away, point, normal, away)
            if beyond is not None and course(beyond) != course(point):
                return beyond
        return None

    def _outside(self, unknowns: FloatArray) -> bool:
        return not all(low <= unknowns[index] <= high for index, low, high in self._curve.bounds)

    def _end(self, node: _Node[P], successor: _Node[P], count: int) -> End | None:
        unknowns = successor.point.unknowns
        if not all(low < unknowns[index] < high for index, low, high in self._curve.bounds):
            return End.BOUND
        if successor.size < min(self._nearest, node.size):
            return End.EQUILIBRIUM
        if successor.size > _LARGEST:
            return End.UNBOUNDED
        return End.LONG if count + 1 >= self._max_points else None

    def _at_bound(self, point: P, target: FloatArray) -> P | None:
        # The point at the first bound between a point and a target beyond the bounds.
        change = target - point.unknowns
        reached = []
        for index, low, high in self._curve.bounds:
            bound = high if change[index] > 0.0 else low
            if (point.unknowns[index] - bound) * (target[index] - bound) < 0.0:
                reached.append(((bound - point.unknowns[index]) / change[index], index, bound))
        if not reached:
            return None
        share, index, bound = min(reached)
        guess = point.unknowns + change * share
        guess[index] = bound
        return self._curve.correct(guess, point, np.eye(len(guess))[index], point.tangent)

    def _up_to_event(
        self, node: _Node[P], successor: _Node[P], until: tuple[EventKind, ...]
    ) -> tuple[_Node[P], EventKind | None]:
        # The next point, or the first event before it. Events of `until` must be located.
        events: list[tuple[float, EventKind, P]] = []
        for kind, test in self._curve.tests.items():
            if node.values[kind] * successor.values[kind] < 0.0:
                try:
                    distance, point = self._locate(
                        node.point, successor.point, test, node.values[kind]
                    )
                except _NotFoundError:
                    if kind in until:
                        raise
                    continue
                if self._curve.confirmed(kind, point):
                    events.append((distance, kind, point))
        if not events:
            return successor, None
        events.sort(key=lambda event: event[0])
        _, first, at = events[0]
        for _, kind, point in events[1:]:
            # Rounding may swap close events: an event that lies before the first one replaces it.
            if node.values[kind] * self._curve.tests[kind](at) < 0.0:
                first, at = kind, point
        return self._node(at), first

    def _locate(
        self, begin: P, end: P, test: Callable[[P], float], value_at_begin: float
    ) -> tuple[float, P]:
        # The point at which a test is zero, and its distance along the tangent.
        from scipy.optimize import brentq

        along = begin.tangent
        step = float(along @ (end.unknowns - begin.unknowns))
        points = {0.0: begin, step: end}

        def value(at: float) -> float:
            if at == 0.0:
                return value_at_begin
            if at not in points:
                low = max(distance for distance in points if distance < at)
                high = min(distance for distance in points if distance > at)
                guess = _between(points[low], points[high], along, (at - low) / (high - low))
                point = self._curve.correct(guess, begin, along)
                nearest = low if at - low < high - at else high
                if point is None and abs(at - nearest) > _SINGULAR * step:
                    raise _NotFoundError
                if point is None:
                    # The equations are singular at a branch point.
                    points[at] = points[nearest]
                    return 0.0
                points[at] = point
            return test(points[at])

        zero = float(brentq(value, 0.0, step, xtol=1e-14 * step + 1e-15, rtol=1e-14))
        value(zero)
        return zero, points[zero]

    def _closes(self, start: _Node[P], node: _Node[P], successor: _Node[P]) -> bool:
        # Whether the step passes the first point of the curve in the same direction.
        first, begin = start.features, node.features
        chord = successor.features - begin
        length = float(np.linalg.norm(chord))
        share = float((first - begin) @ chord) / (length * length) if length > 0.0 else -1.0
        if not 0.0 < share <= 1.0:
            return False
        if float(np.linalg.norm(first - begin - share * chord)) > _CLOSING_DISTANCE * length:
            return False
        point = node.point
        guess = point.unknowns + share * (successor.point.unknowns - point.unknowns)
        guess[self._first] = start.point.unknowns[self._first]
        normal = np.eye(len(guess))[self._first]
        passed = self._curve.correct(guess, point, normal, point.tangent)
        return passed is not None and bool(
            np.abs(self._curve.features(passed) - first).max() < _EQUAL_POINTS * np.abs(first).max()
        )


def _between(
    first: PointOnCurve, second: PointOnCurve, along: FloatArray, share: float
) -> FloatArray:
    # The cubic through two points with their tangents, at a share of the distance along `along`.
    change = second.unknowns - first.unknowns
    length = float(along @ change)
    begin, end = (
        point.tangent * (length / float(along @ point.tangent)) for point in (first, second)
    )
    rest = 1.0 - share
    bend = share * rest * (rest * (begin - change) - share * (end - change))
    guess: FloatArray = first.unknowns + share * change + bend
    return guess
