"""Lists with columns as wide as their contents; tables of rows with label, value and note."""

from collections.abc import Iterable, Mapping, Sequence
from textwrap import wrap
from typing import Any, ClassVar, Final, TypeVar

from rich.cells import cell_len
from rich.table import Table
from rich.text import Text
from textual.binding import Binding, BindingType
from textual.widgets import DataTable

from fivtui.results import Row

from .search import SearchableList, TextView

Cell = TypeVar("Cell", str, str | Text)
# Minimum width of a wrapped column, in characters.
_MIN_WRAPPED_WIDTH: Final = 12
# Width from which a wrapped column is readable; below it, other columns are omitted first.
_READABLE_WIDTH: Final = 24
# Blanks on each side of a column.
_PADDING: Final = 1
_FACT_SEPARATOR: Final = "  ·  "


class ListTable(DataTable[Cell], SearchableList):
    """A table with vi keys, whose columns are as wide as their contents.

    Textual measures columns one frame late and never shrinks them. A narrow table first omits the
    columns `omitted`, one by one, then wraps the column `wrapped`.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        *SearchableList.BINDINGS,
        Binding("h", "scroll_left", "Left", show=False),
        Binding("l", "scroll_right", "Right", show=False),
    ]

    def __init__(
        self,
        id: str | None = None,  # noqa: A002
        *,
        wrapped: str = "",
        omitted: Sequence[str] = (),
        **options: Any,
    ) -> None:
        super().__init__(id=id, cursor_type="row", zebra_stripes=True, **options)
        self._wrapped, self._omitted = wrapped, omitted
        # The columns and rows of the last call of `fill`.
        self._content: tuple[Sequence[str], Mapping[str, Sequence[Cell]]] = ((), {})

    def fill(self, columns: Sequence[str], rows: Mapping[str, Sequence[Cell]]) -> None:
        """Replace columns and rows (by row key); the cursor keeps its row."""
        self._content = columns, rows
        cursor_row, scroll_x = self.cursor_row, self.scroll_x
        self.clear(columns=True)
        # Widths of the shown columns, by the indices of the columns.
        widths = {
            index: max(cell_len(str(cell)) for cell in column)
            for index, column in enumerate(zip(columns, *rows.values(), strict=True))
        }
        wrapped = columns.index(self._wrapped) if self._wrapped in columns else None
        spare_width = 0 if wrapped is None else max(widths[wrapped] - _READABLE_WIDTH, 0)
        for label in self._omitted:
            if label in columns and self._missing_width(widths) > spare_width:
                del widths[columns.index(label)]
        missing_width = self._missing_width(widths)
        if missing_width <= 0:
            wrapped = None
        if wrapped is not None:
            widths[wrapped] = max(widths[wrapped] - missing_width, _MIN_WRAPPED_WIDTH)
        # If the columns are still too wide, a blank after each replaces the padding on both sides.
        is_tight = self._missing_width(widths) > 0
        self.cell_padding = 0 if is_tight else _PADDING
        for index, width in widths.items():
            self.add_column(columns[index], width=width + is_tight)
        for key, row in rows.items():
            cells, height = {index: row[index] for index in widths}, 1
            if wrapped is not None:
                lines = wrap(str(row[wrapped]), widths[wrapped])
                cells[wrapped], height = "\n".join(lines), max(len(lines), 1)
            self.add_row(*cells.values(), key=key, height=height)
        self.move_cursor(row=cursor_row)
        self.scroll_x = scroll_x

    def row_texts(self) -> Sequence[str]:
        """The texts of all rows, with those of omitted columns."""
        return [" ".join(map(str, row)) for row in self._content[1].values()]

    def action_move(self, rows: int) -> None:
        """Move the cursor by rows down, or up if negative."""
        self.move_cursor(row=min(max(self.cursor_row + rows, 0), self.row_count - 1))

    def _missing_width(self, widths: Mapping[int, int]) -> int:
        # Width of the columns beyond that of the table; 0 before the table has a size.
        needed_width = sum(width + 2 * _PADDING for width in widths.values())
        return needed_width - self.scrollable_content_region.width if self.size.width else 0

    def on_resize(self) -> None:
        """Wrap for the new width."""
        if self._wrapped or self._omitted:
            self.fill(*self._content)


def shorten(text: str, width: int) -> str:
    """Shorten a text to a width at the end of a word, and append …."""
    if width >= cell_len(text) or width <= 0:
        # The text fits, or the width is not known yet.
        return text
    shortened = text[: width - 1]
    if text[width - 1] not in " ,;":
        shortened = shortened.rpartition(" ")[0] or shortened
    return f"{shortened.rstrip(' ,;')}…"


def flow_facts(facts: Iterable[str], width: int, separator: str = _FACT_SEPARATOR) -> str:
    """Join facts in as few lines as possible, without breaks inside a fact."""
    lines: list[str] = []
    for fact in facts:
        if lines and cell_len(lines[-1]) + cell_len(fact) + len(separator) <= width:
            lines[-1] += f"{separator}{fact}"
        else:
            lines.append(fact)
    return "\n".join(lines)


class RowsView(TextView[Row]):
    """A scrollable table of `Row`."""

    def content_of(self, lines: Sequence[Row]) -> Table:
        """The table of rows."""
        return rows_table(lines)


def rows_table(rows: Sequence[Row]) -> Table:
    """A table with the label of each row, and its value in bold with its note, wrapped."""
    table = Table.grid(padding=(0, 2))
    table.add_column(no_wrap=True)
    for row in rows:
        table.add_row(Text(row.label), Text.assemble((row.value, "bold"), "  ", row.note))
    return table
