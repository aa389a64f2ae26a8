"""Tables as NPZ: an array for each column and each entry of the header."""

import json
import zipfile
import zlib
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Column, InputError

package = extra = ""
_UNITS: Final = "units"
_DAMAGED: Final = (
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
        arrays[key] = _array(value)
    np.savez(file, **arrays)


def _array(value: Any) -> NDArray[Any]:
    # Store a mapping as a record, so that no array holds Python objects.
    if not isinstance(value, Mapping):
        array = np.array(value)
        # Store a list of mappings as text, for the same reason.
        return np.array(json.dumps(value)) if array.dtype == object else array
    # Omit entries that are None.
    entries = {key: _array(entry) for key, entry in value.items() if entry is not None}
    record = np.empty((), dtype=[(key, e.dtype, e.shape) for key, e in entries.items()])
    for key, entry in entries.items():
        record[key] = entry
    return record


@contextmanager
def npz_arrays(file: BinaryIO) -> Iterator["np.lib.npyio.NpzFile"]:
    """The arrays of an NPZ file; `InputError` if it is another file or damaged."""
    try:
        arrays = np.load(file, allow_pickle=False)
        if not isinstance(arrays, np.lib.npyio.NpzFile):
            raise InputError("not an NPZ file")
        yield arrays
    except InputError:
        raise
    except _DAMAGED:
        raise InputError("not an NPZ file, or damaged") from None


def read(
    file: BinaryIO,
    selected: Collection[str] | None = None,
    texts: Collection[str] = (),  # noqa: ARG001
    *,
    missing: bool = False,  # noqa: ARG001
) -> dict[str, NDArray[Any]]:
    """Read columns, see `tables.Format`."""
    with npz_arrays(file) as arrays:
        names = (
            _names(arrays) if selected is None else [name for name in selected if name in arrays]
        )
        return {name: arrays[name] for name in names}


def header(file: BinaryIO) -> dict[str, Any]:
    """Read the header alone, without units."""
    with npz_arrays(file) as arrays:
        columns = {*_names(arrays), _UNITS}
        return {key: _plain(arrays[key]) for key in arrays.files if key not in columns}


def _names(arrays: "np.lib.npyio.NpzFile") -> tuple[str, ...]:
    return arrays[_UNITS].dtype.names or ()


def _plain(array: NDArray[Any]) -> Any:
    # A record is a mapping.
    names = array.dtype.names
    return {name: _plain(array[name]) for name in names} if names else array.tolist()
