"""Chart of a map over two parameters: shaded levels with contour lines.

A level is the index of a shade. In the terminal a shade is a character, in a figure a colour. The
excess of a map is above zero where the equilibrium is unstable: its zero is the stability boundary.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final

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
    figure_colour,
    grade_values,
    label_shades,
    math_symbol,
    meaning_label,
    parameter_text,
    rank_levels,
    value_label,
)
from fivtui.model import Parameters

from .result import (
    KNOCK_REGION,
    NOT_KNOWN,
    REGIONS,
    SAFE_REGION,
    SQUEAL_REGION,
    MapValue,
    StabilityMap,
)
from .stability import MU_FREE_VALUES

FloatArray = NDArray[np.float64]

# Width and height of a figure, inches.
_FIGURE_SIZE: Final = (5.2, 4.2)
# Labels in the terminal; figures have the meanings of the columns.
_LABELS: Final[Mapping[MapValue, str]] = {
    "growth-rate": "growth rate (1/s)",
    "critical-mu": "μ_c",
    "unstable-modes": "unstable modes",
    "safe-mu": "safe μ",
    "coexistence": "escapes from (m)",
}
# Shades of growth rates, from the fastest decay to the fastest growth.
_STABLE_SHADES: Final = tuple(Shade(character, "safe") for character in ":· ")
_UNSTABLE_SHADES: Final = tuple(Shade(character, "danger") for character in "░▒▓█")
# Shades of zero and of one unstable mode.
_MODE_SHADES: Final = (Shade("·", "safe"), Shade("▒", "danger"))
_NOT_KNOWN_SHADE: Final = Shade("×", "ghost", fill="0.65", name=NOT_KNOWN, missing_text=NOT_KNOWN)
_SAFE_SHADE: Final = Shade(
    "·", "safe", "safe", fill=figure_colour("safe", 0.12), name=REGIONS[SAFE_REGION]
)
# Shades of the region of coexistence, from the largest to the smallest displacement that escapes.
_KNOCK_SHADES: Final = tuple(
    Shade(character, "warning", fill=figure_colour("warning", 0.4), name=REGIONS[KNOCK_REGION])
    for character in "░▒▓"
)
_SQUEAL_SHADE: Final = Shade(
    "█", "danger", "squeals", fill=figure_colour("danger", 0.6), name=REGIONS[SQUEAL_REGION]
)
# Least relative step between two shades, twice the accuracy of displacements.
_LEAST_STEP: Final = 0.04
# Contours of displacements in each decade, relative to its lower end.
_CONTOUR_STEPS: Final = (1.0, 2.0, 5.0)
# Contours of safe μ relative to critical μ, their names in the terminal and in figures.
_SAFE_SHARES: Final = (
    (0.99, "99 % of critical μ", "1 % below the critical μ"),
    (0.5, "50 % of critical μ", "half the critical μ"),
)


def map_chart(result: StabilityMap, edited: Parameters | None = None) -> Chart:
    """A map as shades, with the stability boundary and the point of the edited parameters.

    `edited` are the parameters in the editor.
    """
    x_name, y_name = result.names
    # The axes of shades must ascend: reverse those that descend.
    slices = tuple(slice(None, None, -1 if axis[0] > axis[-1] else 1) for axis in result.axes)
    x, y = (axis[order] for axis, order in zip(result.axes, slices, strict=True))
    values = shown_offsets(result) if result.value == "coexistence" else result.values
    levels, shades = _level_grid(result, values)
    column = result.column
    label = Label(_LABELS[result.value], meaning_label(column.meaning, column.unit).math)
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
        point = np.array([getattr(edited, x_name)]), np.array([getattr(edited, y_name)])
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
    irrelevant = ("mu",) if result.value in MU_FREE_VALUES else ()
    title = parameter_text(result.parameters, (*result.names, *irrelevant))
    if result.of_safety:
        chart = replace(chart, traces=())
        title += f"\nsafe {math_symbol('μ')} by {result.basis}"
    return Sheet([[chart]], _FIGURE_SIZE, title)


def shown_offsets(result: StabilityMap) -> FloatArray:
    """Least displacements from rest that escape, m: zero where the slider squeals, NaN where safe.

    Infinite where a limit cycle coexists and no tested displacement leads to it.
    """
    regions = result.values
    escape = np.full(regions.shape, np.nan) if result.escape is None else result.escape
    knock_offsets = np.where(np.isnan(escape), np.inf, escape)
    offsets = np.where(regions == KNOCK_REGION, knock_offsets, np.nan)
    return np.where(regions == SQUEAL_REGION, 0.0, offsets)


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
        return ColourScale(label, ("white", figure_colour("danger", 0.45)), -0.5, 1.5, (0.0, 1.0))
    if result.value == "growth-rate":
        # Zero, the limit of stability, is the middle of the colours.
        magnitudes = np.abs(result.values[np.isfinite(result.values)])
        largest = max(float(magnitudes.max(initial=0.0)), np.finfo(float).tiny)
        return ColourScale(label, "RdBu_r", -largest, largest)
    return colour_scale_of(label, result.values)


def _contours(result: StabilityMap) -> list[Contours]:
    """Contour lines, with which a map can be read without colours."""
    if result.value == "safe-mu":
        shares = result.safe_mu / result.critical_mu
        share_contours = (
            Contours(shares, [share], name, _mu_label(label)) for share, name, label in _SAFE_SHARES
        )
        return [Contours(result.safe_mu, label="%.3g"), *share_contours]
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
    # A text with μ, which figures print as a symbol.
    return Label(text, text.replace("μ", "$\\mu$"))


def _level_grid(result: StabilityMap, values: FloatArray) -> tuple[Levels, Shades]:
    """The level of every point, and the shade of every level.

    The last two levels are of points that have no value, and of points whose value is not known
    because no search confirms it.
    """
    missing = np.isnan(result.values)
    if result.value == "coexistence":
        levels, shades = region_levels(result.values, values)
    elif result.value == "growth-rate":
        shades = (*_STABLE_SHADES, *_UNSTABLE_SHADES)
        stable_count = len(_STABLE_SHADES)
        finite = values[~missing]
        fastest_decay = max(-float(finite.min(initial=0.0)), np.finfo(float).tiny)
        fastest_growth = max(float(finite.max(initial=0.0)), np.finfo(float).tiny)
        rates = np.nan_to_num(values)
        stable_levels = stable_count - 1 - np.floor(-rates / fastest_decay * stable_count)
        unstable_levels = stable_count + np.floor(rates / fastest_growth * len(_UNSTABLE_SHADES))
        levels = np.where(
            rates < 0.0,
            np.clip(stable_levels, 0, stable_count - 1),
            np.clip(unstable_levels, stable_count, len(shades) - 1),
        )
    elif result.value == "unstable-modes":
        shades, levels = _MODE_SHADES, np.clip(np.nan_to_num(values), 0, 1)
    else:
        # The last shade of graded values is for points without a value.
        levels, (*shades, _) = grade_values(values)
    levels = np.where(missing, len(shades), levels)
    levels = np.where(result.unknown, len(shades) + 1, levels).astype(np.intp)
    # Critical and safe μ do not depend on μ; they need not exist. Other values are missing only
    # without an equilibrium.
    name = "none" if result.value in MU_FREE_VALUES else "no equilibrium"
    no_value = NO_VALUE._replace(text=result.missing, name=name)
    return levels, label_shades(levels, (*shades, no_value, _NOT_KNOWN_SHADE), values)


def region_levels(regions: FloatArray, escape: FloatArray) -> tuple[Levels, Shades]:
    """Levels and shades of the three regions.

    The region of coexistence is graded by `escape`, the displacement that escapes, m.
    """
    is_graded = (regions == KNOCK_REGION) & np.isfinite(escape)
    knock_levels = np.ones(regions.shape, dtype=np.intp)
    knock_levels[is_graded] += rank_levels(-escape[is_graded], len(_KNOCK_SHADES), _LEAST_STEP)
    squeal_level = 1 + len(_KNOCK_SHADES)
    levels = np.where(regions == SQUEAL_REGION, squeal_level, knock_levels)
    levels = np.where(regions == SAFE_REGION, 0, levels)
    knock_shades = []
    for level, shade in enumerate(_KNOCK_SHADES, start=1):
        least = escape[is_graded & (levels == level)].min(initial=np.inf)
        text = f"≥{least:.2g} m" if np.isfinite(least) else "squeals after a knock"
        knock_shades.append(shade._replace(text=text))
    return levels, (_SAFE_SHADE, *knock_shades, _SQUEAL_SHADE)


def _zero_lines(x: FloatArray, y: FloatArray, excess: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Contour lines of zero excess, by linear interpolation; NaN separates the lines."""
    from contourpy import contour_generator

    values = np.ma.masked_invalid(excess.T)
    lines: Any = contour_generator(x, y, values, corner_mask=True).lines(0.0)
    if not lines:
        return np.empty(0), np.empty(0)
    gap = np.full((1, 2), np.nan)
    points = np.concatenate([part for line in lines for part in (line, gap)][:-1])
    return points[:, 0], points[:, 1]
