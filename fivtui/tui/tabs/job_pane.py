"""A pane with a computation that the user starts."""

from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.events import Resize
from textual.widgets import Button, ProgressBar, Static

from fivtui.model import InputError
from fivtui.tui.session import PRECEDENCE, Job, Outcome, Session, outcome_of

from .messages import Reported
from .tables import fitted
from .threads import compute_in_thread
from .views_pane import ViewsPane

_PERIOD: Final = 0.1


class JobWords(Static):
    """Words in one line; those without room are in the tooltip. Errors take all their lines."""

    def __init__(self, words: str) -> None:
        super().__init__(words, classes="job-words", markup=False)
        self._words = words
        self._wrong = False

    def show(self, words: str, *, wrong: bool) -> None:
        """Display words, or the error message of an input."""
        resized = wrong or self._wrong
        self._words, self._wrong = words, wrong
        self._fit()
        if resized:
            self.refresh(layout=True)

    @on(Resize)
    def _fit(self) -> None:
        fit = self._words if self._wrong else fitted(self._words, self.size.width)
        self.update(fit, layout=False)
        self.tooltip = self._words if fit != self._words else None


class JobBar(Horizontal):
    """One line: start/stop button, progress bar, words; at first `hint`."""

    def __init__(self, verb: str, hint: str = "") -> None:
        super().__init__(classes="job-bar")
        self._verb, self._hint = verb, hint

    def compose(self) -> ComposeResult:
        """Button, progress bar, words."""
        yield Button(self._verb, classes="job-button", compact=True, variant="primary")
        yield ProgressBar(total=1.0, show_percentage=False, show_eta=False)
        yield JobWords(self._hint)

    def show(self, job: Job | None, words: str, *, wrong: bool = False) -> None:
        """Display a running job's progress, or else some words or what is wrong in the input."""
        running = job is not None
        if running is not self.has_class("-running"):
            button = self.query_one(Button)
            button.label = "Stop" if running else self._verb
            button.variant = "error" if running else "primary"
            self.set_class(running, "-running")
        if job is not None:
            self.query_one(ProgressBar).update(progress=job.fraction)
            words, wrong = job.words, False
        self.set_class(wrong, "-wrong")
        self.query_one(JobWords).show(words, wrong=wrong)


class JobPane(ViewsPane):
    """Views below a bar that starts and stops a computation in a thread.

    Attributes
    ----------
    VERB : str
        Label of the button.
    HINT : str
        Text before the first result.
    """

    VERB: ClassVar[str] = "Compute"
    HINT: ClassVar[str] = ""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self.job: Job | None = None
        self.words = self.HINT

    def compose(self) -> ComposeResult:
        """The bar above the views."""
        yield JobBar(self.VERB)
        yield from super().compose()

    def on_mount(self) -> None:
        """Start polling the progress."""
        self._ticker = self.set_interval(_PERIOD, self._tick, pause=True)
        self.show_bar()

    def on_unmount(self) -> None:
        """Stop the job: the program would wait for its thread."""
        self.stop()
        self._ticker.stop()

    def key_words(self) -> list[str]:
        """Besides, the key that starts and stops the job."""
        return [f"F10 {self.VERB.lower()}", *super().key_words()]

    def begin(self) -> None:
        """Check the inputs and call `start`; raises `InputError` if they are invalid."""
        raise NotImplementedError

    def take(self, result: Any) -> None:
        """Display a result; called in the screen's thread."""
        raise NotImplementedError

    def progressed(self) -> None:
        """Display partial results; called about ten times a second."""

    def start(self, compute: Callable[[Job], object]) -> None:
        """Run `compute(job)` in a thread; it calls `job.report` often and returns the result."""
        self.stop()
        self.job = job = Job()

        def outcome() -> Outcome[object]:
            return outcome_of(lambda: compute(job))

        compute_in_thread(self, outcome, partial(self._ended, job))
        self._ticker.resume()
        self.show_bar()

    def stop(self) -> None:
        """Stop the job; its result is dropped."""
        if self.job is not None:
            self.words = self.job.stop_words
            self.job.stop()
            self.job = None

    def work(self) -> bool:
        """Start or stop the job."""
        if self.job is not None:
            self.stop()
            self._ticker.pause()
        else:
            try:
                self.begin()
            except InputError as error:
                self.say(str(error))
                self.post_message(Reported(str(error), error=True))
        self.show_bar()
        return True

    @on(Button.Pressed, ".job-button")
    def _pressed_job(self, event: Button.Pressed) -> None:
        event.stop()
        self.work()

    def _ended(self, job: Job, outcome: Outcome[object]) -> None:
        if job is not self.job:
            return
        self.job = None
        self._ticker.pause()
        if outcome.error:
            self.words = outcome.error
            self.post_message(Reported(outcome.error, error=True))
        elif outcome.result is not None:
            self.words = ""
            self.take(outcome.result)
        self.show_bar()

    def say(self, words: str) -> None:
        """Display words in the bar while no job is running."""
        self.words = words
        self.show_bar()

    def _tick(self) -> None:
        if PRECEDENCE.claimed:
            return
        self.show_bar()
        if self.job is not None:
            self.progressed()

    def show_bar(self) -> None:
        """Display the job's progress, or else the words."""
        self.query_one(JobBar).show(self.job, self.words)
