"""Single runs by the compiled kernel."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.kernel import (
    SEGMENT_HEAD,
    BeltRun,
    KernelRun,
    RunColumns,
    Status,
    legs_of,
    load_kernel,
)
from fivtui.model import Cancelled, OnProgress, Parameters
from fivtui.taylor import (
    follows_law,
    local_tolerance,
    order_for,
    overflow_error,
    stall_error,
)

from .extremes import Extremes
from .request import OnSamples, Request
from .result import NO_CHANGES, Stats, Transient, assemble, lift_times
from .stiffness import step_limit_error
from .trajectory import DenseSolution, Trajectory, trajectory_of

# Steps between two looks at the progress callback, and at the keyboard if there is none.
_REPORT: Final = 256
_PAUSE: Final = 65536
# Samples that are handed out together.
_PART: Final = 1024
_ENDED_EARLY: Final = (Status.OVERFLOW, Status.STALLED)


def run(
    request: Request, progress: OnProgress | None, on_samples: OnSamples | None = None
) -> Transient:
    """Compute a transient with the compiled kernel: the interpreted one's, to rounding."""
    system, t_end = request.system, request.t_end
    p, separation = system.parameters, system.separation
    tol = local_tolerance(request.tol)
    order = order_for(tol, by_law=follows_law(p))
    times, dense, max_steps = request.times, request.dense, request.max_steps
    course = request.course
    under_way = load_kernel().begin(
        p.values(),
        request.initial,
        separation=separation,
        t_end=t_end,
        tol=tol,
        order=order,
        times=times,
        segments=dense,
        belt=_belt_of(request),
        legs=None if course is None else legs_of(course, t_end),
    )
    switches: list[NDArray[np.float64]] = []
    segments: list[NDArray[np.float64]] = []
    portion = _PAUSE if progress is None and on_samples is None else _REPORT
    reached, steps, given_out = 0.0, 0, 0
    status = Status.RUNNING
    while status is not Status.DONE:
        if progress is not None and not progress(reached / t_end):
            raise Cancelled
        budget = min(portion, max_steps - steps)
        if budget <= 0:
            raise step_limit_error(request, reached)
        status = under_way.advance(budget)
        here = under_way.outcome
        reached, steps = here.t, int(here.steps)
        if on_samples is not None and times is not None:
            part = slice(given_out, under_way.sampled)
            given_out = _hand_out(p, times, under_way, on_samples, part)
        if status in _ENDED_EARLY:
            if status is Status.STALLED:
                raise stall_error(reached, p)
            raise overflow_error(reached, here[:4], system)
        switches.append(under_way.switches)
        if dense:
            segments.append(under_way.segments)
    if progress is not None:
        progress(1.0)
    whole, second_half = _extremes(here)
    found, changes, tally = _joined(switches), NO_CHANGES, None
    if isinstance(under_way, BeltRun):
        every = found.reshape(-1, NO_CHANGES.shape[1])
        found = lift_times(every) if here.separations + here.reattachments > 0.0 else every[:0, 0]
        changes = every if p.v_belt is not None else NO_CHANGES
        tally = under_way.tally
    return assemble(
        request,
        final=here[:4],
        whole=whole,
        second_half=second_half,
        switches=found,
        separations=int(here.separations),
        separated_time=here.separated,
        stats=Stats(steps, None, "compiled"),
        first_mode=request.first_mode,
        trajectory=None if times is None else _trajectory(p, times, under_way),
        solution=_solution(p, _joined(segments), order + 1) if dense else None,
        changes=changes,
        tally=tally,
    )


def _belt_of(request: Request) -> tuple[float, float, float] | None:
    # The belt as the kernel reads it. Where μ follows a table it may fall from μ_s.
    p = request.system.parameters
    if p.v_belt is None:
        return None
    law = p.v_s if request.course is not None and p.mu_s is not None else p.speed_law
    return p.v_belt, p.mu_static, law or 0.0


def _joined(parts: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _extremes(here: RunColumns) -> tuple[Extremes, Extremes]:
    # Over the whole run, and those of y over its second half.
    whole = Extremes.of(here.x_min, here.y_min, here.x_max, here.y_max, here.vx_max)
    second_half = Extremes()
    second_half.y_min, second_half.y_max = here.y_low, here.y_high
    return whole, second_half


def _hand_out(
    p: Parameters,
    times: NDArray[np.float64],
    under_way: KernelRun,
    on_samples: OnSamples,
    part: slice,
) -> int:
    # Gives the next samples away if they are enough; how many are given away then.
    if part.stop - part.start < _PART:
        return int(part.start)
    on_samples(_trajectory(p, times, under_way, part))
    return int(part.stop)


def _trajectory(
    p: Parameters, times: NDArray[np.float64], under_way: KernelRun, part: slice = slice(None)
) -> Trajectory:
    x, vx, y, vy, force = under_way.samples[:, part]
    return trajectory_of(p, times[part], (x, vx, y, vy), under_way.modes[part], force)


def _solution(p: Parameters, stored: NDArray[np.float64], degree: int) -> DenseSolution:
    middle = SEGMENT_HEAD + degree + 1
    x, y = stored[:, SEGMENT_HEAD:middle], stored[:, middle:]
    return DenseSolution.from_arrays(p, stored[:, :SEGMENT_HEAD].copy(), x.T.copy(), y.T.copy())
