"""Rows of a sweep, computed in batches by the compiled kernel, or run by run."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, Final, Literal, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from fivtui.batch import Batch, Requirement, simulate_batch
from fivtui.equilibrium import critical_mus, judge_growths
from fivtui.model import (
    ALL_PARAMETERS,
    ComputationError,
    OnProgress,
    Parameters,
    Progress,
    System,
    spring_force,
)
from fivtui.safety import safe_mus
from fivtui.simulation import simulate
from fivtui.transient import (
    PARTED,
    START_SPECS,
    TOL_RANGE,
    finer_tol,
    first_tol,
    resolve_start,
)

from .study import (
    CRITICAL,
    DONE,
    ERRORS,
    FAILED,
    SAFE,
    STABILITY,
    STICK,
    TRANSIENT,
    Study,
    SweepColumn,
)

Places = NDArray[np.int64]
Floats = NDArray[np.float64]
Truths = NDArray[np.bool_]
BlockStart = Literal["static"] | Floats

_OF_RUNS: Final = (*TRANSIENT, *STICK)
_NOT_OF_Y: Final = ("x_abs", "vx_max")
_FORCE: Final = "contact_force"
# Parts of the run among which the one is found where two runs part.
_PARTS: Final = 8
# Members judged between two calls of `progress`.
_JUDGED: Final = 8192
_FORCE_OVERFLOW: Final = (
    "the contact force grows beyond the floating-point range; consider separation or a shorter run"
)


class _Springs(NamedTuple):
    # The contact springs of members.
    k2: Floats
    k_nl: Floats


@dataclass(frozen=True, slots=True)
class Rows:
    """Rows of a sweep, by column.

    Attributes
    ----------
    numbers : dict of str to ndarray, shape (n,)
        Varied values and outputs, in order; NaN where a member has no value.
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
        """Number of failed members."""
        return sum(map(bool, self.reasons))

    def part(self, first: int, last: int) -> "Rows":
        """The rows `first` to `last` - 1."""
        numbers = {name: values[first:last] for name, values in self.numbers.items()}
        return Rows(numbers, self.separation[first:last], self.reasons[first:last])

    def values(self, column: SweepColumn) -> list[Any]:
        """A column as plain float, int, bool or str; None where a member has no value."""
        if column.name == "status":
            return [FAILED if reason else DONE for reason in self.reasons]
        if column.name == "reason":
            return list(self.reasons)
        if column.name == "separation":
            return [bool(value) for value in self.separation]
        convert = _CONVERSIONS[column.kind]
        numbers = self.numbers[column.name].tolist()
        return [convert(value) if value == value else None for value in numbers]  # noqa: PLR0124

    def array(self, column: SweepColumn) -> NDArray[Any]:
        """A column as an array, NaN where a member has no value; counts are int if all have one."""
        if column.kind == "text" or column.name == "separation":
            return np.array(self.values(column))
        numbers = self.numbers[column.name]
        if column.kind == "number" or np.isnan(numbers).any():
            return numbers
        return numbers.astype(np.int64 if column.kind == "count" else np.bool_)


_CONVERSIONS: Final[Mapping[str, Callable[[float], object]]] = {
    "number": float,
    "count": int,
    "truth": bool,
}


def joined(parts: list[Rows]) -> Rows:
    """The rows of several parts of a study, one after the other."""
    return Rows(
        {name: np.concatenate([part.numbers[name] for part in parts]) for name in parts[0].numbers},
        np.concatenate([part.separation for part in parts]),
        tuple(reason for part in parts for reason in part.reasons),
    )


def compute_rows(study: Study, first: int, last: int, progress: OnProgress | None = None) -> Rows:
    """Compute members `first` to `last` - 1 of a sweep.

    A row never depends on what was computed before.
    """
    members = np.arange(first, last, dtype=np.int64)
    points, case = np.divmod(members, len(study.cases))
    block = _Block(
        study,
        varied=study.design.columns(points),
        separation=np.array(study.cases)[case],
        results={
            name: np.full(members.size, np.nan)
            for name in (*study.outputs, *(ERRORS[name].name for name, _ in study.accuracy))
        },
        reasons=[""] * members.size,
    )
    if study.accuracy or any(column.name in study.outputs for column in _OF_RUNS):
        block.integrate(progress)
    if any(column.name in study.outputs for column in STABILITY):
        block.judge(progress)
    if CRITICAL.name in study.outputs:
        block.find_critical(progress)
    if SAFE.name in study.outputs:
        block.find_safe(progress)
    return Rows({**block.varied, **block.results}, block.separation, tuple(block.reasons))


@dataclass(frozen=True, slots=True)
class _Block:
    # Members computed together; methods fill in `results` and `reasons`.
    study: Study
    varied: dict[str, NDArray[np.float64]]
    separation: NDArray[np.bool_]
    results: dict[str, NDArray[np.float64]]
    reasons: list[str]

    def parameters(self, place: int) -> Parameters:
        values = {
            name: float(c[place]) for name, c in self.varied.items() if name in ALL_PARAMETERS
        }
        return self.study.parameters.with_values(values)

    def integrate(self, progress: OnProgress | None) -> None:
        start = self._start()
        places = np.flatnonzero([not reason for reason in self.reasons])
        if self.study.is_in_turn:
            self._simulate(places, start, progress)
        elif self.study.accuracy:
            self._verify(places, start, progress or (lambda _fraction: True))
        elif places.size > 0:
            self._put(places, self._run(places, start, self.study.tol, progress))

    def _simulate(self, places: Places, start: BlockStart, progress: OnProgress | None) -> None:
        # Members one after the other: of more than batches know.
        study, wanted = self.study, {c.name: attrgetter(c.path) for c in self._wanted}
        for count, place in enumerate(places.tolist()):

            def look(fraction: float, done: int = count) -> bool:
                return progress is None or progress((done + fraction) / places.size)

            try:
                run = simulate(
                    self.parameters(place),
                    t_end=study.t_end,
                    tol=study.tol,
                    separation=bool(self.separation[place]),
                    start=start if isinstance(start, str) else start[place].tolist(),
                    method=study.method,
                    over_time=dict(study.over_time),
                    progress=look,
                )
            except ComputationError as error:
                self.reasons[place] = str(error)
            else:
                for name, value_of in wanted.items():
                    self.results[name][place] = value_of(run)

    def _verify(self, places: Places, start: BlockStart, progress: OnProgress) -> None:
        # As `verified.simulate_to` for each member: refine the tolerance until a run changes by
        # less than the error targets and does not part from the run before.
        asked, part = dict(self.study.accuracy), 0.0

        def look(fraction: float) -> bool:
            return progress(part + 0.5 * fraction)

        tol = first_tol(asked)
        if places.size > 0:
            coarse = _observed(self._run(places, start, tol, look))
        while places.size > 0:
            before, tol, part = tol, finer_tol(tol), 0.5
            batch = self._run(places, start, tol, look)
            fine = _observed(batch)
            errors = {name: _error(name, coarse, fine) for name in asked}
            missed = ~np.all([errors[name] <= asked[name] for name in asked], axis=0)
            parted = _parted(coarse, fine, self._time_scales(places))
            missed |= parted
            missed[batch.failed] = parted[batch.failed] = False
            if tol == TOL_RANGE[0]:
                for place in np.flatnonzero(missed & ~parted).tolist():
                    found = {name: float(error[place]) for name, error in errors.items()}
                    self.reasons[places[place]] = _too_inexact(found, asked)
                self._tell_when(places[parted], start, (before, tol), look)
                missed[:] = False
            for name, error in errors.items():
                self.results[ERRORS[name].name][places] = error
            self._put(places, batch)
            places, coarse = places[missed], {name: fine[name][missed] for name in fine}

    def _time_scales(self, places: Places) -> Floats:
        m, k1, k2, k3 = (
            self.varied.get(name, np.full(len(self.reasons), getattr(self.study.parameters, name)))
            for name in ("m", "k1", "k2", "k3")
        )
        scales: Floats = np.sqrt(m / (k1 + k2 + k3))[places]
        return scales

    def _tell_when(
        self, places: Places, start: BlockStart, tols: tuple[float, float], progress: OnProgress
    ) -> None:
        # Give members whose runs part the interval in which they do as their reason.
        for count in range(1, _PARTS + 1):
            if places.size == 0:
                return
            begin, end = ((n / _PARTS) * self.study.t_end for n in (count - 1, count))
            parted = np.ones(places.size, dtype=bool)
            if count < _PARTS:
                coarse, fine = (
                    _observed(self._run(places, start, tol, progress, end)) for tol in tols
                )
                parted = _parted(coarse, fine, self._time_scales(places))
            for place in places[parted].tolist():
                self.reasons[place] = (
                    f"two runs at different accuracy part between t = {begin:.6g} and {end:.6g} s; "
                    "nothing after that can be verified: take a shorter horizon"
                )
            places = places[~parted]

    def _run(
        self,
        places: Places,
        start: BlockStart,
        tol: float,
        progress: OnProgress | None,
        t_end: float | None = None,
    ) -> Batch:
        study = self.study
        parameters = {name: c[places] for name, c in self.varied.items() if name in ALL_PARAMETERS}
        # If no parameter varies, F gives the batch its size.
        parameters.setdefault("F", np.full(places.size, study.parameters.F))
        return simulate_batch(
            parameters,
            base=study.parameters,
            t_end=study.t_end if t_end is None else t_end,
            tol=tol,
            separation=self.separation[places],
            start=start if isinstance(start, str) else start[places],
            require=self._requirements(),
            workers=1,
            progress=progress,
        )

    def _requirements(self) -> set[Requirement]:
        accuracy = dict(self.study.accuracy)
        # Extremes of y alone take less time than all.
        extremes = "peak" if any(name in self.study.outputs for name in _NOT_OF_Y) else "amplitude"
        parts = {column.path.partition(".")[0] for column in self._wanted}
        required = {extremes if part in ("peak", _FORCE) else part for part in parts}
        if accuracy:
            # These tell whether two runs are the same motion.
            required |= {"final", "events", extremes}
        if "half_range" in accuracy:
            required.add("steady")
        return cast("set[Requirement]", required)

    @property
    def _wanted(self) -> list[SweepColumn]:
        return [column for column in _OF_RUNS if column.name in self.study.outputs]

    def _put(self, places: Places, batch: Batch) -> None:
        for place in batch.failed.tolist():
            self.reasons[places[place]] = str(batch.failure(place))
        wanted, columns = self._wanted, batch.to_columns()
        for column in wanted:
            if not column.path.startswith(_FORCE):
                self.results[column.name][places] = columns[column.name]
        self._put_forces(places, columns)
        failed = [bool(reason) for reason in self.reasons]
        for name in (*(c.name for c in wanted), *(ERRORS[n].name for n, _ in self.study.accuracy)):
            self.results[name][failed] = np.nan

    def _start(self) -> BlockStart:
        # Components that do not vary are those of the study's start, maybe an equilibrium.
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
                    states[place] = resolve_start(System(p, separation), start)
                except ComputationError as error:
                    self.reasons[place] = str(error)
        elif not static:
            states[:] = start
        for target, column in zip(states.T, given, strict=True):
            if column is not None:
                target[:] = column
        return states

    def _put_forces(self, places: Places, columns: Mapping[str, Floats]) -> None:
        # P decreases with y, so its extremes are at those of y; separated, P = 0.
        p, size = self.study.parameters, len(self.reasons)
        springs = _Springs(
            *(
                self.varied.get(name, np.full(size, getattr(p, name)))[places]
                for name in _Springs._fields
            )
        )
        for name, extreme in (("P_min", "y_max"), ("P_max", "y_min")):
            if name not in self.results:
                continue
            y = columns[extreme]
            y = np.where(self.separation[places], np.minimum(y, 0.0), y)
            with np.errstate(over="ignore", invalid="ignore"):
                force = spring_force(springs, y) + 0.0
            self.results[name][places] = force
            for place in places[np.isinf(force)].tolist():
                self.reasons[place] = self.reasons[place] or _FORCE_OVERFLOW

    def _parts(self, progress: OnProgress | None) -> Iterator[tuple[slice, dict[str, Floats]]]:
        # Some members after the other, with the parameters that vary.
        parameters = {name: c for name, c in self.varied.items() if name in ALL_PARAMETERS}
        size, work = len(self.reasons), Progress(progress)
        for first in range(0, size, _JUDGED):
            work.report(first / size)
            some = slice(first, first + _JUDGED)
            yield some, {name: column[some] for name, column in parameters.items()}

    def find_critical(self, progress: OnProgress | None) -> None:
        for some, parameters in self._parts(progress):
            self.results[CRITICAL.name][some] = critical_mus(
                self.study.parameters, parameters, self.separation[some]
            )

    def find_safe(self, progress: OnProgress | None) -> None:
        for some, parameters in self._parts(progress):
            given = self.study.parameters, parameters, self.separation[some]
            self.results[SAFE.name][some] = safe_mus(*given, self.study.safe, progress)

    def judge(self, progress: OnProgress | None) -> None:
        for some, parameters in self._parts(progress):
            growth, stable, reasons = judge_growths(
                self.study.parameters, parameters, self.separation[some]
            )
            for place, reason in reasons.items():
                self.reasons[some.start + place] = self.reasons[some.start + place] or reason
            verdicts = np.where(np.isnan(growth), np.nan, stable)
            for name, values in (("growth_rate", growth), ("stable", verdicts)):
                if name in self.results:
                    self.results[name][some] = values


def _observed(batch: Batch) -> dict[str, Floats]:
    # The quantities that two runs are compared by, members along the first axis.
    columns = batch.to_columns()
    return {
        "final": batch.final,
        "peak": columns["y_abs"],
        "switches": (columns["separations"] + columns["reattachments"]).astype(np.float64),
        **({"half_range": columns["y_half_range"]} if "y_half_range" in columns else {}),
    }


def _parted(run: Mapping[str, Floats], truth: Mapping[str, Floats], scales: Floats) -> Truths:
    # Whether two runs of the members are different motions, as in `divergence`.
    weights = np.stack([np.ones_like(scales), scales] * 2, axis=1)
    apart = (np.abs(run["final"] - truth["final"]) * weights).max(axis=1)
    size = np.maximum((np.abs(truth["final"]) * weights).max(axis=1), truth["peak"])
    parted: Truths = (run["switches"] != truth["switches"]) | ~(apart <= PARTED * size)
    return parted


def _error(quantity: str, run: Mapping[str, Floats], truth: Mapping[str, Floats]) -> Floats:
    # The measures of `deviation`.
    apart = np.abs(run[quantity] - truth[quantity])
    if quantity == "final":
        apart, size = apart.max(axis=1), np.abs(truth[quantity]).max(axis=1)
    else:
        size = truth["peak"]
    error = np.where(apart == 0.0, 0.0, np.inf)
    np.divide(apart, size, out=error, where=size > 0.0)
    return error


def _too_inexact(found: Mapping[str, float], asked: Mapping[str, float]) -> str:
    name = next(name for name in asked if not found[name] <= asked[name])
    return (
        f"the error of {name} is about {found[name]:.1e} at the finest tolerance, not "
        f"{asked[name]:g}; allow a larger error or take a shorter horizon"
    )
