"""A transient with the derivatives of its motion by start and parameters.

A seed is a direction of change of the start and the parameters. The deviation by a seed is the
derivative of the state (x, ẋ, y, ẏ) in this direction.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.kernel import load_kernel, why_interpreted
from fivtui.model import (
    PARAMETERS,
    InputError,
    Mode,
    Progress,
    State,
    accelerations,
)
from fivtui.taylor import (
    Deviations,
    Seed,
    Segment,
    derivative,
    evaluate,
    local_tolerance,
    order_for,
    roots,
    taylor_stepper,
)
from fivtui.transient.compiled import follow
from fivtui.transient.request import Request
from fivtui.transient.stiffness import step_limit_error

FloatArray = NDArray[np.float64]

# An extreme replaces a former one if it is greater by more than this fraction of itself.
_EXTREME_TOLERANCE: Final = 2.0**-50
# Extremes over the whole run, and of y over its second half.
EXTREMES: Final = (
    "x_min",
    "x_max",
    "y_min",
    "y_max",
    "vx_max",
    "second_half_min",
    "second_half_max",
)
# Seeds of the derivatives by x, ẋ, y and ẏ at the start.
START_SEEDS: Final = (
    Seed((1.0, 0.0, 0.0, 0.0)),
    Seed((0.0, 1.0, 0.0, 0.0)),
    Seed((0.0, 0.0, 1.0, 0.0)),
    Seed((0.0, 0.0, 0.0, 1.0)),
)
_STATE_SIZE: Final = 4
_PARAMETER_COLUMNS: Final = {name: column for column, name in enumerate(PARAMETERS)}
_NO_TIMES: Final = np.empty(0)
# Steps between progress reports.
_STEPS_PER_REPORT: Final = 8


@dataclass(frozen=True, slots=True)
class Variation:
    """A motion and its derivatives by k seeds, which are directions of start and parameters."""

    final: State
    # Time derivative of the final state, and its derivatives by the seeds, shape (4, k).
    final_rate: FloatArray
    derivatives: FloatArray
    # The extremes in the order of EXTREMES: times, values, and derivatives, shape (7, k).
    extreme_times: FloatArray
    extremes: FloatArray
    extreme_derivatives: FloatArray
    # Times of separation and reattachment, s.
    switch_times: FloatArray
    # All switches on a belt of finite speed, shape (n, 3): time, s, mode before, mode after.
    changes: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    # States at the sample times, and their derivatives by the seeds, shape (n, 1 + k, 4).
    samples: FloatArray = field(default_factory=lambda: np.empty((0, 1, 4)))


def compute_variation(
    request: Request,
    seeds: Sequence[Seed],
    work: Progress | None = None,
    times: FloatArray = _NO_TIMES,
) -> Variation:
    """Compute a transient with its derivatives, by the variational equations.

    The motion and its derivatives are sampled at `times`, ascending from 0 to the horizon, s.

    The equations of both modes agree at y = 0, so derivatives are continuous at separation. On a
    belt of finite speed they jump at the start and end of sliding, which interpreted code handles.
    All scenes are integrated by the method ``taylor``, also linear ones. Raises `InputError` if a
    parameter changes over time.
    """
    if request.course is not None:
        raise InputError(
            f"{', '.join(request.course.tables)} over time: must be constant for derivatives"
        )
    on_belt = request.parameters.v_belt is not None
    if on_belt or request.kernel == "interpreted" or why_interpreted() is not None:
        return _run_interpreted(request, seeds, work or Progress(None), times)
    return _run_compiled(request, seeds, work or Progress(None), times)


def _run_compiled(
    request: Request, seeds: Sequence[Seed], work: Progress, times: FloatArray
) -> Variation:
    # Tolerance of a step, below that of the run: errors of steps add up.
    tol = local_tolerance(request.tol)
    seed_rows = np.zeros((len(seeds), _STATE_SIZE + len(PARAMETERS)))
    for row, seed in zip(seed_rows, seeds, strict=True):
        row[:_STATE_SIZE] = seed.start
        for name, change in seed.parameters.items():
            row[_STATE_SIZE + _PARAMETER_COLUMNS[name]] = change
    run = load_kernel().begin_varied_run(
        np.array(request.parameters.values()),
        np.array(request.initial),
        seed_rows,
        separation=request.separation,
        t_end=request.t_end,
        tol=tol,
        order=order_for(tol),
        times=np.ascontiguousarray(times, dtype=float),
    )
    # Rows of separations and reattachments, which begin with their times.
    crossings = np.concatenate([run.crossings.copy() for _ in follow(run, request, work)])
    # By rounding, a time at the horizon may lie after the last step.
    run.samples[np.isnan(run.samples[:, 0, 0])] = [run.outcome[:_STATE_SIZE], *run.derivatives]
    return Variation(
        run.outcome[:_STATE_SIZE],
        np.array(run.rate),
        run.derivatives.T,
        run.extremes[:, 0],
        np.array([getattr(run.outcome, name) for name in EXTREMES]),
        run.extremes[:, 1:],
        crossings[:, 0],
        samples=run.samples,
    )


def _run_interpreted(
    request: Request, seeds: Sequence[Seed], work: Progress, times: FloatArray
) -> Variation:
    p, t_end = request.parameters, request.t_end
    stepper = taylor_stepper(request.system, request.initial, tol=request.tol)
    deviations = Deviations(p, seeds)
    extremes = _Extremes(0.5 * t_end, len(seeds))
    switches: list[float] = []
    changes: list[tuple[float, int, int]] = []
    samples: list[list[State]] = []
    t, state = 0.0, request.initial
    for count in range(request.max_steps):
        if count % _STEPS_PER_REPORT == 0:
            work.report(t / t_end)
        segment = stepper.advance()
        # The run ends at θ of the segment, which is below 1 if the horizon is within the segment.
        theta_end = min(segment.fraction(t_end), 1.0) if segment.end > t_end else 1.0
        is_complete = theta_end == 1.0
        sampled_times = _times_within(segment, theta_end, times[len(samples) :])
        thetas = list(map(segment.fraction, sampled_times))
        deviations_at = extremes.include(segment, theta_end, deviations, thetas)
        for time, sampled in zip(sampled_times, deviations_at, strict=True):
            samples.append([segment.state(time), *sampled])
        t, state = segment.end, segment.final if is_complete else segment.state(t_end)
        if segment.switches and is_complete and p.v_belt is not None:
            changes.append((t, segment.mode, segment.next_mode))
        if segment.lifts_or_lands and is_complete:
            switches.append(t)
        if segment.end >= t_end:
            break
    else:
        raise step_limit_error(request, t)
    mode = segment.next_mode if is_complete else segment.mode
    x, vx, y, vy = state
    if mode is Mode.STICK:
        vx = p.v_belt or 0.0
    state = (x, vx, y, vy)
    ax, ay = accelerations(p, state, mode)
    # By rounding, a time at the horizon may lie after the last step.
    samples += [[state, *deviations.current]] * (times.size - len(samples))
    return Variation(
        state,
        np.array([vx, ax, vy, ay]),
        np.array(deviations.current).T,
        extremes.times,
        extremes.values,
        extremes.derivatives,
        np.array(switches),
        np.array(changes, dtype=float).reshape(-1, 3),
        np.array(samples).reshape(-1, 1 + len(seeds), _STATE_SIZE),
    )


def _times_within(segment: Segment, end: float, times: FloatArray) -> list[float]:
    # The next sample times, as far as they are in a segment up to θ = end.
    return list(itertools.takewhile(lambda t: segment.fraction(t) <= end, times.tolist()))


class _Extremes:
    # The extremes of a motion so far, in the order of `EXTREMES`, with their times and derivatives.

    def __init__(self, half_time: float, count: int) -> None:
        self._half_time = half_time
        self._signed_values = [-np.inf] * len(EXTREMES)
        self.values = np.zeros(len(EXTREMES))
        self.times = np.zeros(len(EXTREMES))
        self.derivatives = np.zeros((len(EXTREMES), count))

    def include(
        self, segment: Segment, end: float, deviations: Deviations, sampled: Sequence[float]
    ) -> list[list[State]]:
        """Advance deviations along a segment up to θ = end; store those at new extremes.

        Returns those at the θ in `sampled`. θ is the time since the start of the segment relative
        to its duration.
        """
        # θ of each new extreme, and the component of the state of which it is an extreme.
        thetas, components = {}, {}
        for index, (sign, polynomial, component, begin) in enumerate(
            self._extreme_polynomials(segment)
        ):
            # Skip a segment that ends before the second half of the run. One that lies in the range
            # of the extreme (begin = 0) counts even if it has no length.
            if begin > 0.0 and begin >= end:
                continue
            stationary = roots(derivative(polynomial))
            candidates = [begin, *(theta for theta in stationary if begin < theta < end), end]
            if component == 1 and self._begins_to_stick(segment):
                # Deviations jump at the start of stick. An extreme of ẋ there is the belt's speed;
                # its derivative is that after the jump, at the start of the stick segment.
                candidates.pop()
            values = [sign * evaluate(polynomial, theta) for theta in candidates]
            greatest = max(values)
            if greatest - self._signed_values[index] > _EXTREME_TOLERANCE * abs(greatest):
                self._signed_values[index], self.values[index] = greatest, sign * greatest
                thetas[index], components[index] = candidates[values.index(greatest)], component
        deviations_at = deviations.advance(segment, end, [*thetas.values(), *sampled])
        for index, seed_deviations in zip(thetas, deviations_at, strict=False):
            # The exact start is start + start_remainder, since `start` is rounded.
            self.times[index] = segment.start + (
                segment.start_remainder + thetas[index] * segment.duration
            )
            self.derivatives[index] = [
                deviation[components[index]] for deviation in seed_deviations
            ]
        return deviations_at[len(thetas) :]

    def _begins_to_stick(self, segment: Segment) -> bool:
        t_end = 2.0 * self._half_time
        if segment.end >= t_end:
            # No stick segment follows the end of the run.
            return False
        return segment.mode is not Mode.STICK and segment.next_mode is Mode.STICK

    def _extreme_polynomials(
        self, segment: Segment
    ) -> list[tuple[float, Sequence[float], int, float]]:
        # Sign (−1: minimum), polynomial, state component and first θ of each of EXTREMES.
        speed = [coefficient / segment.duration for coefficient in derivative(segment.x)]
        half_theta = max(segment.fraction(self._half_time), 0.0)
        return [
            (-1.0, segment.x, 0, 0.0),
            (1.0, segment.x, 0, 0.0),
            (-1.0, segment.y, 2, 0.0),
            (1.0, segment.y, 2, 0.0),
            (1.0, speed, 1, 0.0),
            (-1.0, segment.y, 2, half_theta),
            (1.0, segment.y, 2, half_theta),
        ]
