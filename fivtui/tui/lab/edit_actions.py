"""Edits of the session's fields: typed texts, steps, loaded scenes, undo and reset."""

from collections.abc import Callable

from textual import on

from fivtui.model import BELT_PARAMETERS
from fivtui.ranges import number_text
from fivtui.tui.tabs import FieldEdited, FieldStepped, RunsChanged, SceneLoaded

from .actions import LabActions
from .form.form import Form, field_of


class EditActions(LabActions):
    """Actions on fields, by keys, commands and messages."""

    @on(FieldEdited)
    def _edit_field(self, event: FieldEdited) -> None:
        # If the editor has a newer text, the message of that one follows.
        if self.query_one(Form).editor(event.name).text == event.text:
            self.set_text(event.name, event.text)

    def set_text(self, name: str, text: str) -> None:
        """Edit a field's text."""
        if self.session.texts[name] != text:
            self.session.set_text(name, text)
            # A key that waits may change the text before all inputs are displayed.
            self.query_one(Form).editor(name).show(text)
            self.show_inputs()

    @on(FieldStepped)
    def _step_field(self, event: FieldStepped) -> None:
        if self.session.step_field(event.name, event.direction, fine=event.fine):
            self.show_inputs()
        else:
            self.app.bell()

    @on(SceneLoaded)
    def _load_scene(self, event: SceneLoaded) -> None:
        self.session.load(event.scene, event.source)
        self.session.add_recent(event.source)
        self.show_edit(event.report)

    def action_drop_tables(self) -> None:
        """Remove the tables over time; their parameters keep their values at t = 0."""
        self.session.set_tables(())
        self.show_edit("tables over time dropped")

    def action_undo(self) -> None:
        """Undo the last edit."""
        self._change_history(self.session.undo)

    def action_redo(self) -> None:
        """Redo the last undone edit."""
        self._change_history(self.session.redo)

    def action_reset(self) -> None:
        """Reset the focused field to its value in the loaded scene."""
        field = field_of(self.focused)
        if field is not None:
            self.session.reset(field.name)
            self.show_inputs()

    def action_reset_all(self) -> None:
        """Reset all fields to their values in the loaded scene."""
        self.session.reset_all()
        self.show_inputs()

    def action_switch_engine(self) -> None:
        """Switch to the next engine: native solver, Python FMU, native FMU."""
        self.session.switch_engine()
        self.show_edit(f"engine {self.session.engine}: method {self.session.texts['method']}")

    def action_set_belt(self, finite: bool) -> None:
        """Give the belt a finite speed, or none: then it is always faster than the slider."""
        session, form = self.session, self.query_one(Form)
        for name, spec in BELT_PARAMETERS.items():
            # The other parameters of a belt of finite speed are optional.
            session.set_text(name, number_text(spec.default) if finite and name == "v_belt" else "")
        session.close_undo_step()
        # The form keeps a hidden row that is being edited.
        self.set_focus(form.editor("mu"))
        self.show_inputs()
        if finite:
            self.call_after_refresh(self.focus_field, "v_belt")

    def _change_history(self, change: Callable[[], object]) -> None:
        # An undo step may restore or delete a run.
        runs_before = list(self.session.runs)
        change()
        self.show_inputs()
        if list(self.session.runs) != runs_before:
            self.post_message(RunsChanged())
