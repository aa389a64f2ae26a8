"""Curves of periodic orbits along a parameter, by pseudo-arclength continuation over shooting.

Unknowns are a state on the orbit, the period and the parameters that vary, each in a unit of its
own. A plane across the previous orbit fixes the phase, so that no section of the motion is needed
and lift-off has no effect.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, Generic, NamedTuple, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from fivtui.kernel import OrbitSearch, Varied, load_kernel, why_interpreted
from fivtui.model import PARAMETERS, Progress
from fivtui.taylor import local_tolerance, order_for
from fivtui.transient import MAX_T_END

from .flow import FLOW_TOL, MOST_STEPS, FloatArray, Flow, Return, SliderBeltFlow
from .following import Bound, Curve, PointOnCurve

# Indices of the last unknowns, for one parameter that varies.
VALUE: Final = -1
PERIOD: Final = -2
UNWATCHED: Final = Progress(None)

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class OrbitOnCurve(PointOnCurve):
    """A periodic orbit, with the direction of the curve there."""

    across: FloatArray
    monodromy: FloatArray
    extremes: FloatArray
    determinant: float

    def reversed(self) -> Self:
        """The same orbit with the tangent reversed."""
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
    """A curve of limit cycles in units of its scales."""

    def __init__(self, scales: FloatArray, bounds: Sequence[Bound]) -> None:
        self.scales, self.bounds = scales, bounds

    def size(self, point: Orbit) -> float:
        """Amplitude of both displacements, scaled."""
        x_min, x_max, y_min, y_max = (point.extremes[:4] / self.scales[0]).tolist()
        return 0.5 * math.hypot(x_max - x_min, y_max - y_min)

    def features(self, point: Orbit) -> FloatArray:
        """Quantities that do not depend on the phase: period, parameters and extremes."""
        states = len(point.across)
        return np.concatenate([point.unknowns[states:], point.extremes[:4] / self.scales[0]])


class Limits(NamedTuple):
    """Limits of Newton's method: iterations, and residuals relative to the state.

    Iteration stops at a residual below `exact`; above `converged` there is no root.
    """

    iterations: int
    exact: float
    converged: float


class Root(NamedTuple, Generic[T]):
    """A root of equations, derivatives and data of the equations there, and iterations."""

    unknowns: FloatArray
    derivatives: FloatArray
    belonging: T
    iterations: int


def find_root(
    equations: Callable[[FloatArray], tuple[FloatArray, FloatArray, T] | None],
    guess: FloatArray,
    states: int,
    limits: Limits,
) -> Root[T] | None:
    """The root of equations near a guess by Newton's method; None if it finds none.

    `equations` returns residuals, derivatives and data to keep; None where they have no value.
    """
    # The compiled kernel has the same algorithm in `orbit_solve`.
    unknowns, least, best, accepted = guess, np.inf, None, 0.0
    for iteration in range(limits.iterations):
        values = equations(unknowns)
        if values is None:
            break
        residuals, derivatives, belonging = values
        residual = float(np.abs(residuals).max())
        size = float(np.abs(unknowns[:states]).max())
        if residual < least:
            least, accepted = residual, limits.converged * size
            best = Root(unknowns, derivatives, belonging, iteration)
        elif least < accepted:
            break
        if residual < limits.exact * size:
            break
        try:
            unknowns = unknowns - np.linalg.solve(derivatives, residuals)
        except np.linalg.LinAlgError:
            break
    return best if least < accepted else None


def directions_across(direction: FloatArray) -> FloatArray:
    """Unit vectors across a direction: columns of a reflection of the first axis to it."""
    normal = direction.copy()
    normal[0] += -1.0 if direction[0] < 0.0 else 1.0
    basis: FloatArray = (
        np.eye(len(direction)) - np.outer(normal, 2.0 / (normal @ normal) * normal)
    )[:, 1:]
    return basis


_LIMITS: Final = Limits(iterations=8, exact=2e-13, converged=1e-10)


class OrbitCurve:
    """The equations of the periodic orbits of a flow along the parameters that vary."""

    def __init__(self, flow: Flow, scales: FloatArray, work: Progress = UNWATCHED) -> None:
        self._flow, self.scales, self._work = flow, scales, work
        self._states, self._count = flow.states, len(scales)
        self._search = _compiled_search(flow, scales)

    def solve(
        self,
        guess: FloatArray,
        planes: FloatArray,
        along: FloatArray | None = None,
        *,
        turning: bool = True,
    ) -> OrbitOnCurve | None:
        """The periodic orbit near a guess in planes through the guess; None without one.

        The tangent points along `along`, by default the normal of the last plane. It is in the
        plane across the orbit if `turning`, else in the first plane.
        """
        self._work.check()
        if not np.isfinite(guess).all():
            return None
        direction = planes[-1] if along is None else along
        if self._search is not None:
            orbit = self._search.solve(guess, planes, direction, turning=turning)
            return None if orbit is None else OrbitOnCurve(**orbit._asdict())
        states = self._states

        def equations(unknowns: FloatArray) -> tuple[FloatArray, FloatArray, Return] | None:
            motion = self.motion(unknowns)
            if motion is None:
                return None
            residuals = [self.closure_error(unknowns, motion), planes @ (unknowns - guess)]
            return np.concatenate(residuals), np.vstack([self.shooting(motion), planes]), motion

        root = find_root(equations, guess, states, _LIMITS)
        if root is None:
            return None
        return self.with_tangent(root, root.belonging, direction, turning=turning)

    def returns_after(self, orbit: OrbitOnCurve, share: float) -> float:
        """Distance of an orbit from its start after a share of its period, relative to its size."""
        motion = self.motion(orbit.unknowns, share)
        if motion is None:
            return np.inf
        state = orbit.unknowns[: self._states]
        away = np.abs(self.closure_error(orbit.unknowns, motion)).max()
        return float(away / np.abs(state).max())

    def later(self, orbit: OrbitOnCurve, share: float) -> OrbitOnCurve | None:
        """The same orbit, beginning a share of its period later; None if it is not found."""
        motion, states = self.motion(orbit.unknowns, share), self._states
        if motion is None:
            return None
        guess, along = orbit.unknowns.copy(), orbit.tangent.copy()
        guess[:states] = motion.final / self.scales[:states]
        # The direction along the curve is given by period and parameters.
        along[:states] = 0.0
        planes = np.eye(self._count)[states:]
        planes[0] = 0.0
        planes[0, :states] = motion.rate / self.scales[:states]
        planes[0] /= np.linalg.norm(planes[0])
        return self.solve(guess, planes, along)

    def motion(self, unknowns: FloatArray, share: float = 1.0) -> Return | None:
        """The motion over a share of a period; None if there is none."""
        values, states = unknowns * self.scales, self._states
        period = float(values[states])
        if not np.isfinite(values).all() or not period > 0.0:
            return None
        return self._flow.follow(values[:states], share * period, values[states + 1 :])

    def closure_error(self, unknowns: FloatArray, motion: Return) -> FloatArray:
        """Scaled distance of the end of a motion from its start."""
        distance: FloatArray = motion.final / self.scales[: self._states]
        return distance - unknowns[: self._states]

    def shooting(self, motion: Return) -> FloatArray:
        """Derivatives of `closure_error` by the unknowns."""
        n, scales = self._states, self.scales
        units = scales[:n, None]
        rows = np.empty((n, self._count))
        rows[:, :n] = motion.derivatives[:, :n] * scales[:n] / units - np.eye(n)
        rows[:, n] = motion.rate * scales[n] / scales[:n]
        rows[:, n + 1 :] = motion.derivatives[:, n:] * scales[n + 1 :] / units
        return rows

    def with_tangent(
        self, root: Root[T], motion: Return, along: FloatArray, *, turning: bool = True
    ) -> OrbitOnCurve | None:
        """The orbit of a root with its tangent; None where the equations are singular."""
        system, states = root.derivatives.copy(), self._states
        system[-1] = along
        rate = motion.rate / self.scales[:states]
        across = rate / np.linalg.norm(rate)
        if turning:
            system[states] = 0.0
            system[states, :states] = across
        try:
            tangent = np.linalg.solve(system, np.eye(self._count)[-1])
        except np.linalg.LinAlgError:
            return None
        tangent = tangent / np.linalg.norm(tangent)
        system[-1] = tangent
        basis = directions_across(across)
        return OrbitOnCurve(
            root.unknowns,
            tangent,
            root.iterations,
            across,
            basis.T @ (system[:states, :states] + np.eye(states)) @ basis,
            motion.extremes,
            float(np.linalg.det(system)),
        )


def _compiled_search(flow: Flow, scales: FloatArray) -> OrbitSearch | None:
    if not isinstance(flow, SliderBeltFlow) or flow.system.parameters.v_belt is not None:
        return None
    if why_interpreted() is not None:
        return None
    tol = local_tolerance(FLOW_TOL)
    indices = {name: index for index, name in enumerate(PARAMETERS)}
    specs = (PARAMETERS[name] for name in flow.names)
    return load_kernel().orbits(
        parameters=[getattr(flow.system.parameters, name) for name in PARAMETERS],
        varied=[Varied(indices[spec.name], spec.lower, spec.upper) for spec in specs],
        scales=scales,
        separation=flow.system.separation,
        tol=tol,
        order=order_for(tol),
        longest=MAX_T_END,
        budget=MOST_STEPS,
    )
