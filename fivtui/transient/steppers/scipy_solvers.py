"""SciPy's variable-step methods, restarted at every switch.

A guard is a function of the state whose zero ends a mode; the dense output of a step, interpolated
by a polynomial, locates it. The height guards are ±y, the speed guards compare ẋ with the belt.
"""

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

# Classes of the solvers, and the degree of the polynomials that represent their dense output.
_SOLVERS: Final[dict[str, tuple[Callable[..., OdeSolver], int]]] = {
    "DOP853": (DOP853, 7),
    "Radau": (Radau, 3),
    "LSODA": (LSODA, 7),
}
# Number of successive steps of zero length that counts as no progress.
_MAX_EMPTY_STEPS: Final = 64
# Magnitude of a state that counts as overflow.
_OVERFLOW_LIMIT: Final = 1e150
_HEIGHT_GUARDS: Final = (Guard.HEIGHT, Guard.DEPTH)
_SPEED_GUARDS: Final = (Guard.BELT_FASTER, Guard.BELT_SLOWER)


class ScipyStepper:
    """A stepper by SciPy (``"DOP853"``, ``"Radau"`` or ``"LSODA"``); each mode has a new solver.

    `tol` is the relative tolerance. The absolute one is `tol` times the start displacement, at
    least the static deflection.
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
        self._solver_class, degree = _SOLVERS[solver]
        self._t_end = t_end
        self._separation = system.separation
        self._tol = tol
        size = max(abs(state[0]), abs(state[2]), static_deflection(p))
        self._absolute_tol = tol * (size if size > 0.0 else 1.0)
        # Chebyshev points on [0, 1], and the matrix from values there to coefficients.
        nodes = 0.5 - 0.5 * np.cos(np.pi * np.arange(degree + 1) / degree)
        self._nodes: NDArray[np.float64] = nodes
        self._to_coefficients = np.linalg.inv(np.vander(nodes, increasing=True))
        self._empty_steps = 0
        self._y_start = state[2]
        self._mode = mode_of(p, state, separation=system.separation)
        self._solver = self._create_solver(0.0, state)

    def _create_solver(self, t: float, state: State) -> OdeSolver:
        mode, p = self._mode, self._p

        def right_hand_side(_t: float, z: NDArray[np.float64]) -> list[float]:
            x, vx, y, vy = z.tolist()
            ax, ay = accelerations(p, (x, vx, y, vy), mode)
            return [vx, ax, vy, ay]

        def state_jacobian(_t: float, z: NDArray[np.float64]) -> NDArray[np.float64]:
            return np.array(jacobian(p, float(z[2]), mode))

        # `jacobian` has the friction of steady sliding. On a belt of finite speed, where friction
        # may depend on ẋ, the solver approximates the Jacobian; DOP853 is explicit and needs none.
        needs_no_jacobian = self._solver_class is DOP853 or p.v_belt is not None
        options = {} if needs_no_jacobian else {"jac": state_jacobian}
        return self._solver_class(
            right_hand_side,
            t,
            np.array(state),
            self._t_end,
            rtol=self._tol,
            atol=self._absolute_tol,
            **options,
        )

    def advance(self) -> Segment:
        """The next segment: one step of the solver, or its part before the first zero of a guard.

        Raises `ComputationError` if the solver fails, the motion overflows, or switches follow at
        the same time without end.
        """
        solver, start = self._solver, float(self._solver.t)
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                message = solver.step()
        except (ValueError, ArithmeticError, np.linalg.LinAlgError) as error:
            raise self._solver_error(start, str(error)) from error
        if solver.status == "failed":
            raise self._solver_error(start, message or "no reason given")
        if not np.abs(solver.y).max() < _OVERFLOW_LIMIT:
            raise self._solver_error(start, "the motion grows beyond the floating-point range")
        dense = solver.dense_output()
        end, mode = float(solver.t), self._mode
        samples = dense(start + (end - start) * self._nodes)
        x, y = self._polynomials(samples)
        final = _state_of(solver.y)
        mode_end = self._find_mode_end(y, samples, final)
        if mode_end is not None:
            root, transition = mode_end
            end = start + (end - start) * root
            final = self._next_state(transition, _state_of(dense(end)))
            x, y = self._polynomials(dense(start + (end - start) * self._nodes))
            # The state decides if several modes may follow, and at y = 0, which the slider may only
            # touch: then it keeps its mode.
            if len(transition.next_modes) == 1 and transition.guard not in _HEIGHT_GUARDS:
                self._mode = transition.next_modes[0]
            else:
                self._mode = mode_of(self._p, final, separation=self._separation)
            self._solver = self._create_solver(end, final)
        self._y_start = final[2]
        self._empty_steps = self._empty_steps + 1 if end == start else 0
        if self._empty_steps > _MAX_EMPTY_STEPS:
            raise ComputationError(
                f"SciPy's solver makes no progress after the switch at t = {start:.6g} s",
                "use the taylor method",
            )
        return Segment(mode, start, 0.0, end - start, end, x, y, final, self._mode)

    def _find_mode_end(
        self, y: list[float], samples: NDArray[np.float64], final: State
    ) -> tuple[float, Transition] | None:
        # The earliest end of the mode in the step, as a fraction of the step, and its transition;
        # None if the mode lasts.
        earliest: tuple[float, Transition] | None = None
        for transition in MODES[self._mode].ends:
            if transition.guard not in _HEIGHT_GUARDS:
                root = self._guard_zero(transition.guard, samples, final)
            else:
                root = self._height_zero(y, final[2]) if self._separation else None
            if root is not None and (earliest is None or root < earliest[0]):
                earliest = root, transition
        return earliest

    def _guard_zero(self, guard: Guard, samples: NDArray[np.float64], final: State) -> float | None:
        # First zero of a guard, as a fraction of the step.
        values = [guard_value(self._p, _state_of(state), guard) for state in samples.T]
        coefficients = (self._to_coefficients @ np.array(values)).tolist()
        coefficients[0] = values[0]
        if coefficients[0] <= 0.0:
            # The mode began at a zero of this guard, which rises from there: without this, rounding
            # errors would end the mode at once.
            coefficients[0], coefficients[1] = 0.0, max(coefficients[1], 0.0)
        root = first_root(coefficients)
        return 1.0 if root is None and guard_value(self._p, final, guard) <= 0.0 else root

    def _next_state(self, transition: Transition, state: State) -> State:
        # The state with which the next mode begins.
        x, vx, y, vy = state
        if transition.guard in _HEIGHT_GUARDS:
            return (x, vx, 0.0, vy)
        return (x, self._p.v_belt or 0.0, y, vy) if transition.guard in _SPEED_GUARDS else state

    def _solver_error(self, t: float, reason: str) -> ComputationError:
        return ComputationError(
            f"SciPy's solver fails at t = {t:.6g} s: {reason}",
            "use another tolerance, or the taylor method",
        )

    def _polynomials(self, samples: NDArray[np.float64]) -> tuple[list[float], list[float]]:
        x, y = self._to_coefficients @ samples[0], self._to_coefficients @ samples[2]
        # Set the value at the start exactly: rounding must not add a root after a switch there.
        y[0] = self._y_start
        return x.tolist(), y.tolist()

    def _height_zero(self, y: list[float], final_y: float) -> float | None:
        # First zero of y, as a fraction of the step; its end if only the final state is beyond 0.
        root = first_root(y)
        is_beyond = final_y > 0.0 if self._mode in IN_CONTACT else final_y < 0.0
        return 1.0 if root is None and is_beyond else root


def _state_of(z: NDArray[np.float64]) -> State:
    """A state as a tuple of Python floats."""
    x, vx, y, vy = z.tolist()
    return (x, vx, y, vy)
