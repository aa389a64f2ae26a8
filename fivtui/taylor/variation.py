"""Deviations from a motion: its derivatives with respect to changes of start and parameters.

A deviation is the imaginary part of the motion (complex-step derivative). The equations of
`fivtui.model.field` are expanded at a state and parameters with small imaginary parts, so that no
derivative is written by hand. At a switch the saltation matrix applies. Where the slider sticks,
the deviation of ẋ is the change of the belt's speed, and the earlier deviation of ẋ is lost.

A guard is a function of the state whose zero ends a mode. Where one of `SPEED_GUARDS` is zero, the
slider has the speed of the belt; where one of `HOLD_GUARDS` is zero, stick ends.

A deviation oscillates at the system's frequencies even if the motion is slow. So each segment of
the motion is divided into substeps, and the deviation is expanded on each of them.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import accumulate, repeat
from operator import mul
from typing import Any, Final, NamedTuple

from fivtui.model.errors import ComputationError
from fivtui.model.field import CONSTANT, DERIVATIVE_STEP, derivative, field, guard_value
from fivtui.model.modes import MODES, Guard, Mode
from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import MIN_FORCE, State, accelerations
from fivtui.model.system import System

from .belt import HOLD_GUARDS, SPEED_GUARDS
from .recurrence import Terms, motion_function
from .segment import Segment
from .series import Coefficients, coefficient_function, right_hand_side, state_function
from .stepper import overflow_error

ORDER: Final = 20
# Largest ratio of the last two terms of a substep to the greatest of its first nine.
_NEGLIGIBLE: Final = 2.0**-54
_FIRST_TERMS: Final = 9
# Deviations up to this size count as zero, as forces up to it do.
_MIN_DEVIATION: Final = MIN_FORCE
_SHORTENING: Final = 0.8
_MAX_SHORTENINGS: Final = 64


class Seed(NamedTuple):
    """A direction of change: of the start (x, ẋ, y, ẏ), and of parameters by name."""

    start: State
    parameters: Mapping[str, float] = {}


Series = tuple[list[float], list[float]]


def apply_saltation(
    deviation: State, jumps: Sequence[float], guard_change: float, rate: float
) -> State:
    """A deviation after a switch at which a guard g(state, parameters) vanishes.

    The rate of the state is f⁻ before the switch and f⁺ after it; `jumps` is f⁺ − f⁻, and `rate` is
    ∇g·f⁻. With g′, the change of g by the parameters, `guard_change` is ∇g·δ + g′. A deviation δ
    moves the switch by −(∇g·δ + g′)/(∇g·f⁻), hence

        δ⁺ = δ + (f⁺ − f⁻) (∇g·δ + g′)/(∇g·f⁻),

    the saltation matrix I + (f⁺ − f⁻) ∇gᵀ/(∇g·f⁻) with the term of the parameters.
    """
    if not any(jumps):
        return deviation
    shift = guard_change / rate
    x, vx, y, vy = (value + jump * shift for value, jump in zip(deviation, jumps, strict=True))
    return (x, vx, y, vy)


def unbounded_error(t: float) -> ComputationError:
    """The error for deviations that overflow or change too fast at a time, s."""
    return ComputationError(
        f"the derivatives of the motion cannot be computed beyond t = {t:.6g} s",
        "end before that time, or use a less stiff contact",
    )


class Deviations:
    """Deviations from one motion, integrated segment by segment."""

    def __init__(self, p: Parameters, seeds: Sequence[Seed]) -> None:
        self._p = p
        self._perturbed = [p.perturbed(seed.parameters) for seed in seeds]
        # Changes of the belt's speed, used while the slider sticks.
        self._speeds = [seed.parameters.get("v_belt", 0.0) for seed in seeds]
        # Friction does not jump where stick ends: friction by a law of the speed begins with μ_s.
        self._friction_is_continuous = p.mu_static == p.mu or p.speed_law is not None
        self.current: list[State] = [seed.start for seed in seeds]

    def advance(
        self, segment: Segment, end: float = 1.0, fractions: Sequence[float] = ()
    ) -> list[list[State]]:
        """Integrate over the next segment, to θ = `end`; returns the deviations at `fractions`."""
        mode, span = segment.mode, end * segment.duration
        if mode is Mode.STICK:
            self.current = self._with_belt_speed(self.current)
        times = [fraction * segment.duration for fraction in fractions]
        deviations_at: list[list[State]] = [[] for _ in fractions]
        pending = sorted(range(len(times)), key=times.__getitem__, reverse=True)
        covered = 0.0
        while covered < span:
            series = self._series(mode, segment, covered)
            remaining = span - covered
            length = _substep_length(series, remaining)
            if length == 0.0:
                raise self._error_at(segment, covered)
            while pending and (length == remaining or times[pending[-1]] <= covered + length):
                index = pending.pop()
                deviations_at[index] = [_deviation_at(z, times[index] - covered) for z in series]
            self.current = [_deviation_at(z, length) for z in series]
            covered = span if length == remaining else covered + length
        if segment.switches and end == 1.0:
            self._cross_switch(segment)
        if segment.switches and self._ending_guard(segment) in SPEED_GUARDS:
            # At the switch the slider has the belt's speed.
            for fraction, deviations in zip(fractions, deviations_at, strict=True):
                if fraction == 1.0:
                    deviations[:] = self._with_belt_speed(deviations)
        return deviations_at

    def _with_belt_speed(self, deviations: Sequence[State]) -> list[State]:
        return [
            (x, speed, y, vy) for (x, _, y, vy), speed in zip(deviations, self._speeds, strict=True)
        ]

    def _series(self, mode: Mode, segment: Segment, offset: float) -> list[Series]:
        # Expand every deviation at a time after the segment's start.
        duration = segment.duration
        evaluate = state_function(len(segment.x) - 1)
        x, vx, y, vy = evaluate(segment.x, segment.y, offset / duration)
        start = (x, vx / duration, y, vy / duration)
        return [
            _imaginary_parts(expand(p, mode, _add_imaginary_step(start, deviation)))
            for p, deviation in zip(self._perturbed, self.current, strict=True)
        ]

    def _error_at(self, segment: Segment, offset: float) -> ComputationError:
        # Distinguish an overflow of the motion from one of the deviations.
        t = segment.start + offset
        state = segment.state(t)
        motion = expand(self._p, segment.mode, state)
        size = sum(n * abs(value) for z in motion for n, value in enumerate(z, 1))
        if math.isfinite(size):
            return unbounded_error(t)
        return overflow_error(t, state, System(self._p))

    def _ending_guard(self, segment: Segment) -> Guard:
        # The guard whose zero ended the segment.
        return next(
            end.guard for end in MODES[segment.mode].ends if segment.next_mode in end.next_modes
        )

    def _cross_switch(self, segment: Segment) -> None:
        # Apply the switch at the end of a segment to the deviations.
        guard, next_mode = self._ending_guard(segment), segment.next_mode
        if next_mode is Mode.STICK and guard in SPEED_GUARDS:
            self.current = self._with_belt_speed(self.current)
            return
        if guard in HOLD_GUARDS and self._friction_is_continuous:
            return
        p, state, mode = self._p, segment.final, segment.mode
        before, after = accelerations(p, state, mode), accelerations(p, state, next_mode)
        jump = (0.0, after[0] - before[0], 0.0, after[1] - before[1])
        rates = (state[1], before[0], state[3], before[1])
        rate = derivative(guard_value(p, _add_imaginary_step(state, rates), guard))
        if rate == 0.0 and any(jump):
            raise ComputationError(
                f"at t = {segment.end:.9g} s the motion touches {guard.value} = 0 without crossing "
                "it: it has no derivatives there",
                "change the start or a parameter a little",
            )
        self.current = [
            apply_saltation(
                deviation,
                jump,
                derivative(guard_value(perturbed, _add_imaginary_step(state, deviation), guard)),
                rate,
            )
            for perturbed, deviation in zip(self._perturbed, self.current, strict=True)
        ]


def expand(p: Parameters, mode: Mode, state: Any) -> Coefficients:
    """Taylor coefficients of order `ORDER` from real or complex parameters and state."""
    if p.speed_law is None or not MODES[mode].slips:
        return coefficient_function(right_hand_side(p, mode), ORDER)(*state, *field(p, mode))
    # The rates of the parameters are zero: `CONSTANT`.
    terms = Terms(by_law=True, finite_belt=True, over_time=False)
    return motion_function(terms, mode)(p, CONSTANT, state, ORDER)


def _add_imaginary_step(state: State, direction: State) -> tuple[complex, ...]:
    # A state with a small imaginary part in a direction.
    return tuple(
        complex(value, slope * DERIVATIVE_STEP)
        for value, slope in zip(state, direction, strict=True)
    )


def _imaginary_parts(motion: Any) -> Series:
    x, y = (list(map(derivative, z)) for z in motion)
    return x, y


def _substep_length(series: Sequence[Series], remaining: float) -> float:
    # Length of the next substep: the remaining span or an equal part of it. Zero if deviations
    # overflow or need too many substeps.
    if not all(math.isfinite(x[-1] + y[-1]) for x, y in series):
        return 0.0
    sizes = [list(map(max, map(abs, x), map(abs, y))) for x, y in series]
    length = remaining
    for _ in range(_MAX_SHORTENINGS):
        if all(_converges(size, length) for size in sizes):
            return remaining / math.ceil(remaining / length)
        length *= _SHORTENING
    return 0.0


def _converges(size: Sequence[float], length: float) -> bool:
    powers = accumulate(repeat(length, ORDER + 1), mul, initial=1.0)
    terms = list(map(mul, size, powers))
    scale = max(terms[:_FIRST_TERMS])
    # Deviations that count as zero may lose digits.
    return bool(scale <= _MIN_DEVIATION or max(terms[-2:]) <= scale * _NEGLIGIBLE)


def _deviation_at(series: Series, t: float) -> State:
    # Value of a deviation. Flush tiny numbers to zero: subnormal numbers are slow.
    x, vx, y, vy = state_function(ORDER + 1)(series[0], series[1], t)
    return (_flush(x), _flush(vx), _flush(y), _flush(vy))


def _flush(value: float) -> float:
    return value if abs(value) > _MIN_DEVIATION else 0.0
