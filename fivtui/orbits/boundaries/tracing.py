"""Tracing a curve of folds on and off the belt, through the corners in between.

The curve of folds has a corner where a fold begins to touch y = 0. The curve of folds on the belt
is smooth and extends beyond the corner. Off the belt the highest point rises from y = 0 with the
square of the distance. At the corner the curve turns back or passes. Where it turns back there is a
cusp: two folds and the touch of a branch meet.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from fivtui.model import Progress
from fivtui.orbits.curves.arclength import VALUE, OrbitOnCurve
from fivtui.orbits.curves.branch_curve import ParameterLine
from fivtui.orbits.curves.events import End, EventKind
from fivtui.orbits.curves.flow import FloatArray
from fivtui.orbits.curves.following import Followed, Follower

from .fold_curve import FoldCurve, FoldOnCurve
from .plane import FIRST, SECOND, ParameterPlane
from .touch_curve import TouchCurve

# Amplitude, relative to the length, below which folds have shrunk into a Hopf point.
_NEAREST: Final = 4e-3
# Height above y = 0, relative to the length, below which a cycle is near a corner, and below which
# it is at the corner.
_AT_CORNER: Final = 1e-3
_SETTLED: Final = 1e-9
_MOST_CORNERS: Final = 8
# Distances from a corner, in units of the parameters, at which the curve is continued.
_CORNER_DISTANCES: Final = (0.02, 0.005, 0.001)
# Greatest height above y = 0, relative to its depth, of a fold next to a corner.
_PART_OF_SIZE: Final = 0.05
_MOST_TO_FOLD: Final = 60
_FIRST_STEP: Final = 1e-3
_STATE: Final = slice(4)


@dataclass(slots=True)
class _Trace:
    # Folds along the curve, events by index, and the end.
    points: list[FoldOnCurve]
    events: dict[int, EventKind]
    end: End


class FoldTracer:
    """Traces curves of folds."""

    def __init__(self, plane: ParameterPlane, length: float, period: float, work: Progress) -> None:
        self._plane, self._length, self._period, self._work = plane, length, period, work
        self._on, self._off = (
            FoldCurve(plane, length, period, work, separation=separates)
            for separates in (False, plane.system.separation)
        )
        self._touches = TouchCurve(plane, length, period, work)
        self.scales = self._on.scales

    def begin(self, cycle: FloatArray, y_max: float) -> FoldOnCurve | None:
        """The fold near a limit cycle, at the same value of the first parameter."""
        return self._curve(y_max).begin(cycle / self.scales, FIRST)

    def follow(self, start: FoldOnCurve) -> Followed[FoldOnCurve]:
        """Follow a curve of folds from a fold, in the direction of its tangent."""
        trace = _Trace([], {}, End.LOST)
        fold: FoldOnCurve | None = start
        for _ in range(_MOST_CORNERS):
            if fold is None:
                break
            fold = self._to_corner(trace, fold, None if fold is start else EventKind.TOUCH)
        return Followed(tuple(trace.points), trace.events, trace.end)

    def _curve(self, y_max: float) -> FoldCurve:
        leaves = y_max > _SETTLED * self._length
        return self._off if leaves and self._plane.system.separation else self._on

    def _to_corner(
        self, trace: _Trace, start: FoldOnCurve, at: EventKind | None
    ) -> FoldOnCurve | None:
        # Follow the curve to its end or to a corner; return the fold to continue from, if any.
        curve, points = self._curve(float(start.extremes[3])), trace.points
        part = Follower(curve, _NEAREST).follow(start, until=(EventKind.TOUCH,), at=at)
        trace.events |= {len(points) + index: kind for index, kind in part.events.items()}
        points += part.points
        trace.end = part.end
        if not self._plane.system.separation or part.end not in (End.EVENT, End.LOST):
            return None
        if curve is self._on:
            return self._leave_belt(trace) if part.end is End.EVENT else None
        if part.end is not End.EVENT:
            return self._meet_belt(trace, start)
        # Touch level: approaching a corner, leaving one, or no corner.
        del trace.events[len(points) - 1]
        before = points[-2] if len(points) > 1 else start
        rises = bool(before.extremes[3] < points[-1].extremes[3])
        corner = None if rises else self._meet_belt(trace, start)
        return points[-1] if corner is None else corner

    def _leave_belt(self, trace: _Trace) -> FoldOnCurve | None:
        # From a corner at the end of folds on the belt to a fold off the belt.
        corner = trace.points[-1]
        trace.end = End.LOST
        for distance in _CORNER_DISTANCES:
            for kind, signed in ((EventKind.CUSP, -distance), (EventKind.TOUCH, distance)):
                beyond = self._beyond(corner, signed)
                if beyond is not None:
                    trace.events[len(trace.points) - 1] = kind
                    trace.points.append(beyond)
                    return beyond
        return None

    def _beyond(self, corner: FoldOnCurve, distance: float) -> FoldOnCurve | None:
        # The fold off the belt at a distance from a corner, measured along the curve on the belt.
        direction = corner.tangent[FIRST:] / np.linalg.norm(corner.tangent[FIRST:])
        fixed = FIRST + int(np.argmax(np.abs(direction)))
        free = FIRST + SECOND - fixed
        touch = self._touching(corner, corner.unknowns[FIRST:] + distance * direction, fixed)
        if touch is None:
            return None
        values = touch.unknowns * self.scales
        system = replace(self._plane.at(values[FIRST:].tolist()), separation=True)
        name, bounds = self._plane.names[free - FIRST], self._plane.ranges[free - FIRST]
        line = ParameterLine(system, name, bounds, self._work)
        curve = line.curve(self._length, self._period)
        planes = np.zeros((2, 6))
        planes[0, _STATE], planes[1, VALUE] = touch.across, 1.0
        start = curve.orbits.solve(np.append(values[:FIRST], values[free]) / curve.scales, planes)
        if start is None:
            return None
        start = start if start.tangent[2] > 0.0 else start.reversed()
        part = Follower(curve, max_points=_MOST_TO_FOLD).follow(
            start, step=_FIRST_STEP * abs(distance), until=(EventKind.FOLD,)
        )
        if part.end is not End.EVENT:
            return None
        fold_on_line = part.points[-1].unknowns * curve.scales
        unknowns = np.append(fold_on_line[:FIRST] / self.scales[:FIRST], touch.unknowns[FIRST:])
        unknowns[free] = fold_on_line[VALUE] / self.scales[free]
        fold = self._off.begin(unknowns, fixed)
        if fold is None or fold.extremes[3] > _PART_OF_SIZE * abs(fold.extremes[2]):
            return None
        away = float((fold.unknowns - corner.unknowns)[FIRST:] @ fold.tangent[FIRST:])
        return fold if away > 0.0 else fold.reversed()

    def _meet_belt(self, trace: _Trace, start: FoldOnCurve) -> FoldOnCurve | None:
        # From the last fold off the belt to a corner nearby, if there is one.
        points = trace.points
        nearest = points[-1] if points else start
        if not float(nearest.extremes[3]) < _AT_CORNER * self._length:
            return None
        corner = self._corner_near(nearest)
        if corner is None:
            return None
        # Displacements below the smallest distance from a corner have no reliable direction.
        steps = [(corner.unknowns - fold.unknowns)[FIRST:] for fold in (*points[::-1], start)]
        long = (step for step in steps if np.linalg.norm(step) > _CORNER_DISTANCES[-1])
        turns = bool(corner.tangent[FIRST:] @ next(long, nearest.tangent[FIRST:]) < 0.0)
        while points and float(points[-1].extremes[3]) < _SETTLED * self._length:
            points.pop()
        count = len(points)
        trace.events = {index: kind for index, kind in trace.events.items() if index < count}
        trace.events[count] = EventKind.CUSP if turns else EventKind.TOUCH
        points.append(corner)
        return corner

    def _corner_near(self, fold: FoldOnCurve) -> FoldOnCurve | None:
        # The touching fold near a fold close to the belt, with the tangent towards folds on the
        # belt. It is found along the curve of touching cycles, which has no corner.
        arrival = fold.tangent[FIRST:]
        fixed = FIRST + int(np.argmax(np.abs(arrival)))
        touch = self._touching(fold, fold.unknowns[FIRST:], fixed)
        if touch is None:
            return None
        ahead = touch if touch.tangent[FIRST:] @ arrival > 0.0 else touch.reversed()
        follower = Follower(self._touches, max_points=_MOST_TO_FOLD)
        for start in (ahead, ahead.reversed()):
            part = follower.follow(start, step=_FIRST_STEP, until=(EventKind.FOLD,))
            if part.end is End.EVENT:
                corner = self._on.begin(part.points[-1].unknowns, fixed)
                # The orbit starts at its highest point: the third unknown is its height.
                descends = corner is None or corner.tangent[2] < 0.0
                return corner if corner is None or descends else corner.reversed()
        return None

    def _touching(self, fold: FoldOnCurve, values: FloatArray, fixed: int) -> OrbitOnCurve | None:
        # The touching cycle near a fold, with the scaled value of one parameter fixed.
        return self._touches.begin(fold.unknowns * self.scales, fixed, values)
