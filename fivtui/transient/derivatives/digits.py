"""Estimate of the correct digits of the final state, from the growth of errors in the motion.

A run is divided into parts. Over each part the derivatives of the state by x, ẋ, y and ẏ at the
start are computed; these four directions of change are `START_SEEDS`.
"""

import math
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fivtui.kernel import why_interpreted
from fivtui.model import ComputationError, State, System, time_scale
from fivtui.transient.errors import rounding_error
from fivtui.transient.request import Request
from fivtui.transient.result import Transient

from .variation import START_SEEDS, compute_variation

FloatArray = NDArray[np.float64]

# Largest number of digits that is printed.
MAX_DIGITS: Final = 13
# Number of parts of a run for which derivatives are computed.
_PARTS: Final = 8
# Limits of all parts together, with which the estimate takes about 20 ms: number of steps, and time
# in units of the shortest of √(m/(k1 + k2 + k3)), m/c1 and m/c2. The number of steps alone does not
# limit the time: the steps of a slider at rest are long.
_MAX_STEPS: Final = 20_000
_MAX_TIME_UNITS: Final = 12_000.0
# Relative error by rounding per square root of the number of steps, and error per tolerance.
_ROUNDING_ERROR: Final = 2.0**-51
_TOL_FRACTION: Final = 1e-1
# Growth factor over half of the computed time that indicates exponential growth.
_EXPONENTIAL_GROWTH: Final = 8.0


class FinalDigits(NamedTuple):
    """Numbers of correct digits of the final state; 0 if the error is as large as the value."""

    x: int
    vx: int
    y: int
    vy: int


def final_digits(run: Transient) -> FinalDigits | None:
    """Estimated numbers of correct digits of the final state; None without the compiled kernel.

    Rounding and the tolerance cause errors at every step, which grow like deviations from the
    motion. For a long run, their growth is estimated from a continuation after its end. The exact
    solution of a linear scene has rounding errors alone.
    """
    _, *state = run.final
    if run.stats.kernel == "exact":
        rounding = rounding_error(run).final * max(map(abs, state))
        return FinalDigits(*(_count_digits(value, rounding) for value in state))
    if (
        run.parameters.v_belt is not None
        or run.stats.kernel != "compiled"
        or run.stats.steps == 0
        or why_interpreted() is not None
    ):
        return None
    scales = _error_scales(run)
    if not scales.any():
        return FinalDigits(*[MAX_DIGITS] * 4)
    p = run.parameters
    fastest_rate = max(1.0 / time_scale(p), p.c1 / p.m, p.c2 / p.m)
    fraction = min(_MAX_STEPS / run.stats.steps, _MAX_TIME_UNITS / (fastest_rate * run.t_end), 1.0)
    x, vx, y, vy = run.start if fraction == 1.0 else state
    part_duration = run.t_end * fraction / _PARTS
    try:
        jacobians = _jacobians(System(p, run.separation), (x, vx, y, vy), part_duration, run.tol)
    except ComputationError:
        return None
    relative_error = _ROUNDING_ERROR * math.sqrt(run.stats.steps) + _TOL_FRACTION * run.tol
    errors = relative_error * _final_errors(jacobians, scales, fraction)
    return FinalDigits(*map(_count_digits, state, errors.tolist()))


def _count_digits(value: float, error: float) -> int:
    # Number of correct digits of a value with an error.
    if error == 0.0:
        return MAX_DIGITS
    return min(math.floor(math.log10(abs(value) / error)), MAX_DIGITS) if error < abs(value) else 0


def _error_scales(run: Transient) -> FloatArray:
    # Sizes of x, ẋ, y, ẏ, to which their errors are relative.
    frequency, final = 1.0 / time_scale(run.parameters), run.final
    x, y = run.peak.x_abs, run.peak.y_abs
    return np.array([x, max(x * frequency, abs(final.vx)), y, max(y * frequency, abs(final.vy))])


def _final_errors(
    jacobians: tuple[FloatArray, ...], scales: FloatArray, fraction: float
) -> FloatArray:
    # Errors at the end if errors of size `scales` occur at the worst time. An error at the start of
    # a part is multiplied by the derivatives of this part and of all later ones. The parts cover a
    # fraction of the run; errors that grow linearly are extrapolated to all of it, errors that grow
    # exponentially are infinite.
    product, final_errors = np.eye(4), [scales]
    with np.errstate(over="ignore", invalid="ignore"):
        for jacobian in reversed(jacobians):
            product = product @ jacobian
            final_errors.append(np.abs(product) @ scales)
    max_errors: FloatArray = np.max(final_errors, axis=0)
    if fraction == 1.0:
        return max_errors
    # The list goes back from the end: its first half is due to errors in the second half.
    late_errors = np.max(final_errors[: len(final_errors) // 2 + 1], axis=0)
    return np.where(
        max_errors <= _EXPONENTIAL_GROWTH * late_errors, max_errors / fraction, math.inf
    )


@lru_cache(maxsize=64)
def _jacobians(
    system: System, start: State, part_duration: float, tol: float
) -> tuple[FloatArray, ...]:
    # Derivatives of the state at the end of each part by the state at its start.
    jacobians = []
    for _ in range(_PARTS):
        request = Request(system, t_end=part_duration, tol=tol, start=start)
        variation = compute_variation(request, START_SEEDS)
        jacobians.append(variation.derivatives)
        start = variation.final
    return tuple(jacobians)
