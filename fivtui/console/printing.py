"""Console output: tables to stdout, progress to stderr."""

import sys
import time
from collections.abc import Collection, Sequence
from html import escape
from types import TracebackType
from typing import Final, Self

from rich.cells import cell_len
from rich.console import Console, JustifyMethod, RenderableType
from rich.padding import Padding
from rich.progress import BarColumn, Progress as Bar, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from fivtui.model import Parameters

from .layout import GAP, READABLE_WIDTH, TableColumn, split_columns

# A progress bar appears after this time, so that short computations have none.
_DELAY_S: Final = 1.0
# Interval between two updates in a notebook.
_NOTEBOOK_INTERVAL_S: Final = 0.2
# Width of output that goes to a program, characters: lines are not wrapped.
_UNLIMITED_WIDTH: Final = 1_000_000


class ProgressBar:
    """A progress bar, on standard error or in a notebook, that appears after a second.

    Give it to a function as `progress`. The bar disappears at the end of the computation, and at
    the latest at the end of a ``with`` block.

    Parameters
    ----------
    label : str
        Name of the computation.
    remaining : bool
        Whether to show the time left.

    Examples
    --------
    >>> from fivtui import ProgressBar, sweep
    >>> table = sweep(vary={"F": [20.0, 80.0]}, t_end=20.0, progress=ProgressBar("F = 20, 80 N"))
    """

    def __init__(self, label: str, *, remaining: bool = True) -> None:
        self._label, self._remaining = label, remaining
        self._bar: _TerminalBar | _NotebookBar | None = None
        self._begin = time.monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._stop()

    def __call__(self, fraction: float) -> bool:
        """Show the fraction done, 0 to 1; returns True, so that the computation continues."""
        self.show(fraction, self._label)
        return True

    def show(self, fraction: float, label: str) -> None:
        """Show the fraction done beside a label."""
        if self._bar is None:
            if time.monotonic() - self._begin < _DELAY_S or fraction >= 1.0:
                return
            make_bar = _NotebookBar if _in_notebook() else _TerminalBar
            self._bar = make_bar(label, remaining=self._remaining)
        self._bar.show(fraction, label)
        if fraction >= 1.0:
            self._stop()

    def _stop(self) -> None:
        if self._bar is not None:
            self._bar.stop()
            self._bar = None


class _TerminalBar:
    # Drawn by rich; nothing is drawn if standard error is no terminal.

    def __init__(self, label: str, *, remaining: bool) -> None:
        console = Console(stderr=True)
        columns = [TextColumn("{task.description}", markup=False), BarColumn()]
        time_left = [TimeRemainingColumn()] if remaining else []
        self._bar = Bar(
            *columns,
            *time_left,
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        self._bar.start()
        self._bar.add_task(label, total=1.0)

    def show(self, fraction: float, label: str) -> None:
        self._bar.update(self._bar.task_ids[0], completed=fraction, description=label)

    def stop(self) -> None:
        self._bar.stop()


class _NotebookBar:
    # An output of the running cell, which is replaced at every update.

    def __init__(self, label: str, *, remaining: bool) -> None:  # noqa: ARG002
        from IPython.display import HTML, DisplayHandle

        self._html, self._handle = HTML, DisplayHandle()
        self._remaining = remaining
        self._begin = self._last_update = time.monotonic()
        self._handle.display(HTML(""))

    def show(self, fraction: float, label: str) -> None:
        current_time = time.monotonic()
        if current_time - self._last_update < _NOTEBOOK_INTERVAL_S:
            return
        self._last_update = current_time
        text = f"{label}: {fraction:.0%}"
        if self._remaining and fraction > 0.0:
            text += f", {(current_time - self._begin) * (1.0 - fraction) / fraction:.0f} s left"
        self._handle.update(
            self._html(f'<progress value="{fraction:.4f}" max="1"></progress> {escape(text)}')
        )

    def stop(self) -> None:
        self._handle.update(self._html(""))


def _in_notebook() -> bool:
    # Whether the code runs in the kernel of a notebook, not in IPython's terminal.
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return getattr(shell, "kernel", None) is not None


def print_list(title: str, rows: Sequence[Sequence[str]]) -> None:
    """Print rows of a name and texts, on a narrow terminal with the texts below the name."""
    width = terminal_width()
    lines = [(name, "  ".join(filter(None, parts))) for name, *parts in rows]
    name_width = max((cell_len(name) for name, _ in lines), default=0)
    text_width = max((cell_len(text) for _, text in lines), default=0)
    # Beside a name, long texts are wrapped if a readable width is left for them.
    needed_width = name_width + GAP + min(text_width, READABLE_WIDTH)
    side_by_side = width is None or needed_width <= width
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
    # rich pads lines with blanks to the width of a table or of the console: programs get none.
    for line in captured.get().splitlines():
        sys.stdout.write(f"{line if width else line.rstrip()}\n")


def terminal_width() -> int | None:
    """Width of the terminal that stdout is; None if it is no terminal."""
    return Console(file=sys.stdout).width if sys.stdout.isatty() else None


def number(value: float, digits: int = 6) -> str:
    """A number with a few significant digits."""
    return f"{value:.{digits}g}"


def parameter_line(p: Parameters, without: Collection[str] = ()) -> str:
    """A parameter set in one line, except those `without`."""
    values = {name: value for name, value in p.as_dict().items() if name not in without}
    return "  ".join(f"{name}={number(value)}" for name, value in values.items())


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
    # A block has columns that fit side by side, with their widths; the first are always the keys.
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
