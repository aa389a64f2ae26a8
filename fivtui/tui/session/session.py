"""The state of the laboratory without its screen. Imports no Textual."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Generic, TypeVar

from fivtui.charts import View
from fivtui.equilibrium import Stability, stability
from fivtui.model import (
    ALL_PARAMETERS,
    BELT_PARAMETERS,
    ComputationError,
    InputError,
    Parameters,
    System,
    unused_parameters,
)
from fivtui.ranges import number_text
from fivtui.scene import Scene
from fivtui.transient import METHODS, SETTINGS, WITH_SEPARATION, uses_step

from .editing import Action, Editing, initial_value_text, loaded_state
from .equations import symbol_of
from .fields import FIELDS
from .live import LiveCurve
from .report import NEXT_STEPS, Attractors, verdict_kind
from .runs import FMU_ENGINES, Run, Runs, engine_of
from .scene_differences import base_scene, differences

if TYPE_CHECKING:
    from fivtui.sweeps import Study

    from .command_lines import Origin

MAX_RECENT: Final = 10
# Group and key of the stored setting of the live curve, and its values.
_LIVE: Final = "live"
_ON: Final = "on"
_OFF: Final = "off"
_FIRST_METHOD: Final = next(iter(METHODS))

# By field, the fields that restrict its values: static friction is at least the sliding friction,
# the step depends on method and end time.
_RESTRICTING_FIELDS: Final = {"mu_s": ("mu",), "step": ("method", "t_end")}

# Maps of safety by mapped value, with their titles: each is a result with a key of its own.
SAFETY_MAPS: Final = {"safe-mu": "Safe μ", "coexistence": "Regions"}
_RUN, _MAP = "run", "map"

T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class DisplayedStudy(Generic[T]):
    """A displayed result, the name of its scene or file, and its `source` file if it was read."""

    value: T
    name: str
    source: str = ""


def study_kind(key: str) -> str:
    """The kind of study of a stored result with this key."""
    return _MAP if key in SAFETY_MAPS else _RUN if key.startswith(f"{_RUN}-") else key


def study_key(kind: str, value: Any) -> str:
    """The key of a result of this kind."""
    return str(value.value) if kind == _MAP and value.value in SAFETY_MAPS else kind


def check_drawable(study: "Study") -> None:
    """Raise `InputError` unless a sweep has one variable, or two as a full grid."""
    names, kind = list(study.design.axes), study.design.kind
    if len(names) > 2 or (len(names) == 2 and kind != "product"):
        raise InputError(
            f"a {kind} sweep over {', '.join(names)} cannot be displayed: use one name, "
            "or two with all combinations of their values"
        )


@dataclass(frozen=True, slots=True)
class StoredResult:
    """The file of a result in a saved session; `name` and `source` are as in `DisplayedStudy`."""

    file: str
    name: str = ""
    source: str = ""


# The result of a run, a displayed study, or a result that is not read yet.
SessionResult = Run | DisplayedStudy[Any] | StoredResult


class Session(Editing):
    """The edited scene, its runs and studies, and the state of the tabs."""

    def __init__(self, scene: Scene | None = None, source: str = "") -> None:
        super().__init__(scene, source)
        self.runs = Runs()
        self.live = LiveCurve()
        self.reports: list[str] = []
        # Keys of the laboratory as displayed, by their identifiers in the configuration file.
        self.key_names: Mapping[str, str] = {}
        self.recent: tuple[str, ...] = ()
        # Names of the displayed tab and of the theme; unknown names are ignored.
        self.tab = self.theme = ""
        # Displayed results by kind of study; a sweep may be incomplete.
        self.studies: dict[str, DisplayedStudy[Any]] = {}
        # Stored settings of the tabs, by tab and key.
        self.settings: dict[str, dict[str, str]] = {}
        # Visible parts of the charts, by the identifiers of their widgets.
        self.views: dict[str, View] = {}
        # Results of the saved session that are not read yet, by run or kind of study.
        self.unread_results: dict[str, StoredResult] = {}
        # Why results were not stored with the saved session, likewise.
        self.not_stored: dict[str, str] = {}
        self.attractors: Attractors | None = None
        # Last native and last FMU method, for `switch_engine` and `engine_pair`.
        self._native_method, self._fmu_method = _FIRST_METHOD, next(iter(FMU_ENGINES))
        # Cached, because several views need it after every key.
        self._stability: Stability | None = None

    @property
    def live_enabled(self) -> bool:
        """Whether a live curve follows edits; stored with the session."""
        return self.settings.get(_LIVE, {}).get(_LIVE) != _OFF

    @live_enabled.setter
    def live_enabled(self, on: bool) -> None:
        self.settings.setdefault(_LIVE, {})[_LIVE] = _ON if on else _OFF

    def add_recent(self, path: str) -> None:
        """Add a scene file to the recent files, as the first."""
        absolute_path = Path(path).absolute()
        other_paths = [
            recent_path
            for recent_path in self.recent
            if Path(recent_path).absolute() != absolute_path
        ]
        self.recent = (path, *other_paths)[:MAX_RECENT]

    def field_error(self, name: str) -> str:
        """Error message of a field; empty if its text is valid."""
        try:
            FIELDS[name].check(self.texts[name])
        except InputError as error:
            return str(error).replace(f"{name} =", f"{symbol_of(name)} =", 1)
        table = dict(self.over_time).get(name)
        if table is not None and self.texts[name] != initial_value_text(table):
            return f"{name}: follows a table over time; must not be changed"
        return self._conflict(name)

    def _conflict(self, name: str) -> str:
        # The error of a value that is allowed with some values of other fields only.
        restricting = _RESTRICTING_FIELDS.get(name, ())
        if not restricting or any(map(self.field_error, restricting)):
            return ""
        values: dict[str, Any] = {field: self._value(field) for field in (*restricting, name)}
        try:
            if name == "step":
                dataclasses.replace(base_scene(), **values)
            else:
                Parameters(**values)
        except InputError as error:
            return str(error)
        return ""

    def _value(self, name: str) -> object:
        return FIELDS[name].check(self.texts[name])

    @property
    def errors(self) -> dict[str, str]:
        """Error messages of the invalid fields, by name."""
        messages = {name: self.field_error(name) for name in FIELDS}
        return {name: message for name, message in messages.items() if message}

    def step_field(self, name: str, direction: int, *, fine: bool = False) -> bool:
        """Change a number by a step up (+1) or down (-1), or by a tenth of it if `fine`.

        Returns False if the field is no number, or if the new number is not allowed.
        """
        field = FIELDS[name]
        if field.step_rule is None:
            return False
        try:
            value = field.check(self.texts[name] or field.default)
            if not isinstance(value, float):
                return False
            text = number_text(field.step_rule(value, direction, fine))
            field.check(text)
        except InputError:
            return False
        self._set_field(name, text, f"step {direction:+d}")
        return True

    @property
    def engine(self) -> str:
        """The engine of the edited scene: native solver, Python FMU or native FMU."""
        return engine_of(self.texts["method"])

    def switch_engine(self) -> None:
        """Switch to the next engine: one FMU after the other, then the last native method."""
        method = self.texts["method"]
        if method not in FMU_ENGINES:
            self._native_method = method
        methods = [self._native_method, *FMU_ENGINES, self._native_method]
        next_method = methods[methods.index(method) + 1]
        if next_method in FMU_ENGINES:
            self._fmu_method = next_method
        self._set_field("method", next_method, "engine")
        self.close_undo_step()

    def engine_pair(self) -> tuple[Scene, Scene]:
        """The edited scene with a native method, and with an FMU: its own, or the last one used.

        Raises `InputError` if a field is invalid.
        """
        scene = self.scene()
        is_fmu = scene.method in FMU_ENGINES
        method = self._native_method if is_fmu else scene.method
        fmu_method = scene.method if is_fmu else self._fmu_method
        step = scene.step if uses_step(method) else None
        return (
            dataclasses.replace(scene, method=method, step=step),
            dataclasses.replace(scene, method=fmu_method, step=None),
        )

    def parameters(self) -> Parameters:
        """The edited parameter set; raises `InputError` if a parameter is invalid."""
        values = {name: FIELDS[name].check(self.texts[name]) for name in ALL_PARAMETERS}
        return Parameters().with_values(values)

    @property
    def notes(self) -> dict[str, str]:
        """By name, notes on parameters that follow a table over time or have no effect."""
        notes = {}
        for name, table in self.over_time:
            values, unit = table.values, f" {FIELDS[name].unit}".rstrip()
            span = f"{table.times[0]:g} to {table.times[-1]:g} s"
            notes[name] = f"at t = 0; {min(values):g} to {max(values):g}{unit}, table {span}"
        if self.belt_is_finite and not self.errors:
            varied = [name for name, _ in self.over_time]
            for name, needed in unused_parameters(self.parameters(), varied).items():
                notes[name] = f"no effect without {needed}"
        return notes

    @property
    def belt_is_finite(self) -> bool:
        """Whether the edited belt has a finite speed."""
        return any(self.texts[name] for name in BELT_PARAMETERS)

    @property
    def separation(self) -> bool:
        """Whether the edited scene considers separation."""
        return self.texts["separation"] == WITH_SEPARATION

    def stability(self) -> Stability:
        """Stability of the edited parameter set."""
        parameters, separation = self.parameters(), self.separation
        if self._stability is None or self._stability.system != System(parameters, separation):
            self._stability = stability(parameters, separation=separation)
        return self._stability

    def scene(self) -> Scene:
        """The edited scene, named as the loaded one; raises `InputError` if a field is invalid."""
        errors = list(self.errors.values())
        if errors:
            raise InputError(errors[0])
        settings: dict[str, Any] = {name: self._value(name) for name in SETTINGS}
        return dataclasses.replace(
            self.loaded,
            description="" if self.changed_fields else self.loaded.description,
            parameters=self.parameters(),
            over_time=self.over_time,
            **settings,
        )

    def replace_scene(self, scene: Scene) -> None:
        """Replace the edited scene in one undo step.

        A scene that differs in more than fields of the form, such as its name, has no file.
        """
        edited = self.scene()
        settings: dict[str, Any] = {name: getattr(edited, name) for name in SETTINGS}
        with_fields = dataclasses.replace(
            scene, parameters=edited.parameters, over_time=edited.over_time, **settings
        )
        state = loaded_state(scene, "")
        if with_fields == edited:
            state = dataclasses.replace(state, loaded=self.loaded, source=self.source)
        self.restore(state)

    @property
    def next_step(self) -> tuple[str, str]:
        """The tab that leads on from the verdict, and its question; empty if it has a result."""
        try:
            kind = verdict_kind(self.stability(), self.attractors)
        except (InputError, ComputationError):
            return "", ""
        tab, question = NEXT_STEPS.get(kind, ("", ""))
        if not tab or tab in {*self.studies, *self.unread_results}:
            return "", ""
        return tab, question

    def delete_run(self, run: Run) -> None:
        """Delete a run; `undo` restores it."""
        runs = self.runs
        displayed, baseline = runs.displayed, runs.baseline

        def restore() -> None:
            runs.reinsert(run)
            runs.displayed, runs.baseline = displayed, baseline

        runs.remove_restorably(run)
        self.record(Action(restore, lambda: runs.remove_restorably(run)))

    def is_outdated(self, run: Run) -> bool:
        """Whether the fields differ from the scene of a run, or are invalid."""
        try:
            return bool(differences(self.scene(), run.form_scene))
        except InputError:
            return True

    @property
    def origin(self) -> "Origin":
        """The loaded scene, and its preset or file."""
        from .command_lines import Origin

        return Origin(self.loaded, self.source)

    def command_line(self) -> str:
        """The command for the edited transient; raises `InputError` if a field is invalid."""
        from .command_lines import study_command

        return study_command("run", self.scene(), self.origin)
