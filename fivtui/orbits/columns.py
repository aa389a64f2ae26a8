"""Columns shared by tables of limit cycles."""

from collections.abc import Iterable, Sequence
from typing import Final, Protocol

import numpy as np

from fivtui.model import Column, State
from fivtui.results import Table
from fivtui.transient import START_SPECS

_MULTIPLIER_COUNT: Final = 3
MEASURES: Final = (
    Column("period", "s", "period of the limit cycle"),
    Column("y_min", "m", "lowest point"),
    Column("y_max", "m", "highest point"),
    Column("half_range", "m", "half peak-to-peak of y"),
)


class CycleLike(Protocol):
    """A record with a state and Floquet multipliers; a Hopf point has no multipliers."""

    @property
    def start(self) -> State:
        """A state of the cycle."""

    @property
    def multipliers(self) -> Sequence[complex]:
        """Its Floquet multipliers."""


def attribute_table(records: Sequence[object], columns: Iterable[Column]) -> Table:
    """Columns of the attributes of records; each column is named after its attribute."""
    return {c: np.array([getattr(record, c.name) for record in records]) for c in columns}


def multiplier_table(cycles: Sequence[CycleLike]) -> Table:
    """Columns of the Floquet multipliers of cycles; NaN where there are none."""
    undefined = (complex(np.nan, np.nan),) * _MULTIPLIER_COUNT
    rows = np.array([tuple(cycle.multipliers) or undefined for cycle in cycles])
    return {
        Column(
            f"multiplier_{number}_{part}", "1", f"Floquet multiplier {number}, {meaning} part"
        ): (values.real if part == "re" else values.imag)
        for number, values in enumerate(rows.T, 1)
        for part, meaning in (("re", "real"), ("im", "imaginary"))
    }


def start_table(cycles: Sequence[CycleLike], description: str) -> Table:
    """Columns of a state of each cycle, which `description` describes."""
    states = np.array([cycle.start for cycle in cycles])
    return {
        Column(spec.name, spec.unit, f"{spec.meaning}: {description}"): values
        for spec, values in zip(START_SPECS.values(), states.T, strict=True)
    }
