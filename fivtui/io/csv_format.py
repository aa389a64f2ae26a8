"""Tables as CSV: comment lines of JSON, names, rows; floats without loss of precision."""

import csv
import io
import json
import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Column, InputError, read_number

# Rows written or converted at a time.
_BLOCK: Final = 8192
_MISSING: Final[Mapping[str, float]] = {"": math.nan, "true": 1.0, "false": 0.0}
UNITS: Final = "units"


def write(
    file: BinaryIO,
    columns: Sequence[Column],
    values: Mapping[str, NDArray[Any]],
    header: Mapping[str, Any],
) -> None:
    """Write a table of numbers, its header and the units of its columns."""
    units = {column.name: column.unit for column in columns}
    write_csv_numbers(file, {name: values[name] for name in units}, {**header, UNITS: units})


def write_csv_numbers(
    file: BinaryIO, values: Mapping[str, NDArray[Any]], header: Mapping[str, Any]
) -> None:
    """Write columns of numbers under a header."""
    write_csv_head(file, values, header)
    size = max((column.shape[0] for column in values.values()), default=0)
    for start in range(0, size, _BLOCK):
        # The representation of a Python float is the shortest that reads back as the same number.
        parts = (column[start : start + _BLOCK].tolist() for column in values.values())
        write_csv_rows(file, (map(repr, part) for part in parts))


def write_csv_head(file: BinaryIO, names: Iterable[str], header: Mapping[str, Any]) -> None:
    """Write the lines above the rows: ``# key: JSON`` comments, and the names of columns."""
    lines = [f"# {key}: {json.dumps(value)}" for key, value in header.items()]
    file.write("\n".join([*lines, ",".join(names), ""]).encode())


def write_csv_rows(file: BinaryIO, columns: Iterable[Iterable[str]]) -> None:
    """Write rows, given by column as texts that are quoted where they need it."""
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


def read_csv(
    file: BinaryIO,
    wanted: Collection[str] | None = None,
    texts: Collection[str] = (),
    *,
    missing: bool = False,
) -> dict[str, NDArray[Any]]:
    """Read columns, see `tables.Format`; comments and empty lines may stand anywhere."""
    try:
        with io.TextIOWrapper(file, encoding="utf-8-sig", newline="") as text:
            return _columns(text, wanted, texts, _MISSING if missing else {})
    except UnicodeDecodeError:
        raise InputError("not a CSV file: not UTF-8 text") from None
    except csv.Error as error:
        raise InputError(f"not a CSV file: {error}") from None


def _columns(
    text: Iterable[str],
    wanted: Collection[str] | None,
    texts: Collection[str],
    words: Mapping[str, float],
) -> dict[str, NDArray[Any]]:
    rows = _numbered(text)
    _, first = next(rows, (0, []))
    names = [name.strip().strip('"') for name in first]
    places = {
        name: names.index(name) for name in (names if wanted is None else wanted) if name in names
    }
    parts: dict[str, list[NDArray[Any]]] = {name: [] for name in places}
    while block := _block(rows, len(names)):
        for name, place in places.items():
            cells = [row[place] for _, row in block]
            if name in texts:
                parts[name].append(np.array(cells, dtype=object))
                continue
            try:
                numbers = [words[c] if c in words else read_number(c) for c in cells]
            except ValueError:
                raise _not_a_number(block, name, place, words) from None
            parts[name].append(np.array(numbers, dtype=float))
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


def _block(rows: Iterator[tuple[int, list[str]]], width: int) -> list[tuple[int, list[str]]]:
    block = []
    for number, row in rows:
        if len(row) != width:
            raise InputError(f"line {number}: {len(row)} values under {width} columns")
        block.append((number, row))
        if len(block) == _BLOCK:
            break
    return block


def _not_a_number(
    block: Sequence[tuple[int, list[str]]], name: str, place: int, words: Mapping[str, float]
) -> InputError:
    for number, row in block:
        if row[place] not in words:
            try:
                read_number(row[place])
            except ValueError:
                return InputError(f"line {number}: {name} = {row[place]!r} is not a number")
    raise AssertionError(name)


def header(file: BinaryIO) -> dict[str, Any]:
    """Read the header alone, without units."""
    found = {}
    for line in file:
        comment = line.removeprefix(b"\xef\xbb\xbf")
        if not comment.startswith(b"#"):
            break
        key, colon, value = comment.removeprefix(b"#").partition(b":")
        if colon:
            try:
                found[key.strip().decode()] = json.loads(value)
            except (ValueError, RecursionError):
                raise InputError("not a CSV file that fivtui wrote, or damaged") from None
    found.pop(UNITS, None)
    return found
