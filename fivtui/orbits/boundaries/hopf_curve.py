"""Curves of Hopf points over two parameters, from their closed form."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from fivtui.equilibrium import lowest_critical_mu
from fivtui.model import Cancelled, ComputationError, InputError
from fivtui.orbits.curves.events import EventKind
from fivtui.orbits.curves.flow import FloatArray
from fivtui.orbits.curves.hopf import HopfPoint, hopf_point

from .plane import ParameterPlane

_MOST_ITERATIONS: Final = 20
_DIFFERENCE: Final = 1e-6
_EXACT: Final = 1e-13


@dataclass(frozen=True, slots=True)
class HopfOnCurve:
    """A Hopf point."""

    unknowns: FloatArray
    tangent: FloatArray
    hopf: HopfPoint
    iterations: int


class HopfCurve:
    """The points at which the friction coefficient is the critical one."""

    def __init__(self, plane: ParameterPlane, *, go_on: Callable[[], bool] = lambda: True) -> None:
        self._plane, self._go_on = plane, go_on
        self.scales = plane.units
        self.bounds = plane.bounds((0, 1))
        self.tests: Mapping[EventKind, Callable[[HopfOnCurve], float]] = {
            EventKind.BAUTIN: lambda point: point.hopf.lyapunov
        }

    def begin(self, values: tuple[float, float], place: int) -> HopfOnCurve | None:
        """The Hopf point near values of both parameters, with that at `place`."""
        return self._solve(np.array(values) / self.scales, np.eye(2)[place])

    def correct(
        self,
        guess: FloatArray,
        here: HopfOnCurve,  # noqa: ARG002
        along: FloatArray,
        tangent: FloatArray | None = None,
    ) -> HopfOnCurve | None:
        """The Hopf point near a guess on the line with the normal `along`: see `Curve`."""
        return self._solve(guess, along, tangent)

    def size(self, point: HopfOnCurve) -> float:  # noqa: ARG002
        """There is nothing in which the curve begins or ends."""
        return 1.0

    def features(self, point: HopfOnCurve) -> FloatArray:
        """The two parameters."""
        return point.unknowns

    def confirmed(self, kind: EventKind, point: HopfOnCurve) -> bool:  # noqa: ARG002
        """Whether an event is what its test looked for."""
        return True

    def _excess(self, unknowns: FloatArray) -> float | None:
        # The friction coefficient beyond the critical one; None without one.
        try:
            system = self._plane.at((unknowns * self.scales).tolist())
            critical = lowest_critical_mu(system)
        except (InputError, ComputationError):
            return None
        return None if critical is None else system.parameters.mu - critical

    def _slope(self, unknowns: FloatArray) -> FloatArray | None:
        slope = np.empty(2)
        for place, one in enumerate(np.eye(2)):
            step = _DIFFERENCE * one
            ahead, behind = self._excess(unknowns + step), self._excess(unknowns - step)
            if ahead is None or behind is None:
                # At an end of what a parameter may be.
                side = step if behind is None else -step
                beyond, here = ahead if behind is None else behind, self._excess(unknowns)
                if beyond is None or here is None:
                    return None
                slope[place] = (beyond - here) / side[place]
            else:
                slope[place] = (ahead - behind) / (2.0 * _DIFFERENCE)
        return slope

    def _solve(
        self, guess: FloatArray, along: FloatArray, tangent: FloatArray | None = None
    ) -> HopfOnCurve | None:
        if not self._go_on():
            raise Cancelled
        way, ahead = np.array([-along[1], along[0]]), along if tangent is None else tangent
        unknowns = guess.copy()
        for iteration in range(_MOST_ITERATIONS):
            excess, slope = self._excess(unknowns), self._slope(unknowns)
            if excess is None or slope is None or not slope @ way:
                return None
            change = excess / float(slope @ way)
            unknowns = unknowns - change * way
            if abs(change) <= _EXACT * float(np.abs(unknowns).max()):
                return self._completed(unknowns, slope, ahead, iteration)
        return None

    def _completed(
        self, unknowns: FloatArray, slope: FloatArray, way: FloatArray, iterations: int
    ) -> HopfOnCurve | None:
        direction = np.array([-slope[1], slope[0]]) / np.linalg.norm(slope)
        if direction @ way < 0.0:
            direction = -direction
        values = (unknowns * self.scales).tolist()
        try:
            system = self._plane.at(values)
        except InputError:
            return None
        hopf = hopf_point(system, self._plane.names[0])
        return HopfOnCurve(unknowns, direction, hopf, iterations)
