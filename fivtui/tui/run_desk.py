"""Running: transients in threads, their results taken in on the screen's side."""

from textual.screen import Screen
from textual.worker import Worker, WorkerState

from fivtui.core.errors import InputError

from .messages import Reported, RunEnded, RunsChanged
from .report import result_brief
from .runs import Outcome, execute
from .session import Session

_GROUP = "transient"


class RunDesk:
    """Starts, stops and finishes the runs of a session on behalf of a screen.

    Parameters
    ----------
    screen : Screen
        Owns the threads and gets the messages.
    session : Session
        Its runs are started, stopped and finished.
    """

    def __init__(self, screen: Screen[None], session: Session) -> None:
        self._screen = screen
        self._session = session

    def start(self) -> bool:
        """Begin a run of what is edited; whether that could be done."""
        try:
            scene = self._session.scene()
        except InputError as error:
            self._tell(Reported(str(error), error=True))
            return False
        run = self._session.runs.start(scene)
        self._screen.run_worker(
            lambda: self._screen.post_message(RunEnded(run, execute(run))),
            name=str(run.number),
            group=_GROUP,
            thread=True,
            exit_on_error=False,
        )
        self._tell(RunsChanged())
        return True

    def stop(self) -> None:
        """Stop the run that goes on."""
        run = self._session.runs.stop()
        if run is not None:
            self._tell(RunsChanged())
            done = f"{100.0 * run.fraction:.0f} %"
            self._tell(Reported(f"run {run.number} stopped at {done}"))

    def ended(self, event: RunEnded) -> None:
        """Take in how a run ended, unless it was stopped before.

        Parameters
        ----------
        event : RunEnded
            The run and its outcome.
        """
        run = event.run
        if not self._session.runs.finish(run, event.outcome):
            return
        if run.result is None:
            self._tell(Reported(f"run {run.number}: {run.message}", error=True))
        else:
            self._session.runs.shown = run
            words = "; ".join([f"run {run.number} done", *result_brief(run.result)])
            self._tell(Reported(words, routine=True))
        self._tell(RunsChanged())

    def thread_failed(self, worker: Worker[object]) -> bool:
        """Take in that a thread broke off, which it must not.

        Parameters
        ----------
        worker : Worker
            Whose state has changed.

        Returns
        -------
        bool
            Whether it computed a run, which then failed.
        """
        if worker.group != _GROUP or worker.state is not WorkerState.ERROR or worker.name is None:
            return False
        run = self._session.runs.find(int(worker.name))
        if run is not None:
            words = f"unexpected {type(worker.error).__name__}: {worker.error}"
            self._tell(RunEnded(run, Outcome(error=words)))
        return True

    def _tell(self, message: Reported | RunEnded | RunsChanged) -> None:
        self._screen.post_message(message)
