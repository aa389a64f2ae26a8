"""Runs the edited scene in the background for the live curve.

The live curve is a run that follows the edits and is not kept. How soon it follows an edit, its
`Pace`, depends on how long a run takes.
"""

from functools import partial
from typing import TYPE_CHECKING

from fivtui.model import InputError
from fivtui.scene import Scene
from fivtui.transient import Transient
from fivtui.tui.session import (
    MAX_IMMEDIATE_S,
    LiveJob,
    LiveRun,
    Outcome,
    Pace,
    compute_scene,
)
from fivtui.tui.tabs import compute_in_thread

from .controller import Controller

if TYPE_CHECKING:
    from fivtui.tui.lab.screen import LabScreen


class LiveController(Controller[LiveJob]):
    """Runs the edited scene and shows the result as the live curve.

    The next edit stops a long run. A short run is completed and shown, so that the curve moves
    while a key is held; then the newest scene is run.
    """

    def __init__(self, screen: "LabScreen") -> None:
        super().__init__(screen)
        # The scene of the last request (None at first, and if invalid), and the run displayed then.
        self._requested_scene: Scene | None = None
        self._displayed = self._session.runs.displayed
        self._queued_scene: Scene | None = None

    def _edited_scene(self) -> Scene | None:
        try:
            return self._session.scene()
        except InputError:
            return None

    def update(self) -> bool:
        """Run the edited scene if it has changed. Returns False if nothing has changed."""
        session, live = self._session, self._session.live
        if not session.live_enabled or session.runs.active is not None:
            self.stop()
            return False
        scene = self._edited_scene()
        if scene == self._requested_scene:
            return False
        self._requested_scene = scene
        run = session.runs.displayed
        if scene is None:
            self.stop()
            live.announce_run(None)
        elif run is not None and not session.is_outdated(run):
            self.stop()
            live.clear()
        else:
            self._schedule(scene)
        return True

    @property
    def follows_edits(self) -> bool:
        """Whether a run of a fraction of a second is in progress."""
        return self._job is not None and self._job.pace is Pace.AT_ONCE

    def _schedule(self, scene: Scene) -> None:
        # Run a scene at once, after the current live run, after a pause, or not at all.
        live = self._session.live
        if self._job is not None and self._job.elapsed > MAX_IMMEDIATE_S:
            # The run takes longer than expected, so the next runs wait for a pause.
            live.record_duration(self._job.scene, self._job.elapsed)
        pace = live.pace(scene)
        if pace is Pace.AT_ONCE and self.follows_edits:
            self._queued_scene = scene
            return
        self.stop()
        if pace is Pace.AT_ONCE:
            self._start(scene)
        elif pace is Pace.OFF:
            live.switch_off(scene)
        else:
            live.announce_run(scene)
            self.start_after_pause(partial(self._start, scene))

    def _start(self, scene: Scene) -> None:
        self._queued_scene = None
        self._job = job = LiveJob(scene=scene, pace=self._session.live.pace(scene))

        def compute() -> Outcome[Transient]:
            outcome = compute_scene(scene, job)
            job.duration = job.elapsed
            return outcome

        compute_in_thread(self._screen, compute, partial(self._handle_outcome, job))

    def _handle_outcome(self, job: LiveJob, outcome: Outcome[Transient]) -> None:
        if job is not self._job:
            return
        self._job = None
        live, displayed = self._session.live, self._session.runs.displayed
        displayed_result = None if displayed is None else displayed.result
        if outcome.result is not None:
            live.record_duration(job.scene, job.duration - job.setup_time)
            live.show(LiveRun(job.scene, outcome.result, job.duration), displayed_result)
        elif outcome.error:
            live.show(None, displayed_result, outcome.error)
        else:
            # Neither result nor error: the run took too long and was stopped.
            live.record_duration(job.scene, job.estimated_duration)
            live.switch_off(job.scene)
        if self._queued_scene is not None:
            self._start(self._queued_scene)
        self._screen.show_live()

    def handle_runs_changed(self) -> None:
        """Stop live runs during other runs; clear the curve if the displayed run has changed."""
        runs = self._session.runs
        if runs.active is not None:
            self.stop()
        if runs.displayed is not self._displayed:
            self._displayed = runs.displayed
            # A displayed run stays visible until the next edit.
            self.reset(None if self._displayed is None else self._edited_scene())

    def reset(self, requested_scene: Scene | None = None) -> None:
        """Clear the curve; the next `update` runs a valid scene that is not `requested_scene`."""
        self.stop()
        self._session.live.clear()
        self._requested_scene = requested_scene

    def stop(self) -> None:
        """Stop the live run and discard the queued scene."""
        super().stop()
        self._queued_scene = None
