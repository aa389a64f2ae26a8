"""A gauge: the zones of a parameter in which the slider is safe or squeals, and the edited value.

In a zone `SAFE` no disturbance was found to lead to squeal; in `KNOCK` a large one does, in
`SQUEALS` any. In `SMALL` small disturbances die out, and large ones were not searched. In `NONE`
there is no equilibrium.
"""

import math
from dataclasses import dataclass, replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from itertools import pairwise
from typing import Final, NamedTuple

from rich.cells import cell_len
from textual import on
from textual.content import Content
from textual.events import MouseDown, MouseMove, MouseUp
from textual.message import Message
from textual.reactive import reactive
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


class _Look(NamedTuple):
    style: str
    glyph: str
    # The longest first.
    labels: tuple[str, ...]


# From the safest zone on.
_LOOKS: Final = {
    Zone.SAFE: _Look("$text-success", "─", ("safe",)),
    Zone.SMALL: _Look("$text-muted", "·", ("large disturbances: not known", "not known", "?")),
    Zone.KNOCK: _Look("$text-warning", "╍", (str(Zone.KNOCK), "after a knock", "knock")),
    Zone.SQUEALS: _Look("$text-error", "━", (str(Zone.SQUEALS), "squeals")),
    Zone.NONE: _Look("$text-muted", " ", (str(Zone.NONE),)),
}
# Labels of the zone `SMALL` during the search.
_SEARCHING: Final = ("large disturbances: searching…", "searching…", "…")


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

    def lines(self, width: int, marker_style: str = "bold") -> tuple[Content, Content]:
        """Two lines: the bar of zones, and below it the numbers at bounds and value."""
        margin, width = self._margin, self._bar_width(width)
        numbers = [(" ", "")] * width
        for value, first, text in self._tick_labels(width):
            style = "bold" if value == self.value else ""
            numbers[first : first + len(text)] = [(digit, style) for digit in text]
        return (
            Content.assemble((margin, "bold"), *self._bar(width, marker_style)).simplify(),
            Content.assemble(" " * len(margin), *numbers).simplify(),
        )

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
        below, above = map(list(_LOOKS).index, zones[index - 1 : index + 1])
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

    def _bar(self, width: int, marker_style: str) -> list[tuple[str, str]]:
        # The cells of the bar: each a glyph with its style.
        marker = self._column(self.value, width)
        bounds = [self._column(bound, width) for bound in self.zones.bounds[1:-1]]
        cells = [(" ", "")] * width
        for zone, (lower, upper) in zip(
            self.zones.zones, pairwise([-1, *bounds, width]), strict=True
        ):
            look, glyphs = _LOOKS[zone], [_LOOKS[zone].glyph] * width
            # If the marker divides a zone, the label of the zone is in the larger part.
            edges = (lower, marker, upper) if lower < marker < upper else (lower, upper)
            start, stop = max(pairwise(edges), key=lambda part: part[1] - part[0])
            labels = _SEARCHING if zone is Zone.SMALL and self.searching else look.labels
            room = stop - start - 1 - _LABEL_PADDING
            label = next((f" {label} " for label in labels if cell_len(label) <= room), "")
            first = (start + 1 + stop - len(label)) // 2
            glyphs[first : first + len(label)] = label
            cells[lower + 1 : upper] = [(glyph, look.style) for glyph in glyphs[lower + 1 : upper]]
        for bound in bounds:
            cells[bound] = (_BOUND_GLYPH, "bold")
        cells[marker] = (_MARKER_GLYPH, marker_style)
        return cells

    def _tick_labels(self, width: int) -> list[tuple[float, int, str]]:
        # Value, first column and text of the labels, which are separated by blanks.
        is_long = len(self.text) > _MAX_TEXT_LENGTH
        texts = {self.value: f"{self.value:.{_VALUE_DIGITS}g}" if is_long else self.text}
        # The ends of the range take precedence over other bounds.
        low, *inner_bounds, high = self.zones.bounds
        for bound in (low, high, *inner_bounds):
            if bound != self.value:
                texts[bound] = _bound_text(bound, self.value)
        labels: list[tuple[float, int, str]] = []
        for value, text in texts.items():
            ends = [first + len(label) + 1 for x, first, label in labels if x < value]
            starts = [first for x, first, _ in labels if x > value]
            start, stop = max(ends, default=0), min(starts, default=width + 1) - 1
            # Centred below the value if possible.
            centred = min(max(self._column(value, width) - len(text) // 2, 0), width - len(text))
            first = min(max(centred, start), stop - len(text))
            # Close bounds may have the same text.
            is_repeated = any(float(label) == float(text) for _, _, label in labels)
            if start <= first and abs(first - centred) <= _LARGEST_OFFSET and not is_repeated:
                labels.append((value, first, text))
        return labels


def _bound_text(bound: float, value: float) -> str:
    # Round to the fewest digits that keep the bound on its side of the value.
    texts = (f"{bound:.{digits}g}" for digits in range(_MIN_DIGITS, _MAX_DIGITS + 1))
    return next(
        text for text in texts if float(text) != value and (float(text) > value) is (bound > value)
    )


class GaugeView(Widget):
    """Draws a gauge in two lines, or a text in its place; the mouse drags the marker."""

    @dataclass
    class MarkerMoved(Message):
        """The mouse pressed, dragged or, if not `dragging`, released the marker of a parameter."""

        name: str
        text: str
        dragging: bool

    # A gauge, or the reason for its absence.
    gauge: reactive[Gauge | str] = reactive("")
    # The last message and column of the mouse, while it holds the marker.
    _last_move: MarkerMoved | None = None
    _column = 0

    def render(self) -> Content:
        """The two lines."""
        if isinstance(self.gauge, str):
            return Content(self.gauge)
        marker_style = "bold reverse" if self._last_move or self.mouse_hover else "bold"
        return Content("\n").join(self.gauge.lines(self.size.width, marker_style))

    def watch_mouse_hover(self) -> None:
        """Highlight the marker below the mouse."""
        self.refresh()

    @on(MouseDown)
    def _grab(self, event: MouseDown) -> None:
        # A text in place of a gauge has no marker to drag.
        if event.button == _LEFT_BUTTON and isinstance(self.gauge, Gauge):
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
        if isinstance(self.gauge, Gauge):
            self._column = column
            text = self.gauge.text_at(column, row, self.size.width)
            self._last_move = self.MarkerMoved(self.gauge.zones.name, text, dragging=True)
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
