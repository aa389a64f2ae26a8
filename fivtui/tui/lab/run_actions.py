"""Starts, stops and finishes runs; transients are computed in threads."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from textual import on

from fivtui.scene import Scene
from fivtui.transient import Transient
from fivtui.tui.session import (
    MAX_RUNS,
    Outcome,
    Run,
    engine_difference_text,
    execute,
    result_summary,
)
from fivtui.tui.tabs import (
    PointRunRequested,
    RunActionRequested,
    RunRequested,
    RunsChanged,
    SceneLoaded,
    compute_in_thread,
)

from .actions import LabActions


class RunActions(LabActions):
    """Actions on runs, by keys, commands and messages.

    The edited scene is that of the form. To compare engines, it is run with a native method, then
    with an FMU: the scenes that are computed differ from it in method and step.
    """

    def action_run(self) -> None:
        """Run the edited scene."""
        with self.report_errors():
            self._start(self.session.scene())
            self.action_show_tab("transient")

    def action_compare_engines(self) -> None:
        """Run the edited scene with the native solver, then with an FMU, and compare them."""
        with self.report_errors():
            edited_scene = self.session.scene()
            native_scene, fmu_scene = self.session.engine_pair()

            def run_fmu(native_run: Run, native_result: Transient) -> None:
                def compare(_: Run, result: Transient) -> None:
                    native_run.overlaid = True
                    self.session.runs.baseline = native_run
                    self.report(engine_difference_text(native_result, result))

                self._start(fmu_scene, edited_scene, compare)

            self._start(native_scene, edited_scene, run_fmu)
            self.action_show_tab("transient")

    def _start(
        self,
        scene: Scene,
        edited_scene: Scene | None = None,
        on_result: Callable[[Run, Transient], None] = lambda *_: None,
    ) -> None:
        # `edited_scene` is needed only if it differs from `scene`; `on_result` is called unless the
        # run is stopped or fails.
        self.session.close_undo_step()
        runs_before = list(self.session.runs)
        run = self.session.runs.start(scene, edited_scene)
        self._report_deleted(runs_before)
        compute_in_thread(self, lambda: execute(run), partial(self._finish_run, run, on_result))
        self.post_message(RunsChanged())

    def action_stop(self) -> None:
        """Stop the active run."""
        run = self.session.runs.stop()
        if run is not None:
            self.post_message(RunsChanged())
            self.report(f"run {run.number} {run.stop_text}")

    @on(RunRequested)
    def _toggle_run(self) -> None:
        if self.session.runs.active is None:
            self.action_run()
        else:
            self.action_stop()

    @on(PointRunRequested)
    def _run_point(self, event: PointRunRequested) -> None:
        with self.report_errors():
            self.session.set_texts(event.texts)
            self.show_inputs()
            self.report(event.report, routine=True)
            self.action_run()

    def _finish_run(
        self, run: Run, on_result: Callable[[Run, Transient], None], outcome: Outcome[Transient]
    ) -> None:
        # The run may have been stopped.
        if not self.session.runs.finish(run, outcome):
            return
        if run.result is None:
            self.report(f"run {run.number}: {run.message}", error=True)
        else:
            self.session.runs.displayed = run
            # The elapsed time of the first run would include the time to load libraries.
            cpu_s = run.result.stats.cpu_s
            self.session.live.record_duration(run.scene, run.elapsed if cpu_s is None else cpu_s)
            report = "; ".join([f"run {run.number} done", *result_summary(run.result)])
            self.report(report, routine=True)
            on_result(run, run.result)
        self.post_message(RunsChanged())

    def add_run(self, path: Path, scene: Scene, result: Transient) -> None:
        """Add a run read from a file."""
        runs_before = list(self.session.runs)
        run = self.session.runs.add_loaded(scene, result, str(path))
        self._report_deleted(runs_before)
        self.report(f"run {run.number} read from {path}")
        self.post_message(RunsChanged())

    def _report_deleted(self, runs_before: list[Run]) -> None:
        # Report runs that were deleted because the list is full.
        for run in runs_before:
            if self.session.runs.find(run.number) is None:
                reason = f"the list holds {MAX_RUNS} runs"
                self.report(f"run {run.number} (the oldest) was deleted: {reason}")

    @on(RunActionRequested)
    def _handle_run_action(self, event: RunActionRequested) -> None:
        runs, undo_key = self.session.runs, self.session.key_names["undo"]
        run = runs.find(event.number)
        if run is None:
            return
        if event.action == "load":
            runs.displayed = runs.displayed if run.result is None else run
            report = f"scene of run {run.number} loaded; {undo_key} undoes"
            self.post_message(SceneLoaded(run.scene, "", report))
        elif event.action == "delete":
            self.session.delete_run(run)
            self.report(f"run {run.number} deleted; {undo_key} brings it back")
        else:
            self._change_plots(event.action, run)
        self.post_message(RunsChanged())

    def _change_plots(self, action: str, run: Run) -> None:
        # Actions that change how runs are plotted or compared.
        runs = self.session.runs
        if action == "overlay" and run is runs.displayed and not self.session.live.visible:
            self.report(f"run {run.number} is shown already: choose a run to draw beside it")
        elif action == "overlay":
            run.overlaid = not run.overlaid
        elif action == "colour":
            run.colour_shift += 1
        elif action == "marker":
            run.marker_shift += 1
        elif run.result is None:
            self.report(f"run {run.number} has no result", error=True)
        elif action == "show":
            runs.displayed = run
        elif action == "baseline":
            runs.baseline = None if runs.baseline is run else run
