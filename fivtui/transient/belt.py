"""The yardsticks on a belt of finite speed: RK4 with bisection, and SciPy's solvers."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import (
    MODES,
    Guard,
    Mode,
    Parameters,
    State,
    Transition,
    guard_value,
    mode_of,
)
from fivtui.taylor import BeltSegment, Segment, first_root

from .rk4 import BoolArray, FloatArray, ReferenceStepper, RungeKutta4, StepPart
from .scipy_solvers import ScipyStepper, state_of
from .trajectory import segment_between

# Beyond this exponent the fall of friction is not followed where a step goes past v_r = 0.
_LARGEST_EXPONENT: Final = 5.0
_OF_HEIGHT: Final = (Guard.HEIGHT, Guard.DEPTH)
_OF_SPEED: Final = (Guard.AHEAD, Guard.BEHIND)


class BeltRungeKutta4(RungeKutta4):
    """`RungeKutta4` on belts of finite speed; its `contact` has the numbers of the modes.

    It has modes and friction by rules of its own.
    """

    def __init__(
        self, parameters: list[Parameters], starts: list[State], *, step: float, separation: bool
    ) -> None:
        super().__init__(parameters, starts, step=step, separation=separation)
        modes = [
            mode_of(p, start, separation=separation)
            for p, start in zip(parameters, starts, strict=True)
        ]
        self.contact = np.array(modes, dtype=np.int64)
        table = self._table
        table["v"] = np.array([p.v_belt for p in parameters], dtype=float)
        table["mu_s"] = np.array([p.mu_static for p in parameters])
        table["fall"] = np.array([p.mu_static - p.mu if p.speed_law else 0.0 for p in parameters])
        table["rate"] = np.array([1.0 / p.speed_law if p.speed_law else 0.0 for p in parameters])

    def _forces(self, state: FloatArray) -> tuple[FloatArray, FloatArray]:
        # Of the contact spring as if in contact, and of a belt that holds.
        p, (x, _, y, _) = self._table, state
        held = p["c1"] * p["v"] + (p["k1"] + 0.5 * p["k3"]) * x - 0.5 * p["k3"] * y
        return -p["k2"] * y - p["k_nl"] * y**3, held

    def _derivatives(self, state: FloatArray, contact: BoolArray) -> FloatArray:
        p, (x, vx, y, vy) = self._table, state
        sign = np.select([contact == Mode.FORWARD, contact == Mode.BACKWARD], [1.0, -1.0], 0.0)
        force = np.where(contact == Mode.SEPARATED, 0.0, self._forces(state)[0])
        # Past v_r = 0 the law goes on smoothly: such a step is cut there.
        exponent = np.minimum(-sign * (p["v"] - vx) * p["rate"], _LARGEST_EXPONENT)
        friction = sign * (p["mu"] + p["fall"] * np.exp(exponent)) * force
        coupling = 0.5 * p["k3"] * (x - y)
        ax = (friction - p["c1"] * vx - p["k1"] * x - coupling) / p["m"]
        ay = (force - p["F"] - p["c2"] * vy + coupling) / p["m"]
        return np.array((vx, np.where(contact == Mode.STICK, 0.0, ax), vy, ay))

    def _crossed(self, state: FloatArray, contact: BoolArray) -> BoolArray:
        force, held = self._forces(state)
        ahead = self._table["v"] - state[1]
        crossed = np.select(
            [contact == Mode.FORWARD, contact == Mode.BACKWARD, contact == Mode.STICK],
            [ahead < 0.0, ahead > 0.0, self._table["mu_s"] * force < np.abs(held)],
            default=False,
        )
        if self.separation:
            crossed |= np.where(contact == Mode.SEPARATED, state[2] < 0.0, state[2] > 0.0)
        return np.asarray(crossed, dtype=bool)

    def _after(self, last: FloatArray, crossed: BoolArray) -> tuple[FloatArray, BoolArray]:
        mode = self.contact
        lifts = crossed & (mode != Mode.SEPARATED) & (last[2] > 0.0) & self.separation
        sliding = (mode == Mode.FORWARD) | (mode == Mode.BACKWARD)
        state = last.copy()
        state[1] = np.where(crossed & sliding & ~lifts, self._table["v"], last[1])
        force, held = self._forces(state)
        ahead = self._table["v"] - state[1]
        holds = (self._table["mu_s"] * force >= np.abs(held)) & (mode != Mode.STICK)
        then = np.select(
            [lifts, ahead > 0.0, ahead < 0.0, holds, held < 0.0],
            [Mode.SEPARATED, Mode.FORWARD, Mode.BACKWARD, Mode.STICK, Mode.BACKWARD],
            Mode.FORWARD,
        )
        return state, np.where(crossed, then, mode)


class BeltReferenceStepper(ReferenceStepper):
    """One parameter set under `BeltRungeKutta4`, as segments."""

    def __init__(
        self, p: Parameters, state: State, *, step: float, separation: bool, locate: bool = True
    ) -> None:
        super().__init__(p, state, step=step, separation=separation, locate=locate)
        self._integrator = BeltRungeKutta4([p], [state], step=step, separation=separation)

    def advance(self) -> BeltSegment:
        """The next segment, as `ReferenceStepper.advance`."""
        segment = super().advance()
        waiting = self._waiting
        then = waiting[-1].mode if waiting else Mode(int(self._integrator.contact[0]))
        return BeltSegment.of(segment, then)

    def _segment(self, part: StepPart, times: tuple[float, float]) -> Segment:
        first, last = (state_of(state[:, 0]) for state in (part.first, part.last))
        mode = Mode(int(part.contact[0]))
        return segment_between(self._p, mode, times, (first, last), switches=bool(part.switches[0]))


class BeltScipyStepper(ScipyStepper):
    """A SciPy solver on a belt of finite speed, one instance per mode interval."""

    # How the last mode ended.
    _ended: Transition | None = None

    def advance(self) -> BeltSegment:
        """The next segment: one step of the solver, cut where the first guard falls to zero."""
        segment = super().advance()
        return BeltSegment.of(segment, self._mode)

    def _end_of_mode(
        self, y: list[float], samples: NDArray[np.float64], final: State
    ) -> float | None:
        first: float | None = None
        self._ended = None
        for transition in MODES[self._mode].ends:
            guard = transition.guard
            if guard in _OF_HEIGHT:
                root = super()._end_of_mode(y, samples, final)
            else:
                root = self._first_fall(guard, samples, final)
            if root is not None and (first is None or root < first):
                first, self._ended = root, transition
        return first

    def _first_fall(self, guard: Guard, samples: NDArray[np.float64], final: State) -> float | None:
        values = [guard_value(self._p, state_of(state), guard) for state in samples.T]
        c = (self._to_power @ np.array(values)).tolist()
        c[0] = values[0]
        if c[0] <= 0.0:
            # At the start of a mode its guard is zero, and rises but for rounding.
            c[0], c[1] = 0.0, max(c[1], 0.0)
        root = first_root(c)
        return 1.0 if root is None and guard_value(self._p, final, guard) <= 0.0 else root

    def _past(self, state: State) -> State:
        x, vx, y, vy = state
        ended = self._ended
        if ended is not None and ended.guard in _OF_HEIGHT:
            return (x, vx, 0.0, vy)
        if ended is not None and ended.guard in _OF_SPEED:
            return (x, self._p.v_belt or 0.0, y, vy)
        return state

    def _mode_after(self, state: State) -> Mode:
        ended = self._ended
        if ended is not None and len(ended.to) == 1 and ended.guard not in _OF_HEIGHT:
            return ended.to[0]
        return super()._mode_after(state)
