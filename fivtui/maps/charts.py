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
from .stability import MU_FREE_VALUES

FloatArray = NDArray[np.float64]

_SIZE: Final = (5.2, 4.2)
_LABELS: Final[Mapping[MapValue, str]] = {
    "growth-rate": "growth rate (1/s)",
    "critical-mu": "μ_c",
    "unstable-modes": "unstable modes",
    "safe-mu": "safe μ",
    "coexistence": "escapes from (m)",
}
# Shades of growth rates, from the fastest decay to the fastest growth.
_STABLE: Final = tuple(Shade(character, "stable") for character in ":· ")
_UNSTABLE: Final = tuple(Shade(character, "unstable") for character in "░▒▓█")
_MODES: Final = (_STABLE[1], _UNSTABLE[1])
_NOT_KNOWN: Final = Shade("×", "hidden", fill="0.65", name=NOT_KNOWN, missing_text=NOT_KNOWN)
_SAFE: Final = Shade("·", "stable", "safe", fill="#e8f1ea", name=REGIONS[0])
# Shades of displacements that escape, from the largest to the smallest.
_KNOCK: Final = tuple(
    Shade(character, "trace-2", fill="#f7d9a0", name=REGIONS[1]) for character in "░▒▓"
)
_SQUEALS: Final = Shade("█", "unstable", "squeals", fill="#d98880", name=REGIONS[2])
# Least relative step between two shades, twice the accuracy of displacements.
_LEAST_STEP: Final = 0.04
# Contours of displacements in each decade.
_CONTOUR_STEPS: Final = (1.0, 2.0, 5.0)


def map_chart(result: StabilityMap, edited: Parameters | None = None) -> Chart:
    """A map as shades, with the stability boundary and the point of the edited parameters."""
    first, second = result.names
    # The axes of shades must ascend.
    slices = tuple(slice(None, None, -1 if axis[0] > axis[-1] else 1) for axis in result.axes)
    x, y = (axis[part] for axis, part in zip(result.axes, slices, strict=True))
    values = shown_offsets(result) if result.value == "coexistence" else result.values
    levels, shades = _level_grid(result, values)
    column = result.column
    label = Label(_LABELS[result.value], column_label(column.meaning, column.unit).math)
    contours = [replace(lines, values=lines.values[slices]) for lines in _contours(result)]
    name = "stability boundary"
    if result.value == "critical-mu" and "mu" not in result.names:
        name += f", {value_label('mu', result.parameters.mu)}"
    traces = [
        Trace(
            Label("boundary", name),
            *_zero_lines(x, y, result.excess[slices]),
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
        backdrop=Backdrop(x, y, levels[slices], shades, values[slices], label, contours),
        colour_scale=_colours(result, label),
        note=label,
        x_range=(float(x[0]), float(x[-1])),
        y_range=(float(y[0]), float(y[-1])),
        log="x" * is_logarithmic(x) + "y" * is_logarithmic(y),
    )


def map_sheet(result: StabilityMap) -> Sheet:
    """The map in colours, with the stability boundary or, in the title, the basis of safe μ."""
    chart = map_chart(result)
    unused = ("mu",) if result.value in MU_FREE_VALUES else ()
    title = parameter_text(result.parameters, (*result.names, *unused))
    if result.of_safety:
        chart = replace(chart, traces=())
        title += f"\ncycles by {result.basis}"
    return Sheet([[chart]], _SIZE, title)


def shown_offsets(result: StabilityMap) -> FloatArray:
    """Least displacements from rest that escape, m: zero where the slider squeals, NaN where safe.

    Infinite where a limit cycle coexists and no tested displacement leads to it.
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
    """Contour lines, with which a map can be read without colours."""
    if result.value == "safe-mu":
        share = result.safe_mu / result.critical_mu
        return [
            Contours(result.safe_mu, label="%.3g"),
            Contours(share, [0.99], "99 % of critical μ", _mu_label("1 % below the critical μ")),
            Contours(share, [0.5], "50 % of critical μ", _mu_label("half the critical μ")),
        ]
    if result.value == "coexistence" and result.escape is not None:
        finite = result.escape[np.isfinite(result.escape)]
        ends = np.floor(np.log10([finite.min(), finite.max()])) if finite.size else (0, -1)
        decades = range(int(ends[0]), int(ends[1]) + 1)
        levels = [step * 10.0**decade for decade in decades for step in _CONTOUR_STEPS]
        name = "offset from rest that escapes"
        return [Contours(result.escape, levels, name=name, label="%g m")] if levels else []
    if result.value in ("growth-rate", "critical-mu"):
        return [Contours(result.values, label="%g")]
    return []


def _mu_label(text: str) -> Label:
    return Label(text, text.replace("μ", "$\\mu$"))


def _level_grid(result: StabilityMap, values: FloatArray) -> tuple[Levels, Shades]:
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
        stable_levels = middle - 1 - np.floor(-rates / decay * middle)
        unstable_levels = middle + np.floor(rates / growth * len(_UNSTABLE))
        levels = np.where(
            rates < 0.0,
            np.clip(stable_levels, 0, middle - 1),
            np.clip(unstable_levels, middle, len(shades) - 1),
        )
    elif result.value == "unstable-modes":
        shades, levels = _MODES, np.clip(np.nan_to_num(values), 0, 1)
    else:
        levels, (*shades, _) = grade_values(values)
    levels = np.where(missing, len(shades), levels)
    levels = np.where(result.unknown, len(shades) + 1, levels).astype(np.intp)
    name = "none" if result.value in MU_FREE_VALUES else "no equilibrium"
    no_value = NO_VALUE._replace(text=result.missing, name=name)
    return levels, label_shades(levels, (*shades, no_value, _NOT_KNOWN), values)


def region_levels(regions: FloatArray, escape: FloatArray) -> tuple[Levels, Shades]:
    """Levels and shades of the three regions; the region of coexistence is graded by `escape`."""
    inside = (regions == 1.0) & np.isfinite(escape)
    knock_levels = np.ones(regions.shape, dtype=np.intp)
    knock_levels[inside] += rank_levels(-escape[inside], len(_KNOCK), _LEAST_STEP)
    squeals = 1 + len(_KNOCK)
    levels = np.where(regions == 0.0, 0, np.where(regions == 2.0, squeals, knock_levels))
    least = [escape[inside & (levels == level)].min(initial=np.inf) for level in range(1, squeals)]
    texts = [f"≥{low:.2g} m" if np.isfinite(low) else "squeals after a knock" for low in least]
    knock_shades = [shade._replace(text=text) for shade, text in zip(_KNOCK, texts, strict=True)]
    return levels, (_SAFE, *knock_shades, _SQUEALS)


def _zero_lines(x: FloatArray, y: FloatArray, excess: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Contour lines of zero excess, by linear interpolation; NaN separates the lines."""
    from contourpy import contour_generator

    values = np.ma.masked_invalid(excess.T)
    lines = contour_generator(x, y, values, corner_mask=True).lines(0.0)
    gap = np.full((1, 2), np.nan)
    points = np.concatenate([gap[:0], *(part for line in lines for part in (line, gap))])[:-1]
    return points[:, 0], points[:, 1]
