"""Values over a plane as levels, each with a shade; a scale of colours. Imports no Textual."""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Levels = NDArray[np.intp]

# Smallest visible difference, relative to the greatest value: that of three-digit numbers.
LEAST_CONTRAST: Final = 1e-3
# Digits of the values of a scale: the fewest that distinguish neighbours.
_DIGITS: Final = range(3, 7)


class Shade(NamedTuple):
    """How the points of a level are drawn.

    Attributes
    ----------
    character, style : str
        In the terminal.
    text : str
        Values of the level as text; empty if no point has it.
    fill : str
        Colour in figures; if empty, points have the colours of their values.
    name : str
        In the legend of figures; shades of the same name look the same.
    hatch : str
        Matplotlib's hatching in figures.
    missing : str
        Read-out of points of the level, which have no value.
    """

    character: str
    style: str
    text: str = ""
    fill: str = ""
    name: str = ""
    hatch: str = ""
    missing: str = "none"


Shades = Sequence[Shade]
NO_VALUE: Final = Shade("?", "hidden", fill="0.85", name="no value")
_GRADES: Final = tuple(Shade(character, "trace-1") for character in " ·░▒▓█")


class Colours(NamedTuple):
    """A scale of colours in figures.

    Attributes
    ----------
    label : str
        Quantity and unit of the values, beside the bar of colours.
    colours : str or tuple of str
        Name of matplotlib's map of colours, or the colours themselves.
    low, high : float
        Values at the ends.
    ticks : tuple of float
        Labelled values; if empty, matplotlib chooses them.
    names : tuple of str
        Labels of these values; if empty, the values themselves.
    """

    label: str
    colours: str | tuple[str, ...]
    low: float
    high: float
    ticks: tuple[float, ...] = ()
    names: tuple[str, ...] = ()


def colours_of(label: str, values: FloatArray) -> Colours:
    """A scale from the least to the greatest value, at least `LEAST_CONTRAST` apart."""
    finite = values[np.isfinite(values)]
    if not finite.size:
        return Colours(label, "viridis", 0.0, 1.0)
    low, high = float(finite.min()), float(finite.max())
    margin = max(0.5 * (LEAST_CONTRAST * max(abs(low), abs(high)) - (high - low)), 0.0)
    return Colours(label, "viridis", low - margin, high + margin)


def ranks(values: FloatArray, count: int, least: float) -> Levels:
    """Levels from 0 to `count` - 1 by the ranks of values, without NaN.

    Values that differ by less than the share `least` of the greatest magnitude have one level.
    """
    ascending = np.sort(values)
    gap = least * float(np.abs(ascending[np.isfinite(ascending)]).max(initial=0.0))
    tops, level_of = [], []
    begin = 0
    while begin < ascending.size:
        end = int(np.searchsorted(ascending, ascending[begin] + gap, side="right"))
        tops.append(ascending[end - 1])
        level_of.append(int(count * 0.5 * (begin + end) / ascending.size))
        begin = end
    levels: Levels = np.array(level_of, dtype=np.intp)[np.searchsorted(tops, values)]
    return levels


def graded(values: FloatArray) -> tuple[Levels, Shades]:
    """Levels and shades from the smallest values to the largest, by their ranks."""
    missing = np.isnan(values)
    levels = np.full(values.shape, len(_GRADES), dtype=np.intp)
    levels[~missing] = ranks(values[~missing], len(_GRADES), LEAST_CONTRAST)
    return levels, (*_GRADES, NO_VALUE)


def in_words(levels: Levels, shades: Shades, values: FloatArray) -> Shades:
    """The shades with texts: shades without one get the greatest value of their level."""
    finite = np.isfinite(values)
    tops = [values[(levels == level) & finite].max(initial=-np.inf) for level in range(len(shades))]
    used = [top for top in tops if top > -np.inf]
    digits = next((n for n in _DIGITS if len({f"{top:.{n}g}" for top in used}) == len(used)), 3)
    counts = np.bincount(levels.ravel(), minlength=len(shades))
    texts = [f"≤{top:.{digits}g}" if top > -np.inf else "" for top in tops]
    return [
        shade._replace(text=(shade.text or text or shade.missing) if count else "")
        for shade, text, count in zip(shades, texts, counts, strict=True)
    ]


def scale_words(shades: Shades) -> str:
    """The shades in use with their values, in one line."""
    return " ".join(
        f"{shade.character if shade.character.strip() else 'blank'} {shade.text}"
        for shade in shades
        if shade.text
    )
