"""What runs the method ``taylor``: the exact solution, compiled code or interpreted code."""

from typing import Final

from fivtui.kernel import loader
from fivtui.model import InputError, unknown_name

from . import compiled
from .linear import run as linear
from .loop import KernelChoice, Progress, run_segments
from .methods import METHODS, Problem
from .recorder import OnSamples, Recorder, Samples
from .result import Transient

KERNELS: Final = ("auto", "compiled", "interpreted", "exact")
# Less than this of a run done is soonest done by starting over in compiled code.
_EARLY: Final = 0.5


def run(
    problem: Problem,
    samples: Samples,
    max_steps: int,
    progress: Progress | None,
    kernel: KernelChoice,
    *,
    on_samples: OnSamples | None = None,
) -> Transient:
    """Compute a transient by the method ``taylor``.

    Parameters
    ----------
    problem : Problem
        What is asked.
    samples : "none", "dense" or sequence of float
        What is kept of the trajectory: nothing, everything, or its values at ascending times, s.
    max_steps : int
        Steps after which the run is given up.
    progress : callable, optional
        Called now and then with the fraction done; the run is cancelled when it returns False.
    kernel : "auto", "compiled", "interpreted" or "exact"
        By default the exact solution of a linear scene; else the compiled kernel once that is
        loaded, which this starts in the background. Until then the interpreted kernel runs, and
        hands over if the compiled one is ready early in the run. To ask for the compiled one is
        to wait for it.
    on_samples : callable, optional
        See `integrate`; a run that the compiled kernel takes over begins anew.

    Returns
    -------
    Transient
        The same to rounding whatever ran.

    Raises
    ------
    InputError
        If there is no such kernel, or the exact solution is asked for a scene that is not linear.
    ComputationError
        If the run cannot be finished.
    Cancelled
        If `progress` returned False.
    """
    if kernel not in KERNELS:
        raise unknown_name("kernel", kernel, KERNELS)
    solvable = linear.is_linear(problem)
    if kernel == "exact" and not solvable:
        raise InputError(
            "kernel = 'exact': the scene must be linear (k_nl = 0, separation ignored)"
        )
    if solvable and kernel in ("auto", "exact"):
        return linear.run(problem, samples, max_steps, progress)
    if kernel == "interpreted":
        return _interpreted(problem, samples, max_steps, progress, on_samples)
    if kernel == "auto" and not loader.single.ready:
        loader.single.start()
        try:
            watch = _Overtaken.by_compiled(progress)
            return _interpreted(problem, samples, max_steps, watch, on_samples)
        except _Overtaken as overtaken:
            progress = overtaken.progress
    return compiled.run(problem, samples, max_steps, progress, on_samples)


def _interpreted(
    problem: Problem,
    samples: Samples,
    max_steps: int,
    progress: Progress | None,
    on_samples: OnSamples | None,
) -> Transient:
    recorder = Recorder(problem, samples, on_samples)
    run_segments(METHODS["taylor"].stepper(problem), recorder, max_steps, progress)
    return recorder.result("taylor", "interpreted")


class _Overtaken(Exception):
    # The compiled kernel is ready; `progress` never falls behind what was reported before.

    def __init__(self, progress: Progress | None) -> None:
        super().__init__()
        self.progress = progress

    @classmethod
    def by_compiled(cls, progress: Progress | None) -> Progress:
        def watch(fraction: float) -> bool:
            if loader.single.ready and fraction < _EARLY:
                raise cls(progress and (lambda part: progress(max(part, fraction))))
            return progress is None or progress(fraction)

        return watch
