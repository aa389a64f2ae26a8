"""The parser of the input of tabs of maps, and points of its chart. Imports no Textual."""

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.charts import Axis, NearestPoint
from fivtui.model import ALL_PARAMETERS, InputError
from fivtui.ranges import number_text
from fivtui.transient import WITH_SEPARATION, WITHOUT_SEPARATION
from fivtui.tui.session import replace_symbols, symbol_of

if TYPE_CHECKING:
    from fivtui.maps import StabilityMap
    from fivtui.ranges import NamedRange

FloatArray = NDArray[np.float64]

# Titles of the values that are mapped quickly.
TITLES: Final = {"growth-rate": "Growth", "critical-mu": "μ_c", "unstable-modes": "Modes"}
# Usual ranges by mapped value; values of safety, which take longer, have fewer points.
EXAMPLES: Final = {
    "growth-rate": "μ=0:1.5:121 F=5:120:93",
    "critical-mu": "F=5:120:93 k_nl=20:500:61",
    "unstable-modes": "μ=0:1.5:121 F=5:120:93",
    "safe-mu": "F=5:120:24 k_nl=20:500:25",
    "coexistence": "μ=0:1.5:31 F=5:120:24",
}
_MAX_POINTS: Final = 1_000_000
# Significant digits of the coordinates of an opened point.
_DIGITS: Final = 9


def map_request(text: str, value: str) -> "tuple[NamedRange, NamedRange]":
    """Parse the two ranges of a map, such as ``μ=0:1.5:121 F=5:120:93``; the first is along x.

    `value` is the mapped value, a key of `EXAMPLES`. Raises `InputError` for an invalid text.
    """
    from fivtui.maps import check_map, check_points
    from fivtui.ranges import parse_ranges

    range_texts = replace_symbols(text).split()
    if len(range_texts) != 2:
        raise InputError(f"{text!r}: must be two ranges, e.g. {EXAMPLES[value]}")
    try:
        first, second = parse_ranges("map", range_texts)
    except InputError as error:
        raise InputError(str(error).removeprefix("map ")) from None
    check_map(value, (first.name, second.name))
    check_points(first.count * second.count, _MAX_POINTS)
    return first, second


def mapped_values(named_range: "NamedRange", axis: Axis | None) -> FloatArray:
    """The values of a range, or the same number of values between chosen axis limits."""
    if axis is None:
        return named_range.values()
    spec = ALL_PARAMETERS[named_range.name]
    low, high = max(axis.low, spec.lower), min(axis.high, spec.upper)
    if low >= high:
        return named_range.values()
    spacing = np.geomspace if axis.log and low > 0.0 else np.linspace
    values: FloatArray = spacing(low, high, named_range.count)
    return values


def point_texts(result: "StabilityMap", point: NearestPoint) -> dict[str, str]:
    """Field texts of a point of a map: all parameters and separation."""
    coordinates = (float(f"{value:.{_DIGITS}g}") for value in (point.x, point.y))
    values = result.parameters.as_dict() | dict(zip(result.names, coordinates, strict=True))
    texts = {name: number_text(value) for name, value in values.items()}
    return texts | {"separation": WITH_SEPARATION if result.separation else WITHOUT_SEPARATION}


def point_text(result: "StabilityMap", point: NearestPoint) -> str:
    """The coordinates of a point of a map as text."""
    texts = point_texts(result, point)
    return ", ".join(f"{symbol_of(name)} = {texts[name]}" for name in result.names)
