"""Chart of a map over two parameters: shaded levels with contour lines.

A level is the index of a shade. In the terminal a shade is a character, in a figure a colour. The
excess of a map is above zero where the equilibrium is unstable: its zero is the stability boundary.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.charts import (
    NO_VALUE,
    STRONG,
    Backdrop,
    Band,
    Chart,
    Contours,
    Grading,
    Label,
    Shade,
    Shades,
    Sheet,
    Trace,
    axis_label,
    grade,
    grade_values,
    hide_unused,
    math_symbol,
    meaning_label,
    parameter_text,
    plateau_labels,
    shade_bands,
    value_label,
)
from fivtui.model import Parameters, time_scale

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
# Shade of growth rates that are zero but for rounding, and the largest such rate over the time in
# which a vibration without damping turns by a radian.
_NEUTRAL_SHADE: Final = Shade("=", "warning", "0")
_ZERO_GROWTH: Final = 1e-9
# Shades of zero and of one unstable mode.
_MODE_SHADES: Final = (Shade("·", "safe", "0"), Shade("▒", "danger", "1"))
_NOT_KNOWN_SHADE: Final = Shade("×", "ghost", name=NOT_KNOWN, missing_text=NOT_KNOWN, strength=0.6)
_SAFE_SHADE: Final = Shade("·", "safe", "safe", REGIONS[SAFE_REGION])
# Shades of the region of coexistence, from the smallest to the largest displacement that escapes.
_KNOCK_SHADES: Final = tuple(
    Shade(character, "warning", name=REGIONS[KNOCK_REGION], strength=0.4) for character in "▓▒░"
)
_SQUEAL_SHADE: Final = Shade("█", "danger", "squeals", REGIONS[SQUEAL_REGION], strength=0.6)
# Least difference between two shades relative to the greatest displacement: twice the accuracy.
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
    grading, shades = _grade(result, values)
    # The grading along ascending axes.
    grading = grading._replace(levels=grading.levels[slices])
    column = result.column
    label = Label(_LABELS[result.value], meaning_label(column.meaning, column.unit).math)
    contours = [
        replace(lines, values=lines.values[slices]) for lines in _contours(result, grading.bounds)
    ]
    boundary_x, boundary_y = _zero_lines(x, y, result.excess[slices])
    # NaN separates lines.
    name = "boundaries" if np.isnan(boundary_x).any() else "boundary"
    figure_name = f"stability {name}"
    if "mu" not in result.names:
        name += f" at μ = {result.parameters.mu:g}"
        figure_name += f", {value_label('mu', result.parameters.mu)}"
    traces = [
        Trace(
            Label(name, figure_name),
            boundary_x,
            boundary_y,
            look="dots",
            ordered=False,
            colour=STRONG,
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
        backdrop=Backdrop(
            x,
            y,
            grading.levels,
            hide_unused(grading.levels, shades),
            values[slices],
            label,
            contours,
            plateau_labels(x, y, grading),
        ),
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


def _contours(result: StabilityMap, bounds: Sequence[float]) -> list[Contours]:
    """Contour lines, to read a map without colours: at bounds of levels, or at round values."""
    if result.value == "safe-mu":
        shares = result.safe_mu / result.critical_mu
        share_contours = (
            Contours(shares, [share], name, _mu_label(label)) for share, name, label in _SAFE_SHARES
        )
        return [Contours(result.safe_mu, bounds, label="%g"), *share_contours]
    if result.value == "coexistence" and result.escape is not None:
        finite = result.escape[np.isfinite(result.escape)]
        ends = np.floor(np.log10([finite.min(), finite.max()])) if finite.size else (0, -1)
        decades = range(int(ends[0]), int(ends[1]) + 1)
        levels = [step * 10.0**decade for decade in decades for step in _CONTOUR_STEPS]
        name = "offset from rest that escapes"
        return [Contours(result.escape, levels, name=name, label="%g m")] if levels else []
    if result.value in ("growth-rate", "critical-mu"):
        return [Contours(result.values, bounds, label="%g")]
    return []


def _mu_label(text: str) -> Label:
    # A text with μ, which figures print as a symbol.
    return Label(text, text.replace("μ", "$\\mu$"))


def _grade(result: StabilityMap, values: FloatArray) -> tuple[Grading, Shades]:
    """The level of every point, and the shade of every level.

    The last two levels are of points that have no value, and of points whose value is not known
    because no search confirms it.
    """
    missing = np.isnan(result.values)
    if result.value == "coexistence":
        grading, shades = grade_regions(result.values, values)
    elif result.value == "growth-rate":
        grading, shades = _grade_growth(values, time_scale(result.parameters))
    elif result.value == "unstable-modes":
        levels = np.clip(np.nan_to_num(values), 0, 1).astype(np.intp)
        grading, shades = Grading(levels, [], []), _MODE_SHADES
    else:
        # The last shade of graded values is for points without a value.
        grading, (*shades, _) = grade_values(values)
    levels = np.where(missing, len(shades), grading.levels)
    levels = np.where(result.unknown, len(shades) + 1, levels).astype(np.intp)
    # Critical and safe μ do not depend on μ; they need not exist. Other values are missing only
    # without a verdict.
    name = "none" if result.value in MU_FREE_VALUES else "no verdict"
    no_value = NO_VALUE._replace(text=result.missing, name=name)
    return grading._replace(levels=levels), (*shades, no_value, _NOT_KNOWN_SHADE)


def _grade_growth(rates: FloatArray, time_unit: float) -> tuple[Grading, Shades]:
    # Levels of decay, of zero and of growth; rates up to `_ZERO_GROWTH` over the time are zero.
    zero = _ZERO_GROWTH / time_unit
    decay = grade(np.where(rates < -zero, rates, np.nan), len(_STABLE_SHADES), log=False)
    growth = grade(np.where(rates > zero, rates, np.nan), len(_UNSTABLE_SHADES), log=False)
    bands = [*decay.bands, Band(None, None, 0.0), *growth.bands]
    levels = np.where(rates > zero, len(decay.bands) + 1 + growth.levels, decay.levels)
    decay_texts = [band.text() if band.upper is not None else "<0" for band in decay.bands]
    shades = (
        *shade_bands(_STABLE_SHADES, decay_texts),
        _NEUTRAL_SHADE,
        *shade_bands(_UNSTABLE_SHADES, [band.text() for band in growth.bands]),
    )
    # Decay beside a plateau falls to zero at the stability boundary, which is a line of its own.
    has_plateau = any(band.plateau is not None for band in decay.bands)
    return Grading(levels, bands, [*([] if has_plateau else decay.bounds), *growth.bounds]), shades


def grade_regions(regions: FloatArray, escape: FloatArray) -> tuple[Grading, Shades]:
    """Levels and shades of the three regions.

    The region of coexistence is graded by `escape`, the displacement that escapes, m.
    """
    is_graded = (regions == KNOCK_REGION) & np.isfinite(escape)
    knock = grade(np.where(is_graded, escape, np.nan), len(_KNOCK_SHADES), _LEAST_STEP)
    knock_shades = shade_bands(_KNOCK_SHADES, [_escape_text(band) for band in knock.bands])
    # Points without a value are where no tested displacement escapes.
    far_shade = _KNOCK_SHADES[-1]._replace(text=REGIONS[KNOCK_REGION])
    shades = (_SAFE_SHADE, *knock_shades, far_shade, _SQUEAL_SHADE)
    levels = np.where(regions == SQUEAL_REGION, len(shades) - 1, 1 + knock.levels)
    levels = np.where(regions == SAFE_REGION, 0, levels)
    return Grading(levels, [], []), shades


def _escape_text(band: Band) -> str:
    # Displacements of a level in the region of coexistence.
    if band.plateau is not None:
        return f"{band.plateau:.2g} m"
    return f"<{band.upper:.2g} m" if band.lower is None else f"≥{band.lower:.2g} m"


def _zero_lines(x: FloatArray, y: FloatArray, excess: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Contour lines of zero excess, by linear interpolation; NaN separates the lines."""
    from contourpy import contour_generator

    lines: Any = ()
    # A single row or column of points has no lines.
    if min(excess.shape) > 1:
        values = np.ma.masked_invalid(excess.T)
        lines = contour_generator(x, y, values, corner_mask=True).lines(0.0)
    if not lines:
        return np.empty(0), np.empty(0)
    gap = np.full((1, 2), np.nan)
    points = np.concatenate([part for line in lines for part in (line, gap)][:-1])
    return points[:, 0], points[:, 1]
