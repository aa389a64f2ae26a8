"""Keys are handled at once during computations, in order, and computations show progress."""

import asyncio
import gc
import threading
import time
from functools import partial

import pytest
from textual.events import Key
from textual.pilot import Pilot

from fivtui.tui.app import FivtuiApp
from fivtui.tui.lab.key_bar import KeyBar
from fivtui.tui.session import jobs
from fivtui.tui.session.jobs import SCREEN_RESPONSE, Job, ScreenResponse
from fivtui.tui.tabs.tab_book import TABS
from tests.support.laboratory import (
    HANG_S,
    app_of,
    show_tab,
    text_of,
    until,
    until_screen,
    until_shown,
)

SIZE = (80, 24)


def test_computations_pause_until_the_screen_has_responded(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # The response is pending until it ends, even on a slow machine.
    monkeypatch.setattr(jobs, "_RESPONSE_TIME_S", HANG_S)
    response = ScreenResponse()
    response.wait()
    assert not response.pending
    response.begin()
    assert response.pending
    has_resumed = threading.Event()

    def compute() -> None:
        response.wait()
        has_resumed.set()

    computing_thread = threading.Thread(target=compute)
    computing_thread.start()
    assert not has_resumed.is_set()
    response.end()
    assert has_resumed.wait(HANG_S)


def test_continuous_key_presses_do_not_stop_computations() -> None:
    response, stop_pressing = ScreenResponse(), threading.Event()
    response.begin()

    def press_continuously() -> None:
        while not stop_pressing.is_set():
            response.begin()
            time.sleep(1e-3)

    pressing_thread = threading.Thread(target=press_continuously)
    computing_thread = threading.Thread(target=response.wait, daemon=True)
    pressing_thread.start()
    computing_thread.start()
    computing_thread.join(HANG_S)
    stop_pressing.set()
    pressing_thread.join()
    assert not computing_thread.is_alive()


async def test_computations_pause_from_a_key_until_its_frame(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(jobs, "_RESPONSE_TIME_S", HANG_S)
    pending: list[bool] = []
    original_step_field = app_of(pilot).session.step_field

    def record_and_step_field(name: str, direction: int, *, fine: bool = False) -> bool:
        pending.append(SCREEN_RESPONSE.pending)
        return original_step_field(name, direction, fine=fine)

    app_of(pilot).session.step_field = record_and_step_field  # type: ignore[method-assign]
    await pilot.press("up")
    await until(pilot, lambda: bool(pending) and not SCREEN_RESPONSE.pending)
    assert pending == [True]
    await until_shown(pilot, "base (changed)")


def test_a_started_job_shows_its_progress() -> None:
    job = Job()
    assert job.progress_text == "0 %"
    job.report(0.5)
    assert job.progress_text.startswith("50 %, ")


async def test_a_tab_handles_keys_pressed_before_it_exists(pilot: Pilot[None]) -> None:
    # Both keys are queued before the tab exists.
    pilot.app.simulate_key("alt+8")
    pilot.app.simulate_key("f10")
    await until_shown(pilot, "Stop")
    await pilot.press("f10")
    await until_shown(pilot, "stopped at")


async def click_key(pilot: Pilot[None], label: str) -> None:
    await until_screen(pilot, lambda text: label in text.splitlines()[-1])
    line = text_of(pilot).splitlines()[-1]
    await pilot.click(KeyBar, offset=(line.index(label), 0))


async def test_a_click_on_a_key_presses_it(pilot: Pilot[None]) -> None:
    await pilot.press("alt+2")
    await click_key(pilot, "Runs")
    await until_shown(pilot, "none yet: Run keeps one")
    await pilot.press("f3")
    await until_shown(pilot, "F7 Data")
    await click_key(pilot, "Data")
    await until_shown(pilot, "Export the data of the stability")
    await pilot.press("escape")
    await click_key(pilot, "palette")
    await until_shown(pilot, "Search for commands")


def is_key_bar(pilot: Pilot[None], width: int, *, has_zoom: bool) -> bool:
    line = text_of(pilot).splitlines()[-1]
    return len(line) == width and ("+ - Zoom" in line) is has_zoom and line.endswith("^p palette ")


async def test_the_key_bar_is_one_line_that_stays_where_the_focus_moves(
    pilot: Pilot[None],
) -> None:
    await show_tab(pilot, "alt+2")
    keys = "F5 Run F10 Compute F1 Help F2 Tab F3 Runs F6 Figure F7 Data ^q Quit"
    for width in (40, 57, 80, 140):
        await pilot.resize_terminal(width, 24)
        for selector in ("#row-mu TextEditor", "#growth"):
            pilot.app.screen.query_one(selector).focus()
            # Keys of the focused widget follow where there is room.
            has_zoom = width == 140 and selector == "#growth"
            await until(pilot, partial(is_key_bar, pilot, width, has_zoom=has_zoom))
            line = text_of(pilot).splitlines()[-1]
            always_shown = line.rstrip().removesuffix("^p palette")[: len(keys)].strip()
            assert always_shown == keys if width >= 80 else keys.startswith(always_shown)


async def test_no_timer_of_a_tab_is_lost() -> None:
    # The garbage collector reports a pending timer that has no reference.
    errors: list[str] = []
    asyncio.get_running_loop().set_exception_handler(
        lambda _loop, context: errors.append(str(context))
    )
    async with FivtuiApp().run_test(size=(80, 24)) as pilot:
        for tab in TABS:
            await pilot.press(tab.key)
            await pilot.pause()
        gc.collect()
    assert errors == []


async def test_keys_after_quitting_are_ignored() -> None:
    app = FivtuiApp()
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.pause()
        for key in ("ctrl+q", "f5", "up", "alt+6", "f10"):
            app.simulate_key(key)
        app.post_message(Key("up", None))


async def test_a_dialog_can_be_closed_while_it_opens(pilot: Pilot[None]) -> None:
    for pause in (0.0, 0.0, 0.002, 0.005, 0.01, 0.02):
        pilot.app.simulate_key("alt+s")
        await asyncio.sleep(pause)
        pilot.app.simulate_key("escape")
    await until(pilot, lambda: len(pilot.app.screen_stack) == 1)
    await pilot.press("alt+s")
    await until_shown(pilot, "Cancel")
