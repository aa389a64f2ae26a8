"""The main screen: form, verdict, runs and tabs of a session."""

from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from typing import Any, ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, Vertical
from textual.events import Resize
from textual.widgets import Static
from textual.worker import Worker, WorkerState

from fivtui.equilibrium import verdict
from fivtui.model import ComputationError, InputError
from fivtui.tui.persistence import Slot, restore_results
from fivtui.tui.session import (
    SCREEN_PRIORITY,
    WELCOME,
    DisplayedStudy,
    RunState,
    Session,
    crash_message,
    stability_summary,
    verdict_kind,
)
from fivtui.tui.tabs import (
    TABS,
    FieldFocused,
    JobPane,
    LiveRequested,
    Pane,
    Reported,
    RunsChanged,
    StudyPane,
    TabBook,
)

from .edit_actions import EditActions
from .form.form import Form
from .key_bar import KeyBar
from .keys import LAB_KEYS
from .live_control import LiveController
from .notices import NoticeView
from .run_actions import RunActions
from .run_bar import NO_RUN_TEXT, RunBar
from .run_list import RunsPane
from .search_control import SearchController
from .verdict.gauge_control import GaugeController
from .verdict.view import VerdictView

_PROGRESS_PERIOD: Final = 0.1
# The tab that shows the live curve.
_LIVE_TAB: Final = "transient"
_TOO_SMALL: Final = "This window is too small for fivtui: it needs 40 columns and 10 lines."


def _reset_charts(pane: Pane) -> None:
    if isinstance(pane, StudyPane):
        pane.reset_charts()


class LabScreen(EditActions, RunActions):
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
        super().__init__(session, welcome=welcome)
        self.other_sessions = other_sessions
        self._search = SearchController(self)
        self._live = LiveController(self)
        self._gauges = GaugeController(self)
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
        yield NoticeView()
        yield KeyBar()

    def on_mount(self) -> None:
        """Display the session and start polling the progress of runs."""
        # Polling: a run's thread never waits for the screen.
        self._ticker = self.set_interval(_PROGRESS_PERIOD, self._tick, pause=True)
        self.show_inputs()
        self._show_runs()
        self.query_one(Form).focus_field("mu")
        self.app.theme_changed_signal.subscribe(self, lambda _: self._redraw())

    def on_unmount(self) -> None:
        """Stop all computations."""
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
        self.call_after_refresh(self.book.update_pane, lambda pane: pane.theme_changed())

    @on(Reported)
    def _reported(self, event: Reported) -> None:
        if not event.routine:
            self.query_one(NoticeView).add(event.text, error=event.error)
        mark = "ERROR: " if event.error else ""
        self.session.reports.append(f"{datetime.now():%H:%M:%S} {mark}{event.text}")
        self.book.update_pane(lambda pane: pane.reported())

    # Editing

    @on(FieldFocused)
    def _field_focused(self, event: FieldFocused) -> None:
        self.session.close_step()
        self._gauges.focus(event.name)
        self.show_verdict()

    def show_inputs(self) -> None:
        """Display the fields, their errors and the verdict."""
        session = self.session
        mark = " (changed)" if session.changed_fields else ""
        self.query_one(VerdictView).show_scene_name(f"{session.name}{mark}")
        self.query_one(Form).show(
            session.texts, session.errors, session.changed_fields, session.notes
        )
        self.show_verdict()
        self._show_newest()
        if not self._tab_behind:
            # Form and verdict are updated first; the tab is drawn in the next frame.
            self._tab_behind = True
            self.call_after_refresh(self._show_in_tab)

    def _show_in_tab(self) -> None:
        self._tab_behind = False
        self.book.update_pane(lambda pane: pane.scene_changed())
        self.call_after_refresh(SCREEN_PRIORITY.release)

    def show_verdict(self) -> None:
        """Display the stability of the edited scene, and the result of the search."""
        view = self.query_one(VerdictView)
        try:
            result = self.session.stability()
        except (InputError, ComputationError) as error:
            why = ": invalid input" if isinstance(error, InputError) else ""
            view.show("invalid", [f"NO VERDICT{why}"], [str(error)])
            self._search.stop()
            self._gauges.stop()
            self.session.attractors = None
        else:
            stable = verdict(result) == "STABLE"
            coexisting = self._search.attractors(result.system, stable=stable)
            self.session.attractors = coexisting
            gauges = self._gauges.gauges(result, coexisting, both=self.has_class("-tall"))
            lines = stability_summary(result, coexisting)
            if self.session.over_time:
                lines[0] = f"at t = 0: {lines[0]}"
            view.show(verdict_kind(result, coexisting), lines, gauges)

    @on(Resize)
    def _resized(self) -> None:
        # The number of gauges depends on the height.
        self.call_after_refresh(self.show_verdict)

    def show_search_result(self) -> None:
        """Display the result of a search."""
        self.show_verdict()
        self.book.update_pane(lambda pane: pane.scene_changed())

    # Runs and files

    def _tick(self) -> None:
        if not SCREEN_PRIORITY.claimed:
            self._show_progress()

    @on(TabBook.TabActivated)
    def _show_newest(self) -> None:
        newest, live = self.session.runs.newest, self.session.live.status
        bar = self.query_one(RunBar)
        failed = newest is not None and newest.state is RunState.FAILED
        if failed and newest is not None and not self.session.is_outdated(newest):
            # A scene that failed has no live curve.
            live = ""
        if live and self.book.active == _LIVE_TAB and self.session.runs.active is None:
            bar.show(None, live)
        elif newest is not None:
            bar.show_run(newest, outdated=self.session.is_outdated(newest))
        else:
            bar.show(None, NO_RUN_TEXT)

    # The live curve

    @on(LiveRequested)
    def _live_requested(self) -> None:
        shown = self.session.live.curve
        if self._live.request():
            self._show_newest()
            if self.session.live.curve is not shown:
                self._show_curves()

    def show_live(self) -> None:
        """Display the live curve."""
        self._show_newest()
        self._show_curves()

    def _show_curves(self) -> None:
        self.query_one(RunsPane).mark(self.session.runs, self.session.live)
        self.book.update_pane(lambda pane: pane.run_changed(self.session.runs.displayed))

    def action_switch_live(self) -> None:
        """Switch the live curve on or off."""
        self._live.switch()
        state = "follows every edit" if self.session.live_enabled else "off"
        self.report(f"live curve {state}")
        self._show_newest()
        self.book.catch_up()

    def _show_progress(self) -> None:
        self._show_newest()
        active = self.session.runs.active
        if active is not None:
            self.book.update_pane(lambda pane: pane.run_progressed(active))

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
        self.query_one(RunsPane).show(self.session.runs, self.session.live)
        self._show_curves()
        self.refresh_bindings()

    def show_study(self, kind: str, study: DisplayedStudy[Any]) -> None:
        """Display a result read from a file in the tab of its kind."""
        self.session.studies[kind] = study
        self.action_show_tab(kind)
        self.book.when_ready(_reset_charts)
        self.book.catch_up()
        self.report(f"{kind} read from {study.source}")

    def restore_results(self, results: Mapping[str, Any], errors: Sequence[str]) -> None:
        """Display the results of the last session; `errors` lists those that could not be read."""
        restore_results(self.session, results)
        for error in errors:
            self.report(error, error=True)
        self._show_runs()
        self.book.catch_up()

    @on(Worker.StateChanged)
    def _thread_failed(self, event: Worker.StateChanged) -> None:
        if event.state is WorkerState.ERROR:
            self.report(f"{event.worker.name}: {crash_message(event.worker.error)}", error=True)
