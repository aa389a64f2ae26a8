"""Actions of the main screen on its parts and tabs.

The main screen is the laboratory, in which a scene, a parameter set with the settings of its run,
is edited and run. Its verdict says whether the slider is stable.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from textual.screen import Screen
from textual.widgets import Input

from fivtui.model import ComputationError, InputError
from fivtui.results import Row
from fivtui.scene import scene_file
from fivtui.tui.session import EQUATIONS, HINTS, Session, field_help
from fivtui.tui.tabs import ActionPane, Pane, Reported, TabBook, TabLine

from .dialogs import HelpDialog, PartKey
from .form.form import FieldList, Form, field_of
from .keys import active_keys
from .run_list import RunsTable


class LabActions(Screen[None]):
    """Actions that key bindings and palette entries of the main screen call."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.session = session

    def show_inputs(self) -> None:
        """Display the fields, their errors and the verdict."""
        raise NotImplementedError

    def show_edit(self, report: str) -> None:
        """Display the inputs after an edit, and report it."""
        self.show_inputs()
        self.report(report)

    def report(self, text: str, *, error: bool = False, routine: bool = False) -> None:
        """Log a message; unless it is `routine`, notify the user."""
        self.post_message(Reported(text, error=error, routine=routine))

    @contextmanager
    def report_errors(self) -> Iterator[None]:
        """Report an `InputError` or `ComputationError` instead of raising it."""
        try:
            yield
        except (InputError, ComputationError) as error:
            self.report(str(error), error=True)

    def run_in_thread(self, name: str, function: Callable[[], object]) -> None:
        """Call a function in a thread; `name` appears in the report of an unexpected error."""
        self.run_worker(function, name=name, thread=True, exit_on_error=False)

    @property
    def tab_book(self) -> TabBook:
        """The tabs."""
        return self.query_one(TabBook)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Whether an action is available, such as stop during a run."""
        session, is_running = self.session, self.session.runs.active is not None
        field = field_of(self.focused)
        # Typing in an input of a tab does not edit the scene.
        edits_scene = field is not None or not isinstance(self.focused, Input)
        conditions = {
            "run": not is_running,
            "compare_engines": not is_running,
            "stop": is_running,
            "reset": field is not None,
            "reload_scene": scene_file(session.source) is not None,
            "undo": bool(session.undo_steps) and edits_scene,
            "redo": bool(session.redo_steps) and edits_scene,
            "set_belt": parameters != (session.belt_is_finite,),
            "drop_tables": bool(session.over_time),
        }
        return conditions.get(action, True)

    def _remove_welcome(self) -> None:
        self.query("#welcome").remove()

    def action_switch_tab(self, direction: int) -> None:
        """Show the next (+1) or previous (-1) tab."""
        self._remove_welcome()
        self.tab_book.show_neighbour(direction)

    def action_toggle_runs(self) -> None:
        """Show and focus the list of runs, or hide it."""
        if self.query_one(RunsTable).has_focus:
            self.remove_class("-runs")
            self.focus_field("mu")
        else:
            self.action_focus_part("runs")

    def action_toggle_computation(self) -> None:
        """Start or stop the computation of the current tab."""

        def toggle(pane: Pane) -> None:
            if isinstance(pane, ActionPane):
                pane.toggle_computation()
            else:
                self.app.bell()

        self.tab_book.when_ready(toggle)

    def action_show_tab(self, name: str) -> None:
        """Show the tab with the identifier `name`."""
        self._remove_welcome()
        self.tab_book.show(name)

    def action_help(self) -> None:
        """Show the active keys, help on the focused field, and the equations."""
        rows, field = active_keys(self), field_of(self.focused)
        if field is not None:
            heading = Row("", f"{field.name}: {field.meaning}")
            rows += [Row("", ""), heading, *field_help(field)]
        self.app.push_screen(HelpDialog([*rows, Row("", ""), *HINTS, Row("", ""), *EQUATIONS]))

    def action_focus_part(self, part: str) -> None:
        """Focus a part of the screen: fields, tabs, runs, or the bar or plot of the current tab."""
        if part == "fields":
            self.query_one(FieldList).action_edit()
        elif part == "tabs":
            self.query_one(TabLine).focus()
        elif part == "runs":
            self.add_class("-runs")
            self.query_one(RunsTable).focus()
        else:
            self.tab_book.when_ready(lambda pane: pane.focus_content(bar_first=part == "bar"))

    def action_ask_part(self) -> None:
        """Focus the part of the screen that the next key names."""
        self.app.push_screen(PartKey(), lambda part: self.action_focus_part(part) if part else None)

    def focus_field(self, name: str) -> None:
        """Focus a field of the form."""
        self.query_one(Form).editor(name).focus()
