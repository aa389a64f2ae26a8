"""Tables: lists with columns as wide as their contents, and rows of label, value and note."""

from collections.abc import Iterable, Mapping, Sequence
from textwrap import wrap
from typing import ClassVar, Final, TypeVar

from rich.cells import cell_len
from rich.table import Table
from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import VerticalScroll
from textual.widgets import DataTable, Static

from fivtui.results import Row

Cell = TypeVar("Cell", str, str | Text)
# Minimum width of a wrapped column.
_MIN_WIDTH: Final = 12
_PADDING: Final = 1
_BETWEEN: Final = "  ·  "
# Width at which a wrapped column is readable: columns are omitted to reach it.
_READABLE: Final = 24


class ListTable(DataTable[Cell]):
    """A table with vi keys and measured columns.

    Textual measures columns one frame late and never shrinks them. In a narrow table the columns
    `dropped` are omitted, one after the other, then the column `wrapped` is wrapped.
    """

    wrapped: str = ""
    dropped: tuple[str, ...] = ()
    _filled: tuple[Sequence[str], Mapping[str, Sequence[Cell]]] | None = None

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("j", "cursor_down", "Down", show=False),
        Binding("k", "cursor_up", "Up", show=False),
        Binding("h", "scroll_left", "Left", show=False),
        Binding("l", "scroll_right", "Right", show=False),
    ]

    def fill(self, columns: Sequence[str], rows: Mapping[str, Sequence[Cell]]) -> None:
        """Replace columns and rows (by row key); the cursor keeps its row."""
        self._filled = columns, rows
        cursor_row, scroll_x = self.cursor_row, self.scroll_x
        self.clear(columns=True)
        widths = {
            number: max(cell_len(label), *(_width(row[number]) for row in rows.values()), 0)
            for number, label in enumerate(columns)
        }
        for label in self.dropped:
            if self._crowded(columns, widths) and label in columns:
                del widths[columns.index(label)]
        lack, wrapped = self._lack(widths), -1
        if lack > 0 and self.wrapped in columns:
            wrapped = columns.index(self.wrapped)
            widths[wrapped] = max(widths[wrapped] - lack, _MIN_WIDTH)
        # As a last resort, omit the padding of columns.
        tight = self._lack(widths) > 0
        self.cell_padding = 0 if tight else _PADDING
        for number, width in widths.items():
            self.add_column(columns[number], width=width + tight)
        for key, row in rows.items():
            shown = {number: row[number] for number in widths}
            lines = wrap(str(row[wrapped]), widths[wrapped]) if wrapped >= 0 else []
            if lines:
                shown[wrapped] = "\n".join(lines)
            self.add_row(*shown.values(), key=key, height=max(len(lines), 1))
        self.move_cursor(row=cursor_row)
        self.scroll_x = scroll_x

    def _crowded(self, columns: Sequence[str], widths: Mapping[int, int]) -> bool:
        # Whether wrapping alone would make the column unreadably narrow.
        lack = self._lack(widths)
        if self.wrapped not in columns:
            return lack > 0
        width = widths[columns.index(self.wrapped)]
        return lack > 0 and width - lack < min(width, _READABLE)

    def _lack(self, widths: Mapping[int, int]) -> int:
        # Missing width of the table; 0 before it has a size.
        needed = sum(width + 2 * _PADDING for width in widths.values())
        return needed - self.scrollable_content_region.width if self.size.width else 0

    def on_resize(self) -> None:
        """Wrap for the new width."""
        if (self.wrapped or self.dropped) and self._filled is not None:
            self.fill(*self._filled)


def fitted(text: str, width: int) -> str:
    """A text cut to a width between words, with … at the cut."""
    if not 0 < width < cell_len(text):
        return text
    part = text[: width - 1]
    if text[width - 1] not in " ,;":
        part = part.rpartition(" ")[0] or part
    return f"{part.rstrip(' ,;')}…"


def flowed(facts: Iterable[str], width: int) -> str:
    """Facts in as few lines as possible, none divided."""
    lines: list[str] = []
    for fact in facts:
        if lines and cell_len(lines[-1]) + cell_len(fact) + len(_BETWEEN) <= width:
            lines[-1] += f"{_BETWEEN}{fact}"
        else:
            lines.append(fact)
    return "\n".join(lines)


def _width(cell: str | Text) -> int:
    return cell.cell_len if isinstance(cell, Text) else cell_len(cell)


class RowsView(VerticalScroll):
    """A scrollable list of `Row`."""

    def compose(self) -> ComposeResult:
        """The table."""
        yield Static("", markup=False)

    def show(self, rows: Sequence[Row], otherwise: str) -> None:
        """Display rows; without rows, the text `otherwise`."""
        self.query_one(Static).update(grid(rows) if rows else otherwise)


def grid(rows: Sequence[Row]) -> Table:
    """Rows as a table: label, then value in bold and note, wrapped."""
    table = Table.grid(padding=(0, 2))
    table.add_column(no_wrap=True)
    for row in rows:
        table.add_row(Text(row.label), Text.assemble((row.value, "bold"), "  ", row.note))
    return table
