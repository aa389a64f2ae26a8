"""The file formats of sweeps, as data: how rows become pieces, and pieces one file."""

import csv
import json
import shutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np

from fivtui.io import check_suffix
from fivtui.model import InputError, read_number

from .rows import Rows
from .study import ColumnKind, Study, SweepColumn

# What a file says of its own making: JSON values by key.
Provenance = Mapping[str, Any]

_TRUTH: Final[Mapping[bool, str]] = {True: "true", False: "false"}
# Rows of a row group of a Parquet file: enough to be read fast, few enough to be held in memory.
_GROUP_ROWS: Final = 131_072
# Bytes read at a time to count rows.
_CHUNK: Final = 1 << 20
# Bytes of a Parquet file besides its columns and what says where they are.
_PARQUET_FRAME: Final = 12
_ARROW_TYPES: Final[Mapping[ColumnKind, str]] = {
    "number": "double",
    "count": "int64",
    "truth": "bool",
    "text": "string",
}


@dataclass(frozen=True, slots=True)
class SweepFormat:
    """A file format of a sweep's rows.

    Attributes
    ----------
    write_piece : callable
        Writes some rows of a study to a binary file.
    merge : callable
        Writes pieces, in order, and what the file says of its making to a binary file.
    provenance : callable
        What a file says of its making; None if it says nothing.
    count : callable
        How many whole rows of a study a file has; 0 if it is not laid out as one.
    read : callable
        The rows of a study in a file.
    package : str
        Package that it needs besides those that fivtui always needs; empty if none.
    """

    write_piece: Callable[[BinaryIO, Study, Rows], None]
    merge: Callable[[BinaryIO, Study, Iterable[Path], Provenance], None]
    provenance: Callable[[Path], dict[str, Any] | None]
    count: Callable[[Path, Study], int]
    read: Callable[[Path, Study], Rows]
    package: str = ""


def sweep_format(path: Path) -> SweepFormat:
    """The format that the name of a file says.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    SweepFormat
        Its format.

    Raises
    ------
    InputError
        If the suffix is not known, or a package is not installed.
    """
    form = SWEEP_FORMATS[check_suffix(path, "sweep", SWEEP_FORMATS)]
    if form.package and find_spec(form.package) is None:
        raise InputError(f"{path}: this format needs {form.package}: install fivtui[parquet]")
    return form


def _cell(value: object) -> str:
    if value is None:
        return ""
    # The representation of a float is the shortest that reads back as the same number.
    return _TRUTH[value] if isinstance(value, bool) else str(value)


def _write_csv_piece(file: BinaryIO, study: Study, rows: Rows) -> None:
    # Reasons alone can hold a comma or a quotation mark.
    cells = [
        [f'"{text.replace(chr(34), chr(34) * 2)}"' if text else "" for text in rows.reasons]
        if column.name == "reason"
        else list(map(_cell, rows.values(column)))
        for column in study.columns
    ]
    file.write("".join(",".join(row) + "\n" for row in zip(*cells, strict=True)).encode())


def _merge_csv(
    file: BinaryIO, study: Study, pieces: Iterable[Path], provenance: Provenance
) -> None:
    header = [f"# {key}: {json.dumps(value)}" for key, value in provenance.items()]
    header.append(f"# units: {json.dumps({c.name: c.unit for c in study.columns})}")
    names = ",".join(column.name for column in study.columns)
    file.write("\n".join([*header, names, ""]).encode())
    for piece in pieces:
        with piece.open("rb") as rows:
            shutil.copyfileobj(rows, file)


def _csv_provenance(path: Path) -> dict[str, Any] | None:
    said = {}
    with path.open("rb") as file:
        for line in file:
            key, colon, value = line.removeprefix(b"# ").partition(b": ")
            if not line.startswith(b"# ") or not colon:
                break
            try:
                said[key.decode()] = json.loads(value)
            except ValueError:
                return None
    said.pop("units", None)
    return said or None


def _count_csv(path: Path, study: Study) -> int:
    with path.open("rb") as file:
        names = next((line for line in file if not line.startswith(b"# ")), b"")
        if names != (",".join(column.name for column in study.columns) + "\n").encode():
            return 0
        # Each row ends with the only line feed that it has; what follows the last one is no row.
        return sum(part.count(b"\n") for part in iter(partial(file.read, _CHUNK), b""))


_CSV_NUMBERS: Final[Mapping[str, float]] = {"": np.nan, "true": 1.0, "false": 0.0}


def _read_csv(path: Path, study: Study) -> Rows:
    with path.open(encoding="utf-8", newline="") as file:
        lines = (line for line in file if not line.startswith("# "))
        table = list(zip(*csv.reader(lines), strict=True))
    columns = {name: values for name, *values in table}
    return _rows(
        study,
        {
            column.name: [
                _CSV_NUMBERS[text] if text in _CSV_NUMBERS else read_number(text)
                for text in columns[column.name]
            ]
            for column in study.columns
            if column.kind != "text"
        },
        columns["reason"],
    )


def _rows(study: Study, numbers: Mapping[str, Any], reasons: Iterable[str]) -> Rows:
    return Rows(
        {
            column.name: np.array(numbers[column.name], dtype=float)
            for column in study.columns
            if column.kind != "text" and column.name != "separation"
        },
        np.array(numbers["separation"], dtype=bool),
        tuple(reasons),
    )


def _arrow_table(study: Study, rows: Rows) -> Any:
    import pyarrow as pa

    schema = _arrow_schema(study)
    arrays = [_arrow_array(rows, column) for column in study.columns]
    return pa.table(arrays, schema=schema)


def _arrow_array(rows: Rows, column: SweepColumn) -> Any:
    import pyarrow as pa

    if column.kind == "number":
        return pa.array(rows.numbers[column.name], from_pandas=True)
    return pa.array(rows.values(column), type=_ARROW_TYPES[column.kind])


def _arrow_schema(study: Study, provenance: Provenance | None = None) -> Any:
    import pyarrow as pa

    fields = [
        pa.field(
            column.name,
            pa.type_for_alias(_ARROW_TYPES[column.kind]),
            metadata={"unit": column.unit, "meaning": column.meaning},
        )
        for column in study.columns
    ]
    metadata = {key: json.dumps(value) for key, value in (provenance or {}).items()}
    return pa.schema(fields, metadata=metadata or None)


def _write_parquet_piece(file: BinaryIO, study: Study, rows: Rows) -> None:
    import pyarrow.parquet as pq

    pq.write_table(_arrow_table(study, rows), file)


def _merge_parquet(
    file: BinaryIO, study: Study, pieces: Iterable[Path], provenance: Provenance
) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    schema = _arrow_schema(study, provenance)
    with pq.ParquetWriter(file, schema) as writer:
        waiting: list[Any] = []

        def write() -> None:
            table = pa.concat_tables(waiting).combine_chunks()
            writer.write_table(table.replace_schema_metadata(schema.metadata))
            waiting.clear()

        for piece in pieces:
            waiting.append(pq.read_table(piece))
            if sum(table.num_rows for table in waiting) >= _GROUP_ROWS:
                write()
        if waiting:
            write()


def _parquet_provenance(path: Path) -> dict[str, Any] | None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        metadata = pq.read_schema(path).metadata or {}
        return {key.decode(): json.loads(value) for key, value in metadata.items()}
    except (pa.ArrowException, ValueError):
        return None


def _count_parquet(path: Path, study: Study) -> int:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        found = pq.read_metadata(path)
    except pa.ArrowException:
        return 0
    groups = [found.row_group(number) for number in range(found.num_row_groups)]
    chunks = [group.column(place) for group in groups for place in range(group.num_columns)]
    stored = sum(chunk.total_compressed_size for chunk in chunks)
    if found.schema.names != [column.name for column in study.columns]:
        return 0
    # The end of the file says where everything is: a file from which a part is missing is shorter.
    whole = path.stat().st_size >= stored + found.serialized_size + _PARQUET_FRAME
    return int(found.num_rows) if whole else 0


def _read_parquet(path: Path, study: Study) -> Rows:
    import pyarrow.parquet as pq

    table = pq.read_table(path)
    numbers = {
        column.name: table[column.name].cast("double").to_numpy()
        if column.kind != "truth"
        else table[column.name].cast("int8").cast("double").to_numpy()
        for column in study.columns
        if column.kind != "text"
    }
    return _rows(study, numbers, table["reason"].to_pylist())


SWEEP_FORMATS: Final[Mapping[str, SweepFormat]] = {
    ".csv": SweepFormat(_write_csv_piece, _merge_csv, _csv_provenance, _count_csv, _read_csv),
    ".parquet": SweepFormat(
        _write_parquet_piece,
        _merge_parquet,
        _parquet_provenance,
        _count_parquet,
        _read_parquet,
        "pyarrow",
    ),
}
