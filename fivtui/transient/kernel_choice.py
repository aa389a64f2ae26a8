"""What runs the method ``taylor``: the exact solution, compiled code or interpreted code."""

from typing import Final

from fivtui.kernel import loader
from fivtui.model import InputError, unknown_name

from . import compiled
from .linear import run as linear
from .methods import METHODS
from .recorder import Recorder
from .request import OnSamples, Progress, Request
from .result import Transient

KERNELS: Final = ("auto", "compiled", "interpreted", "exact")
# Below this progress, restarting compiled is faster than finishing interpreted.
_EARLY: Final = 0.5


def run(request: Request, progress: Progress | None, on_samples: OnSamples | None) -> Transient:
    """Compute a transient by the method ``taylor``; the same to rounding whatever runs it.

    Until the compiled kernel is loaded, which this starts in the background, the interpreted one
    runs, and hands over if the compiled one is ready early in the run, which then begins anew.
    """
    kernel = request.kernel
    if kernel not in KERNELS:
        raise unknown_name("kernel", kernel, KERNELS)
    solvable = linear.is_linear(request)
    if kernel == "exact" and not solvable:
        raise InputError(
            "kernel = 'exact': the scene must be linear (k_nl = 0, separation ignored)"
        )
    if solvable and kernel in ("auto", "exact"):
        return linear.run(request, progress)
    if kernel == "interpreted":
        return _interpreted(request, progress, on_samples)
    if kernel == "auto" and not loader.single.ready:
        loader.single.start()
        try:
            watch = _Overtaken.by_compiled(progress)
            return _interpreted(request, watch, on_samples)
        except _Overtaken as overtaken:
            progress = overtaken.progress
    return compiled.run(request, progress, on_samples)


def _interpreted(
    request: Request, progress: Progress | None, on_samples: OnSamples | None
) -> Transient:
    recorder = Recorder(request, on_samples)
    recorder.follow(METHODS["taylor"].stepper(request), progress)
    return recorder.result("interpreted")


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
