"""Lists with columns as wide as their contents; tables of rows with label, value and note."""

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
_MIN_WRAPPED_WIDTH: Final = 12
_PADDING: Final = 1
_FACT_SEPARATOR: Final = "  ·  "
# Width from which a wrapped column is readable; optional columns are omitted below it.
_READABLE_WIDTH: Final = 24


class ListTable(DataTable[Cell]):
    """A table with vi keys, whose columns are as wide as their contents.

    Textual measures columns one frame late and never shrinks them. A narrow table first omits the
    columns `optional`, one by one, then wraps the column `wrapped`.
    """

    wrapped: str = ""
    optional: tuple[str, ...] = ()
    _filled_content: tuple[Sequence[str], Mapping[str, Sequence[Cell]]] | None = None

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("j", "cursor_down", "Down", show=False),
        Binding("k", "cursor_up", "Up", show=False),
        Binding("h", "scroll_left", "Left", show=False),
        Binding("l", "scroll_right", "Right", show=False),
    ]

    def fill(self, columns: Sequence[str], rows: Mapping[str, Sequence[Cell]]) -> None:
        """Replace columns and rows (by row key); the cursor keeps its row."""
        self._filled_content = columns, rows
        cursor_row, scroll_x = self.cursor_row, self.scroll_x
        self.clear(columns=True)
        widths = {
            number: max(cell_len(label), *(_cell_width(row[number]) for row in rows.values()), 0)
            for number, label in enumerate(columns)
        }
        for label in self.optional:
            if self._is_crowded(columns, widths) and label in columns:
                del widths[columns.index(label)]
        missing_width, wrapped = self._missing_width(widths), -1
        if missing_width > 0 and self.wrapped in columns:
            wrapped = columns.index(self.wrapped)
            widths[wrapped] = max(widths[wrapped] - missing_width, _MIN_WRAPPED_WIDTH)
        # If the columns are still too wide, omit their padding.
        is_tight = self._missing_width(widths) > 0
        self.cell_padding = 0 if is_tight else _PADDING
        for number, width in widths.items():
            self.add_column(columns[number], width=width + is_tight)
        for key, row in rows.items():
            cells = {number: row[number] for number in widths}
            lines = wrap(str(row[wrapped]), widths[wrapped]) if wrapped >= 0 else []
            if lines:
                cells[wrapped] = "\n".join(lines)
            self.add_row(*cells.values(), key=key, height=max(len(lines), 1))
        self.move_cursor(row=cursor_row)
        self.scroll_x = scroll_x

    def _is_crowded(self, columns: Sequence[str], widths: Mapping[int, int]) -> bool:
        # Whether the wrapped column would be too narrow to read.
        missing_width = self._missing_width(widths)
        if self.wrapped not in columns:
            return missing_width > 0
        width = widths[columns.index(self.wrapped)]
        return missing_width > 0 and width - missing_width < min(width, _READABLE_WIDTH)

    def _missing_width(self, widths: Mapping[int, int]) -> int:
        # Width of the columns beyond that of the table; 0 before the table has a size.
        needed = sum(width + 2 * _PADDING for width in widths.values())
        return needed - self.scrollable_content_region.width if self.size.width else 0

    def on_resize(self) -> None:
        """Wrap for the new width."""
        if (self.wrapped or self.optional) and self._filled_content is not None:
            self.fill(*self._filled_content)


def shorten(text: str, width: int) -> str:
    """Shorten a text to a width at the end of a word, and append …."""
    if not 0 < width < cell_len(text):
        return text
    shortened = text[: width - 1]
    if text[width - 1] not in " ,;":
        shortened = shortened.rpartition(" ")[0] or shortened
    return f"{shortened.rstrip(' ,;')}…"


def flow_facts(facts: Iterable[str], width: int) -> str:
    """Join facts in as few lines as possible, without breaks inside a fact."""
    lines: list[str] = []
    for fact in facts:
        if lines and cell_len(lines[-1]) + cell_len(fact) + len(_FACT_SEPARATOR) <= width:
            lines[-1] += f"{_FACT_SEPARATOR}{fact}"
        else:
            lines.append(fact)
    return "\n".join(lines)


def _cell_width(cell: str | Text) -> int:
    return cell.cell_len if isinstance(cell, Text) else cell_len(cell)


class RowsView(VerticalScroll):
    """A scrollable table of `Row`."""

    def compose(self) -> ComposeResult:
        """The table."""
        yield Static("", markup=False)

    def show(self, rows: Sequence[Row], empty_text: str) -> None:
        """Display rows; without rows, the text `empty_text`."""
        self.query_one(Static).update(rows_table(rows) if rows else empty_text)


def rows_table(rows: Sequence[Row]) -> Table:
    """A table with the label of each row, and its value in bold with its note, wrapped."""
    table = Table.grid(padding=(0, 2))
    table.add_column(no_wrap=True)
    for row in rows:
        table.add_row(Text(row.label), Text.assemble((row.value, "bold"), "  ", row.note))
    return table
