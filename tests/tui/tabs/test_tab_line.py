"""The line of tabs: every tab by mouse at any width, and the progress of a run from every tab."""

from pathlib import Path

import pytest
from textual.pilot import Pilot

from fivtui.tui.app import FivtuiApp
from fivtui.tui.tabs import TABS, TabLine
from tests.support.laboratory import (
    app_of,
    endless_simulate,
    text_of,
    until,
    until_hidden,
    until_shown,
)


@pytest.mark.parametrize("width", [40, 80])
async def test_a_click_on_any_title_shows_its_tab(width: int) -> None:
    async with FivtuiApp().run_test(size=(width, 24)) as pilot:
        await until_shown(pilot, "Run")
        line = pilot.app.screen.query_one(TabLine)
        for tab in TABS[::-3]:
            text = text_of(pilot).splitlines()[line.region.y]
            # A narrow line has the signs of the keys in place of the titles of hidden tabs.
            sign = tab.key.rpartition("+")[2].replace("minus", "-")
            await pilot.click(line, offset=(text.rindex(tab.title if width >= 80 else sign), 0))
            await until(pilot, lambda tab=tab: app_of(pilot).session.tab == tab.id)  # type: ignore[misc]
            await until_shown(pilot, tab.title)


@pytest.mark.parametrize(
    ("width", "configured_key", "start"),
    [
        (40, "alt+1", "Alt+1 Run │ 2 3"),
        (80, "alt+1", "Alt+1… Run │ Modes"),
        (100, "alt+1", "Alt+1 Run │ 2 Modes"),
        (120, "alt+1", "Alt+1 Run │ Stability 2 Modes"),
        (160, "f12", "F12 Run │ Stability Alt+2 Modes"),
    ],
)
async def test_the_line_says_which_keys_show_tabs(
    width: int, configured_key: str, start: str, tmp_path: Path
) -> None:
    config = tmp_path / "config.toml"
    config.write_text(f'[keys]\ntab-transient = "{configured_key}"\n')
    async with FivtuiApp(config=config).run_test(size=(width, 24)) as pilot:
        await until_shown(pilot, start)


async def test_every_tab_shows_the_progress_of_a_run(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fivtui.scene.run.compute", endless_simulate)
    await pilot.press("f5", "alt+0")
    await until_shown(pilot, "Run 0%")
    await pilot.press("f5")
    await until_hidden(pilot, "Run 0%")
