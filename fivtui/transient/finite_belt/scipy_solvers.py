"""SciPy's variable-step methods on a belt of finite speed."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import MODES, Guard, Mode, State, Transition, guard_value
from fivtui.taylor import BeltSegment, first_root
from fivtui.transient.scipy_solvers import ScipyStepper, state_of

_OF_HEIGHT: Final = (Guard.HEIGHT, Guard.DEPTH)
_OF_SPEED: Final = (Guard.AHEAD, Guard.BEHIND)


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
