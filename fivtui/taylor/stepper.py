"""Variable-step Taylor integrator in plain floats: the default method, and what the FMU runs.

Every step expands the motion about its start (`recurrences`), takes the step size from the last
two coefficients, and ends at the first root of y if there is one. Nothing depends on where output
is wanted: the polynomial of a step is its dense output.
"""

import math
from itertools import accumulate, repeat
from operator import mul
from typing import Final, NamedTuple

from fivtui.model.errors import ComputationError, InputError
from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import Mode, State, mode_of, pull

from .polynomial import first_root
from .segment import Segment
from .series import coefficient_function, constants, right_hand_side, state_function

# Relative error to aim at in the end state, and what may be asked for.
DEFAULT_TOL: Final = 1e-12
TOL_RANGE: Final = (1e-13, 1e-2)
# Local errors add up and grow along the run; this much smaller, `tol` is the error at its end.
_LOCAL_TOLERANCE: Final = 1e-3

MIN_TOLERANCE: Final = 1e-16
MAX_TOLERANCE: Final = 1e-2
MIN_ORDER: Final = 8
MAX_ORDER: Final = 20
ORDER_STEP: Final = 4
# A step never exceeds this many times √(m/stiffness), at rest least of all.
LONGEST_STEP: Final = 1e3
# Half of what a straight line exceeds the power of two by, as an exponent.
EXP2_BIAS: Final = 0.043
# A step that a switch ends before this many times √(m/stiffness) does not advance the motion, and
# more of these in a row than can be are chatter below the spacing of floats.
SHORTEST_FLIGHT: Final = 2.0**-30
MAX_STALLED: Final = 64


class StepperSnapshot(NamedTuple):
    """Where an integrator stands: all that a step changes.

    Attributes
    ----------
    t, remainder : float
        Time, s, and what it lacks of the exact time (compensated summation).
    state : State
        (x, ẋ, y, ẏ), m and m/s.
    mode : Mode
        The field that governs the next step.
    stalled : int
        Steps taken, one after the other, that did not advance.
    """

    t: float
    remainder: float
    state: State
    mode: Mode
    stalled: int


def local_tolerance(tol: float) -> float:
    """Local tolerance of the Taylor integrator for an aimed relative error of the end state.

    Parameters
    ----------
    tol : float
        Aimed relative error after about a hundred periods.

    Returns
    -------
    float
        Tolerance for one step.
    """
    return tol * _LOCAL_TOLERANCE


def order_for(tol: float) -> int:
    """Order of expansion that is cheapest for a tolerance, a multiple of four.

    After a landing y is v t + O(t⁵) and every fourth coefficient stands out; only with such an
    order is the last one among them, and the step size safe.

    Parameters
    ----------
    tol : float
        Local tolerance.

    Returns
    -------
    int
        Order N of the velocities.
    """
    return min(max(ORDER_STEP * math.ceil(-0.6 / ORDER_STEP * math.log(tol)), MIN_ORDER), MAX_ORDER)


def overflow_error(t: float, state: State) -> ComputationError:
    """An error for a motion that leaves the range of numbers.

    Parameters
    ----------
    t : float
        Last time at which all was well, s.
    state : State
        The state then.

    Returns
    -------
    ComputationError
        To be raised by the caller.
    """
    x, _, y, _ = state
    return ComputationError(
        f"the motion grows out of the range of numbers at t = {t:.6g} s "
        f"(x = {x:.3g} m, y = {y:.3g} m)",
        "it is unbounded: consider separation, use a cubic contact, or end before that time",
    )


def stall_error(t: float) -> ComputationError:
    """An error for a motion that the spacing of floats cannot resolve in time.

    Parameters
    ----------
    t : float
        Where time stands still, s.

    Returns
    -------
    ComputationError
        To be raised by the caller.
    """
    return ComputationError(
        f"at t = {t:.17g} s the motion changes faster than the spacing of time",
        "use a less stiff contact, more damping or a later start",
    )


def rough_log2(number: float) -> float:
    """Logarithm to base 2, by a straight line between powers of two.

    Step sizes need no more, and in machine code it is the bits of a float read as an integer.

    Parameters
    ----------
    number : float
        Positive.

    Returns
    -------
    float
        At most 0.09 too small.
    """
    mantissa, exponent = math.frexp(number)
    return exponent - 2 + 2.0 * mantissa


def rough_exp2(exponent: float) -> float:
    """Power of two, by a straight line between whole exponents.

    Parameters
    ----------
    exponent : float
        Between -1000 and 1000.

    Returns
    -------
    float
        Within 3 %.
    """
    centred = exponent - EXP2_BIAS
    whole = math.floor(centred)
    return math.ldexp(1.0 + (centred - whole), whole)


class TaylorStepper:
    """Taylor series of the motion, step by step, switching mode at y = 0.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    state : State
        (x, ẋ, y, ẏ) at `t`, m and m/s.
    t : float
        Start time, s.
    separation : bool
        Whether separation is considered.
    tol : float
        Local tolerance: last Taylor term of the velocities relative to the speed.
    order : int, optional
        Order of expansion; chosen from `tol` if not given.

    Raises
    ------
    InputError
        If `tol` or the state is out of range.
    """

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
        if not MIN_TOLERANCE <= tol <= MAX_TOLERANCE:
            raise InputError(
                f"local tolerance = {tol}: must be from {MIN_TOLERANCE:g} to {MAX_TOLERANCE:g}"
            )
        if not all(map(math.isfinite, state)):
            raise InputError(f"start = {state}: must be four finite numbers")
        self._p = p
        self._separation = separation
        self._tol = tol
        self._degree = (order_for(tol) if order is None else order) + 1
        self._constants = {mode: constants(p, mode) for mode in Mode}
        self._expand = {
            mode: coefficient_function(right_hand_side(p, mode), self._degree - 1) for mode in Mode
        }
        self._evaluate = state_function(self._degree)
        self._weights = tuple(n * (n - 1) / 8.0 for n in range(self._degree + 1))
        stiffness = p.k1 + p.k2 + p.k3
        self._deflection = abs(p.F) / stiffness
        self._time_scale = math.sqrt(p.m / stiffness)
        self._time, self._remainder, self._state = t, 0.0, state
        self._stalled = 0
        self._mode = mode_of(p, state, separation=separation)

    @property
    def snapshot(self) -> StepperSnapshot:
        """Where the integrator stands: at the end of the last segment."""
        return StepperSnapshot(self._time, self._remainder, self._state, self._mode, self._stalled)

    def resume(self, snapshot: StepperSnapshot) -> None:
        """Go back, or on, to where an integrator of the same problem stood.

        Parameters
        ----------
        snapshot : StepperSnapshot
            The segments that follow are those that followed then, to the last bit.
        """
        self._time, self._remainder, self._state, self._mode, self._stalled = snapshot

    def advance(self) -> Segment:
        """Compute the next segment: one Taylor step, cut at the first root of y.

        Returns
        -------
        Segment
            It begins where the last one ended.

        Raises
        ------
        ComputationError
            If the motion leaves the range of numbers, or switches faster than time can resolve.
        """
        mode = self._mode
        x, y = self._expand[mode](*self._state, *self._constants[mode])
        if self._state[2] == 0.0 and self._separation:
            y = self._settled(y)
        duration = self._step_size(x, y)
        powers = tuple(accumulate(repeat(duration, self._degree), mul, initial=1.0))
        x, y = tuple(map(mul, x, powers)), tuple(map(mul, y, powers))
        final = self._evaluate(x, y, 1.0)
        root = self._first_root(y, final[2]) if self._separation else None
        if root is not None:
            duration *= root
            powers = tuple(accumulate(repeat(root, self._degree), mul, initial=1.0))
            x, y = tuple(map(mul, x, powers)), tuple(map(mul, y, powers))
            final = self._evaluate(x, y, 1.0)
        if not math.isfinite(sum(final)) or duration == 0.0:
            raise overflow_error(self._time, self._state)
        self._state = state = (
            final[0],
            final[1] / duration,
            final[2] if root is None else 0.0,
            final[3] / duration,
        )
        if root is not None:
            self._mode = mode_of(self._p, state, separation=True)
        start, remainder = self._time, self._remainder
        self._add_to_time(duration)
        short = root is not None and duration < SHORTEST_FLIGHT * self._time_scale
        self._check_progress(start, short=short)
        switches = self._mode is not mode
        return Segment(mode, start, remainder, duration, self._time, x, y, state, switches)

    def _settled(self, y: tuple[float, ...]) -> tuple[float, ...]:
        # On the switch, where the forces balance to rounding, the acceleration is that of the
        # damper: with a sign by chance the motion would seem to cross at once, again and again.
        x, vx, _, vy = self._state
        if pull(0.5 * self._p.k3, self._p.F, x) != 0.0:
            return y
        given = self._constants[self._mode]
        half = 0.5 * given.yvy * vy
        sixth = (given.yx * vx + given.yy * vy + 2.0 * given.yvy * half) / 6.0
        return (*y[:2], half, sixth, *y[4:])

    def _step_size(self, x: tuple[float, ...], y: tuple[float, ...]) -> float:
        # The last two terms of the velocities stay below the tolerance relative to the speed, or
        # to the speed with which the displacement or the static deflection would be passed.
        displacement = max(abs(x[0]), abs(y[0]), self._deflection)
        speed = max(abs(x[1]), abs(y[1]), displacement / self._time_scale)
        allowed = self._tol * speed
        longest = LONGEST_STEP * self._time_scale
        exponent = math.inf
        for n in (self._degree, self._degree - 1):
            last = n * max(abs(x[n]), abs(y[n]))
            if not math.isfinite(last):
                raise overflow_error(self._time, self._state)
            if last > 0.0 and allowed > 0.0:
                exponent = min(exponent, (rough_log2(allowed) - rough_log2(last)) / (n - 1))
        return longest if exponent == math.inf else min(longest, rough_exp2(exponent))

    def _first_root(self, y: tuple[float, ...], final: float) -> float | None:
        # |y − chord| <= max|d²y/dθ²|/8, which rejects most steps at the cost of one sum. After a
        # switch y starts from zero and the same bound holds for y/θ.
        bulge = sum(map(mul, map(abs, y), self._weights))
        contact = self._mode is Mode.CONTACT
        first = y[0] if y[0] != 0.0 else y[1]
        nearest = max(first, final) if contact else -min(first, final)
        if nearest + bulge < 0.0:
            return None
        root = first_root(y)
        if root is None and (final >= 0.0 if contact else final <= 0.0):
            # The root rounded out of the step: it is at its end.
            return 1.0
        return root

    def _add_to_time(self, duration: float) -> None:
        # Two-sum, so that the rounding of t does not grow with the number of steps.
        increment = duration + self._remainder
        total = self._time + increment
        self._remainder = (self._time - (total - (total - self._time))) + (
            increment - (total - self._time)
        )
        self._time = total

    def _check_progress(self, start: float, *, short: bool) -> None:
        self._stalled = self._stalled + 1 if short or self._time == start else 0
        if self._stalled > MAX_STALLED:
            raise stall_error(start)
