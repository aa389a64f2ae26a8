"""A gauge: safe and unsafe zones of a parameter, with a marker at the edited value."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from rich.cells import cell_len
from textual.content import Content
from textual.widget import Widget

from fivtui.safety import Zone, Zones

_MARKER_GLYPH: Final = "●"
_BOUND_GLYPH: Final = "┼"
_MIN_DIGITS: Final = 3
_MAX_DIGITS: Final = 17
_VALUE_DIGITS: Final = 5
_MAX_LENGTH: Final = 8
# Largest offset of a tick label, in columns.
_LARGEST_OFFSET: Final = 6
_STYLES: Final = {
    Zone.SAFE: "$text-success",
    Zone.KNOCK: "$text-warning",
    Zone.SQUEALS: "$text-error",
    Zone.SMALL: "$text-muted",
    Zone.NONE: "$text-muted",
}
_GLYPHS: Final = {
    Zone.SAFE: "─",
    Zone.KNOCK: "╍",
    Zone.SQUEALS: "━",
    Zone.SMALL: "·",
    Zone.NONE: " ",
}
_LABELS: Final = {
    Zone.SAFE: ("safe",),
    Zone.KNOCK: (str(Zone.KNOCK), "after a knock", "knock"),
    Zone.SQUEALS: (str(Zone.SQUEALS), "squeals"),
    Zone.SMALL: ("large disturbances: not known", "not known", "?"),
    Zone.NONE: (str(Zone.NONE),),
}
_SEARCHING: Final = ("large disturbances: searching…", "searching…", "…")

# Consecutive texts with their styles.
StyledTexts = list[tuple[str, str]]


@dataclass(frozen=True, slots=True)
class Gauge:
    """The content of a gauge; `text` is the edited value, `basis` names the methods."""

    label: str
    zones: Zones
    value: float
    text: str
    searching: bool
    basis: str

    def lines(self, width: int) -> tuple[StyledTexts, StyledTexts]:
        """The zones, and below them the tick labels: bounds of the zones, and the value."""
        margin = f"{self.label} "
        width = max(width - len(margin), 4)
        bar, numbers = self._bar(width), self._numbers(width)
        return [(margin, "bold"), *bar], [(" " * len(margin), ""), *numbers]

    def _column(self, value: float, width: int) -> int:
        low, high = self.zones.bounds[0], self.zones.bounds[-1]
        share = (value - low) / (high - low)
        return min(max(round(share * (width - 1)), 0), width - 1)

    def _bar(self, width: int) -> StyledTexts:
        marker = self._column(self.value, width)
        ends = [self._column(bound, width) for bound in self.zones.bounds]
        cells: list[tuple[str, str]] = []
        for zone, (start_column, end_column) in zip(self.zones.zones, pairwise(ends), strict=True):
            stop = end_column if end_column < width - 1 else width
            # The bound between two zones takes a column.
            begin = start_column + (start_column > 0)
            style, text = _STYLES[zone], list(_GLYPHS[zone] * (stop - begin))
            # If the marker divides a zone, the label of the zone is in the larger part.
            spans = [(begin, stop)]
            if begin <= marker < stop:
                spans = [(begin, marker), (marker + 1, stop)]
            start, end = max(spans, key=lambda span: span[1] - span[0])
            self._write_label(zone, text, start - begin, end - begin)
            cells += [(letter, style) for letter in text]
            if end_column < width - 1:
                cells.append((_BOUND_GLYPH, "bold"))
        del cells[width:]
        cells[marker] = (_MARKER_GLYPH, "bold")
        return _join_cells(cells)

    def _write_label(self, zone: Zone, text: list[str], start: int, end: int) -> None:
        texts = _SEARCHING if zone is Zone.SMALL and self.searching else _LABELS[zone]
        label = next(
            (f" {option} " for option in texts if cell_len(option) + 4 <= end - start),
            "",
        )
        first = start + (end - start - len(label)) // 2
        text[first : first + len(label)] = label

    def _numbers(self, width: int) -> StyledTexts:
        line: list[tuple[str, str]] = [(" ", "")] * width
        # Value, first column and end column of every tick label in the line.
        placed: list[tuple[float, int, int]] = []

        def write(value: float, text: str, style: str) -> None:
            # Keep the labels in ascending order, separated by blanks.
            start = max((end + 1 for number, _, end in placed if number < value), default=0)
            stop = min((first - 1 for number, first, _ in placed if number > value), default=width)
            first = _first_column(self._column(value, width), len(text), start, stop, width)
            if first is not None:
                end = first + len(text)
                line[first:end] = [(letter, style) for letter in text]
                placed.append((value, first, end))

        # Round a computed value that has many digits.
        label = self.text if len(self.text) <= _MAX_LENGTH else f"{self.value:.{_VALUE_DIGITS}g}"
        write(self.value, label, "bold")
        bounds = self.zones.bounds
        # The ends of the range take precedence over other bounds.
        for bound in (bounds[0], bounds[-1], *bounds[1:-1]):
            if bound != self.value:
                write(bound, _number_text(bound, self.value), "")
        return _join_cells(line)


def _number_text(bound: float, value: float) -> str:
    # Round to the fewest digits that keep the bound on its side of the value.
    for digits in range(_MIN_DIGITS, _MAX_DIGITS):
        text = f"{bound:.{digits}g}"
        if (float(text) > value) is (bound > value) and float(text) != value:
            return text
    return repr(bound)


def _first_column(column: int, size: int, start: int, stop: int, width: int) -> int | None:
    # First column of a label between `start` and `stop`, centred at `column` if possible.
    centred = min(max(column - size // 2, 0), width - size)
    first = min(max(centred, start), stop - size)
    return first if first >= start and abs(first - centred) <= _LARGEST_OFFSET else None


def _join_cells(cells: StyledTexts) -> StyledTexts:
    parts: StyledTexts = []
    for text, style in cells:
        if parts and parts[-1][1] == style:
            parts[-1] = (parts[-1][0] + text, style)
        else:
            parts.append((text, style))
    return parts


class GaugeView(Widget):
    """Draws a gauge in two lines, or a text in its place."""

    def __init__(self, *, id: str) -> None:  # noqa: A002
        super().__init__(id=id)
        self._content: Gauge | str = ""

    def show(self, gauge: Gauge | str) -> None:
        """Display a gauge, or the reason for its absence."""
        if gauge != self._content:
            self._content = gauge
            self.refresh()

    def render(self) -> Content:
        """The two lines."""
        if isinstance(self._content, str):
            return Content(self._content)
        lines = self._content.lines(self.size.width)
        return Content("\n").join(Content.assemble(*line) for line in lines)


# Factors of a power of ten at which ranges end, and the least ratio of the end to the value.
_FACTORS: Final = (1.0, 1.5, 2.0, 3.0, 5.0, 7.5, 10.0)
_RANGE_FACTOR: Final = 1.5


def round_range(value: float, lower: float, upper: float) -> tuple[float, float]:
    """A round range around a value, from 0 unless it is negative, within the allowed limits.

    A round range stays the same while the value is edited.
    """
    least_end = _RANGE_FACTOR * abs(value) or 1.0
    decade = 10.0 ** math.floor(math.log10(least_end))
    end = next(
        (decade * f for f in _FACTORS if decade * f >= least_end * (1.0 - 1e-12)), 10.0 * decade
    )
    return max(-end if value < 0.0 else 0.0, lower), min(end, upper)
