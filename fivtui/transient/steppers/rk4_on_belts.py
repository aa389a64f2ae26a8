"""The reference method on a belt of finite speed: RK4 with bisection and its own mode rules."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Mode, Parameters, State, mode_of

from .rk4 import BoolArray, FloatArray, RungeKutta4

# Limit of the exponent of the friction law beyond v_r = 0, where trial steps evaluate it.
_MAX_EXPONENT: Final = 5.0
# Sign of friction by mode; 0 in separation and stick.
_SIGNS: Final = np.array([{Mode.FORWARD: 1.0, Mode.BACKWARD: -1.0}.get(m, 0.0) for m in Mode])


class BeltRungeKutta4(RungeKutta4):
    """`RungeKutta4` on belts of finite speed; its `contact` has the numbers of the modes.

    It shares no rules of modes and friction with other methods. The relative velocity is
    v_r = v_belt − ẋ. Without `bisect` every stage selects the equations by the signs of y and v_r,
    without friction at v_r = 0. Then there is no stick: the slider alternates between forward and
    backward sliding.
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
        values = self._values
        values["v"] = np.array([p.v_belt for p in parameters], dtype=float)
        values["mu_s"] = np.array([p.mu_static for p in parameters])
        # The friction law μ + (μ_s − μ) exp(−|v_r|/v_s): μ_s − μ and 1/v_s. Both are 0 for constant
        # friction; else `speed_law` is v_s, m/s.
        values["fall"] = np.array([p.mu_static - p.mu if p.speed_law else 0.0 for p in parameters])
        values["rate"] = np.array([1.0 / p.speed_law if p.speed_law else 0.0 for p in parameters])
        modes = [
            mode_of(p, start, separation=separation)
            for p, start in zip(parameters, starts, strict=True)
        ]
        self.contact = np.array(modes, dtype=np.int64) if bisect else self._sliding_mode(self.state)

    def _sliding_mode(self, state: FloatArray) -> NDArray[Any]:
        # The mode by the signs of y and v_r, without stick.
        _, vx, y, _ = state
        separated = (y > 0.0) & self.separation
        sliding = np.where(vx > self._values["v"], Mode.BACKWARD, Mode.FORWARD)
        return np.where(separated, Mode.SEPARATED, sliding).astype(np.int64)

    def _forces(self, state: FloatArray) -> tuple[FloatArray, FloatArray]:
        # Force of the contact spring at y in any mode, and the force with which the belt must hold
        # a sticking slider.
        p, (x, _, y, _) = self._values, state
        holding_force = p["c1"] * p["v"] + (p["k1"] + 0.5 * p["k3"]) * x - 0.5 * p["k3"] * y
        return -p["k2"] * y - p["k_nl"] * y**3, holding_force

    def _derivatives(self, state: FloatArray, contact: BoolArray) -> FloatArray:
        p, (x, vx, y, vy) = self._values, state
        mode, sign = contact, _SIGNS[contact]
        if not self.bisect:
            mode, sign = self._sliding_mode(state), np.sign(p["v"] - vx)
        force = np.where(mode == Mode.SEPARATED, 0.0, self._forces(state)[0])
        # In the law |v_r| is sign · v_r. A trial step beyond v_r = 0, where bisection will end it,
        # makes that negative: the law continues smoothly.
        exponent = np.minimum(-sign * (p["v"] - vx) * p["rate"], _MAX_EXPONENT)
        friction = sign * (p["mu"] + p["fall"] * np.exp(exponent)) * force
        coupling = 0.5 * p["k3"] * (x - y)
        ax = (friction - p["c1"] * vx - p["k1"] * x - coupling) / p["m"]
        ay = (force - p["F"] - p["c2"] * vy + coupling) / p["m"]
        return np.array((vx, np.where(mode == Mode.STICK, 0.0, ax), vy, ay))

    def _violates(self, state: FloatArray, contact: BoolArray) -> BoolArray:
        if not self.bisect:
            return np.asarray(self._sliding_mode(state) != contact, dtype=bool)
        mode, (_, vx, y, _) = contact, state
        force, holding_force = self._forces(state)
        v_r = self._values["v"] - vx
        belt_slips = self._values["mu_s"] * force < np.abs(holding_force)
        violates = (_SIGNS[mode] * v_r < 0.0) | ((mode == Mode.STICK) & belt_slips)
        if self.separation:
            violates |= np.where(mode == Mode.SEPARATED, y < 0.0, y > 0.0)
        return np.asarray(violates, dtype=bool)

    def _next_state(self, final: FloatArray, switches: BoolArray) -> tuple[FloatArray, BoolArray]:
        # After a change of the sign of v_r the slider has the belt's speed; forces decide whether
        # the belt holds it. Then it sticks, or slides in the direction of the excess force.
        if not self.bisect:
            return final, self._sliding_mode(final)
        mode = self.contact
        separates = switches & (mode != Mode.SEPARATED) & (final[2] > 0.0) & self.separation
        sliding = (mode == Mode.FORWARD) | (mode == Mode.BACKWARD)
        state = final.copy()
        state[1] = np.where(switches & sliding & ~separates, self._values["v"], final[1])
        force, holding_force = self._forces(state)
        v_r = self._values["v"] - state[1]
        # A slider that sticks until now starts to slide.
        belt_holds = (self._values["mu_s"] * force >= np.abs(holding_force)) & (mode != Mode.STICK)
        # The first condition that holds decides. After a slide or a stick v_r is 0, so that forces
        # decide; after a flight it usually is not.
        next_mode = np.select(
            [separates, v_r > 0.0, v_r < 0.0, belt_holds, holding_force < 0.0],
            [Mode.SEPARATED, Mode.FORWARD, Mode.BACKWARD, Mode.STICK, Mode.BACKWARD],
            Mode.FORWARD,
        )
        return state, np.where(switches, next_mode, mode)
