"""The line to the terminal: its rate, and drawing in pieces where it is slow.

A frame that is written to a slow line, such as a serial one of 9600 baud, is displayed seconds
later. There, changed cells are written in pieces of a fraction of a second, the verdict first. Each
piece is drawn from the newest state when the terminal has read the piece before.
"""

import math
import re
import select
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from functools import lru_cache
from typing import TYPE_CHECKING, Final, cast

from rich.cells import cell_len
from rich.segment import Segment
from rich.style import Style
from textual.app import App
from textual.events import CursorPosition
from textual.geometry import Region
from textual.timer import Timer

if TYPE_CHECKING:
    from rich.color import ColorSystem
    from textual._compositor import LayoutUpdate

# Duration of a piece on a slow line, s.
_PIECE_S: Final = 0.15
# A line is slow if it takes less than this rate, bytes/s, or if an answer takes this time, s.
_FAST_RATE: Final = 20e3
_SLOW_ANSWER_S: Final = 0.4
# Rate of a slow line until it is measured, bytes/s, and its largest increase by a piece of at most
# the following size, bytes.
_FIRST_RATE: Final = 1000.0
_MAX_INCREASE: Final = 4.0
_BURST_SIZE: Final = 400
# Time after which an answer is not awaited any longer, s.
_LOST_ANSWER_S: Final = 5.0
_POLL_INTERVAL_S: Final = 0.02
# For terminals that do not answer: bytes that the system buffers (Linux), and the part of the rate
# measured with them that is relied on.
_BUFFER_SIZE: Final = 20000
_RATE_MARGIN: Final = 0.8
# The terminal answers this query with the position of its cursor. The row tells whether the query
# stands before or after a piece, the column is the number of the piece; both from 0.
_QUERY: Final = "\x1b[{};{}H\x1b[6n"
_ROW_BEFORE: Final = 1
_ROW_AFTER: Final = 2
_PIECE_NUMBERS: Final = 32
_SAVE_CURSOR: Final = "\x1b7"
_RESTORE_CURSOR: Final = "\x1b8"
_RESET_STYLE: Final = "\x1b[0m"
# Text that displays nothing, to measure the rate before the first frame.
_FIRST_PIECE: Final = _RESET_STYLE * 50
# Longest row of unchanged cells that is written rather than skipped.
_MAX_GAP: Final = 4
_STYLE_SEQUENCE: Final = re.compile(r"\x1b\[([\d;]*)m")
_STYLE_CODE: Final = re.compile(r"[34]8;(?:2;\d+;\d+;\d+|5;\d+)|\d+")

# Codes of a style in the escape sequence that sets it.
Codes = frozenset[str]
# A character and its style; the text is empty for the second half of a wide character.
Cell = tuple[str, Codes]
_UNKNOWN_CELL: Final[Cell] = ("unknown", frozenset())


class AnsweredRate:
    """Rate of a line whose terminal answers queries before and after each piece."""

    def __init__(self, size: int, write_time: float) -> None:
        # Bytes of the last piece, and the time (s) of writing it; None if the terminal has read it.
        self._size = size
        self._write_time: float | None = write_time
        # In bytes/s.
        self._rate = _FIRST_RATE
        self._is_late = False

    @property
    def slow(self) -> bool:
        """Whether to write in pieces."""
        return self._rate < _FAST_RATE or self._is_late

    @property
    def is_settled(self) -> bool:
        """Whether no answer is awaited."""
        return self._write_time is None

    def budget(self, time_s: float, *, blocked: bool) -> float:  # noqa: ARG002
        """Bytes to write at `time_s`, s: infinite on a fast line, 0 to wait."""
        waiting_time = 0.0 if self._write_time is None else time_s - self._write_time
        if waiting_time > _SLOW_ANSWER_S:
            self._rate = min(self._rate, _FIRST_RATE)
        if not self.slow:
            return math.inf
        return 0.0 if 0.0 < waiting_time < _LOST_ANSWER_S else self._rate * _PIECE_S

    def write(self, size: int, time_s: float) -> None:
        """Record that a piece was written; `size` is 0 for a frame of unknown size."""
        self._size, self._write_time = size, time_s

    def answer(self, duration: float, time_s: float) -> None:
        """Record that the terminal has read the last piece in `duration` s."""
        if self._write_time is None:
            return
        self._is_late = time_s - self._write_time > _SLOW_ANSWER_S
        self._write_time = None
        if self._size:
            # Buffers take a small piece at once, so it cannot measure a higher rate.
            is_full = self._size > self._rate * _PIECE_S
            increase = _MAX_INCREASE if is_full else 1.0
            limit = math.inf if self._size > _BURST_SIZE else self._rate * increase
            self._rate = min(self._size / max(duration, 1e-6), limit)


class BlockingRate:
    """Rate of a line whose terminal does not answer: of writes while the buffer is full."""

    def __init__(self) -> None:
        # In bytes/s; infinite until it is measured.
        self._rate = math.inf
        # Bytes of the last piece.
        self.size = 0
        # Times, in s: at which the terminal has read all pieces, and at which the buffer was full.
        # Frames wait for the first answer, which would measure the rate.
        self._free_time = time.monotonic() + _SLOW_ANSWER_S
        self._block_time: float | None = None
        self.slow = True

    def budget(self, time_s: float, *, blocked: bool) -> float:
        """Bytes to write at `time_s`, s: infinite on a fast line, 0 to wait."""
        if blocked:
            self._block_time = self._block_time or time_s
        elif self._block_time is not None:
            # A full buffer accepts bytes again when it is nearly empty.
            rate = _RATE_MARGIN * _BUFFER_SIZE / (time_s - self._block_time)
            self._rate = rate if rate > _FAST_RATE else min(self._rate, rate)
            self._block_time = None
        is_free = self._block_time is None and time_s >= self._free_time
        self.slow = self._rate < _FAST_RATE or not is_free
        if not is_free:
            return 0.0
        return self._rate * _PIECE_S if self.slow else math.inf

    def write(self, size: int, time_s: float) -> None:
        """Record that a piece was written."""
        self.size = size
        self._free_time = max(time_s, self._free_time) + size / self._rate


class TerminalLine:
    """Displays frames: at once, or in pieces while the line is slow."""

    def __init__(self, app: App[None], urgent_regions: Callable[[], Iterable[Region]]) -> None:
        self._app = app
        # Parts of the screen that are drawn first.
        self._urgent_regions = urgent_regions
        self._rate: AnsweredRate | BlockingRate = BlockingRate()
        # Number and time of the last piece, and time of the answer to the query before it, s.
        self._number = 0
        self._write_time = self._answer_time = 0.0
        # While the line is slow: the timer, the displayed cells, and whether there may be changes.
        self._timer: Timer | None = None
        self._cells: list[list[Cell]] = []
        self._is_outdated = False

    def open(self) -> None:
        """Measure the rate of the line before the first frame."""
        self._rate = BlockingRate()
        self._write_piece(_FIRST_PIECE)

    @property
    def is_settled(self) -> bool:
        """Whether no answer of the terminal is awaited."""
        return isinstance(self._rate, BlockingRate) or self._rate.is_settled

    def display(self, display_frame: Callable[[], None]) -> None:
        """Display a frame by a function, or on a slow line the newest state in pieces."""
        budget, self._is_outdated = self._budget(), True
        if self._timer is not None or math.isfinite(budget):
            if self._timer is None:
                self._timer = self._app.set_interval(_POLL_INTERVAL_S, self._continue)
            self._continue()
        elif isinstance(self._rate, AnsweredRate) and self._rate.is_settled:
            self._write(_SAVE_CURSOR + self._begin_query() + _RESTORE_CURSOR)
            display_frame()
            self._write(_SAVE_CURSOR + self._end_query() + _RESTORE_CURSOR)
            self._rate.write(0, self._write_time)
        else:
            display_frame()

    def answer(self, event: CursorPosition) -> None:
        """Handle the answer of the terminal to a query."""
        if event.x != self._number:
            return
        if isinstance(self._rate, BlockingRate):
            self._rate = AnsweredRate(self._rate.size, self._write_time)
        if event.y == _ROW_BEFORE:
            self._answer_time = event.time
        elif event.y == _ROW_AFTER:
            self._rate.answer(event.time - self._answer_time, event.time)
            self._continue()

    def _budget(self) -> float:
        return self._rate.budget(time.monotonic(), blocked=_is_blocked())

    def _continue(self) -> None:
        # On a slow line, write the next piece if the terminal has read the last one.
        budget = self._budget()
        if (
            self._timer is None
            or budget == 0.0
            or self._app._batch_count
            or not self._app.is_running
        ):
            return
        text = self._changes(budget) if self._is_outdated else ""
        self._is_outdated = bool(text)
        if text:
            self._write_piece(text)
        elif not self._rate.slow:
            self._timer.stop()
            self._timer, self._cells = None, []

    def _changes(self, budget: float) -> str:
        screen = self._app.screen
        update = screen._compositor.render_update(
            full=True, screen_stack=self._app._background_screens
        )
        color_system = self._app.console._color_system
        rows = [
            [cell for strip in strips for cell in _cells_of(strip, color_system)]
            for strips in cast("LayoutUpdate", update).strips
        ]
        if [len(row) for row in rows] != [len(row) for row in self._cells]:
            self._cells = [[_UNKNOWN_CELL] * len(row) for row in rows]
        regions = [region.intersection(screen.region) for region in self._urgent_regions()]
        return changed_text(self._cells, rows, [*regions, screen.region], budget)

    def _write_piece(self, text: str) -> None:
        text = self._begin_query() + text + _RESET_STYLE + self._end_query()
        self._write(text)
        self._rate.write(len(text.encode()), self._write_time)

    def _begin_query(self) -> str:
        self._number = (self._number + 1) % _PIECE_NUMBERS
        return _QUERY.format(_ROW_BEFORE + 1, self._number + 1)

    def _end_query(self) -> str:
        self._write_time = time.monotonic()
        return _QUERY.format(_ROW_AFTER + 1, self._number + 1)

    def _write(self, text: str) -> None:
        driver = self._app._driver
        if driver is not None:
            driver.write(text)
            driver.flush()


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
    line, next_x, codes = -1, -1, frozenset[str]()
    for region in regions:
        for y in region.line_range:
            row, displayed_row = rows[y], displayed[y]
            for x in region.column_range:
                if row[x] == displayed_row[x]:
                    continue
                if size >= budget:
                    return "".join(parts)
                first = next_x if line == y and 0 <= x - next_x <= _MAX_GAP else x
                change = ""
                if (line, next_x) != (y, first):
                    # Both halves of a wide character are written together.
                    first -= not row[x][0]
                    change = f"\x1b[{y + 1};{first + 1}H"
                for text, next_codes in row[first : x + 1]:
                    change += _style_change(codes, next_codes) + text
                    codes = next_codes
                displayed_row[x] = row[x]
                line, next_x = y, x + 1
                parts.append(change)
                size += len(change.encode())
    return "".join(parts)


def _style_change(old: Codes, new: Codes) -> str:
    # A colour replaces one of the same kind; other codes end only with all others.
    if old == new:
        return ""
    replaced = {code[:3] for code in new - old}
    is_replacement = all(code[:3] in replaced for code in old - new)
    return f"\x1b[{';'.join(sorted(new - old) if is_replacement else ['0', *sorted(new)])}m"


@lru_cache(maxsize=4096)
def _style_codes(style: Style | None, color_system: "ColorSystem | None") -> Codes:
    if style is None:
        return frozenset()
    match = _STYLE_SEQUENCE.match(style.render(" ", color_system=color_system))
    return frozenset(_STYLE_CODE.findall(match[1]) if match else ())


def _cells_of(strip: Iterable[Segment], color_system: "ColorSystem | None") -> list[Cell]:
    cells: list[Cell] = []
    for text, style, _control in strip:
        codes = _style_codes(style, color_system)
        for character in text:
            width = cell_len(character)
            if width:
                cells += [(character, codes), ("", codes)][:width]
            elif cells:
                # A combining character.
                cells[-1] = (cells[-1][0] + character, codes)
    return cells


def _is_blocked() -> bool:
    # Whether a write to the terminal, by Textual to standard error, would block; never on Windows,
    # where this is unknown.
    with suppress(OSError, ValueError):
        return (
            sys.__stderr__ is not None
            and not select.select([], [sys.__stderr__.fileno()], [], 0.0)[1]
        )
    return False
