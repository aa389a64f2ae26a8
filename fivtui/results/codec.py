"""Convert results to data for JSON and back, and check that the data are finite.

msgspec converts dataclasses, tuples and enumerations, checks the types of data that it reads, and
names the wrong value in errors.
"""

import math
from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np

from fivtui.model import ComputationError


def to_data(value: Any) -> Any:
    """A value as data for JSON; NaN in arrays becomes None, a complex number becomes a pair."""
    return _tuples_to_lists(msgspec.to_builtins(value, enc_hook=_encode))


def from_data(data: Any, kind: Any) -> Any:
    """Convert data of `to_data` back to the type `kind`; `ValueError` if they do not fit it.

    The type must not contain arrays: the data have lists in place of them.
    """
    return msgspec.convert(data, kind, dec_hook=_decode)


def _tuples_to_lists(data: Any) -> Any:
    # JSON has lists but no tuples.
    if isinstance(data, dict):
        return {key: _tuples_to_lists(value) for key, value in data.items()}
    return [_tuples_to_lists(item) for item in data] if isinstance(data, (tuple, list)) else data


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
    raise TypeError(f"{type(value).__name__} cannot be written to JSON")


def _decode(kind: type, data: Any) -> Any:
    if kind is complex:
        return complex(*data)
    raise TypeError(f"{kind.__name__} cannot be read from JSON")


def check_finite(data: object, name: str, advice: str) -> None:
    """Raise `ComputationError` with `advice` if a number in nested data is not finite."""
    if isinstance(data, Mapping):
        for key, value in data.items():
            check_finite(value, f"{name}.{key}".lstrip("."), advice)
    elif isinstance(data, list):
        for value in data:
            check_finite(value, name, advice)
    elif isinstance(data, float) and not math.isfinite(data):
        raise not_finite_error(name, advice)


def not_finite_error(name: str, advice: str) -> ComputationError:
    """The error for a number that is not finite."""
    return ComputationError(f"{name} is not a finite number", advice)
