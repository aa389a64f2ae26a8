"""Edits of the session's fields: typing, steps, scenes, undo and reset."""

from collections.abc import Callable
from pathlib import Path

from textual import on

from fivtui.io import describe_files
from fivtui.model import BELT_PARAMETERS
from fivtui.ranges import number_text
from fivtui.scene import PRESETS, OverTime, Scene
from fivtui.tui.tabs import FieldEdited, FieldStepped, RunsChanged, SceneLoaded

from .actions import LabActions
from .form.form import Form, field_of


class EditActions(LabActions):
    """Actions on fields, by keys, commands and messages."""

    @on(FieldEdited)
    def _edited(self, event: FieldEdited) -> None:
        # Ignore typed text that undo or reset has replaced.
        form, session = self.query_one(Form), self.session
        current = not event.typed or form.text_of(event.name) == event.text
        if current and session.texts[event.name] != event.text:
            session.set_text(event.name, event.text)
            self.show_inputs()

    @on(FieldStepped)
    def _stepped(self, event: FieldStepped) -> None:
        self._show_or_ring(self.session.step_field(event.name, event.direction, fine=event.fine))

    @on(SceneLoaded)
    def _loaded(self, event: SceneLoaded) -> None:
        self.session.load(event.scene, event.source)
        self._remember(event.source)
        self.show_inputs()
        self.report(event.report)

    def set_tables(self, over_time: OverTime, report: str) -> None:
        """Replace the tables over time, which may be empty, and log `report`."""
        self.session.set_tables(over_time)
        self.show_inputs()
        self.report(report)

    def action_drop_tables(self) -> None:
        """Keep the parameters over time at their values at t = 0."""
        self.set_tables((), "tables over time dropped")

    def record_saved_scene(self, scene: Scene, path: Path) -> None:
        """Record that the edited scene was saved to a file."""
        self.session.record_saved(scene, str(path))
        self._remember(str(path))
        self.show_inputs()
        self.report(f"scene {scene.name} saved: {describe_files(path)}")

    def action_undo(self) -> None:
        """Undo the last edit."""
        self._turn(self.session.undo)

    def action_redo(self) -> None:
        """Redo the last undone edit."""
        self._turn(self.session.redo)

    def action_reset(self) -> None:
        """Reset the focused field to the scene's value."""
        field = field_of(self.focused)
        if field is not None:
            self.session.reset(field.name)
        self._show_or_ring(field is not None)

    def action_reset_all(self) -> None:
        """Reset all fields to the scene's values."""
        self.session.reset_all()
        self.show_inputs()

    def action_switch_engine(self) -> None:
        """Switch to the next engine: native solver, Python FMU, native FMU."""
        self.session.switch_engine()
        self.show_inputs()
        self.report(f"engine {self.session.engine}: method {self.session.texts['method']}")

    def action_switch_belt(self) -> None:
        """Give the belt a finite speed, or make it faster than the slider again."""
        session, form = self.session, self.query_one(Form)
        finite = session.belt_is_finite
        for name, spec in BELT_PARAMETERS.items():
            text = number_text(spec.default) if name == "v_belt" and not finite else ""
            session.set_text(name, text)
        session.close_step()
        self.show_inputs()
        if finite:
            form.focus_field("mu")
            form.hide_belt()
        else:
            form.call_after_refresh(form.focus_field, "v_belt")

    def _turn(self, turn: Callable[[], bool]) -> None:
        # The step may restore or delete a run.
        before = list(self.session.runs)
        self._show_or_ring(turn())
        if list(self.session.runs) != before:
            self.post_message(RunsChanged())

    def _show_or_ring(self, changed: bool) -> None:
        if changed:
            self.show_inputs()
        else:
            self.app.bell()

    def _remember(self, source: str) -> None:
        if source and source not in PRESETS:
            self.session.add_recent(source)
