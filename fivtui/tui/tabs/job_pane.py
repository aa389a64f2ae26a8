"""Panes with an action that the user starts, such as a computation."""

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any, ClassVar, Final, TypeVar

from rich.cells import cell_len
from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal
from textual.content import Content
from textual.events import Resize
from textual.widget import Widget
from textual.widgets import Button, ProgressBar, Static

from fivtui.tui.session import (
    SCREEN_RESPONSE,
    Job,
    Outcome,
    compute_outcome,
    crash_message,
    duration_text,
)

from .messages import Reported
from .tables import flow_facts, shorten
from .views_pane import ViewsPane

_POLL_INTERVAL_S: Final = 0.1
# Separates the facts of a status.
_FACT_SEPARATOR: Final = " · "
# Separates the facts of an answer.
FACTS: Final = "   "
_ANSWER_STYLE: Final = "bold"
_STATUS_STYLE: Final = "$foreground-muted"

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


class ActionBar(Horizontal):
    """The line of an action and its inputs."""

    DEFAULT_CLASSES = "bar"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "screen.focus_part('plot')", "Go to the plot or table", show=False)
    ]


class StatusLine(Horizontal):
    """The progress of a running job; else an answer in bold and a status, or the error of an input.

    Answers and errors are wrapped; facts of a status that do not fit are in the tooltip.
    """

    def __init__(self) -> None:
        super().__init__(classes="status-line")
        self._answer, self._text, self._is_error = "", "", False

    def compose(self) -> ComposeResult:
        """Progress bar, answer and status."""
        yield ProgressBar(total=1.0, show_percentage=False, show_eta=False)
        yield Static("", classes="job-status", markup=False)

    def show(self, job: Job | None, answer: str, text: str, *, is_error: bool) -> None:
        """Display the progress of a running job, or an answer and a text."""
        if job is not None:
            self.query_one(ProgressBar).update(progress=job.fraction)
            answer, text, is_error = "", job.progress_text, False
        self._answer, self._text, self._is_error = answer, text, is_error
        self.set_class(job is not None, "-running")
        self.set_class(is_error, "-wrong")
        self.set_class(bool(answer), "-answered")
        self._fit_text()

    @on(Resize)
    def _fit_text(self) -> None:
        text, width = self._text, self.size.width
        if not self._is_error:
            # Facts that do not fit are omitted from the last on.
            while 0 < width < cell_len(text) and _FACT_SEPARATOR in text:
                text = text.rpartition(_FACT_SEPARATOR)[0]
            text = shorten(text, width)
        lines = flow_facts(filter(None, (*self._answer.split(FACTS), text)), width)
        content = Content(lines)
        if self._answer:
            # The status comes last, in the line of the answer if it fits there.
            status_start = len(lines) - len(text)
            content = content.stylize(_ANSWER_STYLE, 0, status_start)
            content = content.stylize(_STATUS_STYLE, status_start)
        status = self.query_one(".job-status", Static)
        status.update(content)
        status.tooltip = self._text if text != self._text else None


class ActionPane(ViewsPane):
    """Views below a line with the primary action of the tab, its inputs, and a status."""

    # Label of the button, and the identifier of the key that does the same.
    VERB: ClassVar[str] = "Compute"
    KEY: ClassVar[str] = "compute"
    # Whether the status is below the views, because inputs fill the line of the action.
    STATUS_BELOW: ClassVar[bool] = False

    def compose(self) -> ComposeResult:
        """Action, views, status."""
        with ActionBar():
            yield Button("", classes="action", compact=True)
            yield from self.compose_bar()
            if not self.STATUS_BELOW:
                yield StatusLine()
        yield from super().compose()
        if self.STATUS_BELOW:
            yield StatusLine()

    def compose_bar(self) -> ComposeResult:
        """The inputs of the action."""
        yield from ()

    def show_action(
        self, job: Job | None, text: str, *, answer: str = "", is_error: bool = False
    ) -> None:
        """Display the progress of a running job, which the button stops; else answer and text."""
        button = self.query_one(".action", Button)
        key = self.session.key_names[self.KEY]
        button.label = f"{self.VERB if job is None else 'Stop'} {key}"
        button.variant = "primary" if job is None else "warning"
        self.query_one(StatusLine).show(job, answer, text, is_error=is_error)

    def toggle_computation(self) -> None:
        """Start or stop the computation of the tab."""
        raise NotImplementedError

    @on(Button.Pressed, ".action")
    def _toggle_pressed(self, event: Button.Pressed) -> None:
        event.stop()
        self.toggle_computation()


class JobPane(ActionPane):
    """A pane whose action starts and stops a computation in a thread."""

    job: Job | None = None
    status = ""
    # What the displayed result says in words or numbers.
    answer = ""
    # Duration of the latest job that finished, s.
    duration = 0.0

    def on_mount(self) -> None:
        """Prepare the polling of the progress."""
        self._polling = self.set_interval(_POLL_INTERVAL_S, self._poll_progress, pause=True)
        self.show_bar()

    def on_unmount(self) -> None:
        """Stop the job: else the program would wait for its thread at exit."""
        self.stop()

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
        compute_job = partial(compute_outcome, partial(compute, job))
        compute_in_thread(self, compute_job, partial(self._show_outcome, job))
        self._polling.resume()
        self.show_bar()

    def stop(self) -> None:
        """Stop the job and discard its result."""
        if self.job is not None:
            self.status = self.job.stop_text
            self.job.stop()
            self.job = None

    def toggle_computation(self) -> None:
        """Start or stop the job."""
        if self.job is not None:
            self.stop()
            self._polling.pause()
        else:
            error = compute_outcome(self.start_from_inputs).error
            if error:
                self.show_status(error)
                self.post_message(Reported(error, error=True))
        self.show_bar()

    def _show_outcome(self, job: Job, outcome: Outcome[object]) -> None:
        if job is not self.job:
            return
        self.job = None
        self._polling.pause()
        if outcome.error:
            self.status = outcome.error
            self.post_message(Reported(outcome.error, error=True))
        elif outcome.result is not None:
            self.status, self.duration = "", job.elapsed
            self.show_result(outcome.result)
        self.show_bar()

    def log_result(self, name: str, facts: Iterable[str]) -> None:
        """List what was computed in the log, with its duration and the facts of its answer."""
        report = f"{name} done in {duration_text(self.duration)}"
        self.post_message(Reported("; ".join([report, *filter(None, facts)]), routine=True))

    def show_status(self, status: str, answer: str = "") -> None:
        """Display an answer and a status in the bar while no job is running."""
        self.status, self.answer = status, answer
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
        self.show_action(self.job, self.status, answer=self.answer)
