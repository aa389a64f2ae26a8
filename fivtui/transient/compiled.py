"""Single runs by the compiled kernel."""

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.kernel import (
    SEGMENT_HEAD,
    BeltRun,
    KernelRun,
    Status,
    VariedRun,
    course_table,
    load_kernel,
)
from fivtui.model import Parameters, Progress
from fivtui.taylor import (
    follows_law,
    local_tolerance,
    order_for,
    overflow_error,
    stall_error,
    unbounded_error,
)

from .extremes import Extremes
from .request import OnSamples, Request
from .result import NO_CHANGES, Stats, Transient, assemble, lift_times
from .stiffness import step_limit_error
from .trajectory import DenseSolution, Trajectory, trajectory_of

# Steps between progress reports, and between checks for interrupts without a callback.
_REPORT: Final = 256
_PAUSE: Final = 65536
# Enum lookups would slow down short runs, which are one kernel call.
_DONE: Final = Status.DONE
# Samples per call of `on_samples`.
_PART: Final = 1024


def follow(
    run: KernelRun | VariedRun, request: Request, work: Progress, portion: int = _REPORT
) -> Iterator[None]:
    """Continue a run to its end; yields after every kernel call of `portion` steps."""
    t_end, max_steps = request.t_end, request.max_steps
    reached, steps = 0.0, 0
    while True:
        work.report(reached / t_end)
        budget = min(portion, max_steps - steps)
        if budget <= 0:
            raise step_limit_error(request, reached)
        status = run.advance(budget)
        outcome = run.outcome
        reached, steps = outcome.t, int(outcome.steps)
        yield
        if status is _DONE:
            return
        if status is Status.OVERFLOW:
            raise overflow_error(reached, outcome[:4], request.system)
        if status is Status.STALLED:
            raise stall_error(reached, request.parameters)
        if status is Status.UNBOUNDED:
            raise unbounded_error(reached)


def run(request: Request, work: Progress, on_samples: OnSamples | None = None) -> Transient:
    """Compute a transient with the compiled kernel: the interpreted one's, to rounding."""
    system, course, times, dense = request.system, request.course, request.times, request.dense
    p = system.parameters
    tol = local_tolerance(request.tol)
    order = order_for(tol, by_law=follows_law(p))
    under_way = load_kernel().begin_run(
        p.values(),
        request.initial,
        separation=system.separation,
        t_end=request.t_end,
        tol=tol,
        order=order,
        times=times,
        segments=dense,
        belt=_belt_of(request),
        table=None if course is None else course_table(course, request.t_end),
    )
    switches: list[NDArray[np.float64]] = []
    segments: list[NDArray[np.float64]] = []
    given_out = 0
    is_silent = work.callback is None and on_samples is None
    for _ in follow(under_way, request, work, _PAUSE if is_silent else _REPORT):
        switches.append(under_way.switches)
        if dense:
            segments.append(under_way.segments)
        if on_samples is not None and times is not None and under_way.sampled - given_out >= _PART:
            on_samples(_trajectory(p, times, under_way, slice(given_out, under_way.sampled)))
            given_out = under_way.sampled
    work.advance(1.0)
    outcome = under_way.outcome
    switch_times, changes, tally = _joined(switches), NO_CHANGES, None
    if isinstance(under_way, BeltRun):
        rows = switch_times.reshape(-1, NO_CHANGES.shape[1])
        has_lifts = outcome.separations + outcome.reattachments > 0.0
        switch_times = lift_times(rows) if has_lifts else rows[:0, 0]
        changes = rows if p.v_belt is not None else NO_CHANGES
        tally = under_way.tally
    return assemble(
        request,
        final=outcome[:4],
        extremes=Extremes(
            outcome.x_min, outcome.y_min, outcome.x_max, outcome.y_max, outcome.vx_max
        ),
        second_half=Extremes(y_min=outcome.y_low, y_max=outcome.y_high),
        switches=switch_times,
        separations=int(outcome.separations),
        separated_time=outcome.separated,
        stats=Stats(int(outcome.steps), None, "compiled"),
        first_mode=request.first_mode,
        trajectory=None if times is None else _trajectory(p, times, under_way),
        solution=_solution(p, _joined(segments), order + 1) if dense else None,
        changes=changes,
        tally=tally,
    )


def _belt_of(request: Request) -> tuple[float, float, float] | None:
    # Belt arguments of the kernel. Keep the law if μ follows a table, which may start at μ_s.
    p = request.system.parameters
    if p.v_belt is None:
        return None
    law = p.v_s if request.course is not None and p.mu_s is not None else p.speed_law
    return p.v_belt, p.mu_static, law or 0.0


def _joined(parts: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _trajectory(
    p: Parameters, times: NDArray[np.float64], under_way: KernelRun, part: slice = slice(None)
) -> Trajectory:
    x, vx, y, vy, force = under_way.samples[:, part]
    return trajectory_of(p, times[part], (x, vx, y, vy), under_way.modes[part], force)


def _solution(p: Parameters, stored: NDArray[np.float64], degree: int) -> DenseSolution:
    middle = SEGMENT_HEAD + degree + 1
    x, y = stored[:, SEGMENT_HEAD:middle], stored[:, middle:]
    return DenseSolution.from_arrays(p, stored[:, :SEGMENT_HEAD].copy(), x.T.copy(), y.T.copy())
