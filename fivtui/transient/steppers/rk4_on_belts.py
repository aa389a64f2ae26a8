"""The reference method on a belt of finite speed: RK4 with bisection and independent rules."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Mode, Parameters, State, mode_of

from .rk4 import BoolArray, FloatArray, RungeKutta4

# Largest exponent of the friction law where a step passes v_r = 0.
_LARGEST_EXPONENT: Final = 5.0
# Sign of friction by mode.
_SIGNS: Final = np.array([{Mode.FORWARD: 1.0, Mode.BACKWARD: -1.0}.get(m, 0.0) for m in Mode])


class BeltRungeKutta4(RungeKutta4):
    """`RungeKutta4` on belts of finite speed; its `contact` has the numbers of the modes.

    Its rules of modes and friction are independent. Without `locate` every stage chooses the field
    by the signs of y and v_r, without friction at v_r = 0. Then there is no stick: the slider
    alternates between forward and backward sliding.
    """

    def __init__(
        self,
        parameters: Sequence[Parameters],
        starts: Sequence[State],
        *,
        step: float,
        separation: bool,
        locate: bool = True,
    ) -> None:
        super().__init__(parameters, starts, step=step, separation=separation, locate=locate)
        table = self._table
        table["v"] = np.array([p.v_belt for p in parameters], dtype=float)
        table["mu_s"] = np.array([p.mu_static for p in parameters])
        table["fall"] = np.array([p.mu_static - p.mu if p.speed_law else 0.0 for p in parameters])
        table["rate"] = np.array([1.0 / p.speed_law if p.speed_law else 0.0 for p in parameters])
        modes = [
            mode_of(p, start, separation=separation)
            for p, start in zip(parameters, starts, strict=True)
        ]
        self.contact = np.array(modes, dtype=np.int64) if locate else self._side(self.state)

    def _side(self, state: FloatArray) -> NDArray[Any]:
        # The mode by the signs of y and v_r alone.
        off = (state[2] > 0.0) & self.separation
        slides = np.where(state[1] > self._table["v"], Mode.BACKWARD, Mode.FORWARD)
        return np.where(off, Mode.SEPARATED, slides).astype(np.int64)

    def _forces(self, state: FloatArray) -> tuple[FloatArray, FloatArray]:
        # Contact force as if in contact, and holding force of the belt.
        p, (x, _, y, _) = self._table, state
        holding_force = p["c1"] * p["v"] + (p["k1"] + 0.5 * p["k3"]) * x - 0.5 * p["k3"] * y
        return -p["k2"] * y - p["k_nl"] * y**3, holding_force

    def _derivatives(self, state: FloatArray, contact: BoolArray) -> FloatArray:
        p, (x, vx, y, vy) = self._table, state
        sign = _SIGNS[contact]
        if not self.locate:
            contact, sign = self._side(state), np.sign(p["v"] - vx)
        force = np.where(contact == Mode.SEPARATED, 0.0, self._forces(state)[0])
        # Continue the law smoothly past v_r = 0, where the step is cut.
        exponent = np.minimum(-sign * (p["v"] - vx) * p["rate"], _LARGEST_EXPONENT)
        friction = sign * (p["mu"] + p["fall"] * np.exp(exponent)) * force
        coupling = 0.5 * p["k3"] * (x - y)
        ax = (friction - p["c1"] * vx - p["k1"] * x - coupling) / p["m"]
        ay = (force - p["F"] - p["c2"] * vy + coupling) / p["m"]
        return np.array((vx, np.where(contact == Mode.STICK, 0.0, ax), vy, ay))

    def _crossed(self, state: FloatArray, contact: BoolArray) -> BoolArray:
        if not self.locate:
            return np.asarray(self._side(state) != contact, dtype=bool)
        force, holding_force = self._forces(state)
        ahead = self._table["v"] - state[1]
        slips = self._table["mu_s"] * force < np.abs(holding_force)
        crossed = (_SIGNS[contact] * ahead < 0.0) | ((contact == Mode.STICK) & slips)
        if self.separation:
            crossed |= np.where(contact == Mode.SEPARATED, state[2] < 0.0, state[2] > 0.0)
        return np.asarray(crossed, dtype=bool)

    def _after(self, final: FloatArray, crossed: BoolArray) -> tuple[FloatArray, BoolArray]:
        if not self.locate:
            return final, self._side(final)
        mode = self.contact
        lifts = crossed & (mode != Mode.SEPARATED) & (final[2] > 0.0) & self.separation
        sliding = (mode == Mode.FORWARD) | (mode == Mode.BACKWARD)
        state = final.copy()
        state[1] = np.where(crossed & sliding & ~lifts, self._table["v"], final[1])
        force, holding_force = self._forces(state)
        ahead = self._table["v"] - state[1]
        holds = (self._table["mu_s"] * force >= np.abs(holding_force)) & (mode != Mode.STICK)
        next_mode = np.select(
            [lifts, ahead > 0.0, ahead < 0.0, holds, holding_force < 0.0],
            [Mode.SEPARATED, Mode.FORWARD, Mode.BACKWARD, Mode.STICK, Mode.BACKWARD],
            Mode.FORWARD,
        )
        return state, np.where(crossed, next_mode, mode)
