"""One transient by any method, native or FMU: the entry point of command line, TUI and scripts."""

import time
from collections.abc import Mapping, Sequence
from typing import Final

from fivtui.model import OnProgress, System, time_tables

from .model import Parameters, Rows, check_known
from .transient import (
    ALL_METHODS,
    DEFAULT_T_END,
    DEFAULT_TOL,
    FMU_FLAVOURS,
    MAX_STEPS,
    KernelChoice,
    OnSamples,
    Request,
    Samples,
    Start,
    Transient,
    check_taylor_options,
    integrate,
)

_BASE_SET: Final = Parameters()


def simulate(
    parameters: Parameters | None = None,
    *,
    t_end: float = DEFAULT_T_END,
    tol: float = DEFAULT_TOL,
    separation: bool = True,
    start: Start = "static",
    method: str = "taylor",
    step: float | None = None,
    samples: Samples = "none",
    max_steps: int = MAX_STEPS,
    progress: OnProgress | None = None,
    kernel: KernelChoice = "auto",
    on_samples: OnSamples | None = None,
    sensitivities: Sequence[str] = (),
    over_time: Mapping[str, Rows] | None = None,
) -> Transient:
    """Compute a transient.

    Parameters
    ----------
    parameters : Parameters, optional
        The parameter set; the base set if not given.
    t_end : float
        Horizon, s; at most 1e7.
    tol : float
        Relative tolerance of the variable-step methods, 1e-13 to 1e-2. The manual's page
        "What a tolerance promises" says what errors it ensures for the methods ``taylor``, ``fmu``
        and ``fmu-native``.
    separation : bool
        Whether the slider may leave the belt (Case 1), or contact never breaks (Case 2).
    start : "static" or sequence of four floats
        At rest at the equilibrium of μ = 0, or (x, ẋ, y, ẏ) in m and m/s: horizontal
        displacement and velocity, then vertical.
    method : str
        A name in `ALL_METHODS`. ``fmu`` runs the exported FMU of Python code,
        ``fmu-native`` the compiled one.
    step : float, optional
        Step of ``rk4``, communication step of ``fmu`` and ``fmu-native``, s.
    samples : "none", "dense", int or sequence of float
        How the trajectory is stored: not at all; as a function of time, ``solution`` of the result;
        at this number of evenly spaced times from 0 to `t_end`, both included; or at these
        ascending times, s.
    max_steps : int
        Steps after which the run is given up.
    progress : callable, optional
        Called at intervals with the fraction done; the run is cancelled when it returns False.
    kernel : "auto", "compiled", "interpreted" or "exact"
        Implementation of the method ``taylor``. By default a linear system (k_nl = 0, separation
        ignored) is solved exactly, without steps; any other system by the compiled kernel, or by
        the interpreted kernel if none is compiled. ``stats.kernel`` names the kernel used. Results
        of different kernels agree to rounding.
    on_samples : callable, optional
        Called at intervals in the computing thread with the next part of the trajectory, if sample
        times are given and the method takes steps.
    sensitivities : sequence of str
        Names of the parameters by which results are differentiated, with the method ``taylor``.
        A static start depends on the parameters and is differentiated too; a start in numbers is
        constant.
    over_time : mapping of str to pairs of time and value, optional
        Values over time, s, in place of those of `parameters`, constant before and after the rows.
        ``F``, ``mu`` and ``v_belt`` are linear between rows, with a jump where a time is given
        twice; stiffnesses, ``c1`` and ``c2`` are held until the next row. With the methods
        ``taylor`` and ``fmu-native``, and ``fmu`` for those that are held.

    Returns
    -------
    Transient
        Final state, extremes (not sampled), events, work done, and the trajectory if requested.

    Raises
    ------
    InputError
        If the request is wrong.
    ComputationError
        If the run cannot be finished.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import Parameters, simulate
    >>> run = simulate(Parameters(F=80.0), t_end=20.0, samples=101)
    >>> run.events.separations
    14
    >>> run.trajectory.t[:3]
    array([0. , 0.2, 0.4])
    >>> motion = simulate(t_end=20.0, samples="dense").solution
    >>> bool(abs(motion([0.2, 0.4]).y - run.trajectory.y[1:3]).max() < 1e-9)
    True

    By how much the peak grows with friction and preload, m and m/N:

    >>> rates = simulate(t_end=20.0, sensitivities=["mu", "F"]).sensitivities
    >>> print(f"{rates['mu'].peak.y_abs:.4f} {rates['F'].peak.y_abs:.6f}")
    10.6029 0.347463
    """
    tables = time_tables(over_time) if over_time else {}
    request = Request(
        System(_BASE_SET if parameters is None else parameters, separation, tables),
        t_end,
        tol,
        start,
        method,
        step,
        samples,
        max_steps,
        kernel,
        sensitivities,
    )
    return compute(request, progress=progress, on_samples=on_samples)


def compute(
    request: Request, *, progress: OnProgress | None = None, on_samples: OnSamples | None = None
) -> Transient:
    """Compute the transient of a request; see `simulate`."""
    check_known("method", request.method, ALL_METHODS)
    begin = time.thread_time()
    result: Transient
    if request.method in FMU_FLAVOURS:
        from .fmu import integrate_fmu

        check_taylor_options(request)
        result = integrate_fmu(request, progress=progress, on_samples=on_samples)
    else:
        result = integrate(request, progress=progress, on_samples=on_samples)
    result.stats.cpu_s = time.thread_time() - begin
    return result
