"""The columns of a trajectory: name, unit and meaning, defined once."""

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Column:
    """A column of numbers in a file: name, SI unit and meaning in one phrase."""

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
    Column("mode", "1", "1 in contact, 0 separated; 2 forward slip, 3 backward slip, 4 stick"),
)
