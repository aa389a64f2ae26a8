"""Tracing a curve of folds both ways, on and off the belt, through the corners in between.

Where a fold begins to touch y = 0 the curve of folds has a corner: on the belt it is smooth and
goes on beyond, off the belt the highest point rises from y = 0 with the square of the distance.
There it turns back (a cusp, where two folds and the touch of a branch meet) or passes.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from fivtui.orbits.curves.arclength import VALUE, OrbitOnCurve
from fivtui.orbits.curves.branch_curve import slider_belt_curve
from fivtui.orbits.curves.events import End, EventKind
from fivtui.orbits.curves.flow import FloatArray
from fivtui.orbits.curves.following import Follower

from .fold_curve import FoldCurve, FoldOnCurve
from .plane import FIRST, SECOND, ParameterPlane
from .touch_curve import TouchCurve, highest_point

# Amplitude, in units of the length, at which folds have shrunk into a Hopf point.
_NEAREST: Final = 4e-3
# Cycles whose highest point is above y = 0 by less, in units of the length, are near a corner, and
# as good as there.
_AT_CORNER: Final = 1e-3
_SETTLED: Final = 1e-9
_MOST_CORNERS: Final = 8
# Distance from a corner, in units of the parameters, at which the curve is taken up again.
_BEYOND: Final = (0.02, 0.005, 0.001)
# A fold that is higher above y = 0, relative to its depth, is not the one next to a corner.
_PART_OF_SIZE: Final = 0.05
_MOST_TO_FOLD: Final = 60
_FIRST_STEP: Final = 1e-3
_STATE: Final = slice(4)


@dataclass(slots=True)
class FoldPart:
    """Folds in the order in which they are met, the events at some of them, and the end."""

    points: list[FoldOnCurve]
    events: dict[int, EventKind]
    end: End


def reversed_fold(fold: FoldOnCurve) -> FoldOnCurve:
    """A fold with the tangent the other way."""
    return replace(fold, tangent=-fold.tangent, determinant=-fold.determinant)


class FoldTracer:
    """Traces curves of folds."""

    def __init__(
        self,
        plane: ParameterPlane,
        length: float,
        period: float,
        tell: Callable[[int], None],
        go_on: Callable[[], bool],
    ) -> None:
        self.plane, self._length, self._period = plane, length, period
        self._tell, self._go_on = tell, go_on
        self._on, self._off = (
            FoldCurve(plane, length, period, separation=separates, go_on=go_on)
            for separates in (False, plane.system.separation)
        )
        self.scales = self._on.scales

    def begin(self, orbit: OrbitOnCurve) -> FoldOnCurve | None:
        """The fold near a limit cycle, at the same value of the first parameter."""
        return self._curve(orbit).begin(orbit, FIRST)

    def follow(self, start: FoldOnCurve) -> FoldPart:
        """Follow a curve of folds from one, in the direction of its tangent."""
        part = FoldPart([], {}, End.LOST)
        here: FoldOnCurve | None = start
        for _ in range(_MOST_CORNERS):
            if here is None:
                break
            here = self._to_corner(part, here, at=EventKind.TOUCH if here is not start else None)
        return part

    def _curve(self, orbit: OrbitOnCurve) -> FoldCurve:
        leaves = float(orbit.extremes[3]) > _SETTLED * self._length
        return self._off if leaves and self.plane.system.separation else self._on

    def _to_corner(
        self, part: FoldPart, start: FoldOnCurve, at: EventKind | None
    ) -> FoldOnCurve | None:
        # Follow it to its end or a corner; returns where to go on behind that.
        curve = self._curve(start)
        found = Follower(curve, _NEAREST, self._tell).follow(start, until=EventKind.TOUCH, at=at)
        part.events |= {len(part.points) + place: kind for place, kind in found.events.items()}
        part.points += found.points
        part.end = found.end
        if not self.plane.system.separation or found.end not in (End.EVENT, End.LOST):
            return None
        if curve is self._on:
            return self._leave_belt(part) if found.end is End.EVENT else None
        if found.end is not End.EVENT:
            return self._meet_belt(part, start)
        # It is the height of a corner: on the way there, from there, or where there is none.
        del part.events[len(part.points) - 1]
        before = part.points[-2] if len(part.points) > 1 else start
        rises = bool(before.extremes[3] < part.points[-1].extremes[3])
        corner = None if rises else self._meet_belt(part, start)
        return part.points[-1] if corner is None else corner

    def _leave_belt(self, part: FoldPart) -> FoldOnCurve | None:
        # From a corner at the end of folds on the belt.
        corner = part.points[-1]
        part.end = End.LOST
        for distance in _BEYOND:
            for turned in (True, False):
                beyond = self._beyond(corner, -distance if turned else distance)
                if beyond is not None:
                    part.events[len(part.points) - 1] = (
                        EventKind.CUSP if turned else EventKind.TOUCH
                    )
                    part.points.append(beyond)
                    return beyond
        return None

    def _beyond(self, corner: FoldOnCurve, distance: float) -> FoldOnCurve | None:
        # The fold off the belt at a distance from a corner, along the curve on the belt.
        way = corner.tangent[FIRST:] / np.linalg.norm(corner.tangent[FIRST:])
        place = FIRST + int(np.argmax(np.abs(way)))
        other = FIRST + SECOND - place
        values = corner.unknowns[FIRST:] + distance * way
        _, touch = self._touching(corner, values, place)
        if touch is None:
            return None
        values = (touch.unknowns * self.scales)[FIRST:]
        system = replace(self.plane.at(values.tolist()), separation=True)
        name, bounds = self.plane.names[other - FIRST], self.plane.ranges[other - FIRST]
        curve = slider_belt_curve(
            system, name, bounds, self._length, self._period, go_on=self._go_on
        )
        planes = np.zeros((2, 6))
        planes[0, _STATE], planes[1, VALUE] = touch.across, 1.0
        start = curve.orbits.solve(
            np.array([*(touch.unknowns * self.scales)[:FIRST], values[other - FIRST]])
            / curve.scales,
            planes,
        )
        if start is None:
            return None
        start = start if start.tangent[2] > 0.0 else _reversed(start)
        follower = Follower(curve, 0.0, lambda _count: None, most=_MOST_TO_FOLD, turns=True)
        found = follower.follow(start, step=_FIRST_STEP * abs(distance), until=EventKind.FOLD)
        if found.end is not End.EVENT:
            return None
        last = found.points[-1]
        unknowns = np.empty(FIRST + 2)
        unknowns[:FIRST] = (last.unknowns * curve.scales)[:FIRST] / self.scales[:FIRST]
        unknowns[place] = touch.unknowns[place]
        unknowns[other] = float(last.unknowns[VALUE] * curve.scales[VALUE]) / self.scales[other]
        fold = self._off.begin(replace(last, unknowns=unknowns), place)
        if fold is None or fold.extremes[3] > _PART_OF_SIZE * abs(fold.extremes[2]):
            return None
        away = float((fold.unknowns - corner.unknowns)[FIRST:] @ fold.tangent[FIRST:])
        return fold if away > 0.0 else reversed_fold(fold)

    def _meet_belt(self, part: FoldPart, start: FoldOnCurve) -> FoldOnCurve | None:
        # From where folds off the belt cannot be followed: to those on it, if they are there.
        last = part.points[-1] if part.points else start
        if not float(last.extremes[3]) < _AT_CORNER * self._length:
            return None
        corner = self._corner_near(last)
        if corner is None:
            return None
        # What is smaller than the last distance at which a corner is left is not looked at.
        ways = [(corner.unknowns - one.unknowns)[FIRST:] for one in (*part.points[::-1], start)]
        long = (way for way in ways if np.linalg.norm(way) > _BEYOND[-1])
        turns = bool(corner.tangent[FIRST:] @ next(long, last.tangent[FIRST:]) < 0.0)
        while part.points and float(part.points[-1].extremes[3]) < _SETTLED * self._length:
            part.points.pop()
        count = len(part.points)
        part.events = {place: kind for place, kind in part.events.items() if place < count}
        part.events[count] = EventKind.CUSP if turns else EventKind.TOUCH
        part.points.append(corner)
        return corner

    def _corner_near(self, fold: FoldOnCurve) -> FoldOnCurve | None:
        # The touching fold near one that is hardly off the belt, with the tangent towards those on
        # it. Touching cycles are as near as the fold itself, and their curve has no corner.
        arrival = fold.tangent[FIRST:]
        place = FIRST + int(np.argmax(np.abs(arrival)))
        curve, touch = self._touching(fold, fold.unknowns[FIRST:], place)
        if touch is None:
            return None
        ahead = touch if touch.tangent[FIRST:] @ arrival > 0.0 else _reversed(touch)
        follower = Follower(curve, 0.0, self._tell, most=_MOST_TO_FOLD)
        for start in (ahead, _reversed(ahead)):
            found = follower.follow(start, step=_FIRST_STEP, until=EventKind.FOLD)
            if found.end is End.EVENT:
                corner = self._on.begin(found.points[-1], place)
                # It starts at its highest point, whose height the third unknown is.
                descends = corner is None or corner.tangent[2] < 0.0
                return corner if corner is None or descends else reversed_fold(corner)
        return None

    def _touching(
        self, fold: FoldOnCurve, values: FloatArray, place: int
    ) -> tuple[TouchCurve, OrbitOnCurve | None]:
        # The touching cycle near a fold, at a scaled value of one of the parameters.
        curve = TouchCurve(self.plane, self._length, self._period, go_on=self._go_on)
        real = fold.unknowns * self.scales
        x, vx, y, vy, period = real[:FIRST].tolist()
        x, vx, _, _ = highest_point(self.plane, (x, vx, y, vy), period, real[FIRST:])
        guess = np.array([x, vx, 0.0, 0.0, period, 0.0, 0.0]) / self.scales
        guess[FIRST:] = values
        return curve, curve.at(guess, place)


def _reversed(orbit: OrbitOnCurve) -> OrbitOnCurve:
    return replace(orbit, tangent=-orbit.tangent, determinant=-orbit.determinant)
