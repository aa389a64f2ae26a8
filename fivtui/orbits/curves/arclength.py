"""Curves of periodic orbits along a parameter, by pseudo-arclength continuation over shooting.

Unknowns are a state on the orbit, the period and the parameters that vary, each divided by its
unit. A plane normal to the previous orbit fixes the phase. Unlike a section of the motion, such as
lift-off, this plane always meets the orbit.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, Generic, NamedTuple, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from fivtui.kernel import OrbitSearch, VariedParameter, load_kernel, why_interpreted
from fivtui.model import PARAMETERS, Progress
from fivtui.taylor import local_tolerance, order_for
from fivtui.transient import MAX_T_END

from .flow import (
    FLOW_TOL,
    MAX_FLOW_STEPS,
    POSITION_EXTREME_COUNT,
    Y_MAX,
    Y_MIN,
    FloatArray,
    Flow,
    MotionEnd,
    SliderBeltFlow,
)
from .following import Bound, Curve, PointOnCurve

# Indices among the unknowns of an orbit along a single parameter: the parameter, and the period.
PARAMETER: Final = -1
PERIOD: Final = -2
# Progress that is reported to nobody, and cannot be cancelled.
SILENT_PROGRESS: Final = Progress(None)

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class OrbitOnCurve(PointOnCurve):
    """A periodic orbit on a curve.

    `flow_direction` is the unit vector of the motion at its start, scaled. `monodromy` maps
    deviations normal to it over a period. `extremes` begin with x_min, x_max, y_min and y_max, m,
    and continue as in `MotionEnd`. `determinant` is that of the equations, with the tangent as last
    row.
    """

    flow_direction: FloatArray
    monodromy: FloatArray
    extremes: FloatArray
    determinant: float

    @property
    def y_min(self) -> float:
        """Lowest point, m."""
        return float(self.extremes[Y_MIN])

    @property
    def y_max(self) -> float:
        """Highest point, m."""
        return float(self.extremes[Y_MAX])

    def reversed(self) -> Self:
        """The orbit with the tangent reversed."""
        return replace(self, tangent=-self.tangent, determinant=-self.determinant)

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Floquet multipliers by falling size, without the one along the orbit."""
        values = np.linalg.eigvals(self.monodromy).astype(np.complex128)
        return values[np.argsort(-np.abs(values), kind="stable")]


Orbit = TypeVar("Orbit", bound=OrbitOnCurve)


def cycle_scales(length: float, period: float, *units: float) -> FloatArray:
    """Units of the unknowns: state (from `length` and `period`), period, and parameters."""
    speed = 2.0 * math.pi * length / period
    return np.array([length, speed, length, speed, period, *units])


class CycleCurve(Curve[Orbit]):
    """A curve of limit cycles; `scales` are the units of its unknowns."""

    def __init__(self, scales: FloatArray, bounds: Sequence[Bound]) -> None:
        self.scales, self.bounds = scales, bounds

    def size(self, point: Orbit) -> float:
        """Amplitude of x and y together, scaled."""
        x_min, x_max, y_min, y_max = self._scaled_extremes(point).tolist()
        return 0.5 * math.hypot(x_max - x_min, y_max - y_min)

    def features(self, point: Orbit) -> FloatArray:
        """Quantities by which cycles of any phase are compared: period, parameters, extremes."""
        state_count = len(point.flow_direction)
        return np.concatenate([point.unknowns[state_count:], self._scaled_extremes(point)])

    def _scaled_extremes(self, point: Orbit) -> FloatArray:
        # Extremes of x and y in units of length.
        extremes: FloatArray = point.extremes[:POSITION_EXTREME_COUNT] / self.scales[0]
        return extremes


class NewtonLimits(NamedTuple):
    """Limits of Newton's method: iterations, and residuals relative to the state.

    Iteration stops below `negligible`; a root is accepted below `accepted`.
    """

    iterations: int
    negligible: float
    accepted: float


class Root(NamedTuple, Generic[T]):
    """A root of equations, with their derivatives and `data` there, and the iterations used.

    `data` is what the equations return beside residuals and derivatives, such as the motion.
    """

    unknowns: FloatArray
    derivatives: FloatArray
    data: T
    iterations: int


def find_root(
    equations: Callable[[FloatArray], tuple[FloatArray, FloatArray, T] | None],
    guess: FloatArray,
    state_count: int,
    limits: NewtonLimits,
) -> Root[T] | None:
    """The root of equations near a guess by Newton's method; None if it does not converge.

    `equations` returns residuals, derivatives and `data`, or None where undefined. The first
    `state_count` unknowns are the state, whose size scales the limits.
    """
    # The compiled kernel has the same algorithm in `orbit_solve`.
    unknowns, best = guess, None
    # Residual at the best iterate, and the residual below which that one is accepted.
    least_residual, tolerance = np.inf, 0.0
    for iteration in range(limits.iterations):
        values = equations(unknowns)
        if values is None:
            break
        residuals, derivatives, data = values
        residual = float(np.abs(residuals).max())
        size = float(np.abs(unknowns[:state_count]).max())
        if residual < least_residual:
            least_residual, tolerance = residual, limits.accepted * size
            best = Root(unknowns, derivatives, data, iteration)
        elif least_residual < tolerance:
            # The residual does not fall below rounding: the best iterate is accepted.
            break
        if residual < limits.negligible * size:
            break
        try:
            unknowns = unknowns - np.linalg.solve(derivatives, residuals)
        except np.linalg.LinAlgError:
            break
    return best if least_residual < tolerance else None


def normal_basis(direction: FloatArray) -> FloatArray:
    """Orthonormal basis, in columns, of the plane normal to a unit vector.

    A Householder reflection maps the first axis to the vector or its opposite, and so the further
    axes to the basis.
    """
    normal = direction.copy()
    normal[0] += -1.0 if direction[0] < 0.0 else 1.0
    basis: FloatArray = (
        np.eye(len(direction)) - np.outer(normal, 2.0 / (normal @ normal) * normal)
    )[:, 1:]
    return basis


_NEWTON_LIMITS: Final = NewtonLimits(iterations=8, negligible=2e-13, accepted=1e-10)


class OrbitCurve:
    """The equations of the periodic orbits of a flow along the parameters that vary."""

    def __init__(self, flow: Flow, scales: FloatArray, work: Progress = SILENT_PROGRESS) -> None:
        self._flow, self.scales, self._work = flow, scales, work
        self._state_count, self._unknown_count = flow.state_count, len(scales)
        self._search = _compiled_search(flow, scales)

    def solve(
        self,
        guess: FloatArray,
        normals: FloatArray,
        heading: FloatArray | None = None,
        *,
        is_normal_to_flow: bool = True,
    ) -> OrbitOnCurve | None:
        """The periodic orbit near a guess in planes through it; None without convergence.

        The planes have these `normals`. The tangent is normal to all `normals` but the last; if
        `is_normal_to_flow`, the direction of the flow replaces the first of them. The tangent
        points to the side of `heading`, by default of the last normal.
        """
        self._work.check()
        if not np.isfinite(guess).all():
            return None
        heading = normals[-1] if heading is None else heading
        if self._search is not None:
            orbit = self._search.solve(guess, normals, heading, is_normal_to_flow=is_normal_to_flow)
            return None if orbit is None else OrbitOnCurve(**orbit._asdict())
        state_count = self._state_count

        def equations(unknowns: FloatArray) -> tuple[FloatArray, FloatArray, MotionEnd] | None:
            motion = self.motion(unknowns)
            if motion is None:
                return None
            residuals = [self.closure_error(unknowns, motion), normals @ (unknowns - guess)]
            return np.concatenate(residuals), np.vstack([self.jacobian(motion), normals]), motion

        root = find_root(equations, guess, state_count, _NEWTON_LIMITS)
        if root is None:
            return None
        return self.orbit_with_tangent(
            root, root.data, heading, is_normal_to_flow=is_normal_to_flow
        )

    def return_distance(self, orbit: OrbitOnCurve, share: float) -> float:
        """Distance of an orbit from its start after a share of its period, relative to its size."""
        motion = self.motion(orbit.unknowns, share)
        if motion is None:
            return np.inf
        state = orbit.unknowns[: self._state_count]
        distance = np.abs(self.closure_error(orbit.unknowns, motion)).max()
        return float(distance / np.abs(state).max())

    def restart_later(self, orbit: OrbitOnCurve, share: float) -> OrbitOnCurve | None:
        """The orbit, starting a share of its period later; None if it is not found."""
        motion, state_count = self.motion(orbit.unknowns, share), self._state_count
        if motion is None:
            return None
        guess, heading = orbit.unknowns.copy(), orbit.tangent.copy()
        guess[:state_count] = motion.final / self.scales[:state_count]
        # Period and parameters determine the direction of the tangent.
        heading[:state_count] = 0.0
        # One plane fixes the phase, the others the parameters.
        flow_normal = np.zeros(self._unknown_count)
        flow_normal[:state_count] = motion.rate / self.scales[:state_count]
        flow_normal /= np.linalg.norm(flow_normal)
        parameter_normals = np.eye(self._unknown_count)[state_count + 1 :]
        return self.solve(guess, np.vstack([flow_normal, parameter_normals]), heading)

    def motion(self, unknowns: FloatArray, share: float = 1.0) -> MotionEnd | None:
        """The motion over a share of a period; None where it cannot be computed."""
        values, state_count = unknowns * self.scales, self._state_count
        period = float(values[state_count])
        if not np.isfinite(values).all() or not period > 0.0:
            return None
        return self._flow.follow(values[:state_count], share * period, values[state_count + 1 :])

    def closure_error(self, unknowns: FloatArray, motion: MotionEnd) -> FloatArray:
        """Scaled distance of the end of a motion from its start."""
        distance: FloatArray = motion.final / self.scales[: self._state_count]
        return distance - unknowns[: self._state_count]

    def jacobian(self, motion: MotionEnd) -> FloatArray:
        """Derivatives of `closure_error` by the unknowns."""
        n, scales = self._state_count, self.scales
        units = scales[:n, None]
        rows = np.empty((n, self._unknown_count))
        rows[:, :n] = motion.derivatives[:, :n] * scales[:n] / units - np.eye(n)
        rows[:, n] = motion.rate * scales[n] / scales[:n]
        rows[:, n + 1 :] = motion.derivatives[:, n:] * scales[n + 1 :] / units
        return rows

    def orbit_with_tangent(
        self,
        root: Root[T],
        motion: MotionEnd,
        heading: FloatArray,
        *,
        is_normal_to_flow: bool = True,
    ) -> OrbitOnCurve | None:
        """The orbit of a root with its tangent; None where the equations are singular."""
        # The product of each row and the tangent is 0, except that of the heading, the last row.
        matrix, state_count = root.derivatives.copy(), self._state_count
        matrix[-1] = heading
        rate = motion.rate / self.scales[:state_count]
        flow_direction = rate / np.linalg.norm(rate)
        if is_normal_to_flow:
            matrix[state_count] = 0.0
            matrix[state_count, :state_count] = flow_direction
        try:
            tangent = np.linalg.solve(matrix, np.eye(self._unknown_count)[-1])
        except np.linalg.LinAlgError:
            return None
        tangent = tangent / np.linalg.norm(tangent)
        # With the tangent as last row the determinant is zero only where curves of orbits cross.
        matrix[-1] = tangent
        # The equations are the end less the start, so that the start's derivative is added again.
        derivatives_by_start = matrix[:state_count, :state_count] + np.eye(state_count)
        basis = normal_basis(flow_direction)
        return OrbitOnCurve(
            root.unknowns,
            tangent,
            root.iterations,
            flow_direction=flow_direction,
            monodromy=basis.T @ derivatives_by_start @ basis,
            extremes=motion.extremes,
            determinant=float(np.linalg.det(matrix)),
        )


def _compiled_search(flow: Flow, scales: FloatArray) -> OrbitSearch | None:
    # The search in the compiled kernel, which knows the belt without `v_belt` alone: there the
    # slider never sticks. None for other flows, and where no kernel is compiled.
    if not isinstance(flow, SliderBeltFlow) or flow.system.parameters.v_belt is not None:
        return None
    if why_interpreted() is not None:
        return None
    tol = local_tolerance(FLOW_TOL)
    indices = {name: index for index, name in enumerate(PARAMETERS)}
    specs = (PARAMETERS[name] for name in flow.names)
    return load_kernel().orbit_search(
        parameters=[getattr(flow.system.parameters, name) for name in PARAMETERS],
        varied=[VariedParameter(indices[spec.name], spec.lower, spec.upper) for spec in specs],
        scales=scales,
        separation=flow.system.separation,
        tol=tol,
        # The order of the Taylor polynomials.
        order=order_for(tol),
        max_period=MAX_T_END,
        budget=MAX_FLOW_STEPS,
    )
