"""Single runs by the compiled kernel."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.kernel import SAMPLE_COLUMNS, SEGMENT_HEAD, RunColumns, Status, load_kernel
from fivtui.model import Cancelled, Parameters, mode_of
from fivtui.taylor import local_tolerance, order_for, overflow_error, stall_error

from .extremes import Extremes
from .request import OnSamples, Progress, Request
from .result import Stats, Transient, assemble
from .stiffness import step_limit_error, stiffness_of
from .trajectory import DenseSolution, Trajectory, trajectory_of

# Steps between two looks at the progress callback, and at the keyboard if there is none.
_REPORT: Final = 256
_PAUSE: Final = 65536
# Lengths of the buffers; a longer run empties them on its way. So large a room for segments is kept
# by the allocator from run to run: given back to the system, its pages cost more than the run.
_SWITCHES: Final = 256
_SEGMENTS: Final = 2048
# Samples that are handed out together.
_PART: Final = 1024
_NO_TIMES: Final = np.empty(0)
_NO_ROWS: Final = np.empty((0, 0))
_ENDED_EARLY: Final = (Status.OVERFLOW, Status.STALLED)


def run(
    request: Request, progress: Progress | None, on_samples: OnSamples | None = None
) -> Transient:
    """Compute a transient with the compiled kernel: the interpreted one's, to rounding."""
    kernel = load_kernel()
    p, t_end = request.parameters, request.t_end
    tol = local_tolerance(request.tol)
    order = order_for(tol)
    first_mode = mode_of(p, request.initial, separation=request.separation)
    times, dense, max_steps = request.times, request.dense, request.max_steps
    under_way = kernel.begin(
        p.as_dict().values(),
        request.initial,
        separation=request.separation,
        t_end=t_end,
        tol=tol,
        order=order,
    )
    switches = _Buffer(_SWITCHES)
    moments = _NO_TIMES if times is None else times
    states = _NO_ROWS if times is None else np.empty((times.size, SAMPLE_COLUMNS))
    segments = _Buffer(_SEGMENTS, SEGMENT_HEAD + 2 * (order + 2)) if dense else None
    portion = _PAUSE if progress is None and on_samples is None else _REPORT
    reached, steps, given_out = 0.0, 0, 0
    status = Status.RUNNING
    while status is not Status.DONE:
        if progress is not None and not progress(reached / t_end):
            raise Cancelled
        budget = min(portion, max_steps - steps)
        if budget <= 0:
            raise step_limit_error(max_steps, reached, t_end, stiffness_of(request))
        status = under_way.advance(
            switches.room, moments, states, None if segments is None else segments.room, budget
        )
        here = under_way.outcome
        reached, steps = here.t, int(here.steps)
        if on_samples is not None:
            part = slice(given_out, under_way.samples)
            given_out = _hand_out(p, moments, states, on_samples, part)
        if status in _ENDED_EARLY:
            overflow = status is Status.OVERFLOW
            raise overflow_error(reached, here[:4]) if overflow else stall_error(reached)
        switches.take(under_way.switches)
        if segments is not None:
            segments.take(under_way.segments)
    if progress is not None:
        progress(1.0)
    whole, second_half = _extremes(here)
    return assemble(
        request,
        final=here[:4],
        whole=whole,
        second_half=second_half,
        switches=switches.content(),
        separations=int(here.separations),
        separated_time=here.separated,
        stats=Stats(steps, None, "compiled"),
        first_mode=first_mode,
        trajectory=None if times is None else _trajectory(p, times, states),
        solution=None if segments is None else _solution(p, segments.content(), order + 1),
    )


class _Buffer:
    # Rows that are filled piece by piece, in as many arrays as it takes.

    def __init__(self, *shape: int) -> None:
        self._full: list[NDArray[np.float64]] = []
        self._rows, self._filled = np.empty(shape), 0

    @property
    def room(self) -> NDArray[np.float64]:
        return self._rows[self._filled :]

    def take(self, count: int) -> None:
        self._filled += count
        if count and self._filled == len(self._rows):
            self._full.append(self._rows)
            self._rows, self._filled = np.empty_like(self._rows), 0

    def content(self) -> NDArray[np.float64]:
        last = self._rows[: self._filled]
        return np.concatenate([*self._full, last]) if self._full else last


def _extremes(here: RunColumns) -> tuple[Extremes, Extremes]:
    # Over the whole run, and those of y over its second half.
    whole = Extremes.of(here.x_min, here.y_min, here.x_max, here.y_max, here.vx_max)
    second_half = Extremes()
    second_half.y_min, second_half.y_max = here.y_low, here.y_high
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
    x, vx, y, vy, mode = states.T.copy()
    return trajectory_of(p, times, (x, vx, y, vy), mode.astype(np.int8))


def _solution(p: Parameters, stored: NDArray[np.float64], degree: int) -> DenseSolution:
    middle = SEGMENT_HEAD + degree + 1
    x, y = stored[:, SEGMENT_HEAD:middle], stored[:, middle:]
    return DenseSolution.from_arrays(p, stored[:, :SEGMENT_HEAD].copy(), x.T.copy(), y.T.copy())
