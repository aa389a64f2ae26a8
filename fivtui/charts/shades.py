"""Levels of the values over a plane, their shades, and scales of colours.

The terminal has few shades, so a map assigns a level to each point: the index of its shade.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Levels = NDArray[np.intp]

# Smallest displayed difference relative to the greatest value: that of numbers with three digits.
MIN_CONTRAST: Final = 1e-3
# Numbers of significant digits that are tried for the texts of shades until all texts differ.
_DIGIT_COUNTS: Final = range(3, 7)


class Shade(NamedTuple):
    """How the points of a level are drawn.

    Attributes
    ----------
    character, style : str
        Character in the terminal, and the role of its colour.
    text : str
        Values of the level as text; empty if no point has this level.
    fill : str
        Colour in figures; if empty, points have the colours of their values.
    name : str
        Entry in the legend of figures; shades of the same name look the same.
    hatch : str
        Matplotlib's hatching in figures.
    missing_text : str
        Displayed at a cursor in place of a value, if points of the level have none.
    """

    character: str
    style: str
    text: str = ""
    fill: str = ""
    name: str = ""
    hatch: str = ""
    missing_text: str = "none"


Shades = Sequence[Shade]
# Shade of points without value, and shades of values from small to great.
NO_VALUE: Final = Shade("?", "ghost", fill="0.85", name="no value")
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


def colour_scale_of(label: str, values: FloatArray) -> ColourScale:
    """A scale from the least to the greatest value, at least `MIN_CONTRAST` apart."""
    finite = values[np.isfinite(values)]
    if not finite.size:
        return ColourScale(label, "viridis", 0.0, 1.0)
    low, high = float(finite.min()), float(finite.max())
    margin = max(0.5 * (MIN_CONTRAST * max(abs(low), abs(high)) - (high - low)), 0.0)
    return ColourScale(label, "viridis", low - margin, high + margin)


def rank_levels(values: FloatArray, count: int, min_difference: float) -> Levels:
    """Levels from 0 to `count` - 1 by the ranks of values, none of which is NaN.

    All levels have about the same number of values. Values that differ by less than
    `min_difference` times the greatest magnitude share a level.
    """
    ascending = np.sort(values)
    gap = min_difference * float(np.abs(ascending[np.isfinite(ascending)]).max(initial=0.0))
    # Groups of values that share a level; the middle rank of a group gives its level.
    group_maxima, group_levels = [], []
    begin = 0
    while begin < ascending.size:
        end = int(np.searchsorted(ascending, ascending[begin] + gap, side="right"))
        group_maxima.append(ascending[end - 1])
        middle_rank = 0.5 * (begin + end)
        group_levels.append(int(count * middle_rank / ascending.size))
        begin = end
    levels: Levels = np.array(group_levels, dtype=np.intp)[np.searchsorted(group_maxima, values)]
    return levels


def grade_values(values: FloatArray) -> tuple[Levels, Shades]:
    """Grade values by their ranks: returns the level of every value, and the shades of levels."""
    missing = np.isnan(values)
    levels = np.full(values.shape, len(_GRADES), dtype=np.intp)
    levels[~missing] = rank_levels(values[~missing], len(_GRADES), MIN_CONTRAST)
    return levels, (*_GRADES, NO_VALUE)


def label_shades(levels: Levels, shades: Shades, values: FloatArray) -> Shades:
    """The shades with their texts.

    A shade without a text gets ≤ the greatest value of its level, or its `missing_text` if no value
    is finite. The text of a level without points is empty.
    """
    finite = np.isfinite(values)
    maxima = [
        values[(levels == level) & finite].max(initial=-np.inf) for level in range(len(shades))
    ]
    finite_maxima = [maximum for maximum in maxima if maximum > -np.inf]
    digits = next(
        (
            count
            for count in _DIGIT_COUNTS
            if len({f"{maximum:.{count}g}" for maximum in finite_maxima}) == len(finite_maxima)
        ),
        # Where the most digits leave texts equal, more digits than the fewest are of no use.
        _DIGIT_COUNTS[0],
    )
    counts = np.bincount(levels.ravel(), minlength=len(shades))
    texts = [f"≤{maximum:.{digits}g}" if maximum > -np.inf else "" for maximum in maxima]
    return [
        shade._replace(text=(shade.text or text or shade.missing_text) if count else "")
        for shade, text, count in zip(shades, texts, counts, strict=True)
    ]


def scale_text(shades: Shades) -> str:
    """Characters and texts of the displayed shades, in one line."""
    return " ".join(
        f"{shade.character if shade.character.strip() else 'blank'} {shade.text}"
        for shade in shades
        if shade.text
    )
