"""How the command line prints: tables on standard output, progress on standard error."""

import sys
import time
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Final, Self

from rich.cells import cell_len
from rich.console import Console, JustifyMethod, RenderableType
from rich.padding import Padding
from rich.progress import BarColumn, Progress as Bar, TaskID, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from fivtui.model import Parameters

from .layout import GAP, READABLE, Column, blocks_of

# A bar for less than this would only flicker.
_PATIENCE_S: Final = 1.0
_NO_LIMIT: Final = 1_000_000


class Progress:
    """A progress bar on standard error that appears only when a computation takes over a second.

    Parameters
    ----------
    label : str
        What is being done.
    compiling : callable, optional
        Whether it waits for a compiler.
    """

    def __init__(self, label: str, compiling: Callable[[], bool] = lambda: False) -> None:
        self._label = label
        self._compiling = compiling
        self._bar: Bar | None = None
        self._task: TaskID | None = None
        self._begin = time.monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, fraction: float) -> bool:
        """Show the fraction done, 0 to 1; always asks to go on."""
        if self._bar is None:
            if time.monotonic() - self._begin < _PATIENCE_S:
                return True
            console = Console(stderr=True)
            columns = (
                TextColumn("{task.description}", markup=False),
                BarColumn(),
                TimeRemainingColumn(),
            )
            self._bar = Bar(
                *columns, console=console, transient=True, disable=not console.is_terminal
            )
            self._bar.start()
            self._task = self._bar.add_task(self._label, total=1.0)
        if self._task is not None:
            self._bar.update(self._task, completed=fraction, description=self._description())
        return True

    def _description(self) -> str:
        return f"{self._label}: compiling, once" if self._compiling() else self._label


def number(value: float, digits: int = 6) -> str:
    """A number for reading: a few significant digits."""
    return f"{value:.{digits}g}"


def print_list(title: str, rows: Sequence[tuple[str, str]]) -> None:
    """Print names and what they stand for: side by side, or one below the other where it is narrow.

    Parameters
    ----------
    title : str
        Title of the list; empty for none.
    rows : sequence of tuple of str
        Name and text of each.
    """
    width = terminal_width()
    names = max((cell_len(name) for name, _ in rows), default=0)
    texts = max((cell_len(text) for _, text in rows), default=0)
    beside = width is None or names + GAP + min(texts, READABLE) <= width
    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_column(no_wrap=beside, overflow="fold")
    if beside:
        table.add_column(overflow="fold")
    for name, text in rows:
        if beside:
            table.add_row(Text(name), Text(text))
        else:
            table.add_row(Text(name))
            table.add_row(Padding(Text(text, overflow="fold"), (0, 0, 0, GAP)))
    print_titled(title, table)


def print_titled(title: str, *parts: RenderableType) -> None:
    """Print a title, if there is one, and what it is of, on standard output.

    Parameters
    ----------
    title : str
        The title.
    *parts : renderable
        What stands below it.
    """
    width = terminal_width()
    # Without a terminal nothing is wrapped or cut: the reader is a program.
    console = Console(file=sys.stdout, width=width or _NO_LIMIT, highlight=False)
    with console.capture() as captured:
        if title:
            console.print(Text(title, style="italic", overflow="fold"))
        for part in parts:
            console.print(part)
    for line in captured.get().splitlines():
        sys.stdout.write(f"{line if width else line.rstrip()}\n")


def terminal_width() -> int | None:
    """The columns of the terminal that standard output is; None if it is none."""
    return Console(file=sys.stdout).width if sys.stdout.isatty() else None


def parameter_line(p: Parameters) -> str:
    """A parameter set in one line."""
    return "  ".join(f"{name}={number(value)}" for name, value in p.as_dict().items())


def print_rows(
    title: str,
    header: Sequence[str],
    rows: Sequence[Sequence[str | Text]],
    *,
    keys: int = 1,
    justify: JustifyMethod = "right",
) -> None:
    """Print a table; one that is wider than the terminal goes on below, with its keys again.

    Parameters
    ----------
    title : str
        Its title.
    header : sequence of str
        Column names.
    rows : sequence of sequence of str or Text
        As many texts each.
    keys : int
        How many columns, from the left, say what a row is of; see `layout.blocks_of`.
    justify : str
        How all columns but the first are justified.
    """
    columns = [
        Column(name, tuple(row[place] for row in rows), justify if place > 0 else "left")
        for place, name in enumerate(header)
    ]
    tables: list[RenderableType] = []
    for block in blocks_of(columns, keys, terminal_width()):
        table = Table(box=None, pad_edge=False)
        for column, width in block:
            table.add_column(
                column.name, justify=column.justify, width=width, overflow="fold", vertical="bottom"
            )
        for cells in zip(*(column.cells for column, _ in block), strict=True):
            table.add_row(*(Text(cell) if isinstance(cell, str) else cell for cell in cells))
        tables += [Text(), table] if tables else [table]
    print_titled(title, *tables)
