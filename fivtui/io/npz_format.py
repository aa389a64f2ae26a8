"""Tables as NPZ, numpy's archive of arrays: one for each column and each entry of the header."""

import json
import zipfile
import zlib
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Column, InputError

# The package that a `tables.Format` needs, and the extra of fivtui that installs it: none.
package = extra = ""
# Name of the array that has the units of columns.
_UNITS: Final = "units"
# Errors that numpy raises for a damaged file.
_READ_ERRORS: Final = (
    ValueError,
    KeyError,
    TypeError,
    EOFError,
    RuntimeError,
    zipfile.BadZipFile,
    zlib.error,
)


def write(
    file: BinaryIO,
    columns: Sequence[Column],
    values: Mapping[str, NDArray[Any]],
    header: Mapping[str, Any],
) -> None:
    """Write a table of numbers, its header and the units of its columns."""
    units = {column.name: column.unit for column in columns}
    arrays: dict[str, Any] = {name: values[name] for name in units}
    for key, value in {**header, _UNITS: units}.items():
        arrays[key] = _header_array(value)
    np.savez(file, **arrays)


def _header_array(value: Any) -> NDArray[Any]:
    # Store a mapping as a structured array, so that no array holds Python objects.
    if not isinstance(value, Mapping):
        array = np.array(value)
        # Store a list of mappings as JSON text for the same reason.
        return np.array(json.dumps(value)) if array.dtype == object else array
    # Omit entries that are None.
    entries = {key: _header_array(entry) for key, entry in value.items() if entry is not None}
    record = np.empty((), dtype=[(key, array.dtype, array.shape) for key, array in entries.items()])
    for key, entry in entries.items():
        record[key] = entry
    return record


@contextmanager
def npz_arrays(file: BinaryIO) -> Iterator["np.lib.npyio.NpzFile"]:
    """Open the arrays of an NPZ file; `InputError` if it is damaged or not an NPZ file."""
    try:
        arrays = np.load(file, allow_pickle=False)
        if not isinstance(arrays, np.lib.npyio.NpzFile):
            raise InputError("not an NPZ file")
        yield arrays
    except InputError:
        raise
    except _READ_ERRORS:
        raise InputError("not an NPZ file, or damaged") from None


def read(
    file: BinaryIO,
    selected: Collection[str] | None = None,
    texts: Collection[str] = (),  # noqa: ARG001
    *,
    missing: bool = False,  # noqa: ARG001
) -> dict[str, NDArray[Any]]:
    """Read columns, see `tables.Format`.

    Arrays have their types in the file: it does not matter which columns are `texts`, or whether
    numbers may be `missing`.
    """
    with npz_arrays(file) as arrays:
        names = _column_names(arrays) if selected is None else [n for n in selected if n in arrays]
        return {name: arrays[name] for name in names}


def header(file: BinaryIO) -> dict[str, Any]:
    """Read the header without the units of columns."""
    with npz_arrays(file) as arrays:
        columns = {*_column_names(arrays), _UNITS}
        return {key: _plain_value(arrays[key]) for key in arrays.files if key not in columns}


def _column_names(arrays: "np.lib.npyio.NpzFile") -> tuple[str, ...]:
    return arrays[_UNITS].dtype.names or ()


def _plain_value(array: NDArray[Any]) -> Any:
    # A structured array stands for a mapping.
    names = array.dtype.names
    return {name: _plain_value(array[name]) for name in names} if names else array.tolist()
