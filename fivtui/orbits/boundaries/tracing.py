"""Curves of folds of cycles in contact and of separating cycles, through the corners in between.

A corner is where a fold begins to touch y = 0. The curve of folds in contact is smooth and extends
beyond the corner. On the curve of separating folds the highest point rises with the square of the
distance from the corner. If the curve turns back there, two folds and a touch meet in a cusp.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from fivtui.model import Progress
from fivtui.orbits.curves.arclength import PARAMETER, OrbitOnCurve
from fivtui.orbits.curves.branch_curve import ParameterLine
from fivtui.orbits.curves.events import End, EventKind
from fivtui.orbits.curves.flow import FloatArray
from fivtui.orbits.curves.following import CurvePart, Follower

from .fold_curve import FoldCurve, FoldOnCurve
from .plane import FIRST, SECOND, ParameterPlane
from .touch_curve import TouchCurve

# Amplitude, relative to the length, below which folds end in a Hopf point.
_MIN_SIZE: Final = 4e-3
# Heights of the highest point, relative to the length, below which a cycle is near a corner, and
# below which it is in contact.
_CORNER_HEIGHT: Final = 1e-3
_CONTACT_HEIGHT: Final = 1e-9
_MAX_CORNERS: Final = 8
# Distances from a corner, in units of the parameters, at which the curve is continued.
_CORNER_DISTANCES: Final = (0.02, 0.005, 0.001)
# Greatest height of a fold next to a corner, relative to the depth of its lowest point.
_MAX_HEIGHT: Final = 0.05
_MAX_POINTS_TO_FOLD: Final = 60
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
        self._contact, self._separating = (
            FoldCurve(plane, length, period, work, separation=separation)
            for separation in (False, plane.system.separation)
        )
        self._touches = TouchCurve(plane, length, period, work)
        self.scales = self._contact.scales

    def fold_at(self, cycle: FloatArray, y_max: float) -> FoldOnCurve | None:
        """The fold near a limit cycle at the same value of the first parameter."""
        return self._curve_for(y_max).fold_at(cycle / self.scales, FIRST)

    def follow(self, start: FoldOnCurve) -> CurvePart[FoldOnCurve]:
        """Follow a curve of folds from a fold, in the direction of its tangent."""
        trace = _Trace([], {}, End.LOST)
        fold: FoldOnCurve | None = start
        for _ in range(_MAX_CORNERS):
            if fold is None:
                break
            fold = self._follow_to_corner(trace, fold, None if fold is start else EventKind.TOUCH)
        return CurvePart(tuple(trace.points), trace.events, trace.end)

    def _curve_for(self, y_max: float) -> FoldCurve:
        separates = y_max > _CONTACT_HEIGHT * self._length
        return self._separating if separates and self._plane.system.separation else self._contact

    def _follow_to_corner(
        self, trace: _Trace, start: FoldOnCurve, event: EventKind | None
    ) -> FoldOnCurve | None:
        # Follow the curve to its end or a corner; return the fold at which to go on, if any.
        curve, points = self._curve_for(float(start.extremes[3])), trace.points
        part = Follower(curve, _MIN_SIZE).follow(start, until=(EventKind.TOUCH,), start_event=event)
        trace.events |= {len(points) + index: kind for index, kind in part.events.items()}
        points += part.points
        trace.end = part.end
        if not self._plane.system.separation or part.end not in (End.EVENT, End.LOST):
            return None
        if curve is self._contact:
            return self._leave_corner(trace) if part.end is End.EVENT else None
        if part.end is not End.EVENT:
            return self._find_corner(trace, start)
        # The highest point is at y = 0: next to a corner ahead or behind, or without a corner.
        del trace.events[len(points) - 1]
        previous = points[-2] if len(points) > 1 else start
        rises = bool(previous.extremes[3] < points[-1].extremes[3])
        corner = None if rises else self._find_corner(trace, start)
        return points[-1] if corner is None else corner

    def _leave_corner(self, trace: _Trace) -> FoldOnCurve | None:
        # Step from a corner at the end of folds in contact to a separating fold.
        corner = trace.points[-1]
        trace.end = End.LOST
        for distance in _CORNER_DISTANCES:
            for kind, signed_distance in ((EventKind.CUSP, -distance), (EventKind.TOUCH, distance)):
                beyond = self._fold_beyond_corner(corner, signed_distance)
                if beyond is not None:
                    trace.events[len(trace.points) - 1] = kind
                    trace.points.append(beyond)
                    return beyond
        return None

    def _fold_beyond_corner(self, corner: FoldOnCurve, distance: float) -> FoldOnCurve | None:
        # The separating fold at a distance from a corner, measured along the curve in contact.
        direction = corner.tangent[FIRST:] / np.linalg.norm(corner.tangent[FIRST:])
        fixed = FIRST + int(np.argmax(np.abs(direction)))
        free = FIRST + SECOND - fixed
        touch = self._touch_at(corner, corner.unknowns[FIRST:] + distance * direction, fixed)
        if touch is None:
            return None
        values = touch.unknowns * self.scales
        system = replace(self._plane.system_at(values[FIRST:].tolist()), separation=True)
        name, bounds = self._plane.names[free - FIRST], self._plane.ranges[free - FIRST]
        line = ParameterLine(system, name, bounds, self._work)
        curve = line.curve(self._length, self._period)
        planes = np.zeros((2, 6))
        planes[0, _STATE], planes[1, PARAMETER] = touch.flow_direction, 1.0
        start = curve.orbits.solve(np.append(values[:FIRST], values[free]) / curve.scales, planes)
        if start is None:
            return None
        start = start if start.tangent[2] > 0.0 else start.reversed()
        part = Follower(curve, max_points=_MAX_POINTS_TO_FOLD).follow(
            start, step=_FIRST_STEP * abs(distance), until=(EventKind.FOLD,)
        )
        if part.end is not End.EVENT:
            return None
        fold_on_line = part.points[-1].unknowns * curve.scales
        unknowns = np.append(fold_on_line[:FIRST] / self.scales[:FIRST], touch.unknowns[FIRST:])
        unknowns[free] = fold_on_line[PARAMETER] / self.scales[free]
        fold = self._separating.fold_at(unknowns, fixed)
        if fold is None or fold.extremes[3] > _MAX_HEIGHT * abs(fold.extremes[2]):
            return None
        away = float((fold.unknowns - corner.unknowns)[FIRST:] @ fold.tangent[FIRST:])
        return fold if away > 0.0 else fold.reversed()

    def _find_corner(self, trace: _Trace, start: FoldOnCurve) -> FoldOnCurve | None:
        # Step from the last separating fold to a corner nearby, if there is one.
        points = trace.points
        end_fold = points[-1] if points else start
        if not float(end_fold.extremes[3]) < _CORNER_HEIGHT * self._length:
            return None
        corner = self._corner_near(end_fold)
        if corner is None:
            return None
        # Steps shorter than the smallest distance from a corner have no reliable direction.
        steps = [(corner.unknowns - fold.unknowns)[FIRST:] for fold in (*points[::-1], start)]
        long_steps = (step for step in steps if np.linalg.norm(step) > _CORNER_DISTANCES[-1])
        turns_back = bool(corner.tangent[FIRST:] @ next(long_steps, end_fold.tangent[FIRST:]) < 0.0)
        while points and float(points[-1].extremes[3]) < _CONTACT_HEIGHT * self._length:
            points.pop()
        count = len(points)
        trace.events = {index: kind for index, kind in trace.events.items() if index < count}
        trace.events[count] = EventKind.CUSP if turns_back else EventKind.TOUCH
        points.append(corner)
        return corner

    def _corner_near(self, fold: FoldOnCurve) -> FoldOnCurve | None:
        # The touching fold near a fold of small height, with the tangent towards folds in contact.
        # It is located on the curve of touching cycles, which has no corner.
        direction = fold.tangent[FIRST:]
        fixed = FIRST + int(np.argmax(np.abs(direction)))
        touch = self._touch_at(fold, fold.unknowns[FIRST:], fixed)
        if touch is None:
            return None
        ahead = touch if touch.tangent[FIRST:] @ direction > 0.0 else touch.reversed()
        follower = Follower(self._touches, max_points=_MAX_POINTS_TO_FOLD)
        for start in (ahead, ahead.reversed()):
            part = follower.follow(start, step=_FIRST_STEP, until=(EventKind.FOLD,))
            if part.end is End.EVENT:
                corner = self._contact.fold_at(part.points[-1].unknowns, fixed)
                # The orbit starts at its highest point: the third unknown is its y.
                towards_contact = corner is None or corner.tangent[2] < 0.0
                return corner if corner is None or towards_contact else corner.reversed()
        return None

    def _touch_at(self, fold: FoldOnCurve, values: FloatArray, fixed: int) -> OrbitOnCurve | None:
        # The touching cycle near a fold, with the scaled value of one parameter fixed.
        return self._touches.touching_cycle(fold.unknowns * self.scales, fixed, values)
