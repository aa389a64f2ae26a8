"""Sweeps run: in memory or into a file, on this machine or on a cluster."""

import os
import threading
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import closing
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Cancelled, InputError, Parameters
from fivtui.results import Result, scene_text
from fivtui.transient import DEFAULT_T_END, DEFAULT_TOL, Progress, Start

from .design import Axis, Design, Kind
from .formats import sweep_format
from .pieces import Piece, piece_count, piece_of
from .rows import Rows, compute_rows, joined
from .store import default_piece_size, open_store
from .study import DEFAULT_OUTPUTS, Study

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Computes pieces of a study, in any order.
Engine = Callable[[Study, Iterable[Piece]], Generator[tuple[Piece, Rows]]]
Cases = Literal["considered", "ignored", "both"]

CASES: Final[Mapping[Cases, tuple[bool, ...]]] = {
    "considered": (True,),
    "ignored": (False,),
    "both": (True, False),
}
MAX_IN_MEMORY: Final = 1_000_000
# Columns of which a session is told when a sweep is printed.
_SHOWN: Final = 8
# At least this many pieces, so that all threads have some.
_PIECES_IN_MEMORY: Final = 32
# Pieces handed out ahead of those that are being computed, a worker each.
_AHEAD: Final = 1


@dataclass(frozen=True, slots=True, repr=False)
class Sweep(Result):
    """A computed sweep.

    Attributes
    ----------
    study : Study
        What was computed.
    table : Rows
        Its rows by column.
    said : dict or None
        What the file says of its making from which it was read; None if it was computed here.
    """

    study: Study
    table: Rows
    said: dict[str, Any] | None = None

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
        scene = scene_text(study.parameters, separation=any(study.cases), without=tuple(axes))
        rows = [
            ("scene", scene),
            ("design", study.design.kind),
            ("members", f"{len(table.reasons)}, {table.failed} failed"),
        ]
        columns = [column for column in study.columns if column.name in table.numbers]
        for column in columns[:_SHOWN]:
            values = table.numbers[column.name][~np.isnan(table.numbers[column.name])]
            if not values.size:
                text = "none"
            elif column.kind == "truth":
                text = f"{np.count_nonzero(values)} of {values.size}"
            else:
                text = f"{values.min():.6g} to {values.max():.6g} {column.unit}".rstrip()
            rows.append((column.name, text))
        if len(columns) > _SHOWN:
            rows.append(("and", f"{len(columns) - _SHOWN} more columns"))
        return rows

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui sweep --json`` prints: ``columns`` and ``rows``."""
        return {"columns": self.columns, "rows": self.rows}

    def to_columns(self) -> dict[str, NDArray[Any]]:
        """The columns as arrays; NaN where a member has no value."""
        return {column.name: self.table.array(column) for column in self.study.columns}

    def figure(self) -> "Figure":
        """Amplitudes over what varies, as a matplotlib figure.

        Raises
        ------
        InputError
            If other than one or two names vary.
        """
        from .figure import sweep_figure

        return sweep_figure(self)


@dataclass(frozen=True, slots=True)
class Written:
    """What became of a sweep that was written to a file.

    Attributes
    ----------
    members : int
        How many rows the file has.
    failed : int or None
        How many members failed; None if the file was complete before.
    kept : int
        How many members an earlier run had computed.
    """

    members: int
    failed: int | None
    kept: int

    def __str__(self) -> str:
        if self.failed is None:
            return f"{self.members} members, complete before"
        text = f"{self.members} members"
        if self.kept:
            text += f", {self.kept} of them computed before"
        return f"{text}, {self.failed} failed" if self.failed else text


def sweep(
    parameters: Parameters | None = None,
    *,
    vary: Mapping[str, Axis | Sequence[float]],
    design: Kind = "product",
    count: int | None = None,
    seed: int | None = None,
    separation: bool | Literal["both"] = True,
    start: Start = "static",
    t_end: float = DEFAULT_T_END,
    tol: float = DEFAULT_TOL,
    accuracy: Mapping[str, float] = MappingProxyType({}),
    outputs: Sequence[str] = DEFAULT_OUTPUTS,
    progress: Progress | None = None,
    workers: int | None = None,
) -> Sweep:
    """Compute many transients and keep their rows in memory.

    Parameters
    ----------
    parameters : Parameters, optional
        The parameters that do not vary; the base set if not given.
    vary : mapping of str to Range or sequence of float
        What varies: parameters, and ``x0``, ``vx0``, ``y0``, ``vy0`` of the start.
    design : "product", "list", "random" or "sobol"
        How the members are chosen, see `Design`; random and Sobol designs take ranges without
        count.
    count, seed : int, optional
        Number of points and seed of a random or Sobol design.
    separation : bool or "both"
        Whether separation is considered; with both every point is two members.
    start, t_end, tol
        As in `simulate`. A component of the start that varies replaces that of `start`.
    accuracy : mapping of str to float
        Errors allowed of ``final``, ``peak``, ``half_range``, relative: the tolerance follows,
        member by member, a finer run verifies it, and rows have the errors. Without it `tol` holds.
    outputs : sequence of str
        What is computed: names in `fivtui.sweeps.study.OUTPUTS`.
    progress : callable, optional
        Called now and then with the fraction done; the sweep is cancelled when it returns False.
    workers : int, optional
        Threads; as many as there are processors if not given.

    Returns
    -------
    Sweep
        A row a member, in the order of the design. A member that cannot be computed is a row with
        the reason.

    Raises
    ------
    InputError
        If the request is wrong, or has more than a million members: see `sweep_to_file`.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import sweep
    >>> sweep(vary={"F": [20.0, 80.0]}, outputs=["separations"]).rows
    [[20.0, True, 68, 'done', ''], [80.0, True, 74, 'done', '']]
    """
    study = Study(
        design=Design(dict(vary), design, count, seed),  # type: ignore[arg-type]
        parameters=Parameters() if parameters is None else parameters,
        cases=CASES["both"] if separation == "both" else (separation,),
        start=start,
        t_end=t_end,
        tol=tol,
        accuracy=tuple(accuracy.items()),
        outputs=tuple(outputs),
    )
    return sweep_in_memory(study, local_engine(workers), progress=progress)


def sweep_in_memory(study: Study, engine: Engine, *, progress: Progress | None = None) -> Sweep:
    """Compute a sweep and keep its rows in memory.

    Parameters
    ----------
    study : Study
        The sweep.
    engine : callable
        Computes its pieces.
    progress : callable, optional
        As in `sweep`.

    Returns
    -------
    Sweep
        A row a member.

    Raises
    ------
    InputError
        If it has more than a million members.
    Cancelled
        If `progress` returned False.
    """
    check_in_memory(study)
    size = min(default_piece_size(study), max(study.members // _PIECES_IN_MEMORY, 1))
    count = piece_count(study.members, size)
    parts: dict[int, Rows] = {}
    pieces = (piece_of(number, study.members, size) for number in range(count))
    with closing(engine(study, pieces)) as results:
        for piece, rows in results:
            parts[piece.number] = rows
            _report(progress, len(parts) / count)
    return Sweep(study, joined([parts[number] for number in range(count)]))


def check_in_memory(study: Study) -> None:
    """Check that the rows of a sweep can be held in memory.

    Parameters
    ----------
    study : Study
        The sweep.

    Raises
    ------
    InputError
        If it has more than a million members.
    """
    if study.members > MAX_IN_MEMORY:
        raise InputError(
            f"{study.members} members: must be at most {MAX_IN_MEMORY} to be held in memory; "
            "write them to a file (--out), and draw and print parts of it"
        )


def load_sweep(study: Study, path: Path) -> Sweep:
    """Read the rows of a sweep from the file that it was written to.

    Parameters
    ----------
    study : Study
        The sweep.
    path : Path
        Its file.

    Returns
    -------
    Sweep
        Its rows.
    """
    return Sweep(study, sweep_format(path).read(path, study))


def sweep_to_file(
    study: Study,
    out: Path,
    engine: Engine,
    *,
    size: int | None = None,
    force: bool = False,
    progress: Progress | None = None,
) -> Written:
    """Compute a sweep into a file, or go on with one that was stopped.

    Whatever stops it, what was computed is kept beside the file; called again with the same
    arguments it goes on, and the file is the same to the last bit as if nothing had happened. A
    file that is there and complete, all its rows counted, is left as it is.

    Parameters
    ----------
    study : Study
        The sweep.
    out : Path
        The file; its suffix ``.csv`` or ``.parquet`` says the format.
    engine : callable
        Computes its pieces.
    size : int, optional
        Members of a piece.
    force : bool
        Whether a file that exists may be replaced, and what is left of another sweep discarded.
    progress : callable, optional
        As in `sweep`.

    Returns
    -------
    Written
        How many members there are, have failed, and had been kept.

    Raises
    ------
    InputError
        If the file cannot be written, is there and damaged, another sweep was begun under its
        name, or this one on a machine whose rows differ in their last bits.
    ComputationError
        If a piece cannot be written or computed; what is written is kept.
    Cancelled
        If `progress` returned False, or by the keyboard; it says how to go on.
    """
    with open_store(out, study, size=size, force=force) as store:
        if store.complete:
            return Written(study.members, None, study.members)
        kept = store.kept
        try:
            _report(progress, kept / study.members)
            with closing(engine(study, store.missing())) as results:
                for piece, rows in results:
                    store.write(piece, rows)
                    _report(progress, store.kept / study.members)
            failed = store.failed
            store.finish()
        except (Cancelled, KeyboardInterrupt):
            raise Cancelled(store.advice) from None
        return Written(study.members, failed, kept)


def _report(progress: Progress | None, fraction: float) -> None:
    if progress is not None and not progress(fraction):
        raise Cancelled


def local_engine(workers: int | None = None) -> Engine:
    """An engine of threads: the compiled kernel leaves the interpreter to others.

    Parameters
    ----------
    workers : int, optional
        How many; as many as there are processors for this process if not given.

    Returns
    -------
    callable
        The engine.

    Raises
    ------
    InputError
        If the number is not positive.
    """
    if workers is not None and workers < 1:
        raise InputError(f"workers = {workers}: must be at least 1")
    threads = workers or _processors()

    def engine(study: Study, pieces: Iterable[Piece]) -> Generator[tuple[Piece, Rows]]:
        stopped = threading.Event()

        def compute(piece: Piece) -> tuple[Piece, Rows]:
            return piece, compute_rows(
                study, piece.first, piece.last, lambda _fraction: not stopped.is_set()
            )

        waiting = iter(pieces)
        with ThreadPoolExecutor(threads, thread_name_prefix="sweep") as pool:
            try:
                running: set[Future[tuple[Piece, Rows]]] = set()
                while True:
                    free = threads + _AHEAD - len(running)
                    running |= {pool.submit(compute, piece) for piece in islice(waiting, free)}
                    if not running:
                        return
                    done, running = wait(running, return_when=FIRST_COMPLETED)
                    for future in done:
                        yield future.result()
            finally:
                stopped.set()

    return engine


def _processors() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
