"""The study of a sweep: parameters, design and the columns of the rows.

A member is a point of the design in one case: Case 1 considers separation, Case 2 ignores it. Each
member has a row.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

from fivtui.batch import BATCH_COLUMNS
from fivtui.model import (
    Column,
    InputError,
    Parameters,
    build_course,
    check_known,
    check_names,
    check_parameters,
    check_separation,
    check_varied_are_used,
)
from fivtui.safety import SafeTable
from fivtui.scene import OverTime, Scene
from fivtui.transient import (
    DEFAULT_T_END,
    DEFAULT_TOL,
    FMU_FLAVOURS,
    QUANTITIES,
    VARIABLES,
    Start,
    check_accuracy,
    check_horizon,
    check_start,
    check_tolerance,
)

from .scatter import Scatter, StudyDesign

ColumnKind = Literal["number", "count", "truth", "text"]
# The method of batches, and all methods of sweeps.
BATCH_METHOD: Final = "taylor"
METHODS: Final = (BATCH_METHOD, *FMU_FLAVOURS)
DONE: Final = "done"
FAILED: Final = "failed"


@dataclass(frozen=True, slots=True)
class SweepColumn(Column):
    """A column of a sweep; `path` is an attribute of `Transient`, empty if no run has the value."""

    kind: ColumnKind = "number"
    path: str = ""


def _batch_column(name: str, path: str, kind: ColumnKind = "number") -> SweepColumn:
    column = BATCH_COLUMNS[name]
    return SweepColumn(column.name, column.unit, column.meaning, kind, path)


TRANSIENT_COLUMNS: Final = (
    *(_batch_column(name, f"peak.{name}") for name in ("y_abs", "y_max", "y_min")),
    *(_batch_column(name, f"peak.{name}") for name in ("x_abs", "vx_max")),
    _batch_column("y_half_range", "steady.y_half_range"),
    SweepColumn("P_min", "N", "least contact force", path="contact_force.min"),
    SweepColumn("P_max", "N", "greatest contact force", path="contact_force.max"),
    _batch_column("separations", "events.separations", "count"),
    _batch_column("reattachments", "events.reattachments", "count"),
    _batch_column("separated_time", "events.separated_time"),
    *(_batch_column(f"{name}_end", f"final.{name}") for name in ("x", "vx", "y", "vy")),
)
STICK_COLUMNS: Final = (
    SweepColumn("sticks", "", "number of sticks", "count", "events.sticks"),
    SweepColumn("stick_time", "s", "time of stick", path="events.stick_time"),
    SweepColumn("final_stick", "s", "beginning of the final stick", path="final_stick"),
)
# Outputs of single runs that batches do not have.
_SINGLE_RUN_OUTPUTS: Final = frozenset(column.name for column in STICK_COLUMNS)
STABILITY_COLUMNS: Final = (
    SweepColumn("growth_rate", "1/s", "greatest real part of the eigenvalues"),
    SweepColumn("stable", "", "whether the equilibrium is stable", "truth"),
)
# Small disturbances die out below the critical μ. Below the least μ on the branch of limit cycles
# from the Hopf point large ones do so too, unless another attractor exists: none is searched for.
CRITICAL_MU_COLUMN: Final = SweepColumn("critical_mu", "", "critical friction coefficient")
SAFE_MU_COLUMN: Final = SweepColumn("safe_mu", "", "least μ on the branch from the Hopf point")
# A motion ends in vibration (share 1), at rest (0), or is undecided.
VIBRATES: Final = "vibrates"
VIBRATION_COLUMNS: Final = (
    SweepColumn(VIBRATES, "", "share of starts that end in vibration"),
    SweepColumn("vibrates_low", "", "lower end of its 95 % interval"),
    SweepColumn("vibrates_high", "", "upper end of its 95 % interval"),
    SweepColumn("undecided", "", "number of undecided starts", "count"),
)
_VIBRATION_OUTPUTS: Final = tuple(column.name for column in VIBRATION_COLUMNS)
OUTPUTS: Final[Mapping[str, SweepColumn]] = {
    column.name: column
    for column in (
        *TRANSIENT_COLUMNS,
        *STICK_COLUMNS,
        *STABILITY_COLUMNS,
        CRITICAL_MU_COLUMN,
        SAFE_MU_COLUMN,
        *VIBRATION_COLUMNS,
    )
}
DEFAULT_OUTPUTS: Final = tuple(column.name for column in TRANSIENT_COLUMNS)
# Columns of errors by quantity. Rows have no switch times, hence no error of events.
ERROR_COLUMNS: Final[Mapping[str, SweepColumn]] = {
    name: SweepColumn(f"{name}_error", "", f"error of the {QUANTITIES[name]}")
    for name in ("final", "peak", "half_range")
}

_SEPARATION: Final = SweepColumn("separation", "", "whether separation is considered", "truth")
_STATUS_COLUMNS: Final = (
    SweepColumn("status", "", f"{DONE} or {FAILED}", "text"),
    SweepColumn("reason", "", "why a member failed", "text"),
)


@dataclass(frozen=True, slots=True)
class Study:
    """A sweep to be computed.

    Parameters
    ----------
    design : Design or Scatter
        The varied values. A varied component of the start replaces that of `start`.
    parameters : Parameters
        The other parameters.
    cases : tuple of bool
        The computed cases: True considers separation, False ignores it. Both give two members per
        point.
    start, t_end, tol
        As in `simulate`.
    accuracy : tuple of (str, float)
        Error targets of ``final``, ``peak``, ``half_range``. They replace `tol`: the tolerance is
        refined until a finer run confirms the targets, and the row has the errors.
    outputs : tuple of str
        Names in `OUTPUTS`; transients are only computed if an output needs them.
    safe : SafeTable, optional
        Table in which ``safe_mu`` is interpolated; without it, a branch of limit cycles is followed
        for each member.
    method : str
        ``taylor``, or a run of the Python FMU, ``fmu``, or of the native one, ``fmu-native``, by
        fmpy for each member.
    over_time : tuple of (str, TimeTable)
        Parameters that follow tables over time in all members; `parameters` is set to their values
        at t = 0.

    Raises
    ------
    InputError
        If a value is out of bounds or a name unknown.
    """

    design: StudyDesign
    parameters: Parameters
    cases: tuple[bool, ...] = (True,)
    start: Start = "static"
    t_end: float = DEFAULT_T_END
    tol: float = DEFAULT_TOL
    accuracy: tuple[tuple[str, float], ...] = ()
    outputs: tuple[str, ...] = DEFAULT_OUTPUTS
    safe: SafeTable | None = None
    method: str = BATCH_METHOD
    over_time: OverTime = ()

    def __post_init__(self) -> None:
        for separation in self.cases:
            check_separation(separation)
        if not 1 <= len(set(self.cases)) == len(self.cases):
            raise InputError(f"cases = {self.cases}: must be True, False, or both")
        for name in check_names("outputs", self.outputs):
            check_known("output", name, OUTPUTS)
        if not 1 <= len(set(self.outputs)) == len(self.outputs):
            raise InputError("outputs: must be one or more names, each once")
        if self.method not in METHODS:
            raise InputError(f"method = {self.method}: must be {', '.join(METHODS)} for a sweep")
        if self.design.starts is not None:
            outputs = tuple(dict.fromkeys((*self.outputs, *_VIBRATION_OUTPUTS)))
            object.__setattr__(self, "outputs", outputs)
        if self.has_vibration and self.method != BATCH_METHOD:
            raise InputError(f"output {VIBRATES}: must be left out with method = {self.method}")
        self._check_over_time()
        targets = self._checked_targets()
        object.__setattr__(self, "accuracy", tuple(targets.items()))
        p = check_parameters(self.parameters)
        if self.over_time:
            p = build_course(p, dict(self.over_time)).initial
            object.__setattr__(self, "parameters", p)
        check_varied_are_used(p, (*dict(self.over_time), *self.design.axes))
        tol = check_tolerance(self.tol)
        object.__setattr__(self, "t_end", check_horizon(self.t_end))
        object.__setattr__(self, "tol", DEFAULT_TOL if targets else tol)
        object.__setattr__(self, "start", check_start(self.start))

    def _checked_targets(self) -> dict[str, float]:
        # The error targets by quantity; `InputError` if the study cannot be refined to them.
        targets = check_accuracy(dict(self.accuracy))
        if self.method != BATCH_METHOD and (targets or isinstance(self.design, Scatter)):
            feature = "error targets" if targets else "a scattered sweep"
            raise InputError(f"method = {self.method}: must be {BATCH_METHOD} for {feature}")
        if targets and self.over_time:
            raise InputError(
                f"{_join_names(self.over_time)} over time: must be constant for error targets; "
                "give a tolerance"
            )
        if targets and self._single_run_outputs:
            output = self._single_run_outputs[0]
            raise InputError(f"output {output}: must be without error targets; give a tolerance")
        for name in targets:
            if name not in ERROR_COLUMNS:
                raise InputError(
                    f"accuracy of {name}: must be one of {', '.join(ERROR_COLUMNS)}; "
                    "a sweep does not store switch times"
                )
        return targets

    def _check_over_time(self) -> None:
        if not self.over_time:
            return
        for name, _ in self.over_time:
            if name in self.design.axes:
                raise InputError(f"{name}: follows a table over time; must not be varied")
        for name in self.outputs:
            if not OUTPUTS[name].path:
                raise InputError(
                    f"output {name}: must be left out, as {_join_names(self.over_time)} over time "
                    "has no equilibrium"
                )

    @property
    def has_vibration(self) -> bool:
        """Whether motions are followed until they vibrate or come to rest."""
        return not set(self.outputs).isdisjoint(_VIBRATION_OUTPUTS)

    @property
    def _single_run_outputs(self) -> list[str]:
        return [name for name in self.outputs if name in _SINGLE_RUN_OUTPUTS]

    @property
    def is_run_by_run(self) -> bool:
        """Whether members are computed as single runs and not in batches."""
        return self.method != BATCH_METHOD or bool(self.over_time or self._single_run_outputs)

    @property
    def members(self) -> int:
        """Number of members."""
        return self.design.size * len(self.cases)

    @property
    def columns(self) -> tuple[SweepColumn, ...]:
        """The columns of a row, in order."""
        varied = [
            SweepColumn(name, VARIABLES[name].unit, VARIABLES[name].meaning)
            for name in self.design.axes
        ]
        outputs = [OUTPUTS[name] for name in self.outputs]
        errors = [ERROR_COLUMNS[name] for name, _ in self.accuracy]
        return (*varied, _SEPARATION, *outputs, *errors, *_STATUS_COLUMNS)


def _join_names(over_time: OverTime) -> str:
    return ", ".join(name for name, _ in over_time)


def scene_study(
    scene: Scene,
    design: StudyDesign,
    *,
    cases: tuple[bool, ...] | None = None,
    outputs: Sequence[str] = (),
) -> Study:
    """The study of a scene, by default for the case of the scene; raises as `Study`."""
    return Study(
        design=design,
        parameters=scene.parameters,
        cases=(scene.separation,) if cases is None else cases,
        start=scene.start,
        t_end=scene.t_end,
        tol=scene.tol,
        accuracy=scene.accuracy,
        outputs=tuple(outputs) or DEFAULT_OUTPUTS,
        method=scene.method,
        over_time=scene.over_time,
    )
