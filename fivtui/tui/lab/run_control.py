"""Starts, stops and finishes runs; transients are computed in threads."""

from collections.abc import Callable, Mapping
from typing import Final

from textual.message import Message
from textual.screen import Screen
from textual.worker import Worker, WorkerState

from fivtui.model import InputError
from fivtui.scene import Scene
from fivtui.tui.session import (
    MAX_RUNS,
    SOLVER,
    Outcome,
    Run,
    Session,
    crash_words,
    engine_words,
    execute,
    result_brief,
)
from fivtui.tui.tabs import (
    Reported,
    RunActionRequested,
    RunEnded,
    RunRead,
    RunsChanged,
    SceneLoaded,
)

_GROUP: Final = "transient"


class RunController:
    """Starts, stops and finishes a session's runs for a screen, which owns the threads."""

    def __init__(self, screen: Screen[None], session: Session) -> None:
        self._screen = screen
        self._session = session
        # The scene to run next, and the run to compare its result with.
        self._next: Scene | None = None
        self._partner: Run | None = None

    def start(self) -> bool:
        """Start a run of the edited scene. Returns False if an input is invalid."""
        try:
            scene = self._session.scene()
        except InputError as error:
            self._tell(Reported(str(error), error=True))
            return False
        self._next = self._partner = None
        self._begin(scene)
        return True

    def start_both(self) -> bool:
        """Start a run with the native solver, then with an FMU. Returns False if invalid."""
        try:
            edited = self._session.scene()
            native, fmu = self._session.engine_pair()
        except InputError as error:
            self._tell(Reported(str(error), error=True))
            return False
        self._next, self._partner = fmu, None
        self._begin(native, edited)
        return True

    def _begin(self, scene: Scene, edited: Scene | None = None) -> None:
        self._session.close_step()
        before = list(self._session.runs)
        run = self._session.runs.start(scene, edited)
        self._tell_left(before)
        self._screen.run_worker(
            lambda: self._tell(RunEnded(run, execute(run))),
            name=str(run.number),
            group=_GROUP,
            thread=True,
            exit_on_error=False,
        )
        self._tell(RunsChanged())

    def stop(self) -> None:
        """Stop the active run and cancel the one to follow."""
        self._next = self._partner = None
        run = self._session.runs.stop()
        if run is not None:
            self._tell(RunsChanged())
            self._tell(Reported(f"run {run.number} {run.stop_words}"))

    def ended(self, event: RunEnded) -> None:
        """Store the outcome of a run, unless it was stopped before."""
        run = event.run
        if not self._session.runs.finish(run, event.outcome):
            return
        if run.result is None:
            self._next = self._partner = None
            self._tell(Reported(f"run {run.number}: {run.message}", error=True))
        else:
            self._session.runs.displayed = run
            # The time of the first run of all would be that of loading libraries.
            cpu_s = run.result.stats.cpu_s
            self._session.live.learn(run.scene, run.elapsed if cpu_s is None else cpu_s)
            words = "; ".join([f"run {run.number} done", *result_brief(run.result)])
            self._tell(Reported(words, routine=True))
            self._go_on(run)
        self._tell(RunsChanged())

    def _go_on(self, run: Run) -> None:
        # The FMU follows the native solver; then they are compared.
        if self._next is not None:
            scene, self._next, self._partner = self._next, None, run
            self._begin(scene, run.edited)
        elif self._partner is not None:
            native, self._partner = self._partner, None
            if native.result is not None and run.result is not None and run.engine != SOLVER:
                native.overlaid = True
                self._session.runs.baseline = native
                self._tell(Reported(engine_words(native.result, run.result)))

    def thread_failed(self, worker: Worker[object]) -> bool:
        """Mark a run as failed if its thread crashed. Returns whether it was a run's thread."""
        if worker.group != _GROUP or worker.state is not WorkerState.ERROR or worker.name is None:
            return False
        run = self._session.runs.find(int(worker.name))
        if run is not None:
            self._tell(RunEnded(run, Outcome(error=crash_words(worker.error))))
        return True

    def read(self, event: RunRead) -> None:
        """Add a run read from a file."""
        before = list(self._session.runs)
        run = self._session.runs.add_read(event.scene, event.result, str(event.path))
        self._tell_left(before)
        self._tell(Reported(f"run {run.number} read from {event.path}"))
        self._tell(RunsChanged())

    def _tell_left(self, before: list[Run]) -> None:
        for run in before:
            if self._session.runs.find(run.number) is None:
                why = f"the list holds {MAX_RUNS} runs"
                self._tell(Reported(f"run {run.number} (the oldest) was deleted: {why}"))

    def act(self, event: RunActionRequested) -> None:
        """Carry out an action of `ACTS` on a run."""
        run = self._session.runs.find(event.number)
        if run is not None:
            ACTS[event.what](self, run)
            self._tell(RunsChanged())

    def _show(self, run: Run) -> None:
        if run.result is None:
            self._tell(Reported(f"run {run.number} has no result", error=True))
        else:
            self._session.runs.displayed = run

    def _load(self, run: Run) -> None:
        if run.result is not None:
            self._session.runs.displayed = run
        self._tell(SceneLoaded(run.scene, "", f"scene of run {run.number} loaded; Ctrl+Z undoes"))

    def _overlay(self, run: Run) -> None:
        run.overlaid = not run.overlaid

    def _baseline(self, run: Run) -> None:
        runs = self._session.runs
        if run.result is None:
            self._tell(Reported(f"run {run.number} has no result", error=True))
        else:
            runs.baseline = None if runs.baseline is run else run

    def _remove(self, run: Run) -> None:
        if run is self._session.runs.active:
            self.stop()
        self._session.delete_run(run)
        self._tell(Reported(f"run {run.number} deleted; Ctrl+Z brings it back"))

    def _colour(self, run: Run) -> None:
        run.style.colour += 1

    def _marker(self, run: Run) -> None:
        run.style.marker += 1

    def _tell(self, message: Message) -> None:
        self._screen.post_message(message)


ACTS: Final[Mapping[str, Callable[[RunController, Run], None]]] = {
    "show": RunController._show,
    "load": RunController._load,
    "overlay": RunController._overlay,
    "baseline": RunController._baseline,
    "delete": RunController._remove,
    "colour": RunController._colour,
    "marker": RunController._marker,
}
