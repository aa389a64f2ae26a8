"""Shades of maps of coexistence, and the scale of any map's shades in words. No Textual."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from fivtui.safety import SafetyMap

FloatArray = NDArray[np.float64]
Levels = NDArray[np.intp]
Shades = Sequence[tuple[str, str]]

_SAFE: Final = ("·", "stable")
# From the displacements that hardly suffice to small ones.
_KNOCK: Final = (("░", "trace-2"), ("▒", "trace-2"), ("▓", "trace-2"))
_SQUEALS: Final = ("█", "unstable")
_NONE: Final = ("?", "hidden")
_BLANK: Final = "blank"
_DIGITS: Final = range(3, 7)


def offsets(result: "SafetyMap") -> FloatArray:
    """Displacements from rest that escape, m: zero where the slider squeals, NaN where it is safe.

    Infinite where a limit cycle coexists that none of the displacements tried leads to.
    """
    regions = result.regions
    known = np.full(regions.shape, np.nan) if result.escape is None else result.escape
    within = np.where(np.isnan(known), np.inf, known)
    return np.where(regions == 2.0, 0.0, np.where(regions == 1.0, within, np.nan))


def region_shades(regions: FloatArray, escape: FloatArray) -> tuple[Levels, Shades, Sequence[str]]:
    """Levels, shades and scale of three regions, the middle one graded by the `offsets`."""
    inside = (regions == 1.0) & np.isfinite(escape)
    parts = np.linspace(1.0, 0.0, len(_KNOCK) + 1)[1:-1]
    edges = np.quantile(escape[inside], parts) if inside.any() else np.zeros(parts.size)
    knock = 1 + np.count_nonzero(escape[..., None] < edges, axis=-1)
    last = 1 + len(_KNOCK)
    levels = np.where(regions == 0.0, 0, np.where(regions == 2.0, last, knock))
    levels = np.where(np.isnan(regions), last + 1, levels).astype(np.intp)
    shades = (_SAFE, *_KNOCK, _SQUEALS, _NONE)
    least = [escape[inside & (levels == place)].min(initial=np.inf) for place in range(1, last)]
    knocks = [f"≥{low:.2g} m" if np.isfinite(low) else "squeals after a knock" for low in least]
    words = ("safe", *knocks, "squeals", "unknown")
    found = np.bincount(levels.ravel(), minlength=len(words))
    return levels, shades, [word if count else "" for word, count in zip(words, found, strict=True)]


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


def scale_words(shades: Shades, scale: Sequence[str]) -> str:
    """The shades in use with their values, in one line."""
    return " ".join(
        f"{shade if shade.strip() else _BLANK} {word}"
        for (shade, _), word in zip(shades, scale, strict=True)
        if word and shade != _NONE[0]
    )
