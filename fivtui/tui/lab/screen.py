"""The main screen: verdict, tabs, form and runs of a session.

The gauges of the verdict show for which values of a parameter the slider is safe or squeals. The
live curve is a run that follows every edit of the scene.
"""

from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from typing import Any, ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Container, Vertical
from textual.events import Resize
from textual.widgets import Static
from textual.worker import Worker, WorkerState

from fivtui.equilibrium import verdict
from fivtui.model import ComputationError, InputError
from fivtui.tui.persistence import Slot, restore_results
from fivtui.tui.session import (
    SCREEN_RESPONSE,
    ResultKey,
    Session,
    crash_message,
    stability_summary,
    verdict_kind,
    welcome_text,
)
from fivtui.tui.tabs import (
    FieldFocused,
    LiveRequested,
    Reported,
    RunsChanged,
    TabBook,
    TabKeyPressed,
    TabLine,
)

from .control.gauge_control import GaugeController
from .control.live_control import LiveController
from .control.search_control import SearchController
from .editor_actions import EditorActions
from .form.form import Form
from .key_bar import KeyBar
from .keys import LAB_KEYS
from .notices import NoticeView
from .run_list import RunsTable
from .verdict.gauge import GaugeView
from .verdict.view import VerdictView

_POLL_INTERVAL_S: Final = 0.1
# Interval at which the scene's file is checked for changes by other programs.
_WATCH_INTERVAL_S: Final = 2.0
# Time between displays of the inputs while keys wait, s.
_INPUTS_INTERVAL_S: Final = 0.1
_TOO_SMALL: Final = "This window is too small for fivtui: it needs 40 columns and 10 lines."


class LabScreen(EditorActions):
    """The laboratory's main screen; it owns the session and handles all messages."""

    BINDINGS: ClassVar[list[BindingType]] = [*LAB_KEYS]
    # No automatic focus: `on_mount` sets it, and every change of focus is slow.
    AUTO_FOCUS: ClassVar[str | None] = ""

    def __init__(
        self,
        session: Session,
        other_sessions: Callable[[], Sequence[Slot]],
        *,
        has_waiting_keys: Callable[[], bool],
        show_welcome: bool = False,
    ) -> None:
        super().__init__(session)
        self.other_sessions = other_sessions
        self._shows_welcome = show_welcome
        self._search = SearchController(self)
        self._live = LiveController(self)
        self._gauges = GaugeController(self)
        self._has_waiting_keys = has_waiting_keys
        # Whether inputs will be displayed although keys wait.
        self._are_inputs_outdated = False
        # Whether the current tab will be updated after the next frame.
        self._is_tab_outdated = False

    def compose(self) -> ComposeResult:
        """Verdict and titles of the tabs at the top; below them form, current tab and runs."""
        yield VerdictView(id="verdict")
        yield TabLine(self.session.key_names)
        with Container(id="bench"):
            yield Form(self.session)
            with Vertical(id="results"):
                if self._shows_welcome:
                    yield Static(welcome_text(self.session.key_names), id="welcome", markup=False)
                yield TabBook(self.session)
            yield RunsTable(self.session)
        yield Static(_TOO_SMALL, id="too-small", markup=False)
        yield NoticeView()
        yield KeyBar()

    def on_mount(self) -> None:
        """Display the session and start polling the progress of runs."""
        # The screen polls, so that the thread of a run never waits for the screen.
        self._progress_timer = self.set_interval(_POLL_INTERVAL_S, self._poll_progress, pause=True)
        self.set_interval(_WATCH_INTERVAL_S, self.check_scene_file)
        self.show_inputs()
        self._update_runs()
        self.focus_field("mu")
        # Style sheets colour all but the marks of the runs.
        self.app.theme_changed_signal.subscribe(self, lambda _: self.query_one(RunsTable).show())

    def on_unmount(self) -> None:
        """Stop all computations but those of tabs, which stop their own."""
        self._progress_timer.stop()
        self._search.stop()
        self._live.stop()
        self._gauges.stop()
        self.session.runs.stop()

    @on(Reported)
    def _show_report(self, event: Reported) -> None:
        if not event.routine:
            self.query_one(NoticeView).add(event)
        prefix = "ERROR: " if event.error else ""
        self.session.reports.append(f"{datetime.now():%H:%M:%S} {prefix}{event.text}")
        self.tab_book.update_pane(lambda pane: pane.report_added())

    @on(FieldFocused)
    def _handle_field_focus(self, event: FieldFocused) -> None:
        self.session.close_undo_step()
        self._gauges.focus(event.name)
        self.show_verdict()

    @on(TabKeyPressed)
    async def _run_tab_key(self, event: TabKeyPressed) -> None:
        if self.tab_book.pane is not None:
            focused = self.focused
            await self.tab_book.pane.run_key(event.key)
            # The next view takes the focus.
            self.set_focus(focused)

    @on(GaugeView.MarkerMoved)
    def _move_marker(self, event: GaugeView.MarkerMoved) -> None:
        session = self.session
        if self._gauges.dragged != event.name or not event.dragging:
            # A drag is one undo step.
            session.close_undo_step()
        self._gauges.dragged = event.name if event.dragging else ""
        session.set_text(event.name, event.text)
        self.show_inputs(later=event.dragging and self.message_queue_size > 0)

    def show_inputs(self, *, later: bool = False) -> None:
        """Display the fields, their errors and the verdict.

        If `later`, or while keys wait, they are displayed a few times a second.
        """
        if not later and not self._has_waiting_keys():
            self._show_inputs()
        elif not self._are_inputs_outdated:
            self._are_inputs_outdated = True
            self.set_timer(_INPUTS_INTERVAL_S, self._show_inputs)

    def _show_inputs(self) -> None:
        self._are_inputs_outdated = False
        session = self.session
        suffix = " (changed)" if session.changed_fields else ""
        self.query_one(VerdictView).border_title = f"{session.name}{suffix}"
        self.query_one(Form).show()
        self.show_verdict()
        self._show_run_status()
        if not self._is_tab_outdated:
            # The tab is drawn in the next frame, after form and verdict.
            self._is_tab_outdated = True
            self.call_after_refresh(self._update_tab)

    def _update_tab(self) -> None:
        self._is_tab_outdated = False
        self.tab_book.update_pane(lambda pane: pane.scene_changed())
        self.call_after_refresh(SCREEN_RESPONSE.end)

    def show_verdict(self) -> None:
        """Display the stability of the edited scene, and the attractors found by the search."""
        verdict_view = self.query_one(VerdictView)
        try:
            result = self.session.stability()
        except (InputError, ComputationError) as error:
            reason = ": invalid input" if isinstance(error, InputError) else ""
            verdict_view.show("invalid", [f"NO VERDICT{reason}"], [str(error)])
            self._search.stop()
            self._gauges.stop()
            self.session.attractors = None
        else:
            stable = verdict(result) == "STABLE"
            attractors = self._search.attractors(result.system, stable=stable)
            self.session.attractors = attractors
            # A high screen has room for two gauges; on a lower one, the second replaces the facts.
            both = self.has_class("-tall") or (
                self.has_class("-middle") and self._gauges.second_is_focused
            )
            gauges = self._gauges.gauges(result, attractors, both=both)
            lines = stability_summary(result, attractors)
            if self.session.over_time:
                lines[0] = f"at t = 0: {lines[0]}"
            verdict_view.show(verdict_kind(result, attractors), lines, gauges)

    @on(Resize)
    def _update_gauges(self) -> None:
        # The number of gauges depends on the height.
        self.call_after_refresh(self.show_verdict)

    @property
    def is_busy(self) -> bool:
        """Whether a key, the tab, or the live curve that follows every edit is to be displayed."""
        is_drawing = self._is_tab_outdated or self.tab_book.pane is None
        return SCREEN_RESPONSE.pending or is_drawing or self._live.follows_edits

    def show_search_result(self) -> None:
        """Display attractors or the safe μ that the search has found."""
        self.show_verdict()
        self.tab_book.update_pane(lambda pane: pane.scene_changed())
        self.tab_book.update_pane(lambda pane: pane.status_changed())

    def _poll_progress(self) -> None:
        active = self.session.runs.active
        if active is not None and not SCREEN_RESPONSE.pending:
            self._show_run_status()
            self.tab_book.update_pane(lambda pane: pane.run_progressed(active))

    @on(TabBook.Changed)
    def _show_run_status(self) -> None:
        tab_line, active = self.query_one(TabLine), self.session.runs.active
        tab_line.active = self.session.tab
        tab_line.progress = "" if active is None else f"{active.fraction:.0%}"
        self.tab_book.update_pane(lambda pane: pane.status_changed())

    @on(LiveRequested)
    def _update_live(self) -> None:
        curve = self.session.live.curve
        if not self._live.update():
            return
        if curve is None or self.session.live.curve is not curve:
            self.show_live()
        else:
            self._show_run_status()

    def show_live(self) -> None:
        """Display the live curve, or else the displayed run, and the runs beside it."""
        self._show_run_status()
        self.query_one(RunsTable).update_marks()
        self.tab_book.update_pane(lambda pane: pane.run_changed(self.session.runs.displayed))

    def action_switch_live(self) -> None:
        """Switch the live curve on or off."""
        session = self.session
        session.live_enabled = not session.live_enabled
        self._live.reset()
        state = "follows every edit" if session.live_enabled else "off"
        self.report(f"live curve {state}")
        self._show_run_status()
        self.tab_book.update_pane_from_session()

    @on(RunsChanged)
    def _update_runs(self) -> None:
        if self.session.runs.newest is not None:
            self._remove_welcome()
        self._live.handle_runs_changed()
        if self.session.runs.active is None:
            self._progress_timer.pause()
        else:
            self._progress_timer.resume()
        self.query_one(RunsTable).show()
        self.show_live()
        self.refresh_bindings()

    def restore_results(self, results: Mapping[ResultKey, Any], errors: Sequence[str]) -> None:
        """Display the results of the last session; `errors` lists those that could not be read."""
        restore_results(self.session, results)
        for error in errors:
            self.report(error, error=True)
        self._update_runs()
        self.tab_book.update_pane_from_session()

    @on(Worker.StateChanged)
    def _report_crash(self, event: Worker.StateChanged) -> None:
        if event.state is WorkerState.ERROR:
            self.report(f"{event.worker.name}: {crash_message(event.worker.error)}", error=True)
