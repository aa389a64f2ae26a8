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


def offsets(result: "SafetyMap") -> FloatArray:
    """Displacements from rest that escape, m: zero where the slider squeals, NaN where it is safe.

    Infinite where a limit cycle coexists that none of the displacements tried leads to.
    """
    regions = result.regions
    known = np.full(regions.shape, np.nan) if result.escape is None else result.escape
    within = np.where(np.isnan(known), np.inf, known)
    return np.where(regions == 2.0, 0.0, np.where(regions == 1.0, within, np.nan))


def region_shades(regions: FloatArray, escape: FloatArray) -> tuple[Levels, Shades, str]:
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
    knocks = [
        f"{shade} ≥{low:.2g}"
        for (shade, _), low in zip(_KNOCK, least, strict=True)
        if np.isfinite(low)
    ]
    words = f"{_SAFE[0]} safe {_SQUEALS[0]} squeals"
    return levels, shades, f"{words} {' '.join(knocks)} m" if knocks else words


def scale_words(levels: Levels, shades: Shades, values: FloatArray) -> str:
    """Up to which value each shade of a map goes."""
    parts = []
    for place, (shade, _) in enumerate(shades):
        here = values[(levels == place) & np.isfinite(values)]
        if here.size:
            parts.append(f"{shade if shade.strip() else _BLANK} ≤{here.max():.3g}")
    return " ".join(parts)
