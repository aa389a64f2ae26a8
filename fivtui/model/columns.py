"""The columns of a trajectory: name, unit and meaning, defined once."""

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Column:
    """A column of numbers in a file: name, SI unit and meaning in one phrase."""

    name: str
    unit: str
    meaning: str


# Mode 1 is contact with a belt that is always faster than the slider; modes 2 to 4 are contact with
# a belt of finite speed.
COLUMNS: Final = (
    Column("t", "s", "time"),
    Column("x", "m", "horizontal displacement"),
    Column("vx", "m/s", "horizontal velocity"),
    Column("y", "m", "vertical displacement"),
    Column("vy", "m/s", "vertical velocity"),
    Column("P", "N", "contact force"),
    Column("mode", "1", "1 in contact, 0 separated; 2 forward slip, 3 backward slip, 4 stick"),
)
