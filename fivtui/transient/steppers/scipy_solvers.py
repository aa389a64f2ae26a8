"""SciPy's variable-step methods, restarted at every switch."""

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853, LSODA, OdeSolver, Radau

from fivtui.model import (
    IN_CONTACT,
    MODES,
    ComputationError,
    Guard,
    State,
    System,
    Transition,
    accelerations,
    guard_value,
    jacobian,
    mode_of,
    static_deflection,
)
from fivtui.taylor import Segment, first_root

# Classes of the solvers, and the degree that represents their dense output.
_SOLVERS: Final[dict[str, tuple[Callable[..., OdeSolver], int]]] = {
    "DOP853": (DOP853, 7),
    "Radau": (Radau, 3),
    "LSODA": (LSODA, 7),
}
_MAX_STALLED: Final = 64
_LARGEST: Final = 1e150
_OF_HEIGHT: Final = (Guard.HEIGHT, Guard.DEPTH)
_OF_SPEED: Final = (Guard.AHEAD, Guard.BEHIND)


class ScipyStepper:
    """A SciPy solver (``"DOP853"``, ``"Radau"`` or ``"LSODA"``), one instance per mode interval.

    `tol` is the relative tolerance; the absolute one is `tol` times the size of the start.
    """

    def __init__(
        self,
        system: System,
        state: State,
        *,
        solver: str,
        t_end: float,
        tol: float,
    ) -> None:
        self._p = p = system.parameters
        self._make, self._degree = _SOLVERS[solver]
        self._t_end = t_end
        self._separation = system.separation
        self._tol = tol
        size = max(abs(state[0]), abs(state[2]), static_deflection(p))
        self._absolute = tol * (size if size > 0.0 else 1.0)
        nodes = 0.5 - 0.5 * np.cos(np.pi * np.arange(self._degree + 1) / self._degree)
        self._nodes: NDArray[np.float64] = nodes
        self._to_power = np.linalg.inv(np.vander(nodes, increasing=True))
        self._stalled = 0
        self._y = state[2]
        self._mode = mode_of(p, state, separation=system.separation)
        self._solver = self._begin(0.0, state)

    def _begin(self, t: float, state: State) -> OdeSolver:
        mode, p = self._mode, self._p

        def motion(_t: float, z: NDArray[np.float64]) -> list[float]:
            x, vx, y, vy = z.tolist()
            ax, ay = accelerations(p, (x, vx, y, vy), mode)
            return [vx, ax, vy, ay]

        def linearised(_t: float, z: NDArray[np.float64]) -> NDArray[np.float64]:
            return np.array(jacobian(p, float(z[2]), mode))

        # The derivative of sliding friction by the speed is left to the solver.
        explicit = self._make is DOP853 or p.v_belt is not None
        options = {} if explicit else {"jac": linearised}
        return self._make(
            motion,
            t,
            np.array(state),
            self._t_end,
            rtol=self._tol,
            atol=self._absolute,
            **options,
        )

    def advance(self) -> Segment:
        """The next segment: one step of the solver, cut where the first guard falls to zero.

        Raises `ComputationError` if the solver fails, the motion overflows, or switches stop
        advancing time.
        """
        solver, start = self._solver, float(self._solver.t)
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                message = solver.step()
        except (ValueError, ArithmeticError, np.linalg.LinAlgError) as error:
            raise self._failure(start, str(error)) from error
        if solver.status == "failed":
            raise self._failure(start, message or "no reason given")
        if not np.abs(solver.y).max() < _LARGEST:
            raise self._failure(start, "the motion grows beyond the floating-point range")
        dense = solver.dense_output()
        end, mode = float(solver.t), self._mode
        samples = dense(start + (end - start) * self._nodes)
        x, y = self._polynomials(samples)
        final = _state_of(solver.y)
        first_end = self._end_of_mode(y, samples, final)
        if first_end is not None:
            root, ended = first_end
            end = start + (end - start) * root
            final = self._past(ended, _state_of(dense(end)))
            x, y = self._polynomials(dense(start + (end - start) * self._nodes))
            if len(ended.to) == 1 and ended.guard not in _OF_HEIGHT:
                self._mode = ended.to[0]
            else:
                self._mode = mode_of(self._p, final, separation=self._separation)
            self._solver = self._begin(end, final)
        self._y = final[2]
        self._stalled = self._stalled + 1 if end == start else 0
        if self._stalled > _MAX_STALLED:
            raise ComputationError(
                f"SciPy's solver does not get past the switch at t = {start:.6g} s",
                "use the taylor method",
            )
        return Segment(mode, start, 0.0, end - start, end, x, y, final, self._mode)

    def _end_of_mode(
        self, y: list[float], samples: NDArray[np.float64], final: State
    ) -> tuple[float, Transition] | None:
        # Earliest end of the mode as a fraction of the step, with its transition.
        first: tuple[float, Transition] | None = None
        for transition in MODES[self._mode].ends:
            if transition.guard not in _OF_HEIGHT:
                root = self._first_fall(transition.guard, samples, final)
            else:
                root = self._first_root(y, final[2]) if self._separation else None
            if root is not None and (first is None or root < first[0]):
                first = root, transition
        return first

    def _first_fall(self, guard: Guard, samples: NDArray[np.float64], final: State) -> float | None:
        values = [guard_value(self._p, _state_of(state), guard) for state in samples.T]
        c = (self._to_power @ np.array(values)).tolist()
        c[0] = values[0]
        if c[0] <= 0.0:
            # At the start of a mode its guard is zero and rises, except for rounding.
            c[0], c[1] = 0.0, max(c[1], 0.0)
        root = first_root(c)
        return 1.0 if root is None and guard_value(self._p, final, guard) <= 0.0 else root

    def _past(self, ended: Transition, state: State) -> State:
        # The state with which the next mode begins.
        x, vx, y, vy = state
        if ended.guard in _OF_HEIGHT:
            return (x, vx, 0.0, vy)
        return (x, self._p.v_belt or 0.0, y, vy) if ended.guard in _OF_SPEED else state

    def _failure(self, t: float, why: str) -> ComputationError:
        return ComputationError(
            f"SciPy's solver fails at t = {t:.6g} s: {why}",
            "try another tolerance or method taylor",
        )

    def _polynomials(self, samples: NDArray[np.float64]) -> tuple[list[float], list[float]]:
        x, y = self._to_power @ samples[0], self._to_power @ samples[2]
        # Rounding must not add a root next to the switch at the start of the step.
        y[0] = self._y
        return x.tolist(), y.tolist()

    def _first_root(self, y: list[float], final: float) -> float | None:
        root = first_root(y)
        contact = self._mode in IN_CONTACT
        if root is None and (final > 0.0 if contact else final < 0.0):
            return 1.0
        return root


def _state_of(z: NDArray[np.float64]) -> State:
    """A state as numbers."""
    x, vx, y, vy = z.tolist()
    return (x, vx, y, vy)
