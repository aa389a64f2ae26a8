"""Curves of Hopf points over two parameters, from their closed form."""

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

_MAX_ITERATIONS: Final = 20
_CONVERGED: Final = 1e-13


@dataclass(frozen=True, slots=True)
class HopfOnCurve(PointOnCurve):
    """A Hopf point on a curve."""

    hopf: HopfPoint


class HopfCurve(Curve[HopfOnCurve]):
    """The points at which the friction coefficient equals the critical one."""

    def __init__(self, plane: ParameterPlane, work: Progress) -> None:
        self._plane, self._work = plane, work
        self.scales, self.bounds = plane.units, plane.bounds((0, 1))
        self.tests = {EventKind.BAUTIN: lambda point: point.hopf.lyapunov}

    def point_at(self, values: tuple[float, float], index: int) -> HopfOnCurve | None:
        """The Hopf point near values of both parameters; the one at this index stays fixed."""
        return self.correct(np.array(values) / self.scales, None, np.eye(2)[index])

    def correct(
        self,
        guess: FloatArray,
        near: HopfOnCurve | None,  # noqa: ARG002
        along: FloatArray,
        tangent: FloatArray | None = None,
    ) -> HopfOnCurve | None:
        """The Hopf point near a guess, on the line with the normal `along`: see `Curve`."""
        self._work.check()
        direction, unknowns = np.array([-along[1], along[0]]), guess.copy()
        iterations, change = 0, np.inf
        while abs(change) > _CONVERGED * float(np.abs(unknowns).max()):
            excess = self._excess(unknowns)
            if excess is None or not excess[1] @ direction or iterations == _MAX_ITERATIONS:
                return None
            difference, slope = excess
            change = difference / float(slope @ direction)
            unknowns = unknowns - change * direction
            iterations += 1
        curve_direction = np.array([-slope[1], slope[0]]) / np.linalg.norm(slope)
        if curve_direction @ (along if tangent is None else tangent) < 0.0:
            curve_direction = -curve_direction
        try:
            system = self._plane.system_at((unknowns * self.scales).tolist())
        except InputError:
            return None
        return HopfOnCurve(
            unknowns, curve_direction, iterations - 1, hopf_point(system, self._plane.names[0])
        )

    def _excess(self, unknowns: FloatArray) -> tuple[float, FloatArray] | None:
        # Friction coefficient less the critical one, and derivatives; None without a critical one.
        names = self._plane.names
        try:
            system = self._plane.system_at((unknowns * self.scales).tolist())
            critical, slopes = lowest_critical_mu(system), critical_mu_derivatives(system, names)
        except (InputError, ComputationError):
            return None
        if critical is None or slopes is None:
            return None
        slope = np.array([float(name == "mu") - slopes.get(name, 0.0) for name in names])
        return system.parameters.mu - critical, slope * self.scales
