"""How a table is laid out on a width: in one block, or in several that repeat its keys."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from rich.cells import cell_len
from rich.console import JustifyMethod
from rich.text import Text

# Between two columns; and the width at which running text can still be read.
GAP: Final = 2
READABLE: Final = 32


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a table.

    Attributes
    ----------
    name : str
        What stands above it.
    cells : tuple of str or Text
        One a row.
    justify : str
        How they are justified.
    """

    name: str
    cells: tuple[str | Text, ...]
    justify: JustifyMethod = "right"

    @property
    def natural(self) -> int:
        """Its width with nothing wrapped."""
        return max(cell_len(self.name), self._widest)

    @property
    def least(self) -> int:
        """Its width with the name wrapped at spaces, and no cell."""
        return max(self._widest, *(cell_len(word) for word in self.name.split()), 0)

    @property
    def _widest(self) -> int:
        return max((cell_len(str(cell)) for cell in self.cells), default=0)


Block = list[tuple[Column, int]]


def blocks_of(columns: Sequence[Column], keys: int, width: int | None) -> list[Block]:
    """The blocks in which a table is printed, one below the other.

    Parameters
    ----------
    columns : sequence of Column
        The table.
    keys : int
        How many columns, from the left, say what a row is of: every block has them. Where they
        leave no room for others, numbers of the rows take their place.
    width : int or None
        What a block may take; None for no limit.

    Returns
    -------
    list of list of (Column, int)
        Columns with their widths. Every column is in a block; a cell that is wider is to be folded.
    """
    natural = [(column, column.natural) for column in columns]
    if width is None or _taken(natural) <= width:
        return [natural]
    heads, others = list(columns[:keys]), list(columns[keys:])
    if _room(heads, width) < max((min(c.least, READABLE) for c in others), default=0):
        count = max((len(column.cells) for column in columns), default=0)
        numbers = tuple(str(number) for number in range(1, count + 1))
        heads, others = [Column("row", numbers)], list(columns)
    return list(_filled(heads, others, _room(heads, width)))


def _filled(heads: Sequence[Column], others: Sequence[Column], room: int) -> Iterator[Block]:
    first: Block = [(column, column.least) for column in heads]
    block: Block = []
    for column in others:
        entry = (column, min(column.least, max(room, 1)))
        if block and _taken([*block, entry]) > room:
            yield [*first, *block]
            block = []
        block.append(entry)
    yield [*first, *block]


def _room(heads: Sequence[Column], width: int) -> int:
    return width - sum(column.least + GAP for column in heads)


def _taken(block: Sequence[tuple[Column, int]]) -> int:
    return sum(width for _, width in block) + GAP * max(len(block) - 1, 0)
