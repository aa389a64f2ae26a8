"""How many digits of the state at the end of a run hold, by how the motion magnifies errors."""

import math
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fivtui.kernel import why_interpreted
from fivtui.model import ComputationError, State, System, time_scale
from fivtui.transient.linear.rounding import rounding_error
from fivtui.transient.request import Request
from fivtui.transient.result import Transient

from .variation import START_SEEDS, vary

FloatArray = NDArray[np.float64]

# Digits of a state that are printed, if they hold.
MOST_DIGITS: Final = 13
# Parts of a run over which deviations are followed; limits in steps and in multiples of
# √(m/stiffness) or m/c. The second limit serves a slider at rest, whose steps are long. They cost
# about twenty milliseconds.
_PARTS: Final = 8
_MOST_STEPS, _MOST_TIMES = 20_000, 12_000.0
# Error per square root of the number of steps by rounding, and per tolerance.
_ROUNDING: Final = 2.0**-51
_OF_TOL: Final = 1e-1
# Growth over half of the time above which deviations grow exponentially.
_EXPONENTIAL: Final = 8.0


class FinalDigits(NamedTuple):
    """How many digits hold of the state at the end; 0 where errors have grown to its size."""

    x: int
    vx: int
    y: int
    vy: int


def final_digits(run: Transient) -> FinalDigits | None:
    """How many digits of x, ẋ, y, ẏ at the end of a transient hold, by estimate.

    A run makes errors by rounding and by its tolerance, and these grow until its end as deviations
    from the motion do. In a run that is too long to be followed, they are taken to have grown as
    deviations do behind its end. The exact solution of a linear scene has errors of rounding alone.
    """
    _, *state = run.final
    if run.stats.kernel == "exact":
        rounding = rounding_error(run).final * max(map(abs, state))
        return FinalDigits(*(_digits(value, rounding) for value in state))
    if (
        run.parameters.v_belt is not None
        or run.stats.kernel != "compiled"
        or run.stats.steps == 0
        or why_interpreted() is not None
    ):
        return None
    scales = _scales(run)
    if not scales.any():
        return FinalDigits(*[MOST_DIGITS] * 4)
    p = run.parameters
    fastest = max(1.0 / time_scale(p), p.c1 / p.m, p.c2 / p.m)
    share = min(_MOST_STEPS / run.stats.steps, _MOST_TIMES / (fastest * run.t_end), 1.0)
    x, vx, y, vy = run.start if share == 1.0 else state
    span = run.t_end * share / _PARTS
    try:
        flows = _flows(System(p, run.separation), (x, vx, y, vy), span, run.tol)
    except ComputationError:
        return None
    relative_errors = _ROUNDING * math.sqrt(run.stats.steps) + _OF_TOL * run.tol
    errors = relative_errors * _magnify_errors(flows, scales, share)
    return FinalDigits(*map(_digits, state, errors.tolist()))


def _digits(value: float, error: float) -> int:
    if error == 0.0:
        return MOST_DIGITS
    return min(math.floor(math.log10(abs(value) / error)), MOST_DIGITS) if error < abs(value) else 0


def _scales(run: Transient) -> FloatArray:
    # Scales of relative errors of x, ẋ, y, ẏ.
    frequency, final = 1.0 / time_scale(run.parameters), run.final
    x, y = run.peak.x_abs, run.peak.y_abs
    return np.array([x, max(x * frequency, abs(final.vx)), y, max(y * frequency, abs(final.vy))])


def _magnify_errors(flows: tuple[FloatArray, ...], scales: FloatArray, share: float) -> FloatArray:
    # Errors at the end, if errors of size `scales` occur at the worst time. `flows` cover a share
    # of the run.
    total, grown = np.eye(4), [scales]
    with np.errstate(over="ignore", invalid="ignore"):
        for flow in reversed(flows):
            total = total @ flow
            grown.append(np.abs(total) @ scales)
    greatest: FloatArray = np.max(grown, axis=0)
    if share == 1.0:
        return greatest
    recent = np.max(grown[: len(grown) // 2 + 1], axis=0)
    return np.where(greatest <= _EXPONENTIAL * recent, greatest / share, math.inf)


@lru_cache(maxsize=64)
def _flows(system: System, start: State, span: float, tol: float) -> tuple[FloatArray, ...]:
    # Derivatives of each part's end by its start.
    flows = []
    for _ in range(_PARTS):
        request = Request(system, t_end=span, tol=tol, start=start)
        variation = vary(request, START_SEEDS)
        flows.append(variation.derivatives)
        start = variation.final
    return tuple(flows)
