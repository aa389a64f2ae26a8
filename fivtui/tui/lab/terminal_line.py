"""The line to the terminal: its rate, and drawing in pieces where it is slow.

A frame that is written to a slow line, such as a serial one of 9600 baud, is displayed seconds
later. There, changed cells are written in pieces of a fraction of a second, the verdict first. Each
piece is drawn from the newest state when the terminal has read the piece before.
"""

import math
import time
from collections.abc import Callable, Iterable, Sequence
from itertools import product
from typing import Any, Final, cast

from rich.cells import cell_len
from rich.color import ColorSystem
from rich.console import Console
from rich.segment import Segment
from textual._compositor import CompositorUpdate, LayoutUpdate
from textual.app import App
from textual.events import CursorPosition
from textual.geometry import Region
from textual.screen import Screen
from textual.timer import Timer

from fivtui.tui.chart import Pictures, write_changes

# Duration of a piece on a slow line, s.
_PIECE_S: Final = 0.15
# A line is slow if it takes less than this rate, bytes/s, or if a frame takes this time, s. A
# frame waits if an answer takes that time.
_FAST_RATE: Final = 20e3
_SLOW_FRAME_S: Final = 0.4
# Rate of a slow line until it is measured, bytes/s: less than that of 9600 baud. Its largest
# increase by a piece.
_FIRST_RATE: Final = 900.0
_MAX_INCREASE: Final = 5.0
# Time after which an answer is not awaited any longer, s.
_LOST_ANSWER_S: Final = 5.0
_POLL_INTERVAL_S: Final = 0.02
# The terminal answers this query with the position of its cursor. The row tells whether the query
# stands before or after a piece, the column is the number of the piece; both from 0.
_QUERY: Final = "\x1b[{};{}H\x1b[6n"
_ROW_BEFORE: Final = 1
_ROW_AFTER: Final = 2
_PIECE_NUMBERS: Final = 32
_RESET_STYLE: Final = "\x1b[0m"
# Text that displays nothing, to measure the rate before the first frame.
_FIRST_PIECE: Final = _RESET_STYLE * 50

# A character and the codes of its style; the text is empty for the second half of a wide character.
Cell = tuple[str, str]
_UNKNOWN_CELL: Final[Cell] = ("unknown", "")


class LineRate:
    """Rate of a line, by the answers of the terminal to queries before and after each piece.

    The line of a terminal that has not answered counts as one of 9600 baud.
    """

    def __init__(self) -> None:
        # In bytes/s.
        self._rate = _FIRST_RATE
        # Bytes of the last piece, and the time (s) of writing it; None if the terminal has read it.
        self._size = 0
        self._write_time: float | None = None
        # Whether the terminal has answered any query.
        self.has_answered = False

    @property
    def is_fast(self) -> bool:
        """Whether to write whole frames."""
        return self._rate >= _FAST_RATE

    @property
    def is_free(self) -> bool:
        """Whether the terminal has read the last piece."""
        return self._write_time is None

    def budget(self, time_s: float) -> float:
        """Bytes to write at `time_s`, s: infinite on a fast line, 0 to wait."""
        if self._write_time is not None:
            waiting_time = time_s - self._write_time
            if waiting_time > (_LOST_ANSWER_S if self.has_answered else self._size / _FIRST_RATE):
                self._write_time = None
            elif not self.is_fast or waiting_time > _SLOW_FRAME_S:
                return 0.0
        return math.inf if self.is_fast else self._rate * _PIECE_S

    def write(self, size: int, time_s: float) -> None:
        """Record that a piece was written; `size` is 0 for a frame that is not measured."""
        self._size, self._write_time = size, time_s

    def measure(self, duration: float) -> None:
        """Record that the terminal has read the last piece in `duration` s."""
        self._write_time = None
        if self.is_fast:
            if duration > _SLOW_FRAME_S:
                self._rate = _FIRST_RATE
        elif self._size:
            # Buffers take a small piece at once, so it cannot measure a higher rate.
            is_full = self._size > self._rate * _PIECE_S
            limit = self._rate * (_MAX_INCREASE if is_full else 1.0)
            self._rate = min(self._size / max(duration, 1e-6), limit)


class _Frame(CompositorUpdate):
    # An update of the screen, and texts before and after it.

    def __init__(self, update: CompositorUpdate, after: str, before: str = "") -> None:
        self._update, self._after, self._before = update, after, before

    def render_segments(self, console: Console) -> str:
        return f"{self._before}{self._update.render_segments(console)}{self._after}"


class TerminalLine:
    """Fits what is written to the line: updates of the screen with pictures, or pieces.

    Pictures are given up on a line that becomes slow.
    """

    def __init__(
        self, app: App[None], pictures: Pictures, urgent_regions: Callable[[], Iterable[Region]]
    ) -> None:
        self._app, self._pictures = app, pictures
        # Parts of the screen that are drawn first.
        self._urgent_regions = urgent_regions
        self._rate = LineRate()
        self._is_open = False
        # Number of the last piece, and the time of the answer to the query before it, s.
        self._number = 0
        self._answer_time = 0.0
        # While the line is slow: the timer, the displayed cells, and whether there may be changes.
        self._timer: Timer | None = None
        self._cells: list[list[Cell]] = []
        self._is_outdated = False

    def open(self, write: Callable[[str], None]) -> None:
        """Measure the rate of the line before the first frame; `write` sends text to it."""
        self._is_open = True
        write(self._piece(_FIRST_PIECE).render_segments(self._app.console))

    @property
    def is_slow(self) -> bool:
        """Whether changes are written in pieces."""
        return self._timer is not None

    def forget_cells(self) -> None:
        """Draw all cells again, because a terminal that changes its size may lose some."""
        self._cells = []

    @property
    def awaits_answer(self) -> bool:
        """Whether the terminal will answer a query."""
        return self._rate.has_answered and not self._rate.is_free

    def fit(self, screen: Screen[Any], update: CompositorUpdate) -> CompositorUpdate | None:
        """What to write for an update: on a slow line a piece of all changes, or nothing yet."""
        budget = self._rate.budget(time.monotonic()) if self._is_open else math.inf
        if math.isinf(budget):
            if self._timer is not None:
                self._timer.stop()
                self._timer, self._cells = None, []
                update = self._full_update(screen)
            is_free = self._rate.is_free
            pictures = self._pictures.text(screen, update, may_send=is_free)
            if self._is_open and is_free:
                return self._between_queries(update, pictures)
            return _Frame(update, pictures)
        if self._timer is None:
            self._timer = self._app.set_interval(_POLL_INTERVAL_S, self._continue)
        text = self._changes(screen, budget) if budget else ""
        self._is_outdated = bool(text) or not budget
        return self._piece(text) if text else None

    def answer(self, event: CursorPosition) -> None:
        """Handle the answer of the terminal to a query."""
        self._rate.has_answered = True
        if (event.x, event.y) == (self._number, _ROW_BEFORE):
            self._answer_time = event.time
        elif (event.x, event.y) == (self._number, _ROW_AFTER):
            was_fast = self._rate.is_fast
            self._rate.measure(event.time - self._answer_time)
            if was_fast and not self._rate.is_fast:
                self._pictures.stop("the terminal reads them too slowly")
            self._continue()
            self._pictures.resume()

    def _continue(self) -> None:
        # On a slow line, write the next piece if the terminal has read the last one; leave a line
        # that has become fast to whole frames.
        if self._timer is None or not self._app.is_running:
            return
        budget = self._rate.budget(time.monotonic())
        if math.isinf(budget) or (budget and self._is_outdated):
            write_changes(self._app)

    def _full_update(self, screen: Screen[Any]) -> LayoutUpdate:
        stack = self._app._background_screens
        update = screen._compositor.render_update(full=True, screen_stack=stack)
        return cast("LayoutUpdate", update)

    def _changes(self, screen: Screen[Any], budget: float) -> str:
        color_system = self._app.console._color_system
        rows = [
            [cell for strip in strips for cell in _cells_of(strip, color_system)]
            for strips in self._full_update(screen).strips
        ]
        if [len(row) for row in rows] != [len(row) for row in self._cells]:
            self._cells = [[_UNKNOWN_CELL] * len(row) for row in rows]
        # The screen has the size of the terminal unless its layout is to follow.
        area = screen.region.intersection(self._app.size.region)
        regions = [region.intersection(area) for region in self._urgent_regions()]
        return changed_text(self._cells, rows, [*regions, area], budget)

    def _piece(self, text: str) -> _Frame:
        text += _RESET_STYLE
        return self._between_queries(CompositorUpdate(), text, len(text.encode()))

    def _between_queries(self, update: CompositorUpdate, text: str, size: int = 0) -> _Frame:
        # `size` is 0 for a frame that is not measured.
        self._number = (self._number + 1) % _PIECE_NUMBERS
        before, after = (
            _QUERY.format(row + 1, self._number + 1) for row in (_ROW_BEFORE, _ROW_AFTER)
        )
        self._rate.write(size and size + len(before + after), time.monotonic())
        return _Frame(update, text + after, before)


def changed_text(
    displayed: list[list[Cell]],
    rows: Sequence[Sequence[Cell]],
    regions: Iterable[Region],
    budget: float,
) -> str:
    """The text that draws what differs from the displayed cells, which it changes accordingly.

    It begins with the first region, and ends when it has as many bytes as the budget.
    """
    parts: list[str] = []
    size = 0
    # The cursor, and the style in which it writes.
    cursor, codes = (-1, -1), ""
    for region in regions:
        for y, x in product(region.line_range, region.column_range):
            row = rows[y]
            if row[x] == displayed[y][x]:
                continue
            if size >= budget:
                return "".join(parts)
            # Both halves of a wide character are written together.
            first = x if cursor == (x, y) or row[x][0] else x - 1
            part = "" if cursor == (first, y) else f"\x1b[{y + 1};{first + 1}H"
            for text, cell_codes in row[first : x + 1]:
                part += text if cell_codes == codes else f"\x1b[0;{cell_codes}m{text}"
                codes = cell_codes
            displayed[y][x] = row[x]
            cursor = x + 1, y
            parts.append(part)
            size += len(part.encode())
    return "".join(parts)


def _cells_of(strip: Iterable[Segment], color_system: ColorSystem | None) -> list[Cell]:
    cells: list[Cell] = []
    for text, style, _control in strip:
        codes = style._make_ansi_codes(color_system) if style and color_system else ""
        for character in text:
            width = cell_len(character)
            if width:
                cells += [(character, codes), ("", codes)][:width]
            elif cells:
                # A combining character.
                cells[-1] = (cells[-1][0] + character, codes)
    return cells
