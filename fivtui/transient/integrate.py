"""Transients by any native method: what everything above the methods calls."""

from fivtui.model import ComputationError, InputError, Parameters, unknown_name

from . import kernel_choice
from .loop import MAX_STEPS, KernelChoice, Progress, run_segments
from .methods import METHODS, Problem, check_takes_step, fixed_step
from .recorder import OnSamples, Recorder, Samples
from .request import DEFAULT_T_END, DEFAULT_TOL, Start, make_problem
from .result import Transient


def integrate(
    p: Parameters,
    *,
    t_end: float = DEFAULT_T_END,
    tol: float = DEFAULT_TOL,
    separation: bool = True,
    start: Start = "static",
    method: str = "taylor",
    step: float | None = None,
    samples: Samples = "none",
    max_steps: int = MAX_STEPS,
    progress: Progress | None = None,
    kernel: KernelChoice = "auto",
    on_samples: OnSamples | None = None,
) -> Transient:
    """Compute a transient with a native method.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    t_end : float
        Horizon, s.
    tol : float
        Relative tolerance of the variable-step methods, 1e-13 to 1e-2. For ``taylor`` it is the
        relative error to expect of the end state after about a hundred periods.
    separation : bool
        Whether separation is considered (the paper's Case 1) or ignored (Case 2).
    start : "static" or sequence of four floats
        At rest at the equilibrium of μ = 0, or (x, ẋ, y, ẏ) in m and m/s.
    method : str
        A name in `METHODS`.
    step : float, optional
        Step of a fixed-step method, s.
    samples : "none", "dense" or sequence of float
        What is kept of the trajectory: nothing, everything, or its values at ascending times, s.
    max_steps : int
        Steps after which the run is given up.
    progress : callable, optional
        Called now and then with the fraction done; the run is cancelled when it returns False.
    kernel : "auto", "compiled", "interpreted" or "exact"
        What runs the method ``taylor``, see `kernel_choice.run`.
    on_samples : callable, optional
        Called now and then with the next part of the trajectory, where sample times are given and
        steps are taken; in the computing thread.

    Returns
    -------
    Transient
        Final state, exact extremes, events, and the trajectory if asked for.

    Raises
    ------
    InputError
        If the request is wrong.
    ComputationError
        If the run cannot be finished.
    Cancelled
        If `progress` returned False.
    """
    if method not in METHODS:
        raise unknown_name("method", method, METHODS)
    problem = make_problem(p, t_end=t_end, tol=tol, separation=separation, start=start, step=step)
    if step is not None:
        check_takes_step(method)
    if method == "taylor":
        return kernel_choice.run(
            problem, samples, max_steps, progress, kernel, on_samples=on_samples
        )
    check_has_kernels(method, kernel)
    if METHODS[method].fixed_step:
        _check_count(problem, max_steps)
    recorder = Recorder(problem, samples, on_samples)
    run_segments(METHODS[method].stepper(problem), recorder, max_steps, progress)
    return recorder.result(method)


def _check_count(problem: Problem, max_steps: int) -> None:
    step = fixed_step(problem)
    if problem.t_end / step > max_steps:
        raise ComputationError(
            f"{problem.t_end / step:.3g} steps of {step:.3g} s are needed, more than {max_steps}",
            "use a shorter horizon, a larger step or the taylor method",
        )


def check_has_kernels(method: str, kernel: KernelChoice) -> None:
    """Check that no kernel is asked for where there is no choice.

    Parameters
    ----------
    method : str
        Name of a method other than ``taylor``.
    kernel : str
        What was asked for.

    Raises
    ------
    InputError
        If that is not ``"auto"``.
    """
    if kernel != "auto":
        raise InputError(f"kernel = {kernel!r}: the method {method} has no choice of kernels")
