"""The Taylor integrator where F, μ and the belt's speed follow tables: steps end at their rows.

Between rows these change linearly, so that the motion is still analytic and guards are polynomials.
"""

import dataclasses
import math
from collections.abc import Sequence
from operator import mul

from fivtui.model.field import (
    Rates,
    coupling_stiffness,
    guard_value,
    holding_force,
    holding_force_size,
    horizontal_stiffness,
    load,
    spring_force,
)
from fivtui.model.modes import IN_CONTACT, MODES, Guard, Mode, Transition
from fivtui.model.over_time import Course
from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import BALANCED, State, lift, mode_of, static_deflection

from .belt import OF_HOLD, OF_SPEED, BeltStepper
from .friction import Law, decay
from .segment import BeltSegment
from .series import Coefficients


class DrivenStepper(BeltStepper):
    """Taylor integrator of a motion whose parameters follow a course.

    Parameters
    ----------
    course : Course
        The parameters over time.
    state : State
        (x, ẋ, y, ẏ) at the start, m and m/s.
    t : float
        Start time, s.
    separation : bool
        Whether separation is considered.
    tol : float
        Local relative tolerance.
    """

    def __init__(
        self, course: Course, state: State, *, t: float = 0.0, separation: bool, tol: float
    ) -> None:
        p, rates = course.after(t)
        super().__init__(p, state, t=t, separation=separation, tol=tol)
        self._course = course
        self._deflection = static_deflection(p.with_values({"F": course.greatest_load}))
        self._rates = rates
        self._break = course.next_break(t)
        self._mode = mode_of(p, state, separation=separation, rates=rates)

    def advance(self) -> BeltSegment:
        """Compute the next segment: one Taylor step, cut at the first switch or row of a table.

        Raises `ComputationError` if the motion overflows, or switches faster than time resolves.
        """
        self._set_out()
        self._break = self._course.next_break(self._time)
        segment = super().advance()
        if segment.end < self._break:
            return segment
        self._time, self._remainder = self._break, 0.0
        p, rates = self._course.after(self._break)
        then = mode_of(p, self._state, separation=self._separation, rates=rates)
        if segment.switches and segment.then is not then:
            # The guard fell to zero where the table bends: what follows has been decided.
            then = segment.then
        self._mode = then
        return dataclasses.replace(
            segment, end=self._break, switches=then is not segment.mode, then=then
        )

    def _set_out(self) -> None:
        # The parameters from now on.
        self._p, self._rates = self._course.after(self._time)
        p = self._p
        self._speed = p.v_belt or 0.0
        self._laws = {mode: _law_over_time(p, mode) for mode in Mode}
        self._smooth = p.mu_static == p.mu or p.speed_law is not None

    def _limited(self, mode: Mode, x: Sequence[float], duration: float) -> float:
        left = (self._break - self._time) - self._remainder
        # v_r changes by what the belt's speed does, too.
        apart = (*x[:2], x[2] - 0.5 * self._rates.v_belt, *x[3:])
        return min(super()._limited(mode, apart, duration), left)

    def _speed_after(self, duration: float) -> float:
        if duration >= (self._break - self._time) - self._remainder:
            return self._course.speed_before(self._break)
        # As it is taken from the tables there: a slider of the belt's speed has it to the last bit.
        p, _ = self._course.after(self._time + (duration + self._remainder))
        return p.v_belt or 0.0

    def _successor(self, transition: Transition, state: State) -> Mode:
        if transition.guard in OF_HOLD:
            return transition.to[0]
        p, rates = self._course.after(self._time)
        return mode_of(p, state, separation=self._separation, rates=rates)

    def _expanded(self, mode: Mode) -> Coefficients:
        state = self._state
        x, y = driven_coefficients(
            self._p, mode, self._laws[mode], state, rates=self._rates, order=self._degree - 1
        )
        if state[2] == 0.0 and self._separation:
            y = self._settled(y)
        if state[1] == self._speed and mode in (Mode.FORWARD, Mode.BACKWARD):
            x = self._started(x, forward=mode is Mode.FORWARD)
        return x, y

    def _settled(self, y: tuple[float, ...]) -> tuple[float, ...]:
        settled = super()._settled(y)
        if lift(self._p, self._state[0]) != 0.0:
            return settled
        return (*settled[:3], settled[3] - self._rates.F / (6.0 * self._p.m), *settled[4:])

    def _started(self, x: tuple[float, ...], *, forward: bool) -> tuple[float, ...]:
        guard = Guard.HELD_FORWARD if forward else Guard.HELD_BACKWARD
        p, (at, _, y, _) = self._p, self._state
        grip = p.mu_static * abs(spring_force(p, y))
        size = holding_force_size(p, at, y, self._rates) + grip
        left = guard_value(p, self._state, guard, self._rates)
        balanced = self._smooth and abs(left) <= BALANCED * size
        with_belt = 0.5 * self._rates.v_belt
        away = x[2] > with_belt if forward else x[2] < with_belt
        return (x[0], x[1], with_belt, *x[3:]) if balanced or away else x

    def _guard_after(self, state: State, guard: Guard, duration: float) -> float:
        p, rates = self._p, self._rates
        if guard in OF_SPEED:
            return OF_SPEED[guard] * (self._speed + rates.v_belt * duration - state[1])
        x, _, y, _ = state
        held = holding_force(p, x, y, rates) + p.c1 * rates.v_belt * duration
        grip = p.mu_static + (rates.mu * duration if p.mu_s is None else 0.0)
        margin: float = grip * spring_force(p, y) + OF_HOLD[guard] * held
        return margin

    def _guard(
        self, guard: Guard, x: tuple[float, ...], y: tuple[float, ...], duration: float
    ) -> list[float]:
        p, rates = self._p, self._rates
        start = guard_value(p, self._state, guard, rates)
        if guard in OF_SPEED:
            sign = OF_SPEED[guard]
            c = [-sign * n * coefficient for n, coefficient in enumerate(x)][1:]
            c[0] = start * duration
            c[1] += sign * rates.v_belt * duration * duration
        else:
            sign, force = OF_HOLD[guard], self._force(y)
            a, h = horizontal_stiffness(p), coupling_stiffness(p)
            more = rates.mu * duration if p.mu_s is None else 0.0
            grip = [
                p.mu_static * here + more * before
                for here, before in zip(force, [0.0, *force], strict=False)
            ]
            held = [a * at - h * depth for at, depth in zip(x, y, strict=True)]
            c = [of_grip + sign * each for of_grip, each in zip(grip, held, strict=True)]
            c[0] = start
            c[1] += sign * p.c1 * rates.v_belt * duration
        if c[0] <= 0.0:
            # At the start of a mode its guard is zero, and rises but for rounding.
            c[0], c[1] = 0.0, max(c[1], 0.0)
        return c


def _law_over_time(p: Parameters, mode: Mode) -> Law | None:
    # There is a law, too, where μ is μ_s: it may fall from there.
    if p.mu_s is None or p.v_s is None or mode not in (Mode.FORWARD, Mode.BACKWARD):
        return None
    return Law(MODES[mode].friction_sign, p.mu, p.mu_s - p.mu, 1.0 / p.v_s)


def driven_coefficients(
    p: Parameters, mode: Mode, law: Law | None, state: State, *, rates: Rates, order: int
) -> Coefficients:
    """Taylor coefficients of x and of y, `order` + 2 each, in m/sⁿ, of Eqs. 2 and 5.

    F, μ and the belt's speed are those of `p` at the start of the step and change at `rates`.
    """
    m, h, a = p.m, coupling_stiffness(p), horizontal_stiffness(p)
    touches, sign = mode in IN_CONTACT, MODES[mode].friction_sign
    x, y = [state[0], state[1]], [state[2], state[3]]
    mu = (p.mu, rates.mu)
    # μ(v) = μ + (μ_s − μ) e, where μ_s is constant: without a law e is left out.
    fall = (0.0, 0.0) if law is None else (law.fall, -rates.mu)
    e = [0.0 if law is None else decay(law.sign * ((p.v_belt or 0.0) - state[1]) * law.per_speed)]
    rate = 0.0 if law is None else law.sign * law.per_speed
    square: list[float] = []
    force: list[float] = []
    weight: list[float] = []
    gap: list[float] = []
    for n in range(order):
        square.append(_product(y, y, n))
        force.append(-p.k2 * y[n] - p.k_nl * _product(y, square, n) if touches else 0.0)
        if n > 0:
            e.append(rate * _product(gap, e, n - 1) / n)
        weight.append(_linear(mu, n) + fall[0] * e[n] + (fall[1] * e[n - 1] if n > 0 else 0.0))
        ay = (
            force[n]
            + h * (x[n] - y[n])
            - p.c2 * ((n + 1) * y[n + 1])
            - _linear((load(p), rates.F), n)
        )
        if mode is Mode.STICK:
            ax = rates.v_belt if n == 0 else 0.0
        else:
            friction = sign * _product(weight, force, n)
            ax = (friction - p.c1 * ((n + 1) * x[n + 1]) - a * x[n] + h * y[n]) / m
        # Of ẍ less the belt's acceleration.
        gap.append(ax - rates.v_belt if n == 0 else ax)
        share = 1.0 / ((n + 1) * (n + 2))
        x.append(ax * share)
        y.append(ay / m * share)
    return tuple(x), tuple(y)


def _linear(coefficients: tuple[float, float], n: int) -> float:
    return coefficients[n] if n < len(coefficients) else 0.0


def _product(a: Sequence[float], b: Sequence[float], n: int) -> float:
    # The n-th coefficient of a product.
    return math.fsum(map(mul, a[: n + 1], b[n::-1]))
