"""Run sweeps: in memory or into a file, on this machine or on a cluster.

The members of a sweep are computed in pieces, ranges of members, by an engine.
"""

import os
import threading
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import closing
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from fivtui.model import (
    Cancelled,
    ComputationError,
    InputError,
    OnProgress,
    Parameters,
    Progress,
    Rows as TimeTableRows,
    System,
    check_names,
    time_tables,
)
from fivtui.results import Plottable, Result, Table, Tabular, scene_text
from fivtui.transient import DEFAULT_T_END, DEFAULT_TOL, Start

from .design import Axis, Design, DesignKind
from .formats import sweep_format
from .pieces import SweepPiece, piece_count, sweep_piece
from .rows import Rows, all_failed_error, compute_rows, concatenate
from .scatter import Scatter
from .store import default_piece_size, open_store
from .study import BATCH_METHOD, DEFAULT_OUTPUTS, Study

if TYPE_CHECKING:
    from fivtui.charts import Sheet

# A function that computes pieces of a study and yields them in any order.
Engine = Callable[[Study, Iterable[SweepPiece]], Generator[tuple[SweepPiece, Rows]]]

MAX_IN_MEMORY: Final = 1_000_000
# Greatest number of members of a scattered sweep in memory; its rows are not printed.
_MAX_SCATTERED: Final = 20_000_000
# Number of columns in the summary of a sweep.
_SUMMARY_COLUMNS: Final = 8
# Least number of pieces of a sweep in memory, so that all threads have work.
_MIN_PIECES: Final = 32
# Pieces queued beyond those being computed.
_QUEUED_PIECES: Final = 1


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Sweep(Result, Tabular, Plottable):
    """A computed sweep.

    Attributes
    ----------
    study : Study
        The computed study.
    table : Rows
        Its rows by column.
    provenance : dict or None
        Provenance in the file that the sweep was read from; None if it was computed.
    """

    study: Study
    table: Rows
    provenance: dict[str, Any] | None = None

    @property
    def columns(self) -> list[str]:
        """Names of the columns."""
        return [column.name for column in self.study.columns]

    @property
    def rows(self) -> list[list[Any]]:
        """Rows of plain values in the order of `columns`; None where a member has no value."""
        values = [self.table.values(column) for column in self.study.columns]
        return [list(row) for row in zip(*values, strict=True)]

    def _summary(self) -> list[tuple[str, str]]:
        study, table = self.study, self.table
        axes = study.design.axes
        varied = (*axes, *dict(study.over_time))
        scene = scene_text(System(study.parameters, any(study.cases)), without=varied)
        rows = [
            ("scene", scene),
            *((f"{name} over time", values.describe(name)) for name, values in study.over_time),
            ("design", study.design.kind),
            ("members", f"{table.members}, {table.failed} failed"),
        ]
        columns = [column for column in study.columns if column.name in table.numbers]
        for column in columns[:_SUMMARY_COLUMNS]:
            values = table.numbers[column.name][~np.isnan(table.numbers[column.name])]
            if not values.size:
                text = "none"
            elif column.kind == "truth":
                text = f"{np.count_nonzero(values)} of {values.size}"
            else:
                text = f"{values.min():.6g} to {values.max():.6g} {column.unit}".rstrip()
            rows.append((column.name, text))
        if len(columns) > _SUMMARY_COLUMNS:
            rows.append(("and", f"{len(columns) - _SUMMARY_COLUMNS} more columns"))
        return rows

    def fast_belt(self, case: bool) -> int | None:
        """Row of the least belt speed from which on the slider never reaches the belt's speed.

        `case` is whether separation is considered. The motion in that row is the same as without
        `v_belt`. None if there is no such row, or friction depends on the sliding speed.
        """
        study, numbers = self.study, self.table.numbers
        if list(study.design.axes) != ["v_belt"] or study.parameters.speed_law is not None:
            return None
        # The greatest velocity of the slider.
        if "vx_max" not in numbers:
            return None
        speeds, peak_velocities = numbers["v_belt"], numbers["vx_max"]
        rows = np.flatnonzero(self.table.separation == case)
        by_falling_speed = rows[np.argsort(-speeds[rows], kind="stable")]
        is_faster = speeds[by_falling_speed] > peak_velocities[by_falling_speed]
        # Number of rows before the first belt that is not faster.
        count = int(np.cumprod(is_faster).sum())
        return int(by_falling_speed[count - 1]) if count else None

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui sweep --json`` prints: ``columns`` and ``rows``."""
        return {"columns": self.columns, "rows": self.rows}

    def _table(self) -> Table:
        return {column: self.table.array(column) for column in self.study.columns}

    def _sheet(self) -> "Sheet":
        from .charts import sweep_sheet

        return sweep_sheet(self)


@dataclass(frozen=True, slots=True)
class WriteSummary:
    """Counts of members of a written sweep; `failed` is None if the file was already complete.

    `reason` is why the first of the computed members that failed did so; empty if none failed.
    """

    members: int
    failed: int | None
    stored_before: int
    reason: str = field(default="", compare=False)

    @property
    def failure(self) -> ComputationError | None:
        """The error of a sweep whose members all failed; None if not all did."""
        if self.failed != self.members:
            return None
        return all_failed_error(self.members, self.reason or "see the column reason of the file")

    def __str__(self) -> str:
        if self.failed is None:
            return f"{self.members} members, complete before"
        text = f"{self.members} members"
        if self.stored_before:
            text += f", {self.stored_before} of them computed before"
        return f"{text}, {self.failed} failed" if self.failed else text


def sweep(
    parameters: Parameters | None = None,
    *,
    vary: Mapping[str, Axis | Sequence[float]],
    design: DesignKind = "product",
    count: int | None = None,
    seed: int | None = None,
    starts: int | None = None,
    separation: bool | Literal["both"] = True,
    start: Start = "static",
    t_end: float = DEFAULT_T_END,
    tol: float = DEFAULT_TOL,
    accuracy: Mapping[str, float] = MappingProxyType({}),
    outputs: Sequence[str] = DEFAULT_OUTPUTS,
    method: str = BATCH_METHOD,
    over_time: Mapping[str, TimeTableRows] | None = None,
    progress: OnProgress | None = None,
    workers: int | None = None,
) -> Sweep:
    """Compute many transients and keep their rows in memory.

    Parameters
    ----------
    parameters : Parameters, optional
        The parameters that do not vary; the base set by default.
    vary : mapping of str to Range or sequence of float
        Values by name: parameters, and ``x0``, ``vx0``, ``y0``, ``vy0`` of the start.
    design : "product", "list", "random" or "sobol"
        Kind of design, see `Design`.
    count, seed : int, optional
        Number of points and seed of a random or Sobol design.
    starts : int, optional
        Number of random starts around the equilibrium of every member, see `Design`: adds
        ``vibrates``, the share that ends in vibration, the ends of its 95 % interval and the number
        of undecided starts. Other outputs are those of `start`.
    separation : bool or "both"
        Whether separation is considered; "both" gives two members per point.
    start, t_end, tol
        As in `simulate`. A varied component of the start replaces that of `start`.
    accuracy : mapping of str to float
        Relative error targets of ``final``, ``peak``, ``half_range``, in place of `tol`: the
        tolerance is refined until a finer run confirms the targets, and the row has the errors.
    outputs : sequence of str
        Names in `fivtui.sweeps.study.OUTPUTS` to be computed.
    method : "taylor", "fmu" or "fmu-native"
        The Taylor integrator in batches, or runs of an FMU one by one.
    over_time : mapping of str to pairs of time and value, optional
        Values of parameters over time, in all members: as in `simulate`. These,
        like the outputs ``sticks``, ``stick_time`` and ``final_stick``, need single runs, which
        are slower than batches.
    progress : callable, optional
        Called with the fraction done; the sweep stops when it returns False.
    workers : int, optional
        Number of threads; all processors by default.

    Returns
    -------
    Sweep
        A row for each member, in the order of the design. A member that cannot be computed has a
        reason instead of values.

    Raises
    ------
    InputError
        If an argument is wrong, or there are more than a million members: see `sweep_to_file`.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import sweep
    >>> sweep(vary={"F": [20.0, 80.0]}, outputs=["separations"]).rows
    [[20.0, True, 68, 'done', ''], [80.0, True, 74, 'done', '']]
    """
    study = Study(
        design=Design(dict(vary), design, count, seed, starts),  # type: ignore[arg-type]
        parameters=Parameters() if parameters is None else parameters,
        cases=(True, False) if separation == "both" else (separation,),
        start=start,
        t_end=t_end,
        tol=tol,
        accuracy=tuple(accuracy.items()),
        outputs=check_names("outputs", outputs),
        method=method,
        over_time=tuple(time_tables(over_time or {}).items()),
    )
    return sweep_in_memory(study, local_engine(workers), progress=progress)


def sweep_in_memory(study: Study, engine: Engine, *, progress: OnProgress | None = None) -> Sweep:
    """Compute a study of at most a million members with an engine, see `sweep`."""
    check_memory_limit(study)
    size = min(default_piece_size(study), max(study.members // _MIN_PIECES, 1))
    count = piece_count(study.members, size)
    rows_by_piece: dict[int, Rows] = {}
    monitor = Progress(progress)
    pieces = (sweep_piece(number, study.members, size) for number in range(count))
    with closing(engine(study, pieces)) as results:
        for piece, rows in results:
            rows_by_piece[piece.number] = rows
            monitor.report(len(rows_by_piece) / count)
    return Sweep(study, concatenate([rows_by_piece[number] for number in range(count)]))


def check_memory_limit(study: Study, members: int | None = None) -> None:
    """Raise `InputError` if a sweep, or `members` of it, is too large to be held in memory.

    The limit is a million members, 20 million if it is scattered.
    """
    count = study.members if members is None else members
    if isinstance(study.design, Scatter):
        if count > _MAX_SCATTERED:
            raise InputError(
                f"{count} members: must be at most {_MAX_SCATTERED}; take fewer samples, or no "
                "Sobol indices"
            )
    elif count > MAX_IN_MEMORY:
        raise InputError(
            f"{count} members: must be at most {MAX_IN_MEMORY} to be held in memory; "
            "write them to a file (--out), and draw and print parts of it"
        )


def load_sweep(study: Study, path: Path) -> Sweep:
    """Read the rows of a known study from its file."""
    return Sweep(study, sweep_format(path).read(path, study))


def sweep_to_file(
    study: Study,
    out: Path,
    engine: Engine,
    *,
    size: int | None = None,
    progress: OnProgress | None = None,
) -> WriteSummary:
    """Compute a sweep into a file with `size` members per piece, or continue one that was stopped.

    Rows are stored in pieces beside the file. After a stop the same call continues, and the file
    gets the same bytes as without the stop. A complete file is left unchanged.
    """
    with open_store(out, study, size=size) as store:
        if store.complete:
            return WriteSummary(study.members, None, study.members)
        stored_before, monitor = store.stored_members, Progress(progress)
        reasons: dict[int, str] = {}
        try:
            monitor.report(stored_before / study.members)
            with closing(engine(study, store.missing())) as results:
                for piece, rows in results:
                    store.write(piece, rows)
                    if rows.failed:
                        reasons[piece.number] = next(filter(None, rows.reasons))
                    monitor.report(store.stored_members / study.members)
            failed = store.failed
            store.finish()
        except (Cancelled, KeyboardInterrupt):
            raise Cancelled(store.advice) from None
        reason = reasons[min(reasons)] if reasons else ""
        return WriteSummary(study.members, failed, stored_before, reason)


def local_engine(workers: int | None = None) -> Engine:
    """An engine of `workers` threads, all processors by default; the kernel releases the GIL."""
    if workers is not None and workers < 1:
        raise InputError(f"workers = {workers}: must be at least 1")
    threads = workers or _processor_count()

    def engine(study: Study, pieces: Iterable[SweepPiece]) -> Generator[tuple[SweepPiece, Rows]]:
        stopped = threading.Event()

        def compute(piece: SweepPiece) -> tuple[SweepPiece, Rows]:
            return piece, compute_rows(
                study, piece.first, piece.stop, lambda _fraction: not stopped.is_set()
            )

        pending = iter(pieces)
        with ThreadPoolExecutor(threads, thread_name_prefix="sweep") as pool:
            try:
                running: set[Future[tuple[SweepPiece, Rows]]] = set()
                while True:
                    slots = threads + _QUEUED_PIECES - len(running)
                    running |= {pool.submit(compute, piece) for piece in islice(pending, slots)}
                    if not running:
                        return
                    completed, running = wait(running, return_when=FIRST_COMPLETED)
                    results = [future.result() for future in completed]
                    yield from sorted(results, key=lambda result: result[0].number)
            finally:
                stopped.set()

    return engine


def _processor_count() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
