"""Single runs by the compiled kernel, the Taylor integrator in C.

The kernel runs a number of steps per call and returns between calls for progress and samples. A
segment is the Taylor polynomial of one step. A `KernelRun` is a run in progress; a `BeltRun` has a
belt of finite speed or parameters that change over time. A `VariedRun` computes the derivatives of
the motion by its start and parameters, too.
"""

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
from fivtui.model import Progress, System
from fivtui.taylor import (
    Extremes,
    follows_law,
    local_tolerance,
    order_for,
    overflow_error,
    stall_error,
    unbounded_error,
)

from .request import OnSamples, Request
from .result import NO_CHANGES, SpringRange, Stats, Transient, build_transient, contact_switch_times
from .stiffness import step_limit_error
from .trajectory import CONTACT_SPRING, DenseSolution, Trajectory, build_trajectory

# Steps per kernel call: with a callback; and without one, where only interrupts (Ctrl+C) need a
# return from the kernel.
_REPORT_STEPS: Final = 256
_INTERRUPT_STEPS: Final = 65536
# A constant, because attribute lookups of enums slow down short runs.
_DONE: Final = Status.DONE
# Least number of samples per call of `on_samples`.
_BATCH_SIZE: Final = 1024


def follow(
    run: KernelRun | VariedRun, request: Request, work: Progress, call_steps: int = _REPORT_STEPS
) -> Iterator[None]:
    """Continue a run to its end; yields after every kernel call of `call_steps` steps."""
    t_end, max_steps = request.t_end, request.max_steps
    t_reached, steps = 0.0, 0
    while True:
        work.report(t_reached / t_end)
        allowed_steps = min(call_steps, max_steps - steps)
        if allowed_steps <= 0:
            raise step_limit_error(request, t_reached)
        status = run.advance(allowed_steps)
        outcome = run.outcome
        t_reached, steps = outcome.t, int(outcome.steps)
        yield
        if status is _DONE:
            return
        if status is Status.OVERFLOW:
            raise overflow_error(t_reached, outcome[:4], request.system)
        if status is Status.STALLED:
            raise stall_error(t_reached, request.parameters)
        if status is Status.UNBOUNDED:
            raise unbounded_error(t_reached)


def run(request: Request, work: Progress, on_samples: OnSamples | None = None) -> Transient:
    """Compute a transient with the compiled kernel; it agrees with interpreted code to rounding."""
    # The course has the parameters as functions of time; None if all are constant.
    system, course, times, dense = request.system, request.course, request.times, request.dense
    p = system.parameters
    # Tolerance of a step, below that of the run: errors of steps add up.
    tol = local_tolerance(request.tol)
    # The order may be higher where friction falls with the sliding speed (`follows_law`).
    order = order_for(tol, by_law=follows_law(p))
    table = None if course is None else course_table(course, request.t_end)
    kernel_run = load_kernel().begin_run(
        p.values(),
        request.initial,
        separation=system.separation,
        t_end=request.t_end,
        tol=tol,
        order=order,
        times=times,
        segments=dense,
        belt=_belt_arguments(request),
        table=table,
    )
    # Parts of results, one per kernel call.
    switch_parts: list[NDArray[np.float64]] = []
    segment_parts: list[NDArray[np.float64]] = []
    sent_count = 0
    is_silent = work.callback is None and on_samples is None
    for _ in follow(kernel_run, request, work, _INTERRUPT_STEPS if is_silent else _REPORT_STEPS):
        switch_parts.append(kernel_run.switches)
        if dense:
            segment_parts.append(kernel_run.segments)
        if on_samples is None or times is None:
            continue
        sampled_count = kernel_run.sampled
        if sampled_count - sent_count >= _BATCH_SIZE:
            on_samples(_trajectory(system, times, kernel_run, slice(sent_count, sampled_count)))
            sent_count = sampled_count
    work.advance(1.0)
    outcome = kernel_run.outcome
    ranges: list[SpringRange] | None = None
    if table is not None and course is not None and not CONTACT_SPRING.isdisjoint(course.tables):
        # The kernel begins another range where the contact spring changes, at a row. A range is
        # empty, greatest below least, if the run ends there.
        table.y_ranges[-1] = outcome.y_min, outcome.y_max
        rows = np.column_stack([table.rows[:, 0], table.y_ranges]).tolist()
        ranges = [
            SpringRange(course.after(t)[0], low, high) for t, low, high in rows if low <= high
        ]
    switch_times, changes, totals = _concatenate(switch_parts), NO_CHANGES, None
    if isinstance(kernel_run, BeltRun):
        # Such a run reports switches as time, mode before and mode after. The result has them only
        # on a belt of finite speed, not if parameters alone change over time.
        mode_changes = switch_times.reshape(-1, NO_CHANGES.shape[1])
        has_contact_switches = outcome.separations + outcome.reattachments > 0.0
        switch_times = contact_switch_times(mode_changes) if has_contact_switches else np.empty(0)
        changes = mode_changes if p.v_belt is not None else NO_CHANGES
        totals = kernel_run.stick_time_and_switch_counts
    return build_transient(
        request,
        final=outcome[:4],
        extremes=Extremes(
            outcome.x_min, outcome.y_min, outcome.x_max, outcome.y_max, outcome.vx_max
        ),
        ranges=ranges,
        second_half=Extremes(y_min=outcome.second_half_min, y_max=outcome.second_half_max),
        switches=switch_times,
        separations=int(outcome.separations),
        separated_time=outcome.separated_time,
        stats=Stats(int(outcome.steps), None, "compiled"),
        first_mode=request.first_mode,
        trajectory=None if times is None else _trajectory(system, times, kernel_run),
        solution=_solution(system, _concatenate(segment_parts), order + 1) if dense else None,
        changes=changes,
        totals=totals,
    )


def _belt_arguments(request: Request) -> tuple[float, float, float] | None:
    # The belt's speed, m/s, μ_s and v_s, m/s; None for a belt that is always faster. v_s is 0 for
    # constant friction, that is for μ = μ_s, where `speed_law` is None. Over time μ may fall below
    # μ_s later, so v_s is then needed even if they are equal at the start.
    p = request.system.parameters
    if p.v_belt is None:
        return None
    v_s = p.v_s if request.course is not None and p.mu_s is not None else p.speed_law
    return p.v_belt, p.mu_static, v_s or 0.0


def _concatenate(parts: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _trajectory(
    system: System, times: NDArray[np.float64], kernel_run: KernelRun, part: slice = slice(None)
) -> Trajectory:
    x, vx, y, vy, force = kernel_run.samples[:, part]
    return build_trajectory(system, times[part], (x, vx, y, vy), kernel_run.modes[part], force)


def _solution(system: System, rows: NDArray[np.float64], degree: int) -> DenseSolution:
    # A row of the kernel has a head (start, its rounding remainder, duration, end and mode of a
    # segment), then the coefficients of x and of y.
    y_start = SEGMENT_HEAD + degree + 1
    x, y = rows[:, SEGMENT_HEAD:y_start], rows[:, y_start:]
    return DenseSolution.from_arrays(system, rows[:, :SEGMENT_HEAD].copy(), x.T.copy(), y.T.copy())
