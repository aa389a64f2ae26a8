"""Curves of Hopf points over two parameters, where μ equals the critical friction coefficient.

At the critical friction coefficient the equilibrium loses stability; there is at most one. The
unknowns are both parameters, each divided by its unit.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from fivtui.equilibrium import critical_mu_derivatives, lowest_critical_mu
from fivtui.model import ComputationError, InputError, Progress
from fivtui.orbits.curves.events import EventKind
from fivtui.orbits.curves.flow import FloatArray
from fivtui.orbits.curves.following import Curve, PointOnCurve
from fivtui.orbits.curves.hopf import HopfPoint, hopf_point

from .plane import ParameterPlane

# Newton's method ends at a step below this, relative to the unknowns.
_CONVERGED: Final = 1e-13
_MAX_ITERATIONS: Final = 20


@dataclass(frozen=True, slots=True)
class HopfOnCurve(PointOnCurve):
    """A Hopf point on a curve, with its frequency and Lyapunov coefficient."""

    hopf: HopfPoint


class HopfCurve(Curve[HopfOnCurve]):
    """The points at which the friction coefficient equals the critical one."""

    def __init__(self, plane: ParameterPlane, work: Progress) -> None:
        self._plane, self._work = plane, work
        self.scales, self.bounds = plane.units, plane.bounds((0, 1))
        # A Bautin point is where its test is zero.
        self.tests = {EventKind.BAUTIN: lambda point: point.hopf.lyapunov}

    def point_at(self, values: tuple[float, float], fixed_index: int) -> HopfOnCurve | None:
        """The Hopf point near values of both parameters; the one at `fixed_index` keeps its value.

        The values are in SI units.
        """
        return self.correct(np.array(values) / self.scales, None, np.eye(2)[fixed_index])

    def correct(
        self,
        guess: FloatArray,
        neighbour: HopfOnCurve | None,  # noqa: ARG002
        normal: FloatArray,
        heading: FloatArray | None = None,
    ) -> HopfOnCurve | None:
        """The Hopf point near a guess, on the line through it with this normal.

        The tangent points to the side of `heading`, by default of the normal. `neighbour` is an
        argument of `Curve.correct` that Hopf points do not need.
        """
        self._work.check()
        line_direction, unknowns = _turn_left(normal), guess.copy()
        iterations, step = 0, np.inf
        while abs(step) > _CONVERGED * float(np.abs(unknowns).max()):
            if iterations == _MAX_ITERATIONS or (excess := self._excess(unknowns)) is None:
                return None
            difference, gradient = excess
            slope = float(gradient @ line_direction)
            if slope == 0.0:
                return None
            step = difference / slope
            unknowns = unknowns - step * line_direction
            iterations += 1
        tangent = _turn_left(gradient) / np.linalg.norm(gradient)
        if tangent @ (normal if heading is None else heading) < 0.0:
            tangent = -tangent
        try:
            system = self._plane.system_at((unknowns * self.scales).tolist())
        except InputError:
            return None
        return HopfOnCurve(
            unknowns,
            tangent,
            # The last step is within the tolerance and not counted.
            iterations=iterations - 1,
            # The name only selects the parameter whose value a `HopfPoint` has.
            hopf=hopf_point(system, name=self._plane.names[0]),
        )

    def _excess(self, unknowns: FloatArray) -> tuple[float, FloatArray] | None:
        # Friction coefficient less the critical one, and its derivatives by the unknowns; None
        # without a critical one.
        names = self._plane.names
        try:
            system = self._plane.system_at((unknowns * self.scales).tolist())
            critical, slopes = lowest_critical_mu(system), critical_mu_derivatives(system, names)
        except (InputError, ComputationError):
            return None
        if critical is None or slopes is None:
            return None
        gradient = np.array([float(name == "mu") - slopes.get(name, 0.0) for name in names])
        return system.parameters.mu - critical, gradient * self.scales


def _turn_left(vector: FloatArray) -> FloatArray:
    # The vector turned by 90°.
    return np.array([-vector[1], vector[0]])
