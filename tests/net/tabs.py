"""The text of every tab of the laboratory: initially, and with results of a stored session.

The laboratory is the program in the terminal. A session is its saved state, with results.
"""

import asyncio
import shutil
import tempfile
from contextlib import ExitStack
from pathlib import Path
from typing import Final
from unittest import mock

from textual.pilot import Pilot

from fivtui.model import Cancelled
from fivtui.tui.app import FivtuiApp
from fivtui.tui.tabs import TABS, RunsChanged
from fivtui.tui.tabs.tab_book import TabBook
from tests.net.text import SECTION_MARK, mask_varying
from tests.support.laboratory import (
    app_of,
    clear_notices,
    focus,
    show_tab,
    text_of,
    until,
    until_still,
)

SIZES: Final = ((80, 24), (120, 40))
SESSION: Final = Path(__file__).parents[1] / "data" / "stored" / "session"
# Partial blocks at the ends of scroll bars depend on the order of Textual's layout.
_PARTIAL_BLOCKS: Final = dict.fromkeys(map(ord, "▏▎▍▌▋▊▉"), " ")


def record_tabs(size: tuple[int, int]) -> str:
    """Text of all tabs in a terminal of the size."""
    return "\n".join(asyncio.run(_tab_lines(size))) + "\n"


async def _tab_lines(size: tuple[int, int]) -> list[str]:
    lines = []
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="fivtui-net-")))
        # Cancel the background computations of safe friction and of zones of stability along a
        # parameter: what they show in time depends on the speed of the machine.
        for name in ("safe_friction", "safety_zones"):
            stack.enter_context(mock.patch(f"fivtui.safety.{name}", side_effect=Cancelled))
        # Usual durations depend on the speed of the machine.
        stack.enter_context(
            mock.patch("fivtui.tui.tabs.preview.relative_duration", return_value=1.0)
        )
        # No live curve, which a background run computes anew after each edit.
        (folder / "config.toml").write_text("live = false\n", encoding="utf-8")
        shutil.copytree(SESSION, folder / "stored")
        for title, session in (("start", None), ("stored session", folder / "stored/session.json")):
            app = FivtuiApp(state=session, config=folder / "config.toml")
            async with app.run_test(size=size) as pilot:
                # Results of a session are read in the background.
                await until(pilot, lambda: not app_of(pilot).session.unread_results)
                for tab in TABS:
                    await show_tab(pilot, tab.key)
                    # A tab may wrap its texts before its width is known. The message, as after a
                    # run, makes it write them again.
                    await until_still(pilot, 2)
                    app.screen.post_message(RunsChanged())
                    for view_title, view_lines in await _views(pilot):
                        lines += [f"{SECTION_MARK}{title}: {tab.title}{view_title}", *view_lines]
    return lines


async def _views(pilot: Pilot[None]) -> list[tuple[str, list[str]]]:
    # Title and screen lines for every view of the visible pane.
    pane = pilot.app.screen_stack[0].query_one(TabBook).pane
    assert pane is not None
    view_count = len(getattr(pane, "VIEWS", {}))
    views = []
    for _ in range(max(view_count, 1)):
        await clear_notices(pilot)
        # The bottom line shows the keys of the focused widget, here always the editor of μ.
        editor = await focus(pilot, "mu")
        # A cursor that blinks is painted again and again: the screen would never be still.
        editor.cursor_blink = False
        await until_still(pilot)
        text = mask_varying(text_of(pilot).translate(_PARTIAL_BLOCKS))
        # A tab without views has one untitled text.
        view = getattr(pane, "view", "")
        views.append((f" {view}".rstrip(), text.splitlines()))
        if view_count > 1:
            await pane.run_action("next_view")
    return views
