"""The file formats of columns with units and provenance, as data: CSV, NPZ and Parquet."""

import csv
import io
import json
import zipfile
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import COLUMNS, Column, InputError, read_number

from .files import check_output, check_suffix

Columns = dict[str, NDArray[Any]]
Provenance = Mapping[str, Any]

_NAMES: Final = tuple(column.name for column in COLUMNS)
_CHUNK: Final = 8192


@dataclass(frozen=True, slots=True)
class Format:
    """A file format.

    Attributes
    ----------
    write : callable
        Writes columns, their values, equally many, and what the file says of its making to a
        binary file.
    read : callable
        Reads those columns of a trajectory that a binary file has; InputError if it is of another
        format.
    package : str
        Package that it needs besides those that fivtui always needs; empty if none.
    extra : str
        The extra of fivtui that installs the package.
    """

    write: Callable[[BinaryIO, Sequence[Column], Columns, Provenance], None]
    read: Callable[[BinaryIO], Columns]
    package: str = ""
    extra: str = ""

    def check_installed(self) -> None:
        """Check that the package that the format needs is installed.

        Raises
        ------
        InputError
            If it is not; the message says how to install it.
        """
        if self.package and find_spec(self.package) is None:
            raise InputError(f"this format needs {self.package}: install fivtui[{self.extra}]")


def write_csv(
    file: BinaryIO, columns: Mapping[str, NDArray[Any]], header: Mapping[str, Any]
) -> None:
    """Write columns as CSV, without loss of precision.

    Parameters
    ----------
    file : binary file
        Where to write.
    columns : mapping of str to ndarray, shape (n,)
        Values by name.
    header : mapping
        What the comment lines (``# key: JSON``) before the names of the columns say.
    """
    lines = [f"# {key}: {json.dumps(value)}" for key, value in header.items()]
    file.write("\n".join([*lines, ",".join(columns), ""]).encode())
    size = max((column.size for column in columns.values()), default=0)
    for start in range(0, size, _CHUNK):
        # The representation of a Python float is the shortest that reads back as the same number.
        parts = (column[start : start + _CHUNK].tolist() for column in columns.values())
        rows = zip(*parts, strict=True)
        file.write("".join(",".join(map(repr, row)) + "\n" for row in rows).encode())


def _write_csv(
    file: BinaryIO, columns: Sequence[Column], values: Columns, provenance: Provenance
) -> None:
    write_csv(file, _ordered(columns, values), {**provenance, "units": _units(columns)})


def _ordered(columns: Sequence[Column], values: Columns) -> Columns:
    return {column.name: values[column.name] for column in columns}


def _units(columns: Sequence[Column]) -> dict[str, str]:
    return {column.name: column.unit for column in columns}


def _read_csv(file: BinaryIO) -> Columns:
    try:
        with io.TextIOWrapper(file, encoding="utf-8-sig", newline="") as text:
            return _parse_csv(text)
    except UnicodeDecodeError:
        raise InputError("not a CSV file: not UTF-8 text") from None
    except csv.Error as error:
        raise InputError(f"not a CSV file: {error}") from None


def _parse_csv(text: io.TextIOWrapper) -> Columns:
    reader = csv.reader(text)
    rows = (row for row in reader if row and not row[0].startswith("#"))
    names = [name.strip() for name in next(rows, [])]
    places = {name: names.index(name) for name in _NAMES if name in names}
    values: dict[str, list[float]] = {name: [] for name in places}
    for row in rows:
        if len(row) != len(names):
            raise InputError(
                f"line {reader.line_num}: {len(row)} values under {len(names)} columns"
            )
        for name, place in places.items():
            try:
                values[name].append(read_number(row[place]))
            except ValueError:
                message = f"line {reader.line_num}: {name} = {row[place]!r} is not a number"
                raise InputError(message) from None
    return {name: np.array(column, dtype=float) for name, column in values.items()}


def _write_npz(
    file: BinaryIO, columns: Sequence[Column], values: Columns, provenance: Provenance
) -> None:
    arrays: dict[str, Any] = dict(_ordered(columns, values))
    for key, value in {**provenance, "units": _units(columns)}.items():
        arrays[key] = _array(value)
    np.savez(file, **arrays)


def _array(value: Any) -> NDArray[Any]:
    # A mapping becomes a record, so that no array holds Python objects.
    if not isinstance(value, Mapping):
        return np.array(value)
    entries = {key: np.array(entry) for key, entry in value.items()}
    return np.array(
        tuple(value.values()), dtype=[(key, entry.dtype) for key, entry in entries.items()]
    )


def _read_npz(file: BinaryIO) -> Columns:
    try:
        archive = np.load(file, allow_pickle=False)
        if isinstance(archive, np.lib.npyio.NpzFile):
            return {name: archive[name] for name in _NAMES if name in archive}
    except (ValueError, EOFError, RuntimeError, zipfile.BadZipFile, zlib.error):
        raise InputError("not an NPZ file, or damaged") from None
    raise InputError("not an NPZ file")


def _write_parquet(
    file: BinaryIO, columns: Sequence[Column], values: Columns, provenance: Provenance
) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    arrays = [pa.array(values[column.name]) for column in columns]
    fields = [
        pa.field(
            column.name,
            array.type,
            nullable=False,
            metadata={"unit": column.unit, "meaning": column.meaning},
        )
        for column, array in zip(columns, arrays, strict=True)
    ]
    metadata = {key: json.dumps(value) for key, value in provenance.items()}
    pq.write_table(pa.table(arrays, schema=pa.schema(fields, metadata=metadata)), file)


def _read_parquet(file: BinaryIO) -> Columns:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(file, columns=list(_NAMES))
    except pa.ArrowException:
        raise InputError("not a Parquet file, or damaged") from None
    return {name: table[name].to_numpy() for name in table.column_names}


FORMATS: Final[Mapping[str, Format]] = {
    ".csv": Format(_write_csv, _read_csv),
    ".npz": Format(_write_npz, _read_npz),
    ".parquet": Format(_write_parquet, _read_parquet, package="pyarrow", extra="parquet"),
}


def check_columns_path(path: Path, kind: str, *, force: bool) -> None:
    """Check that columns can be written to a file, before they are computed.

    Parameters
    ----------
    path : Path
        The file; its suffix says the format.
    kind : str
        What it holds, named in the message, e.g. ``"map"``.
    force : bool
        Whether a file that exists may be replaced.

    Raises
    ------
    InputError
        If the format is unknown or needs a package that is not installed, or as `check_output`.
    """
    columns_format(path, kind)
    check_output(path, force=force)


def columns_format(path: Path, kind: str) -> Format:
    """The format that the name of a file says.

    Parameters
    ----------
    path : Path
        The file.
    kind : str
        What it holds, named in the message, e.g. ``"trajectory"``.

    Returns
    -------
    Format
        Its format.

    Raises
    ------
    InputError
        If the suffix is unknown, or a package that the format needs is not installed.
    """
    form = FORMATS[check_suffix(path, kind, FORMATS)]
    try:
        form.check_installed()
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return form
