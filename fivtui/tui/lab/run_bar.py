"""Run button, progress and state of the last run."""

from textual import on
from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.widgets import Button, ProgressBar, Static

from fivtui.tui.session import FMU_ENGINE, Run, RunState, progress_words
from fivtui.tui.tabs import RunRequested


class RunBar(Horizontal):
    """One line: the button, a progress bar during a run, and the state in words."""

    def compose(self) -> ComposeResult:
        """Button, progress bar, status."""
        yield Button("Run", id="run-button", compact=True, variant="primary")
        yield ProgressBar(total=1.0, show_percentage=False, show_eta=False)
        yield Static("no run yet: press F5", id="run-status", markup=False)

    @on(Button.Pressed, "#run-button")
    def _press(self, event: Button.Pressed) -> None:
        event.stop()
        self.post_message(RunRequested())

    def show(self, run: Run, *, outdated: bool) -> None:
        """Display the state of a run; `outdated` if the inputs have changed since."""
        running = run.state is RunState.RUNNING
        button = self.query_one("#run-button", Button)
        if running is not self.has_class("-running"):
            button.label = "Stop" if running else "Run"
            button.variant = "error" if running else "primary"
            self.set_class(running, "-running")
        self.query_one(ProgressBar).update(progress=run.fraction)
        words = (
            progress_words(run.fraction, run.remaining)
            if running
            else _end_words(run, outdated=outdated)
        )
        self.query_one("#run-status", Static).update(words, layout=False)


def _end_words(run: Run, *, outdated: bool) -> str:
    words = f"run {run.number} {run.state.value}"
    if outdated:
        return f"{words}, inputs changed since"
    if run.result is not None and run.result.stats.cpu_s is not None:
        engine = f", {FMU_ENGINE}" if run.engine == FMU_ENGINE else ""
        words += f" in {run.result.stats.cpu_s:.2g} s{engine}, {run.accuracy}"
    return words
