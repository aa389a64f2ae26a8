"""The file formats of trajectories, as data: CSV, NPZ and Parquet."""

import csv
import io
import json
import zipfile
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from .core.errors import InputError
from .core.trajectory import COLUMNS, Trajectory

Columns = dict[str, NDArray[Any]]
Provenance = Mapping[str, Any]

_NAMES: Final = tuple(column.name for column in COLUMNS)
_UNITS: Final = {column.name: column.unit for column in COLUMNS}
_CHUNK: Final = 8192


@dataclass(frozen=True, slots=True)
class Format:
    """A file format.

    Attributes
    ----------
    write : callable
        Writes a trajectory and its provenance to a binary file.
    read : callable
        Reads those columns of `COLUMNS` that a binary file has; InputError if it is of another
        format.
    package : str
        Package that it needs besides those that fivtui always needs; empty if none.
    extra : str
        The extra of fivtui that installs the package.
    """

    write: Callable[[BinaryIO, Trajectory, Provenance], None]
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


def _write_csv(file: BinaryIO, trajectory: Trajectory, provenance: Provenance) -> None:
    header = {**provenance, "units": _UNITS}
    lines = [f"# {key}: {json.dumps(value)}" for key, value in header.items()]
    file.write("\n".join([*lines, ",".join(_NAMES), ""]).encode())
    columns = [getattr(trajectory, name) for name in _NAMES]
    for start in range(0, trajectory.t.size, _CHUNK):
        # The representation of a Python float is the shortest that reads back as the same number.
        rows = zip(*(column[start : start + _CHUNK].tolist() for column in columns), strict=True)
        file.write("".join(",".join(map(repr, row)) + "\n" for row in rows).encode())


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
                values[name].append(float(row[place]))
            except ValueError:
                message = f"line {reader.line_num}: {name} = {row[place]!r} is not a number"
                raise InputError(message) from None
    return {name: np.array(column, dtype=float) for name, column in values.items()}


def _write_npz(file: BinaryIO, trajectory: Trajectory, provenance: Provenance) -> None:
    arrays: dict[str, Any] = {name: getattr(trajectory, name) for name in _NAMES}
    for key, value in {**provenance, "units": _UNITS}.items():
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


def _write_parquet(file: BinaryIO, trajectory: Trajectory, provenance: Provenance) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    arrays = [pa.array(getattr(trajectory, column.name)) for column in COLUMNS]
    fields = [
        pa.field(
            column.name,
            array.type,
            nullable=False,
            metadata={"unit": column.unit, "meaning": column.meaning},
        )
        for column, array in zip(COLUMNS, arrays, strict=True)
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
