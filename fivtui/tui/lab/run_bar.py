"""The bar with the run button, and progress and state of the newest run."""

from typing import Final

from textual import on
from textual.widgets import Button

from fivtui.tui.session import NATIVE_ENGINE, Run, RunState
from fivtui.tui.tabs import JobBar, RunRequested

NO_RUN_TEXT: Final = "no run yet: press F5"


class RunBar(JobBar):
    """The button that starts and stops runs, and the progress or state of the newest run."""

    def __init__(self) -> None:
        super().__init__("Run", NO_RUN_TEXT)

    @on(Button.Pressed)
    def _request_run(self, event: Button.Pressed) -> None:
        event.stop()
        self.post_message(RunRequested())

    def show_run(self, run: Run, *, outdated: bool) -> None:
        """Display the state of a run; `outdated` if the inputs have changed since."""
        running = run.state is RunState.RUNNING
        self.show(run if running else None, _state_text(run, outdated=outdated))


def _state_text(run: Run, *, outdated: bool) -> str:
    text = f"run {run.number} {run.state.value}"
    if outdated:
        return f"{text}, inputs changed since"
    if run.result is not None and run.result.stats.cpu_s is not None:
        engine = "" if run.engine == NATIVE_ENGINE else f", {run.engine}"
        text += f" in {run.result.stats.cpu_s:.2g} s{engine}, {run.accuracy_text}"
    return text
