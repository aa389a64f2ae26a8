"""Compute the rows of a sweep: transients in batches or run by run, stability, critical and safe μ.

A member is one parameter set with its start and its case: separation considered or ignored. Above
critical μ the equilibrium is unstable; safe μ is the least μ of the cycles that begin there.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, Final, Literal, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from fivtui.batch import Batch, Requirement, simulate_batch
from fivtui.equilibrium import critical_mus, judge_stability, reasons_without_verdict
from fivtui.model import (
    ALL_PARAMETERS,
    ComputationError,
    OnProgress,
    Parameters,
    Progress,
    System,
    spring_force,
)
from fivtui.orbits import Explorer, vibration_flags
from fivtui.safety import START_DIMENSIONS, disturbed_states, safe_mus
from fivtui.simulation import simulate
from fivtui.transient import (
    MIN_DIVERGENCE,
    START_SPECS,
    TOL_RANGE,
    finer_tol,
    first_tol,
    resolve_start,
)

from .design import SEED_LIMIT, random_points
from .study import (
    CRITICAL_MU_COLUMN,
    DONE,
    ERROR_COLUMNS,
    FAILED,
    SAFE_MU_COLUMN,
    STABILITY_COLUMNS,
    STICK_COLUMNS,
    TRANSIENT_COLUMNS,
    VIBRATION_COLUMNS,
    Study,
    SweepColumn,
)

Indices = NDArray[np.int64]
Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
# Start states of a block of members, shape (n, 4), or static: at rest at the equilibrium for μ = 0.
BlockStart = Literal["static"] | Floats

# Outputs of transients. Those on intervals of stick, without slip on the belt, need single runs.
_RUN_COLUMNS: Final = (*TRANSIENT_COLUMNS, *STICK_COLUMNS)
# Outputs for which a batch must record the extremes of x and ẋ beside those of y.
_X_OUTPUTS: Final = ("x_abs", "vx_max")
# Attribute of `Transient` with the extremes of the contact force P; batches do not have it.
_FORCE: Final = "contact_force"
# Intervals into which a run is divided, to say in which of them two runs diverge.
_INTERVAL_COUNT: Final = 8
# Number of members between two calls of `progress`.
_CHUNK_MEMBERS: Final = 8192
# The 97.5 % quantile of the normal distribution.
_QUANTILE: Final = 1.959963984540054
_FORCE_OVERFLOW: Final = (
    "the contact force grows beyond the floating-point range; consider separation or a shorter run"
)


class _Springs(NamedTuple):
    # Spring constants of the contact, per member.
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
        Why members failed; empty for members that did not.
    """

    numbers: dict[str, NDArray[np.float64]]
    separation: NDArray[np.bool_]
    reasons: tuple[str, ...]

    @property
    def members(self) -> int:
        """Number of members, one for each row."""
        return len(self.reasons)

    @property
    def failed(self) -> int:
        """Number of failed members."""
        return sum(map(bool, self.reasons))

    @property
    def failure(self) -> ComputationError | None:
        """The error of a sweep whose members all failed; None if not all did."""
        if self.failed < self.members:
            return None
        return all_failed_error(self.members, self.reasons[0])

    def part(self, first: int, stop: int) -> "Rows":
        """The rows `first` to `stop` - 1."""
        numbers = {name: values[first:stop] for name, values in self.numbers.items()}
        return Rows(numbers, self.separation[first:stop], self.reasons[first:stop])

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
        return [None if math.isnan(value) else convert(value) for value in numbers]

    def array(self, column: SweepColumn) -> NDArray[Any]:
        """A column as an array, NaN where a member has no value; counts are int if all have one."""
        if column.kind == "text" or column.name == "separation":
            return np.array(self.values(column))
        numbers = self.numbers[column.name]
        if column.kind == "number" or np.isnan(numbers).any():
            return numbers
        return numbers.astype(np.int64 if column.kind == "count" else np.bool_)


def all_failed_error(members: int, reason: str) -> ComputationError:
    """The error of a sweep whose members all failed, with the reason of the first."""
    why, _, advice = reason.partition("; ")
    return ComputationError(
        f"all {members} members failed, the first: {why}", advice or "change its parameters"
    )


_CONVERSIONS: Final[Mapping[str, Callable[[float], object]]] = {
    "number": float,
    "count": int,
    "truth": bool,
}


def concatenate(parts: list[Rows]) -> Rows:
    """Join parts of the rows of a sweep, in order."""
    return Rows(
        {name: np.concatenate([part.numbers[name] for part in parts]) for name in parts[0].numbers},
        np.concatenate([part.separation for part in parts]),
        tuple(reason for part in parts for reason in part.reasons),
    )


def compute_rows(study: Study, first: int, stop: int, progress: OnProgress | None = None) -> Rows:
    """Compute members `first` to `stop` - 1 of a sweep.

    A row does not depend on other rows or on earlier calls.
    """
    members = np.arange(first, stop, dtype=np.int64)
    # A member is a point of the design, its varied values, in one case. The cases of a point are
    # consecutive members.
    point_indices, case_indices = np.divmod(members, len(study.cases))
    error_names = [ERROR_COLUMNS[quantity].name for quantity in dict(study.accuracy)]
    block = _MemberBlock(
        study,
        varied=study.design.columns(point_indices),
        separation=np.array(study.cases)[case_indices],
        results={name: np.full(members.size, np.nan) for name in (*study.outputs, *error_names)},
        reasons=[""] * members.size,
    )
    if study.accuracy or any(column.name in study.outputs for column in _RUN_COLUMNS):
        block.integrate(progress)
    if any(column.name in study.outputs for column in STABILITY_COLUMNS):
        block.find_stability(progress)
    if not {CRITICAL_MU_COLUMN.name, SAFE_MU_COLUMN.name}.isdisjoint(study.outputs):
        block.explain_missing_verdicts()
    if CRITICAL_MU_COLUMN.name in study.outputs:
        block.find_critical_mu(progress)
    if SAFE_MU_COLUMN.name in study.outputs:
        block.find_safe_mu(progress)
    if study.has_vibration:
        block.find_vibration(progress)
    return Rows({**block.varied, **block.results}, block.separation, tuple(block.reasons))


@dataclass(frozen=True, slots=True)
class _MemberBlock:
    # Members computed together; the methods fill `results` and `reasons`, why members failed.
    study: Study
    varied: dict[str, NDArray[np.float64]]
    separation: NDArray[np.bool_]
    results: dict[str, NDArray[np.float64]]
    reasons: list[str]

    def parameters(self, index: int) -> Parameters:
        values = {name: float(column[index]) for name, column in self._varied_parameters.items()}
        return self.study.parameters.with_values(values)

    @property
    def _varied_parameters(self) -> dict[str, Floats]:
        # The columns of varied parameters, without components of the start.
        return {name: column for name, column in self.varied.items() if name in ALL_PARAMETERS}

    def _parameter_column(self, name: str) -> Floats:
        fixed_value = getattr(self.study.parameters, name)
        return self.varied.get(name, np.full(len(self.reasons), fixed_value))

    def integrate(self, progress: OnProgress | None) -> None:
        start = self._start()
        indices = np.flatnonzero([not reason for reason in self.reasons])
        if self.study.is_run_by_run:
            self._simulate(indices, start, progress)
        elif self.study.accuracy:
            self._refine(indices, start, progress or (lambda _fraction: True))
        elif indices.size > 0:
            self._store(indices, self._run(indices, start, self.study.tol, progress))

    def _simulate(self, indices: Indices, start: BlockStart, progress: OnProgress | None) -> None:
        # Simulate members one by one, for features that batches do not have.
        study = self.study
        # A `path` is a dotted attribute of `Transient`, such as peak.y_abs.
        readers = {column.name: attrgetter(column.path) for column in self._requested}
        for position, index in enumerate(indices.tolist()):

            def report(fraction: float, position: int = position) -> bool:
                return progress is None or progress((position + fraction) / indices.size)

            try:
                run = simulate(
                    self.parameters(index),
                    t_end=study.t_end,
                    tol=study.tol,
                    separation=bool(self.separation[index]),
                    start=start if isinstance(start, str) else start[index].tolist(),
                    method=study.method,
                    # Tables over time that parameters follow.
                    over_time=dict(study.over_time),
                    progress=report,
                )
            except ComputationError as error:
                self.reasons[index] = str(error)
            else:
                for name, read_output in readers.items():
                    self.results[name][index] = read_output(run)

    def _refine(self, indices: Indices, start: BlockStart, progress: OnProgress) -> None:
        # Refine the tolerance of each member until a run differs from the coarser run by less than
        # the error targets and does not diverge from it.
        targets, first_fraction = dict(self.study.accuracy), 0.0

        def report(fraction: float) -> bool:
            # The number of runs is not known. The first one is the first half of the progress, and
            # each further one is its second half again.
            return progress(first_fraction + 0.5 * fraction)

        tol = first_tol(targets)
        if indices.size > 0:
            coarse = _observe(self._run(indices, start, tol, report))
        while indices.size > 0:
            previous_tol, tol, first_fraction = tol, finer_tol(tol), 0.5
            is_finest = tol == TOL_RANGE[0]
            batch = self._run(indices, start, tol, report)
            fine = _observe(batch)
            errors = {name: _relative_error(name, coarse, fine) for name in targets}
            is_computed = np.ones(indices.size, dtype=bool)
            is_computed[batch.failed] = False
            is_accurate = np.all([errors[name] <= targets[name] for name in targets], axis=0)
            is_diverged = is_computed & _is_diverged(coarse, fine, self._time_scales(indices))
            # Failed members are neither inaccurate nor diverged: there are no finer runs of them.
            is_inaccurate = is_computed & ~is_diverged & ~is_accurate
            if is_finest:
                for row in np.flatnonzero(is_inaccurate).tolist():
                    member_errors = {name: float(error[row]) for name, error in errors.items()}
                    self.reasons[indices[row]] = _missed_target_reason(member_errors, targets)
                self._explain_divergence(indices[is_diverged], start, (previous_tol, tol), report)
            for name, error in errors.items():
                self.results[ERROR_COLUMNS[name].name][indices] = error
            self._store(indices, batch)
            if is_finest:
                return
            needs_finer_run = is_inaccurate | is_diverged
            indices = indices[needs_finer_run]
            coarse = {name: values[needs_finer_run] for name, values in fine.items()}

    def _time_scales(self, indices: Indices) -> Floats:
        # √(m/stiffness) of members, s, as `time_scale`.
        m, k1, k2, k3 = (self._parameter_column(name)[indices] for name in ("m", "k1", "k2", "k3"))
        scales: Floats = np.sqrt(m / (k1 + k2 + k3))
        return scales

    def _explain_divergence(
        self, indices: Indices, start: BlockStart, tols: tuple[float, float], progress: OnProgress
    ) -> None:
        # Set the reason of members whose runs diverge: the interval of the divergence.
        for number in range(1, _INTERVAL_COUNT + 1):
            if indices.size == 0:
                return
            begin, end = ((n / _INTERVAL_COUNT) * self.study.t_end for n in (number - 1, number))
            if number == _INTERVAL_COUNT:
                # These runs did not diverge earlier, so they diverge here.
                is_diverged = np.ones(indices.size, dtype=bool)
            else:
                coarse, fine = (
                    _observe(self._run(indices, start, tol, progress, end)) for tol in tols
                )
                is_diverged = _is_diverged(coarse, fine, self._time_scales(indices))
            for index in indices[is_diverged].tolist():
                self.reasons[index] = (
                    f"two runs at different tolerances diverge between t = {begin:.6g} and "
                    f"{end:.6g} s; later results cannot be verified: use a shorter horizon"
                )
            indices = indices[~is_diverged]

    def _run(
        self,
        indices: Indices,
        start: BlockStart,
        tol: float,
        progress: OnProgress | None,
        t_end: float | None = None,
    ) -> Batch:
        study = self.study
        parameters = {name: column[indices] for name, column in self._varied_parameters.items()}
        # If no parameter varies, an array of F sets the size of the batch.
        parameters.setdefault("F", np.full(indices.size, study.parameters.F))
        return simulate_batch(
            parameters,
            base=study.parameters,
            t_end=study.t_end if t_end is None else t_end,
            tol=tol,
            separation=self.separation[indices],
            start=start if isinstance(start, str) else start[indices],
            require=self._requirements(),
            workers=1,
            progress=progress,
        )

    def _requirements(self) -> set[Requirement]:
        # The results that a batch must compute for the requested outputs and the error targets.
        accuracy = dict(self.study.accuracy)
        # "peak" has the extremes of x, ẋ and y, "amplitude" those of y alone, which take less time.
        extremes = "peak" if any(name in self.study.outputs for name in _X_OUTPUTS) else "amplitude"
        # A path such as peak.y_abs begins with the requirement. Forces have none: they follow from
        # the extremes of y, see `_store_forces`.
        requirements = {column.path.partition(".")[0] for column in self._requested}
        required = {extremes if name in ("peak", _FORCE) else name for name in requirements}
        if accuracy:
            # `_is_diverged` needs these to compare two runs.
            required |= {"final", "events", extremes}
        if "half_range" in accuracy:
            required.add("steady")
        return cast("set[Requirement]", required)

    @property
    def _requested(self) -> list[SweepColumn]:
        # The columns of requested outputs that come from runs.
        return [column for column in _RUN_COLUMNS if column.name in self.study.outputs]

    def _store(self, indices: Indices, batch: Batch) -> None:
        # Copy the results of a batch of members; failed members have no results.
        for batch_member in batch.failed.tolist():
            self.reasons[indices[batch_member]] = str(batch.failure(batch_member))
        requested, columns = self._requested, batch.to_columns()
        for column in requested:
            if not column.path.startswith(_FORCE):
                self.results[column.name][indices] = columns[column.name]
        self._store_forces(indices, columns)
        failed = [bool(reason) for reason in self.reasons]
        error_columns = [ERROR_COLUMNS[quantity] for quantity, _ in self.study.accuracy]
        for column in (*requested, *error_columns):
            self.results[column.name][failed] = np.nan

    def _start(self) -> BlockStart:
        # Components that do not vary come from the start of the study, which may be static.
        columns = [self.varied.get(name) for name in START_SPECS]
        start, size = self.study.start, len(self.reasons)
        is_static = isinstance(start, str)
        if is_static and all(column is None for column in columns):
            return "static"
        states = np.zeros((size, 4))
        if not is_static:
            states[:] = start
        elif any(column is None for column in columns):
            # The static start depends on the parameters of a member.
            for index, separation in enumerate(self.separation.tolist()):
                try:
                    p = self.parameters(index)
                    states[index] = resolve_start(System(p, separation), start)
                except ComputationError as error:
                    self.reasons[index] = str(error)
        for component, column in zip(states.T, columns, strict=True):
            if column is not None:
                component[:] = column
        return states

    def _store_forces(self, indices: Indices, columns: Mapping[str, Floats]) -> None:
        # P decreases with y, so the extremes of P follow from those of y. Off the belt, P = 0.
        springs = _Springs(*(self._parameter_column(name)[indices] for name in _Springs._fields))
        for name, extreme in (("P_min", "y_max"), ("P_max", "y_min")):
            if name not in self.results:
                continue
            y = columns[extreme]
            y = np.where(self.separation[indices], np.minimum(y, 0.0), y)
            with np.errstate(over="ignore", invalid="ignore"):
                # Adding 0 turns -0 into 0.
                force = spring_force(springs, y) + 0.0
            self.results[name][indices] = force
            for index in indices[np.isinf(force)].tolist():
                self.reasons[index] = self.reasons[index] or _FORCE_OVERFLOW

    def _chunks(
        self, progress: OnProgress | None
    ) -> Iterator[tuple[slice, dict[str, Floats], Progress]]:
        # Chunks of members, with the varied parameters of each, and its share of the progress.
        parameters, size, work = self._varied_parameters, len(self.reasons), Progress(progress)
        for first in range(0, size, _CHUNK_MEMBERS):
            stop = min(first + _CHUNK_MEMBERS, size)
            work.report(first / size)
            chunk = slice(first, stop)
            columns = {name: column[chunk] for name, column in parameters.items()}
            yield chunk, columns, work.stage(first / size, stop / size)

    def find_vibration(self, progress: OnProgress | None) -> None:
        design, start = self.study.design, self._start()
        count, explorers = design.starts or 1, {}
        # Not the numbers of the points of a random design.
        points = random_points((design.seed or 0) + SEED_LIMIT, START_DIMENSIONS, 0, count)
        states = np.empty((len(self.reasons), count, 4))
        for index, separation in enumerate(self.separation.tolist()):
            system = System(self.parameters(index), separation)
            try:
                explorers[index] = Explorer(system)
                if design.starts is None:
                    state = start if isinstance(start, str) else start[index].tolist()
                    states[index] = resolve_start(system, state)
                else:
                    states[index] = disturbed_states(system, points)
            except ComputationError as error:
                explorers.pop(index, None)
                self.reasons[index] = self.reasons[index] or str(error)
        members = list(explorers)
        flags = vibration_flags(
            [explorer for explorer in explorers.values() for _ in range(count)],
            states[members].reshape(-1, 4),
            t_end=self.study.t_end,
            tol=self.study.tol,
            progress=progress,
        ).reshape(-1, count)
        hits, undecided = np.nansum(flags, axis=1), np.isnan(flags).sum(axis=1)
        decided = np.where(undecided < count, count - undecided, np.nan)
        # Undecided starts are all at rest for the lower end, and all vibrate for the upper end.
        low, high = wilson_end(hits, count, -1.0), wilson_end(hits + undecided, count, 1.0)
        shares = (hits / decided, low, high, undecided)
        for column, values in zip(VIBRATION_COLUMNS, shares, strict=True):
            if column.name in self.results:
                self.results[column.name][members] = values

    def explain_missing_verdicts(self) -> None:
        reasons = reasons_without_verdict(
            self.study.parameters, self._varied_parameters, self.separation
        )
        for member, reason in reasons.items():
            self.reasons[member] = self.reasons[member] or reason

    def find_critical_mu(self, progress: OnProgress | None) -> None:
        for chunk, parameters, _ in self._chunks(progress):
            self.results[CRITICAL_MU_COLUMN.name][chunk] = critical_mus(
                self.study.parameters, parameters, self.separation[chunk]
            )

    def find_safe_mu(self, progress: OnProgress | None) -> None:
        for chunk, parameters, work in self._chunks(progress):
            # `study.safe` is a table of safe μ, if there is one. Without it a chunk takes long, and
            # `progress` is also called within it.
            self.results[SAFE_MU_COLUMN.name][chunk] = safe_mus(
                self.study.parameters,
                parameters,
                self.separation[chunk],
                self.study.safe,
                work.callback,
            )

    def find_stability(self, progress: OnProgress | None) -> None:
        for chunk, parameters, _ in self._chunks(progress):
            growth, stable, reasons = judge_stability(
                self.study.parameters, parameters, self.separation[chunk]
            )
            for offset, reason in reasons.items():
                member = chunk.start + offset
                self.reasons[member] = self.reasons[member] or reason
            verdicts = np.where(np.isnan(growth), np.nan, stable)
            for name, values in (("growth_rate", growth), ("stable", verdicts)):
                if name in self.results:
                    self.results[name][chunk] = values


def wilson_end(hits: Floats, count: int, sign: float) -> Floats:
    """The lower (sign -1) or upper end (1) of Wilson's 95 % interval of shares hits/count."""
    centre, variance = hits + 0.5 * _QUANTILE**2, hits * (count - hits) / count
    half_width = _QUANTILE * np.sqrt(variance + 0.25 * _QUANTILE**2)
    return np.asarray(np.clip((centre + sign * half_width) / (count + _QUANTILE**2), 0.0, 1.0))


def _observe(batch: Batch) -> dict[str, Floats]:
    # Quantities by which two runs of each member are compared; members are the first axis. As in
    # the error targets, "peak" is the greatest |y|.
    columns = batch.to_columns()
    return {
        "final": batch.final,
        "peak": columns["y_abs"],
        "switches": (columns["separations"] + columns["reattachments"]).astype(np.float64),
        **({"half_range": columns["y_half_range"]} if "y_half_range" in columns else {}),
    }


def _is_diverged(coarse: Mapping[str, Floats], fine: Mapping[str, Floats], scales: Floats) -> Flags:
    # Whether two runs of each member diverge, as in `divergence`. `scales`, s, turn velocities into
    # lengths.
    ones = np.ones_like(scales)
    # For x, ẋ, y, ẏ.
    weights = np.stack([ones, scales, ones, scales], axis=1)
    distance = (np.abs(coarse["final"] - fine["final"]) * weights).max(axis=1)
    size = np.maximum((np.abs(fine["final"]) * weights).max(axis=1), fine["peak"])
    diverged: Flags = (coarse["switches"] != fine["switches"]) | ~(
        distance <= MIN_DIVERGENCE * size
    )
    return diverged


def _relative_error(
    quantity: str, coarse: Mapping[str, Floats], fine: Mapping[str, Floats]
) -> Floats:
    # Errors of members relative to the final state or the peak, as in `deviation`.
    distance = np.abs(coarse[quantity] - fine[quantity])
    if quantity == "final":
        distance, size = distance.max(axis=1), np.abs(fine[quantity]).max(axis=1)
    else:
        size = fine["peak"]
    error = np.where(distance == 0.0, 0.0, np.inf)
    np.divide(distance, size, out=error, where=size > 0.0)
    return error


def _missed_target_reason(errors: Mapping[str, float], targets: Mapping[str, float]) -> str:
    name = next(name for name in targets if not errors[name] <= targets[name])
    return (
        f"the error of {name} is about {errors[name]:.1e} at the finest tolerance, not "
        f"{targets[name]:g}; allow a larger error or take a shorter horizon"
    )
