"""Computation of transients by any native method, that is without an FMU.

The method ``taylor`` has three implementations (kernels) that agree to rounding: the exact solution
of linear scenes, the compiled kernel in C, and interpreted Python.
"""

import dataclasses
import math
from typing import Final, Literal, NamedTuple

from fivtui.kernel import why_interpreted
from fivtui.model import (
    LINEAR_OVER_TIME,
    ComputationError,
    InputError,
    OnProgress,
    Progress,
    check_known,
    horizontal_stiffness,
)

from . import compiled
from .linear import run as linear
from .methods import METHODS, check_uses_step, fixed_step
from .recorder import Recorder
from .request import OnSamples, Request
from .result import Transient

_KERNELS: Final = ("auto", "compiled", "interpreted", "exact")
# Number of periods by which a run is continued after its end.
_CONTINUED_PERIODS: Final = 20
# A run has settled if its amplitude changes by at most this fraction after its end.
_MAX_CHANGE: Final = 0.01
# A motion is at rest if its amplitude is below this fraction of the peak.
_REST_AMPLITUDE: Final = 1e-6
# Tolerance and largest number of steps of the continuation.
_CONTINUATION_TOL: Final = 1e-9
_CONTINUATION_MAX_STEPS: Final = 20_000


def integrate(
    request: Request, *, progress: OnProgress | None = None, on_samples: OnSamples | None = None
) -> Transient:
    """Compute a transient with a native method.

    `on_samples` receives consecutive parts of the trajectory during the run.
    """
    check_known("method", request.method, METHODS)
    if request.step is not None:
        check_uses_step(request.method)
    work = Progress(progress)
    if request.method != "taylor":
        check_taylor_options(request)
        if METHODS[request.method].fixed_step:
            _check_step_count(request)
        return _run_stepper(request, work, on_samples)
    if request.kernel != "auto" or request.course is not None:
        _check_kernel(request)
    if not request.sensitivities:
        return _run_taylor(request, work, on_samples)
    from .derivatives.sensitivity import compute_sensitivities

    transient = _run_taylor(request, work.stage(0.0, 0.5), on_samples)
    sensitivities = compute_sensitivities(request, transient, work.stage(0.5, 1.0))
    return dataclasses.replace(transient, sensitivities=sensitivities)


def _check_kernel(request: Request) -> None:
    # Raise `InputError` if the method ``taylor`` does not support the kernel of the request.
    kernel = request.kernel
    check_known("kernel", kernel, _KERNELS)
    if request.course is not None:
        names = ", ".join(request.course.tables)
        if kernel == "exact":
            raise InputError(f"{names} over time: the kernel must not be exact")
        if request.sensitivities:
            raise InputError(
                f"{names} over time: has no sensitivities; sweep the parameter instead"
            )
    if kernel == "exact" and not linear.is_linear(request):
        raise InputError(
            "kernel = 'exact': the scene must be linear (k_nl = 0, separation ignored)"
        )


def _run_stepper(
    request: Request,
    work: Progress,
    on_samples: OnSamples | None,
    kernel: Literal["interpreted"] | None = None,
) -> Transient:
    # Run an integrator that is written in Python.
    recorder = Recorder(request, on_samples)
    recorder.follow(METHODS[request.method].stepper(request), work)
    return recorder.result(kernel)


def _run_taylor(request: Request, work: Progress, on_samples: OnSamples | None) -> Transient:
    # Choose between the exact solution, compiled and interpreted code, which agree to rounding.
    kernel = request.kernel
    if kernel in ("auto", "exact") and linear.is_linear(request):
        return linear.run(request, work)
    if kernel == "interpreted" or (kernel == "auto" and why_interpreted() is not None):
        return _run_stepper(request, work, on_samples, "interpreted")
    return compiled.run(request, work, on_samples)


def _check_step_count(request: Request) -> None:
    step = fixed_step(request)
    if request.t_end / step > request.max_steps:
        raise ComputationError(
            f"{request.t_end / step:.3g} steps of {step:.3g} s are needed, more than "
            f"{request.max_steps}",
            "use a shorter horizon, a larger step or the taylor method",
        )


def check_taylor_options(request: Request) -> None:
    """Raise `InputError` if options of ``taylor`` are set for a different method, native or FMU."""
    # The course has parameters over time. The Python FMU can follow those that are held.
    tables = () if request.course is None else request.course.tables
    needs_slopes = not {*LINEAR_OVER_TIME}.isdisjoint(tables)
    if tables and request.method != "fmu-native" and (request.method != "fmu" or needs_slopes):
        allowed = "taylor or fmu-native" if needs_slopes else "taylor, fmu or fmu-native"
        raise InputError(
            f"{', '.join(tables)} over time: the method must be {allowed}, not {request.method}"
        )
    if request.sensitivities:
        raise InputError(f"sensitivities: the method must be taylor, not {request.method}")
    if request.kernel != "auto":
        raise InputError(
            f"kernel = {request.kernel!r}: the method {request.method} has no choice of kernels"
        )


class LaterAmplitude(NamedTuple):
    """Half peak-to-peak of y, m, reached when a run is continued by a time `after`, s."""

    y_half_range: float
    after: float


def later_amplitude(result: Transient) -> LaterAmplitude | None:
    """The amplitude after the end of a run that has not settled; None for a settled run.

    The motion is continued for at most 20 periods and at most the length of the run. The second
    half of this time gives the amplitude. None also if parameters change over time, or if the
    continuation fails.
    """
    if result.over_time:
        return None
    p, final, amplitude = result.parameters, result.final, result.steady.y_half_range
    period = 2.0 * math.pi * math.sqrt(p.m / horizontal_stiffness(p))
    t_end = min(_CONTINUED_PERIODS * period, result.t_end)
    try:
        continuation = integrate(
            Request(
                result.system,
                t_end=t_end,
                tol=_CONTINUATION_TOL,
                start=(final.x, final.vx, final.y, final.vy),
                max_steps=_CONTINUATION_MAX_STEPS,
            )
        )
    except (ComputationError, InputError):
        return None
    continued_amplitude = continuation.steady.y_half_range
    greater = max(amplitude, continued_amplitude)
    is_at_rest = greater < _REST_AMPLITUDE * result.peak.y_abs
    if is_at_rest or abs(continued_amplitude - amplitude) <= _MAX_CHANGE * greater:
        return None
    return LaterAmplitude(continued_amplitude, t_end)
