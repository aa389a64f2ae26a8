"""Tables as CSV: comment lines of JSON, names, rows; floats without loss of precision."""

import csv
import io
import json
import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Column, InputError, read_number

from .files import check_suffix
from .reading import opened
from .writing import write_atomically

# Rows written or converted at a time.
_BLOCK: Final = 8192
_MISSING: Final[Mapping[str, float]] = {"": math.nan, "true": 1.0, "false": 0.0}
UNITS: Final = "units"
package = extra = ""


def write(
    file: BinaryIO,
    columns: Sequence[Column],
    values: Mapping[str, NDArray[Any]],
    header: Mapping[str, Any],
) -> None:
    """Write a table of numbers, its header and the units of its columns."""
    units = {column.name: column.unit for column in columns}
    _write(file, {name: values[name] for name in units}, {**header, UNITS: units})


def save_csv(
    path: Path,
    kind: str,
    values: Mapping[str, NDArray[Any] | Sequence[object]],
    header: Mapping[str, Any],
) -> None:
    """Write columns of numbers or texts to a CSV file; `kind` names the file in messages."""
    check_suffix(path, kind, (".csv",))
    write_atomically(path, lambda file: _write(file, values, header))


def _write(
    file: BinaryIO,
    values: Mapping[str, NDArray[Any] | Sequence[object]],
    header: Mapping[str, Any],
) -> None:
    write_csv_head(file, values, header)
    size = max(map(len, values.values()), default=0)
    for start in range(0, size, _BLOCK):
        write_csv_rows(file, (_texts(c[start : start + _BLOCK]) for c in values.values()))


def _texts(values: NDArray[Any] | Sequence[object]) -> Iterable[str]:
    # The repr of a float is the shortest text that reads back as the same number.
    if isinstance(values, np.ndarray):
        return map(repr, values.tolist())
    return map(csv_cell, values)


def write_csv_head(file: BinaryIO, names: Iterable[str], header: Mapping[str, Any]) -> None:
    """Write the lines above the rows: ``# key: JSON`` comments, and the names of columns."""
    lines = [f"# {key}: {json.dumps(value)}" for key, value in header.items()]
    file.write("\n".join([*lines, ",".join(names), ""]).encode())


def write_csv_rows(file: BinaryIO, columns: Iterable[Iterable[str]]) -> None:
    """Write rows from columns of texts, quoted where necessary."""
    rows = zip(*columns, strict=True)
    file.write("".join(",".join(row) + "\n" for row in rows).encode())


def csv_cell(value: object) -> str:
    """The text of a value; empty for None."""
    if value is None:
        return ""
    text = str(value)
    return csv_quoted(text) if any(sign in text for sign in ',"\r\n') else text


def csv_quoted(text: str) -> str:
    """A text in quotation marks."""
    return f'"{text.replace(chr(34), chr(34) * 2)}"'


def read_csv(path: Path) -> dict[str, NDArray[Any]]:
    """All columns of a file, numbers; `InputError` if it cannot be read."""
    with opened(path) as file:
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
    """Read columns, see `tables.Format`; comments and empty lines may stand anywhere."""
    try:
        with io.TextIOWrapper(file, encoding="utf-8-sig", newline="") as text:
            return _columns(text, selected, texts, _MISSING if missing else {})
    except UnicodeDecodeError:
        raise InputError("not a CSV file: not UTF-8 text") from None
    except csv.Error as error:
        raise InputError(f"not a CSV file: {error}") from None


def _columns(
    text: Iterable[str],
    selected: Collection[str] | None,
    texts: Collection[str],
    symbols: Mapping[str, float],
) -> dict[str, NDArray[Any]]:
    rows = _numbered(text)
    _, first = next(rows, (0, []))
    names = [name.strip().strip('"') for name in first]
    indices = {
        name: names.index(name)
        for name in (names if selected is None else selected)
        if name in names
    }
    parts: dict[str, list[NDArray[Any]]] = {name: [] for name in indices}
    while block := list(islice(rows, _BLOCK)):
        for number, row in block:
            if len(row) != len(names):
                raise InputError(f"line {number}: {len(row)} values under {len(names)} columns")
        for name, index in indices.items():
            if name in texts:
                part = np.array([row[index] for _, row in block], dtype=object)
            else:
                part = np.array([_number(row[index], n, name, symbols) for n, row in block])
            parts[name].append(part)
    return {name: np.concatenate(part) if part else np.empty(0) for name, part in parts.items()}


def _numbered(text: Iterable[str]) -> Iterator[tuple[int, list[str]]]:
    # Rows that are neither empty nor comments, with the number of their last line.
    number = 0

    def lines() -> Iterator[str]:
        nonlocal number
        for number, line in enumerate(text, start=1):  # noqa: B007
            if not line.startswith("#"):
                yield line

    for row in csv.reader(lines()):
        if row:
            yield number, row


def _number(cell: str, line: int, name: str, symbols: Mapping[str, float]) -> float:
    if cell in symbols:
        return symbols[cell]
    try:
        return read_number(cell)
    except ValueError:
        raise InputError(f"line {line}: {name} = {cell!r} is not a number") from None


def header(file: BinaryIO) -> dict[str, Any]:
    """Read the header alone, without units."""
    entries = {}
    for line in file:
        comment = line.removeprefix(b"\xef\xbb\xbf")
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
