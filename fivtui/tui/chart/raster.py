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
        # Columns and rows of the dots at both ends of every line.
        ends = _clip_lines(x, y)
        height, width = self._dots.shape
        columns, rows = ends[:, ::2] * (width - 1), (1.0 - ends[:, 1::2]) * (height - 1)
        # A line has a dot per column, or per row if it is steep.
        lengths = np.maximum(np.abs(np.diff(columns)), np.abs(np.diff(rows)))[:, 0]
        counts = np.ceil(lengths).astype(int) + 1
        # For every dot, the index of its line, its index in the line, and its fraction along it.
        line = np.repeat(np.arange(counts.size), counts)
        first_dots = np.cumsum(counts) - counts
        index = np.arange(line.size) - first_dots[line]
        fraction = index / np.maximum(counts - 1, 1)[line]
        self._set_dots(_interpolate(columns, line, fraction), _interpolate(rows, line, fraction))

    def draw_dots(self, x: FloatArray, y: FloatArray) -> None:
        """Draw dots at points; coordinates as in `draw_lines`."""
        inside = (x >= 0.0) & (x <= 1.0) & (y >= 0.0) & (y <= 1.0)
        height, width = self._dots.shape
        self._set_dots(x[inside] * (width - 1), (1.0 - y[inside]) * (height - 1))

    def fill_columns(self, low: FloatArray, high: FloatArray) -> None:
        """Set the dots of each column from `low` to `high`, as fractions of the height, or NaN."""
        height = self._dots.shape[0]
        rows = np.arange(height)[:, None]
        top, bottom = np.rint((1.0 - high) * (height - 1)), np.rint((1.0 - low) * (height - 1))
        self._dots |= (top <= rows) & (rows <= bottom)

    def _set_dots(self, columns: FloatArray, rows: FloatArray) -> None:
        self._dots[np.rint(rows).astype(int), np.rint(columns).astype(int)] = True


def _pack(dots: NDArray[np.bool_]) -> NDArray[np.uint32]:
    # Add the bits of the dots (row y, column x) in every cell (row r, column c).
    rows, columns = dots.shape
    dots_by_cell = dots.reshape(rows // DOTS_Y, DOTS_Y, columns // DOTS_X, DOTS_X)
    cells: NDArray[np.uint32] = np.einsum("rycx,yx->rc", dots_by_cell.astype(np.uint32), _BITS)
    return cells


def _interpolate(ends: FloatArray, line: NDArray[np.intp], fraction: FloatArray) -> FloatArray:
    # Points at fractions of the lines with the indices `line`; `ends` has a row per line.
    start, end = ends[:, 0], ends[:, 1]
    points: FloatArray = start[line] + fraction * (end - start)[line]
    return points


def _clip_lines(x: FloatArray, y: FloatArray) -> FloatArray:
    # Lines between consecutive points, clipped to the unit square by the algorithm of Liang and
    # Barsky; a row per visible line: x0, y0, x1, y1.
    is_finite = np.isfinite(x) & np.isfinite(y)
    is_finite = is_finite[:-1] & is_finite[1:]
    x0, y0, x1, y1 = x[:-1][is_finite], y[:-1][is_finite], x[1:][is_finite], y[1:][is_finite]
    dx, dy = x1 - x0, y1 - y0
    # Fractions of the line at which it enters and leaves the square.
    entering, leaving = np.zeros_like(x0), np.ones_like(x0)
    visible = np.ones(x0.size, dtype=bool)
    with np.errstate(divide="ignore", invalid="ignore"):
        for start, change in ((x0, dx), (y0, dy)):
            at_low, at_high = (0.0 - start) / change, (1.0 - start) / change
            enter, leave = np.minimum(at_low, at_high), np.maximum(at_low, at_high)
            constant = change == 0.0
            visible &= ~constant | ((start >= 0.0) & (start <= 1.0))
            entering = np.where(constant, entering, np.maximum(entering, enter))
            leaving = np.where(constant, leaving, np.minimum(leaving, leave))
    visible &= entering <= leaving
    entering, leaving = entering[visible], leaving[visible]
    x0, y0, dx, dy = x0[visible], y0[visible], dx[visible], dy[visible]
    ends = np.stack(
        [x0 + entering * dx, y0 + entering * dy, x0 + leaving * dx, y0 + leaving * dy], axis=1
    )
    clipped_ends: FloatArray = np.clip(ends, 0.0, 1.0)
    return clipped_ends
