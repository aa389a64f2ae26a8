"""Read measured data from text files with columns, whatever program wrote them."""

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
from fivtui.model import Column, InputError, read_number, unknown_name_error
from fivtui.results import Result, Table, Tabular

FloatArray = NDArray[np.float64]

_MAX_BYTES: Final = 1 << 28
_SEPARATORS: Final = (";", "\t", ",")
_MIN_COLUMNS: Final = 2
# Column names are compared by their leading letters: "y (mm)" and "y_mm" are y.
_LEADING_LETTERS: Final = re.compile("[a-z]*", re.IGNORECASE)
_TIME_NAMES: Final = ("t", "time")


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
        The signal, in the unit of the quantity that it is compared with.
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
    decimal comma. Lines above the first row of numbers are skipped. If the last of them has as many
    cells as that row, they are the column names. Lines that begin with ``#`` are comments.

    Parameters
    ----------
    path : Path or str
        The file.
    time, signal : str
        The columns, by name or by number from 1. By default, times are in the column ``t`` or
        ``time``, and the signal is in the column named like `quantity`; names may have a unit, as
        ``y (mm)`` or ``y_mm``. Without such names, the first column has the times, and the first of
        the others the signal.
    quantity : str
        The quantity that the signal is compared with, e.g. ``y``.
    scale, offset : float
        The signal is `scale` times the value in the file, plus `offset`.
    time_scale : float
        Factor that converts the time column to s, e.g. 0.001 for ms.

    Returns
    -------
    Measurement
        The signal.

    Raises
    ------
    InputError
        If the file cannot be read, a column is unknown, a cell is not a number, or times do not
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
    text = _read_text(path)
    try:
        names, rows = _parse_table(text)
        time_column = _find_column("time", time, names, usual_names=_TIME_NAMES, default=0)
        first_of_others = 1 if time_column == 0 else 0
        signal_column = _find_column(
            "signal", signal, names, usual_names=(quantity,), default=first_of_others
        )
        t = _column_values(rows, time_column, names[time_column])
        values = _column_values(rows, signal_column, names[signal_column])
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    if np.any(np.diff(t) <= 0.0):
        raise InputError(f"{path}: {names[time_column]}: must be ascending times")
    return Measurement(
        str(path), names[time_column], names[signal_column], time_scale * t, scale * values + offset
    )


def has_column_name(column: str, names: Sequence[str]) -> bool:
    """Whether a column has one of the names, with or without a unit, in any case of letters."""
    letters = _LEADING_LETTERS.match(column)
    return letters is not None and letters[0].lower() in {name.lower() for name in names if name}


# The number of a line, and its cells.
_Row = tuple[int, list[str]]


def _read_text(path: Path) -> str:
    content = read_bytes(path, limit=_MAX_BYTES)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        # Some instruments write Latin-1, in which every byte is a character.
        return content.decode("latin-1")


def _parse_table(text: str) -> tuple[list[str], list[_Row]]:
    # The column names and the rows, split by the first separator that gives columns of numbers.
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.startswith("#")
    ]
    for separator in _SEPARATORS:
        rows = [(number, _cells(line, separator)) for number, line in lines]
        first_index = next((index for index, (_, row) in enumerate(rows) if _is_numeric(row)), None)
        if first_index is None:
            continue
        width = len(rows[first_index][1])
        titles = rows[first_index - 1][1] if first_index > 0 else []
        has_titles = len(titles) == width
        numbered_titles = [f"column {number}" for number in range(1, width + 1)]
        for number, row in rows[first_index:]:
            if len(row) != width:
                raise InputError(f"line {number}: {len(row)} values under {width} columns")
        return (titles if has_titles else numbered_titles), rows[first_index:]
    raise InputError(
        "must have at least two columns of numbers, separated by commas, semicolons or tabs"
    )


def _cells(line: str, separator: str) -> list[str]:
    (cells,) = csv.reader(io.StringIO(line), delimiter=separator)
    cells = [cell.strip() for cell in cells]
    return cells if separator == "," else [cell.replace(",", ".") for cell in cells]


def _is_numeric(row: list[str]) -> bool:
    return len(row) >= _MIN_COLUMNS and all(_is_number(cell) for cell in row[:_MIN_COLUMNS])


def _is_number(cell: str) -> bool:
    try:
        read_number(cell)
    except ValueError:
        return False
    return True


def _find_column(
    role: str, chosen: str, names: list[str], *, usual_names: Sequence[str], default: int
) -> int:
    # Index of the column `chosen` by name or number; if empty, of the first with a usual name.
    if not chosen:
        matches = (index for index, name in enumerate(names) if has_column_name(name, usual_names))
        return next(matches, default)
    if chosen in names:
        return names.index(chosen)
    if chosen.isascii() and chosen.isdigit() and 1 <= int(chosen) <= len(names):
        return int(chosen) - 1
    raise unknown_name_error(f"{role} column", chosen, names)


def _column_values(rows: list[_Row], column: int, name: str) -> FloatArray:
    values = np.empty(len(rows))
    for index, (number, row) in enumerate(rows):
        try:
            values[index] = read_number(row[column])
        except ValueError:
            title = name or f"column {column + 1}"
            raise InputError(f"line {number}: {title} = {row[column]!r} is not a number") from None
    return values
