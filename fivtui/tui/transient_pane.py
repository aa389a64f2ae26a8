"""The tab of the transient: run it, stop it, see y and P over time and what came out."""

from typing import Final

from textual import on
from textual.app import ComposeResult
from textual.widgets import Static, TabPane
from textual.worker import Worker, WorkerState

from fivtui.core.errors import ComputationError, InputError
from fivtui.core.outcome import Transient
from fivtui.core.stability import stability

from .messages import Reported, RunAsked, RunEnded, RunsChanged
from .plots import TransientPlots
from .report import remark, result_brief
from .run_bar import RunBar
from .runs import Outcome, Run, execute
from .session import Session

_PROGRESS_PERIOD: Final = 0.1


class TransientPane(TabPane):
    """Run bar, plots and summary.

    Parameters
    ----------
    session : Session
        Its runs are started, stopped and finished here.
    """

    def __init__(self, session: Session) -> None:
        super().__init__("Transient", id="transient")
        self._session = session
        self._shown: Run | None = None

    def compose(self) -> ComposeResult:
        """The parts from top to bottom."""
        yield RunBar()
        yield TransientPlots()
        yield Static("", id="summary", markup=False)

    def on_mount(self) -> None:
        """Prepare to poll the progress of a run: its thread never waits for the screen."""
        self._ticker = self.set_interval(_PROGRESS_PERIOD, self.show_status, pause=True)

    def on_unmount(self) -> None:
        """Let a run that goes on end: the program would wait for its thread."""
        self._session.runs.stop()

    @property
    def shown(self) -> Run | None:
        """The run whose result is shown."""
        return self._shown

    @on(RunAsked)
    def _run_asked(self) -> None:
        if self._session.runs.active is None:
            self.start_run()
        else:
            self.stop_run()

    def start_run(self) -> None:
        """Begin a run of what is edited."""
        try:
            scene = self._session.scene()
        except InputError as error:
            self.post_message(Reported(str(error), error=True))
            return
        run = self._session.runs.start(scene)
        self.run_worker(
            lambda: self.post_message(RunEnded(run, execute(run))),
            name=str(run.number),
            thread=True,
            exit_on_error=False,
        )
        self._runs_changed()

    def stop_run(self) -> None:
        """Stop the run that goes on."""
        run = self._session.runs.stop()
        if run is not None:
            self._runs_changed()
            done = f"{100.0 * run.fraction:.0f} %"
            self.post_message(Reported(f"run {run.number} stopped at {done}"))

    @on(RunEnded)
    def _run_ended(self, event: RunEnded) -> None:
        run = event.run
        if not self._session.runs.finish(run, event.outcome):
            return
        self._runs_changed()
        if run.result is None:
            self.post_message(Reported(f"run {run.number}: {run.message}", error=True))
        else:
            self.show_run(run)
            words = "; ".join([f"run {run.number} done", *result_brief(run.result)])
            self.post_message(Reported(words, routine=True))

    @on(Worker.StateChanged)
    def _thread_failed(self, event: Worker.StateChanged) -> None:
        run = self._session.runs.find(int(event.worker.name))
        if event.state is WorkerState.ERROR and run is not None:
            words = f"unexpected {type(event.worker.error).__name__}: {event.worker.error}"
            self.post_message(RunEnded(run, Outcome(error=words)))

    def _runs_changed(self) -> None:
        if self._session.runs.active is None:
            self._ticker.pause()
        else:
            self._ticker.resume()
        self.show_status()
        self.post_message(RunsChanged())

    def show_status(self) -> None:
        """Show where the newest run stands, and whether the fields were edited since."""
        newest = self._session.runs.newest
        if newest is not None:
            self.query_one(RunBar).show(newest, outdated=self._session.outdated(newest))

    def show_run(self, run: Run) -> None:
        """Show the result of a run.

        Parameters
        ----------
        run : Run
            A run that is done.
        """
        if run.result is None:
            return
        self._shown = run
        first, *others = result_brief(run.result)
        lines = [first, *_remarks(run.result), *others]
        self.query_one("#summary", Static).update("\n".join(lines))
        self.query_one(TransientPlots).show(run.result)


def _remarks(result: Transient) -> list[str]:
    try:
        found = stability(result.parameters, separation=result.separation)
    except ComputationError:
        return []
    words = remark(result, found)
    return [words] if words else []
