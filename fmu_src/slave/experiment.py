"""The experiment of FMI that a host sets up: start time, stop time, tolerance; checks of steps."""

import math
from collections.abc import Callable
from typing import Final, NamedTuple, Self

from fivtui.model.errors import InputError
from fivtui.model.numbers import Interval, parse_number
from fivtui.taylor.stepper import DEFAULT_TOL, TOL_RANGE

# Hosts add up their times with rounding errors: times count as equal if they differ by at most an
# absolute tolerance, s, or a relative one.
TIME_TOLERANCE: Final = 1e-9
_RELATIVE_TIME_TOLERANCE: Final = 2.0**-50


class Experiment(NamedTuple):
    """Start and stop time (infinite if not defined), s, and tolerance of a run."""

    start_time: float = 0.0
    stop_time: float = math.inf
    tol: float = DEFAULT_TOL

    @classmethod
    def from_host(
        cls,
        start_time: float,
        stop_time: float | None,
        tol: float | None,
        warn: Callable[[str], None],
    ) -> Self:
        """Check the times, s, and the tolerance that a host sets.

        If `tol` is None, the tolerance is `DEFAULT_TOL`. If it is out of range, the nearest valid
        one is used, and `warn` is called with a message. Raises `InputError` if a value is not a
        number or a time is out of range.
        """
        start = parse_number("start time", start_time, "a finite number of seconds")
        stop = (
            math.inf
            if stop_time is None
            else Interval(start, unit="s").check("stop time", stop_time)
        )
        tolerance = DEFAULT_TOL if tol is None else tol
        lowest, highest = TOL_RANGE
        if math.isnan(tolerance):
            raise InputError(f"tolerance = nan: must be from {lowest:g} to {highest:g}")
        accepted = min(max(tolerance, lowest), highest)
        if accepted != tolerance:
            warn(
                f"tolerance = {tolerance:g}: must be from {lowest:g} to {highest:g}, "
                f"{accepted:g} is used"
            )
        return cls(start, stop, accepted)

    def end_of_step(self, t: float, current_time: float, step_size: float) -> float:
        """The next communication point, s, from the time reached and the host's time and step size.

        Raises `InputError` if the host's time differs from `t` by more than rounding, the step is
        not positive, or it passes the stop time.
        """
        if not _is_same_time(current_time, t):
            raise InputError(f"current time = {current_time!r} s: the FMU is at {t!r} s")
        end = current_time + step_size
        if not (0.0 < step_size < math.inf and end > t):
            raise InputError(
                f"step size = {step_size!r}: must be a positive number of seconds "
                "that changes the time"
            )
        if end > self.stop_time and not _is_same_time(end, self.stop_time):
            raise InputError(
                f"the step ends at {end!r} s, after the stop time {self.stop_time!r} s"
            )
        return end


def _is_same_time(time: float, reference: float) -> bool:
    return math.isclose(time, reference, rel_tol=_RELATIVE_TIME_TOLERANCE, abs_tol=TIME_TOLERANCE)
