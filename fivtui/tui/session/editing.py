"""Edited field texts of a scene, with undo. Imports no Textual."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final

from fivtui.model import TimeTable
from fivtui.ranges import number_text
from fivtui.scene import OverTime, Scene

from .fields import FIELDS
from .scene_differences import default_scene

# Maximum numbers of undo steps, and of actions among them.
_MAX_STEPS: Final = 1000
_MAX_ACTIONS: Final = 20


@dataclass(frozen=True, slots=True)
class EditState:
    """Edited texts and tables over time, the loaded scene, and its preset or file."""

    texts: Mapping[str, str]
    over_time: OverTime
    loaded: Scene
    source: str


@dataclass(frozen=True, slots=True)
class Action:
    """An undo step that is no edit of texts: functions that undo and redo it."""

    undo: Callable[[], None]
    redo: Callable[[], None]


def initial_value_text(table: TimeTable) -> str:
    """The text of a parameter that follows a table: its value from t = 0 on."""
    return number_text(table.after(0.0)[0])


def _edit_state(scene: Scene, source: str) -> EditState:
    texts = {name: field.text_of(scene) for name, field in FIELDS.items()}
    return EditState(texts, scene.over_time, scene, source)


class Editing:
    """Field texts edited from a scene, with undo.

    Consecutive edits of one kind are one step until `close_step`, so a typed number is one step.
    """

    def __init__(self, scene: Scene | None = None, source: str = "") -> None:
        self._past: list[EditState | Action] = []
        self._future: list[EditState | Action] = []
        self._kind = ""
        self._apply(_edit_state(default_scene() if scene is None else scene, source))

    def _apply(self, state: EditState) -> None:
        self.texts, self.over_time = dict(state.texts), state.over_time
        self._loaded, self.source = state.loaded, state.source

    @property
    def edit_state(self) -> EditState:
        """The edited state, for `restore` in this or another session."""
        return EditState(dict(self.texts), self.over_time, self._loaded, self.source)

    def restore(self, state: EditState) -> None:
        """Restore an edited state as one step that can be undone."""
        self._begin_step()
        self._apply(state)

    def close_step(self) -> None:
        """Make the next edit a separate undo step."""
        self._kind = ""

    def _begin_step(self, kind: str = "") -> None:
        # Record the state before an edit; an edit without a kind is a separate step.
        self._future.clear()
        if not kind or kind != self._kind:
            self._past.append(self.edit_state)
            del self._past[:-_MAX_STEPS]
        self._kind = kind

    @property
    def can_undo(self) -> bool:
        """Whether there is an edit to undo."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """Whether there is an edit to redo."""
        return bool(self._future)

    def undo(self) -> bool:
        """Undo the last edit. Returns False if there is nothing to undo."""
        return self._turn(self._past, self._future)

    def redo(self) -> bool:
        """Redo the last undone edit. Returns False if there is nothing to redo."""
        return self._turn(self._future, self._past)

    def _turn(self, source: list[EditState | Action], target: list[EditState | Action]) -> bool:
        self.close_step()
        if not source:
            return False
        step = source.pop()
        target.append(step if isinstance(step, Action) else self.edit_state)
        if isinstance(step, EditState):
            self._apply(step)
        elif source is self._past:
            step.undo()
        else:
            step.redo()
        return True

    def record(self, action: Action) -> None:
        """Record a completed action as an undo step."""
        self.close_step()
        self._future.clear()
        self._past.append(action)
        # Actions may hold results.
        for step in [step for step in self._past if isinstance(step, Action)][:-_MAX_ACTIONS]:
            self._past.remove(step)

    def load(self, scene: Scene, source: str = "") -> None:
        """Load a scene: replace all texts. `source` is its preset or file, if it has one."""
        self.restore(_edit_state(scene, source))

    def record_saved(self, scene: Scene, source: str) -> None:
        """Record that the edited scene was saved to a file; this is not an undo step."""
        for steps in (self._past, self._future):
            steps[:] = [
                replace(step, loaded=scene, source=source)
                if isinstance(step, EditState) and step.loaded is self._loaded
                else step
                for step in steps
            ]
        self._loaded, self.source = scene, source

    @property
    def loaded(self) -> Scene:
        """The loaded scene, without edits."""
        return self._loaded

    @property
    def name(self) -> str:
        """Name of the loaded scene."""
        return self._loaded.name

    @property
    def description(self) -> str:
        """Description of the loaded scene."""
        return self._loaded.description

    @property
    def changed_fields(self) -> list[str]:
        """Names of the fields whose text or table over time differs from the loaded scene."""
        tables, loaded = dict(self.over_time), dict(self._loaded.over_time)
        return [
            name
            for name, field in FIELDS.items()
            if self.texts[name] != field.text_of(self._loaded)
            or tables.get(name) != loaded.get(name)
        ]

    def set_text(self, name: str, text: str) -> None:
        """Edit a field's text, valid or not."""
        if self.texts[name] != text:
            self._set(name, text, "type")

    def _set(self, name: str, text: str, how: str) -> None:
        self._begin_step(f"{how} {name}")
        self.texts[name] = text

    def set_tables(self, over_time: OverTime) -> None:
        """Let parameters follow tables over time; other texts do not change."""
        self._begin_step()
        self.over_time = over_time
        self.texts |= {name: initial_value_text(table) for name, table in over_time}

    def reset(self, name: str) -> None:
        """Reset a field, and its table over time, to the loaded scene."""
        self._set(name, FIELDS[name].text_of(self._loaded), "reset")
        table, tables = dict(self._loaded.over_time).get(name), dict(self.over_time)
        if table is not None:
            tables[name] = table
        else:
            tables.pop(name, None)
        self.over_time = tuple(tables.items())
        self.close_step()

    def reset_all(self) -> None:
        """Reset all fields to the loaded scene."""
        self.load(self._loaded, self.source)
