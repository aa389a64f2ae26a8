"""The experiment that a host sets up, and the communication steps that it allows."""

import math
from collections.abc import Callable
from typing import Final, NamedTuple, Self

from fivtui.model.errors import InputError
from fivtui.model.numbers import Interval, parse_number
from fivtui.taylor.stepper import DEFAULT_TOL, TOL_RANGE

# Times of the host and of the slave agree to the host's rounding.
SAME_TIME: Final = 1e-9


class Experiment(NamedTuple):
    """Times and tolerance of a run.

    Attributes
    ----------
    start_time, stop_time : float
        First time, s, and last; infinite if no last time is defined.
    tol : float
        Relative error to aim at after about a hundred periods.
    """

    start_time: float = 0.0
    stop_time: float = math.inf
    tol: float = DEFAULT_TOL

    @classmethod
    def checked(
        cls,
        start_time: float,
        stop_time: float | None,
        tol: float | None,
        warn: Callable[[str], None],
    ) -> Self:
        """An experiment from what a host gives.

        Parameters
        ----------
        start_time : float
            Start time, s.
        stop_time : float or None
            Stop time, s.
        tol : float or None
            Relative tolerance; the default if None, the nearest possible if out of range.
        warn : callable
            Is given a line if another tolerance is taken.

        Returns
        -------
        Experiment
            The checked experiment.

        Raises
        ------
        InputError
            If a time or the tolerance is not a number, or a time is not finite or out of range.
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
        possible = min(max(tolerance, lowest), highest)
        if possible != tolerance:
            warn(
                f"tolerance = {tolerance:g}: must be from {lowest:g} to {highest:g}, "
                f"{possible:g} is used"
            )
        return cls(start, stop, possible)

    def end_of_step(self, t: float, current_time: float, step_size: float) -> float:
        """Where a communication step ends.

        Parameters
        ----------
        t : float
            Time reached, s.
        current_time : float
            Time at which the host believes to be, s; its rounding may differ.
        step_size : float
            Communication step, s.

        Returns
        -------
        float
            The next communication point, s.

        Raises
        ------
        InputError
            If the host is at another time, the step is not positive, or it passes the stop time.
        """
        if not _same(current_time, t):
            raise InputError(f"current time = {current_time!r} s: the FMU is at {t!r} s")
        end = current_time + step_size
        if not (0.0 < step_size < math.inf and end > t):
            raise InputError(
                f"step size = {step_size!r}: must be a positive number of seconds "
                "that changes the time"
            )
        if end > self.stop_time and not _same(end, self.stop_time):
            raise InputError(
                f"the step ends at {end!r} s, after the stop time {self.stop_time!r} s"
            )
        return end


def _same(one: float, other: float) -> bool:
    return math.isclose(one, other, rel_tol=SAME_TIME, abs_tol=SAME_TIME)
