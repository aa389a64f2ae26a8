"""The main screen: form, verdict and tabs around one session."""

from datetime import datetime
from typing import ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.notifications import SeverityLevel
from textual.screen import Screen
from textual.widgets import Footer, RichLog, TabbedContent, TabPane
from textual.worker import Worker, WorkerState

from fivtui.core.errors import ComputationError, InputError

from .dialogs import HelpDialog
from .file_desk import FileDesk
from .form import Form, field_of
from .help import field_help, general_help
from .messages import (
    ExportEnded,
    FieldEdited,
    FieldNudged,
    Reported,
    RunChosen,
    RunsChanged,
    SceneLoaded,
)
from .plots import TransientPlots
from .report import result_rows, stability_brief, stability_rows, verdict
from .runs import Run
from .runs_pane import RunsPane
from .session import Session
from .table import RowsView
from .transient_pane import TransientPane
from .verdict import VerdictView

_LAST_PART = 0.1


class LabScreen(Screen[None]):
    """The laboratory.

    Parameters
    ----------
    session : Session
        Its state.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("f5,ctrl+r", "run", "Run", key_display="F5"),
        Binding("f5,ctrl+r", "stop", "Stop", key_display="F5"),
        Binding("f1", "help", "Help", key_display="F1"),
        Binding("f2", "turn_tab(1)", "Tab", key_display="F2"),
        Binding("shift+f2", "turn_tab(-1)", "Previous tab", show=False),
        Binding("f6", "export('figure')", "Figure…", key_display="F6"),
        Binding("f7", "export('data')", "Data…", key_display="F7"),
        Binding("f8", "reset", "Reset", key_display="F8"),
        Binding("shift+f8", "reset_all", "Reset all", show=False),
        Binding("ctrl+o", "open_scene", "Open a scene", show=False),
        Binding("ctrl+s", "save_scene", "Save the scene", show=False),
    ]

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.session = session
        self._files = FileDesk(self, session)

    def compose(self) -> ComposeResult:
        """Form at the left, verdict and tabs at the right."""
        with Horizontal(id="bench"):
            yield Form(id="form")
            with Vertical(id="results"):
                yield VerdictView(id="verdict")
                with TabbedContent(id="tabs"):
                    yield TransientPane(self.session)
                    with TabPane("Result", id="result"):
                        yield RowsView(id="result-rows")
                    with TabPane("Stability", id="stability"):
                        yield RowsView(id="stability-rows")
                    yield RunsPane()
                    with TabPane("Log", id="log"):
                        yield RichLog(id="log-lines", wrap=True, min_width=20, markup=False)
        yield Footer(compact=True)

    def on_mount(self) -> None:
        """Show the session."""
        self.query_one("#result-rows", RowsView).show([], "no result yet: F5 runs")
        self.show_inputs()
        self._show_runs()
        self.query_one(Form).focus_field("m")
        self.app.theme_changed_signal.subscribe(self, lambda _: self._redraw())

    def _redraw(self) -> None:
        self.call_after_refresh(self.query_one(TransientPlots).redraw)

    @property
    def shown(self) -> Run | None:
        """The run whose result is shown."""
        return self.query_one(TransientPane).shown

    @on(Reported)
    def _reported(self, event: Reported) -> None:
        if not event.routine:
            severity: SeverityLevel = "error" if event.error else "information"
            self.notify(event.words, severity=severity, markup=False)
        mark = "ERROR: " if event.error else ""
        line = f"{datetime.now():%H:%M:%S} {mark}{event.words}"
        self.query_one("#log-lines", RichLog).write(line)

    # Editing

    @on(FieldEdited)
    def _edited(self, event: FieldEdited) -> None:
        self.session.set_text(event.name, event.text)
        self.show_inputs()

    @on(FieldNudged)
    def _nudged(self, event: FieldNudged) -> None:
        if self.session.nudge(event.name, event.direction, fine=event.fine):
            self.show_inputs()
        else:
            self.app.bell()

    @on(SceneLoaded)
    def _loaded(self, event: SceneLoaded) -> None:
        self.session.load(event.scene, event.source)
        self.show_inputs()
        self.post_message(Reported(f"scene {event.scene.name}: {event.source}"))

    def show_inputs(self) -> None:
        """Show the session's texts, what is wrong with them, and the verdict."""
        session = self.session
        mark = " (changed)" if session.changed else ""
        self.query_one(Form).show(f"{session.name}{mark}", session.texts, session.errors)
        self._show_verdict()
        self.query_one(TransientPane).show_status()

    def _show_verdict(self) -> None:
        view = self.query_one(VerdictView)
        rows = self.query_one("#stability-rows", RowsView)
        try:
            parameters, found = self.session.parameters(), self.session.stability()
        except (InputError, ComputationError) as error:
            why = ": invalid input" if isinstance(error, InputError) else ""
            view.show("invalid", [f"NO VERDICT{why}", str(error)])
            rows.show([], str(error))
        else:
            view.show(verdict(found).lower(), stability_brief(parameters, found))
            rows.show(stability_rows(parameters, found), "")

    # Runs and files

    @on(RunsChanged)
    def _show_runs(self) -> None:
        self.query_one(RunsPane).show(self.session.runs)
        shown = self.shown
        if shown is not None and shown.result is not None:
            rows = result_rows(shown.result, shown.accuracy)
            self.query_one("#result-rows", RowsView).show(rows, "")
        self.refresh_bindings()

    @on(RunChosen)
    def _run_chosen(self, event: RunChosen) -> None:
        self.show_run(event.number)

    def show_run(self, number: int) -> None:
        """Show a run again.

        Parameters
        ----------
        number : int
            Its number.
        """
        run = self.session.runs.find(number)
        if run is None or run.result is None:
            self.post_message(Reported(f"run {number} has no result", error=True))
            return
        self.query_one(TransientPane).show_run(run)
        self.show_tab("transient")
        self._show_runs()

    @on(ExportEnded)
    def _export_ended(self, event: ExportEnded) -> None:
        words = event.error or f"{event.what} written to {event.path}"
        self.post_message(Reported(words, error=bool(event.error)))

    @on(Worker.StateChanged)
    def _thread_failed(self, event: Worker.StateChanged) -> None:
        if event.state is WorkerState.ERROR:
            words = f"unexpected {type(event.worker.error).__name__}: {event.worker.error}"
            self.post_message(Reported(f"{event.worker.name}: {words}", error=True))

    # Actions

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:  # noqa: ARG002
        """Which actions apply now: one of Run and Stop, export with a result alone."""
        running = self.session.runs.active is not None
        applies = {"run": not running, "stop": running}
        if action == "export":
            # None: shown, but dimmed.
            return True if self.shown is not None else None
        return applies.get(action, True)

    def action_run(self) -> None:
        """Begin a run of what is edited."""
        self.show_tab("transient")
        self.query_one(TransientPane).start_run()

    def action_stop(self) -> None:
        """Stop the run that goes on."""
        self.query_one(TransientPane).stop_run()

    def action_turn_tab(self, direction: int) -> None:
        """Show the next tab, or the one before."""
        tabs = self.query_one("#tabs", TabbedContent)
        panes = [pane.id or "" for pane in tabs.query(TabPane)]
        self.show_tab(panes[(panes.index(tabs.active) + direction) % len(panes)])

    def show_tab(self, name: str) -> None:
        """Show a tab.

        Parameters
        ----------
        name : str
            Its identifier.
        """
        self.query_one("#tabs", TabbedContent).active = name

    def action_export(self, what: str) -> None:
        """Write something of the run shown to a file."""
        if self.shown is not None:
            self._files.export(what, self.shown)

    def action_open_scene(self) -> None:
        """Open a scene file."""
        self._files.open_scene()

    def action_save_scene(self) -> None:
        """Save the scene edited."""
        self._files.save_scene()

    def action_reset(self) -> None:
        """Reset the field in focus to the scene's value."""
        field = field_of(self.focused)
        if field is None:
            self.app.bell()
        else:
            self.session.reset(field.name)
            self.show_inputs()

    def action_reset_all(self) -> None:
        """Reset all fields to the scene's values."""
        self.session.reset_all()
        self.show_inputs()

    def action_show_end(self) -> None:
        """Show the last tenth of the horizon."""
        self.query_one(TransientPlots).show_end(_LAST_PART)

    def action_show_all(self) -> None:
        """Show the whole horizon."""
        self.query_one(TransientPlots).show_all()

    def action_help(self) -> None:
        """Help on the field in focus, or on everything."""
        field = field_of(self.focused)
        if field is None:
            self.app.push_screen(HelpDialog("fivtui", general_help()))
        else:
            self.app.push_screen(HelpDialog(f"{field.name}: {field.meaning}", field_help(field)))

    def action_copy_command(self) -> None:
        """Copy the command line that computes the same."""
        try:
            line = self.session.command_line()
        except InputError as error:
            self.post_message(Reported(str(error), error=True))
        else:
            self.app.copy_to_clipboard(line)
            self.post_message(Reported(f"copied: {line}"))
