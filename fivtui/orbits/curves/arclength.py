"""Curves of periodic orbits along a parameter, by pseudo-arclength continuation over shooting.

Unknowns are a state on the orbit, the period and the parameters that vary, each in a unit of its
own. The phase is fixed by a plane across the orbit before, so that no section of the motion is
needed and lift-off changes nothing.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.kernel import OrbitSearch, Varied, load_kernel, why_interpreted
from fivtui.model import PARAMETERS, Cancelled
from fivtui.taylor import local_tolerance, order_for
from fivtui.transient import MAX_T_END

from .flow import FLOW_TOL, MOST_STEPS, FloatArray, Flow, Return, SliderBeltFlow

# Places of the unknowns, from the last: of one parameter that varies.
VALUE: Final = -1
PERIOD: Final = -2
_MOST_ITERATIONS: Final = 8
# A residual below the first is not improved; one above the second, relative to the state, is none.
_EXACT: Final = 2e-13
_CONVERGED: Final = 1e-10


@dataclass(frozen=True, slots=True)
class OrbitOnCurve:
    """A periodic orbit, with the direction of the curve there."""

    unknowns: FloatArray
    tangent: FloatArray
    across: FloatArray
    monodromy: FloatArray
    extremes: FloatArray
    determinant: float
    iterations: int

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Floquet multipliers by falling size, without the one along the orbit."""
        values = np.linalg.eigvals(self.monodromy).astype(np.complex128)
        return values[np.argsort(-np.abs(values), kind="stable")]


class OrbitCurve:
    """The equations of the periodic orbits of a flow along the parameters that vary."""

    def __init__(
        self, flow: Flow, scales: FloatArray, *, go_on: Callable[[], bool] = lambda: True
    ) -> None:
        self._flow, self.scales, self._go_on = flow, scales, go_on
        self._states, self._count = flow.states, len(scales)
        self._search = _compiled(flow, scales) if isinstance(flow, SliderBeltFlow) else None

    def solve(
        self,
        guess: FloatArray,
        planes: FloatArray,
        along: FloatArray | None = None,
        *,
        turning: bool = True,
    ) -> OrbitOnCurve | None:
        """The periodic orbit near a guess; None if Newton's method finds none."""
        if not self._go_on():
            raise Cancelled
        if not np.isfinite(guess).all():
            return None
        way = planes[-1] if along is None else along
        if self._search is not None:
            found = self._search.solve(guess, planes, way, turning=turning)
            return None if found is None else OrbitOnCurve(*found)
        return self._newton(guess, planes, way, turning=turning)

    def returns_after(self, orbit: OrbitOnCurve, share: float) -> float:
        """How far an orbit is from its start after a share of its period, relative to its size."""
        values, states = orbit.unknowns * self.scales, self._states
        there = self._flow.follow(
            values[:states], share * float(values[states]), values[states + 1 :]
        )
        if there is None:
            return np.inf
        away = np.abs(there.final / self.scales[:states] - orbit.unknowns[:states]).max()
        return float(away / np.abs(orbit.unknowns[:states]).max())

    def later(self, orbit: OrbitOnCurve, share: float) -> OrbitOnCurve | None:
        """The same orbit, beginning a share of its period later; None if it is not found."""
        values, states = orbit.unknowns * self.scales, self._states
        there = self._flow.follow(
            values[:states], share * float(values[states]), values[states + 1 :]
        )
        if there is None:
            return None
        guess, along = orbit.unknowns.copy(), orbit.tangent.copy()
        guess[:states] = there.final / self.scales[:states]
        # The way along the curve is that of period and parameters.
        along[:states] = 0.0
        planes = np.eye(self._count)[states:]
        planes[0] = 0.0
        planes[0, :states] = there.rate / self.scales[:states]
        planes[0] /= np.linalg.norm(planes[0])
        return self.solve(guess, planes, along)

    def _newton(
        self, guess: FloatArray, planes: FloatArray, along: FloatArray, *, turning: bool
    ) -> OrbitOnCurve | None:
        # As `orbit_solve` in the compiled kernel does it.
        states = self._states
        unknowns = guess.copy()
        system = np.zeros((self._count, self._count))
        system[states:] = planes
        least, best, size = np.inf, None, 0.0
        for iteration in range(_MOST_ITERATIONS):
            there = self._return(unknowns)
            if there is None:
                break
            self._fill(system, there)
            missed = np.zeros(self._count)
            missed[:states] = there.final / self.scales[:states] - unknowns[:states]
            missed[states:] = planes @ (unknowns - guess)
            residual, here = float(np.abs(missed).max()), float(np.abs(unknowns[:states]).max())
            if residual < least:
                least, best, size = residual, (unknowns, there, iteration), here
            elif least < _CONVERGED * size:
                break
            if residual < _EXACT * here:
                break
            try:
                unknowns = unknowns - np.linalg.solve(system, missed)
            except np.linalg.LinAlgError:
                break
        if best is None or not least < _CONVERGED * size:
            return None
        return self._completed(best, planes, along, turning=turning)

    def _completed(
        self,
        found: tuple[FloatArray, Return, int],
        planes: FloatArray,
        along: FloatArray,
        *,
        turning: bool,
    ) -> OrbitOnCurve | None:
        (unknowns, there, iterations), states = found, self._states
        system = np.zeros((self._count, self._count))
        self._fill(system, there)
        system[states:], system[-1] = planes, along
        rate = there.rate / self.scales[:states]
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
        # Directions across the orbit: the columns of a reflection of the first axis to its own.
        turn = across.copy()
        turn[0] += -1.0 if across[0] < 0.0 else 1.0
        basis = (np.eye(states) - np.outer(turn, 2.0 / (turn @ turn) * turn))[:, 1:]
        monodromy = basis.T @ (system[:states, :states] + np.eye(states)) @ basis
        determinant = float(np.linalg.det(system))
        return OrbitOnCurve(
            unknowns, tangent, across, monodromy, there.extremes, determinant, iterations
        )

    def _return(self, unknowns: FloatArray) -> Return | None:
        values = unknowns * self.scales
        period = float(values[self._states])
        if not np.isfinite(values).all() or not period > 0.0:
            return None
        return self._flow.follow(values[: self._states], period, values[self._states + 1 :])

    def _fill(self, system: FloatArray, there: Return) -> None:
        n, scales = self._states, self.scales
        units = scales[:n, None]
        system[:n, :n] = there.derivatives[:, :n] * scales[:n] / units - np.eye(n)
        system[:n, n] = there.rate * scales[n] / scales[:n]
        system[:n, n + 1 :] = there.derivatives[:, n:] * scales[n + 1 :] / units


def _compiled(flow: SliderBeltFlow, scales: FloatArray) -> OrbitSearch | None:
    if why_interpreted() is not None:
        return None
    tol = local_tolerance(FLOW_TOL)
    places: Mapping[str, int] = {name: place for place, name in enumerate(PARAMETERS)}
    specs = (PARAMETERS[name] for name in flow.names)
    return load_kernel().orbits(
        parameters=[getattr(flow.system.parameters, name) for name in PARAMETERS],
        varied=[Varied(places[spec.name], spec.lower, spec.upper) for spec in specs],
        scales=scales,
        separation=flow.system.separation,
        tol=tol,
        order=order_for(tol),
        longest=MAX_T_END,
        budget=MOST_STEPS,
    )
