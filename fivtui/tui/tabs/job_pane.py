"""A pane that computes something when it is asked to."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.message import Message
from textual.widgets import Button, ProgressBar, Static
from textual.worker import Worker, WorkerState

from fivtui.model.errors import Cancelled, ComputationError, InputError
from fivtui.tui.session.jobs import PRECEDENCE, Job
from fivtui.tui.session.session import Session

from .messages import Reported
from .views_pane import ViewsPane

_PERIOD: Final = 0.1


class JobBar(Horizontal):
    """One line: the button that begins and stops, the progress, and words.

    Parameters
    ----------
    verb : str
        What the button says.
    """

    def __init__(self, verb: str) -> None:
        super().__init__(classes="job-bar")
        self._verb = verb

    def compose(self) -> ComposeResult:
        """The parts of the line."""
        yield Button(self._verb, classes="job-button", compact=True, variant="primary")
        yield ProgressBar(total=1.0, show_percentage=False, show_eta=False)
        yield Static("", classes="job-words", markup=False)

    def show(self, job: Job | None, words: str) -> None:
        """Show where a job stands.

        Parameters
        ----------
        job : Job or None
            What is under way.
        words : str
            What to say if nothing is.
        """
        running = job is not None
        if running is not self.has_class("-running"):
            button = self.query_one(Button)
            button.label = "Stop" if running else self._verb
            button.variant = "error" if running else "primary"
            self.set_class(running, "-running")
        if job is not None:
            self.query_one(ProgressBar).update(progress=job.fraction)
            words = job.words
        self.query_one(Static).update(words, layout=False)


class JobPane(ViewsPane):
    """A bar with a button above the views; what it begins is computed in a thread.

    Attributes
    ----------
    VERB : str
        What the button says.
    HINT : str
        What to say before anything was computed.
    """

    VERB: ClassVar[str] = "Compute"
    HINT: ClassVar[str] = ""

    @dataclass
    class Ended(Message):
        """A thread came to its end: with a result, with an error, or stopped."""

        job: Job
        result: object = None
        error: str = ""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self.job: Job | None = None
        self.words = self.HINT

    def compose(self) -> ComposeResult:
        """The bar above the views."""
        yield JobBar(self.VERB)
        yield from super().compose()

    def on_mount(self) -> None:
        """Prepare to poll the progress."""
        self._ticker = self.set_interval(_PERIOD, self._tick, pause=True)
        self._show_bar()

    def on_unmount(self) -> None:
        """Let what goes on end: the program would wait for its thread."""
        self.stop()
        self._ticker.stop()

    def begin(self) -> None:
        """Begin what the tab computes: check the request, then call `start`.

        Raises
        ------
        InputError
            If the request is wrong.
        """
        raise NotImplementedError

    def take(self, result: Any) -> None:
        """Take in a result, on the screen's side."""
        raise NotImplementedError

    def progressed(self) -> None:
        """Show what is known by now. Called about ten times a second."""

    def start(self, compute: Callable[[Job], object]) -> None:
        """Compute something in a thread.

        Parameters
        ----------
        compute : callable
            Takes the job, whose `report` it calls now and then, and returns the result.
        """
        self.stop()
        self.job = job = Job()

        def run() -> None:
            try:
                self.post_message(self.Ended(job, compute(job)))
            except Cancelled:
                self.post_message(self.Ended(job))
            except (InputError, ComputationError) as error:
                self.post_message(self.Ended(job, error=str(error)))

        # Its own group: a thread that was stopped may need a moment to end.
        self.run_worker(run, group="job", name=self.VERB, thread=True, exit_on_error=False)
        self._ticker.resume()
        self._show_bar()

    def stop(self) -> None:
        """Stop what is under way; its result is dropped."""
        if self.job is not None:
            self.words = f"stopped at {100.0 * self.job.fraction:.0f} %"
            self.job.stop()
            self.job = None

    def work(self) -> bool:
        """Begin, or stop."""
        if self.job is not None:
            self.stop()
            self._ticker.pause()
        else:
            try:
                self.begin()
            except InputError as error:
                self.words = str(error)
                self.post_message(Reported(str(error), error=True))
        self._show_bar()
        return True

    @on(Button.Pressed, ".job-button")
    def _pressed_job(self, event: Button.Pressed) -> None:
        event.stop()
        self.work()

    @on(Ended)
    def _ended(self, event: Ended) -> None:
        event.stop()
        if event.job is not self.job:
            return
        self.job = None
        self._ticker.pause()
        if event.error:
            self.words = event.error
            self.post_message(Reported(event.error, error=True))
        elif event.result is not None:
            self.words = ""
            self.take(event.result)
        self._show_bar()

    @on(Worker.StateChanged)
    def _thread_failed(self, event: Worker.StateChanged) -> None:
        if event.state is WorkerState.ERROR and event.worker.group == "job":
            event.stop()
            error = event.worker.error
            words = f"unexpected {type(error).__name__}: {error}"
            if self.job is not None:
                self.post_message(self.Ended(self.job, error=words))

    def say(self, words: str) -> None:
        """Say something in the bar while nothing is under way."""
        self.words = words
        self._show_bar()

    def _tick(self) -> None:
        if PRECEDENCE.claimed:
            return
        self._show_bar()
        if self.job is not None:
            self.progressed()

    def _show_bar(self) -> None:
        self.query_one(JobBar).show(self.job, self.words)
