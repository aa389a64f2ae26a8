"""Lines and dots as Braille characters, 2 by 4 dots per character cell. Imports no Textual."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Columns and rows of dots in a cell.
DOTS_X: Final = 2
DOTS_Y: Final = 4
# Bits of the dots of a cell in the code point of its character, by row from the top.
_BITS: Final = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]], dtype=np.uint32)


class Raster:
    """A grid of character cells with Braille dots; the first row of dots is at the top."""

    BLANK: Final = 0x2800

    def __init__(self, columns: int, rows: int) -> None:
        self._dots = np.zeros((rows * DOTS_Y, columns * DOTS_X), dtype=bool)

    @property
    def cells(self) -> NDArray[np.uint32]:
        """The dots of each cell as bits; its character is the code point `BLANK` plus its bits."""
        return _pack(self._dots)

    @property
    def inner_cells(self) -> NDArray[np.uint32]:
        """As `cells`, only the dots whose neighbours left, right, above and below are set.

        Neighbours outside the grid count as set.
        """
        dots = np.pad(self._dots, 1, constant_values=True)
        return _pack(
            dots[1:-1, 1:-1] & dots[:-2, 1:-1] & dots[2:, 1:-1] & dots[1:-1, :-2] & dots[1:-1, 2:]
        )

    def draw_lines(self, x: FloatArray, y: FloatArray) -> None:
        """Join points by lines, clipped to [0, 1]² (origin bottom left); NaN is a gap."""
        if x.size == 1:
            self.draw_dots(x, y)
            return
        starts, ends = _clip_lines(np.stack([x, y]))
        # A line has a dot per column, or per row if it is steep.
        height, width = self._dots.shape
        lengths = np.abs((ends - starts) * [[width - 1], [height - 1]]).max(axis=0)
        counts = np.ceil(lengths).astype(int) + 1
        # For every dot, the index of its line, its index in the line, and its fraction along it.
        line = np.repeat(np.arange(counts.size), counts)
        first_dots = np.cumsum(counts) - counts
        index = np.arange(line.size) - first_dots[line]
        fraction = index / np.maximum(counts - 1, 1)[line]
        self.draw_dots(*(starts.take(line, 1) + fraction * (ends - starts).take(line, 1)))

    def draw_dots(self, x: FloatArray, y: FloatArray) -> None:
        """Draw dots at points; coordinates as in `draw_lines`."""
        inside = (x >= 0.0) & (x <= 1.0) & (y >= 0.0) & (y <= 1.0)
        height, width = self._dots.shape
        rows, columns = (1.0 - y[inside]) * (height - 1), x[inside] * (width - 1)
        self._dots[np.rint(rows).astype(int), np.rint(columns).astype(int)] = True

    def fill_columns(self, low: FloatArray, high: FloatArray) -> None:
        """Set the dots of each column from `low` to `high`, as fractions of the height, or NaN."""
        height = self._dots.shape[0]
        rows = np.arange(height)[:, None]
        top, bottom = np.rint((1.0 - high) * (height - 1)), np.rint((1.0 - low) * (height - 1))
        self._dots |= (top <= rows) & (rows <= bottom)


def _pack(dots: NDArray[np.bool_]) -> NDArray[np.uint32]:
    # Add the bits of the dots (row y, column x) in every cell (row r, column c).
    rows, columns = dots.shape
    dots_by_cell = dots.reshape(rows // DOTS_Y, DOTS_Y, columns // DOTS_X, DOTS_X)
    cells: NDArray[np.uint32] = np.einsum("rycx,yx->rc", dots_by_cell.astype(np.uint32), _BITS)
    return cells


def _clip_lines(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    # Starts and ends of the visible lines between consecutive points, clipped to the unit square by
    # the algorithm of Liang and Barsky. All have two rows: x and y.
    is_finite = np.isfinite(points[0]) & np.isfinite(points[1])
    is_finite = is_finite[:-1] & is_finite[1:]
    starts = points[:, :-1].compress(is_finite, 1)
    changes = points[:, 1:].compress(is_finite, 1) - starts
    with np.errstate(divide="ignore", invalid="ignore"):
        at_low, at_high = (0.0 - starts) / changes, (1.0 - starts) / changes
    # A line parallel to a limit does not cross it.
    is_inside = (changes == 0.0) & (starts >= 0.0) & (starts <= 1.0)
    # Fractions of the line at which it enters and leaves the square.
    entering = np.where(is_inside, 0.0, np.minimum(at_low, at_high)).max(axis=0, initial=0.0)
    leaving = np.where(is_inside, 1.0, np.maximum(at_low, at_high)).min(axis=0, initial=1.0)
    visible = entering <= leaving
    starts, changes = starts.compress(visible, 1), changes.compress(visible, 1)
    first, last = starts + entering[visible] * changes, starts + leaving[visible] * changes
    return np.clip(first, 0.0, 1.0), np.clip(last, 0.0, 1.0)
