"""Following a curve of solutions: step control, location of events, and ends.

Lengths and sizes are those of the scaled unknowns of a point.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Generic, NamedTuple, Self, TypeVar

import numpy as np

from .events import MAX_POINTS, End, EventKind
from .flow import FloatArray

# Upper bound of a step, relative to the size of its first point, and a lower one for steps that are
# longer than `_LARGE_STEP`.
_STEP_PER_SIZE: Final = 0.4
_STEP_PER_LARGE_SIZE: Final = 0.1
_LARGE_STEP: Final = 0.25
# Upper bounds of the part of a parameter's range in a step, and of the turn of the tangent, rad.
_STEP_PER_RANGE: Final = 0.02
_MAX_TURN: Final = 0.25
# Step length below which following ends, and size above which orbits count as unbounded.
_MIN_STEP: Final = 1e-9
_MAX_SIZE: Final = 1e4
# Growth of the step length after few iterations of Newton's method.
_STEP_GROWTH: Final = 1.5
_FEW_ITERATIONS: Final = 4
# Least ratio of the sizes after and before a step.
_MIN_SIZE_RATIO: Final = 0.3
# Added to a component of a tangent, so that it can divide.
_TANGENT_ROUNDING: Final = 1e-9
# Least length of the previous step, relative to the present one, for quadratic extrapolation.
_MIN_PREVIOUS_STEP: Final = 0.2
# A curve may close if its first point is within this distance of a step, relative to the step.
_CLOSING_DISTANCE: Final = 0.1
# It closes if a point on the step equals the first one within this relative tolerance.
_SAME_POINT: Final = 1e-6
# Accuracy of the location of a change of pattern, relative to a step.
_RESOLUTION: Final = 1e-9
# Distance between points of two patterns, relative to their size, above which the motion jumps.
_JUMP_DISTANCE: Final = 1e-3
# Distances from a corner, relative to the size of its cycle, at which the curve may continue.
_CORNER_DISTANCES: Final = (1e-3, 1e-2, 1e-4, 0.1)
# Where the equations are singular, an event is located at the nearest known point if it is within
# this distance, relative to the step.
_SINGULAR_DISTANCE: Final = 1e-7


@dataclass(frozen=True, slots=True)
class PointOnCurve:
    """A point of a curve: scaled unknowns, unit tangent, and iterations of Newton's method."""

    unknowns: FloatArray
    tangent: FloatArray
    iterations: int

    def reversed(self) -> Self:
        """The point with the tangent reversed."""
        return replace(self, tangent=-self.tangent)


P = TypeVar("P", bound=PointOnCurve)


class Bound(NamedTuple):
    """The scaled range of one of the unknowns, given by its index."""

    unknown_index: int
    low: float
    high: float


class Curve(ABC, Generic[P]):
    """A curve that can be followed.

    `tests` are functions that change their sign at events. Where the pattern of the motion changes,
    such as the order of its modes, the curve has a corner. If `checks_hidden_folds`, steps that may
    pass two folds at once are shortened. The test for folds must then be the derivative of the
    first parameter along the curve.
    """

    bounds: Sequence[Bound]
    tests: Mapping[EventKind, Callable[[P], float]]
    checks_hidden_folds = False

    @abstractmethod
    def correct(
        self,
        guess: FloatArray,
        neighbour: P,
        normal: FloatArray,
        heading: FloatArray | None = None,
    ) -> P | None:
        """The point of the curve near a guess; None if there is none.

        It is in the plane through the guess with this normal. `neighbour` is a known point of the
        curve nearby. The new tangent points to the side of `heading`. By default this is the
        normal, in a step the old tangent; a plane that fixes an unknown needs another heading.
        """

    def size(self, point: P) -> float:  # noqa: ARG002
        """Scaled distance from the equilibrium or any other point at which the curve ends."""
        return 1.0

    def features(self, point: P) -> FloatArray:
        """Quantities that are equal if and only if two points are the same."""
        return point.unknowns

    def confirms(self, kind: EventKind, point: P) -> bool:  # noqa: ARG002
        """Whether a zero of the test for an event is such an event."""
        return True

    def pattern(self, point: P) -> object:  # noqa: ARG002
        """A value that identifies the pattern of the motion; it changes at corners of the curve."""
        return None

    def pattern_event(self, point: P, successor: P) -> EventKind:  # noqa: ARG002
        """The event between two points of different patterns."""
        return EventKind.ORDER

    def loss_reason(self, point: P) -> End:  # noqa: ARG002
        """Why the curve cannot be followed beyond its last point."""
        return End.LOST

    def recentre(self, point: P) -> P:
        """The point, or the same cycle with a period that begins at a more suitable state.

        On a belt of finite speed this state is within a stick.
        """
        return point


@dataclass(frozen=True, slots=True)
class CurvePart(Generic[P]):
    """A part of a curve: its points after the first, its events by index of point, and its end."""

    points: tuple[P, ...]
    events: dict[int, EventKind]
    end: End


@dataclass(frozen=True, slots=True)
class WholeCurve(Generic[P]):
    """A curve from end to end: its points, its events by index of point, and its ends."""

    points: tuple[P, ...]
    events: dict[int, EventKind]
    ends: tuple[End, End]


def follow_both_ways(
    follow: Callable[[P], CurvePart[P]], start: P, end_at_start: End | None = None
) -> WholeCurve[P]:
    """The curve through a point; the point is an end of the curve if `end_at_start` is given."""
    ahead = follow(start)
    if end_at_start is None and ahead.end is End.CLOSED:
        end_at_start = End.CLOSED
    behind = follow(start.reversed()) if end_at_start is None else CurvePart((), {}, end_at_start)
    start_index = len(behind.points)
    events = {start_index - 1 - index: kind for index, kind in behind.events.items()}
    events |= {start_index + 1 + index: kind for index, kind in ahead.events.items()}
    points = (*behind.points[::-1], start, *ahead.points)
    return WholeCurve(points, dict(sorted(events.items())), (behind.end, ahead.end))


@dataclass(frozen=True, slots=True)
class _Node(Generic[P]):
    # A point, the values of the tests for events there, its size and its features.
    point: P
    test_values: dict[EventKind, float]
    size: float
    features: FloatArray


class _StepTooLongError(Exception):
    """No point was found at the end of a step, or events may be hidden in it."""


def _angle(first: PointOnCurve, second: PointOnCurve) -> float:
    # Angle between the tangents, rad.
    return float(np.arccos(min(max(float(first.tangent @ second.tangent), -1.0), 1.0)))


class Follower(Generic[P]):
    """Follows a curve from a point to its end."""

    def __init__(
        self,
        curve: Curve[P],
        min_size: float = 0.0,
        report: Callable[[int], None] = lambda _count: None,
        *,
        max_points: int = MAX_POINTS,
    ) -> None:
        self._curve, self._min_size = curve, min_size
        self._report, self._max_points = report, max_points
        self._parameter_index = curve.bounds[0].unknown_index

    def follow(
        self,
        start: P,
        *,
        step: float | None = None,
        until: tuple[EventKind, ...] = (),
        start_event: EventKind | None = None,
    ) -> CurvePart[P]:
        """Follow the curve from a point along its tangent, to its end or an event of `until`.

        `start_event` is the event at the start, if there is one: it is not located again.
        """
        points: list[P] = []
        events: dict[int, EventKind] = {}
        first_node = node = self._node(start, start_event)
        previous: _Node[P] | None = None
        step = _STEP_PER_SIZE * node.size if step is None else step
        end = End.BOUND if self._starts_at_bound(start) else None
        while end is None:
            self._report(len(points))
            step = min(step, self._longest_step(node))
            if step < _MIN_STEP:
                # No step succeeds: the curve is lost here, or has a corner, never at its start.
                beyond = self._point_beyond_corner(node) if points else None
                if beyond is None:
                    end = self._curve.loss_reason(node.point)
                    continue
                # The node is a corner at which the curve turns back and the pattern changes.
                events[len(points) - 1] = self._curve.pattern_event(node.point, beyond)
                step = float(np.linalg.norm(beyond.unknowns - node.point.unknowns))
                points.append(beyond)
                # Across a corner tangents cannot be extrapolated.
                previous, node = None, self._node(beyond)
                continue
            try:
                successor, event, end = self._next_node(node, previous, step, until)
            except _StepTooLongError:
                step *= 0.5
                continue
            if points and self._closes_curve(first_node, node, successor):
                successor, event, end = first_node, None, End.CLOSED
            else:
                end = end or self._end_after(node, successor, len(points))
            if event is not None:
                events[len(points)] = event
                step *= 0.5
                end = End.EVENT if event in until else end
            elif (
                successor.point.iterations <= _FEW_ITERATIONS
                and _angle(node.point, successor.point) < 0.5 * _MAX_TURN
            ):
                step *= _STEP_GROWTH
            recentred = self._curve.recentre(successor.point)
            if recentred is successor.point:
                previous, node = node, successor
            else:
                # Another start of the period: tangents cannot be extrapolated.
                previous, node = None, self._node(recentred)
            if event is not None:
                node.test_values[event] = 0.0
            points.append(node.point)
        return CurvePart(tuple(points), events, end)

    def events_both_ways(self, start: P, kind: EventKind, step: float | None = None) -> list[P]:
        """The points with the first event of a kind, ahead of a point and behind it."""
        parts = (
            self.follow(point, step=step, until=(kind,)) for point in (start, start.reversed())
        )
        return [part.points[-1] for part in parts if part.end is End.EVENT]

    def _node(self, point: P, event: EventKind | None = None) -> _Node[P]:
        test_values = {kind: test(point) for kind, test in self._curve.tests.items()}
        if event is not None:
            # Rounding must not give the test of a located event a sign.
            test_values[event] = 0.0
        return _Node(point, test_values, self._curve.size(point), self._curve.features(point))

    def _starts_at_bound(self, start: P) -> bool:
        # Whether the curve leaves the range at its first point.
        return any(
            start.unknowns[index] == (high if start.tangent[index] > 0 else low)
            for index, low, high in self._curve.bounds
        )

    def _longest_step(self, node: _Node[P]) -> float:
        tangent = node.point.tangent
        return min(
            _STEP_PER_SIZE * node.size,
            max(_LARGE_STEP, _STEP_PER_LARGE_SIZE * node.size),
            *(
                _STEP_PER_RANGE * (high - low) / (abs(float(tangent[index])) + _TANGENT_ROUNDING)
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
        # The next point, or the first event before it; the end if the motion jumps there.
        point = node.point
        guess = point.unknowns + step * point.tangent
        if previous is not None:
            distance = float(np.linalg.norm(point.unknowns - previous.point.unknowns))
            if distance > _MIN_PREVIOUS_STEP * step:
                tangent_change = point.tangent - previous.point.tangent
                guess += 0.5 * step * step / distance * tangent_change
        target = self._curve.correct(guess, point, point.tangent)
        if target is None or self._is_outside(target.unknowns):
            target = self._point_at_bound(point, guess if target is None else target.unknowns)
        if target is None:
            raise _StepTooLongError
        successor = self._node(target)
        if successor.size < _MIN_SIZE_RATIO * node.size:
            raise _StepTooLongError
        if self._curve.pattern(point) != self._curve.pattern(target):
            return self._find_pattern_change(node, target, until)
        if _angle(point, target) > _MAX_TURN or (
            self._curve.checks_hidden_folds and self._hides_folds(node, successor)
        ):
            raise _StepTooLongError
        return *self._find_first_event(node, successor, until), None

    def _hides_folds(self, node: _Node[P], successor: _Node[P]) -> bool:
        # Whether the slope of the parameter has two zeros in the step. A parabola approximates the
        # slope: it has the same values at both ends of the step, and the same mean.
        begin_slope, end_slope = (
            node.test_values[EventKind.FOLD],
            successor.test_values[EventKind.FOLD],
        )
        if not begin_slope * end_slope > 0.0:
            return False
        change = successor.point.unknowns - node.point.unknowns
        sign = np.sign(begin_slope)
        mean_slope = sign * float(change[self._parameter_index]) / float(np.linalg.norm(change))
        begin_slope, end_slope = begin_slope * sign, end_slope * sign
        # The parabola at a share s of the step is begin_slope + linear s + quadratic s².
        quadratic = 3.0 * (begin_slope + end_slope - 2.0 * mean_slope)
        if quadratic <= 0.0:
            return False
        linear = end_slope - begin_slope - quadratic
        vertex = -0.5 * linear / quadratic
        least_slope = begin_slope - 0.25 * linear * linear / quadratic
        return bool(0.0 < vertex < 1.0 and least_slope < 0.0)

    def _find_pattern_change(
        self, node: _Node[P], target: P, until: tuple[EventKind, ...]
    ) -> tuple[_Node[P], EventKind | None, End | None]:
        # The first point of the target's pattern, or the first event before it. If the motion jumps
        # between the patterns, the last point of the node's pattern.
        start, pattern = node.point, self._curve.pattern
        # Bisect between the last point of one pattern and the first point of the other.
        before, after = start, target
        length = float(start.tangent @ (after.unknowns - start.unknowns))
        while True:
            gap = float(start.tangent @ (after.unknowns - before.unknowns))
            if not gap > _RESOLUTION * length:
                break
            # Guesses along the tangent at `before` keep Newton's method on its side.
            direction = before.tangent / float(start.tangent @ before.tangent)
            guess = before.unknowns + 0.5 * gap * direction
            middle = self._curve.correct(guess, start, start.tangent)
            if middle is None:
                raise _StepTooLongError
            if pattern(middle) == pattern(start):
                before = middle
            else:
                after = middle
        event_node, event = self._find_first_event(node, self._node(before), until)
        if event is not None:
            return event_node, event, None
        if float(np.linalg.norm(after.unknowns - before.unknowns)) > _JUMP_DISTANCE * node.size:
            return event_node, None, End.JUMPS
        return self._node(after), self._curve.pattern_event(start, after), None

    def _point_beyond_corner(self, corner: _Node[P]) -> P | None:
        # A point of a different pattern beyond a corner at which the curve turns back along the
        # first parameter.
        point, pattern = corner.point, self._curve.pattern
        normal = np.eye(len(point.unknowns))[self._parameter_index]
        for distance in _CORNER_DISTANCES:
            # The curve goes on along the tangent, but back along the parameter.
            heading = distance * corner.size * point.tangent
            heading[self._parameter_index] = -heading[self._parameter_index]
            beyond = self._curve.correct(point.unknowns + heading, point, normal, heading)
            if beyond is not None and pattern(beyond) != pattern(point):
                return beyond
        return None

    def _is_outside(self, unknowns: FloatArray) -> bool:
        return not all(low <= unknowns[index] <= high for index, low, high in self._curve.bounds)

    def _end_after(self, node: _Node[P], successor: _Node[P], count: int) -> End | None:
        # The reason to end at the successor, the point number `count` + 1; None to continue.
        unknowns = successor.point.unknowns
        if not all(low < unknowns[index] < high for index, low, high in self._curve.bounds):
            return End.BOUND
        # A curve may begin below the minimum size, and grow.
        if successor.size < min(self._min_size, node.size):
            return End.EQUILIBRIUM
        if successor.size > _MAX_SIZE:
            return End.UNBOUNDED
        return End.TOO_LONG if count + 1 >= self._max_points else None

    def _point_at_bound(self, point: P, target: FloatArray) -> P | None:
        # The curve's point at the first bound on the line from a point to a target outside.
        change = target - point.unknowns
        crossings = []
        for index, low, high in self._curve.bounds:
            bound = high if change[index] > 0.0 else low
            if (point.unknowns[index] - bound) * (target[index] - bound) < 0.0:
                crossings.append(((bound - point.unknowns[index]) / change[index], index, bound))
        if not crossings:
            return None
        share, index, bound = min(crossings)
        guess = point.unknowns + change * share
        guess[index] = bound
        return self._curve.correct(guess, point, np.eye(len(guess))[index], point.tangent)

    def _find_first_event(
        self, node: _Node[P], successor: _Node[P], until: tuple[EventKind, ...]
    ) -> tuple[_Node[P], EventKind | None]:
        # The next point, or the first event before it. Events of `until` must be located, if need
        # be by a shorter step; others are left out where they cannot be located.
        events: list[tuple[float, EventKind, P]] = []
        for kind, test in self._curve.tests.items():
            if node.test_values[kind] * successor.test_values[kind] < 0.0:
                try:
                    distance, point = self._locate_zero(
                        node.point, successor.point, test, node.test_values[kind]
                    )
                except _StepTooLongError:
                    if kind in until:
                        raise
                    continue
                if self._curve.confirms(kind, point):
                    events.append((distance, kind, point))
        if not events:
            return successor, None
        events.sort(key=lambda event: event[0])
        _, first_kind, first_point = events[0]
        for _, kind, point in events[1:]:
            # Rounding may swap close events: a test with another sign at the first point than at
            # the node is zero before that point.
            if node.test_values[kind] * self._curve.tests[kind](first_point) < 0.0:
                first_kind, first_point = kind, point
        return self._node(first_point), first_kind

    def _locate_zero(
        self, begin: P, end: P, test: Callable[[P], float], value_at_begin: float
    ) -> tuple[float, P]:
        # The distance s along the first point's tangent at which a test is zero, and the point.
        from scipy.optimize import brentq

        tangent = begin.tangent
        step = float(tangent @ (end.unknowns - begin.unknowns))
        # Points by distance.
        points = {0.0: begin, step: end}

        def test_value(s: float) -> float:
            if s == 0.0:
                return value_at_begin
            if s not in points:
                low = max(distance for distance in points if distance < s)
                high = min(distance for distance in points if distance > s)
                guess = _interpolate(points[low], points[high], tangent, (s - low) / (high - low))
                point = self._curve.correct(guess, begin, tangent)
                closest = low if s - low < high - s else high
                if point is None and abs(s - closest) > _SINGULAR_DISTANCE * step:
                    raise _StepTooLongError
                if point is None:
                    # At a branch point the equations are singular.
                    points[s] = points[closest]
                    return 0.0
                points[s] = point
            return test(points[s])

        zero = float(brentq(test_value, 0.0, step, xtol=1e-14 * step + 1e-15, rtol=1e-14))
        # Add the zero to `points` if the search ended without a value there.
        test_value(zero)
        return zero, points[zero]

    def _closes_curve(self, start: _Node[P], node: _Node[P], successor: _Node[P]) -> bool:
        # Whether a step passes the first point of the curve in the same direction.
        offset = start.features - node.features
        chord = successor.features - node.features
        length = float(np.linalg.norm(chord))
        # The share of the step at which it is nearest to the first point.
        share = float(offset @ chord) / (length * length) if length > 0.0 else -1.0
        if not 0.0 < share <= 1.0:
            return False
        if float(np.linalg.norm(offset - share * chord)) > _CLOSING_DISTANCE * length:
            return False
        point = node.point
        guess = point.unknowns + share * (successor.point.unknowns - point.unknowns)
        guess[self._parameter_index] = start.point.unknowns[self._parameter_index]
        normal = np.eye(len(guess))[self._parameter_index]
        nearest = self._curve.correct(guess, point, normal, point.tangent)
        if nearest is None:
            return False
        deviation = np.abs(self._curve.features(nearest) - start.features).max()
        return bool(deviation < _SAME_POINT * np.abs(start.features).max())


def _interpolate(
    first: PointOnCurve, second: PointOnCurve, direction: FloatArray, share: float
) -> FloatArray:
    # The cubic through two points with their tangents, at a share of their distance in a direction.
    change = second.unknowns - first.unknowns
    length = float(direction @ change)
    # Derivatives of the unknowns by the share, at both points.
    begin, end = (
        point.tangent * (length / float(direction @ point.tangent)) for point in (first, second)
    )
    remainder = 1.0 - share
    bend = share * remainder * (remainder * (begin - change) - share * (end - change))
    guess: FloatArray = first.unknowns + share * change + bend
    return guess
