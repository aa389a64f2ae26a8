"""A pane with a computation that the user starts."""

from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar, Final, TypeVar

from textual import on
from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.events import Resize
from textual.widget import Widget
from textual.widgets import Button, ProgressBar, Static

from fivtui.model import InputError
from fivtui.tui.session import (
    SCREEN_RESPONSE,
    Job,
    Outcome,
    Session,
    compute_outcome,
    crash_message,
)

from .messages import Reported
from .tables import shorten
from .views_pane import ViewsPane

_POLL_INTERVAL_S: Final = 0.1

T = TypeVar("T")


def compute_in_thread(
    owner: Widget, compute: Callable[[], Outcome[T]], show_outcome: Callable[[Outcome[T]], object]
) -> None:
    """Call `compute` in a thread, then `show_outcome` with its outcome in the thread of `owner`.

    The outcome of an unexpected error is its message.
    """

    def compute_and_report() -> None:
        try:
            outcome = compute()
        except Exception as error:  # noqa: BLE001 (it is displayed)
            outcome = Outcome(error=crash_message(error))
        owner.call_later(show_outcome, outcome)

    owner.run_worker(compute_and_report, thread=True, exit_on_error=False)


class JobStatus(Static):
    """A status in one line, with the full text as tooltip; error messages are wrapped."""

    def __init__(self, text: str) -> None:
        super().__init__(text, classes="job-status", markup=False)
        self._full_text = text
        self._is_error = False

    def show(self, text: str, *, is_error: bool) -> None:
        """Display a status, or the error message of an input."""
        may_change_height = is_error or self._is_error
        self._full_text, self._is_error = text, is_error
        self._fit_text()
        if may_change_height:
            self.refresh(layout=True)

    @on(Resize)
    def _fit_text(self) -> None:
        text = self._full_text if self._is_error else shorten(self._full_text, self.size.width)
        self.update(text, layout=False)
        self.tooltip = self._full_text if text != self._full_text else None


class JobBar(Horizontal):
    """One line with start/stop button, progress bar and status; the first status is `hint`."""

    def __init__(self, verb: str, hint: str = "") -> None:
        super().__init__(classes="job-bar")
        self._verb, self._hint = verb, hint

    def compose(self) -> ComposeResult:
        """Button, progress bar, status."""
        yield Button(self._verb, classes="job-button", compact=True, variant="primary")
        yield ProgressBar(total=1.0, show_percentage=False, show_eta=False)
        yield JobStatus(self._hint)

    def show(self, job: Job | None, text: str, *, is_error: bool = False) -> None:
        """Display the progress of a running job; without job, a status or the error of an input."""
        running = job is not None
        if running is not self.has_class("-running"):
            button = self.query_one(Button)
            button.label = "Stop" if running else self._verb
            button.variant = "error" if running else "primary"
            self.set_class(running, "-running")
        if job is not None:
            self.query_one(ProgressBar).update(progress=job.fraction)
            text, is_error = job.progress_text, False
        self.set_class(is_error, "-wrong")
        self.query_one(JobStatus).show(text, is_error=is_error)


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
        self.status = self.HINT

    def compose(self) -> ComposeResult:
        """The bar above the views."""
        yield JobBar(self.VERB)
        yield from super().compose()

    def on_mount(self) -> None:
        """Prepare the polling of the progress."""
        self._polling = self.set_interval(_POLL_INTERVAL_S, self._poll_progress, pause=True)
        self.show_bar()

    def on_unmount(self) -> None:
        """Stop the job: else the program would wait for its thread at exit."""
        self.stop()
        self._polling.stop()

    def key_hints(self) -> list[str]:
        """Keys of the tab; the first starts and stops the job."""
        return [f"F10 {self.VERB.lower()}", *super().key_hints()]

    def start_from_inputs(self) -> None:
        """Check the inputs and call `start`; raises `InputError` if they are invalid."""
        raise NotImplementedError

    def show_result(self, result: Any) -> None:
        """Display a result; called in the screen's thread."""
        raise NotImplementedError

    def show_progress(self) -> None:
        """Display partial results; called about ten times a second."""

    def start(self, compute: Callable[[Job], object]) -> None:
        """Run `compute(job)` in a thread; it calls `job.report` often, and returns the result."""
        self.stop()
        self.job = job = Job()

        def outcome() -> Outcome[object]:
            return compute_outcome(lambda: compute(job))

        compute_in_thread(self, outcome, partial(self._show_outcome, job))
        self._polling.resume()
        self.show_bar()

    def stop(self) -> None:
        """Stop the job and discard its result."""
        if self.job is not None:
            self.status = self.job.stop_text
            self.job.stop()
            self.job = None

    def toggle_computation(self) -> bool:
        """Start or stop the job; True, because this tab has a computation."""
        if self.job is not None:
            self.stop()
            self._polling.pause()
        else:
            try:
                self.start_from_inputs()
            except InputError as error:
                self.show_status(str(error))
                self.post_message(Reported(str(error), error=True))
        self.show_bar()
        return True

    @on(Button.Pressed, ".job-button")
    def _toggle_pressed(self, event: Button.Pressed) -> None:
        event.stop()
        self.toggle_computation()

    def _show_outcome(self, job: Job, outcome: Outcome[object]) -> None:
        if job is not self.job:
            return
        self.job = None
        self._polling.pause()
        if outcome.error:
            self.status = outcome.error
            self.post_message(Reported(outcome.error, error=True))
        elif outcome.result is not None:
            self.status = ""
            self.show_result(outcome.result)
        self.show_bar()

    def show_status(self, status: str) -> None:
        """Display a status in the bar while no job is running."""
        self.status = status
        self.show_bar()

    def _poll_progress(self) -> None:
        if SCREEN_RESPONSE.pending:
            # Drawing the progress would delay the response to a key.
            return
        self.show_bar()
        if self.job is not None:
            self.show_progress()

    def show_bar(self) -> None:
        """Display the progress of the job; without job, the status."""
        self.query_one(JobBar).show(self.job, self.status)
