"""A gauge: zones of a parameter, with a marker at the edited value."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from rich.cells import cell_len
from textual.content import Content
from textual.widget import Widget

from fivtui.safety import Zone, Zones

_MARKER: Final = "●"
_BOUND: Final = "┼"
_DIGITS: Final = 3
_ALL_DIGITS: Final = 17
_VALUE_DIGITS: Final = 5
_MAX_TEXT: Final = 8
# Largest offset of a number below the gauge from the column of its value.
_LARGEST_OFFSET: Final = 6
_TEXT: Final = {
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
Parts = list[tuple[str, str]]


@dataclass(frozen=True, slots=True)
class Gauge:
    """The content of a gauge."""

    label: str
    zones: Zones
    value: float
    text: str
    searching: bool
    basis: str

    def lines(self, width: int) -> tuple[Parts, Parts]:
        """The zones, and below them the numbers of their bounds and of the value."""
        margin = f"{self.label} "
        room = max(width - len(margin), 4)
        bar, numbers = self._bar(room), self._numbers(room)
        return [(margin, "bold"), *bar], [(" " * len(margin), ""), *numbers]

    def _column(self, value: float, room: int) -> int:
        low, high = self.zones.bounds[0], self.zones.bounds[-1]
        share = (value - low) / (high - low)
        return min(max(round(share * (room - 1)), 0), room - 1)

    def _bar(self, room: int) -> Parts:
        marker = self._column(self.value, room)
        ends = [self._column(bound, room) for bound in self.zones.bounds]
        cells: list[tuple[str, str]] = []
        for zone, (start_column, end_column) in zip(self.zones.zones, pairwise(ends), strict=True):
            stop = end_column if end_column < room - 1 else room
            # The bound between two zones takes a column.
            begin = start_column + (start_column > 0)
            style, text = _TEXT[zone], list(_GLYPHS[zone] * (stop - begin))
            # If the marker divides a zone, its label is in the larger part.
            free = [(begin, stop)]
            if begin <= marker < stop:
                free = [(begin, marker), (marker + 1, stop)]
            start, end = max(free, key=lambda span: span[1] - span[0])
            self._write(zone, text, start - begin, end - begin)
            cells += [(letter, style) for letter in text]
            if end_column < room - 1:
                cells.append((_BOUND, "bold"))
        del cells[room:]
        cells[marker] = (_MARKER, "bold")
        return _joined(cells)

    def _write(self, zone: Zone, text: list[str], start: int, end: int) -> None:
        texts = _SEARCHING if zone is Zone.SMALL and self.searching else _LABELS[zone]
        label = next(
            (f" {option} " for option in texts if cell_len(option) + 4 <= end - start),
            "",
        )
        first = start + (end - start - len(label)) // 2
        text[first : first + len(label)] = label

    def _numbers(self, room: int) -> Parts:
        line: list[tuple[str, str]] = [(" ", "")] * room
        # Value, first column and end of every number in the line.
        written: list[tuple[float, int, int]] = []

        def write(value: float, text: str, style: str) -> None:
            # Numbers are in ascending order, separated by a blank.
            start = max((end + 1 for number, _, end in written if number < value), default=0)
            stop = min((first - 1 for number, first, _ in written if number > value), default=room)
            first = _first_column(self._column(value, room), len(text), start, stop, room)
            if first is not None:
                end = first + len(text)
                line[first:end] = [(letter, style) for letter in text]
                written.append((value, first, end))

        # Shorten a computed value with many digits.
        value_text = self.text if len(self.text) <= _MAX_TEXT else f"{self.value:.{_VALUE_DIGITS}g}"
        write(self.value, value_text, "bold")
        bounds = self.zones.bounds
        # The ends of the range are written first.
        for bound in (bounds[0], bounds[-1], *bounds[1:-1]):
            if bound != self.value:
                write(bound, _number(bound, self.value), "")
        return _joined(line)


def _number(bound: float, value: float) -> str:
    # The fewest digits that keep the bound on the correct side of the value.
    for digits in range(_DIGITS, _ALL_DIGITS):
        text = f"{bound:.{digits}g}"
        if (float(text) > value) is (bound > value) and float(text) != value:
            return text
    return repr(bound)


def _first_column(column: int, size: int, start: int, stop: int, room: int) -> int | None:
    # First column of a number between `start` and `stop`, centred at a column if possible.
    centred = min(max(column - size // 2, 0), room - size)
    first = min(max(centred, start), stop - size)
    return first if first >= start and abs(first - centred) <= _LARGEST_OFFSET else None


def _joined(cells: Parts) -> Parts:
    parts: Parts = []
    for text, style in cells:
        if parts and parts[-1][1] == style:
            parts[-1] = (parts[-1][0] + text, style)
        else:
            parts.append((text, style))
    return parts


class GaugeView(Widget):
    """Draws a gauge in two lines, or a text instead."""

    def __init__(self, *, id: str) -> None:  # noqa: A002
        super().__init__(id=id)
        self._shown: Gauge | str = ""

    def show(self, gauge: Gauge | str) -> None:
        """Display a gauge, or the reason why there is none."""
        if gauge != self._shown:
            self._shown = gauge
            self.refresh()

    def render(self) -> Content:
        """The two lines."""
        if isinstance(self._shown, str):
            return Content(self._shown)
        lines = self._shown.lines(self.size.width)
        return Content("\n").join(Content.assemble(*line) for line in lines)


# Round ends of ranges, as factors of a power of ten.
_ROUND: Final = (1.0, 1.5, 2.0, 3.0, 5.0, 7.5, 10.0)
_BEYOND: Final = 1.5


def round_span(value: float, least: float, greatest: float) -> tuple[float, float]:
    """A round range around a value, from 0 unless it is negative, within the allowed limits.

    A round range stays the same while the value is edited.
    """
    reach = _BEYOND * abs(value) or 1.0
    tens = 10.0 ** math.floor(math.log10(reach))
    end = next(
        (tens * factor for factor in _ROUND if tens * factor >= reach * (1.0 - 1e-12)), 10.0 * tens
    )
    return max(-end if value < 0.0 else 0.0, least), min(end, greatest)
