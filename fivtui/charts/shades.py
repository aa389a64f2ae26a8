"""Levels of the values over a plane, their shades, and scales of colours.

A map assigns a level to each point: the index of its shade. Levels are divided by round numbers;
nearly equal values share a level.
"""

from collections.abc import Sequence
from itertools import pairwise, product
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .axis import Axis
from .colours import figure_colour
from .plot_data import round_ticks

FloatArray = NDArray[np.float64]
Levels = NDArray[np.intp]

# Smallest displayed difference relative to the greatest value: that of numbers with three digits.
_MIN_CONTRAST: Final = 1e-3
# A plateau is a level of nearly equal values with at least this share of all values, and at least
# this many if there are more.
_PLATEAU_SHARE: Final = 1.0 / 6.0
_MIN_PLATEAU_SIZE: Final = 3
# Bounds are at 1, 2 and 5 times powers of ten from this ratio of the values on, else evenly spaced.
_LOG_RATIO: Final = 20.0
_MAX_LOG_RATIO: Final = 1e6
# Values up to this part of the greatest are zero but for rounding.
_ROUNDING: Final = 1e-9
# Largest distance between a round number and the bound that replaces it, relative to the smallest
# displayed difference.
_MAX_SHIFT: Final = 1.5
# Strength of the colours of shades in figures by character.
_STRENGTHS: Final = {
    " ": 0.0, "·": 0.15, ":": 0.3, "?": 0.35, "=": 0.4, "×": 0.6,
    "░": 0.35, "▒": 0.5, "▓": 0.65, "█": 0.85,
}  # fmt: skip


class Shade(NamedTuple):
    """How the points of a level are drawn.

    Attributes
    ----------
    character, style : str
        Character in the terminal, and the role of its colour.
    text : str
        Values of the level as text; empty if no point has this level.
    name : str
        Entry in the legend of figures; shades of the same name look the same. Shades without name
        are in a bar of colours beside the figure.
    hatch : str
        Matplotlib's hatching in figures.
    missing_text : str
        Displayed at a cursor in place of a value, if points of the level have none.
    strength : float, optional
        Strength of the colour in figures, from 0 (that of the background) to 1; by default it is
        less for lighter characters.
    """

    character: str
    style: str
    text: str = ""
    name: str = ""
    hatch: str = ""
    missing_text: str = "none"
    strength: float | None = None

    @property
    def figure_colour(self) -> str:
        """The colour in figures."""
        strength = _STRENGTHS[self.character] if self.strength is None else self.strength
        return figure_colour(self.style, strength)


Shades = Sequence[Shade]
# Swatch of a shade whose character is a blank.
BLANK: Final = "blank"
# Shade of points without value, and shades of values from small to great.
NO_VALUE: Final = Shade("?", "ghost", name="no value", strength=0.25)
_GRADES: Final = tuple(Shade(character, "series-1") for character in " ·░▒▓█")


class ColourScale(NamedTuple):
    """A scale of colours in figures.

    Attributes
    ----------
    label : str
        Quantity and unit of the values, beside the bar of colours.
    colour_map : str or tuple of str
        Name of a colour map of matplotlib, or the colours from low to high.
    low, high : float
        Values at the ends.
    ticks : tuple of float
        Labelled values; if empty, matplotlib chooses them.
    names : tuple of str
        Labels of these values; if empty, the values themselves.
    """

    label: str
    colour_map: str | tuple[str, ...]
    low: float
    high: float
    ticks: tuple[float, ...] = ()
    names: tuple[str, ...] = ()


class Band(NamedTuple):
    """The values of a level.

    Attributes
    ----------
    lower, upper : float or None
        Bounds; None if there is no level beyond. The greatest value bounds a single level.
    plateau : float or None
        The value of a plateau, at which all values of the level are.
    """

    lower: float | None
    upper: float | None
    plateau: float | None

    def text(self) -> str:
        """The values as text: that of a plateau, or else the upper bound."""
        if self.plateau is not None:
            return _value_text(self.plateau)
        if self.upper is None:
            return f">{_value_text(self.lower or 0.0)}"
        return f"≤{_value_text(self.upper)}"


def _value_text(value: float) -> str:
    # A number with three digits; without exponent from 0.0001 up to 1e6.
    return f"{float(f'{value:.3g}'):g}"


class Grading(NamedTuple):
    """Values in levels: the level of every value, and the bands and round bounds of levels.

    The level of values that are not finite is the number of bands.
    """

    levels: Levels
    bands: list[Band]
    bounds: list[float]


def colour_scale_of(label: str, values: FloatArray) -> ColourScale:
    """A scale from the least to the greatest value, at least `_MIN_CONTRAST` of them apart."""
    finite = values[np.isfinite(values)]
    if not finite.size:
        return ColourScale(label, "viridis", 0.0, 1.0)
    low, high = float(finite.min()), float(finite.max())
    margin = max(0.5 * (_MIN_CONTRAST * max(abs(low), abs(high)) - (high - low)), 0.0)
    return ColourScale(label, "viridis", low - margin, high + margin)


def grade(
    values: FloatArray, count: int, contrast: float = _MIN_CONTRAST, *, log: bool = True
) -> Grading:
    """Divide values into at most `count` levels at round numbers, and around plateaus.

    Round numbers do not divide a group of values that differ by less than `contrast`, relative to
    them. With `log`, they are logarithmic for values of different magnitudes.
    """
    finite = np.isfinite(values)
    ascending = np.sort(values[finite])
    levels = np.zeros(values.shape, dtype=np.intp)
    if not ascending.size:
        return Grading(levels, [], [])
    plateaus = _find_plateaus(ascending, contrast)
    # Use as many plateaus as possible, the largest first, then as many bounds as possible.
    for plateau_count, bound_count in product(
        range(len(plateaus), -1, -1), range(count - 1, -1, -1)
    ):
        shown_plateaus = plateaus[:plateau_count]
        bounds = _round_bounds(ascending, bound_count, contrast, shown_plateaus, log=log)
        cuts, bands = _divide(ascending, bounds, contrast, shown_plateaus)
        if len(bands) <= count:
            break
    levels[finite] = np.searchsorted(cuts, values[finite], side="right")
    levels[~finite] = len(bands)
    return Grading(levels, bands, bounds)


def _find_plateaus(ascending: FloatArray, contrast: float) -> list[tuple[float, float]]:
    # The least and greatest value of each plateau, the largest plateau first. Values that are zero
    # but for rounding are equal.
    size, rounding = ascending.size, _ROUNDING * float(np.abs(ascending).max())
    least_count = min(size, max(_MIN_PLATEAU_SIZE, size * _PLATEAU_SHARE))
    starts = np.arange(size)
    tolerances = contrast * np.abs(ascending) + rounding
    stops = np.searchsorted(ascending, ascending + tolerances, side="right")
    counts = stops - starts
    plateaus = []
    while counts.max() >= least_count:
        start = int(counts.argmax())
        stop = int(stops[start])
        plateaus.append((float(ascending[start]), float(ascending[stop - 1])))
        # Plateaus are disjoint.
        counts[(stops > start) & (starts < stop)] = 0
    return plateaus


def _round_bounds(
    ascending: FloatArray,
    count: int,
    contrast: float,
    plateaus: Sequence[tuple[float, float]],
    *,
    log: bool,
) -> list[float]:
    # Round numbers between the values, but not at plateaus.
    low, high = float(ascending[0]), float(ascending[-1])
    # Numbers this close to zero have too few digits for round ones between them.
    if high - low < np.finfo(float).tiny:
        return []
    count = min(count, int((high - low) / (contrast * max(-low, high))))
    if count < 1:
        return []
    if log and low > 0.0 and _LOG_RATIO <= high / low <= _MAX_LOG_RATIO:
        candidates, _ = Axis(low, high, log=True).ticks(count)
    else:
        candidates = round_ticks(low, high, count)
    return [
        bound
        for bound in candidates
        if low < bound < high
        and not any(
            first - contrast * abs(first) < bound < last + contrast * abs(last)
            for first, last in plateaus
        )
    ]


def _divide(
    ascending: FloatArray,
    bounds: Sequence[float],
    contrast: float,
    plateaus: Sequence[tuple[float, float]],
) -> tuple[list[float], list[Band]]:
    # The least values of all levels but the first, and the bands of the levels.
    # Cuts between levels: the least value above each, and the number in the texts of bands.
    cuts = [(_shift_bound(ascending, bound, contrast), bound) for bound in bounds]
    for first, last in plateaus:
        cuts += [(first, first), (float(np.nextafter(last, np.inf)), last)]
    cuts.sort()
    plateau_ends = dict(plateaus)
    # Omit cuts without values on one side.
    ends = [(-np.inf, -np.inf), *cuts, (np.inf, np.inf)]
    positions = np.searchsorted(ascending, [cut for cut, _ in ends]).tolist()
    levels = [
        (lower, upper)
        for (lower, upper), (start, stop) in zip(pairwise(ends), pairwise(positions), strict=True)
        if stop > start
    ]
    bands = []
    for index, ((cut, lower), (_, upper)) in enumerate(levels):
        plateau_end = plateau_ends.get(cut)
        bands.append(
            Band(
                lower if index else None,
                upper if index < len(levels) - 1 else None,
                None if plateau_end is None else _plateau_value(cut, plateau_end, ascending),
            )
        )
    if len(bands) == 1:
        bands = [bands[0]._replace(upper=float(ascending[-1]))]
    return [cut for (cut, _), _ in levels[1:]], bands


def _plateau_value(first: float, last: float, ascending: FloatArray) -> float:
    value = 0.5 * (first + last)
    return 0.0 if abs(value) <= _ROUNDING * float(np.abs(ascending).max()) else value


def _shift_bound(ascending: FloatArray, bound: float, contrast: float) -> float:
    # The least value above a bound. If near values are on both sides of the bound, it is shifted to
    # their largest gap, so that it does not divide nearly equal values.
    reach = _MAX_SHIFT * contrast * abs(bound)
    start, stop = np.searchsorted(ascending, [bound - reach, bound + reach])
    near = ascending[start:stop]
    if not near.size or near[0] > bound or near[-1] <= bound:
        return float(np.nextafter(bound, np.inf))
    points = np.concatenate([[bound - reach], near, [bound + reach]])
    gap = int(np.diff(points).argmax())
    return float(np.nextafter(points[gap], np.inf))


def grade_values(values: FloatArray) -> tuple[Grading, Shades]:
    """Values in levels, and the shades of the levels with their texts."""
    grading = grade(values, len(_GRADES))
    texts = [band.text() for band in grading.bands]
    return grading, (*shade_bands(_GRADES, texts), NO_VALUE)


def shade_bands(shades: Shades, texts: Sequence[str]) -> list[Shade]:
    """A shade for each text, evenly chosen among the shades; for a single text the middle one."""
    last = len(shades) - 1
    positions = np.array([0.5 * last]) if len(texts) == 1 else np.linspace(0.0, last, len(texts))
    indices = np.floor(positions + 0.5).astype(int).tolist()
    return [shades[index]._replace(text=text) for index, text in zip(indices, texts, strict=True)]


def plateau_labels(
    x: FloatArray, y: FloatArray, grading: Grading
) -> list[tuple[float, float, str]]:
    """Position and text of a label in the middle of every plateau that is long enough along x."""
    labels = []
    for level, band in enumerate(grading.bands):
        inside = grading.levels == level
        if band.plateau is not None and inside.any():
            column, row = _middle(inside)
            if np.count_nonzero(inside[:, row]) >= max(_PLATEAU_SHARE * x.size, _MIN_PLATEAU_SIZE):
                labels.append((float(x[column]), float(y[row]), band.text()))
    return labels


def _middle(inside: NDArray[np.bool_]) -> tuple[int, int]:
    # Indices of a point inside far from the edge: remove edges until no point would be left.
    core, smaller = inside, inside
    while smaller.any():
        core, padded = smaller, np.pad(smaller, 1)
        smaller = core & padded[:-2, 1:-1] & padded[2:, 1:-1] & padded[1:-1, :-2] & padded[1:-1, 2:]
    points = np.argwhere(core)
    distances = np.abs(points - points.mean(axis=0)).sum(axis=1)
    column, row = points[distances.argmin()].tolist()
    return column, row


def hide_unused(levels: Levels, shades: Shades) -> Shades:
    """The shades, without text where no point has their level.

    A shade without a text gets its `missing_text`.
    """
    counts = np.bincount(levels.ravel(), minlength=len(shades))
    return [
        shade._replace(text=(shade.text or shade.missing_text) if count else "")
        for shade, count in zip(shades, counts, strict=True)
    ]


def scale_swatches(shades: Shades) -> list[tuple[str, Shade]]:
    """The displayed shades, each after its character or, for that of a blank, a word."""
    return [(shade.character.strip() or BLANK, shade) for shade in shades if shade.text]
