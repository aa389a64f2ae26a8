"""What runs the method ``taylor``: the exact solution, compiled code or interpreted code."""

from typing import Final

from fivtui.kernel import why_interpreted
from fivtui.model import InputError, unknown_name

from . import compiled
from .linear import run as linear
from .methods import METHODS
from .recorder import Recorder
from .request import OnSamples, Progress, Request
from .result import Transient

KERNELS: Final = ("auto", "compiled", "interpreted", "exact")


def run(request: Request, progress: Progress | None, on_samples: OnSamples | None) -> Transient:
    """Compute a transient by the method ``taylor``; the same to rounding whatever runs it."""
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
    if kernel == "interpreted" or (kernel == "auto" and why_interpreted() is not None):
        return _interpreted(request, progress, on_samples)
    return compiled.run(request, progress, on_samples)


def _interpreted(
    request: Request, progress: Progress | None, on_samples: OnSamples | None
) -> Transient:
    recorder = Recorder(request, on_samples)
    recorder.follow(METHODS["taylor"].stepper(request), progress)
    return recorder.result("interpreted")
