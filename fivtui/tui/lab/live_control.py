"""Runs the edited scene in the background for the live curve."""

from functools import partial
from typing import TYPE_CHECKING, Final

from textual.timer import Timer

from fivtui.model import InputError
from fivtui.scene import Scene
from fivtui.transient import Transient
from fivtui.tui.session import (
    MAX_IMMEDIATE_S,
    SCREEN_PRIORITY,
    LiveJob,
    LiveRun,
    Outcome,
    Pace,
    differences,
    execute_live,
)
from fivtui.tui.tabs import compute_in_thread

if TYPE_CHECKING:
    from .screen import LabScreen

# Delay of a run after the last edit if it does not follow at once, s.
_PAUSE: Final = 0.4


class LiveController:
    """Updates the live curve of a session to the edited scene, one run at a time, for a screen.

    A short run is finished and shown even if the scene has changed since, so that the curve moves
    while a key is held; a long run is stopped by the next edit. The newest waiting scene is run.
    Results of stopped runs are dropped.
    """

    def __init__(self, screen: "LabScreen") -> None:
        self._screen = screen
        self._session = session = screen.session
        # The scene of the last request, and the run displayed then.
        self._scene = self._edited()
        self._displayed = session.runs.displayed
        self._job: LiveJob | None = None
        self._next: Scene | None = None
        self._waiting: Timer | None = None

    def _edited(self) -> Scene | None:
        try:
            return self._session.scene()
        except InputError:
            return None

    def request(self) -> bool:
        """Follow the edited scene. Returns whether the display has changed."""
        session, live = self._session, self._session.live
        if not session.live_enabled or session.runs.active is not None:
            self.stop()
            return False
        scene = self._edited()
        if scene == self._scene:
            return False
        self._scene = scene
        run = session.runs.displayed
        if scene is None:
            self.stop()
            live.status = "live: waits for valid inputs"
        elif run is not None and not differences(scene, run.edited_scene or run.scene):
            self.stop()
            live.clear()
        else:
            self._follow(scene)
        return True

    def _follow(self, scene: Scene) -> None:
        live = self._session.live
        if self._job is not None and self._job.elapsed > MAX_IMMEDIATE_S:
            # The run takes longer than expected: the next runs wait for a pause.
            live.record_duration(self._job.scene, self._job.elapsed)
        pace = live.pace(scene)
        if pace is Pace.AT_ONCE:
            self._stop_waiting()
            if self._job is not None and self._job.pace is Pace.AT_ONCE:
                self._next = scene
            else:
                self._begin(scene)
            return
        self.stop()
        if pace is Pace.OFF:
            live.switch_off(scene)
        else:
            live.announce_run(scene)
            self._waiting = self._screen.set_timer(_PAUSE, self._idle)

    def _idle(self) -> None:
        self._waiting = None
        if SCREEN_PRIORITY.claimed:
            self._waiting = self._screen.set_timer(_PAUSE, self._idle)
        elif self._scene is not None:
            self._begin(self._scene)

    def _begin(self, scene: Scene) -> None:
        if self._job is not None:
            self._job.stop()
        self._next = None
        self._job = job = LiveJob(scene=scene, pace=self._session.live.pace(scene))

        def compute() -> Outcome[Transient]:
            outcome = execute_live(job)
            job.duration = job.elapsed
            return outcome

        compute_in_thread(self._screen, compute, partial(self._ended, job))

    def _ended(self, job: LiveJob, outcome: Outcome[Transient]) -> None:
        if job is not self._job:
            return
        self._job = None
        live, displayed = self._session.live, self._session.runs.displayed
        displayed_result = None if displayed is None else displayed.result
        if outcome.result is not None:
            live.record_duration(job.scene, job.duration - job.setup_time)
            live.show_result(LiveRun(job.scene, outcome.result, job.duration), displayed_result)
        elif outcome.error:
            live.show_failure(outcome.error, displayed_result)
        else:
            live.record_duration(job.scene, job.estimate)
            live.switch_off(job.scene)
        if self._next is not None:
            self._begin(self._next)
        self._screen.show_live()

    def runs_changed(self) -> None:
        """Stop if a run is active; clear the curve if the displayed run has changed."""
        runs = self._session.runs
        if runs.active is not None:
            self.stop()
        if runs.displayed is not self._displayed:
            self._displayed, self._scene = runs.displayed, self._edited()
            self.stop()
            self._session.live.clear()

    def switch(self) -> None:
        """Switch the live curve on or off."""
        session = self._session
        session.live_enabled = not session.live_enabled
        self.stop()
        session.live.clear()
        self._scene = None if session.live_enabled else self._scene

    def stop(self) -> None:
        """Stop the current run and drop the waiting scene."""
        self._stop_waiting()
        self._next = None
        if self._job is not None:
            self._job.stop()
            self._job = None

    def _stop_waiting(self) -> None:
        if self._waiting is not None:
            self._waiting.stop()
            self._waiting = None
