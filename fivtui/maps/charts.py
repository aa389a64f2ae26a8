"""Chart of a map over two parameters."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.charts import (
    NO_VALUE,
    Backdrop,
    Chart,
    ColourScale,
    Contours,
    Label,
    Levels,
    Shade,
    Shades,
    Sheet,
    Trace,
    axis_label,
    colour_scale_of,
    column_label,
    grade_values,
    label_shades,
    parameter_text,
    rank_levels,
    value_label,
)
from fivtui.model import Parameters

from .result import NOT_KNOWN, REGIONS, MapValue, StabilityMap
from .stability import WITHOUT_MU

FloatArray = NDArray[np.float64]

_SIZE: Final = (5.2, 4.2)
_LABELS: Final[Mapping[MapValue, str]] = {
    "growth-rate": "growth rate (1/s)",
    "critical-mu": "μ_c",
    "unstable-modes": "unstable modes",
    "safe-mu": "safe μ",
    "coexistence": "escapes from (m)",
}
# From the most stable to the fastest growing.
_STABLE: Final = tuple(Shade(character, "stable") for character in ":· ")
_UNSTABLE: Final = tuple(Shade(character, "unstable") for character in "░▒▓█")
_MODES: Final = (_STABLE[1], _UNSTABLE[1])
_NOT_KNOWN: Final = Shade("×", "hidden", fill="0.65", name=NOT_KNOWN, missing_text=NOT_KNOWN)
_SAFE: Final = Shade("·", "stable", "safe", fill="#e8f1ea", name=REGIONS[0])
# From the largest displacements to the smallest.
_KNOCK: Final = tuple(
    Shade(character, "trace-2", fill="#f7d9a0", name=REGIONS[1]) for character in "░▒▓"
)
_SQUEALS: Final = Shade("█", "unstable", "squeals", fill="#d98880", name=REGIONS[2])
# Smallest relative step between two shades: displacements are accurate to 2 %.
_LEAST_KNOCK: Final = 0.04
# Contours of the displacement, per decade.
_STEPS: Final = (1.0, 2.0, 5.0)


def map_chart(result: StabilityMap, edited: Parameters | None = None) -> Chart:
    """A map as shades, with the boundary of stability and the edited point."""
    first, second = result.names
    # Shades need ascending axes.
    ascending = tuple(slice(None, None, -1 if axis[0] > axis[-1] else 1) for axis in result.axes)
    x, y = (axis[part] for axis, part in zip(result.axes, ascending, strict=True))
    values = offsets(result) if result.value == "coexistence" else result.values
    levels, shades = _levels(result, values)
    column = result.column
    label = Label(_LABELS[result.value], column_label(column.meaning, column.unit).math)
    contours = [replace(c, values=c.values[ascending]) for c in _contours(result)]
    name = "stability boundary"
    if result.value == "critical-mu" and "mu" not in result.names:
        name += f", {value_label('mu', result.parameters.mu)}"
    traces = [
        Trace(
            Label("boundary", name),
            *_zeros(x, y, result.excess[ascending]),
            look="dots",
            ordered=False,
            role="boundary",
        )
    ]
    if edited is not None:
        point = np.array([getattr(edited, first)]), np.array([getattr(edited, second)])
        traces.append(Trace("now", *point, look="points", ordered=False, mark="◆"))
    return Chart(
        axis_label(result.grid.specs[0]),
        axis_label(result.grid.specs[1]),
        tuple(traces),
        backdrop=Backdrop(x, y, levels[ascending], shades, values[ascending], label, contours),
        colour_scale=_colours(result, label),
        note=label,
        x_range=(float(x[0]), float(x[-1])),
        y_range=(float(y[0]), float(y[-1])),
        log="x" * is_logarithmic(x) + "y" * is_logarithmic(y),
    )


def map_sheet(result: StabilityMap) -> Sheet:
    """The map in colours, with the stability boundary, or the basis of safe friction."""
    chart = map_chart(result)
    unused = ("mu",) if result.value in WITHOUT_MU else ()
    title = parameter_text(result.parameters, (*result.names, *unused))
    if result.of_safety:
        chart = replace(chart, traces=())
        title += f"\ncycles by {result.basis}"
    return Sheet([[chart]], _SIZE, title)


def offsets(result: StabilityMap) -> FloatArray:
    """Displacements from rest that escape, m: zero where the slider squeals, NaN where it is safe.

    Infinite where a limit cycle coexists and no tested displacement reaches it.
    """
    regions = result.values
    escape = np.full(regions.shape, np.nan) if result.escape is None else result.escape
    inside = np.where(np.isnan(escape), np.inf, escape)
    return np.where(regions == 2.0, 0.0, np.where(regions == 1.0, inside, np.nan))


def is_logarithmic(values: FloatArray) -> bool:
    """Whether three or more values are spaced logarithmically."""
    if values.size < 3 or values.min() <= 0.0:
        return False
    steps = np.diff(np.log(values))
    return bool(np.allclose(steps, steps[0], rtol=1e-6))


def _colours(result: StabilityMap, label: str) -> ColourScale | None:
    if result.value == "coexistence":
        return None
    if result.value == "unstable-modes":
        return ColourScale(label, ("white", "#f2b48a"), -0.5, 1.5, (0.0, 1.0))
    if result.value == "growth-rate":
        # Zero, the limit of stability, is the middle of the colours.
        magnitudes = np.abs(result.values[np.isfinite(result.values)])
        largest = max(float(magnitudes.max(initial=0.0)), np.finfo(float).tiny)
        return ColourScale(label, "RdBu_r", -largest, largest)
    return colour_scale_of(label, result.values)


def _contours(result: StabilityMap) -> list[Contours]:
    """Contour lines, for reading the map without colours."""
    if result.value == "safe-mu":
        share = result.safe_mu / result.critical_mu
        return [
            Contours(result.safe_mu, label="%.3g"),
            Contours(share, [0.99], "nearly", _in_math("1 % below the critical μ")),
            Contours(share, [0.5], "half", _in_math("half the critical μ")),
        ]
    if result.value == "coexistence" and result.escape is not None:
        finite = result.escape[np.isfinite(result.escape)]
        ends = np.floor(np.log10([finite.min(), finite.max()])) if finite.size else (0, -1)
        decades = range(int(ends[0]), int(ends[1]) + 1)
        levels = [step * 10.0**decade for decade in decades for step in _STEPS]
        name = "offset from rest that escapes"
        return [Contours(result.escape, levels, name=name, label="%g m")] if levels else []
    if result.value in ("growth-rate", "critical-mu"):
        return [Contours(result.values, label="%g")]
    return []


def _in_math(text: str) -> Label:
    return Label(text, text.replace("μ", "$\\mu$"))


def _levels(result: StabilityMap, values: FloatArray) -> tuple[Levels, Shades]:
    """The level of every point, and the shade of every level."""
    missing = np.isnan(result.values)
    if result.value == "coexistence":
        levels, shades = region_levels(result.values, values)
    elif result.value == "growth-rate":
        shades = (*_STABLE, *_UNSTABLE)
        middle = len(_STABLE)
        finite = values[~missing]
        decay = max(-float(finite.min(initial=0.0)), np.finfo(float).tiny)
        growth = max(float(finite.max(initial=0.0)), np.finfo(float).tiny)
        rates = np.nan_to_num(values)
        stable = middle - 1 - np.floor(-rates / decay * middle)
        unstable = middle + np.floor(rates / growth * len(_UNSTABLE))
        levels = np.where(
            rates < 0.0,
            np.clip(stable, 0, middle - 1),
            np.clip(unstable, middle, len(shades) - 1),
        )
    elif result.value == "unstable-modes":
        shades, levels = _MODES, np.clip(np.nan_to_num(values), 0, 1)
    else:
        levels, (*shades, _) = grade_values(values)
    levels = np.where(missing, len(shades), levels)
    levels = np.where(result.unknown, len(shades) + 1, levels).astype(np.intp)
    name = "none" if result.value in WITHOUT_MU else "no equilibrium"
    without = NO_VALUE._replace(text=result.missing, name=name)
    return levels, label_shades(levels, (*shades, without, _NOT_KNOWN), values)


def region_levels(regions: FloatArray, escape: FloatArray) -> tuple[Levels, Shades]:
    """Levels and shades of the three regions; the region of coexistence is graded by `escape`."""
    inside = (regions == 1.0) & np.isfinite(escape)
    knock = np.ones(regions.shape, dtype=np.intp)
    knock[inside] += rank_levels(-escape[inside], len(_KNOCK), _LEAST_KNOCK)
    squeals = 1 + len(_KNOCK)
    levels = np.where(regions == 0.0, 0, np.where(regions == 2.0, squeals, knock))
    least = [escape[inside & (levels == level)].min(initial=np.inf) for level in range(1, squeals)]
    texts = [f"≥{low:.2g} m" if np.isfinite(low) else "squeals after a knock" for low in least]
    graded_knock = [shade._replace(text=text) for shade, text in zip(_KNOCK, texts, strict=True)]
    return levels, (_SAFE, *graded_knock, _SQUEALS)


def _zeros(x: FloatArray, y: FloatArray, excess: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Contour lines of zero excess, by linear interpolation; NaN separates the lines."""
    from contourpy import contour_generator

    values = np.ma.masked_invalid(excess.T)
    lines = contour_generator(x, y, values, corner_mask=True).lines(0.0)
    gap = np.full((1, 2), np.nan)
    points = np.concatenate([gap[:0], *(part for line in lines for part in (line, gap))])[:-1]
    return points[:, 0], points[:, 1]
