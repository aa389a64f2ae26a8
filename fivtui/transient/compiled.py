"""Single runs by the compiled kernel."""

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.kernel import loader
from fivtui.model import Cancelled, Mode, Parameters, mode_of
from fivtui.taylor import (
    RightHandSide,
    constants,
    local_tolerance,
    order_for,
    overflow_error,
    right_hand_side,
    stall_error,
)

from .extremes import Extremes
from .request import OnSamples, Progress, Request
from .result import Stats, Transient, assemble
from .stiffness import step_limit_error, stiffness_of
from .trajectory import DenseSolution, Trajectory, trajectory_of

# Steps between two looks at the progress callback, and at the keyboard if there is none.
_REPORT: Final = 256
_PAUSE: Final = 65536
# Lengths of the buffers; a longer run empties them on its way.
_SWITCHES: Final = 256
_SEGMENTS: Final = 512
# Samples that are handed out together.
_PART: Final = 1024
# Time between two looks at the progress callback while the kernel is being loaded, s.
_WAIT_S: Final = 0.02
_NO_TIMES: Final = np.empty(0)
_NO_ROWS: Final = np.empty((0, 0))


def run(
    request: Request, progress: Progress | None, on_samples: OnSamples | None = None
) -> Transient:
    """Compute a transient with the compiled kernel; waits for it if it is not loaded.

    Agrees with the interpreted kernel to rounding.
    """
    single = _loaded(progress)
    p, t_end = request.parameters, request.t_end
    order = order_for(local_tolerance(request.tol))
    first_mode = mode_of(p, request.initial, separation=request.separation)
    times, dense, max_steps = request.times, request.dense, request.max_steps
    block = _begun(request, single, order, first_mode)
    switches = np.empty(_SWITCHES)
    moments = _NO_TIMES if times is None else times
    states = _NO_ROWS if times is None else np.empty((times.size, single.SAMPLE_COLUMNS))
    segments = np.empty((_SEGMENTS, single.segment_columns(order))) if dense else _NO_ROWS
    switched: list[NDArray[np.float64]] = []
    stored: list[NDArray[np.float64]] = []
    portion = _PAUSE if progress is None and on_samples is None else _REPORT
    reached, steps, given_out, ending = 0.0, 0, 0, single.PAUSED
    arrived: tuple[float, ...] = ()
    while ending != single.DONE:
        if progress is not None and not progress(reached / t_end):
            raise Cancelled
        budget = min(portion, max_steps - steps)
        if budget <= 0:
            raise step_limit_error(max_steps, reached, t_end, stiffness_of(request))
        ending = single.advance(block, switches, moments, states, segments, dense, budget)
        arrived = single.ARRIVED.unpack_from(block, single.RUN_BYTES)
        here = single.Run(*arrived[: single.RUN_SIZE])
        reached, steps = here.t, int(here.steps)
        if on_samples is not None:
            part = slice(given_out, int(here.samples))
            given_out = _hand_out(p, moments, states, on_samples, part)
        if ending in (single.DONE, single.FULL):
            switched.append(switches[: int(here.switches)])
            if dense:
                stored.append(segments[: int(here.segments)])
            if ending == single.FULL:
                switches, segments = np.empty_like(switches), np.empty_like(segments)
                block[single.SWITCHES] = block[single.SEGMENTS] = 0.0
        elif ending != single.PAUSED:
            overflow = ending == single.OVERFLOW
            raise overflow_error(reached, here[:4]) if overflow else stall_error(reached)
    if progress is not None:
        progress(1.0)
    whole, second_half = _extremes(*arrived[single.RUN_SIZE :])
    return assemble(
        request,
        final=here[:4],
        whole=whole,
        second_half=second_half,
        switches=switched[0] if len(switched) == 1 else np.concatenate(switched),
        separations=int(here.separations),
        separated_time=here.separated,
        stats=Stats(steps, None, "compiled"),
        first_mode=first_mode,
        trajectory=None if times is None else _trajectory(p, times, states),
        solution=_solution(p, np.concatenate(stored), order + 1) if dense else None,
    )


def _loaded(progress: Progress | None) -> Any:
    # The kernels; who can cancel the run need not wait for them.
    while progress is not None and not loader.single.wait(_WAIT_S):
        if not progress(0.0):
            raise Cancelled
    return loader.single.module()


def _begun(request: Request, single: Any, order: int, first_mode: Mode) -> NDArray[np.float64]:
    # What is asked, and a run that has not begun, as the kernel reads them.
    p = request.parameters
    stiffness = p.k1 + p.k2 + p.k3
    block = np.empty(single.BLOCK_SIZE)
    single.BEGIN.pack_into(
        block,
        0,
        request.t_end,
        local_tolerance(request.tol),
        0.5 * p.k3,
        p.F,
        abs(p.F) / stiffness,
        1.0 / math.sqrt(p.m / stiffness),
        order,
        request.separation,
        right_hand_side(p, Mode.CONTACT) is RightHandSide.CUBIC,
        *constants(p, Mode.SEPARATED),
        *constants(p, Mode.CONTACT),
        *request.initial,
        first_mode,
        *single.NOT_BEGUN,
        *single.NOTHING_SEEN,
    )
    return block


def _extremes(
    x_min: float, y_min: float, x_max: float, y_max: float, vx_max: float, *later: float
) -> tuple[Extremes, Extremes]:
    # Over the whole run and over its second half, from a row of each half.
    second_half = Extremes.of(*later)
    whole = Extremes.of(x_min, y_min, x_max, y_max, vx_max)
    whole.merge(second_half)
    return whole, second_half


def _hand_out(
    p: Parameters,
    moments: NDArray[np.float64],
    states: NDArray[np.float64],
    on_samples: OnSamples,
    part: slice,
) -> int:
    # Gives the next samples away if they are enough; how many are given away then.
    if part.stop - part.start < _PART:
        return int(part.start)
    on_samples(_trajectory(p, moments[part], states[part]))
    return int(part.stop)


def _trajectory(
    p: Parameters, times: NDArray[np.float64], states: NDArray[np.float64]
) -> Trajectory:
    x, y, vx, vy, mode, _ = states.T.copy()
    return trajectory_of(p, times, (x, vx, y, vy), mode.astype(np.int8))


def _solution(p: Parameters, stored: NDArray[np.float64], degree: int) -> DenseSolution:
    head, size = len(loader.single.module().SEGMENT_COLUMNS), degree + 1
    x, y = stored[:, head : head + size], stored[:, head + size + 1 : head + 2 * size + 1]
    return DenseSolution.from_arrays(p, stored[:, :head], x.T.copy(), y.T.copy())
