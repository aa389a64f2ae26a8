"""The plane of two parameters that vary, and the unknowns of an orbit at a point of it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from fivtui.model import System
from fivtui.orbits.curves.flow import FloatArray
from fivtui.orbits.curves.following import Bound

# An orbit has seven unknowns: state, period and the two parameters. Their indices:
STATE: Final = slice(0, 4)
STATE_AND_PERIOD: Final = slice(0, 5)
FIRST_PARAMETER: Final = 5
SECOND_PARAMETER: Final = 6
IN_PLANE: Final = slice(5, 7)
UNKNOWN_COUNT: Final = 7


@dataclass(frozen=True, slots=True)
class ParameterPlane:
    """A rectangle of two parameters; all others are those of the system."""

    system: System
    names: tuple[str, str]
    ranges: tuple[tuple[float, float], tuple[float, float]]

    @property
    def units(self) -> FloatArray:
        """Units of the parameters, powers of two: a quarter to half of their ranges."""
        spans = (high - low for low, high in self.ranges)
        return np.array([2.0 ** math.floor(math.log2(span) - 1.0) for span in spans])

    def bounds(self, indices: Sequence[int]) -> tuple[Bound, Bound]:
        """The ranges in units of the parameters, which are the unknowns with these indices."""
        first, second = (
            Bound(index, low / float(unit), high / float(unit))
            for index, (low, high), unit in zip(indices, self.ranges, self.units, strict=True)
        )
        return first, second

    def system_at(self, values: Sequence[float]) -> System:
        """The system at a point of the plane."""
        return self.system.with_values(dict(zip(self.names, values, strict=True)))
