"""Charts as pictures, in terminals that answer that they can show them."""

import itertools
import os
import re
import select
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from textual.app import App
from textual.events import Key
from textual.geometry import Region
from textual.pilot import Pilot

from fivtui.charts import mix, plot_pixels
from fivtui.tui.chart import ChartView, TerminalReply
from fivtui.tui.chart.graphics import GRAPHICS_QUERY
from fivtui.tui.chart.picture import axis_ticks
from fivtui.tui.chart.widget.pictures import _REPLY, _ReplyParser
from fivtui.tui.tabs.studies.sweep import SweepPane
from tests.support import laboratory
from tests.support.laboratory import (
    HANG_S,
    app_of,
    run_to_end,
    show_tab,
    text_of,
    until,
    until_notice,
    until_still,
)
from tests.support.sixel import SIXEL, decode_sixel

KITTY, CELL = "\x1b_Gi=31;OK\x1b\\", "\x1b[6;20;10t"
# Attributes with and without sixel.
SIXEL_ATTRIBUTES, PLAIN_ATTRIBUTES = "\x1b[?62;4;22c", "\x1b[?64;1;2;6;9;15;16;17;18;21;22;28;29c"
BRAILLE = re.compile("[⠁-⣿]")
MOVE = re.compile(r"\x1b\[(\d+);(\d+)H\Z")


@pytest.mark.parametrize("reply", [KITTY, CELL, SIXEL_ATTRIBUTES, PLAIN_ATTRIBUTES])
def test_answers_are_not_taken_for_keys_even_in_two_parts(reply: str) -> None:
    text = f"a{reply}b"
    # A shorter first part may be a key.
    for position in range(5, len(text)):
        parser = _ReplyParser()
        events = [*parser.feed(text[:position]), *parser.feed(text[position:])]
        assert [event.key for event in events if isinstance(event, Key)] == ["a", "b"], position
        assert sum(isinstance(event, TerminalReply) for event in events) == 1
        assert len(events) == 3


def test_keys_that_begin_like_answers_are_not_held_back() -> None:
    parser = _ReplyParser()
    assert [event.key for event in parser.feed("\x1b[6~") if isinstance(event, Key)] == ["pagedown"]
    assert [event.key for event in parser.feed("\x1b[A") if isinstance(event, Key)] == ["up"]


@dataclass
class Screen:
    """What a terminal would receive."""

    pilot: Pilot[None]
    frames: list[str] = field(default_factory=list)

    def write(self, text: str) -> None:
        self.frames.append(text)

    def answer(self, *replies: str) -> None:
        for reply in replies:
            match = _REPLY.fullmatch(reply)
            assert match is not None
            self.pilot.app.post_message(TerminalReply(match))

    def text(self) -> str:
        return "".join(self.frames)


@pytest.fixture
async def screen(pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch) -> Screen:
    recorded = Screen(pilot)
    paint = App._display

    def display(app: App[None], screen: Any, update: Any) -> None:
        paint(app, screen, update)
        if update is not None:
            recorded.write(update.render_segments(app.console))

    await show_tab(pilot, "alt+1")
    await run_to_end(pilot)
    await until_still(pilot)
    monkeypatch.setattr(App, "_display", display)
    monkeypatch.setattr(laboratory, "every_frame", True)
    app_of(pilot)._pictures.start(recorded.write)
    return recorded


def is_shown(screen: Screen) -> bool:
    pictures = app_of(screen.pilot)._pictures
    return bool(pictures._visible) and all(
        chart in pictures._shown and pictures._shown[chart].plot == plot
        for chart, plot in pictures._visible.items()
    )


async def test_after_a_failure_charts_stay_in_characters_and_the_failure_is_reported(
    screen: Screen, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ValueError("no room")

    monkeypatch.setattr("fivtui.charts.plot_pixels", fail)
    screen.answer(CELL, SIXEL_ATTRIBUTES)
    await until_notice(screen.pilot, "pictures are off: a chart cannot be drawn: ValueError")
    assert not SIXEL.search(screen.text())
    assert "⢕" in text_of(screen.pilot)


async def test_a_terminal_with_sixel_shows_the_figures_of_the_charts(screen: Screen) -> None:
    assert GRAPHICS_QUERY in screen.text()
    screen.answer(CELL, SIXEL_ATTRIBUTES)
    await until(screen.pilot, lambda: is_shown(screen))
    text, pictures = screen.text(), app_of(screen.pilot)._pictures
    shown: dict[tuple[int, int], str] = {}
    for match in SIXEL.finditer(text):
        position = MOVE.search(text[: match.start()])
        assert position is not None
        shown[int(position[1]) - 1, int(position[2]) - 1] = match[0]
    for plot in pictures._visible.values():
        area = plot.area
        pixels = plot_pixels(
            plot.chart,
            plot.view,
            (area.width * 10, area.height * 20),
            dpi=120.0,
            colours=plot.colours,
            ticks=axis_ticks(plot.chart, plot.view, area.width, area.height),
        )
        decoded = decode_sixel(shown[area.y, area.x])
        assert decoded.shape == pixels.shape
        assert np.abs(decoded - pixels).mean() < 3.0
        assert pixels.std() > 5.0


async def test_pictures_of_outdated_results_are_dimmed(pilot: Pilot[None]) -> None:
    await show_tab(pilot, "alt+6")
    pane = pilot.app.screen.query_one(SweepPane)
    chart = pane.query(ChartView).first()
    plain = chart.plot_colours(chart.opacity)
    pane.add_class("-outdated")
    await pilot.pause()
    dimmed = chart.plot_colours(chart.opacity)
    assert dimmed.background == plain.background
    for role, code in plain.roles.items():
        assert dimmed.roles[role] == mix(code, plain.background, 0.6)


def writes_into(frame: str, area: Region) -> bool:
    """Whether a frame writes characters into an area."""
    moves = [*re.finditer(r"\x1b\[(\d+);(\d+)H", SIXEL.sub("", frame)), None]
    for move, successor in itertools.pairwise(moves):
        assert move is not None
        text = SIXEL.sub("", frame)[move.end() : successor.start() if successor else None]
        length = len(re.sub(r"\x1b\[[\d;?]*[a-zA-Z]|\x1b[78]|\n", "", text))
        start = int(move[2]) - 1
        if length and area.overlaps(Region(start, int(move[1]) - 1, length, 1)):
            return True
    return False


async def test_no_characters_replace_the_picture_of_a_chart_that_changes(
    screen: Screen, monkeypatch: pytest.MonkeyPatch
) -> None:
    # No key counts as held.
    monkeypatch.setattr("fivtui.tui.chart.widget.pictures._HELD_S", 1e-3)
    screen.answer(CELL, SIXEL_ATTRIBUTES)
    await until(screen.pilot, lambda: is_shown(screen))
    (chart, plot), *_ = app_of(screen.pilot)._pictures._visible.items()
    chart.focus()
    await until_still(screen.pilot)
    screen.frames.clear()
    keys = ("plus", "plus", "right")
    for key in keys:
        await screen.pilot.press(key)
        await until(screen.pilot, lambda: is_shown(screen))
    assert sum(len(SIXEL.findall(frame)) for frame in screen.frames) >= len(keys)
    assert not any(writes_into(frame, plot.area) for frame in screen.frames)
    # Without pictures, characters do.
    app_of(screen.pilot)._pictures.stop("")
    await screen.pilot.press("plus")
    assert any(writes_into(frame, plot.area) for frame in screen.frames)


async def test_kittys_pictures_leave_while_a_dialog_covers_them_or_a_key_is_held(
    screen: Screen, monkeypatch: pytest.MonkeyPatch
) -> None:
    # No key counts as held.
    monkeypatch.setattr("fivtui.tui.chart.widget.pictures._HELD_S", 1e-3)
    screen.answer(KITTY, CELL, SIXEL_ATTRIBUTES)
    await until(screen.pilot, lambda: is_shown(screen))
    assert SIXEL.search(screen.text()) is None
    numbers = {picture.number for picture in app_of(screen.pilot)._pictures._shown.values()}
    screen.frames.clear()
    await screen.pilot.press("f1")
    await until(screen.pilot, lambda: not app_of(screen.pilot)._pictures._shown)
    assert all(f"a=d,d=I,i={number}," in screen.text() for number in numbers)
    await screen.pilot.press("escape")
    await until(screen.pilot, lambda: is_shown(screen))
    assert "a=T" in screen.text()
    pictures = app_of(screen.pilot)._pictures
    # All further keys are those of a held key.
    monkeypatch.setattr("fivtui.tui.chart.widget.pictures._HELD_S", HANG_S)
    await screen.pilot.press("up", "up")
    await until(screen.pilot, lambda: not pictures._shown)
    pictures._end_held_key()
    await until(screen.pilot, lambda: is_shown(screen))


async def test_a_terminal_without_pictures_gets_none(screen: Screen) -> None:
    screen.answer(PLAIN_ATTRIBUTES)
    await screen.pilot.press("f5", "alt+2")
    await screen.pilot.pause(0.1)
    assert not app_of(screen.pilot)._pictures._visible
    assert screen.text().count("\x1b_G") == 1
    assert "\x1bP" not in screen.text()


@dataclass
class PseudoTerminal:
    """A terminal of 100 by 30 cells of 10 by 20 pixels.

    Its answers are templates by the regular expressions of queries.
    """

    process: subprocess.Popen[bytes]
    descriptor: int
    answers: Mapping[str, str]
    stream: str = ""
    answered: int = 0

    def until(self, holds: Callable[[str], bool]) -> str:
        deadline = time.monotonic() + HANG_S
        while not holds(self.stream):
            assert time.monotonic() < deadline, self.stream[-2000:]
            if select.select([self.descriptor], [], [], 0.1)[0]:
                received = os.read(self.descriptor, 65536).decode(errors="replace")
                self.stream += received
                queries = re.compile("|".join(self.answers) or "$.")
                for query in queries.finditer(self.stream, self.answered):
                    self.answered = query.end()
                    matches = (re.fullmatch(key, query[0]) for key in self.answers)
                    (match,) = filter(None, matches)
                    self.type(match.expand(self.answers[match.re.pattern]))
        return self.stream

    def type(self, text: str) -> None:
        os.write(self.descriptor, text.encode())

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self.descriptor)


@pytest.fixture
def start_terminal(tmp_path: Path) -> Iterator[Callable[..., PseudoTerminal]]:
    pytest.importorskip("pty", reason="no pseudo-terminals")
    from tests.support.pseudo_terminal import start_laboratory

    terminals: list[PseudoTerminal] = []

    def start(answers: Mapping[str, str], config: str = "") -> PseudoTerminal:
        (tmp_path / "fivtui").mkdir()
        (tmp_path / "fivtui" / "config.toml").write_text(config)
        folders = {name: str(tmp_path) for name in ("XDG_CONFIG_HOME", "XDG_STATE_HOME")}
        environment = {**os.environ, **folders}
        environment.pop("NO_COLOR", None)
        process, descriptor = start_laboratory(environment, 30, 100, (10, 20))
        terminals.append(PseudoTerminal(process, descriptor, answers))
        return terminals[-1]

    yield start
    for terminal in terminals:
        terminal.close()


@pytest.mark.host
def test_a_real_terminal_with_sixel_gets_pictures_of_whole_cells(
    start_terminal: Callable[..., PseudoTerminal],
) -> None:
    terminal = start_terminal(
        {r"\x1b\[c": SIXEL_ATTRIBUTES, r"\x1b\[(\d+;\d+)H\x1b\[6n": "\x1b[\\1R"}
    )
    terminal.until(lambda stream: "growth rate" in stream)
    # The tab Modes always has charts.
    terminal.type("\x1b2")
    stream = terminal.until(lambda stream: SIXEL.search(stream) is not None)
    match = SIXEL.search(stream)
    assert match is not None
    position, pixels = MOVE.search(stream[: match.start()]), decode_sixel(match[0])
    assert position is not None
    assert (pixels.shape[0] % 20, pixels.shape[1] % 10) == (0, 0)
    assert int(position[1]) - 1 + pixels.shape[0] // 20 <= 30
    assert int(position[2]) - 1 + pixels.shape[1] // 10 <= 100
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 2


@pytest.mark.host
@pytest.mark.parametrize("config", ["", "pictures = false"])
def test_a_real_terminal_that_does_not_answer_gets_characters(
    config: str, start_terminal: Callable[..., PseudoTerminal]
) -> None:
    terminal = start_terminal({}, config)
    terminal.until(lambda stream: "UNSTABLE" in stream)
    # The tab Modes has charts. A word may be drawn in pieces, a character is not.
    terminal.type("\x1b2")
    start = len(terminal.stream)
    stream = terminal.until(lambda stream: len(BRAILLE.findall(stream, start)) > 50)
    assert stream.count("\x1b_G") == (not config)
    assert "\x1bP" not in stream
