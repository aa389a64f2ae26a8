"""Drawing on a slow line: changes in pieces, the verdict first, the newest state at the end."""

import itertools
import math
import re
from collections.abc import Iterator

import pytest
from hypothesis import given, strategies as st
from textual.drivers.headless_driver import HeadlessDriver
from textual.events import CursorPosition
from textual.geometry import Region
from textual.pilot import Pilot

from fivtui.tui.app import FivtuiApp
from fivtui.tui.lab.terminal_line import Cell, LineRate, changed_text
from tests.support.laboratory import HANG_S, app_of, text_of, until_still

SIZE = (80, 24)
# Of 9600 baud, in bytes/s.
RATE = 960.0
# The field of μ in the form.
VALUE = re.compile(r"│.μ +([\d.]+)")
TOKEN = re.compile(r"\x1b\[([?\d;]*)([A-Za-z])|\x1b[78]|([^\x1b])", re.DOTALL)


class Screen:
    """The cells of a terminal that executes what is written."""

    def __init__(self, width: int, height: int) -> None:
        self.cells: list[list[Cell]] = [[(" ", "")] * width for _ in range(height)]
        self.x = self.y = 0
        self.codes = ""

    def execute(self, token: re.Match[str]) -> None:
        parameters, command, character = token.groups()
        if character and character != "\n":
            self.cells[self.y][self.x] = (character, self.codes)
            self.x += 1
            if character == "漢":
                self.cells[self.y][self.x] = ("", self.codes)
                self.x += 1
        elif command == "H":
            self.y, self.x = (int(number) - 1 for number in parameters.split(";"))
        elif command == "m":
            # Every style replaces that before.
            self.codes = re.sub("^0;?", "", parameters)

    @property
    def lines(self) -> list[str]:
        return ["".join(text for text, _ in row) for row in self.cells]


styles = st.sampled_from(["", "1", "4;38;2;1;2;3", "38;2;1;2;3;48;2;9;9;9"])


@st.composite
def rows(draw: st.DrawFn, width: int = 12, height: int = 3) -> list[list[Cell]]:
    """Rows of styled cells, some of them halves of wide characters."""
    result = []
    for _ in range(height):
        row: list[Cell] = []
        while len(row) < width:
            codes = draw(styles)
            character = draw(st.sampled_from("ab漢" if len(row) < width - 1 else "ab"))
            row += [(character, codes), ("", codes)][: 2 if character == "漢" else 1]
        result.append(row)
    return result


@given(rows(), rows(), st.integers(1, 200))
def test_pieces_of_changes_draw_the_new_cells(
    old: list[list[Cell]], new: list[list[Cell]], budget: int
) -> None:
    screen, displayed = Screen(12, 3), [list(row) for row in old]
    screen.cells = [list(row) for row in old]
    for _ in range(100):
        piece = changed_text(displayed, new, [Region(4, 1, 5, 1), Region(0, 0, 12, 3)], budget)
        # A change is not divided: it moves the cursor, sets a style and writes a few characters.
        assert len(piece.encode()) < budget + 150
        for token in TOKEN.finditer(piece + "\x1b[0m"):
            screen.execute(token)
        if not piece:
            break
    assert screen.cells == displayed == new


def test_changes_begin_in_the_first_region() -> None:
    old: list[list[Cell]] = [[("a", "")] * 9 for _ in range(9)]
    new: list[list[Cell]] = [[("b", "")] * 9 for _ in range(9)]
    piece = changed_text(old, new, [Region(2, 5, 3, 1), Region(0, 0, 9, 9)], 14.0)
    assert piece == "\x1b[6;3Hbbb\x1b[1;1Hb"


def answer_piece(rate: LineRate, size: int, now: float, bytes_per_s: float) -> float:
    # The time at which a line of this rate has taken a piece that is written now.
    rate.write(size, now)
    assert math.isinf(rate.budget(now)) or rate.budget(now + 0.01) == 0.0
    duration = size / bytes_per_s
    rate.measure(duration)
    return now + duration


def test_answers_measure_the_rate_of_a_line() -> None:
    rate, now = LineRate(), 0.2
    rate.write(200, 0.0)
    rate.has_answered = True
    rate.measure(200 / RATE)
    for _ in range(9):
        # A piece lasts a fraction of a second.
        size = int(rate.budget(now))
        assert 0.1 < size / RATE < 0.3
        now = answer_piece(rate, size + 30, now, RATE)
    # Small pieces, such as a blinking cursor, raise no rate.
    for _ in range(9):
        now = answer_piece(rate, 60, now, 1e6)
    assert 0.1 < rate.budget(now) / RATE < 0.3
    # The line becomes fast; a frame waits for a late answer.
    while not math.isinf(budget := rate.budget(now)):
        now = answer_piece(rate, int(budget) + 30, now, 1e6)
    rate.write(0, now)
    assert math.isinf(rate.budget(now + 0.1))
    assert rate.budget(now + 1.0) == 0.0
    # A lost answer does not stop the display.
    assert math.isinf(rate.budget(now + 10.0))
    # A frame that takes long shows that the line is slow.
    rate.write(0, now)
    rate.measure(1.0)
    assert 0.0 < rate.budget(now + 1.0) < math.inf


def test_a_terminal_that_does_not_answer_gets_pieces_at_the_rate_of_a_slow_line() -> None:
    rate, now, size = LineRate(), 0.0, 0
    while now < 10.0:
        if budget := rate.budget(now):
            assert 0.1 < budget / RATE < 0.3
            rate.write(int(budget), now)
            size += int(budget)
        now += 0.01
    assert 0.7 < size / (10.0 * RATE) < 1.0


class SlowTerminal:
    """A terminal behind a slow line that reads when the test wants it to."""

    def __init__(self, app: FivtuiApp) -> None:
        self.app = app
        self.screen = Screen(*SIZE)
        self.unread = ""
        self.read_count = 0
        self.time, self.seconds_per_byte = 0.0, 1.0 / RATE

    @property
    def is_slow(self) -> bool:
        return self.app._line._timer is not None

    def write(self, text: str) -> None:
        self.unread += text

    def read(self) -> Iterator[None]:
        """Execute all unread text, and stop after each piece; answer queries in the time needed."""
        while match := TOKEN.match(self.unread):
            self.unread = self.unread[match.end() :]
            size = len(match[0].encode())
            self.read_count += size
            self.time += size * self.seconds_per_byte
            self.screen.execute(match)
            if match[2] == "n":
                event = CursorPosition(self.screen.x, self.screen.y)
                event.time = self.time
                self.app.post_message(event)
                yield


@pytest.fixture
async def terminal(pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch) -> SlowTerminal:
    app = app_of(pilot)
    slow_terminal = SlowTerminal(app)
    # `HeadlessDriver` is the driver of tests, which writes nothing.
    monkeypatch.setattr("tests.support.laboratory.every_frame", True)
    monkeypatch.setattr(HeadlessDriver, "is_headless", False)
    monkeypatch.setattr(HeadlessDriver, "write", lambda _, text: slow_terminal.write(text))
    monkeypatch.setattr("fivtui.tui.lab.terminal_line._LOST_ANSWER_S", HANG_S)
    app._line.open(slow_terminal.write)
    app.refresh()
    await read_all(pilot, slow_terminal)
    return slow_terminal


async def read_all(pilot: Pilot[None], terminal: SlowTerminal) -> list[tuple[int, list[str]]]:
    """Read until all is displayed; the number of bytes and the lines of the screen by piece."""
    screens = []
    while terminal.screen.lines != text_of(pilot).splitlines():
        screens += [(terminal.read_count, terminal.screen.lines) for _ in terminal.read()]
        await pilot.pause(0.01)
    return screens


async def test_a_slow_line_gets_the_verdict_before_the_charts(
    pilot: Pilot[None], terminal: SlowTerminal
) -> None:
    before, first_count = terminal.screen.lines, terminal.read_count
    await pilot.press("up")
    await until_still(pilot)
    after = text_of(pilot).splitlines()
    screens = await read_all(pilot, terminal)
    # Field and verdict are complete in a fraction of a second, before a chart changes.
    count = next(count for count, lines in screens if lines[:5] == after[:5])
    assert count - first_count < 0.6 * RATE
    for _, lines in screens:
        chart, chart_before = ([line[32:] for line in part[6:-1]] for part in (lines, before))
        assert chart == chart_before or lines[:5] == after[:5]
    assert any("0.71" in line for line in after[5:])
    assert terminal.read_count - first_count < 3 * RATE


async def test_a_slow_line_shows_the_last_value_of_a_held_key(
    pilot: Pilot[None], terminal: SlowTerminal
) -> None:
    first_count = terminal.read_count
    for _ in range(12):
        await pilot.press("up")
    # One piece waits to be read, whatever changes in the meantime.
    assert len(terminal.unread.encode()) < 0.3 * RATE
    await until_still(pilot)
    screens = await read_all(pilot, terminal)
    values = [float(value) for _, lines in screens for value in VALUE.findall("\n".join(lines))]
    assert values == sorted(values)
    assert values[-1] == 0.82
    assert terminal.read_count - first_count < 6 * RATE


async def test_a_fast_line_gets_frames_again(pilot: Pilot[None], terminal: SlowTerminal) -> None:
    terminal.seconds_per_byte = 1e-6
    # The line is measured with what changes; a busy machine reads some of it late.
    for key in itertools.cycle(("alt+2", "alt+1")):
        await pilot.press(key)
        await until_still(pilot)
        await read_all(pilot, terminal)
        await until_still(pilot)
        if not terminal.is_slow:
            break
    await pilot.press("up")
    assert "\x1b[6n" in terminal.unread
    await read_all(pilot, terminal)


async def test_a_slow_line_draws_all_cells_after_a_storm_of_sizes(
    pilot: Pilot[None], terminal: SlowTerminal
) -> None:
    first_count = terminal.read_count
    for width in (70, 60, SIZE[0]):
        await pilot.resize_terminal(width, SIZE[1])
        list(terminal.read())
    # Until sizes stop changing, none is drawn.
    assert terminal.read_count - first_count < RATE
    terminal.screen = Screen(*SIZE)
    await read_all(pilot, terminal)
