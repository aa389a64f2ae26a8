"""Random keys neither crash nor block the laboratory."""

import os
import random
import subprocess
import sys
from pathlib import Path

import pytest

from fivtui.tui.app import FivtuiApp
from fivtui.tui.tabs.tab_book import TABS
from tests.support.laboratory import (
    EVERY_FRAME,
    until,
    until_shown,
)

KEYS = (
    *"0123456789jkhlgGirebsxcmn+-.",
    *("up", "down", "left", "right", "tab", "shift+tab", "enter", "escape", "space", "backspace"),
    *("delete", "home", "end", "shift+up", "ctrl+z", "ctrl+y", "ctrl+p", "ctrl+o", "ctrl+s"),
    *("f1", "f2", "shift+f2", "f3", "f4", "f5", "f5", "f6", "f7", "f8", "shift+f8", "f9"),
    *(tab.key for tab in TABS),
)
PRESSED_KEY_COUNT = 100


@pytest.mark.slow
async def test_random_keys_neither_crash_nor_block(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("tests.support.laboratory.every_frame", True)
    # Building and loading an FMU would be slow.
    monkeypatch.setattr("fivtui.fmu.integrate_fmu", _refuse_fmu)
    generator = random.Random(7)
    pressed_keys: list[str] = []
    app = FivtuiApp(state=tmp_path / "session.json")
    async with app.run_test(size=(100, 30)) as pilot:
        await pilot.pause()
        for _ in range(PRESSED_KEY_COUNT):
            pressed_keys.append(generator.choice(KEYS))
            if pressed_keys[-1] == "enter" and app.screen.query("#path"):
                # Random keys must not open or write files.
                pressed_keys[-1] = "escape"
            await pilot.press(pressed_keys[-1])
            assert app._exception is None, pressed_keys
        # The program still responds after all keys.
        while len(app.screen_stack) > 1:
            await pilot.press("escape")
        await pilot.press("shift+f8")
        await until(pilot, lambda: not app.session.changed_fields)
        await until_shown(pilot, "F1 Help")


def _refuse_fmu(*_: object, **__: object) -> None:
    from fivtui.model.errors import ComputationError

    raise ComputationError("there is no FMU in this test", "another method")


@pytest.mark.whole
def test_every_frame_of_all_tests_of_the_laboratory_is_rendered() -> None:
    process = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-n", "0", str(Path(__file__).parent)],
        env=os.environ | {EVERY_FRAME: "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, process.stdout
