"""Tables as CSV: comment lines with a header in JSON, column names, rows.

Floats are written so that they read back as the same numbers.
"""

import csv
import io
import json
import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import chain, islice
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Column, InputError, read_number

from .files import check_suffix
from .reading import open_regular
from .writing import write_atomically

# Rows that are converted at a time, which limits memory.
_BLOCK_ROWS: Final = 8192
# Byte order mark that some programs write before UTF-8 text.
_BYTE_ORDER_MARK: Final = b"\xef\xbb\xbf"
# Numbers for cells that are empty or truth values.
_SPECIAL_VALUES: Final[Mapping[str, float]] = {"": math.nan, "true": 1.0, "false": 0.0}
# Separators of cells besides the comma, in files of other programs.
_OTHER_SEPARATORS: Final = (";", "\t")
# Key of the header under which the units of columns are stored.
UNITS: Final = "units"
# The package that a `tables.Format` needs, and the extra of fivtui that installs it: none.
package = extra = ""


def write(
    file: BinaryIO,
    columns: Sequence[Column],
    values: Mapping[str, NDArray[Any]],
    header: Mapping[str, Any],
) -> None:
    """Write a table of numbers, its header and the units of its columns."""
    units = {column.name: column.unit for column in columns}
    _write_columns(file, {name: values[name] for name in units}, {**header, UNITS: units})


def save_csv(
    path: Path,
    kind: str,
    values: Mapping[str, NDArray[Any] | Sequence[object]],
    header: Mapping[str, Any],
) -> None:
    """Write columns of numbers or texts to a CSV file; messages call it a `kind` file."""
    check_suffix(path, kind, (".csv",))
    write_atomically(path, lambda file: _write_columns(file, values, header))


def _write_columns(
    file: BinaryIO, values: Mapping[str, NDArray[Any] | Sequence[object]], header: Mapping[str, Any]
) -> None:
    write_csv_header(file, values, header)
    size = max(map(len, values.values()), default=0)
    for start in range(0, size, _BLOCK_ROWS):
        end = start + _BLOCK_ROWS
        write_csv_rows(file, (_cell_texts(column[start:end]) for column in values.values()))


def _cell_texts(values: NDArray[Any] | Sequence[object]) -> Iterable[str]:
    # The repr of a float is the shortest text that reads back as the same number.
    if isinstance(values, np.ndarray):
        return map(repr, values.tolist())
    return map(csv_cell, values)


def write_csv_header(file: BinaryIO, names: Iterable[str], header: Mapping[str, Any]) -> None:
    """Write the lines above the rows: ``# key: JSON`` comments, and the column names."""
    lines = [f"# {key}: {json.dumps(value)}" for key, value in header.items()]
    file.write("\n".join([*lines, ",".join(names), ""]).encode())


def write_csv_rows(file: BinaryIO, columns: Iterable[Iterable[str]]) -> None:
    """Write rows from columns of cell texts, which are quoted already."""
    rows = zip(*columns, strict=True)
    file.write("".join(",".join(row) + "\n" for row in rows).encode())


def csv_cell(value: object) -> str:
    """The text of a value, quoted if necessary; empty for None."""
    if value is None:
        return ""
    text = str(value)
    return quote_csv(text) if any(sign in text for sign in ',"\r\n') else text


def quote_csv(text: str) -> str:
    """Put a text in quotation marks."""
    return f'"{text.replace(chr(34), chr(34) * 2)}"'


def read_csv(path: Path) -> dict[str, NDArray[Any]]:
    """Read all columns of a file as numbers; `InputError` if that fails."""
    with open_regular(path) as file:
        try:
            return read(file)
        except InputError as error:
            raise InputError(f"{path}: {error}") from None


def read(
    file: BinaryIO,
    selected: Collection[str] | None = None,
    texts: Collection[str] = (),
    *,
    missing: bool = False,
) -> dict[str, NDArray[Any]]:
    """Read columns, see `tables.Format`; comments and empty lines are skipped.

    With `missing`, cells in columns of numbers may be empty, true or false.
    """
    try:
        with io.TextIOWrapper(file, encoding="utf-8-sig", newline="") as text:
            return _read_columns(text, selected, texts, _SPECIAL_VALUES if missing else {})
    except UnicodeDecodeError:
        raise InputError("not a CSV file: not UTF-8 text") from None
    except csv.Error as error:
        raise InputError(f"not a CSV file: {error}") from None


def _read_columns(
    text: Iterable[str],
    selected: Collection[str] | None,
    texts: Collection[str],
    special: Mapping[str, float],
) -> dict[str, NDArray[Any]]:
    rows = _numbered_rows(text)
    _, name_row = next(rows, (0, []))
    # After a space the reader leaves quotation marks in a cell.
    names = [name.strip().strip('"') for name in name_row]
    for index, name in enumerate(names):
        if name in names[:index]:
            label = f"column {name}" if name else "a column without a name"
            raise InputError(f"{label} is given twice; must be given once")
    indices = {
        name: names.index(name)
        for name in (names if selected is None else selected)
        if name in names
    }
    blocks: dict[str, list[NDArray[Any]]] = {name: [] for name in indices}
    while block := list(islice(rows, _BLOCK_ROWS)):
        for number, row in block:
            if len(row) != len(names):
                raise InputError(f"line {number}: {len(row)} values under {len(names)} columns")
        for name, index in indices.items():
            if name in texts:
                column = np.array([row[index] for _, row in block], dtype=object)
            else:
                column = np.array(
                    [_parse_number(row[index], number, name, special) for number, row in block]
                )
            blocks[name].append(column)
    return {
        name: np.concatenate(arrays) if arrays else np.empty(0) for name, arrays in blocks.items()
    }


def _numbered_rows(text: Iterable[str]) -> Iterator[tuple[int, list[str]]]:
    # Rows of cells that are neither empty nor comments, each with the number of its last line. If
    # the names are separated by semicolons or tabs, numbers may have a decimal comma.
    number = 0

    def uncommented_lines() -> Iterator[str]:
        nonlocal number
        for number, line in enumerate(text, start=1):  # noqa: B007
            if not line.startswith("#"):
                yield line

    lines = uncommented_lines()
    names = next((line for line in lines if line.strip()), "")
    separator = next((separator for separator in _OTHER_SEPARATORS if separator in names), ",")
    for row in csv.reader(chain([names], lines), delimiter=separator):
        if row:
            yield number, row if separator == "," else [cell.replace(",", ".") for cell in row]


def _parse_number(cell: str, line: int, name: str, special: Mapping[str, float]) -> float:
    if cell in special:
        return special[cell]
    try:
        return read_number(cell)
    except ValueError:
        raise InputError(f"line {line}: {name} = {cell!r} is not a number") from None


def header(file: BinaryIO) -> dict[str, Any]:
    """Read the header without the units of columns."""
    entries = {}
    for line in file:
        comment = line.removeprefix(_BYTE_ORDER_MARK)
        if not comment.startswith(b"#"):
            break
        key, colon, value = comment.removeprefix(b"#").partition(b":")
        if colon:
            try:
                entries[key.strip().decode()] = json.loads(value)
            except (ValueError, RecursionError):
                raise InputError("not a CSV file that fivtui wrote, or damaged") from None
    entries.pop(UNITS, None)
    return entries
