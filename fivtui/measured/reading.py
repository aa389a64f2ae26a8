"""Measured data from text files of any program."""

import csv
import io
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.io import read_bytes
from fivtui.model import Column, InputError, read_number, unknown_name
from fivtui.results import Result, Table, Tabular

FloatArray = NDArray[np.float64]

_LARGEST: Final = 1 << 28
_SEPARATORS: Final = (";", "\t", ",")
_FEWEST: Final = 2
# Names of columns are compared by their first letters: "y (mm)" and "y_mm" are y.
_SYMBOL: Final = re.compile("[a-z]*", re.IGNORECASE)
_TIMES: Final = ("t", "time")


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Measurement(Result, Tabular):
    """A measured signal.

    Attributes
    ----------
    source : str
        The file.
    time, signal : str
        Names of the columns.
    t : ndarray, shape (n,)
        Ascending times, s.
    values : ndarray, shape (n,)
        The signal, in the unit of the quantity it is compared with.
    """

    source: str
    time: str
    signal: str
    t: FloatArray
    values: FloatArray

    def _summary(self) -> list[tuple[str, str]]:
        return [
            ("file", self.source),
            ("signal", f"{self.signal} over {self.time}, {self.t.size} samples"),
            ("time", f"{self.t[0]:.6g} to {self.t[-1]:.6g} s"),
            ("values", f"{self.values.min():.6g} to {self.values.max():.6g}"),
        ]

    def _table(self) -> Table:
        return {
            Column("t", "s", "time"): self.t,
            Column("values", "", f"{self.signal} over {self.time}"): self.values,
        }


def read_measurement(
    path: Path | str,
    *,
    time: str = "",
    signal: str = "",
    quantity: str = "",
    scale: float = 1.0,
    offset: float = 0.0,
    time_scale: float = 1.0,
) -> Measurement:
    r"""Read a measured signal from a text file with columns.

    Commas, semicolons or tabs separate the columns; with semicolons or tabs, numbers may have a
    decimal comma. Lines above the first row of numbers are skipped; the last of these lines names
    the columns if it has as many cells. Lines that begin with ``#`` are comments.

    Parameters
    ----------
    path : Path or str
        The file.
    time, signal : str
        The columns, by name or by number from 1. The defaults are the columns named ``t`` or
        ``time``, and `quantity`, also with a unit as in ``y (mm)`` or ``y_mm``. Without such names
        the times are in the first column, and the signal in the first of the rest.
    quantity : str
        The quantity that the signal is compared with, e.g. ``y``.
    scale, offset : float
        The signal is `scale` times the number in the file, plus `offset`.
    time_scale : float
        Seconds in a unit of the time column, e.g. 0.001 for ms.

    Returns
    -------
    Measurement
        The signal.

    Raises
    ------
    InputError
        If the file cannot be read, a column is unknown, a cell is no number, or times do not
        ascend.

    Examples
    --------
    >>> from pathlib import Path
    >>> from fivtui import read_measurement
    >>> _ = Path("test.csv").write_text("t_ms;disp_mm\n0;1,5\n10;2,5\n")
    >>> read_measurement("test.csv", signal="disp_mm", scale=1e-3, time_scale=1e-3).values
    array([0.0015, 0.0025])
    """
    path = Path(path)
    for name, value in (("scale", scale), ("offset", offset), ("time_scale", time_scale)):
        if not math.isfinite(value) or (name != "offset" and value == 0.0):
            raise InputError(f"{name} = {value:g}: must be a number other than 0")
    if time_scale < 0.0:
        raise InputError(f"time_scale = {time_scale:g}: must be above 0")
    text = _text(path)
    try:
        names, rows = _table(text)
        time_column = _column(time, names, "time", _TIMES, 0)
        first = 1 if time_column == 0 else 0
        signal_column = _column(signal, names, "signal", (quantity,), first)
        t = _numbers(rows, time_column, names[time_column])
        values = _numbers(rows, signal_column, names[signal_column])
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    if np.any(np.diff(t) <= 0.0):
        raise InputError(f"{path}: {names[time_column]}: must be ascending times")
    return Measurement(
        str(path), names[time_column], names[signal_column], time_scale * t, scale * values + offset
    )


def bears_name(column: str, names: Sequence[str]) -> bool:
    """Whether a column has one of some names, perhaps with a unit; case does not matter."""
    symbol = _SYMBOL.match(column)
    return symbol is not None and symbol[0].lower() in {name.lower() for name in names if name}


_Row = tuple[int, list[str]]


def _text(path: Path) -> str:
    content = read_bytes(path, limit=_LARGEST)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        # Latin-1, as instruments in Western Europe write it: every byte is a character.
        return content.decode("latin-1")


def _table(text: str) -> tuple[list[str], list[_Row]]:
    # Names of the columns, and the rows of cells with their line numbers.
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.startswith("#")
    ]
    for separator in _SEPARATORS:
        rows = [(number, _cells(line, separator)) for number, line in lines]
        first = next((number for number, (_, row) in enumerate(rows) if _is_numeric(row)), None)
        if first is None:
            continue
        width = len(rows[first][1])
        above = rows[first - 1][1] if first > 0 else []
        named = len(above) == width
        numbered = [f"column {number}" for number in range(1, width + 1)]
        for number, row in rows[first:]:
            if len(row) != width:
                raise InputError(f"line {number}: {len(row)} values under {width} columns")
        return (above if named else numbered), rows[first:]
    raise InputError(
        "must have at least two columns of numbers, parted by commas, semicolons or tabs"
    )


def _cells(line: str, separator: str) -> list[str]:
    (cells,) = csv.reader(io.StringIO(line), delimiter=separator)
    cells = [cell.strip() for cell in cells]
    return cells if separator == "," else [cell.replace(",", ".") for cell in cells]


def _is_numeric(row: list[str]) -> bool:
    return len(row) >= _FEWEST and all(_is_number(cell) for cell in row[:_FEWEST])


def _is_number(cell: str) -> bool:
    try:
        read_number(cell)
    except ValueError:
        return False
    return True


def _column(chosen: str, names: list[str], kind: str, usual: Sequence[str], first: int) -> int:
    # Index of the chosen column, or else of a column with a usual name, or else of the first.
    if not chosen:
        matches = (index for index, name in enumerate(names) if bears_name(name, usual))
        return next(matches, first)
    if chosen in names:
        return names.index(chosen)
    if chosen.isascii() and chosen.isdigit() and 1 <= int(chosen) <= len(names):
        return int(chosen) - 1
    raise unknown_name(f"{kind} column", chosen, names)


def _numbers(rows: list[_Row], column: int, name: str) -> FloatArray:
    values = np.empty(len(rows))
    for index, (number, row) in enumerate(rows):
        try:
            values[index] = read_number(row[column])
        except ValueError:
            raise InputError(f"line {number}: {name} = {row[column]!r} is not a number") from None
    return values
