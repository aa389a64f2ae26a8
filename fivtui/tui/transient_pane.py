"""The tab of the transient: y and P over time and what came out."""

from textual.app import ComposeResult
from textual.widgets import Static

from fivtui.core.errors import ComputationError
from fivtui.core.outcome import Transient
from fivtui.core.stability import stability

from .pane import Pane
from .plots import TransientPlots
from .report import remark, result_brief
from .runs import Run


class TransientPane(Pane):
    """Plots and summary of the run shown."""

    def compose(self) -> ComposeResult:
        """The parts from top to bottom."""
        yield TransientPlots()
        yield Static("", id="summary", markup=False)

    def run_changed(self, run: Run | None) -> None:
        """Show the result of a run."""
        if run is None or run.result is None:
            return
        first, *others = result_brief(run.result)
        lines = [first, *_remarks(run.result), *others]
        self.query_one("#summary", Static).update("\n".join(lines))
        self.query_one(TransientPlots).show(run.result)

    def theme_changed(self) -> None:
        """Draw the plots in the colours of now."""
        self.query_one(TransientPlots).redraw()


def _remarks(result: Transient) -> list[str]:
    try:
        found = stability(result.parameters, separation=result.separation)
    except ComputationError:
        return []
    words = remark(result, found)
    return [words] if words else []
