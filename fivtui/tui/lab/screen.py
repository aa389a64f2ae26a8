"""The main screen: form, verdict, runs and tabs of a session."""

from collections.abc import Callable, Sequence
from datetime import datetime
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.binding import ActiveBinding, BindingType
from textual.containers import Horizontal, Vertical
from textual.events import Resize
from textual.notifications import SeverityLevel
from textual.screen import Screen
from textual.widgets import Static
from textual.worker import Worker, WorkerState

from fivtui.equilibrium import verdict
from fivtui.model import ComputationError, InputError
from fivtui.tui.persistence import Slot, restore_results
from fivtui.tui.session import (
    CHARTS,
    PRECEDENCE,
    WELCOME,
    RunState,
    Session,
    crash_words,
    stability_brief,
    verdict_kind,
)
from fivtui.tui.tabs import (
    TABS,
    ExportEnded,
    FieldEdited,
    FieldFocused,
    FieldStepped,
    JobPane,
    LiveEnded,
    LiveRequested,
    Pane,
    PointOpened,
    Reported,
    ResultsRestored,
    RunActionRequested,
    RunEnded,
    RunRead,
    RunRequested,
    RunsChanged,
    SceneLoaded,
    SceneSaved,
    SearchUpdated,
    StudyRead,
    TabBook,
)

from .edit_control import EditController
from .form import Form, field_of
from .key_bar import KeyBar
from .keys import LAB_KEYS
from .live_control import LiveController
from .run_bar import NO_RUN, RunBar
from .run_control import RunController
from .run_list import RunsPane
from .search_control import SearchController
from .verdict.gauge_control import GaugeController, ZonesComputed
from .verdict.view import VerdictView

if TYPE_CHECKING:
    from .file_control import FileController

_PROGRESS_PERIOD: Final = 0.1
# The tab that shows the live curve.
_LIVE_TAB: Final = "transient"
_TOO_SMALL: Final = "This window is too small for fivtui: it needs 40 columns and 10 lines."


class LabScreen(Screen[None]):
    """The laboratory's main screen; it owns the session and handles all messages."""

    BINDINGS: ClassVar[list[BindingType]] = [*LAB_KEYS]
    # `on_mount` sets the focus once: every change of focus costs time.
    AUTO_FOCUS: ClassVar[str | None] = ""

    def __init__(
        self,
        session: Session,
        other_sessions: Callable[[], Sequence[Slot]],
        *,
        welcome: bool = False,
    ) -> None:
        super().__init__()
        self._welcome = welcome
        self.session = session
        self.other_sessions = other_sessions
        self._editor = EditController(self, session)
        self._run_controller = RunController(self, session)
        self._search = SearchController(self)
        self._live = LiveController(self, session)
        self._gauges = GaugeController(self, session)
        self._tab_behind = False

    def compose(self) -> ComposeResult:
        """Verdict above; form at the left; run bar, tabs and runs at the right."""
        yield VerdictView(id="verdict")
        with Horizontal(id="bench"):
            yield Form(self.session.texts)
            with Vertical(id="results"):
                yield RunBar()
                if self._welcome:
                    yield Static("\n".join(WELCOME), id="welcome", markup=False)
                yield TabBook(TABS, self.session)
                yield RunsPane()
        yield Static(_TOO_SMALL, id="too-small", markup=False)
        yield KeyBar()

    def on_mount(self) -> None:
        """Display the session and start polling the progress of runs."""
        # Polled, so that a run's thread never waits for the screen.
        self._ticker = self.set_interval(_PROGRESS_PERIOD, self._tick, pause=True)
        self.show_inputs()
        self._show_runs()
        self.query_one(Form).focus_field("mu")
        self.app.theme_changed_signal.subscribe(self, lambda _: self._redraw())

    def on_unmount(self) -> None:
        """Stop what is computed."""
        self._ticker.stop()
        self.stop_computing()

    def stop_computing(self) -> None:
        """Stop all computations of this session."""
        self._search.stop()
        self._live.stop()
        self._gauges.stop()
        self.session.runs.stop()
        for pane in self.query(JobPane):
            pane.stop()

    def _redraw(self) -> None:
        self.call_after_refresh(self._book.update_pane, lambda pane: pane.theme_changed())

    @cached_property
    def _files(self) -> "FileController":
        # Imported late: it loads slow modules.
        from .file_control import FileController

        return FileController(self, self.session)

    @property
    def _book(self) -> TabBook:
        return self.query_one(TabBook)

    @on(Reported)
    def _reported(self, event: Reported) -> None:
        if not event.routine:
            severity: SeverityLevel = "error" if event.error else "information"
            self.notify(event.words, severity=severity, markup=False)
        mark = "ERROR: " if event.error else ""
        self.session.reports.append(f"{datetime.now():%H:%M:%S} {mark}{event.words}")
        self._book.update_pane(lambda pane: pane.reported())

    # Editing

    @on(FieldEdited)
    def _edited(self, event: FieldEdited) -> None:
        self._editor.edited(event)

    @on(FieldFocused)
    def _field_focused(self, event: FieldFocused) -> None:
        self.session.close_step()
        self._gauges.focus(event.name)
        self._show_verdict()

    @on(FieldStepped)
    def _stepped(self, event: FieldStepped) -> None:
        self._editor.stepped(event)

    @on(SceneLoaded)
    def _loaded(self, event: SceneLoaded) -> None:
        self._editor.loaded(event)

    @on(PointOpened)
    def _point_opened(self, event: PointOpened) -> None:
        self._editor.point_opened(event)
        self.action_run()

    @on(SceneSaved)
    def _saved(self, event: SceneSaved) -> None:
        self._editor.saved(event)

    def show_inputs(self) -> None:
        """Display the fields, their errors and the verdict."""
        session = self.session
        mark = " (changed)" if session.changed else ""
        self.query_one(VerdictView).name_scene(f"{session.name}{mark}")
        self.query_one(Form).show(session.texts, session.errors, session.changed, session.courses)
        self._show_verdict()
        self._show_newest()
        if not self._tab_behind:
            # Form and verdict answer the key first; the tab is drawn in the next frame.
            self._tab_behind = True
            self.call_after_refresh(self._show_in_tab)

    def _show_in_tab(self) -> None:
        self._tab_behind = False
        self._book.update_pane(lambda pane: pane.scene_changed())
        self.call_after_refresh(PRECEDENCE.release)

    def _show_verdict(self) -> None:
        view = self.query_one(VerdictView)
        try:
            parameters, found = self.session.parameters(), self.session.stability()
        except (InputError, ComputationError) as error:
            why = ": invalid input" if isinstance(error, InputError) else ""
            view.show("invalid", [f"NO VERDICT{why}"], [str(error)])
            self._search.stop()
            self._gauges.stop()
            self.session.coexisting = None
        else:
            coexisting = self._search.coexisting(
                parameters, separation=self.session.separation, stable=verdict(found) == "STABLE"
            )
            self.session.coexisting = coexisting
            gauges = self._gauges.gauges(found, coexisting, both=self.has_class("-tall"))
            lines = stability_brief(found, coexisting)
            if self.session.loaded.over_time:
                lines[0] = f"at t = 0: {lines[0]}"
            view.show(verdict_kind(found, coexisting), lines, gauges)

    @on(Resize)
    def _resized(self) -> None:
        # There is room for another number of gauges.
        self.call_after_refresh(self._show_verdict)

    @on(ZonesComputed)
    def _zones_computed(self, event: ZonesComputed) -> None:
        self._gauges.take(event)
        self._show_verdict()

    @on(SearchUpdated)
    def _search_updated(self, event: SearchUpdated) -> None:
        if self._search.take(event):
            self._show_verdict()
            self._book.update_pane(lambda pane: pane.scene_changed())

    # Runs and files

    def _tick(self) -> None:
        if not PRECEDENCE.claimed:
            self._show_progress()

    @on(TabBook.TabActivated)
    def _show_newest(self) -> None:
        newest, live = self.session.runs.newest, self.session.live.words
        bar = self.query_one(RunBar)
        failed = newest is not None and newest.state is RunState.FAILED
        if failed and newest is not None and not self.session.outdated(newest):
            # There is no live curve of what cannot be computed.
            live = ""
        if live and self._book.active == _LIVE_TAB and self.session.runs.active is None:
            bar.show(None, live)
        elif newest is not None:
            bar.show_run(newest, outdated=self.session.outdated(newest))
        else:
            bar.show(None, NO_RUN)

    # The live curve

    @on(LiveRequested)
    def _live_requested(self) -> None:
        shown = self.session.live.curve
        if self._live.request():
            self._show_newest()
            if self.session.live.curve is not shown:
                self._show_curves()

    @on(LiveEnded)
    def _live_ended(self, event: LiveEnded) -> None:
        if self._live.ended(event):
            self._show_newest()
            self._show_curves()

    def _show_curves(self) -> None:
        self._book.update_pane(lambda pane: pane.run_changed(self.session.runs.displayed))

    def action_switch_live(self) -> None:
        """Switch the live curve on or off."""
        self._live.switch()
        words = "follows every edit" if self.session.lives else "off"
        self.post_message(Reported(f"live curve {words}"))
        self._show_newest()
        self._book.catch_up()

    def _show_progress(self) -> None:
        self._show_newest()
        active = self.session.runs.active
        if active is not None:
            self._book.update_pane(lambda pane: pane.run_progressed(active))

    @on(RunsChanged)
    def _show_runs(self) -> None:
        if self.session.runs.newest is not None:
            self._end_welcome()
        self._live.runs_changed()
        if self.session.runs.active is None:
            self._ticker.pause()
        else:
            self._ticker.resume()
        self._show_progress()
        self.query_one(RunsPane).show(self.session.runs)
        self._show_curves()
        self.refresh_bindings()

    @on(RunRequested)
    def _run_requested(self) -> None:
        if self.session.runs.active is None:
            self.action_run()
        else:
            self.action_stop()

    @on(RunEnded)
    def _run_ended(self, event: RunEnded) -> None:
        self._run_controller.ended(event)

    @on(RunActionRequested)
    def _run_action_requested(self, event: RunActionRequested) -> None:
        self._run_controller.act(event)

    @on(RunRead)
    def _run_read(self, event: RunRead) -> None:
        self._run_controller.read(event)

    @on(StudyRead)
    def _study_read(self, event: StudyRead) -> None:
        self.session.studies.put(event.kind, event.study)
        # The axis limits were chosen for another result.
        view = self.session.views.get(CHARTS[event.kind])
        if view is not None:
            view.reset()
            view.hidden.clear()
        self.show_tab(event.kind)
        self._book.catch_up()
        self.post_message(Reported(f"{event.kind} read from {event.study.source}"))

    @on(ResultsRestored)
    def _results_restored(self, event: ResultsRestored) -> None:
        restore_results(self.session, event.results)
        for words in event.errors:
            self.post_message(Reported(words, error=True))
        self._show_runs()
        self._book.catch_up()

    @on(ExportEnded)
    def _export_ended(self, event: ExportEnded) -> None:
        words = event.error or f"{event.what} written to {event.path}"
        self.post_message(Reported(words, error=bool(event.error)))

    @on(Worker.StateChanged)
    def _thread_failed(self, event: Worker.StateChanged) -> None:
        if (
            not self._run_controller.thread_failed(event.worker)
            and not self._live.thread_failed(event.worker)
            and event.state is WorkerState.ERROR
        ):
            words = f"{event.worker.name}: {crash_words(event.worker.error)}"
            self.post_message(Reported(words, error=True))

    # Actions

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
