"""The reference method on a belt of finite speed: RK4 with bisection and its own mode rules."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Mode, Parameters, State, mode_of

from .rk4 import BoolArray, FloatArray, RungeKutta4

# Largest exponent of the friction law beyond v_r = 0, where trial steps evaluate it.
_LARGEST_EXPONENT: Final = 5.0
# Sign of friction by mode.
_SIGNS: Final = np.array([{Mode.FORWARD: 1.0, Mode.BACKWARD: -1.0}.get(m, 0.0) for m in Mode])


class BeltRungeKutta4(RungeKutta4):
    """`RungeKutta4` on belts of finite speed; its `contact` has the numbers of the modes.

    It shares no rules of modes and friction with other methods. Without `bisect` every
    stage selects the equations by the signs of y and v_r, without friction at v_r = 0. Then there
    is no stick: the slider alternates between forward and backward sliding.
    """

    def __init__(
        self,
        parameters: Sequence[Parameters],
        starts: Sequence[State],
        *,
        step: float,
        separation: bool,
        bisect: bool = True,
    ) -> None:
        super().__init__(parameters, starts, step=step, separation=separation, bisect=bisect)
        table = self._values
        table["v"] = np.array([p.v_belt for p in parameters], dtype=float)
        table["mu_s"] = np.array([p.mu_static for p in parameters])
        table["fall"] = np.array([p.mu_static - p.mu if p.speed_law else 0.0 for p in parameters])
        table["rate"] = np.array([1.0 / p.speed_law if p.speed_law else 0.0 for p in parameters])
        modes = [
            mode_of(p, start, separation=separation)
            for p, start in zip(parameters, starts, strict=True)
        ]
        self.contact = np.array(modes, dtype=np.int64) if bisect else self._sliding_mode(self.state)

    def _sliding_mode(self, state: FloatArray) -> NDArray[Any]:
        # The mode by the signs of y and v_r, without stick.
        separated = (state[2] > 0.0) & self.separation
        sliding = np.where(state[1] > self._values["v"], Mode.BACKWARD, Mode.FORWARD)
        return np.where(separated, Mode.SEPARATED, sliding).astype(np.int64)

    def _forces(self, state: FloatArray) -> tuple[FloatArray, FloatArray]:
        # Force of the contact spring in any mode, and holding force of the belt.
        p, (x, _, y, _) = self._values, state
        holding_force = p["c1"] * p["v"] + (p["k1"] + 0.5 * p["k3"]) * x - 0.5 * p["k3"] * y
        return -p["k2"] * y - p["k_nl"] * y**3, holding_force

    def _derivatives(self, state: FloatArray, contact: BoolArray) -> FloatArray:
        p, (x, vx, y, vy) = self._values, state
        sign = _SIGNS[contact]
        if not self.bisect:
            contact, sign = self._sliding_mode(state), np.sign(p["v"] - vx)
        force = np.where(contact == Mode.SEPARATED, 0.0, self._forces(state)[0])
        # Beyond v_r = 0, where bisection will end the step, continue the law smoothly.
        exponent = np.minimum(-sign * (p["v"] - vx) * p["rate"], _LARGEST_EXPONENT)
        friction = sign * (p["mu"] + p["fall"] * np.exp(exponent)) * force
        coupling = 0.5 * p["k3"] * (x - y)
        ax = (friction - p["c1"] * vx - p["k1"] * x - coupling) / p["m"]
        ay = (force - p["F"] - p["c2"] * vy + coupling) / p["m"]
        return np.array((vx, np.where(contact == Mode.STICK, 0.0, ax), vy, ay))

    def _violates(self, state: FloatArray, contact: BoolArray) -> BoolArray:
        if not self.bisect:
            return np.asarray(self._sliding_mode(state) != contact, dtype=bool)
        force, holding_force = self._forces(state)
        v_r = self._values["v"] - state[1]
        belt_slips = self._values["mu_s"] * force < np.abs(holding_force)
        crosses = (_SIGNS[contact] * v_r < 0.0) | ((contact == Mode.STICK) & belt_slips)
        if self.separation:
            crosses |= np.where(contact == Mode.SEPARATED, state[2] < 0.0, state[2] > 0.0)
        return np.asarray(crosses, dtype=bool)

    def _next_state(self, final: FloatArray, crossed: BoolArray) -> tuple[FloatArray, BoolArray]:
        if not self.bisect:
            return final, self._sliding_mode(final)
        mode = self.contact
        separates = crossed & (mode != Mode.SEPARATED) & (final[2] > 0.0) & self.separation
        sliding = (mode == Mode.FORWARD) | (mode == Mode.BACKWARD)
        state = final.copy()
        state[1] = np.where(crossed & sliding & ~separates, self._values["v"], final[1])
        force, holding_force = self._forces(state)
        v_r = self._values["v"] - state[1]
        belt_holds = (self._values["mu_s"] * force >= np.abs(holding_force)) & (mode != Mode.STICK)
        next_mode = np.select(
            [separates, v_r > 0.0, v_r < 0.0, belt_holds, holding_force < 0.0],
            [Mode.SEPARATED, Mode.FORWARD, Mode.BACKWARD, Mode.STICK, Mode.BACKWARD],
            Mode.FORWARD,
        )
        return state, np.where(crossed, next_mode, mode)
