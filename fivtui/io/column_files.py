"""Files of columns read whole: every column, and what the file says of its making."""

import codecs
import csv
import io
import json
import zipfile
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import InputError, read_number

from .formats import Columns, columns_format
from .reading import opened

Read = tuple[Columns, dict[str, Any]]
_UNITS: Final = "units"


def read_columns(path: Path, kind: str) -> Read:
    """Read a file of columns.

    Parameters
    ----------
    path : Path
        A ``.csv``, ``.npz`` or ``.parquet`` file that fivtui wrote.
    kind : str
        What it holds, named in messages, e.g. ``"map"``.

    Returns
    -------
    columns : dict of str to ndarray, shape (n,)
        Values by name, in the order of the file; of texts where one is no number.
    provenance : dict
        What the file says of its making; empty if it says nothing.

    Raises
    ------
    InputError
        If it cannot be read, or is of another format than its name says.
    """
    found: Read = _read(path, kind, _READERS)
    return found


def read_provenance(path: Path, kind: str) -> dict[str, Any]:
    """What a file of columns says of its making; the columns are not read.

    Parameters
    ----------
    path, kind
        As in `read_columns`.

    Returns
    -------
    dict
        Empty if it says nothing.

    Raises
    ------
    InputError
        As `read_columns`.
    """
    said: dict[str, Any] = _read(path, kind, _HEADER_READERS)
    return said


def _read(path: Path, kind: str, readers: Mapping[str, Callable[[BinaryIO], Any]]) -> Any:
    columns_format(path, kind)
    with opened(path) as file:
        try:
            return readers[path.suffix.lower()](file)
        except _DAMAGED:
            raise InputError(f"{path}: not a {kind} file, or damaged") from None


def _from_csv(file: BinaryIO) -> Read:
    said = _csv_header(file)
    file.seek(0)
    with io.TextIOWrapper(file, encoding="utf-8-sig", newline="") as text:
        names, *rows = csv.reader((line for line in text if not line.startswith("#")), strict=True)
    columns = zip(*rows, strict=True) if rows else ([] for _ in names)
    return dict(zip(names, map(_numbers, columns), strict=True)), said


def _csv_header(file: BinaryIO) -> dict[str, Any]:
    said = {}
    for line in file:
        if not line.removeprefix(codecs.BOM_UTF8).startswith(b"#"):
            break
        key, colon, value = line.removeprefix(codecs.BOM_UTF8).removeprefix(b"#").partition(b":")
        if colon:
            said[key.strip().decode()] = json.loads(value)
    return _without_units(said)


def _numbers(texts: Any) -> NDArray[Any]:
    try:
        return np.array([read_number(text) for text in texts], dtype=float)
    except ValueError:
        return np.array(texts, dtype=str)


def _from_npz(file: BinaryIO) -> Read:
    archive = _archive(file)
    return {name: archive[name] for name in archive[_UNITS].dtype.names or ()}, _npz_said(archive)


def _npz_header(file: BinaryIO) -> dict[str, Any]:
    return _npz_said(_archive(file))


def _archive(file: BinaryIO) -> "np.lib.npyio.NpzFile":
    archive = np.load(file, allow_pickle=False)
    if not isinstance(archive, np.lib.npyio.NpzFile):
        raise ValueError
    return archive


def _npz_said(archive: "np.lib.npyio.NpzFile") -> dict[str, Any]:
    names = archive[_UNITS].dtype.names or ()
    return _without_units({k: _plain(archive[k]) for k in archive.files if k not in names})


def _plain(array: NDArray[Any]) -> Any:
    # A record is a mapping.
    names = array.dtype.names
    return {name: array[name].tolist() for name in names} if names else array.tolist()


def _from_parquet(file: BinaryIO) -> Read:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(file)
    except pa.ArrowException:
        raise ValueError from None
    columns = {name: table[name].to_numpy() for name in table.column_names}
    return columns, _metadata(table.schema)


def _parquet_header(file: BinaryIO) -> dict[str, Any]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        return _metadata(pq.read_schema(file))
    except pa.ArrowException:
        raise ValueError from None


def _metadata(schema: Any) -> dict[str, Any]:
    known = (schema.metadata or {}).items()
    return {key.decode(): json.loads(value) for key, value in known if key != b"ARROW:schema"}


def _without_units(said: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in said.items() if key != _UNITS}


_DAMAGED: Final = (
    ValueError,
    RecursionError,
    KeyError,
    TypeError,
    EOFError,
    RuntimeError,
    csv.Error,
    zipfile.BadZipFile,
    zlib.error,
)
_READERS: Final[Mapping[str, Callable[[BinaryIO], Read]]] = {
    ".csv": _from_csv,
    ".npz": _from_npz,
    ".parquet": _from_parquet,
}
_HEADER_READERS: Final[Mapping[str, Callable[[BinaryIO], dict[str, Any]]]] = {
    ".csv": _csv_header,
    ".npz": _npz_header,
    ".parquet": _parquet_header,
}
