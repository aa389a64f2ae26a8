"""What runs the method ``taylor``: compiled code or interpreted code."""

from collections.abc import Callable
from typing import Final

from . import compiled
from .methods import Problem
from .outcome import Transient
from .parameters import unknown_name
from .recorder import OnSamples, Samples
from .transient import KernelChoice, Progress

WholeRun = Callable[[Problem, Samples, int, Progress | None, OnSamples | None], Transient]

KERNELS: Final = ("auto", "compiled", "interpreted")


def chosen(kernel: KernelChoice) -> WholeRun | None:
    """What is to run a problem.

    Parameters
    ----------
    kernel : "auto", "compiled" or "interpreted"
        By default the compiled kernel once that is loaded, which this starts in the background;
        until then the interpreted one. To ask for the compiled one is to wait for it.

    Returns
    -------
    callable or None
        Runs the problem; None for the interpreted kernel.

    Raises
    ------
    InputError
        If there is no such kernel.
    """
    if kernel not in KERNELS:
        raise unknown_name("kernel", kernel, KERNELS)
    if kernel == "auto" and not compiled.kernels.ready:
        compiled.kernels.start()
        return None
    return None if kernel == "interpreted" else compiled.run
