"""Charts of the map tab: stability over two parameters. Imports no Textual."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.charts import Axis, Backdrop, Chart, NearestPoint, Trace
from fivtui.model import ALL_PARAMETERS, InputError, Parameters
from fivtui.ranges import number_text
from fivtui.transient import CONSIDERED, IGNORED
from fivtui.tui.session import plain_names, symbol_of

from .map_shades import (
    NO_VALUE,
    UNKNOWN_VALUE,
    graded,
    offsets,
    region_shades,
    scale_words,
    value_scale,
    with_unknown,
)

if TYPE_CHECKING:
    from fivtui.maps import StabilityMap
    from fivtui.ranges import NamedRange

FloatArray = NDArray[np.float64]

# Values that do not depend on μ, and ranges for them.
WITHOUT_MU: Final = ("critical-mu", "safe-mu")
EXAMPLE_WITHOUT_MU: Final = "F=5:120:93 k_nl=20:500:61"
EXAMPLE: Final = "μ=0:1.5:121 F=5:120:93"
VALUES: Final = {
    "growth-rate": "Growth",
    "critical-mu": "μ_c",
    "unstable-modes": "Modes",
    "safe-mu": "Safe μ",
    "coexistence": "Regions",
}
_LABELS: Final = {
    "growth-rate": "growth rate (1/s)",
    "critical-mu": "μ_c",
    "unstable-modes": "unstable modes",
    "safe-mu": "safe μ",
    "coexistence": "escapes from (m)",
}
_MOST: Final = 1_000_000
_DIGITS: Final = 9
# From the most stable to the fastest growing; then no value.
_STABLE: Final = (":", "·", " ")
_UNSTABLE: Final = ("░", "▒", "▓", "█")


def map_request(text: str, value: str) -> "tuple[NamedRange, NamedRange]":
    """Parse the two ranges of a map, such as ``μ=0:1.5:121 F=5:120:93``; the first is along x."""
    from fivtui.maps import check_map
    from fivtui.ranges import parse_ranges

    words = plain_names(text).split()
    if len(words) != 2:
        raise InputError(f"{text!r}: must be two ranges, e.g. {EXAMPLE}")
    try:
        first, second = parse_ranges("map", words)
    except InputError as error:
        raise InputError(str(error).removeprefix("map ")) from None
    names = (first.name, second.name)
    if value in WITHOUT_MU and "mu" in names:
        raise InputError(
            f"{VALUES[value]} does not depend on μ: must be over others, e.g. {EXAMPLE_WITHOUT_MU}"
        )
    check_map(value, names)
    if first.count * second.count > _MOST:
        raise InputError(f"{first.count * second.count} points: must be at most {_MOST}")
    return first, second


def values_in(given: "NamedRange", axis: Axis | None) -> FloatArray:
    """The values of a range, or as many between chosen axis limits."""
    if axis is None:
        return given.values()
    spec = ALL_PARAMETERS[given.name]
    low, high = max(axis.low, spec.lower), min(axis.high, spec.upper)
    if low >= high:
        return given.values()
    space = np.geomspace if axis.log and low > 0.0 else np.linspace
    values: FloatArray = space(low, high, given.count)
    return values


def map_chart(result: "StabilityMap", now: Parameters | None) -> Chart:
    """A map as shades, with the boundary of stability and the edited point."""
    first, second = result.names
    x, y = result.axes
    regions = result.values
    grids = [result.values, result.excess, regions]
    unknown = result.unknown
    if result.value == "coexistence":
        grids[0] = offsets(result)
    if x[0] > x[-1]:
        x, grids, unknown = x[::-1], [grid[::-1] for grid in grids], unknown[::-1]
    if y[0] > y[-1]:
        y, grids, unknown = y[::-1], [grid[:, ::-1] for grid in grids], unknown[:, ::-1]
    values, excess, regions = grids
    levels, shades, scale = _graded_by_kind(result.value, values, regions, unknown)
    across, up = boundary(x, y, excess)
    traces = [Trace("boundary", across, up, look="dots", ordered=False)]
    if now is not None:
        here = np.array([getattr(now, first)]), np.array([getattr(now, second)])
        traces.append(Trace("now", *here, look="points", ordered=False, mark="◆"))
    backdrop = Backdrop(
        x,
        y,
        levels,
        shades,
        values,
        _LABELS[result.value],
        scale,
        missing={shades.index(UNKNOWN_VALUE): scale[-1]} if unknown.any() else {},
    )
    return Chart(
        _axis(first),
        _axis(second),
        tuple(traces),
        backdrop=backdrop,
        note=_LABELS[result.value],
        x_range=(float(x[0]), float(x[-1])),
        y_range=(float(y[0]), float(y[-1])),
    )


def map_scale(result: "StabilityMap") -> str:
    """What the shades of a map mean, in words."""
    values = offsets(result) if result.value == "coexistence" else result.values
    return scale_words(*_graded_by_kind(result.value, values, result.values, result.unknown)[1:])


def _graded_by_kind(
    value: str, values: FloatArray, regions: FloatArray, unknown: NDArray[np.bool_]
) -> tuple[NDArray[np.intp], Sequence[tuple[str, str]], Sequence[str]]:
    # Levels, shades and scale.
    if value == "coexistence":
        shading = region_shades(regions, values)
    else:
        levels, shades = _shades(value, values)
        shading = levels, shades, value_scale(levels, shades, values)
    return with_unknown(*shading, unknown) if unknown.any() else shading


def _axis(name: str) -> str:
    unit = ALL_PARAMETERS[name].unit
    return f"{symbol_of(name)} ({unit})" if unit else symbol_of(name)


def _shades(value: str, values: FloatArray) -> tuple[NDArray[np.intp], Sequence[tuple[str, str]]]:
    missing = np.isnan(values)
    known = values[~missing]
    if value == "growth-rate":
        shades = [*((s, "stable") for s in _STABLE), *((s, "unstable") for s in _UNSTABLE)]
        decay = max(-float(known.min(initial=0.0)), np.finfo(float).tiny)
        growth = max(float(known.max(initial=0.0)), np.finfo(float).tiny)
        stable = len(_STABLE) - 1 - np.floor(np.nan_to_num(-values / decay) * len(_STABLE))
        unstable = len(_STABLE) + np.floor(np.nan_to_num(values / growth) * len(_UNSTABLE))
        levels = np.where(
            np.nan_to_num(values) < 0.0,
            np.clip(stable, 0, len(_STABLE) - 1),
            np.clip(unstable, len(_STABLE), len(shades) - 1),
        )
    elif value == "unstable-modes":
        shades = [(_STABLE[1], "stable"), (_UNSTABLE[1], "unstable")]
        levels = np.clip(np.nan_to_num(values), 0, 1)
    else:
        return graded(values)
    shades.append(NO_VALUE)
    return np.where(missing, len(shades) - 1, levels).astype(np.intp), tuple(shades)


def boundary(x: FloatArray, y: FloatArray, excess: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Zero crossings of `excess`, shape (n, k), on the grid lines, by linear interpolation."""
    return _merged(_along(x, y, excess), _along(y, x, excess.T)[::-1])


def _along(x: FloatArray, y: FloatArray, excess: FloatArray) -> tuple[FloatArray, FloatArray]:
    with np.errstate(invalid="ignore"):
        row, column = np.nonzero((excess[:-1] > 0.0) != (excess[1:] > 0.0))
    low, high = excess[row, column], excess[row + 1, column]
    kept = np.isfinite(low) & np.isfinite(high)
    row, column, low, high = row[kept], column[kept], low[kept], high[kept]
    part = low / (low - high)
    return x[row] + part * (x[row + 1] - x[row]), y[column]


def _merged(
    one: tuple[FloatArray, FloatArray], other: tuple[FloatArray, ...]
) -> tuple[FloatArray, FloatArray]:
    return np.concatenate([one[0], other[0]]), np.concatenate([one[1], other[1]])


def point_texts(result: "StabilityMap", point: NearestPoint) -> dict[str, str]:
    """Field texts of a point of a map: all parameters and separation."""
    places = (float(f"{value:.{_DIGITS}g}") for value in (point.x, point.y))
    values = result.parameters.as_dict() | dict(zip(result.names, places, strict=True))
    texts = {name: number_text(value) for name, value in values.items()}
    return texts | {"separation": CONSIDERED if result.separation else IGNORED}


def point_words(result: "StabilityMap", point: NearestPoint) -> str:
    """The coordinates of a point of a map in words."""
    texts = point_texts(result, point)
    return ", ".join(f"{symbol_of(name)} = {texts[name]}" for name in result.names)
