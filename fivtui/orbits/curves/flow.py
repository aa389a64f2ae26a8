"""Flows whose periodic orbits are followed: the slider-belt model, or any other flow.

On a belt of finite speed the result includes the sticks and the order of modes, `Makeup`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from fivtui.model import ComputationError, InputError, Mode, System
from fivtui.taylor import Seed
from fivtui.transient import EXTREMES, START_SEEDS, Request, Variation, vary

FloatArray = NDArray[np.float64]

FLOW_TOL: Final = 1e-13
MOST_STEPS: Final = 20_000
# On a belt of finite speed steps are interpreted, and a period takes less than a hundred.
_MOST_BELT_STEPS: Final = 2_000


@dataclass(frozen=True, slots=True)
class Return:
    """The end of a motion after a time, with derivatives."""

    final: FloatArray
    rate: FloatArray
    derivatives: FloatArray
    extremes: FloatArray


class Flow(Protocol):
    """A flow that depends on one or two parameters."""

    @property
    def states(self) -> int:
        """Number of state variables."""
        ...

    def follow(self, state: FloatArray, time: float, values: FloatArray) -> Return | None:
        """The motion from a state, with values of the parameters; None if there is none."""
        ...


class Makeup(NamedTuple):
    """Sticks and order of modes of a motion over a period on a belt of finite speed."""

    sticks: float
    reversals: float
    order: float
    least_stick: float
    gap: float
    start_in_stick: float
    middle: float


# Number of extremes in front of the `Makeup`.
EXTREMES_KEPT: Final = 4
_MODES: Final = len(Mode)
# Orders of modes are encoded below this number, up to which floats are exact.
_MOST_ORDERS: Final = 2**53
# Distance from the belt speed, relative to both speeds, within which a slider may stick.
_ON_BELT: Final = 1e-9


def _makeup_of(motion: Variation, period: float, speed: float) -> Makeup:
    # The makeup of a motion over a period; `speed` is that of the belt, m/s.
    times, modes = motion.changes[:, 0], [int(mode) for mode in motion.changes[:, 2]]
    # The cyclic order of modes in contact.
    touching = [mode for mode in modes if mode != Mode.SEPARATED]
    order = [mode for index, mode in enumerate(touching) if touching[index - 1] != mode]
    turns = [order[index:] + order[:index] for index in range(len(order))] or [[]]
    number = 0
    for mode in min(turns):
        number = (number * _MODES + mode + 1) % _MOST_ORDERS
    begins, lengths = times / period, np.diff(np.append(times, times[:1] + period)) / period
    sticks = [
        (float(length), float(begin))
        for length, begin, mode in zip(lengths, begins, modes, strict=True)
        if mode == Mode.STICK
    ]
    fastest = float(motion.extremes[EXTREMES.index("vx_max")])
    longest, begin = max(sticks, default=(0.0, -1.0))
    inside = bool(sticks) and modes[-1] == Mode.STICK
    return Makeup(
        sticks=float(len(sticks)),
        reversals=float(order.count(Mode.BACKWARD)),
        order=float(number),
        least_stick=min((length for length, _ in sticks), default=1.0),
        gap=(speed - fastest) / speed if speed > 0.0 else 0.0,
        start_in_stick=(1.0 - float(begins[-1])) / float(lengths[-1]) if inside else -1.0,
        middle=(begin + 0.5 * longest) % 1.0 if sticks else -1.0,
    )


class SliderBeltFlow:
    """The flow of the slider-belt model.

    On a belt of finite speed a start at the belt speed, to rounding, sticks if the belt can hold
    it. The `Makeup` follows the first extremes.
    """

    states: Final = 4

    def __init__(self, system: System, names: Sequence[str]) -> None:
        self.system, self.names = system, tuple(names)
        self._seeds = [*START_SEEDS, *(Seed((0.0,) * 4, {name: 1.0}) for name in names)]

    def follow(self, state: FloatArray, time: float, values: FloatArray) -> Return | None:
        """See `Flow`; None for values out of range and for unbounded motions."""
        start = state.tolist()
        try:
            system = self.system.with_values(dict(zip(self.names, values.tolist(), strict=True)))
            speed = system.parameters.v_belt
            if speed is not None and abs(start[1] - speed) <= _ON_BELT * (speed + abs(start[3])):
                start[1] = speed
            max_steps = MOST_STEPS if speed is None else _MOST_BELT_STEPS
            request = Request(
                system, t_end=float(time), tol=FLOW_TOL, start=start, max_steps=max_steps
            )
            motion = vary(request, self._seeds)
        except (InputError, ComputationError):
            return None
        extremes = motion.extremes
        if speed is not None:
            makeup = _makeup_of(motion, time, speed)
            extremes = np.append(extremes[:EXTREMES_KEPT], makeup)
        return Return(np.array(motion.final), motion.rate, motion.derivatives, extremes)
