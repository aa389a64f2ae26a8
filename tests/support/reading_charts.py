"""Reads charts of the terminal: positions of dots and marks, by the tick labels."""

import re
from collections.abc import Callable

import numpy as np

from fivtui.tui.chart.picture import MARGIN, Picture

# Bits of the dots of a Braille character, by row and column.
BITS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])


class Reading:
    """A drawn chart in data coordinates, by the tick labels, as a user reads it."""

    def __init__(self, picture: Picture, *, log_x: bool = False, log_y: bool = False) -> None:
        self.lines = picture.text().splitlines()
        first_column, top, columns, rows = picture.plot_area
        assert first_column == MARGIN
        self.cells = [
            line[first_column : first_column + columns] for line in self.lines[top : top + rows]
        ]
        y_ticks = [
            (row + 0.5, float(line[: MARGIN - 1]))
            for row, line in enumerate(self.lines[top : top + rows])
            if line[MARGIN - 1] == "┤"
        ]
        x_ticks = [
            (0.5 * (match.start() + match.end()), float(match[0]))
            for match in re.finditer(r"\S+", self.lines[-1][MARGIN:])
            # Labels at the edges are shifted inwards, so they are skipped.
            if re.fullmatch(r"[-+.e\d]+", match[0]) and match.start() > 0 and match.end() < columns
        ]
        self.x, self.x_per_column = self._scale(x_ticks, log_x)
        self.y, self.y_per_row = self._scale(y_ticks, log_y)

    @staticmethod
    def _scale(
        ticks: list[tuple[float, float]], log: bool
    ) -> tuple[Callable[[float], float], float]:
        assert len(ticks) > 1
        positions, values = np.array(ticks).T
        slope, intercept = np.polyfit(positions, np.log10(values) if log else values, 1).tolist()
        # The fitted scale places every tick within its cell.
        residuals = intercept + slope * positions - (np.log10(values) if log else values)
        assert np.abs(residuals).max() <= 1.1 * abs(slope)
        return lambda position: intercept + slope * position, abs(slope)

    def dots(self) -> list[tuple[float, float]]:
        """Positions of the dots in axis coordinates (logarithms on logarithmic axes)."""
        points = []
        for row, cells in enumerate(self.cells):
            for column, cell in enumerate(cells):
                if 0x2800 <= ord(cell) < 0x2900:
                    down, right = np.nonzero(BITS & (ord(cell) - 0x2800))
                    points += [
                        (self.x(column + 0.25 + 0.5 * r), self.y(row + 0.125 + 0.25 * d))
                        for d, r in zip(down.tolist(), right.tolist(), strict=True)
                    ]
        return points

    def marks(self, character: str) -> list[tuple[float, float]]:
        """Positions of a character."""
        return [
            (self.x(column + 0.5), self.y(row + 0.5))
            for row, cells in enumerate(self.cells)
            for column, cell in enumerate(cells)
            if cell == character
        ]

    def near(self, actual: tuple[float, float], expected: tuple[float, float]) -> bool:
        """Whether two positions agree within about a cell."""
        return (
            abs(actual[0] - expected[0]) <= 1.6 * self.x_per_column
            and abs(actual[1] - expected[1]) <= 1.6 * self.y_per_row
        )
