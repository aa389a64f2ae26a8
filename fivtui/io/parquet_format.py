"""Tables as Parquet: header in the schema's metadata, units and meanings in those of fields."""

import json
from collections.abc import Collection, Mapping, Sequence
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Column, InputError

# The package that the format needs, and the extra that installs it, see `tables.Format`.
package, extra = "pyarrow", "parquet"
# Key of the metadata that pyarrow adds; it is no entry of the header.
_ARROW: Final = b"ARROW:schema"


def write(
    file: BinaryIO,
    columns: Sequence[Column],
    values: Mapping[str, NDArray[Any]],
    header: Mapping[str, Any],
) -> None:
    """Write a table of numbers, its header, and units and meanings of its columns."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    arrays = [pa.array(values[column.name]) for column in columns]
    types = [array.type for array in arrays]
    pq.write_table(
        pa.table(arrays, schema=parquet_schema(columns, types, header, nullable=False)), file
    )


def parquet_schema(
    columns: Sequence[Column], types: Sequence[Any], header: Mapping[str, Any], *, nullable: bool
) -> Any:
    """An Arrow schema of columns with name, unit and meaning."""
    import pyarrow as pa

    fields = [
        pa.field(
            column.name,
            arrow_type,
            nullable=nullable,
            metadata={"unit": column.unit, "meaning": column.meaning},
        )
        for column, arrow_type in zip(columns, types, strict=True)
    ]
    metadata = {key: json.dumps(value) for key, value in header.items()}
    return pa.schema(fields, metadata=metadata or None)


def read(
    file: BinaryIO,
    selected: Collection[str] | None = None,
    texts: Collection[str] = (),
    *,
    missing: bool = False,  # noqa: ARG001
) -> dict[str, NDArray[Any]]:
    """Read columns, see `tables.Format`; numbers may always be missing, whatever `missing`."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(file, columns=None if selected is None else list(selected))
        return {name: _column_array(table[name], name in texts) for name in table.column_names}
    except pa.ArrowException:
        raise InputError("not a Parquet file, or damaged") from None


def _column_array(column: Any, is_text: bool) -> NDArray[Any]:
    import pyarrow as pa

    if is_text:
        return np.array(column.to_pylist(), dtype=object)
    if pa.types.is_boolean(column.type):
        column = column.cast("int8")
    # Missing numbers become NaN, which integers do not have.
    array: NDArray[Any] = (column.cast("double") if column.null_count else column).to_numpy()
    return array


def header(file: BinaryIO) -> dict[str, Any]:
    """Read the header."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        metadata = pq.read_schema(file).metadata or {}
        return {key.decode(): json.loads(value) for key, value in metadata.items() if key != _ARROW}
    except (pa.ArrowException, ValueError, RecursionError):
        raise InputError("not a Parquet file, or damaged") from None
