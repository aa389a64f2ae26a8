"""Transients: the mode-by-mode event loop over any integrator."""

from collections.abc import Callable
from typing import Final, Literal

from fivtui.model import Cancelled, ComputationError
from fivtui.taylor import Stepper

from .recorder import Recorder
from .result import Kernel
from .stiffness import Stiffness, stiffness_of

Progress = Callable[[float], bool]
KernelChoice = Literal["auto"] | Kernel

MAX_STEPS: Final = 20_000_000
_PROGRESS_EVERY: Final = 32


def run_segments(
    stepper: Stepper, recorder: Recorder, max_steps: int, progress: Progress | None
) -> None:
    """The event loop: segment after segment until the horizon.

    Parameters
    ----------
    stepper : Stepper
        The integrator.
    recorder : Recorder
        Takes in its segments.
    max_steps : int
        Steps after which the run is given up.
    progress : callable, optional
        See `integrate`.

    Raises
    ------
    ComputationError
        If the run cannot be finished.
    Cancelled
        If `progress` returned False.
    """
    t_end = recorder.t_end
    report = progress or _keep_going
    for count in range(max_steps):
        if count % _PROGRESS_EVERY == 0 and not report(min(recorder.t / t_end, 1.0)):
            raise Cancelled
        recorder.include(stepper.advance())
        if recorder.complete:
            report(1.0)
            return
    asked = recorder.problem
    raise step_limit_error(max_steps, recorder.t, t_end, stiffness_of(asked))


def step_limit_error(
    max_steps: int, t: float, t_end: float, stiff: Stiffness | None
) -> ComputationError:
    """An error for a run that takes too many steps.

    Parameters
    ----------
    max_steps : int
        Their greatest number.
    t, t_end : float
        Time reached and horizon, s.
    stiff : Stiffness or None
        Why the scene is stiff, if it is.

    Returns
    -------
    ComputationError
        To be raised by the caller.
    """
    why = f"{max_steps} steps end at t = {t:.6g} s of {t_end:g} s"
    if stiff is None:
        return ComputationError(why, "use a shorter horizon or a larger tol")
    return ComputationError(f"{why}; {stiff}", "use the method scipy-lsoda or scipy-radau")


def _keep_going(_fraction: float) -> bool:
    return True
