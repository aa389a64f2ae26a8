"""Compute the members of a batch in Python, if there is no compiled kernel."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fivtui.kernel import RunColumns, Status
from fivtui.model import PARAMETERS, ComputationError, Parameters, System, static_start
from fivtui.taylor import StallError, taylor_stepper
from fivtui.transient import Recorder, Request

from .result import Floats


class Members(NamedTuple):
    """Parameter sets (n, 9), whether each considers separation (n,), and start states (n, 4)."""

    parameters: Floats
    separation: NDArray[np.bool_]
    starts: Floats


def _to_parameters(row: Floats) -> Parameters:
    return Parameters(**dict(zip(PARAMETERS, row.tolist(), strict=True)))


def interpreted_starts(parameters: Floats, separation: NDArray[np.bool_]) -> Floats:
    """Static starts, shape (n, 4); infinite for members without one."""
    starts = np.full((len(parameters), 4), np.inf)
    for index, (row, considers_separation) in enumerate(zip(parameters, separation, strict=True)):
        try:
            starts[index] = static_start(System(_to_parameters(row), bool(considers_separation)))
        except ComputationError:
            continue
    return starts


def interpret_members(
    members: Members,
    t_end: float,
    tol: float,
    max_steps: int,
    *,
    belt_columns: Mapping[str, Floats],
    proceed: Callable[[], bool],
) -> Floats:
    """Integrate members; the rows of the result have the columns of `RunColumns`.

    `belt_columns` has the belt parameters by name. `proceed` is called after every member; the
    batch stops if it returns False.
    """
    results = np.full((len(members.starts), len(RunColumns._fields)), np.nan)
    for index, (row, separation, start) in enumerate(zip(*members, strict=True)):
        if np.isfinite(start).all():
            belt_values = {name: float(column[index]) for name, column in belt_columns.items()}
            p = _to_parameters(row).with_values(belt_values)
            request = Request(
                System(p, bool(separation)), t_end=t_end, tol=tol, start=start.tolist()
            )
            results[index] = _integrate(request, max_steps)
        else:
            results[index] = _incomplete_columns(start.tolist(), 0.0, Status.NO_START, 0)
        if not proceed():
            break
    return results


def _integrate(request: Request, max_steps: int) -> RunColumns:
    # The columns of one member, as those of the compiled kernel. The run stalls if the motion
    # changes faster than floating-point time resolves.
    recorder = Recorder(request)
    stepper = taylor_stepper(request.system, request.initial, tol=request.tol)
    steps, status = 0, Status.STEP_LIMIT
    try:
        while steps < max_steps and status is not Status.DONE:
            recorder.include(stepper.advance())
            steps += 1
            if recorder.t >= request.t_end:
                status = Status.DONE
        run = recorder.result("interpreted") if status is Status.DONE else None
    except ComputationError as error:
        run, status = None, Status.STALLED if isinstance(error, StallError) else Status.OVERFLOW
    if run is None:
        snapshot = stepper.snapshot
        return _incomplete_columns(snapshot.state, snapshot.t, status, steps)
    peak, events, final = run.peak, run.events, run.final
    return RunColumns(
        x=final.x,
        vx=final.vx,
        y=final.y,
        vy=final.vy,
        t=request.t_end,
        status=status,
        steps=steps,
        separations=events.separations,
        reattachments=events.reattachments,
        separated_time=events.separated_time,
        first=np.nan if events.first is None else events.first,
        last=np.nan if events.last is None else events.last,
        # A run has the peak of |x|, and half the range of y in its second half, but not the ends of
        # these ranges. Batches need no more, so any ends with this peak and this range will do.
        x_min=-peak.x_abs,
        y_min=peak.y_min,
        x_max=peak.x_abs,
        y_max=peak.y_max,
        vx_max=peak.vx_max,
        second_half_min=0.0,
        second_half_max=2.0 * run.steady.y_half_range,
    )


def _incomplete_columns(state: Sequence[float], t: float, status: Status, steps: int) -> RunColumns:
    # The columns of a member whose integration ended at t; NaN for values of the whole run.
    x, vx, y, vy = state
    no_values = RunColumns(*[np.nan] * len(RunColumns._fields))
    return no_values._replace(
        x=x, vx=vx, y=y, vy=vy, t=t, status=status, steps=steps, separations=0, reattachments=0
    )
