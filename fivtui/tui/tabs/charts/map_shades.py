"""Shades of maps of coexistence, and the scale of any map's shades in words. No Textual."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from fivtui.maps import StabilityMap

FloatArray = NDArray[np.float64]
Levels = NDArray[np.intp]
Shades = Sequence[tuple[str, str]]

_SAFE: Final = ("·", "stable")
# From the displacements that hardly suffice to small ones.
_KNOCK: Final = (("░", "trace-2"), ("▒", "trace-2"), ("▓", "trace-2"))
_SQUEALS: Final = ("█", "unstable")
NO_VALUE: Final = ("?", "hidden")
UNKNOWN_VALUE: Final = ("×", "hidden")
_GRADES: Final = tuple((shade, "trace-1") for shade in " ·░▒▓█")
# Displacements that escape are known to 2 %.
_LEAST_KNOCK: Final = 0.04
_BLANK: Final = "blank"
_DIGITS: Final = range(3, 7)


def offsets(result: "StabilityMap") -> FloatArray:
    """Displacements from rest that escape, m: zero where the slider squeals, NaN where it is safe.

    Infinite where a limit cycle coexists that none of the displacements tried leads to.
    """
    regions = result.values
    known = np.full(regions.shape, np.nan) if result.escape is None else result.escape
    within = np.where(np.isnan(known), np.inf, known)
    return np.where(regions == 2.0, 0.0, np.where(regions == 1.0, within, np.nan))


def region_shades(regions: FloatArray, escape: FloatArray) -> tuple[Levels, Shades, Sequence[str]]:
    """Levels, shades and scale of three regions, the middle one graded by the `offsets`."""
    inside = (regions == 1.0) & np.isfinite(escape)
    knock = np.ones(regions.shape, dtype=np.intp)
    knock[inside] += ranks(-escape[inside], len(_KNOCK), _LEAST_KNOCK)
    last = 1 + len(_KNOCK)
    levels = np.where(regions == 0.0, 0, np.where(regions == 2.0, last, knock))
    levels = np.where(np.isnan(regions), last + 1, levels).astype(np.intp)
    shades = (_SAFE, *_KNOCK, _SQUEALS, NO_VALUE)
    least = [escape[inside & (levels == place)].min(initial=np.inf) for place in range(1, last)]
    knocks = [f"≥{low:.2g} m" if np.isfinite(low) else "squeals after a knock" for low in least]
    words = ("safe", *knocks, "squeals", "no equilibrium")
    counts = np.bincount(levels.ravel(), minlength=len(words))
    return levels, shades, [word * bool(count) for word, count in zip(words, counts, strict=True)]


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
    found: Levels = np.array(level_of, dtype=np.intp)[np.searchsorted(tops, values)]
    return found


def graded(values: FloatArray) -> tuple[Levels, Shades]:
    """Levels and shades from the smallest values to the largest, by their ranks."""
    from fivtui.maps import LEAST_CONTRAST

    missing = np.isnan(values)
    levels = np.full(values.shape, len(_GRADES), dtype=np.intp)
    levels[~missing] = ranks(values[~missing], len(_GRADES), LEAST_CONTRAST)
    return levels, (*_GRADES, NO_VALUE)


def value_scale(levels: Levels, shades: Shades, values: FloatArray) -> Sequence[str]:
    """Up to which value each level of a map goes; empty where it has none."""
    known = np.isfinite(values)
    here = [values[(levels == place) & known] for place in range(len(shades))]
    tops = [part.max() for part in here if part.size]
    # Enough digits to tell neighbours apart.
    digits = next((n for n in _DIGITS if len({f"{top:.{n}g}" for top in tops}) == len(tops)), 3)
    scale = [f"≤{part.max():.{digits}g}" if part.size else "" for part in here]
    missing = np.bincount(levels.ravel(), minlength=len(shades))
    return [word or ("none" if count else "") for word, count in zip(scale, missing, strict=True)]


def with_unknown(
    levels: Levels, shades: Shades, scale: Sequence[str], unknown: NDArray[np.bool_]
) -> tuple[Levels, Shades, Sequence[str]]:
    """Levels, shades and scale with a level of its own for points that are not known."""
    from fivtui.maps import NOT_KNOWN

    levels = np.where(unknown, len(shades), levels)
    counts = np.bincount(levels.ravel(), minlength=len(shades) + 1)
    words = [word if count else "" for word, count in zip((*scale, NOT_KNOWN), counts, strict=True)]
    return levels, (*shades, UNKNOWN_VALUE), words


def scale_words(shades: Shades, scale: Sequence[str]) -> str:
    """The shades in use with their values, in one line."""
    return " ".join(
        f"{shade if shade.strip() else _BLANK} {word}"
        for (shade, _), word in zip(shades, scale, strict=True)
        if word
    )
