"""Tables: lists with columns as wide as their contents, and rows of label, value and note."""

from collections.abc import Mapping, Sequence
from typing import ClassVar, TypeVar

from rich.cells import cell_len
from rich.table import Table
from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import VerticalScroll
from textual.widgets import DataTable, Static

from fivtui.results import Row

Cell = TypeVar("Cell", str, str | Text)


class ListTable(DataTable[Cell]):
    """A table with vi keys and measured columns.

    Textual measures columns one frame late and never shrinks them.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("j", "cursor_down", "Down", show=False),
        Binding("k", "cursor_up", "Up", show=False),
        Binding("h", "scroll_left", "Left", show=False),
        Binding("l", "scroll_right", "Right", show=False),
    ]

    def fill(self, columns: Sequence[str], rows: Mapping[str, Sequence[Cell]]) -> None:
        """Replace columns and rows (by row key); the cursor keeps its place."""
        place, across = self.cursor_row, self.scroll_x
        self.clear(columns=True)
        for number, label in enumerate(columns):
            widths = [_width(row[number]) for row in rows.values()]
            self.add_column(label, width=max(cell_len(label), *widths, 0))
        for key, row in rows.items():
            self.add_row(*row, key=key)
        self.move_cursor(row=place)
        self.scroll_x = across


def _width(cell: str | Text) -> int:
    return cell.cell_len if isinstance(cell, Text) else cell_len(cell)


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
