"""A gauge: the zones of a parameter in which the slider is safe or squeals, and the edited value.

In a zone `SAFE` no disturbance was found to lead to squeal; in `KNOCK` a large one does, in
`SQUEALS` any. In `SMALL` small disturbances die out, and large ones were not searched. In `NONE`
there is no equilibrium.
"""

import math
from dataclasses import dataclass, replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from itertools import pairwise
from typing import Final

from rich.cells import cell_len
from textual import on
from textual.content import Content
from textual.events import MouseDown, MouseMove, MouseUp
from textual.message import Message
from textual.widget import Widget

from fivtui.ranges import number_text
from fivtui.safety import Zone, Zones

_MARKER_GLYPH: Final = "●"
_BOUND_GLYPH: Final = "┼"
# Minimum columns of the bar.
_MIN_WIDTH: Final = 4
# Columns beside the label of a zone: on each side a blank, and at least one glyph of the zone.
_LABEL_PADDING: Final = 4
# Fewest significant digits of a bound; 17 digits identify any number.
_MIN_DIGITS: Final = 3
_MAX_DIGITS: Final = 17
# A value whose text is longer than this is rounded to `_VALUE_DIGITS`.
_MAX_TEXT_LENGTH: Final = 8
_VALUE_DIGITS: Final = 5
# Largest distance of a tick label from its centred position, in columns.
_LARGEST_OFFSET: Final = 6
# Ranges end at these multiples of a power of ten, and at 1.5 times the value or beyond.
_RANGE_ENDS: Final = (1.0, 1.5, 2.0, 3.0, 5.0, 7.5, 10.0)
_MIN_END_RATIO: Final = 1.5
# Relative rounding error of the end of a range.
_ROUNDING: Final = 1e-12
# A dragged value is a multiple of one of these times a power of ten.
_STEPS: Final = (5.0, 2.0, 1.0)
# Significant digits of a bound that is clicked, as in the facts beside the gauge.
_CLICKED_DIGITS: Final = 4
_LEFT_BUTTON: Final = 1
# Zones from the safest on.
_ZONES_BY_RISK: Final = (Zone.SAFE, Zone.SMALL, Zone.KNOCK, Zone.SQUEALS, Zone.NONE)
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
# Labels of zones, the longest first; labels of `SMALL` during the search.
_LABELS: Final = {
    Zone.SAFE: ("safe",),
    Zone.KNOCK: (str(Zone.KNOCK), "after a knock", "knock"),
    Zone.SQUEALS: (str(Zone.SQUEALS), "squeals"),
    Zone.SMALL: ("large disturbances: not known", "not known", "?"),
    Zone.NONE: (str(Zone.NONE),),
}
_SEARCHING: Final = ("large disturbances: searching…", "searching…", "…")

# Consecutive texts, each with its style.
StyledTexts = list[tuple[str, str]]


@dataclass(frozen=True, slots=True)
class Gauge:
    """The content of a gauge: the zones of a parameter, and the edited value."""

    # Symbol and unit of the parameter.
    label: str
    zones: Zones
    value: float
    # The text of the value in the form.
    text: str
    # Whether large disturbances are still being searched.
    searching: bool
    # Names of the methods that found the zones.
    basis: str

    def lines(self, width: int, marker_style: str = "bold") -> tuple[StyledTexts, StyledTexts]:
        """Two lines: the bar of zones, and below it the numbers at bounds and value."""
        margin, width = self._margin, self._bar_width(width)
        cells: StyledTexts = [(" ", "")] * width
        for value, first, text in self._tick_labels(width):
            style = "bold" if value == self.value else ""
            cells[first : first + len(text)] = [(letter, style) for letter in text]
        bar = [(margin, "bold"), *self._bar(width, marker_style)]
        return bar, [(" " * len(margin), ""), *_join_cells(cells)]

    def text_at(self, column: int, row: int, width: int) -> str:
        """Text of the value to which the mouse moves the marker at a cell of the two lines.

        At a bound or its number, this is the bound, rounded to four digits towards its safer side.
        Elsewhere it is a round number within the column, and at the marker the edited text.
        """
        column, width = column - len(self._margin), self._bar_width(width)
        labels = self._tick_labels(width) if row == 1 else []
        targets = [value for value, first, text in labels if 0 <= column - first < len(text)]
        column = min(max(column, 0), width - 1)
        low, *bounds, high = self.zones.bounds
        values = (self.value, low, high, *bounds)
        targets += [value for value in values if self._column(value, width) == column]
        if targets and targets[0] == self.value:
            return self.text
        if targets:
            return number_text(self._safe_bound(self.zones.bounds.index(targets[0])))
        column_width = (high - low) / (width - 1)
        decade = 10.0 ** math.floor(math.log10(column_width))
        step = next(digit * decade for digit in _STEPS if digit * decade <= column_width)
        value = round((low + column * column_width) / step) * step
        return number_text(float(f"{value:.12g}"))

    def _safe_bound(self, index: int) -> float:
        bounds, zones = self.zones.bounds, self.zones.zones
        if not 0 < index < len(zones):
            return bounds[index]
        below, above = map(_ZONES_BY_RISK.index, zones[index - 1 : index + 1])
        context = Context(_CLICKED_DIGITS, ROUND_FLOOR if below < above else ROUND_CEILING)
        return float(context.create_decimal_from_float(bounds[index]))

    @property
    def _margin(self) -> str:
        return f"{self.label} "

    def _bar_width(self, width: int) -> int:
        return max(width - len(self._margin), _MIN_WIDTH)

    def _column(self, value: float, width: int) -> int:
        low, high = self.zones.bounds[0], self.zones.bounds[-1]
        share = (value - low) / (high - low)
        return min(max(round(share * (width - 1)), 0), width - 1)

    def _bar(self, width: int, marker_style: str) -> StyledTexts:
        marker = self._column(self.value, width)
        bound_columns = [self._column(bound, width) for bound in self.zones.bounds]
        cells: StyledTexts = []
        for zone, (lower, upper) in zip(self.zones.zones, pairwise(bound_columns), strict=True):
            # The bound between two zones takes a column; the ends of the bar take none.
            first = lower + 1 if lower > 0 else 0
            reaches_end = upper == width - 1
            stop = width if reaches_end else upper
            style, glyphs = _STYLES[zone], list(_GLYPHS[zone] * (stop - first))
            # If the marker divides a zone, the label of the zone is in the larger part.
            parts = [(first, stop)]
            if first <= marker < stop:
                parts = [(first, marker), (marker + 1, stop)]
            part_first, part_stop = max(parts, key=lambda part: part[1] - part[0])
            self._write_label(zone, glyphs, part_first - first, part_stop - first)
            cells += [(glyph, style) for glyph in glyphs]
            if not reaches_end:
                cells.append((_BOUND_GLYPH, "bold"))
        # A zone that is narrower than a column still adds its bound: cut what is too wide.
        del cells[width:]
        cells[marker] = (_MARKER_GLYPH, marker_style)
        return _join_cells(cells)

    def _write_label(self, zone: Zone, glyphs: list[str], first: int, stop: int) -> None:
        # Replace the middle of `glyphs[first:stop]` by the longest label that fits.
        labels = _SEARCHING if zone is Zone.SMALL and self.searching else _LABELS[zone]
        room = stop - first - _LABEL_PADDING
        label = next((f" {label} " for label in labels if cell_len(label) <= room), "")
        start = first + (stop - first - len(label)) // 2
        glyphs[start : start + len(label)] = label

    def _tick_labels(self, width: int) -> list[tuple[float, int, str]]:
        # Value, first column and text of the labels: ascending, and separated by blanks.
        labels: list[tuple[float, int, str]] = []

        def add(value: float, text: str) -> None:
            below = [label for label in labels if label[0] < value]
            above = [label for label in labels if label[0] > value]
            lower = max((first + len(label) + 1 for _, first, label in below), default=0)
            upper = min((first - 1 for _, first, _ in above), default=width)
            first = _label_column(self._column(value, width), len(text), (lower, upper), width)
            # Close bounds may have the same text.
            is_repeated = any(float(label) == float(text) for _, _, label in labels)
            if first is not None and not is_repeated:
                labels.append((value, first, text))

        text = self.text
        if len(text) > _MAX_TEXT_LENGTH:
            text = f"{self.value:.{_VALUE_DIGITS}g}"
        add(self.value, text)
        bounds = self.zones.bounds
        # The ends of the range take precedence over other bounds.
        for bound in (bounds[0], bounds[-1], *bounds[1:-1]):
            if bound != self.value:
                add(bound, _bound_text(bound, self.value))
        return labels


def _bound_text(bound: float, value: float) -> str:
    # Round to the fewest digits that keep the bound on its side of the value.
    for digits in range(_MIN_DIGITS, _MAX_DIGITS):
        text = f"{bound:.{digits}g}"
        rounded = float(text)
        is_on_same_side = (rounded > value) is (bound > value)
        if is_on_same_side and rounded != value:
            return text
    return repr(bound)


def _label_column(column: int, length: int, free: tuple[int, int], width: int) -> int | None:
    # First column of a label within the free columns, centred at `column` if possible; None if the
    # label does not fit near `column`. `width` is that of the line.
    start, stop = free
    centred = min(max(column - length // 2, 0), width - length)
    first = min(max(centred, start), stop - length)
    return first if first >= start and abs(first - centred) <= _LARGEST_OFFSET else None


def _join_cells(cells: StyledTexts) -> StyledTexts:
    # Join neighbouring cells of one style.
    parts: StyledTexts = []
    for text, style in cells:
        if parts and parts[-1][1] == style:
            parts[-1] = (parts[-1][0] + text, style)
        else:
            parts.append((text, style))
    return parts


class GaugeView(Widget):
    """Draws a gauge in two lines, or a text in its place; the mouse drags the marker."""

    @dataclass
    class MarkerMoved(Message):
        """The mouse pressed, dragged or, if not `dragging`, released the marker of a parameter."""

        name: str
        text: str
        dragging: bool

    def __init__(self, *, id: str) -> None:  # noqa: A002
        super().__init__(id=id)
        self._content: Gauge | str = ""
        # The last message and column of the mouse, while it holds the marker.
        self._last_move: GaugeView.MarkerMoved | None = None
        self._column = 0

    def show(self, gauge: Gauge | str) -> None:
        """Display a gauge, or the reason for its absence."""
        if gauge != self._content:
            self._content = gauge
            self.refresh()

    def render(self) -> Content:
        """The two lines."""
        if isinstance(self._content, str):
            return Content(self._content)
        marker_style = "bold reverse" if self._last_move or self.mouse_hover else "bold"
        lines = self._content.lines(self.size.width, marker_style)
        return Content("\n").join(Content.assemble(*line) for line in lines)

    def watch_mouse_hover(self) -> None:
        """Highlight the marker below the mouse."""
        self.refresh()

    @on(MouseDown)
    def _grab(self, event: MouseDown) -> None:
        if event.button == _LEFT_BUTTON:
            self.capture_mouse()
            self._move_to(event.x, event.y)

    @on(MouseMove)
    def _drag(self, event: MouseMove) -> None:
        # The numbers of the second row are targets of clicks only.
        if self._last_move and event.x != self._column:
            self._move_to(event.x, 0)

    @on(MouseUp)
    def _release(self) -> None:
        if self._last_move:
            self.release_mouse()
            self.post_message(replace(self._last_move, dragging=False))
            self._last_move = None

    def _move_to(self, column: int, row: int) -> None:
        if isinstance(self._content, Gauge):
            self._column = column
            text = self._content.text_at(column, row, self.size.width)
            self._last_move = self.MarkerMoved(self._content.zones.name, text, dragging=True)
            self.post_message(self._last_move)


def round_range(value: float, lower: float, upper: float) -> tuple[float, float]:
    """A round range around a value, from 0 unless it is negative, within the allowed limits.

    Round ends stay the same during small edits of the value.
    """
    least_end = _MIN_END_RATIO * abs(value) or 1.0
    decade = 10.0 ** math.floor(math.log10(least_end))
    ends = (decade * multiple for multiple in _RANGE_ENDS)
    end = next((end for end in ends if end >= least_end * (1.0 - _ROUNDING)), 10.0 * decade)
    return max(-end if value < 0.0 else 0.0, lower), min(end, upper)
