"""The list of all runs of the session."""

from collections.abc import Iterable, Sequence
from typing import ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.widgets import DataTable

from .differences import base_scene, differences
from .messages import RunChosen
from .report import quantity
from .runs import Run

_COLUMNS = ("run", "state", "peak |y| m", "half range m", "off belt %", "changes")


class RunsTable(DataTable[str]):
    """A table with a row a run."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("j", "cursor_down", "Down", show=False),
        Binding("k", "cursor_up", "Up", show=False),
        Binding("enter", "select_cursor", "Show the run"),
    ]


class RunsPane(Vertical):
    """The runs, newest first, with what differs from the base set; choosing one shows it again."""

    def __init__(self) -> None:
        super().__init__(id="runs")

    def compose(self) -> ComposeResult:
        """The table."""
        yield RunsTable(cursor_type="row", zebra_stripes=True)

    def show(self, runs: Iterable[Run]) -> None:
        """Show the runs.

        Parameters
        ----------
        runs : iterable of Run
            Oldest first.
        """
        table = self.query_one(RunsTable)
        table.clear(columns=True)
        table.add_columns(*_COLUMNS)
        for run in reversed(list(runs)):
            table.add_row(*_cells(run), key=str(run.number))

    def take_focus(self) -> None:
        """Give the table the focus."""
        self.query_one(RunsTable).focus()

    @on(DataTable.RowSelected)
    def _choose(self, event: DataTable.RowSelected) -> None:
        event.stop()
        self.post_message(RunChosen(int(str(event.row_key.value))))


def _cells(run: Run) -> Sequence[str]:
    changes = ", ".join(map(str, differences(run.scene, base_scene()))) or "none"
    result = run.result
    if result is None:
        return (str(run.number), run.state.value, "", "", "", changes)
    return (
        str(run.number),
        run.state.value,
        quantity(result.peak.y_abs),
        quantity(result.steady.y_half_range),
        f"{100.0 * result.events.separated_time / result.t_end:.3g}",
        changes,
    )
