"""The Taylor integrator on a belt of finite speed: slip forward and backward, stick, separation.

Every step ends where the first guard of its mode falls to zero, by the table `MODES`. Guards are
polynomials of the step, and are located as the switch of `stepper` is.
"""

import math
from collections.abc import Iterable, Sequence
from itertools import accumulate, repeat
from operator import mul
from typing import Final

from fivtui.model.field import (
    coupling_stiffness,
    guard_value,
    holding_force_size,
    horizontal_stiffness,
    spring_force,
)
from fivtui.model.modes import MODES, Guard, Mode, Transition
from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import BALANCED, State, mode_of

from .friction import is_far, law_coefficients, law_of, limited
from .polynomial import first_root
from .segment import BeltSegment
from .series import Coefficients
from .stepper import SHORTEST_FLIGHT, TaylorStepper

# Guards that fall to zero this close to each other, relative to the step, do so at once: then the
# slider separates.
SIMULTANEOUS: Final = 2.0**-40
# Where a friction law is too steep at the speed of the belt the motion creeps: part of t below
# which a step does not advance it.
UNRESOLVED: Final = 2.0**-50
_OF_HEIGHT: Final = (Guard.HEIGHT, Guard.DEPTH)
OF_SPEED: Final = {Guard.AHEAD: 1.0, Guard.BEHIND: -1.0}
OF_HOLD: Final = {Guard.HELD_FORWARD: -1.0, Guard.HELD_BACKWARD: 1.0}


class BeltStepper(TaylorStepper):
    """Taylor integrator on a belt of finite speed; parameters as of `TaylorStepper`."""

    def _modes(self) -> Iterable[Mode]:
        return Mode

    def __init__(
        self,
        p: Parameters,
        state: State,
        *,
        t: float = 0.0,
        separation: bool = True,
        tol: float = 1e-15,
        order: int | None = None,
    ) -> None:
        super().__init__(p, state, t=t, separation=separation, tol=tol, order=order)
        self._speed = p.v_belt or 0.0
        self._laws = {mode: law_of(p, mode) for mode in Mode}
        # Where friction does not jump at v_r = 0 the slider starts to slide without acceleration.
        self._smooth = p.mu_static == p.mu or p.speed_law is not None

    def advance(self) -> BeltSegment:
        """Compute the next segment: one Taylor step, cut where the first guard falls to zero.

        Raises `ComputationError` if the motion overflows, or switches faster than time resolves.
        """
        mode, first = self._mode, self._state
        x, y = self._expanded(mode)
        duration = self._limited(mode, x, self._step_size(x, y))
        powers = tuple(accumulate(repeat(duration, self._degree), mul, initial=1.0))
        x, y = tuple(map(mul, x, powers)), tuple(map(mul, y, powers))
        final = self._evaluate(x, y, 1.0)
        ended = self._first_end(mode, x, y, duration, final)
        if ended is not None:
            root, transition = ended
            duration *= root
            powers = tuple(accumulate(repeat(root, self._degree), mul, initial=1.0))
            x, y = tuple(map(mul, x, powers)), tuple(map(mul, y, powers))
            final = self._evaluate(x, y, 1.0)
        if not math.isfinite(sum(final)) or duration == 0.0:
            raise self._overflow(first)
        guard = None if ended is None else ended[1].guard
        on_belt = mode is Mode.STICK or guard in OF_SPEED
        self._state = state = (
            final[0],
            self._speed_after(duration) if on_belt else final[1] / duration,
            0.0 if guard in _OF_HEIGHT else final[2],
            final[3] / duration,
        )
        start, remainder = self._time, self._remainder
        self._add_to_time(duration)
        if ended is not None:
            self._mode = self._successor(transition, state)
        short = ended is not None and duration < SHORTEST_FLIGHT * self._time_scale
        creeps = self._laws[mode] is not None and duration < UNRESOLVED * start
        self._check_progress(start, short=short or creeps)
        switches, end = self._mode is not mode, self._time
        return BeltSegment(mode, start, remainder, duration, end, x, y, state, switches, self._mode)

    def _limited(self, mode: Mode, x: Sequence[float], duration: float) -> float:
        """The part of a step, s, over which its expansions hold."""
        law = self._laws[mode]
        if law is None:
            return duration
        return limited(duration, x, law, law.sign * (self._speed - self._state[1]))

    def _speed_after(self, _duration: float) -> float:
        """Speed of the belt so long after the start of a step, m/s."""
        return self._speed

    def _guard_after(self, state: State, guard: Guard, _duration: float) -> float:
        """Value of a guard at the end of a step."""
        return float(guard_value(self._p, state, guard))

    def _successor(self, transition: Transition, state: State) -> Mode:
        if transition.guard in OF_HOLD:
            return transition.to[0]
        return mode_of(self._p, state, separation=self._separation)

    def _expanded(self, mode: Mode) -> Coefficients:
        state, law = self._state, self._laws[mode]
        if law is None or is_far(law, law.sign * (self._speed - state[1])):
            x, y = self._expand[mode](*state, *self._constants[mode])
        else:
            x, y = law_coefficients(self._p, mode, law, state, self._degree - 1)
        if state[2] == 0.0 and self._separation:
            y = self._settled(y)
        if state[1] == self._speed and mode in (Mode.FORWARD, Mode.BACKWARD):
            x = self._started(x, forward=mode is Mode.FORWARD)
        return x, y

    def _started(self, x: tuple[float, ...], *, forward: bool) -> tuple[float, ...]:
        # A slider that begins to slide where friction balances the other forces has no
        # acceleration: with a random sign it would seem to stick at once.
        guard = Guard.HELD_FORWARD if forward else Guard.HELD_BACKWARD
        p, (at, _, y, _) = self._p, self._state
        grip = p.mu_static * abs(spring_force(p, y))
        size = holding_force_size(p, at, y) + grip
        balanced = self._smooth and abs(guard_value(p, self._state, guard)) <= BALANCED * size
        away = x[2] > 0.0 if forward else x[2] < 0.0
        return (x[0], x[1], 0.0, *x[3:]) if balanced or away else x

    def _first_end(
        self,
        mode: Mode,
        x: tuple[float, ...],
        y: tuple[float, ...],
        duration: float,
        final: State,
    ) -> tuple[float, Transition] | None:
        # Where in the step, of length 1, the first guard falls to zero, and which.
        found: tuple[float, Transition] | None = None
        last = (final[0], final[1] / duration, final[2], final[3])
        for transition in MODES[mode].ends:
            guard = transition.guard
            root: float | None
            if guard in _OF_HEIGHT:
                root = self._first_root(y, final[2]) if self._separation else None
            else:
                c = self._guard(guard, x, y, duration)
                value = self._guard_after(last, guard, duration)
                root = _first_fall(c, value * duration if guard in OF_SPEED else value)
            if root is None:
                continue
            if found is None or root < found[0] * (1.0 - SIMULTANEOUS):
                found = root, transition
        return found

    def _guard(
        self, guard: Guard, x: tuple[float, ...], y: tuple[float, ...], duration: float
    ) -> list[float]:
        # Coefficients of a guard over the step; its start is that of the state.
        if guard in OF_SPEED:
            sign = OF_SPEED[guard]
            c = [-sign * n * coefficient for n, coefficient in enumerate(x)][1:]
            c[0] = sign * (self._speed - self._state[1]) * duration
        else:
            p, sign = self._p, OF_HOLD[guard]
            a, h = horizontal_stiffness(p), coupling_stiffness(p)
            grip = [p.mu_static * force for force in self._force(y)]
            held = [a * at - h * depth for at, depth in zip(x, y, strict=True)]
            c = [of_grip + sign * force for of_grip, force in zip(grip, held, strict=True)]
            c[0] = guard_value(p, self._state, guard)
        if c[0] <= 0.0:
            # At the start of a mode its guard is zero, and rises but for rounding.
            c[0], c[1] = 0.0, max(c[1], 0.0)
        return c

    def _force(self, y: Sequence[float]) -> list[float]:
        # Coefficients of P.
        p, size = self._p, range(len(y))
        square = [sum(map(mul, y[: n + 1], y[n::-1])) for n in size]
        cube = [sum(map(mul, y[: n + 1], square[n::-1])) for n in size]
        return [-p.k2 * y[n] - p.k_nl * cube[n] for n in size]


def _first_fall(c: Sequence[float], final: float) -> float | None:
    # Where a guard falls to zero. It leaves its chord by max|second derivative|/8 at most; one that
    # starts from zero is taken over θ.
    first = c[0] if c[0] != 0.0 else c[1]
    bulge = sum(abs(coefficient) * n * (n - 1) for n, coefficient in enumerate(c)) / 8.0
    if min(first, final) > bulge:
        return None
    root = first_root(c)
    if root is None and final <= 0.0:
        # By rounding the root is not in the step: take the end of the step.
        return 1.0
    return root
