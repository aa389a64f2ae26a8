"""Edits the session's fields: typing, steps, scenes, undo and reset."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from fivtui.io import files_text
from fivtui.model import BELT_PARAMETERS
from fivtui.ranges import number_text
from fivtui.scene import PRESETS
from fivtui.tui.session import Session
from fivtui.tui.tabs import (
    FieldEdited,
    FieldStepped,
    PointOpened,
    Reported,
    RunsChanged,
    SceneLoaded,
    SceneSaved,
    TablesChosen,
)

from .form.form import Form, field_of

if TYPE_CHECKING:
    from .screen import LabScreen


class EditController:
    """Carries out edits of a session for the screen, which displays them."""

    def __init__(self, screen: "LabScreen", session: Session) -> None:
        self._screen = screen
        self._session = session

    def edited(self, event: FieldEdited) -> None:
        """Take what was typed, unless undo or reset has replaced it since, or nothing changed."""
        known = self._session.texts[event.name] == event.text
        form = self._screen.query_one(Form)
        if not known and (not event.typed or form.text_of(event.name) == event.text):
            self._session.set_text(event.name, event.text)
            self._screen.show_inputs()

    def stepped(self, event: FieldStepped) -> None:
        """Change a number by a step."""
        self._turned(self._session.step_field(event.name, event.direction, fine=event.fine))

    def loaded(self, event: SceneLoaded) -> None:
        """Edit a scene in place of the present one."""
        self._session.load(event.scene, event.source)
        self._remember(event.source)
        self._screen.show_inputs()
        self._tell(event.words)

    def tables_chosen(self, event: TablesChosen) -> None:
        """Let parameters follow other tables over time, or none."""
        self._session.set_tables(event.over_time)
        self._screen.show_inputs()
        self._tell(event.words)

    def point_opened(self, event: PointOpened) -> None:
        """Put a point of a chart into the fields."""
        for name, text in event.texts.items():
            self._session.set_text(name, text)
        self._screen.show_inputs()
        self._screen.post_message(Reported(event.words, routine=True))

    def saved(self, event: SceneSaved) -> None:
        """Take a file as that of the edited scene."""
        self._session.saved(event.scene, str(event.path))
        self._remember(str(event.path))
        self._screen.show_inputs()
        self._tell(f"scene {event.scene.name} saved: {files_text(event.path)}")

    def undo(self) -> None:
        """Undo the last edit."""
        self._follow(self._session.undo)

    def redo(self) -> None:
        """Redo the last undone edit."""
        self._follow(self._session.redo)

    def reset(self) -> None:
        """Reset the focused field to the scene's value."""
        field = field_of(self._screen.focused)
        if field is not None:
            self._session.reset(field.name)
        self._turned(field is not None)

    def reset_all(self) -> None:
        """Reset all fields to the scene's values."""
        self._session.reset_all()
        self._screen.show_inputs()

    def switch_engine(self) -> None:
        """Switch to the next engine: native solver, Python FMU, native FMU."""
        self._session.switch_engine()
        self._screen.show_inputs()
        self._tell(f"engine {self._session.engine}: method {self._session.texts['method']}")

    def switch_belt(self) -> None:
        """Give the belt a finite speed, or make it faster than the slider again."""
        session, form = self._session, self._screen.query_one(Form)
        finite = session.belt_is_finite
        for name, spec in BELT_PARAMETERS.items():
            text = number_text(spec.default) if name == "v_belt" and not finite else ""
            session.set_text(name, text)
        session.close_step()
        self._screen.show_inputs()
        if finite:
            form.focus_field("mu")
            form.hide_belt()
        else:
            form.call_after_refresh(form.focus_field, "v_belt")

    def _follow(self, turn: Callable[[], bool]) -> None:
        # A step may be a deleted run.
        before = list(self._session.runs)
        self._turned(turn())
        if list(self._session.runs) != before:
            self._screen.post_message(RunsChanged())

    def _turned(self, done: bool) -> None:
        if done:
            self._screen.show_inputs()
        else:
            self._screen.app.bell()

    def _remember(self, source: str) -> None:
        if source and source not in PRESETS:
            self._session.remember(source)

    def _tell(self, words: str) -> None:
        self._screen.post_message(Reported(words))
