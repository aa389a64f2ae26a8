"""Single runs by the kernel: plain, on a belt of finite speed, and with derivatives.

A segment is the motion over one step. A crossing is a switch at y = 0, with the state and its
derivatives there. A seed is a direction of change of the start and of the parameters.
"""

import ctypes
import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Course, Mode, State, load

Floats = NDArray[np.float64]

# Columns of a segment before its coefficients in θ = time/duration.
SEGMENT_HEAD: Final = 5
# Limit of seeds, number of extremes, and columns of a crossing before its derivatives.
MAX_SEEDS: Final = 16
EXTREMES: Final = 7
CROSSING_HEAD: Final = 6
# Buffer sizes per call, in crossings, switches and segments. The allocator reuses a segment buffer
# of this size between runs: new pages from the system would cost more than the run.
_CROSSINGS: Final = 64
_SWITCHES: Final = 256
_SEGMENTS: Final = 2048


class Status(IntEnum):
    """How a run, or the transient of a member of a batch, ended.

    Attributes
    ----------
    DONE
        At the horizon.
    OVERFLOW
        The motion exceeded the range of floating-point numbers.
    STALLED
        The motion changed faster than floating-point time resolves.
    STEP_LIMIT
        The run took too many steps.
    NO_START
        F < 0, and there is no equilibrium to start from.
    RUNNING
        The run has not ended.
    UNBOUNDED
        The derivatives of the motion exceed the range of numbers or change too fast.
    """

    DONE = 0
    OVERFLOW = 1
    STALLED = 2
    STEP_LIMIT = 3
    NO_START = 4
    RUNNING = 5
    UNBOUNDED = 6


class RunColumns(NamedTuple):
    """Columns of a result, SI units.

    `first` and `last` are the times of the first and last switch, NaN without one.
    `second_half_min` and `second_half_max` are extremes of y in the second half of the run.
    """

    x: Any
    vx: Any
    y: Any
    vy: Any
    t: Any
    status: Any
    steps: Any
    separations: Any
    reattachments: Any
    separated_time: Any
    first: Any
    last: Any
    x_min: Any
    y_min: Any
    x_max: Any
    y_max: Any
    vx_max: Any
    second_half_min: Any
    second_half_max: Any


COLUMNS: Final = len(RunColumns._fields)
# The columns of a result, then the numbers of switches, segments and samples; for a `VariedRun`
# instead the number of crossings, ẍ and ÿ.
_CALL_COLUMNS: Final = COLUMNS + 3
# Columns that a `BeltRun` adds: stick time, and counts of switches for each pair of modes.
_TALLY_COLUMNS: Final = slice(_CALL_COLUMNS, _CALL_COLUMNS + 1 + len(Mode) ** 2)
_STATUSES: Final = tuple(Status)
# Numbers of a switch on a belt of finite speed.
_SWITCH_COLUMNS: Final = 3
# Short runs spend most time on buffers; ctypes ones are fastest.
_Result, _Switches = ctypes.c_double * _CALL_COLUMNS, ctypes.c_double * _SWITCHES
_NO_SWITCHES: Final = np.empty(0)


@dataclass(frozen=True, slots=True)
class CourseTable:
    """Parameters over time as a table for the kernel.

    A row has its time, values and slopes of F, μ, μ_s and v_belt from that time on, v_belt just
    before the next row, and the parameters from that time on. The kernel writes its last columns,
    `y_ranges`. `greatest_load` is the greatest absolute load, N: divided by the stiffness of all
    springs it is the scale of displacements.
    """

    rows: NDArray[np.float64]
    greatest_load: float

    @property
    def y_ranges(self) -> NDArray[np.float64]:
        """Least and greatest y, m, since the contact spring last changed, up to the next row."""
        return self.rows[:, -2:]


def course_table(course: Course, t_end: float) -> CourseTable:
    """The table of a course up to a horizon, s."""
    p, t, rows, no_range = course.fixed, 0.0, [], (math.nan, math.nan)
    while t <= t_end:
        values = {name: table.after(t) for name, table in course.tables.items()}
        mu = values.get("mu", (p.mu, 0.0))
        mu_static = mu if p.mu_s is None else (p.mu_s, 0.0)
        speed = values.get("v_belt", (p.v_belt or 0.0, 0.0))
        next_time = course.next_row_time(t)
        speed_before = course.speed_before(next_time)
        inputs = *values.get("F", (p.F, 0.0)), *mu, *mu_static, *speed, speed_before
        rows.append((t, *inputs, *course.after(t)[0].values(), *no_range))
        t = next_time
    # `load` of the model, in place of |F|: terms that are added to it then count, too.
    parameters_at_greatest_load = p.with_values({"F": course.greatest_load})
    return CourseTable(np.array(rows), abs(load(parameters_at_greatest_load)))


class KernelRun:
    """A run that continues step by step; `Kernel.begin_run` makes it."""

    # Columns of a switch, and buffer types for switches and the result.
    _switch_width, _SwitchBuffer, _ResultBuffer = 1, _Switches, _Result
    # Result up to the current time.
    outcome: RunColumns
    # Rows x, ẋ, y and ẏ at the sample times, and a row in which the caller computes the contact
    # force: all five in one block, which the allocator reuses between runs.
    samples: Floats
    modes: NDArray[np.int8]
    # Number of samples computed so far.
    sampled: int
    # Times of the switches of the last call, s.
    switches: Floats
    # A row for each segment of the last call: start, its remainder (exact start minus start),
    # duration, end, mode, and coefficients of x and y.
    segments: Floats

    def __init__(
        self, function: Any, memory: Any, order: int, times: Floats | None, segments: bool
    ) -> None:
        self._function, self._memory = function, memory
        self._result: Any = self._ResultBuffer()
        self._switch_buffer: Any = self._SwitchBuffer()
        self._segment_columns = SEGMENT_HEAD + 2 * (order + 2) if segments else 0
        self._sampling: tuple[Any, ...] = (None, 0, None, None)
        self.sampled = 0
        if times is not None:
            self._times = np.ascontiguousarray(times)
            self.samples = np.empty((5, times.size))
            self.modes = np.empty(times.size, dtype=np.int8)
            samples, modes = self.samples.ctypes.data, self.modes.ctypes.data
            self._sampling = (self._times.ctypes.data, times.size, samples, modes)

    def advance(self, budget: int) -> Status:
        """Continue until the run has ended, a buffer is full or `budget` steps have been taken."""
        segment_address, rows = None, 0
        if self._segment_columns:
            rows = min(budget, _SEGMENTS)
            segment_rows = np.empty((rows, self._segment_columns))
            segment_address = segment_rows.ctypes.data
        status: int = self._function(
            self._memory,
            self._switch_buffer,
            _SWITCHES,
            *self._sampling,
            segment_address,
            rows,
            budget,
            self._result,
        )
        columns = self._result[:_CALL_COLUMNS]
        self.outcome = RunColumns._make(columns[:COLUMNS])
        switch_count, segment_count, sampled = columns[COLUMNS:]
        self.sampled = int(sampled)
        self.switches = (
            np.frombuffer(self._switch_buffer, count=int(switch_count) * self._switch_width).copy()
            if switch_count
            else _NO_SWITCHES
        )
        if self._segment_columns:
            self.segments = segment_rows[: int(segment_count)]
        return _STATUSES[status]


class BeltRun(KernelRun):
    """A run on a belt of finite speed, or with parameters over time.

    `switches` has three numbers for each switch of the last call: time, s, and the modes before
    and after it.
    """

    # Keeps the array alive that the kernel reads during the run.
    table: CourseTable | None = None
    _switch_width, _SwitchBuffer = _SWITCH_COLUMNS, ctypes.c_double * (_SWITCH_COLUMNS * _SWITCHES)
    _ResultBuffer = ctypes.c_double * _TALLY_COLUMNS.stop

    @property
    def stick_time_and_switch_counts(self) -> tuple[float, list[float]]:
        """Stick time so far, s, and counts of switches at the index before · modes + after."""
        stick_time, *switch_counts = self._result[_TALLY_COLUMNS]
        return stick_time, switch_counts


class VariedRun:
    """A run with its derivatives by k numbers."""

    # Result up to the current time, and (ẋ, ẍ, ẏ, ÿ) at that time, m/s and m/s².
    outcome: RunColumns
    rate: State
    # Derivatives of (x, ẋ, y, ẏ) at that time, shape (k, 4).
    derivatives: Floats
    # Time, s, and derivatives of each extreme, shape (7, 1 + k): least and greatest x, y, greatest
    # ẋ, least and greatest y of the second half.
    extremes: Floats
    # A row for each switch of the last call: time, x, ẋ, y, ẏ, mode after it, and the derivatives
    # of (x, ẋ, y, ẏ).
    crossings: Floats
    # (x, ẋ, y, ẏ) at the sample times, and their derivatives by the numbers, shape (n, 1 + k, 4).
    # NaN at times that the run has not reached.
    samples: Floats

    def __init__(self, function: Any, memory: Floats, count: int, times: Floats) -> None:
        self._function, self._memory = function, memory
        # The kernel reads the times during the run.
        self._times = times
        self.samples = np.full((times.size, 1 + count, 4), np.nan)
        self._result = np.empty(_CALL_COLUMNS)
        self._crossings = np.empty((_CROSSINGS, CROSSING_HEAD + 4 * count))
        self.derivatives = np.empty((count, 4))
        self.extremes = np.empty((EXTREMES, 1 + count))

    def advance(self, budget: int) -> Status:
        """Continue until the run has ended, `budget` steps have been taken or a buffer is full."""
        status = self._function(
            self._memory.ctypes.data,
            self._crossings.ctypes.data,
            _CROSSINGS,
            budget,
            self._result.ctypes.data,
            self.derivatives.ctypes.data,
            self.extremes.ctypes.data,
        )
        columns = self._result.tolist()
        self.outcome = outcome = RunColumns(*columns[:COLUMNS])
        count, ax, ay = columns[COLUMNS:]
        self.rate: State = (outcome.vx, ax, outcome.vy, ay)
        self.crossings = self._crossings[: int(count)]
        return Status(status)
