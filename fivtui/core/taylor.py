"""Variable-step Taylor integrator in plain floats: the default method, and what the FMU runs.

Every step expands the motion about its start (`recurrences`), takes the step size from the last
two coefficients, and ends at the first root of y if there is one. Nothing depends on where output
is wanted: the polynomial of a step is its dense output.
"""

import math
from itertools import accumulate, repeat
from operator import mul
from typing import Final, NamedTuple

from .errors import ComputationError, InputError
from .model import Mode, State, mode_of
from .parameters import Parameters
from .polynomial import first_root
from .recurrences import Field, coefficient_function, constants, state_function
from .segment import Segment

# Relative error to aim at in the end state, and what may be asked for.
DEFAULT_TOL: Final = 1e-12
TOL_RANGE: Final = (1e-13, 1e-2)
# Local errors add up and grow along the run; this much smaller, `tol` is the error at its end.
_LOCAL_TOLERANCE: Final = 1e-3

MIN_TOLERANCE: Final = 1e-16
MAX_TOLERANCE: Final = 1e-2
MIN_ORDER: Final = 8
MAX_ORDER: Final = 20
# A step never exceeds this many times √(m/stiffness), at rest least of all.
_LONGEST_STEP: Final = 1e3
# More switches than this without time advancing is chatter below the spacing of floats.
_MAX_STALLED: Final = 64


class Instant(NamedTuple):
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
        Steps taken without time advancing.
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
    return min(max(4 * math.ceil(-0.125 * math.log(tol)), MIN_ORDER), MAX_ORDER)


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
                f"local tolerance = {tol}: allowed is {MIN_TOLERANCE:g} to {MAX_TOLERANCE:g}"
            )
        if not all(map(math.isfinite, state)):
            raise InputError(f"start = {state}: four finite numbers are needed")
        self._p = p
        self._separation = separation
        self._tol = tol
        self._constants = constants(p)
        contact = Field.CUBIC_CONTACT if p.k_nl > 0.0 else Field.LINEAR_CONTACT
        self._degree = (order_for(tol) if order is None else order) + 1
        self._expand = {
            Mode.CONTACT: coefficient_function(contact, self._degree - 1),
            Mode.SEPARATED: coefficient_function(Field.SEPARATED, self._degree - 1),
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
    def instant(self) -> Instant:
        """Where the integrator stands: at the end of the last segment."""
        return Instant(self._time, self._remainder, self._state, self._mode, self._stalled)

    def resume(self, instant: Instant) -> None:
        """Go back, or on, to where an integrator of the same problem stood.

        Parameters
        ----------
        instant : Instant
            The segments that follow are those that followed then, to the last bit.
        """
        self._time, self._remainder, self._state, self._mode, self._stalled = instant

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
        x, y = self._expand[mode](*self._state, *self._constants)
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
            raise self._overflow()
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
        self._check_progress(start)
        switches = self._mode is not mode
        return Segment(mode, start, remainder, duration, self._time, x, y, state, switches)

    def _step_size(self, x: tuple[float, ...], y: tuple[float, ...]) -> float:
        # The last two terms of the velocities stay below the tolerance relative to the speed, or
        # to the speed with which the displacement or the static deflection would be passed.
        displacement = max(abs(x[0]), abs(y[0]), self._deflection)
        speed = max(abs(x[1]), abs(y[1]), displacement / self._time_scale)
        allowed = self._tol * speed
        duration = _LONGEST_STEP * self._time_scale
        for n in (self._degree, self._degree - 1):
            last = n * max(abs(x[n]), abs(y[n]))
            if not math.isfinite(last):
                raise self._overflow()
            if last > 0.0 and allowed > 0.0:
                duration = min(duration, math.exp(math.log(allowed / last) / (n - 1)))
        return duration

    def _first_root(self, y: tuple[float, ...], final: float) -> float | None:
        # |y − chord| <= max|d²y/dθ²|/8, which rejects most steps at the cost of one sum.
        bulge = sum(map(mul, map(abs, y), self._weights))
        contact = self._mode is Mode.CONTACT
        nearest = max(y[0], final) if contact else -min(y[0], final)
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

    def _check_progress(self, start: float) -> None:
        self._stalled = self._stalled + 1 if self._time == start else 0
        if self._stalled > _MAX_STALLED:
            raise ComputationError(
                f"at t = {start:.17g} s the motion changes faster than the spacing of time",
                "use a less stiff contact, more damping or a later start",
            )

    def _overflow(self) -> ComputationError:
        x, _, y, _ = self._state
        return ComputationError(
            f"the motion grows out of the range of numbers at t = {self._time:.6g} s "
            f"(x = {x:.3g} m, y = {y:.3g} m)",
            "it is unbounded: consider separation, use a cubic contact, or end before that time",
        )
