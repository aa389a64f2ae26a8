"""Edited field texts of a scene, with undo. Imports no Textual."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final

from fivtui.model import TimeTable
from fivtui.ranges import number_text
from fivtui.scene import OverTime, Scene

from .fields import FIELDS, scene_texts
from .scene_differences import base_scene

# Maximum number of undo steps, and of those that are an `Action`.
_MAX_STEPS: Final = 1000
_MAX_ACTIONS: Final = 20


@dataclass(frozen=True, slots=True)
class EditState:
    """Edited texts and tables over time, the loaded scene, and the scene's preset or file."""

    texts: Mapping[str, str]
    over_time: OverTime
    loaded: Scene
    source: str


@dataclass(frozen=True, slots=True)
class Action:
    """An undo step that does not edit texts, such as the deletion of a run."""

    undo: Callable[[], None]
    redo: Callable[[], None]


def initial_value_text(table: TimeTable) -> str:
    """The field text of a parameter that follows a table over time: its value just after t = 0."""
    value, _slope = table.after(0.0)
    return number_text(value)


def loaded_state(scene: Scene, source: str) -> EditState:
    """The unedited state of a scene from a preset or file, `source`."""
    return EditState(scene_texts(scene), scene.over_time, scene, source)


class Editing:
    """Field texts edited from a scene, with undo.

    Consecutive edits of one kind are one undo step, so a number is undone as a whole.
    """

    def __init__(self, scene: Scene | None = None, source: str = "") -> None:
        self.undo_steps: list[EditState | Action] = []
        self.redo_steps: list[EditState | Action] = []
        self._step_kind = ""
        self._apply(loaded_state(scene or base_scene(), source))

    def _apply(self, state: EditState) -> None:
        self.texts, self.over_time = dict(state.texts), state.over_time
        self.loaded, self.source = state.loaded, state.source

    @property
    def edit_state(self) -> EditState:
        """The current texts, tables and loaded scene, as `restore` takes them."""
        return EditState(dict(self.texts), self.over_time, self.loaded, self.source)

    def restore(self, state: EditState) -> None:
        """Replace texts, tables and loaded scene in one undo step."""
        self._begin_step()
        self._apply(state)

    def close_undo_step(self) -> None:
        """Make the next edit a separate undo step."""
        self._step_kind = ""

    def _begin_step(self, kind: str = "") -> None:
        # Record the state before an edit, unless the previous edit is of the same kind. An edit
        # without a kind is always a separate step.
        self.redo_steps.clear()
        if not kind or kind != self._step_kind:
            self.undo_steps.append(self.edit_state)
            del self.undo_steps[:-_MAX_STEPS]
        self._step_kind = kind

    def undo(self) -> bool:
        """Undo the last edit. Returns False if there is nothing to undo."""
        return self._move(self.undo_steps, self.redo_steps)

    def redo(self) -> bool:
        """Redo the last undone edit. Returns False if there is nothing to redo."""
        return self._move(self.redo_steps, self.undo_steps)

    def _move(self, source: list[EditState | Action], target: list[EditState | Action]) -> bool:
        # Move the last step from `source` to `target`, and apply it.
        self.close_undo_step()
        if not source:
            return False
        step = source.pop()
        target.append(step if isinstance(step, Action) else self.edit_state)
        if isinstance(step, EditState):
            self._apply(step)
        elif source is self.undo_steps:
            step.undo()
        else:
            step.redo()
        return True

    def record(self, action: Action) -> None:
        """Record a completed action as an undo step."""
        self.close_undo_step()
        self.redo_steps.clear()
        self.undo_steps.append(action)
        # Limit the number of actions, because they may hold results.
        for step in [step for step in self.undo_steps if isinstance(step, Action)][:-_MAX_ACTIONS]:
            self.undo_steps.remove(step)

    def load(self, scene: Scene, source: str = "") -> None:
        """Replace all texts by those of a scene; `source` is its preset or file, or empty."""
        self.restore(loaded_state(scene, source))

    def record_saved(self, scene: Scene, source: str) -> None:
        """Record that the edited scene was saved to a file; this is not an undo step."""
        # Undo and redo also restore the loaded scene and its file: for the edits of this scene,
        # these become the saved scene and its file.
        for steps in (self.undo_steps, self.redo_steps):
            steps[:] = [
                replace(step, loaded=scene, source=source)
                if isinstance(step, EditState) and step.loaded is self.loaded
                else step
                for step in steps
            ]
        self.loaded, self.source = scene, source

    @property
    def name(self) -> str:
        """Name of the loaded scene."""
        return self.loaded.name

    @property
    def changed_fields(self) -> list[str]:
        """Names of the fields whose text or table over time differs from the loaded scene."""
        tables, loaded = dict(self.over_time), dict(self.loaded.over_time)
        return [
            name
            for name, text in scene_texts(self.loaded).items()
            if self.texts[name] != text or tables.get(name) != loaded.get(name)
        ]

    def set_text(self, name: str, text: str) -> None:
        """Edit a field's text, valid or not."""
        if self.texts[name] != text:
            self._set_field(name, text, "type")

    def _set_field(self, name: str, text: str, kind: str) -> None:
        self._begin_step(f"{kind} {name}")
        self.texts[name] = text

    def set_tables(self, over_time: OverTime) -> None:
        """Set the parameters that follow tables over time, and their texts."""
        self._begin_step()
        self.over_time = over_time
        self.texts |= {name: initial_value_text(table) for name, table in over_time}

    def reset(self, name: str) -> None:
        """Reset a field, and its table over time, to the loaded scene."""
        self._set_field(name, FIELDS[name].text_of(self.loaded), "reset")
        table, tables = dict(self.loaded.over_time).get(name), dict(self.over_time)
        if table is not None:
            tables[name] = table
        else:
            tables.pop(name, None)
        self.over_time = tuple(tables.items())
        self.close_undo_step()

    def reset_all(self) -> None:
        """Reset all fields to the loaded scene."""
        self.load(self.loaded, self.source)
