"""What the keys and the palette do on the main screen; edits, runs and files have controllers."""

from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from textual.binding import ActiveBinding
from textual.screen import Screen

from fivtui.model import InputError
from fivtui.tui.session import Session
from fivtui.tui.tabs import Pane, Reported, TabBook

from .edit_control import EditController
from .form.form import Form, field_of
from .run_control import RunController
from .run_list import RunsPane

if TYPE_CHECKING:
    from .file_control import FileController


class LabActions(Screen[None]):
    """The actions of the main screen, by their names in bindings and commands."""

    _editor: EditController

    def __init__(self, session: Session, *, welcome: bool) -> None:
        super().__init__()
        self.session = session
        self._welcome = welcome
        self._run_controller = RunController(self, session)

    @cached_property
    def _files(self) -> "FileController":
        # Imported late: it loads slow modules.
        from .file_control import FileController

        return FileController(self, self.session)

    @property
    def _book(self) -> TabBook:
        return self.query_one(TabBook)

    @property
    def active_bindings(self) -> dict[str, ActiveBinding]:
        """The active keys, the laboratory's before those of the focused widget."""
        bindings = super().active_bindings
        return dict(sorted(bindings.items(), key=lambda item: item[1].node is not self))

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:  # noqa: ARG002
        """Whether an action applies now: one of run and stop."""
        running = self.session.runs.active is not None
        applies = {"run": not running, "stop": running, "run_both": not running}
        return applies.get(action, True)

    def action_run(self) -> None:
        """Run the edited scene."""
        if self._run_controller.start():
            self.show_tab("transient")

    def action_stop(self) -> None:
        """Stop the active run."""
        self._run_controller.stop()

    def _end_welcome(self) -> None:
        if self._welcome:
            self._welcome = False
            self.query("#welcome").remove()

    def action_turn_tab(self, direction: int) -> None:
        """Show the next (+1) or previous (-1) tab."""
        self._end_welcome()
        self._book.turn(direction)

    def action_list_runs(self) -> None:
        """Show and focus the list of runs, or hide it."""
        pane = self.query_one(RunsPane)
        if pane.has_focus_within:
            self.remove_class("-runs")
            self.query_one(Form).focus_field("mu")
        else:
            self.add_class("-runs")
            pane.take_focus()

    def action_work(self) -> None:
        """Start or stop the computation of the current tab."""

        def work(pane: Pane) -> None:
            if not pane.work():
                self.app.bell()

        self._book.when_ready(work)

    def action_show_tab(self, name: str) -> None:
        """Show a tab."""
        self.show_tab(name)

    def show_tab(self, name: str) -> None:
        """Show the tab with this identifier."""
        self._end_welcome()
        self._book.show(name)

    def when_pane(self, what: Callable[[Pane], None]) -> None:
        """Call a function with the pane of the current tab as soon as it exists."""
        self._book.when_ready(what)

    @property
    def pane(self) -> Pane | None:
        """The pane of the current tab, None before it is created."""
        return self._book.pane

    def action_export(self, what: str) -> None:
        """Export figure or data of the current tab."""
        self._book.when_ready(lambda pane: self._export(pane, what))

    def _export(self, pane: Pane, what: str) -> None:
        try:
            self._files.export(pane.export(what))
        except InputError as error:
            self.post_message(Reported(str(error), error=True))

    def action_open_scene(self) -> None:
        """Open a scene or result file."""
        self._files.open_scene()

    def action_open_recent(self, path: str) -> None:
        """Open a recent scene file."""
        self._files.open_path(Path(path))

    def action_save_scene(self) -> None:
        """Save the edited scene to its file."""
        self._files.save_scene(ask=False)

    def action_save_scene_as(self) -> None:
        """Save the edited scene to another file."""
        self._files.save_scene(ask=True)

    def action_read_result(self) -> None:
        """Read a run, sweep, map or trade-off from a file."""
        self._files.read_result()

    def action_read_tables(self) -> None:
        """Read preload, friction or belt speed over time from a file."""
        self._files.read_tables()

    def action_drop_tables(self) -> None:
        """Keep the parameters over time at their values at t = 0."""
        self._files.drop_tables()

    def action_undo(self) -> None:
        """Undo the last edit."""
        self._editor.undo()

    def action_redo(self) -> None:
        """Redo the last undone edit."""
        self._editor.redo()

    def action_switch_engine(self) -> None:
        """Switch to the next engine: native solver, Python FMU, native FMU."""
        self._editor.switch_engine()

    def action_switch_belt(self) -> None:
        """Give the belt a finite speed, or make it faster than the slider again."""
        self._editor.switch_belt()

    def action_run_both(self) -> None:
        """Run the edited scene by the native solver and an FMU, and compare them."""
        if self._run_controller.start_both():
            self.show_tab("transient")

    def action_reset(self) -> None:
        """Reset the focused field to the scene's value."""
        self._editor.reset()

    def action_reset_all(self) -> None:
        """Reset all fields to the scene's values."""
        self._editor.reset_all()

    def action_help(self) -> None:
        """Show all keys that work now, then help on the focused field, then the equations."""
        from fivtui.results import Row
        from fivtui.tui.session import field_help, general_help

        from .dialogs import HelpDialog
        from .keys import active_keys

        rows, field = active_keys(self), field_of(self.focused)
        if field is not None:
            heading = Row("", f"{field.name}: {field.meaning}")
            rows += [Row("", ""), heading, *field_help(field)]
        self.app.push_screen(
            HelpDialog("Keys that work now", [*rows, Row("", ""), *general_help()])
        )

    def action_jump(self, place: str) -> None:
        """Focus a part of the screen: fields, tabs, bar, plot or runs."""
        if place == "fields":
            self.query_one(Form).take_focus()
        elif place == "tabs":
            self._book.take_focus()
        elif place == "runs":
            self.add_class("-runs")
            self.query_one(RunsPane).take_focus()
        else:
            self._book.when_ready(lambda pane: pane.take_focus(bar=place == "bar"))

    def action_copy_command(self) -> None:
        """Copy the command that computes what the current tab shows."""
        self._book.when_ready(self._files.copy_command)

    def action_copy_plot(self) -> None:
        """Copy the plots of the current tab as text."""
        self._book.when_ready(self._files.copy_plot)

    def action_copy_picture(self) -> None:
        """Copy the figure of the current tab as a picture."""
        self._book.when_ready(self._files.copy_picture)

    def edit_field(self, name: str) -> None:
        """Focus a field of the form."""
        self.query_one(Form).focus_field(name)
