"""Results as data that JSON holds, and back.

msgspec converts dataclasses, tuples and enumerations, checks the types of data that it reads, and
names the wrong value in errors.
"""

from typing import Any

import msgspec
import numpy as np


def to_data(value: Any) -> Any:
    """A value as data that JSON holds; NaN in arrays becomes None, complex numbers become pairs."""
    return _lists(msgspec.to_builtins(value, enc_hook=_encode))


def from_data(data: Any, kind: Any) -> Any:
    """A value of a type from the data of `to_data`; `ValueError` if they are of another form."""
    return msgspec.convert(data, kind, dec_hook=_decode)


def _lists(data: Any) -> Any:
    # JSON has lists but no tuples.
    if isinstance(data, dict):
        return {key: _lists(value) for key, value in data.items()}
    return [_lists(item) for item in data] if isinstance(data, (tuple, list)) else data


def _encode(value: Any) -> Any:
    if isinstance(value, complex):
        return [value.real, value.imag]
    if isinstance(value, np.ndarray):
        data = value.astype(object)
        if value.dtype.kind == "f":
            data[np.isnan(value)] = None
        return data.tolist()
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} has no form in JSON")


def _decode(kind: type, data: Any) -> Any:
    if kind is complex:
        return complex(*data)
    raise TypeError(f"{kind.__name__} cannot be read from JSON")
