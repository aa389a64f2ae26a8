"""Variable-step Taylor integrator in plain floats: the default method, also of the Python FMU.

Every step expands the motion about its start (`series`), takes the step size from the last two
coefficients, and ends at the first root of y if there is one. The polynomial of a step is its
dense output, so results do not depend on where output is requested.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import accumulate, repeat
from operator import mul
from typing import Final, NamedTuple

from fivtui.model.advice import CUBIC_CONTACT, LARGER_V_S, LESS_DAMPING, SEPARATION, advise
from fivtui.model.errors import ComputationError, InputError
from fivtui.model.field import field
from fivtui.model.modes import ALWAYS_SLIDING, IN_CONTACT, MODES, Mode, Transition
from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import (
    State,
    lifting_force,
    mode_of,
    static_deflection,
    time_scale,
)
from fivtui.model.system import System

from .polynomial import first_root
from .segment import Segment
from .series import Coefficients, coefficient_function, right_hand_side, state_function

# Default and range of `tol`; `docs/explanation/tolerance.md` defines its accuracy.
DEFAULT_TOL: Final = 1e-12
TOL_RANGE: Final = (1e-13, 1e-2)
# Ratio of the local tolerance to `tol`: local errors add up along the run.
_LOCAL_TOLERANCE: Final = 3e-3

MIN_TOLERANCE: Final = 1e-16
MAX_TOLERANCE: Final = 1e-2
MIN_ORDER: Final = 8
MAX_ORDER: Final = 20
# Largest order with a friction law, which shortens steps.
MAX_LAW_ORDER: Final = 24
ORDER_STEP: Final = 4
# Ratio of the cheapest order to −ln(local tolerance), measured.
_ORDER_OVER_LOG_TOL: Final = 0.655
# Longest step, in units of √(m/stiffness), reached at rest.
LONGEST_STEP: Final = 1e3
# Smallest scale of a coordinate relative to the larger scale of x and y.
MIN_SCALE_RATIO: Final = 2.0**-30
# Offset that centres the error of `rough_exp2`, which is linear between powers of two.
EXP2_BIAS: Final = 0.043
# If a motion overflows at a state below this, in m and m/s, its derivatives overflow: it changes
# too fast.
_SMALL: Final = 1e30
# A step that a switch ends counts as stalled if it is shorter than this multiple of √(m/stiffness).
# More than MAX_STALLED stalled steps in a row are an error: floats do not resolve the switches.
SHORTEST_CUT_STEP: Final = 2.0**-30
MAX_STALLED: Final = 64


class StepperSnapshot(NamedTuple):
    """State of an integrator between two steps.

    `remainder` is the exact time less `t`, s (compensated summation); `mode` is that of the next
    step. `stalled` counts consecutive steps that were too short to advance the motion.
    """

    t: float
    remainder: float
    state: State
    mode: Mode
    stalled: int


def local_tolerance(tol: float) -> float:
    """Local tolerance for a run with the tolerance `tol`."""
    return tol * _LOCAL_TOLERANCE


def order_for(tol: float, *, by_law: bool = False) -> int:
    """Cheapest order of expansion for a local tolerance, a multiple of four.

    After a fast reattachment the cubic spring dominates, ÿ ≈ −k_nl y³/m: then y is v t + O(t⁵), and
    every fourth coefficient is large. Only such an order has one of them last, so that the step
    size is safe. With `by_law` friction falls with the sliding speed.
    """
    order = ORDER_STEP * math.ceil(-_ORDER_OVER_LOG_TOL / ORDER_STEP * math.log(tol))
    return min(max(order, MIN_ORDER), MAX_LAW_ORDER if by_law else MAX_ORDER)


def follows_law(p: Parameters) -> bool:
    """Whether friction falls with the sliding speed."""
    return p.v_belt is not None and p.speed_law is not None


def overflow_error(t: float, state: State, system: System) -> ComputationError:
    """The error for a motion that overflows after a finite time, s, and state.

    A small state does not grow: its derivatives overflow.
    """
    x, _, y, _ = state
    if max(map(abs, state)) < _SMALL:
        return ComputationError(
            f"the motion changes faster than floating-point numbers resolve at t = {t:.6g} s "
            f"(x = {x:.3g} m, y = {y:.3g} m)",
            advise(system, (LARGER_V_S, "a softer contact", LESS_DAMPING, "a greater mass")),
        )
    return ComputationError(
        f"the motion grows beyond the floating-point range at t = {t:.6g} s "
        f"(x = {x:.3g} m, y = {y:.3g} m)",
        advise(system, (SEPARATION, CUBIC_CONTACT, "a shorter run")),
    )


class StallError(ComputationError):
    """The motion changes faster than the spacing of floats."""


def stall_error(t: float, p: Parameters) -> StallError:
    """The error for a motion that changes faster than floats resolve time, at t in s."""
    return StallError(
        f"at t = {t:.17g} s the motion changes faster than floating-point time resolves",
        advise(System(p), ("a less stiff contact", "more damping", LARGER_V_S)),
    )


def rough_log2(number: float) -> float:
    """Logarithm to base 2 of a positive number, linear between powers of two: up to 0.09 too small.

    Accurate enough for step sizes. The compiled kernel reads the bits of a float as an integer.
    """
    mantissa, exponent = math.frexp(number)
    return exponent - 2 + 2.0 * mantissa


def rough_exp2(exponent: float) -> float:
    """Power of two, linear between whole exponents: within 3 %, for exponents of −1000 to 1000."""
    centred = exponent - EXP2_BIAS
    integer = math.floor(centred)
    return math.ldexp(1.0 + (centred - integer), integer)


@lru_cache(maxsize=64)
def _chord_weights(size: int) -> tuple[float, ...]:
    # Distance of θⁿ from its chord: at most an eighth of the second derivative.
    return tuple(n * (n - 1) / 8.0 for n in range(size))


def first_fall(guard: Sequence[float], final: float) -> float | None:
    """The fraction θ of a step at which a guard falls to zero; None if it does not.

    `guard` has the coefficients in θ, `final` is its value at the end.
    """
    # The bound |guard − chord| <= max|second derivative|/8 excludes a root in most steps at the
    # cost of one sum. After a switch the guard starts at zero. Then the bound is used for guard/θ,
    # from its slope at θ = 0 to the same end; its weights (n − 1)(n − 2)/8 would be even smaller.
    chord_distance = sum(map(mul, map(abs, guard), _chord_weights(len(guard))))
    start_value = guard[0] if guard[0] != 0.0 else guard[1]
    if min(start_value, final) > chord_distance:
        return None
    root = first_root(guard)
    # Without a root, rounding has moved it out of the step if the guard is not positive at the end.
    return 1.0 if root is None and final <= 0.0 else root


class TaylorStepper:
    """Taylor integrator that switches mode at y = 0."""

    def __init__(
        self,
        system: System,
        state: State,
        *,
        t: float = 0.0,
        tol: float = 1e-15,
        order: int | None = None,
    ) -> None:
        if not MIN_TOLERANCE <= tol <= MAX_TOLERANCE:
            raise InputError(
                f"local tolerance = {tol}: must be from {MIN_TOLERANCE:g} to {MAX_TOLERANCE:g}"
            )
        if not all(map(math.isfinite, state)):
            raise InputError(f"start = {state}: must be four finite numbers")
        p = system.parameters
        self._separation = separation = system.separation
        self._tol = tol
        self._degree = (order or order_for(tol, by_law=follows_law(p))) + 1
        self._set_parameters(p)
        self._coefficient_functions = {
            mode: coefficient_function(right_hand_side(p, mode), self._degree - 1)
            for mode in self._fields
        }
        self._evaluate = state_function(self._degree)
        self._time, self._remainder, self._state = t, 0.0, state
        self._stalled = 0
        self._mode = mode_of(p, state, separation=separation)

    def _set_parameters(self, p: Parameters) -> None:
        modes = ALWAYS_SLIDING if p.v_belt is None else tuple(Mode)
        self._p = p
        self._fields = {mode: field(p, mode) for mode in modes}
        self._deflection = static_deflection(p)
        self._time_scale = time_scale(p)

    @property
    def snapshot(self) -> StepperSnapshot:
        """State of the integrator, at the end of the last segment."""
        return StepperSnapshot(self._time, self._remainder, self._state, self._mode, self._stalled)

    def resume(self, snapshot: StepperSnapshot) -> None:
        """Return to a snapshot of the same problem; what follows is bit-identical."""
        self._time, self._remainder, self._state, self._mode, self._stalled = snapshot

    def advance(self) -> Segment:
        """Compute the next segment: one Taylor step, cut where its mode ends.

        Raises `ComputationError` if the motion overflows, or switches faster than time resolves.
        """
        mode, start, remainder = self._mode, self._time, self._remainder
        # Coefficients in m/sⁿ, then in m over the fraction θ of the step.
        x, y = motion = self._expand(mode)
        duration = self._step_size(x, y)
        powers = tuple(accumulate(repeat(duration, self._degree), mul, initial=1.0))
        x, y = tuple(map(mul, x, powers)), tuple(map(mul, y, powers))
        final = self._evaluate(x, y, 1.0)
        end = self._find_first_end(motion, y, powers, final)
        transition: Transition | None = None
        if end is not None:
            root, transition = end
            duration *= root
            powers = tuple(accumulate(repeat(root, self._degree), mul, initial=1.0))
            x, y = tuple(map(mul, x, powers)), tuple(map(mul, y, powers))
            final = self._evaluate(x, y, 1.0)
        if not math.isfinite(sum(final)) or duration == 0.0:
            raise self._overflow_error(self._state)
        self._state = state = self._final_state(final, duration, transition)
        self._add_to_time(duration)
        if transition is not None:
            self._mode = self._next_mode(transition, state)
        self._check_progress(mode, start, duration, cut=transition is not None)
        return Segment(mode, start, remainder, duration, self._time, x, y, state, self._mode)

    def _expand(self, mode: Mode) -> Coefficients:
        # The coefficients of x and y in m/sⁿ.
        x, y = self._coefficient_functions[mode](*self._state, *self._fields[mode])
        return x, self._balance_forces(y) if self._state[2] == 0.0 and self._separation else y

    def _find_first_end(
        self, _motion: Coefficients, y: tuple[float, ...], _powers: Sequence[float], final: State
    ) -> tuple[float, Transition] | None:
        # Earliest end of the mode as a fraction θ of the step, with its transition; y has the
        # coefficients in θ. `BeltStepper`, a subclass, also uses those in m/sⁿ, `_motion`, and the
        # powers of the step's duration.
        root = self._first_root(y, final[2]) if self._separation else None
        return None if root is None else (root, MODES[self._mode].ends[0])

    def _final_state(self, final: State, duration: float, transition: Transition | None) -> State:
        # Convert the final state from velocities by θ to SI units; y is zero at a switch.
        x, vx, y, vy = final
        return (x, vx / duration, y if transition is None else 0.0, vy / duration)

    def _next_mode(self, _ended: Transition, state: State) -> Mode:
        return mode_of(self._p, state, separation=self._separation)

    def _balance_forces(self, y: tuple[float, ...]) -> tuple[float, ...]:
        # At y = 0 the coupling spring may balance F. Then ÿ is due to the damper alone: a rounding
        # error of random sign would cause repeated switches. `half` and `sixth`, the coefficients
        # of t² and t³, are ÿ/2 and a sixth of its rate of change.
        x, vx, _, vy = self._state
        if lifting_force(self._p, x) != 0.0:
            return y
        coefficients = self._fields[self._mode]
        half = 0.5 * coefficients.yvy * vy
        sixth = (coefficients.yx * vx + coefficients.yy * vy + 2.0 * coefficients.yvy * half) / 6.0
        return (*y[:2], half, sixth, *y[4:])

    def _step_size(self, x: tuple[float, ...], y: tuple[float, ...]) -> float:
        # Keep the last two terms of each velocity below the tolerance relative to the scale of that
        # coordinate. The scale is at least a fraction of the larger scale of x, y and the static
        # deflection.
        scales = [max(abs(z[1]), abs(z[0]) / self._time_scale) for z in (x, y)]
        min_scale = MIN_SCALE_RATIO * max(*scales, self._deflection / self._time_scale)
        longest = LONGEST_STEP * self._time_scale
        exponent = math.inf
        for z, scale in zip((x, y), scales, strict=True):
            allowed = self._tol * max(scale, min_scale)
            for n in (self._degree, self._degree - 1):
                term = n * abs(z[n])
                if not math.isfinite(term):
                    raise self._overflow_error(self._state)
                if term > 0.0 and allowed > 0.0:
                    exponent = min(exponent, (rough_log2(allowed) - rough_log2(term)) / (n - 1))
        return longest if exponent == math.inf else min(longest, rough_exp2(exponent))

    def _first_root(self, y: tuple[float, ...], final: float) -> float | None:
        # The first switch in a step; y has the coefficients in its fraction θ, `final` is y at 1.
        if self._mode in IN_CONTACT:
            return first_fall([-coefficient for coefficient in y], -final)
        return first_fall(y, final)

    def _overflow_error(self, state: State) -> ComputationError:
        return overflow_error(self._time, state, System(self._p, self._separation))

    def _add_to_time(self, duration: float) -> None:
        # Two-sum, so that the rounding of t does not grow with the number of steps.
        increment = duration + self._remainder
        total = self._time + increment
        self._remainder = (self._time - (total - (total - self._time))) + (
            increment - (total - self._time)
        )
        self._time = total

    def _check_progress(self, _mode: Mode, start: float, duration: float, *, cut: bool) -> None:
        # Raises `ComputationError` if many steps in a row did not advance the motion.
        self._count_stalled(start, short=cut and duration < SHORTEST_CUT_STEP * self._time_scale)

    def _count_stalled(self, start: float, *, short: bool) -> None:
        self._stalled = self._stalled + 1 if short or self._time == start else 0
        if self._stalled > MAX_STALLED:
            raise stall_error(start, self._p)
