"""The curve of limit cycles along one parameter, as it is followed."""

import math
from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from fivtui.model import System

from .arclength import VALUE, OrbitCurve, OrbitOnCurve
from .events import (
    ORBIT_TESTS,
    EventKind,
    OrbitTest,
    change_of_course,
    confirmed,
    course,
    makeup,
    why_lost,
)
from .flow import FiniteBeltFlow, FloatArray, Flow, SliderBeltFlow
from .following import Bound, Courses

# Where in a stick a period may begin.
_INSIDE: Final = (0.25, 0.75)


class BranchCurve:
    """Periodic orbits of a flow along one parameter."""

    def __init__(
        self,
        flow: Flow,
        scales: FloatArray,
        low: float,
        high: float,
        lengths: tuple[float, float],
        *,
        go_on: Callable[[], bool] = lambda: True,
        touches: bool,
        courses: bool = False,
    ) -> None:
        self.scales = scales
        self.orbits = OrbitCurve(flow, scales, go_on=go_on)
        value = float(scales[VALUE])
        self.bounds = (Bound(len(scales) - 1, low / value, high / value),)
        # With sticks the sign of the determinant depends on where a period begins.
        left_out = {EventKind.BRANCH} if courses else set()
        if not touches:
            left_out.add(EventKind.TOUCH)
        self.tests: Mapping[EventKind, OrbitTest] = {
            kind: test for kind, test in ORBIT_TESTS.items() if kind not in left_out
        }
        self._lengths = np.repeat(lengths, 2)
        self._states = flow.states
        self.courses = (
            Courses(course, change_of_course, why_lost, self._centred) if courses else None
        )

    def correct(
        self,
        guess: FloatArray,
        here: OrbitOnCurve,
        along: FloatArray,
        tangent: FloatArray | None = None,
    ) -> OrbitOnCurve | None:
        """The orbit near a guess in the plane with the normal `along`: see `Curve`."""
        planes = np.zeros((2, len(guess)))
        planes[0, : self._states], planes[1] = here.across, along
        return self.orbits.solve(guess, planes, tangent)

    def size(self, point: OrbitOnCurve) -> float:
        """Amplitude of both displacements, scaled."""
        x_min, x_max, y_min, y_max = (point.extremes[:4] / self._lengths).tolist()
        return 0.5 * math.hypot(x_max - x_min, y_max - y_min)

    def features(self, point: OrbitOnCurve) -> FloatArray:
        """What does not depend on the phase."""
        return np.concatenate([point.unknowns[-2:], point.extremes[:4] / self._lengths])

    def _centred(self, point: OrbitOnCurve) -> OrbitOnCurve:
        # Cycles that stick begin within a stick, away from its ends.
        made = makeup(point)
        if made.sticks == 0.0 or _INSIDE[0] < made.place < _INSIDE[1]:
            return point
        moved = self.orbits.later(point, made.middle)
        if moved is None:
            return point
        return moved if makeup(moved).place > 0.0 and course(moved) == course(point) else point

    def confirmed(self, kind: EventKind, point: OrbitOnCurve) -> bool:
        """Whether an event is what its test looked for."""
        return confirmed(kind, point)


# A unit of the parameter is at least its range over this; a power of two scales without rounding.
_LEAST_UNIT: Final = 64.0


def slider_belt_curve(
    system: System,
    name: str,
    bounds: tuple[float, float],
    length: float,
    period: float,
    *,
    go_on: Callable[[], bool],
) -> BranchCurve:
    """The curve of the slider-belt model, in units of a length, a period, and about its value."""
    p = system.parameters
    always = p.v_belt is None
    low, high = bounds
    speed = 2.0 * math.pi * length / period
    value = 2.0 ** math.floor(math.log2(max(abs(getattr(p, name)), (high - low) / _LEAST_UNIT)))
    return BranchCurve(
        (SliderBeltFlow if always else FiniteBeltFlow)(system, (name,)),
        np.array([length, speed, length, speed, period, value]),
        low,
        high,
        (length, length),
        go_on=go_on,
        touches=system.separation,
        courses=not always,
    )
