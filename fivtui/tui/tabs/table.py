"""Rows of label, value and note."""

from collections.abc import Sequence

from rich.table import Table
from rich.text import Text
from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.widgets import Static

from fivtui.tui.session import Row


class RowsView(VerticalScroll):
    """A scrollable list of `Row`."""

    def compose(self) -> ComposeResult:
        """The table."""
        yield Static("", markup=False)

    def show(self, rows: Sequence[Row], otherwise: str) -> None:
        """Display rows, or if there are none the text `otherwise`."""
        self.query_one(Static).update(grid(rows) if rows else otherwise)


def grid(rows: Sequence[Row]) -> Table:
    """Rows as a table: label, then value in bold and note, wrapped."""
    table = Table.grid(padding=(0, 2))
    table.add_column(no_wrap=True)
    for row in rows:
        table.add_row(Text(row.label), Text.assemble((row.value, "bold"), "  ", row.note))
    return table
