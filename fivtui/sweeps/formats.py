"""File formats of sweeps: pieces of rows are written first, then merged into one file.

The provenance in the header of the file describes the sweep and how its rows were computed.
"""

import shutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO, Final

from fivtui.io import (
    FORMATS,
    UNITS,
    Format,
    csv_cell,
    parquet_schema,
    quote_csv,
    table_format,
    write_csv_header,
    write_csv_rows,
)
from fivtui.model import InputError

from .rows import Rows
from .study import ColumnKind, Study

# JSON values by key, see `fivtui.sweeps.provenance`.
Provenance = Mapping[str, Any]

_TRUTH_TEXTS: Final[Mapping[bool, str]] = {True: "true", False: "false"}
_NO_PROVENANCE: Final[Provenance] = {}
# Rows per row group of a Parquet file: large enough for speed, small enough for memory.
_GROUP_ROWS: Final = 131_072
# Bytes that are read at a time to count rows.
_READ_BYTES: Final = 1 << 20
# Bytes of a Parquet file besides its columns and metadata: a mark of 4 bytes at both ends, and the
# length of the metadata.
_PARQUET_FRAME_BYTES: Final = 12
_ARROW_TYPES: Final[Mapping[ColumnKind, str]] = {
    "number": "double",
    "count": "int64",
    "truth": "bool",
    "text": "string",
}


@dataclass(frozen=True, slots=True)
class SweepFormat:
    """A file format of a sweep's rows."""

    # The format of the complete file as a table.
    table: Format
    # Writes a piece: some rows of a study.
    write_piece: Callable[[BinaryIO, Study, Rows], None]
    # Writes the provenance, and below it the pieces in order.
    merge: Callable[[BinaryIO, Study, Iterable[Path], Provenance], None]
    # Number of complete rows of a study in a file; 0 if the file has other columns.
    count: Callable[[Path, Study], int]

    def provenance(self, path: Path) -> dict[str, Any] | None:
        """Read the provenance in a file; None if it has none."""
        with path.open("rb") as file:
            try:
                return self.table.header(file) or None
            except InputError:
                return None

    def read(self, path: Path, study: Study) -> Rows:
        """Read the rows of a study from a file."""
        # The status follows from the reason, which is empty unless the member failed.
        names = [column.name for column in study.columns if column.name != "status"]
        with path.open("rb") as file:
            columns = self.table.read(file, names, ["reason"], missing=True)
        numbers = {
            name: columns[name].astype(float)
            for name in names
            if name not in ("separation", "reason")
        }
        return Rows(numbers, columns["separation"].astype(bool), tuple(columns["reason"]))


def sweep_format(path: Path) -> SweepFormat:
    """The format of a file by its suffix; `InputError` if unknown or its package is missing."""
    table_format(path, "sweep", SWEEP_FORMATS)
    return SWEEP_FORMATS[path.suffix.lower()]


def _cell_text(value: object) -> str:
    return _TRUTH_TEXTS[value] if isinstance(value, bool) else csv_cell(value)


def _write_csv_piece(file: BinaryIO, study: Study, rows: Rows) -> None:
    cells = (
        [quote_csv(text) if text else "" for text in rows.reasons]
        if column.name == "reason"
        else map(_cell_text, rows.values(column))
        for column in study.columns
    )
    write_csv_rows(file, cells)


def _merge_csv(
    file: BinaryIO, study: Study, pieces: Iterable[Path], provenance: Provenance
) -> None:
    units = {column.name: column.unit for column in study.columns}
    write_csv_header(file, units, {**provenance, UNITS: units})
    for piece in pieces:
        with piece.open("rb") as rows:
            shutil.copyfileobj(rows, file)


def _count_csv_rows(path: Path, study: Study) -> int:
    with path.open("rb") as file:
        name_line = next((line for line in file if not line.startswith(b"# ")), b"")
        if name_line != (",".join(column.name for column in study.columns) + "\n").encode():
            return 0
        # A complete row ends with its only line feed.
        return sum(chunk.count(b"\n") for chunk in iter(partial(file.read, _READ_BYTES), b""))


def _arrow_schema(study: Study, provenance: Provenance = _NO_PROVENANCE) -> Any:
    import pyarrow as pa

    types = [pa.type_for_alias(_ARROW_TYPES[column.kind]) for column in study.columns]
    return parquet_schema(study.columns, types, provenance, nullable=True)


def _write_parquet_piece(file: BinaryIO, study: Study, rows: Rows) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    arrays = [
        pa.array(rows.numbers[column.name], from_pandas=True)
        if column.kind == "number"
        else pa.array(rows.values(column), type=_ARROW_TYPES[column.kind])
        for column in study.columns
    ]
    pq.write_table(pa.table(arrays, schema=_arrow_schema(study)), file)


def _merge_parquet(
    file: BinaryIO, study: Study, pieces: Iterable[Path], provenance: Provenance
) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    schema = _arrow_schema(study, provenance)
    with pq.ParquetWriter(file, schema) as writer:
        tables: list[Any] = []

        def write_group() -> None:
            table = pa.concat_tables(tables).combine_chunks()
            writer.write_table(table.replace_schema_metadata(schema.metadata))
            tables.clear()

        for piece in pieces:
            tables.append(pq.read_table(piece))
            if sum(table.num_rows for table in tables) >= _GROUP_ROWS:
                write_group()
        if tables:
            write_group()


def _count_parquet_rows(path: Path, study: Study) -> int:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        metadata = pq.read_metadata(path)
    except pa.ArrowException:
        return 0
    groups = [metadata.row_group(number) for number in range(metadata.num_row_groups)]
    chunks = [group.column(index) for group in groups for index in range(group.num_columns)]
    column_bytes = sum(chunk.total_compressed_size for chunk in chunks)
    if metadata.schema.names != [column.name for column in study.columns]:
        return 0
    # A file that lost bytes in the middle is shorter than its metadata say.
    expected_bytes = column_bytes + metadata.serialized_size + _PARQUET_FRAME_BYTES
    return int(metadata.num_rows) if path.stat().st_size >= expected_bytes else 0


SWEEP_FORMATS: Final[Mapping[str, SweepFormat]] = {
    ".csv": SweepFormat(FORMATS[".csv"], _write_csv_piece, _merge_csv, _count_csv_rows),
    ".parquet": SweepFormat(
        FORMATS[".parquet"], _write_parquet_piece, _merge_parquet, _count_parquet_rows
    ),
}
