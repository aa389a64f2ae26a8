"""The columns of a trajectory: the only source of their names, units and meanings."""

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a trajectory.

    Attributes
    ----------
    name : str
        Name of the attribute of `Trajectory` and of the column in a file.
    unit : str
        SI unit.
    meaning : str
        One phrase.
    """

    name: str
    unit: str
    meaning: str


COLUMNS: Final = (
    Column("t", "s", "time"),
    Column("x", "m", "horizontal displacement"),
    Column("vx", "m/s", "horizontal velocity"),
    Column("y", "m", "vertical displacement"),
    Column("vy", "m/s", "vertical velocity"),
    Column("P", "N", "contact force"),
    Column("mode", "1", "1 in contact, 0 separated"),
)
