"""Flows whose periodic orbits are followed: the slider-belt model, or any other flow."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from fivtui.model import ComputationError, InputError, Mode, System
from fivtui.taylor import Seed
from fivtui.transient import EXTREMES, START_SEEDS, Request, Variation, compute_variation

FloatArray = NDArray[np.float64]

FLOW_TOL: Final = 1e-13
MAX_FLOW_STEPS: Final = 20_000
# A lower limit on a belt of finite speed, where slower, interpreted code computes the motion, and a
# period takes less than a hundred steps.
_MAX_BELT_STEPS: Final = 2_000
# Number of the extremes of x and y, which come first. On a belt of finite speed the numbers of a
# `ModePattern` take the positions of the further extremes.
POSITION_EXTREME_COUNT: Final = 4
Y_MIN: Final = EXTREMES.index("y_min")
Y_MAX: Final = EXTREMES.index("y_max")


@dataclass(frozen=True, slots=True)
class MotionEnd:
    """The end of a motion: state, rate of change, and derivatives by start and parameters.

    `extremes` are those over the motion, in the order of `EXTREMES`; on a belt of finite speed only
    those of x and y, before the numbers of a `ModePattern`.
    """

    final: FloatArray
    rate: FloatArray
    derivatives: FloatArray
    extremes: FloatArray

    @property
    def y_max(self) -> float:
        """Highest point, m."""
        return float(self.extremes[Y_MAX])


class Flow(Protocol):
    """A flow that depends on one or two parameters."""

    @property
    def state_count(self) -> int:
        """Number of state variables."""
        ...

    def follow(self, state: FloatArray, time: float, values: FloatArray) -> MotionEnd | None:
        """The motion from a state with values of the parameters; None if it cannot be computed."""
        ...


class ModePattern(NamedTuple):
    """Sticks and order of modes of a motion over a period on a belt of finite speed.

    `sticks` and `reversals` are numbers of sticks and slips backward; `order` is a number that
    encodes the order of modes in contact. Times are relative to the period. `speed_gap` is the
    distance of the greatest ẋ from the belt speed, relative to that speed.

    The motion is periodic: a stick may last from the end of the period into its start. Then
    `start_in_stick` is the part of this stick before the start, else -1. `longest_stick_middle` is
    the time at which the longest stick is half over, where a period can well begin; -1 without
    sticks.
    """

    sticks: float
    reversals: float
    order: float
    shortest_stick: float
    speed_gap: float
    start_in_stick: float
    longest_stick_middle: float


_MODE_COUNT: Final = len(Mode)
# Modulus of the numbers that encode orders of modes: floats hold smaller integers exactly.
_ORDER_MODULUS: Final = 2**53
# A start has the belt speed if its ẋ differs from it by at most this, relative to the sum of the
# belt speed and |ẏ|.
_SPEED_TOL: Final = 1e-9


def _mode_pattern(motion: Variation, period: float, belt_speed: float) -> ModePattern:
    times, _, modes_after = motion.changes.T
    modes = [int(mode) for mode in modes_after]
    # The order of modes in contact is cyclic, and empty if there is only one mode.
    contact_modes = [mode for mode in modes if mode != Mode.SEPARATED]
    previous_modes = contact_modes[-1:] + contact_modes[:-1]
    order = [
        mode
        for mode, previous in zip(contact_modes, previous_modes, strict=True)
        if mode != previous
    ]
    # The least rotation does not depend on the start.
    rotations = [order[index:] + order[:index] for index in range(len(order))] or [[]]
    code = 0
    for mode in min(rotations):
        # Modes are digits; as none of them is 0, orders of different length differ.
        code = (code * _MODE_COUNT + mode + 1) % _ORDER_MODULUS
    # The last mode lasts over the end of the period until the first change.
    ends = np.append(times[1:], times[:1] + period)
    starts, lengths = times / period, (ends - times) / period
    sticks = [
        (float(length), float(start))
        for length, start, mode in zip(lengths, starts, modes, strict=True)
        if mode == Mode.STICK
    ]
    vx_max = float(motion.extremes[EXTREMES.index("vx_max")])
    longest_stick, start = max(sticks, default=(0.0, -1.0))
    starts_in_stick = bool(sticks) and modes[-1] == Mode.STICK
    return ModePattern(
        sticks=float(len(sticks)),
        reversals=float(order.count(Mode.BACKWARD)),
        order=float(code),
        shortest_stick=min((length for length, _ in sticks), default=1.0),
        speed_gap=(belt_speed - vx_max) / belt_speed if belt_speed > 0.0 else 0.0,
        start_in_stick=(1.0 - float(starts[-1])) / float(lengths[-1]) if starts_in_stick else -1.0,
        longest_stick_middle=(start + 0.5 * longest_stick) % 1.0 if sticks else -1.0,
    )


class SliderBeltFlow:
    """The flow of the slider-belt model.

    On a belt of finite speed a start at the belt speed, to rounding, sticks if friction holds it.
    """

    state_count: Final = 4

    def __init__(self, system: System, names: Sequence[str]) -> None:
        self.system, self.names = system, tuple(names)
        # Directions of the derivatives: the components of the start, then the parameters.
        self._seeds = [*START_SEEDS, *(Seed((0.0,) * 4, {name: 1.0}) for name in names)]

    def follow(self, state: FloatArray, time: float, values: FloatArray) -> MotionEnd | None:
        """See `Flow`: None for parameters out of range and for motions that cannot be followed."""
        start = state.tolist()
        try:
            system = self.system.with_values(dict(zip(self.names, values.tolist(), strict=True)))
            belt_speed = system.parameters.v_belt
            if belt_speed is not None:
                _, vx, _, vy = start
                if abs(vx - belt_speed) <= _SPEED_TOL * (abs(belt_speed) + abs(vy)):
                    start[1] = belt_speed
            max_steps = MAX_FLOW_STEPS if belt_speed is None else _MAX_BELT_STEPS
            request = Request(
                system, t_end=float(time), tol=FLOW_TOL, start=start, max_steps=max_steps
            )
            motion = compute_variation(request, self._seeds)
        except (InputError, ComputationError):
            return None
        extremes = motion.extremes
        if belt_speed is not None:
            pattern = _mode_pattern(motion, time, belt_speed)
            extremes = np.append(extremes[:POSITION_EXTREME_COUNT], pattern)
        return MotionEnd(np.array(motion.final), motion.final_rate, motion.derivatives, extremes)
