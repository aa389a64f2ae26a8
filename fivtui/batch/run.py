"""Compute many transients on all processor cores; memory does not grow with the horizon.

A member is one transient. Workers are threads, each of which computes chunks of members.
"""

import os
import threading
from collections.abc import Callable, Collection, Mapping
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import fields
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fivtui.kernel import Kernel, RunColumns, Status, load_kernel, why_interpreted
from fivtui.model import (
    ALL_PARAMETERS,
    BELT_PARAMETERS,
    PARAMETERS,
    InputError,
    OnProgress,
    Parameters,
    Progress,
    check_known,
    check_parameters,
)
from fivtui.taylor import local_tolerance, order_for
from fivtui.transient import (
    DEFAULT_T_END,
    DEFAULT_TOL,
    MAX_STEPS,
    check_horizon,
    check_max_steps,
    check_tolerance,
)

from .interpreted import Members, interpret_members, interpreted_starts
from .request import belt_rows, falling_friction, member_columns, separation_flags, start_states
from .result import ALLOCATORS, FAILURE_COLUMNS, Batch, Floats

Requirement = Literal["final", "amplitude", "peak", "steady", "events"]

REQUIREMENTS: Final = ("final", "amplitude", "peak", "steady", "events")

# Bounds of the number of members in a chunk. Chunks shrink towards the end of the batch, so that
# all workers finish at about the same time.
_LEAST_CHUNK, _GREATEST_CHUNK = 64, 1024
# Steps between two checks for cancellation, summed over the lanes of a SIMD vector. The kernel
# computes one member per lane.
_STEPS_PER_CHECK: Final = 10_000
# Interval between two calls of the progress callback, s.
_REPORT_S: Final = 0.02


def _no_op() -> None:
    pass


def simulate_batch(
    parameters: Mapping[str, ArrayLike] | ArrayLike,
    *,
    base: Parameters | None = None,
    t_end: float = DEFAULT_T_END,
    tol: float = DEFAULT_TOL,
    separation: ArrayLike = True,
    start: ArrayLike = "static",
    require: Collection[Requirement] = ("final", "peak", "steady", "events"),
    max_steps: int = MAX_STEPS,
    workers: int | None = None,
    progress: OnProgress | None = None,
) -> Batch:
    """Compute many transients with the compiled kernel, or in Python if there is none.

    Parameters
    ----------
    parameters : mapping of str to array_like, or array_like of shape (n, 9)
        The parameter sets, SI units: values by parameter name, broadcast against each other to
        one axis, other parameters from `base`; or nine columns in the order of `Parameters`.
    base : Parameters, optional
        Values of the parameters that a mapping does not name; the base set by default.
    t_end : float
        Horizon of all members, s; at most 1e7.
    tol : float
        Relative tolerance, 1e-13 to 1e-2; the manual's page "What a tolerance promises" says
        what errors it ensures.
    separation : bool or array_like of bool, shape (n,)
        Whether the slider may leave the belt (Case 1), or contact never breaks (Case 2).
    start : "static" or array_like of shape (4,) or (n, 4)
        At rest at the equilibrium of μ = 0, or (x, ẋ, y, ẏ) in m and m/s.
    require : collection of "final", "amplitude", "peak", "steady", "events"
        Results to compute. ``"amplitude"`` has only the extremes of y of ``"peak"`` and takes five
        sixths of the time.
    max_steps : int
        Steps after which a member is given up.
    workers : int, optional
        Number of threads, including the caller's; by default the number of processors.
    progress : callable, optional
        Called regularly with the completed fraction; if it returns False, the batch is cancelled.

    Returns
    -------
    Batch
        Each member has the same bits as a single run by the same kernel. Other members, their
        order, the number of workers and the required results have no effect on it. A member that
        cannot be finished raises no error: see `Batch.failure`.

    Raises
    ------
    InputError
        If the request is wrong.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import simulate_batch
    >>> batch = simulate_batch({"F": [60.0, 80.0, 100.0]}, require={"amplitude"})
    >>> [f"{y:.3f}" for y in batch.amplitude.y_abs]
    ['5.990', '10.503', '16.170']
    """
    base = Parameters() if base is None else check_parameters(base)
    table, size = member_columns(parameters, base)
    for name in require:
        check_known("requirement", name, REQUIREMENTS)
    if workers is not None and workers < 1:
        raise InputError(f"workers = {workers}: must be at least 1")
    batch_run = _BatchRun(
        table,
        size,
        separation=separation_flags(separation, size),
        start=start_states(start, size),
        t_end=check_horizon(t_end),
        tol=check_tolerance(tol),
        require=frozenset(require),
        max_steps=check_max_steps(max_steps),
    )
    kernel = load_kernel() if why_interpreted() is None else None
    batch_run.run(kernel, workers or os.cpu_count() or 1, Progress(progress))
    return batch_run.result()


class _BatchRun:
    # A batch while it runs: the checked arguments, the results so far, and the progress.

    def __init__(
        self,
        columns: dict[str, Floats],
        size: int,
        *,
        separation: NDArray[np.bool_],
        start: Floats | None,
        t_end: float,
        tol: float,
        require: frozenset[str],
        max_steps: int,
    ) -> None:
        self._columns, self._size = columns, size
        self._separation, self._start = separation, start
        self._t_end, self._tol, self._max_steps = t_end, tol, max_steps
        self._require = require

        self._status = np.empty(size, np.int8)
        self._t, self._steps = np.empty(size), np.empty(size, np.int64)
        self._parts = {name: make(size) for name, make in ALLOCATORS.items() if name in require}
        self._failures: list[Floats] = []
        # Guards the attributes below and `_failures`, which all workers change.
        self._lock = threading.Lock()
        # First member of the next chunk; computed members, with fractions of unfinished ones.
        self._next_member, self._computed_members = 0, 0.0
        self._stop = False

    def run(self, kernel: Kernel | None, workers: int, progress: Progress) -> None:
        """Compute all members."""
        workers = min(workers, -(-self._size // _LEAST_CHUNK))
        running: set[Future[None]] = set()

        def report() -> None:
            for future in running:
                if future.done():
                    # Raise the error of a worker.
                    future.result()
            progress.report(min(self._computed_members / self._size, 1.0))

        if workers > 0:
            report()
            pool = ThreadPoolExecutor(workers, thread_name_prefix="batch")
            try:
                # This thread is one of the workers.
                running |= {
                    pool.submit(self._worker, kernel, workers, _no_op) for _ in range(workers - 1)
                }
                self._worker(kernel, workers, report)
                while wait(running, timeout=_REPORT_S).not_done:
                    report()
                report()
            finally:
                self._stop = True
                pool.shutdown(cancel_futures=True)
        progress.advance(1.0)

    def _worker(self, kernel: Kernel | None, workers: int, report: Callable[[], None]) -> None:
        # A chunk has the remaining members over this divisor, within its bounds. A single worker
        # needs no small chunks at the end.
        divisor = 1 if workers == 1 else 2 * workers
        while not self._stop:
            with self._lock:
                first = self._next_member
                share = (self._size - first) // divisor
                stop = first + min(max(share, _LEAST_CHUNK), _GREATEST_CHUNK)
                self._next_member = stop = min(stop, self._size)
            if first == stop:
                return
            self._compute(kernel, slice(first, stop), report)

    def _compute(self, kernel: Kernel | None, chunk: slice, report: Callable[[], None]) -> None:
        columns = {name: column[chunk] for name, column in self._columns.items()}
        parameters = np.column_stack([columns[name] for name in PARAMETERS])
        belt = belt_rows(columns)
        separation = np.array(self._separation[chunk])
        if self._start is not None:
            start = np.array(self._start[chunk])
        elif kernel is None:
            start = interpreted_starts(parameters, separation)
        else:
            start = kernel.static_starts(parameters, separation)
        members = Members(parameters, separation, start)
        if kernel is None:
            results = self._interpret(members, columns, report)
        else:
            results = np.empty((len(parameters), len(RunColumns._fields)))
            # Group members by code path of the kernel: linear or cubic springs, with or without a
            # friction law.
            code_paths = (columns["k_nl"] > 0.0).astype(int)
            if belt is not None:
                code_paths += 2 * falling_friction(belt)
            for code_path in np.unique(code_paths):
                rows = np.flatnonzero(code_paths == code_path)
                subset = Members(parameters[rows], separation[rows], start[rows])
                subset_belts = None if belt is None else belt[rows]
                results[rows] = self._integrate(kernel, subset, subset_belts, report)
                if self._stop:
                    return
        if not self._stop:
            self._store(RunColumns(*results.T), chunk)

    def _integrate(
        self, kernel: Kernel, members: Members, belt: Floats | None, report: Callable[[], None]
    ) -> Floats:
        # Limit of the error of a step; the interpreter derives it from the tolerance itself.
        step_tol = local_tolerance(self._tol)
        has_friction_law = belt is not None and bool(falling_friction(belt).any())
        peak, steady = "peak" in self._require, "steady" in self._require
        kernel_work = kernel.begin_batch(
            **members._asdict(),
            t_end=self._t_end,
            tol=step_tol,
            order=order_for(step_tol, by_law=has_friction_law),
            max_steps=self._max_steps,
            observed=(peak or "amplitude" in self._require, peak, steady),
            belts=belt,
        )
        counted = 0.0
        while not kernel_work.done and not self._stop:
            computed = kernel_work.advance(_STEPS_PER_CHECK)
            with self._lock:
                self._computed_members += computed - counted
            counted = computed
            report()
        return kernel_work.results

    def _interpret(
        self, members: Members, columns: dict[str, Floats], report: Callable[[], None]
    ) -> Floats:
        # As `_integrate`, without a kernel.
        def proceed() -> bool:
            with self._lock:
                self._computed_members += 1.0
            report()
            return not self._stop

        belt = {name: column for name, column in columns.items() if name in BELT_PARAMETERS}
        return interpret_members(
            members, self._t_end, self._tol, self._max_steps, belt_columns=belt, proceed=proceed
        )

    def _column(self, name: str) -> Floats:
        # NaN for a parameter that the batch does not use.
        return self._columns.get(name, np.broadcast_to(np.nan, self._size))

    def _store(self, results: Any, chunk: slice) -> None:
        # Copy the results of a chunk into the arrays of the batch.
        status = results.status.astype(np.int8)
        state = np.column_stack([results.x, results.vx, results.y, results.vy])
        has_no_start = (results.steps == 0.0) & ~np.isfinite(state).all(axis=1)
        status[has_no_start] = Status.NO_START
        failed = status != Status.DONE
        self._status[chunk], self._t[chunk], self._steps[chunk] = (status, results.t, results.steps)
        if failed.any():
            rows = np.flatnonzero(failed)
            failures = np.column_stack(
                [
                    rows + chunk.start,
                    state[rows],
                    self._separation[chunk][rows],
                    *(self._column(name)[chunk][rows] for name in ALL_PARAMETERS),
                ]
            )
            with self._lock:
                self._failures.append(failures)

        def fill(target: NDArray[Any], value: Floats, failed_value: float = np.nan) -> None:
            target[chunk] = value
            target[chunk][failed] = failed_value

        values = {
            **results._asdict(),
            # Adding 0 makes −0 a 0.
            "y_abs": np.maximum(results.y_max, -results.y_min) + 0.0,
            "x_abs": np.maximum(results.x_max, -results.x_min) + 0.0,
            "y_half_range": 0.5 * (results.second_half_max - results.second_half_min),
        }
        for name, part in self._parts.items():
            if name == "final":
                fill(part, state)
                continue
            for column in fields(part):
                target = getattr(part, column.name)
                fill(target, values[column.name], -1 if target.dtype == np.int64 else np.nan)

    def result(self) -> Batch:
        """The result of the batch."""
        failures = np.concatenate([np.empty((0, len(FAILURE_COLUMNS))), *self._failures])
        return Batch(
            t_end=self._t_end,
            tol=self._tol,
            status=self._status,
            t=self._t,
            steps=self._steps,
            _parts=self._parts,
            _failures=failures[np.argsort(failures[:, FAILURE_COLUMNS.index("member")])],
        )
