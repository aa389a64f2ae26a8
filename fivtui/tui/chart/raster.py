"""Lines and dots as braille characters, 2 by 4 dots per cell. Imports no Textual."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

DOTS_X: Final = 2
DOTS_Y: Final = 4
# Braille bit of every dot of a cell, from the top.
_BITS: Final = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]], dtype=np.uint32)


class Raster:
    """A grid of character cells with braille dots.

    `cells`, shape (rows, columns), has the dots of each cell as bits, relative to the code point
    `BLANK`.
    """

    BLANK: Final = 0x2800

    def __init__(self, columns: int, rows: int) -> None:
        self._shape = rows * DOTS_Y, columns * DOTS_X
        self.cells = np.zeros((rows, columns), dtype=np.uint32)

    def lines(self, x: FloatArray, y: FloatArray) -> None:
        """Join points in [0, 1]² (origin bottom left); parts outside are clipped, NaN is a gap."""
        if x.size == 1:
            self.dots(x, y)
            return
        ends = _clipped(x, y)
        height, width = self._shape
        columns, rows = (ends[:, ::2] * (width - 1), (1.0 - ends[:, 1::2]) * (height - 1))
        span = np.maximum(np.abs(np.diff(columns)), np.abs(np.diff(rows)))[:, 0]
        counts = np.ceil(span).astype(int) + 1
        which = np.repeat(np.arange(counts.size), counts)
        number = np.arange(which.size) - np.repeat(np.cumsum(counts) - counts, counts)
        part = number / np.maximum(counts - 1, 1)[which]
        self._set_dots(_between(columns, which, part), _between(rows, which, part))

    def dots(self, x: FloatArray, y: FloatArray) -> None:
        """Draw dots at points; coordinates as in `lines`."""
        inside = (x >= 0.0) & (x <= 1.0) & (y >= 0.0) & (y <= 1.0)
        height, width = self._shape
        self._set_dots(x[inside] * (width - 1), (1.0 - y[inside]) * (height - 1))

    def _set_dots(self, columns: FloatArray, rows: FloatArray) -> None:
        marked = np.zeros(self._shape, dtype=bool)
        marked[np.rint(rows).astype(int), np.rint(columns).astype(int)] = True
        height, width = self.cells.shape
        blocks = marked.reshape(height, DOTS_Y, width, DOTS_X)
        self.cells |= np.einsum("rycx,yx->rc", blocks.astype(np.uint32), _BITS)


def _between(ends: FloatArray, which: NDArray[np.intp], part: FloatArray) -> FloatArray:
    begin, end = ends[:, 0], ends[:, 1]
    points: FloatArray = begin[which] + part * (end - begin)[which]
    return points


def _clipped(x: FloatArray, y: FloatArray) -> FloatArray:
    # Segments clipped to the unit square (Liang-Barsky), as rows x0, y0, x1, y1.
    joined = np.isfinite(x) & np.isfinite(y)
    joined = joined[:-1] & joined[1:]
    x0, y0, x1, y1 = x[:-1][joined], y[:-1][joined], x[1:][joined], y[1:][joined]
    dx, dy = x1 - x0, y1 - y0
    entering, leaving = np.zeros_like(x0), np.ones_like(x0)
    visible = np.ones(x0.size, dtype=bool)
    with np.errstate(divide="ignore", invalid="ignore"):
        for start, change in ((x0, dx), (y0, dy)):
            enter, leave = (0.0 - start) / change, (1.0 - start) / change
            still = change == 0.0
            visible &= ~still | ((start >= 0.0) & (start <= 1.0))
            entering = np.where(still, entering, np.maximum(entering, np.minimum(enter, leave)))
            leaving = np.where(still, leaving, np.minimum(leaving, np.maximum(enter, leave)))
    visible &= entering <= leaving
    entering, leaving = entering[visible], leaving[visible]
    x0, y0, dx, dy = x0[visible], y0[visible], dx[visible], dy[visible]
    ends = np.stack(
        [x0 + entering * dx, y0 + entering * dy, x0 + leaving * dx, y0 + leaving * dy], axis=1
    )
    inside: FloatArray = np.clip(ends, 0.0, 1.0)
    return inside
