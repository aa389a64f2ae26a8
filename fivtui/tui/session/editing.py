"""Edited field texts of a scene, with undo. Imports no Textual."""

from fivtui.model import TimeTable
from fivtui.ranges import number_text
from fivtui.scene import OverTime, Scene

from .fields import FIELDS
from .history import Action, Edited, History
from .scene_differences import base_scene


def text_at_start(table: TimeTable) -> str:
    """The text of a parameter that follows a table: its value from t = 0 on."""
    return number_text(table.after(0.0)[0])


def _edited(scene: Scene, source: str) -> Edited:
    texts = {name: field.text_of(scene) for name, field in FIELDS.items()}
    return Edited(texts, scene.over_time, scene, source)


class Editing:
    """Field texts edited from a scene, with undo."""

    def __init__(self, scene: Scene | None = None, source: str = "") -> None:
        self._history = History()
        self._take(_edited(base_scene() if scene is None else scene, source))

    def _take(self, state: Edited) -> None:
        self.texts, self.over_time = dict(state.texts), state.over_time
        self._loaded, self.source = state.loaded, state.source

    @property
    def edited(self) -> Edited:
        """The edited state, for `restore` in this or another session."""
        return Edited(dict(self.texts), self.over_time, self._loaded, self.source)

    def restore(self, state: Edited) -> None:
        """Restore an edited state as one step that can be undone."""
        self._history.close()
        self._history.before(self.edited, "restore")
        self._history.close()
        self._take(state)

    def close_step(self) -> None:
        """Make the next edit a separate undo step."""
        self._history.close()

    @property
    def can_undo(self) -> bool:
        """Whether there is an edit to undo."""
        return self._history.can_undo

    @property
    def can_redo(self) -> bool:
        """Whether there is an edit to redo."""
        return self._history.can_redo

    def undo(self) -> bool:
        """Undo the last edit. Returns False if there is nothing to undo."""
        return self._turn(self._history.undo(self.edited))

    def redo(self) -> bool:
        """Redo the last undone edit. Returns False if there is nothing to redo."""
        return self._turn(self._history.redo(self.edited))

    def _turn(self, state: Edited | None) -> bool:
        if state is None:
            return False
        self._take(state)
        return True

    def load(self, scene: Scene, source: str = "") -> None:
        """Load a scene: replace all texts. `source` is its preset or file, if it has one."""
        self.restore(_edited(scene, source))

    def saved(self, scene: Scene, source: str) -> None:
        """Record that the edited scene was saved to a file; this is not an undo step."""
        self._history.saved(self._loaded, scene, source)
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
    def changed(self) -> list[str]:
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
        self._history.before(self.edited, f"{how} {name}")
        self.texts[name] = text

    def set_tables(self, over_time: OverTime) -> None:
        """Let parameters follow tables over time; the texts of others stay."""
        self.close_step()
        self._history.before(self.edited, "tables")
        self.close_step()
        self.over_time = over_time
        self.texts |= {name: text_at_start(table) for name, table in over_time}

    def record(self, action: Action) -> None:
        """Make an action that has been done a step that can be undone."""
        self._history.record(action)

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
