"""The data of a figure: named columns with units, and their file.

A figure has panels; the lines of a panel differ in the column `by` and are drawn over `along`.
"""

import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.io import write_table
from fivtui.model import COLUMNS, PARAMETERS, Column, ComputationError

from .panels import SEPARATION

FloatArray = NDArray[np.float64]

_PAPER_COLUMNS: Final = (
    Column(SEPARATION, "1", "1 considered, 0 ignored"),
    Column("x_e", "m", "horizontal displacement of the equilibrium"),
    Column("y_e", "m", "vertical displacement of the equilibrium"),
    Column("omega_1", "rad/s", "imaginary part of the eigenvalue of the lower mode"),
    Column("omega_2", "rad/s", "imaginary part of the eigenvalue of the upper mode"),
    Column("sigma_1", "1/s", "real part of the eigenvalue of the lower mode"),
    Column("sigma_2", "1/s", "real part of the eigenvalue of the upper mode"),
    Column("mu_c", "1", "critical friction coefficient"),
    Column("growth_rate", "1/s", "greatest real part of the eigenvalues at the equilibrium"),
    Column("y_peak", "m", "greatest |y| of the run"),
    Column("y_half_range", "m", "half peak-to-peak of y over the second half of the run"),
    Column("separations", "1", "number of separations"),
    Column("separated_time", "s", "time off the belt"),
)
DATA_COLUMNS: Final[Mapping[str, Column]] = {
    column.name: column
    for column in (
        *(Column(p.name, p.unit or "1", p.meaning) for p in PARAMETERS.values()),
        *COLUMNS,
        *_PAPER_COLUMNS,
    )
}


@dataclass(frozen=True, slots=True)
class FigureData:
    """The numbers that a panel shows."""

    key: str
    caption: str
    by: str
    along: str
    columns: Mapping[str, FloatArray]
    provenance: Mapping[str, Any]

    def __post_init__(self) -> None:
        for name, values in self.columns.items():
            if not np.all(np.isfinite(values)):
                raise ComputationError(
                    f"figure {self.key}: {name} is not a finite number",
                    "report the version and the machine: these scenes all have finite values",
                )

    def __getitem__(self, name: str) -> FloatArray:
        return self.columns[name]

    def line(self, value: float) -> "FigureData":
        """The rows of one line, given its value of the column `by`."""
        rows = self.columns[self.by] == value
        return dataclasses.replace(
            self, columns={name: values[rows] for name, values in self.columns.items()}
        )

    def lines(self) -> Iterator[tuple[float, "FigureData"]]:
        """The lines in order: value of the column `by`, and their rows."""
        # In the order of the figure, not sorted.
        for value in dict.fromkeys(self.columns[self.by].tolist()):
            yield value, self.line(value)


def save_data(data: FigureData, path: Path) -> None:
    """Write the data of a figure as ``.csv``, ``.npz`` or ``.parquet``, with units and provenance.

    Raises `InputError` if the format is unknown or its package missing, or the file cannot be
    written.
    """
    stored_columns = [DATA_COLUMNS[name] for name in data.columns]
    header = {
        "figure": data.key,
        "caption": data.caption,
        **data.provenance,
        "meanings": {column.name: column.meaning for column in stored_columns},
    }
    write_table(path, "figure's data", stored_columns, dict(data.columns), header)
