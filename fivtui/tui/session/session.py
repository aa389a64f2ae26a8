"""The state of the laboratory without its screen. Imports no Textual."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Generic, TypeVar

from fivtui.charts import View
from fivtui.equilibrium import Stability, stability
from fivtui.model import (
    ALL_PARAMETERS,
    BELT_PARAMETERS,
    ComputationError,
    InputError,
    Parameters,
    unused_parameters,
)
from fivtui.ranges import number_text
from fivtui.scene import Scene, scene_file
from fivtui.transient import METHODS, SETTINGS, WITH_SEPARATION, uses_step

from .editing import Action, Editing, EditState, initial_value_text, loaded_state
from .equations import symbol_of
from .fields import FIELDS, scene_texts
from .live import LiveCurve
from .report import NEXT_STEPS, Attractors, verdict_kind
from .runs import FMU_ENGINES, Run, Runs, engine_of
from .scene_differences import base_scene, differences

if TYPE_CHECKING:
    from fivtui.sweeps import Study

MAX_RECENT: Final = 10
_FIRST_METHOD: Final = next(iter(METHODS))

# By field, the fields that restrict its values: static friction is at least the sliding friction,
# the step depends on method and end time.
_RESTRICTING_FIELDS: Final = {"mu_s": ("mu",), "step": ("method", "t_end")}

# Maps of safety by mapped value, with their titles: each is a result with a key of its own.
SAFETY_MAPS: Final = {"safe-mu": "Safe μ", "coexistence": "Regions"}

T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class DisplayedStudy(Generic[T]):
    """A displayed result, the name of its scene or file, and its `source` file if it was read."""

    value: T
    name: str
    source: str = ""


def study_key(kind: str, value: Any) -> str:
    """The key of a result of this kind."""
    return str(value.value) if kind == "map" and value.value in SAFETY_MAPS else kind


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


# The run of a result, or the key of a study: its kind, or the mapped value of a map of safety.
ResultKey = Run | str


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
        # Whether a live curve follows edits.
        self.live_enabled = True
        # Displayed results of studies; a sweep may be incomplete.
        self.studies: dict[ResultKey, DisplayedStudy[Any]] = {}
        # Stored settings of the tabs, by tab and key.
        self.settings: dict[str, dict[str, str]] = {}
        # Visible parts of the charts, by the identifiers of their widgets.
        self.views: dict[str, View] = {}
        # Results of the saved session that are not read yet.
        self.unread_results: dict[ResultKey, StoredResult] = {}
        # Why results were not stored with the saved session, by run or key of a study.
        self.not_stored: dict[str, str] = {}
        self.attractors: Attractors | None = None
        # The last native method, and the last that runs an FMU (True).
        self._last_methods = {False: _FIRST_METHOD, True: next(iter(FMU_ENGINES))}

    def add_recent(self, source: str) -> None:
        """Add a scene to the recent files, as the first, if its source is a file."""
        if (file := scene_file(source)) is not None:
            # The next start may be in another folder.
            paths = dict.fromkeys((str(file.absolute()), *self.recent))
            self.recent = tuple(paths)[:MAX_RECENT]

    def field_error(self, name: str) -> str:
        """Error message of a field; empty if its text is valid."""
        try:
            self._value(name)
        except InputError as error:
            return str(error).replace(f"{name} =", f"{symbol_of(name)} =", 1)
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

    def _value(self, name: str) -> Any:
        value = FIELDS[name].check(self.texts[name])
        self._check_table(name, self.texts[name])
        return value

    def _check_table(self, name: str, text: str) -> None:
        # A parameter that follows a table over time has the value of the table at t = 0.
        table = dict(self.over_time).get(name)
        if table is not None and text != initial_value_text(table):
            raise InputError(f"{symbol_of(name)}: follows a table over time; must not be changed")

    def set_texts(self, texts: Mapping[str, str]) -> None:
        """Edit several fields; raises `InputError` before any edit if one follows a table."""
        for name, text in texts.items():
            self._check_table(name, text)
        for name, text in texts.items():
            self.set_text(name, text)

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
        try:
            value = field.check(self.texts[name] or field.default)
            if field.step_rule is None or not isinstance(value, float):
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
        self._last_methods[method in FMU_ENGINES] = method
        methods = [*FMU_ENGINES, self._last_methods[False]]
        self._set_field("method", methods[(methods.index(method) + 1) % len(methods)], "engine")
        self.close_undo_step()

    def engine_pair(self) -> tuple[Scene, Scene]:
        """The edited scene with a native method, and with an FMU: its own, or the last one used.

        Raises `InputError` if a field is invalid.
        """
        scene = self.scene()
        methods = self._last_methods | {scene.method in FMU_ENGINES: scene.method}
        method, fmu_method = methods[False], methods[True]
        step = scene.step if uses_step(method) else None
        return (
            dataclasses.replace(scene, method=method, step=step),
            dataclasses.replace(scene, method=fmu_method, step=None),
        )

    def parameters(self) -> Parameters:
        """The edited parameter set; raises `InputError` if a parameter is invalid."""
        return Parameters().with_values({name: self._value(name) for name in ALL_PARAMETERS})

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
        return stability(self.parameters(), separation=self.separation)

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
        description = self.scene().description
        self.restore(EditState(scene_texts(scene), scene.over_time, self.loaded, self.source))
        if dataclasses.replace(self.scene(), description=description) != scene:
            self._apply(loaded_state(scene, ""))

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

        runs.remove(run)
        self.record(Action(restore, lambda: runs.remove(run)))

    def is_outdated(self, run: Run) -> bool:
        """Whether the fields differ from the scene of a run, or are invalid."""
        try:
            return bool(differences(self.scene(), run.edited_scene or run.scene))
        except InputError:
            return True
