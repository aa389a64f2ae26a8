"""Parameters that follow tables over time, read from scene files or from CSV files."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from fivtui.io import read_csv
from fivtui.model import TIME_DEPENDENT, InputError, TimeTable, check_known, time_table
from fivtui.transient import check_file_number

# Tables over time, with the names of their parameters.
OverTime = tuple[tuple[str, TimeTable], ...]

# Default name of the column of time (s), and the key by which a scene file gives another name.
TIME: Final = "time"
_TIME_KEY: Final = "time"
_MAX_ROWS: Final = 20_000
_FILE_KEYS: Final = ("file", _TIME_KEY, *TIME_DEPENDENT)
_COLUMN_KEYS: Final = ("column", "scale", "offset")
_ALLOWED_FORM: Final = "a table such as {F = [[0, 10], [4, 60]]}, or with file = a CSV file"


class ScaledColumn(NamedTuple):
    """A column of a CSV file from which a parameter follows: scale times value plus offset."""

    name: str
    scale: float = 1.0
    offset: float = 0.0


def parse_over_time(key: str, value: object, folder: Path | None = None) -> OverTime:
    """The tables in a scene file: rows of time (s) and value, or columns of a CSV file.

    The path of the CSV file is relative to `folder`. Raises `InputError` if `value` has neither
    rows nor a file.
    """
    if not isinstance(value, Mapping):
        raise InputError(f"{key} = {value!r}: must be {_ALLOWED_FORM}")
    if "file" not in value:
        return tuple(
            (str(name), time_table(str(name), _check_rows(rows))) for name, rows in value.items()
        )
    for name in value:
        check_known(f"key of {key}", str(name), _FILE_KEYS)
    if not isinstance(value["file"], str):
        raise InputError(f"{key}.file = {value['file']!r}: must be the name of a file in quotes")
    path = (folder or Path()) / value["file"]
    columns = {name: _read_column(name, value[name]) for name in TIME_DEPENDENT if name in value}
    return read_over_time(path, time=str(value.get(_TIME_KEY, TIME)), columns=columns or None)


def read_over_time(
    path: Path,
    *,
    time: str = TIME,
    columns: Mapping[str, ScaledColumn] | None = None,
) -> OverTime:
    """The tables in a CSV file with a row of names.

    `time` is the column of time (s). `columns` are the columns by parameter; by default all columns
    but that of time have the name of a parameter.
    """
    table = read_csv(path)
    allowed = list(table)
    if columns is None:
        allowed = [time, *TIME_DEPENDENT]
        columns = {name: ScaledColumn(name) for name in TIME_DEPENDENT if name in table}
    for name in (time, *(column.name for column in columns.values())):
        if name not in table:
            names = ", ".join(table) or "none"
            raise InputError(f"{path}: there is no column {name}; it has {names}")
    for name in table:
        if name not in allowed:
            raise InputError(f"{path}: column {name}: must be one of {', '.join(allowed)}")
    if not columns:
        raise InputError(f"{path}: must have a column of {', '.join(TIME_DEPENDENT)}")
    if table[time].size > _MAX_ROWS:
        raise InputError(f"{path}: {table[time].size} rows: must be at most {_MAX_ROWS}")
    tables = []
    for name, column in columns.items():
        values = column.scale * np.asarray(table[column.name], dtype=float) + column.offset
        rows = zip(table[time].tolist(), values.tolist(), strict=True)
        try:
            tables.append((name, time_table(name, rows)))
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
    return tuple(tables)


def over_time_to_dict(tables: OverTime) -> dict[str, list[list[float]]]:
    """Tables in the layout of a scene file."""
    return {name: [list(row) for row in table.rows()] for name, table in tables}


def _check_rows(rows: object) -> Any:
    is_nested = isinstance(rows, list | tuple) and all(
        isinstance(row, list | tuple) for row in rows
    )
    if not is_nested:
        raise InputError(f"{rows!r}: must be rows of time and value such as [[0, 10], [4, 60]]")
    return rows


def _read_column(name: str, value: object) -> ScaledColumn:
    if isinstance(value, str):
        return ScaledColumn(value)
    if not isinstance(value, Mapping) or not isinstance(value.get("column"), str):
        raise InputError(
            f'{name} = {value!r}: must be a column such as {{column = "p", scale = 12}}'
        )
    for key in value:
        check_known(f"key of {name}", str(key), _COLUMN_KEYS)
    # Raises `InputError` if a value of the scene file is no number.
    scale, offset = (
        check_file_number(f"{name}.{key}", value.get(key, default))
        for key, default in (("scale", 1.0), ("offset", 0.0))
    )
    return ScaledColumn(str(value["column"]), scale, offset)
