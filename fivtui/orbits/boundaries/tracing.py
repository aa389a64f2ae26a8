"""Curves of folds of limit cycles, through the corners between contact and separation.

A fold is in contact or separating, as its cycle is. At a corner the cycle just reaches y = 0, where
the slider leaves the belt. The curve of folds in contact is smooth and extends beyond the corner,
where the contact would have to pull.

The time that a cycle is off the belt rises with √y_max, and so does the effect on the slope of its
branch. Hence on the curve of separating folds y_max rises with the square of the distance from the
corner. If the curve turns back at the corner, it is a cusp.
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
from .plane import (
    FIRST_PARAMETER,
    IN_PLANE,
    SECOND_PARAMETER,
    STATE,
    STATE_AND_PERIOD,
    ParameterPlane,
)
from .touch_curve import TouchCurve

# Amplitude, relative to the length scale, below which folds end in a Hopf point.
_MIN_SIZE: Final = 4e-3
# Value of y_max, relative to the length scale, below which a cycle is near a corner.
_CORNER_HEIGHT: Final = 1e-3
# Value of y_max, relative to the length scale, up to which a cycle is in contact.
_CONTACT_HEIGHT: Final = 1e-9
# Upper bound of the corners that a curve passes, after which it ends as lost.
_MAX_CORNERS: Final = 8
# Distances from a corner, in units of the parameters, at which the curve is continued, in the order
# in which they are tried.
_CORNER_DISTANCES: Final = (0.02, 0.005, 0.001)
# Length of a step to a corner, in the same units, up to which its direction is not reliable.
_UNRELIABLE_LENGTH: Final = _CORNER_DISTANCES[-1]
# Greatest y_max of a fold next to a corner, relative to |y_min|.
_MAX_HEIGHT: Final = 0.05
# Greatest number of points from a cycle near a corner to a fold, and length of the first step.
_MAX_POINTS_TO_FOLD: Final = 60
_FIRST_STEP: Final = 1e-3
# Index of y among the unknowns.
_Y: Final = 2


@dataclass(slots=True)
class _FoldPath:
    # The curve as far as it has been followed: folds, events by index of fold, and its end.
    folds: list[FoldOnCurve]
    events: dict[int, EventKind]
    end: End


class FoldTracer:
    """Follows curves of folds over two parameters.

    `length`, m, and `period`, s, are the scales of state and period.
    """

    def __init__(self, plane: ParameterPlane, length: float, period: float, work: Progress) -> None:
        self._plane, self._length, self._period, self._work = plane, length, period, work
        # In a system that ignores separation both are equal, and only the first is followed.
        self._contact_curve, self._separating_curve = (
            FoldCurve(plane, length, period, work, separation=separation)
            for separation in (False, plane.system.separation)
        )
        self._touch_curve = TouchCurve(plane, length, period, work)
        self.scales = self._contact_curve.scales

    def fold_at(self, cycle: FloatArray, y_max: float) -> FoldOnCurve | None:
        """The fold near a limit cycle, with the same value of the first parameter.

        `cycle` are its unknowns in SI units, `y_max` its highest point.
        """
        return self._curve_for(y_max).fold_at(cycle / self.scales, FIRST_PARAMETER)

    def follow(self, start: FoldOnCurve) -> CurvePart[FoldOnCurve]:
        """Follow a curve of folds from a fold, in the direction of its tangent."""
        path = _FoldPath([], {}, End.LOST)
        fold: FoldOnCurve | None = start
        for _ in range(_MAX_CORNERS):
            if fold is None:
                break
            # From a corner on, the touch of y = 0 there is not an event to locate again.
            start_event = None if fold is start else EventKind.TOUCH
            fold = self._follow_to_corner(path, fold, start_event)
        return CurvePart(tuple(path.folds), path.events, path.end)

    def _curve_for(self, y_max: float) -> FoldCurve:
        if self._plane.system.separation and y_max > _CONTACT_HEIGHT * self._length:
            return self._separating_curve
        return self._contact_curve

    def _follow_to_corner(
        self, path: _FoldPath, start: FoldOnCurve, start_event: EventKind | None
    ) -> FoldOnCurve | None:
        # Follow the curve to its end or a corner; return the fold from which it continues, if any.
        curve, folds = self._curve_for(start.y_max), path.folds
        part = Follower(curve, min_size=_MIN_SIZE).follow(
            start, until=(EventKind.TOUCH,), start_event=start_event
        )
        path.events |= {len(folds) + index: kind for index, kind in part.events.items()}
        folds += part.points
        path.end = part.end
        ends_at_touch, is_lost = part.end is End.EVENT, part.end is End.LOST
        if not self._plane.system.separation or not (ends_at_touch or is_lost):
            return None
        if curve is self._contact_curve:
            return self._leave_corner(path) if ends_at_touch else None
        # A curve of separating folds may be lost just before a corner.
        if is_lost:
            return self._step_to_corner(path, start)
        # Here y_max passes the least height of separating folds: the event is a corner beside it.
        del path.events[len(folds) - 1]
        fold = folds[-1]
        previous = folds[-2] if len(folds) > 1 else start
        # If y_max rises the corner is behind, else it may be ahead.
        corner = None if previous.y_max < fold.y_max else self._step_to_corner(path, start)
        return fold if corner is None else corner

    def _leave_corner(self, path: _FoldPath) -> FoldOnCurve | None:
        # Step from a corner, the last fold in contact, to a separating fold, and add that one.
        corner = path.folds[-1]
        path.end = End.LOST
        for distance in _CORNER_DISTANCES:
            # Distances are along the curve in contact: at a cusp the separating curve goes back.
            for event, signed_distance in (
                (EventKind.CUSP, -distance),
                (EventKind.TOUCH, distance),
            ):
                beyond = self._fold_beyond_corner(corner, signed_distance)
                if beyond is not None:
                    path.events[len(path.folds) - 1] = event
                    path.folds.append(beyond)
                    return beyond
        return None

    def _fold_beyond_corner(self, corner: FoldOnCurve, distance: float) -> FoldOnCurve | None:
        # The separating fold at a distance from a corner, measured along the curve in contact. It
        # is located on the branch of separating cycles that begins at a touching cycle.
        direction = corner.tangent[IN_PLANE] / np.linalg.norm(corner.tangent[IN_PLANE])
        fixed_index = _steepest_parameter(direction)
        fixes_first = fixed_index == FIRST_PARAMETER
        free_index = SECOND_PARAMETER if fixes_first else FIRST_PARAMETER
        touch = self._touching_cycle(
            corner, corner.unknowns[IN_PLANE] + distance * direction, fixed_index
        )
        if touch is None:
            return None
        touch_unknowns = touch.unknowns * self.scales
        system = self._plane.system_at(touch_unknowns[IN_PLANE].tolist())
        index_in_plane = free_index - FIRST_PARAMETER
        # The branch of separating cycles along the free parameter.
        line = ParameterLine(
            replace(system, separation=True),
            name=self._plane.names[index_in_plane],
            bounds=self._plane.ranges[index_in_plane],
            work=self._work,
        )
        curve = line.curve(self._length, self._period)
        normals = np.zeros((2, len(curve.scales)))
        normals[0, STATE], normals[1, PARAMETER] = touch.flow_direction, 1.0
        guess = np.append(touch_unknowns[STATE_AND_PERIOD], touch_unknowns[free_index])
        start = curve.orbits.solve(guess / curve.scales, normals)
        if start is None:
            return None
        # The cycle starts at its highest point: it separates where the start rises.
        start = start if start.tangent[_Y] > 0.0 else start.reversed()
        part = Follower(curve, max_points=_MAX_POINTS_TO_FOLD).follow(
            start, step=_FIRST_STEP * abs(distance), until=(EventKind.FOLD,)
        )
        if part.end is not End.EVENT:
            return None
        branch_fold = part.points[-1].unknowns * curve.scales
        unknowns = touch.unknowns.copy()
        unknowns[STATE_AND_PERIOD] = branch_fold[STATE_AND_PERIOD] / self.scales[STATE_AND_PERIOD]
        unknowns[free_index] = branch_fold[PARAMETER] / self.scales[free_index]
        fold = self._separating_curve.fold_at(unknowns, fixed_index)
        if fold is None or fold.y_max > _MAX_HEIGHT * abs(fold.y_min):
            return None
        step = (fold.unknowns - corner.unknowns)[IN_PLANE]
        return fold if float(step @ fold.tangent[IN_PLANE]) > 0.0 else fold.reversed()

    def _step_to_corner(self, path: _FoldPath, start: FoldOnCurve) -> FoldOnCurve | None:
        # Find the corner near the last separating fold, and add it to the path. Folds at its end
        # that are in contact lie beyond the corner and are removed.
        folds = path.folds
        last_fold = folds[-1] if folds else start
        if not last_fold.y_max < _CORNER_HEIGHT * self._length:
            return None
        corner = self._corner_near(last_fold)
        if corner is None:
            return None
        # The direction in which the curve reaches the corner: that of the last step to it that is
        # not too short, or the last tangent.
        steps = [(corner.unknowns - fold.unknowns)[IN_PLANE] for fold in (*folds[::-1], start)]
        long_steps = (step for step in steps if np.linalg.norm(step) > _UNRELIABLE_LENGTH)
        heading = next(long_steps, last_fold.tangent[IN_PLANE])
        turns_back = bool(corner.tangent[IN_PLANE] @ heading < 0.0)
        while folds and folds[-1].y_max < _CONTACT_HEIGHT * self._length:
            folds.pop()
        count = len(folds)
        path.events = {index: kind for index, kind in path.events.items() if index < count}
        path.events[count] = EventKind.CUSP if turns_back else EventKind.TOUCH
        folds.append(corner)
        return corner

    def _corner_near(self, fold: FoldOnCurve) -> FoldOnCurve | None:
        # The touching fold near a fold of small y_max, with the tangent towards folds in contact.
        # It is located on the curve of touching cycles, which has no corner.
        direction = fold.tangent[IN_PLANE]
        fixed_index = _steepest_parameter(direction)
        touch = self._touching_cycle(fold, fold.unknowns[IN_PLANE], fixed_index)
        if touch is None:
            return None
        ahead = touch if touch.tangent[IN_PLANE] @ direction > 0.0 else touch.reversed()
        follower = Follower(self._touch_curve, max_points=_MAX_POINTS_TO_FOLD)
        for start in (ahead, ahead.reversed()):
            part = follower.follow(start, step=_FIRST_STEP, until=(EventKind.FOLD,))
            if part.end is End.EVENT:
                corner = self._contact_curve.fold_at(part.points[-1].unknowns, fixed_index)
                if corner is None:
                    return None
                # The cycle starts at its highest point: towards folds in contact its y falls.
                return corner if corner.tangent[_Y] < 0.0 else corner.reversed()
        return None

    def _touching_cycle(
        self, fold: FoldOnCurve, values: FloatArray, fixed_index: int
    ) -> OrbitOnCurve | None:
        # The touching cycle near a fold, at scaled values of the parameters of which one is fixed.
        return self._touch_curve.touching_cycle(fold.unknowns * self.scales, fixed_index, values)


def _steepest_parameter(direction: FloatArray) -> int:
    # Index among the unknowns of the parameter that changes most in a direction of the plane.
    return FIRST_PARAMETER + int(np.argmax(np.abs(direction)))
