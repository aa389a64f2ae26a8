"""Helpers shared by tests of the laboratory, the application in the terminal."""

import asyncio
import math
import os
import re
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import textual.app
import textual.pilot
from rich.console import RenderableType
from textual._compositor import Compositor
from textual._context import visible_screen_stack
from textual.app import App
from textual.css.model import RuleSet
from textual.css.stylesheet import Stylesheet
from textual.css.types import CSSLocation
from textual.pilot import Pilot
from textual.screen import Screen
from textual.widgets import Input

from fivtui.model.errors import Cancelled
from fivtui.tui.app import FivtuiApp
from fivtui.tui.chart import ChartView
from fivtui.tui.lab.form.rows import FieldRow
from fivtui.tui.lab.notices import NoticeView
from fivtui.tui.lab.screen import LabScreen
from fivtui.tui.session import Session, study_command
from fivtui.tui.tabs.tab_book import TabBook
from fivtui.tui.tabs.transient import TransientPane
from fivtui.tui.tabs.views_pane import ViewsPane

# A wait fails after this many polls of an idle application; a running worker resets their count. A
# poll that is late, because the machine is busy, leaves it as it is. HANG_S is the longest wait,
# shorter than pytest's limit of a test, which ends the process without a message.
_IDLE_POLLS: Final = 1600
_POLL_S: Final = 0.01
_LATE_S: Final = 0.1
HANG_S: Final = 240.0
_wait_for_screen = Pilot._wait_for_screen


async def _wait_longer(self: Pilot[None], timeout: float = HANG_S) -> bool:
    # Textual gives up after half a minute, which a busy machine may need.
    return await _wait_for_screen(self, timeout)


Pilot._wait_for_screen = _wait_longer  # type: ignore[method-assign, assignment]

# Effects of a key may need the next frame; tests wait for later timers explicitly.
_FRAME_S: Final = 0.02
# Greatest number of consecutive timers to wait for: threads may schedule them endlessly.
_MAX_TIMERS: Final = 4


async def _until_idle(min_sleep: float = 0.0, max_sleep: float = 1.0) -> None:
    """Wait until no task is ready and no timer is due within a frame.

    Textual's own version sleeps while threads compute, twice after each key. The limit is CPU time
    of this thread, which other processes do not use up.
    """
    loop = asyncio.get_running_loop()
    end = time.thread_time() + max_sleep
    for _ in range(_MAX_TIMERS):
        await asyncio.sleep(0)
        while loop._ready and time.thread_time() < end:  # type: ignore[attr-defined]
            await asyncio.sleep(0)
        next_frame = loop.time() + _FRAME_S
        scheduled = loop._scheduled  # type: ignore[attr-defined]
        times = [handle.when() for handle in scheduled if not handle.cancelled()]
        due = min(times, default=math.inf)
        if due > next_frame:
            return
        await asyncio.sleep(max(due - loop.time(), 0.0))


for _module in (textual.app, textual.pilot):
    _module.wait_for_idle = _until_idle  # type: ignore[attr-defined]

_paint = App._display
_paints: Final = Counter[int]()


def _count_and_paint(self: App[Any], screen: Screen[Any], renderable: Any) -> None:
    _paints[id(self)] += 1
    _paint(self, screen, renderable)


App._display = _count_and_paint  # type: ignore[method-assign]

# Without a terminal, frames are rendered and discarded, which takes half of a test's time. Render
# the screen only where a test reads it. With this variable set every frame is rendered.
EVERY_FRAME: Final = "FIVTUI_TEST_EVERY_FRAME"
every_frame = EVERY_FRAME in os.environ
_render_update = Compositor.render_update


def _render_on_demand(
    self: Compositor,
    full: bool = False,
    screen_stack: list[Screen[Any]] | None = None,
    simplify: bool = False,
) -> RenderableType | None:
    if every_frame or full or simplify:
        return _render_update(self, full, screen_stack, simplify)
    visible_screen_stack.set([] if screen_stack is None else screen_stack)
    self._dirty_regions.clear()
    return None


Compositor.render_update = _render_on_demand  # type: ignore[method-assign]

# Cache parsed style sheets: parsing takes an eighth of an application's start.
_parse_rules = Stylesheet._parse_rules
_parsed: Final[dict[tuple[Any, ...], list[RuleSet]]] = {}


def _parse_once(
    self: Stylesheet, css: str, read_from: CSSLocation, *positional: Any, **keywords: Any
) -> Any:
    key = (css, read_from, positional, *keywords.items(), *self._variables.items())
    if key not in _parsed:
        _parsed[key] = _parse_rules(self, css, read_from, *positional, **keywords)
    return _parsed[key]


Stylesheet._parse_rules = _parse_once  # type: ignore[method-assign]
# Equal to Textual's, but without a Python call for each rule and widget.
RuleSet.__hash__ = object.__hash__  # type: ignore[method-assign]

# A horizon, s, that no run reaches during a test.
ENDLESS: Final = "1e6"


def text_of(pilot: Pilot[None]) -> str:
    """The text of the screen, line by line."""
    strips = pilot.app.screen._compositor.render_strips()
    return "\n".join(strip.text for strip in strips)


def flat_text_of(pilot: Pilot[None]) -> str:
    """The text of the screen with runs of blanks and line breaks as one blank, for wrapped text."""
    return " ".join(text_of(pilot).split())


async def until(pilot: Pilot[None], holds: Callable[[], bool]) -> None:
    """Wait until a condition holds."""
    begin = previous = time.monotonic()
    idle = 0
    while not holds():
        current = time.monotonic()
        busy = any(worker.is_running for worker in pilot.app.workers)
        if busy:
            idle = 0
        elif current - previous < _LATE_S:
            idle += 1
        previous = current
        timed_out = idle > _IDLE_POLLS or current - begin > HANG_S
        assert not timed_out, "waited in vain; the screen:\n" + text_of(pilot)
        await asyncio.sleep(_POLL_S)
    await pilot.pause()


async def until_screen(pilot: Pilot[None], holds: Callable[[str], bool]) -> None:
    """Wait until a condition on the screen's text holds."""
    previous_paints = -1

    def holds_after_paint() -> bool:
        # Rendering is the most expensive part, and the text changes only with a paint.
        nonlocal previous_paints
        paints = _paints[id(pilot.app)]
        if paints == previous_paints:
            return False
        previous_paints = paints
        return holds(text_of(pilot))

    await until(pilot, holds_after_paint)


async def until_shown(pilot: Pilot[None], phrase: str) -> None:
    """Wait until the screen shows a phrase."""
    await until_screen(pilot, lambda text: phrase in " ".join(text.split()))


async def until_hidden(pilot: Pilot[None], phrase: str) -> None:
    """Wait until the screen shows a phrase no more."""
    await until_screen(pilot, lambda text: phrase not in " ".join(text.split()))


async def until_key_bar(pilot: Pilot[None], start: str) -> None:
    """Wait until the last line of the screen starts with a text."""
    await until_screen(pilot, lambda text: text.splitlines()[-1].startswith(start))


async def until_still(pilot: Pilot[None], polls: int = 4) -> None:
    """Wait until no worker runs and several polls find the same text, whatever blinks."""
    previous_text, previous_paints, still_polls = "", -1, 0
    while still_polls < polls:
        await asyncio.sleep(0.03)
        await pilot.pause()
        paints = _paints[id(pilot.app)]
        text = previous_text if paints == previous_paints else text_of(pilot)
        busy = any(worker.is_running for worker in pilot.app.workers)
        still_polls = 0 if busy or text != previous_text else still_polls + 1
        previous_text, previous_paints = text, paints


def notices_of(pilot: Pilot[None]) -> NoticeView:
    """The notices of the main screen."""
    return pilot.app.screen_stack[0].query_one(NoticeView)


async def clear_notices(pilot: Pilot[None]) -> None:
    """Remove all notices from the screen, as they are transient."""
    notices_of(pilot).clear()
    await pilot.pause()


async def until_notice(pilot: Pilot[None], phrase: str) -> None:
    """Wait until a notice contains a phrase.

    Its lines are wrapped on the screen, so wait there for the first word alone.
    """
    await until(pilot, lambda: any(phrase in n.text for n in notices_of(pilot).notices))
    first_word, *_ = phrase.split(maxsplit=1)
    await until_shown(pilot, first_word)


def command_line(session: Session) -> str:
    """The command for the edited transient; raises `InputError` if a field is invalid."""
    return study_command("run", session.scene(), session)


def app_of(pilot: Pilot[None]) -> FivtuiApp:
    """The application under test."""
    app = pilot.app
    assert isinstance(app, FivtuiApp)
    return app


def lab_of(pilot: Pilot[None]) -> LabScreen:
    """The main screen."""
    lab = pilot.app.screen_stack[0]
    assert isinstance(lab, LabScreen)
    return lab


def chart_of(pilot: Pilot[None], name: str) -> ChartView:
    """The widget of a chart on the main screen."""
    return lab_of(pilot).query_one(f"#{name}", ChartView)


async def answer(pilot: Pilot[None], path: Path | str) -> None:
    """Enter a path in the dialog that asks for one, once it is open."""
    await until(pilot, lambda: bool(pilot.app.screen.query("#path")))
    pilot.app.screen.query_one("#path", Input).value = str(path)
    await pilot.pause()
    await pilot.press("enter")


async def palette(pilot: Pilot[None], query: str) -> None:
    """Open the command palette and enter a query."""
    await pilot.press("ctrl+p")
    await until(pilot, lambda: bool(pilot.app.screen.query("CommandInput")))
    pilot.app.screen.query_one("CommandInput", Input).value = query
    await pilot.pause()


async def choose(pilot: Pilot[None], query: str, title: str) -> None:
    """Run the palette's first entry for a query, once a title is visible."""
    await palette(pilot, query)
    await until_shown(pilot, title)
    await pilot.press("enter")


async def show_tab(pilot: Pilot[None], key: str) -> None:
    """Press the key of a tab, and wait until the tab is mounted."""
    await pilot.press(key)
    await until(pilot, lambda: _tab_is_mounted(pilot))


async def click_view(pilot: Pilot[None], name: str) -> None:
    """Click the title of a view of the current tab, in the upper border of its pane."""
    pane = app_of(pilot).screen_stack[0].query_one(TabBook).pane
    assert isinstance(pane, ViewsPane)

    def title_columns() -> list[int]:
        border = text_of(pilot).splitlines()[pane.region.y][pane.region.x :]
        return [match.start() for match in re.finditer(rf"{pane.VIEWS[name]}\b", border)]

    await until(pilot, lambda: bool(title_columns()))
    await pilot.click(pane, offset=(title_columns()[0], 0))
    await until(pilot, lambda: pane.view == name)


def _tab_is_mounted(pilot: Pilot[None]) -> bool:
    book = app_of(pilot).screen_stack[0].query_one(TabBook)
    return book.pane is not None and book.pane.is_mounted


async def focus(pilot: Pilot[None], name: str) -> Input:
    """Focus the editor of a field that is edited as text."""
    editor = pilot.app.screen.query_one(f"#row-{name}", FieldRow).query_one(Input)
    editor.focus()
    await until(pilot, lambda: editor.has_focus)
    return editor


async def type_into(pilot: Pilot[None], name: str, text: str) -> None:
    """Replace the text of a field; only the last character is typed."""
    editor = await focus(pilot, name)
    editor.value = text[:-1]
    await pilot.press("end", {".": "full_stop", "-": "minus", ",": "comma"}.get(text[-1], text[-1]))
    await until(pilot, lambda: app_of(pilot).session.texts[name] == text)


def endless_simulate(*_: object, progress: Callable[[float], bool], **__: object) -> None:
    """Stands in for a run that continues until it is stopped, with little CPU time."""
    fraction = 0.0
    while progress(fraction):
        fraction += 1e-6
        time.sleep(0.005)
    raise Cancelled


async def show_all_quantities(pilot: Pilot[None]) -> None:
    """Draw all quantities over time, also on a low screen."""
    pane = lab_of(pilot).query_one(TransientPane)
    pane.store_setting("chart-time", "all")
    pane.fit_charts()
    pane.draw()
    await pilot.pause()


async def run_to_end(pilot: Pilot[None]) -> None:
    """Press the run key, and wait for the result."""
    runs = app_of(pilot).session.runs
    # Earlier notices may cover the result.
    notices_of(pilot).clear()
    await pilot.press("f5")
    await until(pilot, lambda: runs.newest is not None and runs.active is None)
    await until_shown(pilot, "amplitude of y")
