"""Rows of label, value and note."""

from collections.abc import Sequence

from rich.table import Table
from rich.text import Text
from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.widgets import Static

from .report import Row


class RowsView(VerticalScroll):
    """A scrollable list of `Row`."""

    def compose(self) -> ComposeResult:
        """One renderable."""
        yield Static("")

    def show(self, rows: Sequence[Row], otherwise: str) -> None:
        """Show rows.

        Parameters
        ----------
        rows : sequence of Row
            The rows.
        otherwise : str
            What to say if there are none.
        """
        table = Table.grid(padding=(0, 2))
        for row in rows:
            table.add_row(Text(row.label), Text(row.value, style="bold"), Text(row.note))
        self.query_one(Static).update(table if rows else Text(otherwise))
