"""Checks that results are finite."""

import math
from collections.abc import Mapping

from fivtui.model import ComputationError


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
