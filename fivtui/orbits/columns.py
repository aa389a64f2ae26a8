"""Columns that tables of limit cycles have in common."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Column, State
from fivtui.transient import START_SPECS

_MULTIPLIERS: Final = 3
MEASURES: Final = (
    Column("period", "s", "period of the limit cycle"),
    Column("y_min", "m", "lowest point"),
    Column("y_max", "m", "highest point"),
    Column("half_range", "m", "half peak-to-peak of y"),
)
MULTIPLIERS: Final = tuple(
    Column(f"multiplier_{place}_{part}", "1", f"Floquet multiplier {place}, {words} part")
    for place in range(1, _MULTIPLIERS + 1)
    for part, words in (("re", "real"), ("im", "imaginary"))
)


def state_columns(of: str) -> tuple[Column, ...]:
    """Columns of x, ẋ, y, ẏ of a state, with what it is of."""
    return tuple(Column(s.name, s.unit, f"{s.meaning}: {of}") for s in START_SPECS.values())


def multiplier_values(each: Sequence[Sequence[complex]]) -> dict[str, NDArray[Any]]:
    """The columns `MULTIPLIERS` of cycles' multipliers; NaN where there are none."""
    none = (complex(np.nan, np.nan),) * _MULTIPLIERS
    values = np.array([tuple(multipliers) or none for multipliers in each]).T
    parts = [part for value in values for part in (value.real, value.imag)]
    return dict(zip((column.name for column in MULTIPLIERS), parts, strict=True))


def state_values(states: Sequence[State]) -> dict[str, NDArray[Any]]:
    """The columns `state_columns` of states."""
    return dict(zip(START_SPECS, np.array(states).T, strict=True))
