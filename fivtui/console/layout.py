"""Layout of a printed table: one block, or several blocks if it is wider than the terminal.

Key columns, the first ones, identify a row and are repeated in every block. Widths are in
characters.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from rich.cells import cell_len
from rich.console import JustifyMethod
from rich.text import Text

# Space between two columns, and the width below which text is hard to read.
GAP: Final = 2
READABLE_WIDTH: Final = 32


@dataclass(frozen=True, slots=True)
class TableColumn:
    """A column of a printed table: its heading, and a cell for each row."""

    name: str
    cells: tuple[str | Text, ...]
    justify: JustifyMethod = "right"

    @property
    def natural_width(self) -> int:
        """Width with nothing wrapped."""
        return max(cell_len(self.name), self._widest_cell)

    @property
    def least_width(self) -> int:
        """Width with the heading wrapped at spaces, and no cell wrapped."""
        return max(self._widest_cell, *(cell_len(part) for part in self.name.split()), 0)

    @property
    def _widest_cell(self) -> int:
        return max((cell_len(str(cell)) for cell in self.cells), default=0)


# Columns that are printed side by side, with their widths.
Block = list[tuple[TableColumn, int]]


def split_columns(columns: Sequence[TableColumn], keys: int, width: int | None) -> list[Block]:
    """Split a table into blocks of at most `width` characters, printed one below the other.

    The first `keys` columns are repeated in every block; if they leave no room for the others, row
    numbers replace them. A column may be narrower than its cells, which are folded when printed. A
    `width` of None is no limit.
    """
    single_block = [(column, column.natural_width) for column in columns]
    if width is None or _block_width(single_block) <= width:
        return [single_block]
    key_columns, values = list(columns[:keys]), list(columns[keys:])
    # Room for every column, or as much of it as makes text readable.
    needed = max((min(column.least_width, READABLE_WIDTH) for column in values), default=0)
    if _room_beside(key_columns, width) < needed:
        count = max((len(column.cells) for column in columns), default=0)
        numbers = tuple(str(number) for number in range(1, count + 1))
        key_columns, values = [TableColumn("row", numbers)], list(columns)
    return list(_make_blocks(key_columns, values, _room_beside(key_columns, width)))


def _make_blocks(
    key_columns: Sequence[TableColumn], values: Sequence[TableColumn], room: int
) -> Iterator[Block]:
    # Blocks of keys and as many columns as fit into the room beside the keys.
    key_entries: Block = [(column, column.least_width) for column in key_columns]
    block: Block = []
    for column in values:
        entry = (column, min(column.least_width, max(room, 1)))
        if block and _block_width([*block, entry]) > room:
            yield [*key_entries, *block]
            block = []
        block.append(entry)
    yield [*key_entries, *block]


def _room_beside(key_columns: Sequence[TableColumn], width: int) -> int:
    # The width that key columns leave for others.
    return width - sum(column.least_width + GAP for column in key_columns)


def _block_width(block: Sequence[tuple[TableColumn, int]]) -> int:
    return sum(width for _, width in block) + GAP * max(len(block) - 1, 0)
