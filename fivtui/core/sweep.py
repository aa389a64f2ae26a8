"""Sweeps: many transients that differ in parameters, start and physics, as rows of numbers."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal, cast

import numpy as np
from numpy.typing import NDArray

from .batch import Requirement, simulate_batch
from .batch_result import Batch, BatchAmplitude, BatchPeak
from .design import VARIABLES, Design
from .errors import Cancelled, ComputationError, InputError
from .parameters import PARAMETERS, Parameters, unknown_name
from .request import (
    DEFAULT_T_END,
    DEFAULT_TOL,
    START_SPECS,
    Start,
    make_problem,
    resolve_start,
)
from .stability_points import judge_growths
from .transient import Progress

ColumnKind = Literal["number", "count", "truth", "text"]
Seen = Literal["peak", "amplitude"]
DONE: Final = "done"
FAILED: Final = "failed"


@dataclass(frozen=True, slots=True)
class SweepColumn:
    """A column of a sweep's rows.

    Attributes
    ----------
    name : str
        Its name.
    unit : str
        SI unit; empty where there is none.
    meaning : str
        One phrase.
    kind : "number", "count", "truth" or "text"
        What it holds.
    path : str
        Attribute of `Transient` that it is; empty if it is none.
    """

    name: str
    unit: str
    meaning: str
    kind: ColumnKind = "number"
    path: str = ""


_TRANSIENT: Final = (
    SweepColumn("y_abs", "m", "peak of |y|", path="peak.y_abs"),
    SweepColumn("y_max", "m", "greatest y", path="peak.y_max"),
    SweepColumn("y_min", "m", "least y", path="peak.y_min"),
    SweepColumn("x_abs", "m", "peak of |x|", path="peak.x_abs"),
    SweepColumn("vx_max", "m/s", "least valid belt speed", path="peak.vx_max"),
    SweepColumn("y_half_range", "m", "half range of y, second half", path="steady.y_half_range"),
    SweepColumn("P_min", "N", "least contact force", path="contact_force.min"),
    SweepColumn("P_max", "N", "greatest contact force", path="contact_force.max"),
    SweepColumn("separations", "", "number of separations", "count", "events.separations"),
    SweepColumn("reattachments", "", "number of reattachments", "count", "events.reattachments"),
    SweepColumn("separated_time", "s", "time off the belt", path="events.separated_time"),
    SweepColumn("x_end", "m", "horizontal displacement at the end", path="final.x"),
    SweepColumn("vx_end", "m/s", "horizontal velocity at the end", path="final.vx"),
    SweepColumn("y_end", "m", "vertical displacement at the end", path="final.y"),
    SweepColumn("vy_end", "m/s", "vertical velocity at the end", path="final.vy"),
)
_STABILITY: Final = (
    SweepColumn("growth_rate", "1/s", "greatest real part of the eigenvalues"),
    SweepColumn("stable", "", "whether the equilibrium is stable", "truth"),
)
OUTPUTS: Final[Mapping[str, SweepColumn]] = {
    column.name: column for column in (*_TRANSIENT, *_STABILITY)
}
DEFAULT_OUTPUTS: Final = tuple(column.name for column in _TRANSIENT)

_STATE: Final = ("x", "vx", "y", "vy")
_NOT_OF_Y: Final = ("x_abs", "vx_max")
_FORCE: Final = "contact_force"
# Between two looks at a cancellation.
_JUDGED: Final = 8192
_FORCE_OVERFLOW: Final = (
    "the contact force grows out of the range of numbers; consider separation or a shorter horizon"
)

_SEPARATION: Final = SweepColumn("separation", "", "whether separation is considered", "truth")
_ENDING: Final = (
    SweepColumn("status", "", f"{DONE} or {FAILED}", "text"),
    SweepColumn("reason", "", "why a member failed", "text"),
)


@dataclass(frozen=True, slots=True)
class Study:
    """A sweep to be computed: a scene, what varies in it, and what is asked of every member.

    Parameters
    ----------
    design : Design
        What varies. A component of the start that varies replaces that component of `start`.
    parameters : Parameters
        The other parameters.
    cases : tuple of bool
        Whether separation is considered; with ``(True, False)`` every point is two members, which
        stand together.
    start, t_end, tol
        As in `integrate`.
    outputs : tuple of str
        Names in `OUTPUTS`. Without an output of the transient nothing is integrated.

    Raises
    ------
    InputError
        If a value is not allowed.
    """

    design: Design
    parameters: Parameters
    cases: tuple[bool, ...] = (True,)
    start: Start = "static"
    t_end: float = DEFAULT_T_END
    tol: float = DEFAULT_TOL
    outputs: tuple[str, ...] = DEFAULT_OUTPUTS

    def __post_init__(self) -> None:
        if not 1 <= len(set(self.cases)) == len(self.cases):
            raise InputError(f"cases = {self.cases}: allowed are True, False, or both")
        for name in self.outputs:
            if name not in OUTPUTS:
                raise unknown_name("output", name, OUTPUTS)
        if not 1 <= len(set(self.outputs)) == len(self.outputs):
            raise InputError("outputs: allowed are one or more names, each once")
        static = isinstance(self.start, str) and self.start == "static"
        problem = make_problem(
            self.parameters,
            t_end=self.t_end,
            tol=self.tol,
            start=(0.0, 0.0, 0.0, 0.0) if static else self.start,
        )
        object.__setattr__(self, "t_end", problem.t_end)
        object.__setattr__(self, "tol", problem.tol)
        if not static:
            object.__setattr__(self, "start", problem.start)

    @property
    def members(self) -> int:
        """How many members there are."""
        return self.design.size * len(self.cases)

    @property
    def columns(self) -> tuple[SweepColumn, ...]:
        """The columns of a row, in order."""
        varied = [
            SweepColumn(name, VARIABLES[name].unit, VARIABLES[name].meaning)
            for name in self.design.axes
        ]
        outputs = [OUTPUTS[name] for name in self.outputs]
        return (*varied, _SEPARATION, *outputs, *_ENDING)


@dataclass(frozen=True, slots=True)
class Rows:
    """Rows of a sweep, by column.

    Attributes
    ----------
    numbers : dict of str to ndarray, shape (n,)
        What varies and the outputs, in order; NaN where a member has no such value.
    separation : ndarray of bool, shape (n,)
        Whether separation is considered.
    reasons : tuple of str
        Why members failed; empty for those that did not.
    """

    numbers: dict[str, NDArray[np.float64]]
    separation: NDArray[np.bool_]
    reasons: tuple[str, ...]

    @property
    def failed(self) -> int:
        """How many members failed."""
        return sum(map(bool, self.reasons))

    def values(self, column: SweepColumn) -> list[Any]:
        """A column as plain values.

        Parameters
        ----------
        column : SweepColumn
            One of `Study.columns`.

        Returns
        -------
        list
            Of float, int, bool or str, as the column's kind says; None where there is no value.
        """
        if column.name == "status":
            return [FAILED if reason else DONE for reason in self.reasons]
        if column.name == "reason":
            return list(self.reasons)
        if column.name == "separation":
            return [bool(value) for value in self.separation]
        convert = _CONVERSIONS[column.kind]
        numbers = self.numbers[column.name].tolist()
        return [convert(value) if value == value else None for value in numbers]  # noqa: PLR0124


_CONVERSIONS: Final[Mapping[str, Callable[[float], object]]] = {
    "number": float,
    "count": int,
    "truth": bool,
}


def joined(parts: list[Rows]) -> Rows:
    """Rows one after the other.

    Parameters
    ----------
    parts : list of Rows
        One or more, of the same study.

    Returns
    -------
    Rows
        All of them.
    """
    return Rows(
        {name: np.concatenate([part.numbers[name] for part in parts]) for name in parts[0].numbers},
        np.concatenate([part.separation for part in parts]),
        tuple(reason for part in parts for reason in part.reasons),
    )


def compute_rows(study: Study, first: int, last: int, progress: Progress | None = None) -> Rows:
    """Compute some members of a sweep.

    The compiled kernel computes all of them, so that a row does not depend on what was computed
    before it.

    Parameters
    ----------
    study : Study
        The sweep.
    first, last : int
        The members from `first` up to, not including, `last`.
    progress : callable, optional
        Called now and then; the computation is cancelled when it returns False.

    Returns
    -------
    Rows
        A row a member; one that cannot be computed has a reason, and not the values that failed.

    Raises
    ------
    Cancelled
        If `progress` returned False.
    ComputationError
        If the compiled kernel cannot be loaded.
    """
    members = np.arange(first, last, dtype=np.int64)
    points, case = np.divmod(members, len(study.cases))
    block = _Block(
        study,
        varied=study.design.columns(points),
        separation=np.array(study.cases)[case],
        results={name: np.full(members.size, np.nan) for name in study.outputs},
        reasons=[""] * members.size,
    )
    if any(column.name in study.outputs for column in _TRANSIENT):
        block.integrate(progress)
    if any(column.name in study.outputs for column in _STABILITY):
        block.judge(progress)
    return Rows({**block.varied, **block.results}, block.separation, tuple(block.reasons))


@dataclass(frozen=True, slots=True)
class _Block:
    # Members that are computed together; their results and reasons are filled in.
    study: Study
    varied: dict[str, NDArray[np.float64]]
    separation: NDArray[np.bool_]
    results: dict[str, NDArray[np.float64]]
    reasons: list[str]

    def parameters(self, place: int) -> Parameters:
        values = {name: float(c[place]) for name, c in self.varied.items() if name in PARAMETERS}
        return self.study.parameters.with_values(values)

    def integrate(self, progress: Progress | None) -> None:
        study = self.study
        wanted = [column for column in _TRANSIENT if column.name in study.outputs]
        start = self._start()
        places = np.flatnonzero([not reason for reason in self.reasons])
        if places.size == 0:
            return
        parameters = {name: c[places] for name, c in self.varied.items() if name in PARAMETERS}
        # Extremes of y alone cost less than all.
        seen: Seen = "peak" if any(name in study.outputs for name in _NOT_OF_Y) else "amplitude"
        # Without a parameter that varies the size of the batch has to be said by one.
        parameters.setdefault("F", np.full(places.size, study.parameters.F))
        batch = simulate_batch(
            parameters,
            base=study.parameters,
            t_end=study.t_end,
            tol=study.tol,
            separation=self.separation[places],
            start=start if isinstance(start, str) else start[places],
            require={_part(column, seen) for column in wanted},
            workers=1,
            progress=progress,
        )
        for place in batch.failed.tolist():
            self.reasons[places[place]] = str(batch.failure(place))
        for column in wanted:
            if not column.path.startswith(_FORCE):
                self.results[column.name][places] = _found(batch, column, seen)
        if any(column.path.startswith(_FORCE) for column in wanted):
            self._put_forces(places, getattr(batch, seen))
        for column in wanted:
            self.results[column.name][[bool(reason) for reason in self.reasons]] = np.nan

    def _start(self) -> Literal["static"] | NDArray[np.float64]:
        # Components of the start that do not vary may be those of an equilibrium.
        given = [self.varied.get(name) for name in START_SPECS]
        start, size = self.study.start, len(self.reasons)
        static = isinstance(start, str)
        if static and all(column is None for column in given):
            return "static"
        states = np.zeros((size, 4))
        if static and any(column is None for column in given):
            for place, separation in enumerate(self.separation.tolist()):
                try:
                    p = self.parameters(place)
                    states[place] = resolve_start(p, start, separation=separation)
                except ComputationError as error:
                    self.reasons[place] = str(error)
        elif not static:
            states[:] = start
        for target, column in zip(states.T, given, strict=True):
            if column is not None:
                target[:] = column
        return states

    def _put_forces(self, places: NDArray[np.int64], extremes: BatchPeak | BatchAmplitude) -> None:
        # P decreases with y, so its extremes are those of y, except that it ends at zero.
        k2, k_nl = (
            self.varied.get(name, np.full(len(self.reasons), getattr(self.study.parameters, name)))
            for name in ("k2", "k_nl")
        )
        for name, extreme in (("P_min", "y_max"), ("P_max", "y_min")):
            if name not in self.results:
                continue
            y = getattr(extremes, extreme)
            y = np.where(self.separation[places], np.minimum(y, 0.0), y)
            with np.errstate(over="ignore", invalid="ignore"):
                force = -k2[places] * y - k_nl[places] * y * y * y + 0.0
            self.results[name][places] = force
            for place in places[np.isinf(force)].tolist():
                self.reasons[place] = self.reasons[place] or _FORCE_OVERFLOW

    def judge(self, progress: Progress | None) -> None:
        parameters = {name: c for name, c in self.varied.items() if name in PARAMETERS}
        size = len(self.reasons)
        for first in range(0, size, _JUDGED):
            if progress is not None and not progress(first / size):
                raise Cancelled
            some = slice(first, first + _JUDGED)
            growth, stable, reasons = judge_growths(
                self.study.parameters,
                {name: column[some] for name, column in parameters.items()},
                self.separation[some],
            )
            for place, reason in reasons.items():
                self.reasons[first + place] = self.reasons[first + place] or reason
            verdicts = np.where(np.isnan(growth), np.nan, stable)
            for name, values in (("growth_rate", growth), ("stable", verdicts)):
                if name in self.results:
                    self.results[name][some] = values


def _part(column: SweepColumn, seen: Seen) -> Requirement:
    # The part of a batch's result that a column comes from.
    part = column.path.split(".", maxsplit=1)[0]
    return seen if part in ("peak", _FORCE) else cast("Requirement", part)


def _found(batch: Batch, column: SweepColumn, seen: Seen) -> NDArray[np.float64]:
    part, name = getattr(batch, _part(column, seen)), column.path.rsplit(".", maxsplit=1)[-1]
    found = part[:, _STATE.index(name)] if name in _STATE else getattr(part, name)
    return np.asarray(found, dtype=np.float64)
