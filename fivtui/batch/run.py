"""Many transients at once, on all processor cores; memory does not grow with the horizon."""

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

from .interpreted import Members, interpreted_results, interpreted_starts
from .request import belts, columns, flags, starts
from .result import PARTS, Batch, Floats

Requirement = Literal["final", "amplitude", "peak", "steady", "events"]

REQUIREMENTS: Final = ("final", "amplitude", "peak", "steady", "events")

# Bounds of the members a worker takes at a time, a share of the rest so that all end together.
_LEAST_CHUNK, _GREATEST_CHUNK = 64, 1024
# Steps of all lanes of a worker between two checks for a stop.
_BUDGET: Final = 10_000
# Interval between two calls of the progress callback, s.
_REPORT_S: Final = 0.02


def _nothing() -> None:
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
    """Compute many transients with the compiled kernel, or interpreted where there is none.

    Parameters
    ----------
    parameters : mapping of str to array_like, or array_like of shape (n, 9)
        The parameter sets, SI units: values by parameter name, broadcast against each other to
        one axis, other parameters from `base`; or nine columns in the order of `Parameters`.
    base : Parameters, optional
        Values of the parameters that a mapping does not name; the base set by default.
    t_end : float
        Horizon of all, s; at most 1e7.
    tol : float
        Relative tolerance, 1e-13 to 1e-2; ``examples/trust.md`` says what errors it ensures.
    separation : bool or array_like of bool, shape (n,)
        Whether separation is considered (the paper's Case 1) or ignored (Case 2).
    start : "static" or array_like of shape (4,) or (n, 4)
        At rest at the equilibrium of μ = 0, or (x, ẋ, y, ẏ) in m and m/s.
    require : collection of "final", "amplitude", "peak", "steady", "events"
        Results to compute. ``"amplitude"`` has the extremes of y in ``"peak"`` alone, in five
        sixths of the time.
    max_steps : int
        Steps after which a member is given up.
    workers : int, optional
        Number of threads, including the caller's; by default the number of processors.
    progress : callable, optional
        Called at intervals with the fraction done; the batch is cancelled when it returns False.

    Returns
    -------
    Batch
        Each member has the same bits as the single run by the same kernel, for any other members,
        order, number of workers and required results.

    Raises
    ------
    InputError
        If the request is wrong.
    ComputationError
        Not raised for a member that cannot be finished: see `Batch.failure`.
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
    table, size = columns(parameters, base)
    for name in require:
        check_known("requirement", name, REQUIREMENTS)
    if workers is not None and workers < 1:
        raise InputError(f"workers = {workers}: must be at least 1")
    work = _Work(
        table,
        size,
        separation=flags(separation, size),
        start=starts(start, size),
        t_end=check_horizon(t_end),
        tol=check_tolerance(tol),
        require=frozenset(require),
        max_steps=check_max_steps(max_steps),
    )
    kernel = load_kernel() if why_interpreted() is None else None
    work.run(kernel, workers or os.cpu_count() or 1, Progress(progress))
    return work.result()


class _Work:
    # A running batch: its checked request, its results so far, and its progress.

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
        self._parts = {name: empty(size) for name, empty in PARTS.items() if name in require}
        self._failures: list[Floats] = []
        self._lock = threading.Lock()
        self._next, self._progress_units = 0, 0.0
        self._stop = False

    def run(self, kernel: Kernel | None, workers: int, progress: Progress) -> None:
        """Compute all members."""
        workers = min(workers, -(-self._size // _LEAST_CHUNK))
        running: set[Future[None]] = set()

        def look() -> None:
            for future in running:
                if future.done():
                    future.result()
            progress.report(min(self._progress_units / self._size, 1.0))

        if workers > 0:
            look()
            pool = ThreadPoolExecutor(workers, thread_name_prefix="batch")
            try:
                # This thread is one of the workers.
                running |= {
                    pool.submit(self._worker, kernel, workers, _nothing) for _ in range(workers - 1)
                }
                self._worker(kernel, workers, look)
                while wait(running, timeout=_REPORT_S).not_done:
                    look()
                look()
            finally:
                self._stop = True
                pool.shutdown(cancel_futures=True)
        progress.advance(1.0)

    def _worker(self, kernel: Kernel | None, workers: int, look: Callable[[], None]) -> None:
        share = 1 if workers == 1 else 2 * workers
        while not self._stop:
            with self._lock:
                first = self._next
                chunk = (self._size - first) // share
                stop = first + min(max(chunk, _LEAST_CHUNK), _GREATEST_CHUNK)
                self._next = stop = min(stop, self._size)
            if first == stop:
                return
            self._compute(kernel, slice(first, stop), look)

    def _compute(self, kernel: Kernel | None, where: slice, look: Callable[[], None]) -> None:
        columns = {name: column[where] for name, column in self._columns.items()}
        parameters = np.column_stack([columns[name] for name in PARAMETERS])
        belt = belts(columns)
        separation = np.array(self._separation[where])
        if self._start is not None:
            start = np.array(self._start[where])
        elif kernel is None:
            start = interpreted_starts(parameters, separation)
        else:
            start = kernel.static_starts(parameters, separation)
        members = parameters, separation, start
        if kernel is None:
            results = self._interpret(members, columns, look)
        else:
            results = np.empty((len(parameters), len(RunColumns._fields)))
            # Group members by code path: linear springs cannot overflow in a square, and a friction
            # law has its own expansions.
            kinds = (columns["k_nl"] > 0.0).astype(int)
            if belt is not None:
                kinds += 2 * (belt[:, 2] > 0.0)
            for kind in np.unique(kinds):
                rows = np.flatnonzero(kinds == kind)
                subset = parameters[rows], separation[rows], start[rows]
                on = None if belt is None else belt[rows]
                results[rows] = self._advance(kernel, subset, on, look)
                if self._stop:
                    return
        if not self._stop:
            self._store(RunColumns(*results.T), where)

    def _advance(
        self, kernel: Kernel, members: Members, belt: Floats | None, look: Callable[[], None]
    ) -> Floats:
        parameters, separation, starts = members
        tol = local_tolerance(self._tol)
        peak, steady = "peak" in self._require, "steady" in self._require
        work = kernel.work(
            parameters=parameters,
            separation=separation,
            starts=starts,
            t_end=self._t_end,
            tol=tol,
            order=order_for(tol, by_law=belt is not None and bool((belt[:, 2] > 0.0).any())),
            max_steps=self._max_steps,
            observed=(peak or "amplitude" in self._require, peak, steady),
            belts=belt,
        )
        reported = 0.0
        while not work.done and not self._stop:
            advanced = work.advance(_BUDGET)
            with self._lock:
                self._progress_units += advanced - reported
            reported = advanced
            look()
        return work.results

    def _interpret(
        self, members: Members, columns: dict[str, Floats], look: Callable[[], None]
    ) -> Floats:
        def go_on() -> bool:
            with self._lock:
                self._progress_units += 1.0
            look()
            return not self._stop

        belt = {name: column for name, column in columns.items() if name in BELT_PARAMETERS}
        return interpreted_results(
            members, self._t_end, self._tol, self._max_steps, belt=belt, go_on=go_on
        )

    def _column(self, name: str) -> Floats:
        # NaN for a parameter that the members do not have.
        return self._columns.get(name, np.broadcast_to(np.nan, self._size))

    def _store(self, outcome: Any, where: slice) -> None:
        # Copy the results of a chunk into the arrays of the batch.
        status = outcome.status.astype(np.int8)
        state = np.column_stack([outcome.x, outcome.vx, outcome.y, outcome.vy])
        status[(outcome.steps == 0.0) & ~np.isfinite(state).all(axis=1)] = Status.NO_START
        failed = status != Status.DONE
        self._status[where], self._t[where], self._steps[where] = status, outcome.t, outcome.steps
        if failed.any():
            rows = np.flatnonzero(failed)
            failures = np.column_stack(
                [
                    rows + where.start,
                    state[rows],
                    self._separation[where][rows],
                    *(self._column(name)[where][rows] for name in ALL_PARAMETERS),
                ]
            )
            with self._lock:
                self._failures.append(failures)

        def store(target: NDArray[Any], value: Floats, missing: float = np.nan) -> None:
            target[where] = value
            target[where][failed] = missing

        values = {
            **outcome._asdict(),
            "y_abs": np.maximum(outcome.y_max, -outcome.y_min),
            "x_abs": np.maximum(outcome.x_max, -outcome.x_min),
            "y_half_range": 0.5 * (outcome.y_high - outcome.y_low),
            "separated_time": outcome.separated,
        }
        for name, part in self._parts.items():
            if name == "final":
                store(part, state)
                continue
            for column in fields(part):
                target = getattr(part, column.name)
                store(target, values[column.name], -1 if target.dtype == np.int64 else np.nan)

    def result(self) -> Batch:
        """The result of the batch."""
        failures = np.concatenate([np.empty((0, 6 + len(ALL_PARAMETERS))), *self._failures])
        return Batch(
            t_end=self._t_end,
            tol=self._tol,
            status=self._status,
            t=self._t,
            steps=self._steps,
            _parts=self._parts,
            _failures=failures[np.argsort(failures[:, 0])],
        )
