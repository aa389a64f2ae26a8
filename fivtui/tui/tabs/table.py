"""Rows of label, value and note."""

from collections.abc import Sequence

from rich.table import Table
from rich.text import Text
from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.widgets import Static

from fivtui.tui.session.report import Row


class RowsView(VerticalScroll):
    """A scrollable list of `Row`."""

    def compose(self) -> ComposeResult:
        """One renderable."""
        yield Static("", markup=False)

    def show(self, rows: Sequence[Row], otherwise: str) -> None:
        """Show rows.

        Parameters
        ----------
        rows : sequence of Row
            The rows.
        otherwise : str
            What to say if there are none.
        """
        self.query_one(Static).update(grid(rows) if rows else otherwise)


def grid(rows: Sequence[Row]) -> Table:
    """Rows in two columns, of which the second wraps.

    Parameters
    ----------
    rows : sequence of Row
        The rows.

    Returns
    -------
    Table
        Labels never wrapped; values in bold, with their notes behind them.
    """
    table = Table.grid(padding=(0, 2))
    table.add_column(no_wrap=True)
    for row in rows:
        table.add_row(Text(row.label), Text.assemble((row.value, "bold"), "  ", row.note))
    return table
