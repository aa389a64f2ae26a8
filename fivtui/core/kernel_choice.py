"""What runs the method ``taylor``: the exact solution, compiled code or interpreted code."""

from collections.abc import Callable
from typing import Final

from . import compiled, linear
from .errors import InputError
from .methods import Problem
from .outcome import Transient
from .parameters import unknown_name
from .recorder import Samples
from .transient import KernelChoice, Progress

WholeRun = Callable[[Problem, Samples, int, Progress | None], Transient]

KERNELS: Final = ("auto", "compiled", "interpreted", "exact")


def chosen(kernel: KernelChoice, problem: Problem) -> WholeRun | None:
    """What is to run a problem.

    Parameters
    ----------
    kernel : "auto", "compiled", "interpreted" or "exact"
        By default the exact solution of a linear scene; else the compiled kernel once that is
        loaded, which this starts in the background, and until then the interpreted one. To ask for
        the compiled one is to wait for it.
    problem : Problem
        What is to be run.

    Returns
    -------
    callable or None
        Runs the problem; None for the interpreted kernel.

    Raises
    ------
    InputError
        If there is no such kernel, or the exact solution is asked for a scene that is not linear.
    """
    if kernel not in KERNELS:
        raise unknown_name("kernel", kernel, KERNELS)
    solvable = linear.is_linear(problem)
    if kernel == "exact" and not solvable:
        raise InputError(
            "kernel = 'exact': allowed for a linear scene (k_nl = 0, separation ignored)"
        )
    if solvable and kernel in ("auto", "exact"):
        return linear.run
    if kernel == "auto" and not compiled.kernels.ready:
        compiled.kernels.start()
        return None
    return None if kernel == "interpreted" else compiled.run
