"""How the command line prints: tables on standard output, progress on standard error."""

import sys
import time
from collections.abc import Sequence
from types import TracebackType
from typing import Final, Self

from rich.console import Console
from rich.progress import BarColumn, TaskID, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar
from rich.table import Table

from .core.parameters import Parameters

# A bar for less than this would only flicker.
_PATIENCE_S: Final = 1.0


class Progress:
    """A progress bar on standard error that appears only when a computation takes over a second.

    Parameters
    ----------
    label : str
        What is being done.
    """

    def __init__(self, label: str) -> None:
        self._label = label
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
            columns = (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
            self._bar = Bar(
                *columns, console=console, transient=True, disable=not console.is_terminal
            )
            self._bar.start()
            self._task = self._bar.add_task(self._label, total=1.0)
        if self._task is not None:
            self._bar.update(self._task, completed=fraction, description=self._description())
        return True

    def _description(self) -> str:
        # Batches wait for the compiler where single runs do not.
        from .core.batch import kernels

        return f"{self._label}: compiling, once" if kernels.loading else self._label


def number(value: float, digits: int = 6) -> str:
    """A number for reading: a few significant digits."""
    return f"{value:.{digits}g}"


def print_table(table: Table) -> None:
    """Print a table on standard output."""
    # Without a terminal nothing is wrapped or cut: the reader is a program.
    console = Console(file=sys.stdout, width=None if sys.stdout.isatty() else 200, highlight=False)
    console.print(table)


def print_list(title: str, rows: Sequence[tuple[str, str]]) -> None:
    """Print names and what they stand for.

    Parameters
    ----------
    title : str
        Title of the list.
    rows : sequence of tuple of str
        Name and text of each.
    """
    table = Table(title=title, title_justify="left", show_header=False, box=None, pad_edge=False)
    table.add_column(no_wrap=True)
    table.add_column()
    for name, value in rows:
        table.add_row(name, value)
    print_table(table)


def parameter_line(p: Parameters) -> str:
    """A parameter set in one line."""
    return "  ".join(f"{name}={number(value)}" for name, value in p.as_dict().items())


def print_rows(title: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table.

    Parameters
    ----------
    title : str
        Its title.
    header : sequence of str
        Column names.
    rows : sequence of sequence of str
        As many texts each; the first column is left-aligned, the others right-aligned.
    """
    table = Table(title=title, title_justify="left", box=None, pad_edge=False)
    for index, name in enumerate(header):
        table.add_column(name, justify="left" if index == 0 else "right", no_wrap=index > 0)
    for row in rows:
        table.add_row(*row)
    print_table(table)
