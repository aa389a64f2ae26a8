"""Draws the README's picture: `python -m tests.support.laboratory_picture FILE`."""

import asyncio
import sys
import tempfile
from pathlib import Path
from typing import Final

from textual.pilot import Pilot

from fivtui.tui.app import FivtuiApp
from fivtui.tui.tabs import RunsChanged
from tests.support.laboratory import (
    app_of,
    clear_notices,
    focus,
    show_tab,
    until,
    until_screen,
    until_shown,
)

SIZE: Final = (120, 40)


async def set_up(pilot: Pilot[None]) -> None:
    """Two overlaid runs, with separation ignored and considered, and the zones of F computed.

    Zones are the ranges of a parameter in which the slider is safe or squeals.
    """
    session = app_of(pilot).session
    for separation in ("ignored", "considered"):
        session.set_text("separation", separation)
        await pilot.press("f5")
        await until(pilot, lambda: session.runs.active is None)
    await show_tab(pilot, "alt+1")
    first, second = session.runs
    # The first run is drawn beside the second, whose numbers are compared with it.
    first.overlaid, session.runs.baseline, session.runs.displayed = True, first, second
    pilot.app.screen.post_message(RunsChanged())
    # In the list of runs: marker and number of the first run, and that it is overlaid.
    await until_shown(pilot, "● 1 on")
    # The zones of the focused parameter are computed and drawn.
    await focus(pilot, "F")
    await until_shown(pilot, "a global search")
    await until_screen(pilot, lambda text: "searching" not in text)


async def write_picture(path: Path) -> None:
    """Write the picture as SVG."""
    with tempfile.TemporaryDirectory() as folder:
        app = FivtuiApp(state=Path(folder) / "session.json")
        async with app.run_test(size=SIZE) as pilot:
            await set_up(pilot)
            await clear_notices(pilot)
            path.write_text(app.export_screenshot(title="fivtui"), encoding="utf-8")


if __name__ == "__main__":
    asyncio.run(write_picture(Path(sys.argv[1])))
