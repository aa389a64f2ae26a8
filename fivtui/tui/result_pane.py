"""The tab of the figures that came out of a run."""

from textual.app import ComposeResult

from .pane import Pane
from .report import result_rows
from .runs import Run
from .table import RowsView


class ResultPane(Pane):
    """The figures of the run shown."""

    def compose(self) -> ComposeResult:
        """The rows."""
        yield RowsView(id="result-rows")

    def run_changed(self, run: Run | None) -> None:
        """Show the figures of a run."""
        view = self.query_one("#result-rows", RowsView)
        if run is None or run.result is None:
            view.show([], "no result yet: F5 runs")
        else:
            view.show(result_rows(run.result, run.accuracy), "")
