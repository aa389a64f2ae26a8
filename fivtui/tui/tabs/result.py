"""The result tab."""

from textual.app import ComposeResult

from fivtui.results import Row
from fivtui.transient import transient_rows
from fivtui.tui.session import Run, change_rows

from .pane import Pane
from .tables import RowsView


class ResultPane(Pane):
    """The numbers of the displayed run, and their differences to the baseline."""

    def compose(self) -> ComposeResult:
        """The rows."""
        yield RowsView(id="result-rows")

    def run_changed(self, run: Run | None) -> None:
        """Display the numbers of a run, with differences to the baseline if there is one."""
        view = self.query_one("#result-rows", RowsView)
        if run is None or run.result is None:
            view.show([], "no result yet: press F5")
            return
        rows = transient_rows(run.result, run.accuracy_text)
        baseline = self.session.runs.baseline
        if baseline is not None and baseline is not run and baseline.result is not None:
            heading = Row(
                "baseline", f"run {baseline.number}", f"run {run.number} − run {baseline.number}:"
            )
            rows += [Row("", ""), heading, *change_rows(run.result, baseline.result)]
        view.show(rows, "")
