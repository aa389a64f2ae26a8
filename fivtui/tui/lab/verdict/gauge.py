"""A gauge: zones over a parameter, and where the edited value stands."""

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
_OF_VALUE: Final = 5
_LONGEST: Final = 8
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
_WORDS: Final = {
    Zone.SAFE: ("safe",),
    Zone.KNOCK: (str(Zone.KNOCK), "after a knock", "knock"),
    Zone.SQUEALS: (str(Zone.SQUEALS), "squeals"),
    Zone.SMALL: ("large disturbances: not known", "not known", "?"),
    Zone.NONE: (str(Zone.NONE),),
}
_SEARCHING: Final = ("large disturbances: searching…", "searching…", "…")

# Text and style, one after the other.
Parts = list[tuple[str, str]]


@dataclass(frozen=True, slots=True)
class Gauge:
    """What a gauge shows."""

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
        here = self._column(self.value, room)
        ends = [self._column(bound, room) for bound in self.zones.bounds]
        cells: list[tuple[str, str]] = []
        for zone, (first, last) in zip(self.zones.zones, pairwise(ends), strict=True):
            stop = last if last < room - 1 else room
            # The bound of the zone before has a column of its own.
            begin = first + (first > 0)
            style, text = _TEXT[zone], list(_GLYPHS[zone] * (stop - begin))
            # Words stand in the larger part of a zone that the marker divides.
            free = [(begin, stop)]
            if begin <= here < stop:
                free = [(begin, here), (here + 1, stop)]
            start, end = max(free, key=lambda each: each[1] - each[0])
            self._write(zone, text, start - begin, end - begin)
            cells += [(each, style) for each in text]
            if last < room - 1:
                cells.append((_BOUND, "bold"))
        del cells[room:]
        cells[here] = (_MARKER, "bold")
        return _joined(cells)

    def _write(self, zone: Zone, text: list[str], start: int, end: int) -> None:
        known = _SEARCHING if zone is Zone.SMALL and self.searching else _WORDS[zone]
        words = next((f" {each} " for each in known if cell_len(each) + 4 <= end - start), "")
        first = start + (end - start - len(words)) // 2
        text[first : first + len(words)] = words

    def _numbers(self, room: int) -> Parts:
        line: list[tuple[str, str]] = [(" ", "")] * room
        # Value, first column and end of every number in the line.
        written: list[tuple[float, int, int]] = []

        def write(value: float, text: str, style: str) -> None:
            # Numbers stand in ascending order, a blank between them.
            start = max((end + 1 for number, _, end in written if number < value), default=0)
            stop = min((first - 1 for number, first, _ in written if number > value), default=room)
            first = _first_column(self._column(value, room), len(text), start, stop, room)
            if first is not None:
                end = first + len(text)
                line[first:end] = [(letter, style) for letter in text]
                written.append((value, first, end))

        # A value from a computation has all its digits.
        own = self.text if len(self.text) <= _LONGEST else f"{self.value:.{_OF_VALUE}g}"
        write(self.value, own, "bold")
        bounds = self.zones.bounds
        # The ends have precedence over what is between them.
        for bound in (bounds[0], bounds[-1], *bounds[1:-1]):
            if bound != self.value:
                write(bound, _number(bound, self.value), "")
        return _joined(line)


def _number(bound: float, value: float) -> str:
    # As few digits as keep the bound on its side of the value, which is drawn beside it.
    for digits in range(_DIGITS, _ALL_DIGITS):
        text = f"{bound:.{digits}g}"
        if (float(text) > value) is (bound > value) and float(text) != value:
            return text
    return repr(bound)


def _first_column(column: int, size: int, start: int, stop: int, room: int) -> int | None:
    # First column of a number from `start` to `stop`, as near as possible to centred at a column.
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
    """Draws a gauge in two lines, or words in its place."""

    def __init__(self, *, id: str) -> None:  # noqa: A002
        super().__init__(id=id)
        self._shown: Gauge | str = ""

    def show(self, gauge: Gauge | str) -> None:
        """Display a gauge, or why there is none."""
        if gauge != self._shown:
            self._shown = gauge
            self.refresh()

    def render(self) -> Content:
        """The two lines."""
        if isinstance(self._shown, str):
            return Content(self._shown)
        lines = self._shown.lines(self.size.width)
        return Content("\n").join(Content.assemble(*line) for line in lines)


# Round ends of ranges, in tens.
_ROUND: Final = (1.0, 1.5, 2.0, 3.0, 5.0, 7.5, 10.0)
_BEYOND: Final = 1.5


def round_span(value: float, least: float, greatest: float) -> tuple[float, float]:
    """A round range around a value: from 0, unless it is negative; within what is allowed.

    Being round, it stays the same while the value is edited.
    """
    reach = _BEYOND * abs(value) or 1.0
    tens = 10.0 ** math.floor(math.log10(reach))
    end = next((tens * one for one in _ROUND if tens * one >= reach * (1.0 - 1e-12)), 10.0 * tens)
    return max(-end if value < 0.0 else 0.0, least), min(end, greatest)
