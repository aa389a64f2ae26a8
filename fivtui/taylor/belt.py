"""The Taylor integrator for a belt of finite speed and for parameters that follow tables over time.

A step ends at the first zero of a guard of its mode, see `MODES`, or at a row of a table. Between
rows parameters change linearly, so that guards are power series of time.
"""

from collections.abc import Sequence
from dataclasses import replace
from operator import mul
from typing import Final

from fivtui.model.field import (
    CONSTANT,
    guard_value,
    holding_force_size,
    spring_force,
)
from fivtui.model.modes import MODES, Guard, Mode, Transition
from fivtui.model.over_time import Course, parameters_after
from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import BALANCE_TOL, State, lifting_force, mode_of, static_deflection
from fivtui.model.system import System

from .recurrence import Terms, guard_function, motion_function
from .segment import Segment
from .series import Coefficients
from .stepper import TaylorStepper, first_fall, local_tolerance

# Roots of two guards this close, relative to the step, count as simultaneous. Then the transition
# listed first in `MODES` applies: separation before others.
SIMULTANEOUS: Final = 2.0**-40
# A friction law may shorten steps so far that the run would never end. Steps below this, relative
# to t, count as stalled.
UNRESOLVED: Final = 2.0**-50
# With a friction law, friction falls with the sliding speed v, m/s, as exp(−v/v_s). The expansion
# of this exponential converges if v/v_s changes over the step by at most _MAX_CHANGE plus _GROWTH
# times its value at the start.
_MAX_CHANGE: Final = 12.0
_GROWTH: Final = 0.09
# Longer steps are allowed if v/v_s stays above this: the exponential is below rounding.
_NEGLIGIBLE: Final = 37.0
# Factor by which a step is shortened until it is short enough.
_SHRINK_FACTOR: Final = 0.75
# Guards that fall to zero where the slider lands or separates (y = 0).
_HEIGHT_GUARDS: Final = (Guard.HEIGHT, Guard.DEPTH)
# Guards that fall to zero where the slider reaches the speed of the belt.
SPEED_GUARDS: Final = (Guard.BELT_FASTER, Guard.BELT_SLOWER)
# Guards that fall to zero where friction can no longer hold the slider at that speed.
HOLD_GUARDS: Final = (Guard.HELD_FORWARD, Guard.HELD_BACKWARD)


class BeltStepper(TaylorStepper):
    """Taylor integrator for a belt of finite speed, or for tables over time."""

    def __init__(
        self,
        system: System,
        state: State,
        *,
        t: float = 0.0,
        tol: float = 1e-15,
        order: int | None = None,
    ) -> None:
        tables = system.over_time
        self._course = Course(system.parameters, tables)
        p, self._rates = self._course.after(t)
        super().__init__(System(p, system.separation), state, t=t, tol=tol, order=order)
        self._row_time = self._course.next_row_time(t)
        self._mode = mode_of(p, state, separation=system.separation, rates=self._rates)
        if tables:
            # A table of μ may begin at μ_s and fall later. `speed_law` cannot be used: it is None
            # where μ = μ_s, because friction is constant there.
            self._by_law = p.v_s is not None and p.mu_s is not None
        else:
            self._by_law = p.speed_law is not None
        self._terms = Terms(self._by_law, p.v_belt is not None, bool(tables))

    def _set_parameters(self, p: Parameters) -> None:
        super()._set_parameters(p)
        # The scale of displacements in `TaylorStepper._step_size`.
        self._deflection = static_deflection(p.with_inputs({"F": self._course.greatest_load}))

    def advance(self) -> Segment:
        """Compute the next segment as `TaylorStepper.advance` does; cut it also at a table row."""
        if self._terms.over_time:
            self._p, self._rates = self._course.after(self._time)
            self._row_time = self._course.next_row_time(self._time)
        segment = super().advance()
        return segment if segment.end < self._row_time else self._end_at_row(segment)

    def _time_to_row(self) -> float:
        # Time until the next row, s. The exact time is `_time` + `_remainder`, see
        # `StepperSnapshot`.
        return (self._row_time - self._time) - self._remainder

    def _end_at_row(self, segment: Segment) -> Segment:
        # At a row of the table the mode may change without an event.
        self._time, self._remainder = self._row_time, 0.0
        p, rates = self._course.after(self._row_time)
        self._set_parameters(p)
        if segment.switches:
            # A guard at the same time has set the mode.
            return replace(segment, end=self._row_time)
        self._mode = mode_of(p, self._state, separation=self._separation, rates=rates)
        return replace(segment, end=self._row_time, next_mode=self._mode)

    def _step_size(self, x: tuple[float, ...], y: tuple[float, ...]) -> float:
        # Limit the step to the range of the expansions and to the next row.
        duration = super()._step_size(x, y)
        if self._by_law and MODES[self._mode].slips:
            duration = self._limit_to_law(duration, x)
        return min(duration, self._time_to_row())

    def _limit_to_law(self, duration: float, x: tuple[float, ...]) -> float:
        # The longest part of a step, s, over which the expansion of exp(−v/v_s) converges or this
        # exponential is negligible.
        v_s = self._p.v_s or 1.0
        speed = MODES[self._mode].friction_sign * ((self._p.v_belt or 0.0) - x[1])
        exponent = max(speed / v_s, 0.0)
        convergent_change = _MAX_CHANGE + _GROWTH * exponent
        # After this change v/v_s is _NEGLIGIBLE.
        negligible_change = exponent - _NEGLIGIBLE
        allowed = max(convergent_change, negligible_change) * v_s
        # v also changes with the speed of the belt.
        relative_motion = (*x[:2], x[2] - 0.5 * self._rates.v_belt, *x[3:])
        while _max_speed_change(relative_motion, duration) > allowed:
            duration *= _SHRINK_FACTOR
        return duration

    def _final_state(self, final: State, duration: float, transition: Transition | None) -> State:
        # The velocities in `final` are in m per step: convert them to m/s. Where a guard is zero,
        # set its coordinate or speed to the exact value.
        x, vx, y, vy = final
        guard = None if transition is None else transition.guard
        has_belt_speed = self._mode is Mode.STICK or guard in SPEED_GUARDS
        speed = self._speed_after(duration) if has_belt_speed else vx / duration
        return (x, speed, 0.0 if guard in _HEIGHT_GUARDS else y, vy / duration)

    def _speed_after(self, duration: float) -> float:
        # Speed of the belt after the step, m/s.
        if not self._terms.over_time:
            return self._p.v_belt or 0.0
        if duration >= self._time_to_row():
            return self._course.speed_before(self._row_time)
        # Read the table, so that a sticking slider has the belt's speed to the last bit.
        p, _ = self._course.after(self._time + (duration + self._remainder))
        return p.v_belt or 0.0

    def _next_mode(self, transition: Transition, state: State) -> Mode:
        if transition.guard in HOLD_GUARDS:
            # The guard determines the mode after stick; by the state alone, within rounding, stick
            # could go on.
            return transition.next_modes[0]
        p, rates = self._course.after(self._time)
        return mode_of(p, state, separation=self._separation, rates=rates)

    def _expand(self, mode: Mode) -> Coefficients:
        state = self._state
        if self._terms.over_time or (self._by_law and MODES[mode].slips):
            motion = motion_function(self._terms, mode)
            x, y = motion(self._p, self._rates, state, self._degree - 1)
        else:
            x, y = self._coefficient_functions[mode](*state, *self._fields[mode])
        if state[2] == 0.0 and self._separation:
            y = self._balance_forces(y)
        if state[1] == self._p.v_belt and MODES[mode].slips:
            x = self._set_belt_acceleration(x, forward=mode is Mode.FORWARD)
        return x, y

    def _balance_forces(self, y: tuple[float, ...]) -> tuple[float, ...]:
        # If the coupling spring balances the load at y = 0, the base class leaves both out of the
        # coefficients of t² and t³: their sum is a rounding error.
        y = super()._balance_forces(y)
        is_balanced = lifting_force(self._p, self._state[0]) == 0.0
        # The rates CONSTANT are zero.
        if self._rates is CONSTANT or not is_balanced:
            return y
        # A load that changes at a constant rate Ḟ adds −Ḟ/m to the third derivative of y. Its
        # Taylor coefficient is a sixth of it.
        return (*y[:3], y[3] - self._rates.F / (6.0 * self._p.m), *y[4:])

    def _set_belt_acceleration(self, x: tuple[float, ...], *, forward: bool) -> tuple[float, ...]:
        # At the belt's speed, use the belt's acceleration where friction balances the other forces,
        # or where the slider would become faster (`forward`) or slower than the belt. Else a
        # rounding error makes the slider stick again at once.
        guard = Guard.HELD_FORWARD if forward else Guard.HELD_BACKWARD
        p, (position, _, y, _) = self._p, self._state
        # Limit of static friction, and its excess over the force that would hold the slider, N.
        max_friction = p.mu_static * abs(spring_force(p, y))
        excess = guard_value(p, self._state, guard, self._rates)
        # Sum of the absolute terms of the excess, N, to which its rounding error is relative.
        size = holding_force_size(p, position, y, self._rates) + max_friction
        # Friction is continuous at v_r = 0.
        is_continuous = p.mu_static == p.mu or p.speed_law is not None
        is_balanced = is_continuous and abs(excess) <= BALANCE_TOL * size
        half_belt_acceleration = 0.5 * self._rates.v_belt
        passes_belt = x[2] > half_belt_acceleration if forward else x[2] < half_belt_acceleration
        return (x[0], x[1], half_belt_acceleration, *x[3:]) if is_balanced or passes_belt else x

    def _check_progress(self, mode: Mode, start: float, duration: float, *, cut: bool) -> None:
        # `cut` says whether a guard ended the step. The base class counts a short step as stalled
        # only if it is cut; a friction law also shortens steps without a guard.
        if self._by_law and MODES[mode].slips and duration < UNRESOLVED * start:
            self._count_stalled(start, short=True)
        else:
            super()._check_progress(mode, start, duration, cut=cut)

    def _find_first_end(
        self, motion: Coefficients, y: tuple[float, ...], powers: Sequence[float], final: State
    ) -> tuple[float, Transition] | None:
        # `motion` has the coefficients of x and y in m/sⁿ, `y` those of y in m over θ, the fraction
        # of the step; `powers` are powers of the step's duration.
        first_end: tuple[float, Transition] | None = None
        duration = powers[1]
        for transition in MODES[self._mode].ends:
            guard = transition.guard
            root: float | None
            if guard in _HEIGHT_GUARDS:
                root = self._first_root(y, final[2]) if self._separation else None
            else:
                c = guard_function(self._terms, guard)(self._p, self._rates, *motion)
                if c[0] <= 0.0:
                    # A guard of the current mode is positive, or zero and rising where the mode
                    # begins. It is negative or falling only by rounding: set these to zero.
                    c[0], c[1] = 0.0, max(c[1], 0.0)
                end_state = (final[0], final[1] / duration, final[2], final[3] / duration)
                value = self._guard_at_end(end_state, guard, duration)
                root = first_fall(list(map(mul, c, powers)), value)
            if root is None:
                continue
            # Of simultaneous roots the first in the table of modes counts.
            if first_end is None or root < first_end[0] * (1.0 - SIMULTANEOUS):
                first_end = root, transition
        return first_end

    def _guard_at_end(self, state: State, guard: Guard, duration: float) -> float:
        # Value of a guard at the end of a step.
        p = parameters_after(self._p, self._rates, duration)
        return float(guard_value(p, state, guard, self._rates))


def _max_speed_change(x: Sequence[float], duration: float) -> float:
    # Upper bound of the change of ẋ over a step.
    total = 0.0
    for n in range(len(x) - 1, 1, -1):
        total = (total + n * abs(x[n])) * duration
    return total


def taylor_stepper(system: System, state: State, *, t: float = 0.0, tol: float) -> TaylorStepper:
    """The integrator of a system from a state, with the local tolerance for a run's `tol`."""
    needs_belt = system.parameters.v_belt is not None or bool(system.over_time)
    stepper_class = BeltStepper if needs_belt else TaylorStepper
    return stepper_class(system, state, t=t, tol=local_tolerance(tol))
