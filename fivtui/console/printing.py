"""Console output: tables to stdout, progress to stderr."""

import sys
import time
from collections.abc import Sequence
from types import TracebackType
from typing import Final, Self

from rich.cells import cell_len
from rich.console import Console, JustifyMethod, RenderableType
from rich.padding import Padding
from rich.progress import BarColumn, Progress as Bar, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from fivtui.model import Parameters

from .layout import GAP, READABLE, TableColumn, split_columns

# A progress bar appears after this time, so that short computations have none.
_DELAY_S: Final = 1.0
# Width of output that goes to a program, characters: lines are not wrapped.
_UNLIMITED_WIDTH: Final = 1_000_000


class ProgressBar:
    """A progress bar on stderr that appears after a second.

    `label` names the computation, `remaining` shows the time left.
    """

    def __init__(self, label: str, *, remaining: bool = True) -> None:
        self._label, self._remaining = label, remaining
        self._bar: Bar | None = None
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
        """Show the fraction done, 0 to 1; returns True, so that the computation continues."""
        self.show(fraction, self._label)
        return True

    def show(self, fraction: float, label: str) -> None:
        """Show the fraction done beside a label."""
        if self._bar is None:
            if time.monotonic() - self._begin < _DELAY_S:
                return
            console = Console(stderr=True)
            columns = [TextColumn("{task.description}", markup=False), BarColumn()]
            time_left = [TimeRemainingColumn()] if self._remaining else []
            self._bar = Bar(
                *columns,
                *time_left,
                console=console,
                transient=True,
                disable=not console.is_terminal,
            )
            self._bar.start()
            self._bar.add_task(label, total=1.0)
        self._bar.update(self._bar.task_ids[0], completed=fraction, description=label)


def print_list(title: str, rows: Sequence[Sequence[str]]) -> None:
    """Print rows of a name and texts, on a narrow terminal with the texts below the name."""
    width = terminal_width()
    lines = [(name, "  ".join(filter(None, parts))) for name, *parts in rows]
    name_width = max((cell_len(name) for name, _ in lines), default=0)
    text_width = max((cell_len(text) for _, text in lines), default=0)
    side_by_side = width is None or name_width + GAP + min(text_width, READABLE) <= width
    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_column(no_wrap=side_by_side, overflow="fold")
    if side_by_side:
        table.add_column(overflow="fold")
    for name, text in lines:
        if side_by_side:
            table.add_row(Text(name), Text(text))
        else:
            table.add_row(Text(name))
            table.add_row(Padding(Text(text, overflow="fold"), (0, 0, 0, GAP)))
    print_titled(title, table)


def print_titled(title: str, *parts: RenderableType) -> None:
    """Print a title, if it is not empty, and renderables below it to stdout."""
    width = terminal_width()
    console = Console(file=sys.stdout, width=width or _UNLIMITED_WIDTH, highlight=False)
    with console.capture() as captured:
        if title:
            console.print(Text(title, style="italic", overflow="fold"))
        for part in parts:
            console.print(part)
    for line in captured.get().splitlines():
        sys.stdout.write(f"{line if width else line.rstrip()}\n")


def terminal_width() -> int | None:
    """Width of the terminal that stdout is; None if it is no terminal."""
    return Console(file=sys.stdout).width if sys.stdout.isatty() else None


def number(value: float, digits: int = 6) -> str:
    """A number with a few significant digits."""
    return f"{value:.{digits}g}"


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
    """Print a table, in several blocks if it is wider than the terminal.

    The first `keys` columns identify a row; `justify` applies to all columns but the first.
    """
    columns = [
        TableColumn(name, tuple(row[index] for row in rows), justify if index > 0 else "left")
        for index, name in enumerate(header)
    ]
    tables: list[RenderableType] = []
    for block in split_columns(columns, keys, terminal_width()):
        table = Table(box=None, pad_edge=False)
        for column, width in block:
            table.add_column(
                column.name, justify=column.justify, width=width, overflow="fold", vertical="bottom"
            )
        for cells in zip(*(column.cells for column, _ in block), strict=True):
            table.add_row(*(Text(cell) if isinstance(cell, str) else cell for cell in cells))
        tables += [Text(), table] if tables else [table]
    print_titled(title, *tables)
