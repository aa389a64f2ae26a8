"""Curves of periodic orbits along a parameter, by pseudo-arclength continuation over shooting.

Unknowns are a state on the orbit, the period and the parameter. The phase is fixed by a plane
across the orbit before, so that no section of the motion is needed and lift-off changes nothing.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import (
    Cancelled,
    ComputationError,
    InputError,
    Parameters,
    equilibrium,
)
from fivtui.taylor import Seed
from fivtui.transient import START_SEEDS, Request, Variation, vary

FloatArray = NDArray[np.float64]

# Places of the unknowns.
PERIOD: Final = 4
VALUE: Final = 5
_FLOW_TOL: Final = 1e-13
_MOST_STEPS: Final = 20_000
_MOST_ITERATIONS: Final = 8
# A residual below the first is not improved; one above the second, relative to the state, is none.
_EXACT: Final = 2e-13
_CONVERGED: Final = 1e-10


@dataclass(frozen=True, slots=True)
class OrbitOnCurve:
    """A periodic orbit, with the direction of the curve there.

    Attributes
    ----------
    unknowns : ndarray, shape (6,)
        State, period and parameter, in units of the scales of the curve.
    flow : Variation
        One period of the motion from the state.
    across : ndarray, shape (6,)
        Normal of the plane in which the next orbit is looked for.
    tangent : ndarray, shape (6,)
        Unit tangent of the curve.
    monodromy : ndarray, shape (3, 3)
        The return map's derivative across the orbit, in scaled coordinates: its eigenvalues are the
        Floquet multipliers but for the one along the orbit.
    determinant : float
        Of the scaled equations with the tangent; zero at a branch point, not at a fold.
    iterations : int
        Of Newton's method.
    """

    unknowns: FloatArray
    flow: Variation
    across: FloatArray
    tangent: FloatArray
    monodromy: FloatArray
    determinant: float
    iterations: int

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Floquet multipliers by falling size, without the one along the orbit."""
        values = np.linalg.eigvals(self.monodromy).astype(np.complex128)
        return values[np.argsort(-np.abs(values), kind="stable")]


class OrbitCurve:
    """The equations of the periodic orbits of a parameter set along a parameter.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    name : str
        The parameter that varies.
    scales : ndarray, shape (6,)
        Units of state, period and parameter in which distances along the curve are measured.
    separation : bool
        Whether separation is considered.
    go_on : callable
        Called before every motion; cancels the work by returning False.
    """

    def __init__(
        self,
        p: Parameters,
        name: str,
        scales: FloatArray,
        *,
        separation: bool = True,
        go_on: Callable[[], bool] = lambda: True,
    ) -> None:
        self._p, self._name, self.scales = p, name, scales
        self._separation, self._go_on = separation, go_on
        self._seeds = [*START_SEEDS, Seed((0.0, 0.0, 0.0, 0.0), {name: 1.0})]

    def parameters(self, unknowns: FloatArray) -> Parameters:
        """The parameter set of an orbit."""
        return self._p.with_values({self._name: float(unknowns[VALUE] * self.scales[VALUE])})

    def from_rest(self, unknowns: FloatArray) -> float:
        """Scaled distance of the state from the equilibrium."""
        point = equilibrium(self.parameters(unknowns), separation=self._separation)
        rest = np.array([point.x, 0.0, point.y, 0.0]) / self.scales[:4]
        return float(np.linalg.norm(unknowns[:4] - rest))

    def solve(
        self,
        guess: FloatArray,
        across: FloatArray,
        along: FloatArray,
        tangent: FloatArray | None = None,
    ) -> OrbitOnCurve | None:
        """The periodic orbit near a guess; None if Newton's method finds none.

        Parameters
        ----------
        guess : ndarray, shape (6,)
            Scaled unknowns.
        across, along : ndarray, shape (6,)
            Normals of the two planes through the guess in which it is looked for.
        tangent : ndarray, shape (6,), optional
            Direction along the curve that the new tangent is to have; `along` if not given.

        Raises
        ------
        Cancelled
            If `go_on` returned False.
        """
        unknowns = guess.copy()
        system = np.zeros((6, 6))
        system[4], system[5] = across, along
        least, best = np.inf, None
        for iteration in range(_MOST_ITERATIONS):
            flow = self._flow(unknowns)
            if flow is None:
                break
            self._fill(system, flow)
            missed = np.zeros(6)
            missed[:4] = np.array(flow.final) / self.scales[:4] - unknowns[:4]
            away = unknowns - guess
            missed[4:] = across @ away, along @ away
            residual = float(np.abs(missed).max())
            size = float(np.abs(unknowns[:4]).max())
            if residual < least:
                least, best = residual, (unknowns, flow, iteration)
            elif least < _CONVERGED * size:
                break
            if residual < _EXACT * size:
                break
            try:
                unknowns = unknowns - np.linalg.solve(system, missed)
            except np.linalg.LinAlgError:
                break
        if best is None or not least < _CONVERGED * float(np.abs(best[0][:4]).max()):
            return None
        return self._completed(best, along if tangent is None else tangent)

    def _completed(
        self, found: tuple[FloatArray, Variation, int], along: FloatArray
    ) -> OrbitOnCurve | None:
        unknowns, flow, iterations = found
        system = np.zeros((6, 6))
        self._fill(system, flow)
        rate = flow.rate / self.scales[:4]
        speed = float(np.linalg.norm(rate))
        across = np.zeros(6)
        across[:4] = rate / speed
        system[4], system[5] = across, along
        try:
            tangent = np.linalg.solve(system, np.eye(6)[5])
        except np.linalg.LinAlgError:
            return None
        tangent = tangent / np.linalg.norm(tangent)
        system[5] = tangent
        # The directions across the orbit: what is left of an orthonormal basis that begins with the
        # motion's own.
        others = np.linalg.qr(np.column_stack([across[:4], np.eye(4)]))[0][:, 1:4]
        monodromy = others.T @ (system[:4, :4] + np.eye(4)) @ others
        return OrbitOnCurve(
            unknowns, flow, across, tangent, monodromy, float(np.linalg.det(system)), iterations
        )

    def _flow(self, unknowns: FloatArray) -> Variation | None:
        # One period; None if there is none.
        if not self._go_on():
            raise Cancelled
        if not np.isfinite(unknowns).all():
            return None
        state, period = unknowns[:4] * self.scales[:4], unknowns[PERIOD] * self.scales[PERIOD]
        try:
            request = Request(
                self.parameters(unknowns),
                t_end=float(period),
                tol=_FLOW_TOL,
                separation=self._separation,
                start=state.tolist(),
                max_steps=_MOST_STEPS,
            )
            return vary(request, self._seeds)
        except (InputError, ComputationError):
            # A guess out of the range of the parameters, or that runs away.
            return None

    def _fill(self, system: FloatArray, flow: Variation) -> None:
        scales = self.scales
        system[:4, :4] = flow.derivatives[:, :4] * scales[:4] / scales[:4, None] - np.eye(4)
        system[:4, PERIOD] = flow.rate * scales[PERIOD] / scales[:4]
        system[:4, VALUE] = flow.derivatives[:, 4] * scales[VALUE] / scales[:4]
