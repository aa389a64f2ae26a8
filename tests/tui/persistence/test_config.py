"""User-defined keys and themes."""

from pathlib import Path

import pytest

from fivtui.model.errors import InputError
from fivtui.tui.app import FivtuiApp
from fivtui.tui.lab.keys import KEY_IDS
from fivtui.tui.persistence.config import load_config
from fivtui.tui.session.help import welcome_text
from tests.support.laboratory import (
    until,
    until_key_bar,
    until_screen,
    until_shown,
)

# `live = false`: edits do not update the live curve, a run of the edited scene.
USER_CONFIG = """
theme = "mine"
live = false
[keys]
run = "f12"
next-tab = "ctrl+n"
compute = "alt+c"
tab-map = "alt+m"
[themes.mine]
primary = "#112233"
dark = false
"""


def test_a_missing_file_changes_nothing(tmp_path: Path) -> None:
    for path in (None, tmp_path / "config.toml"):
        config = load_config(path, KEY_IDS)
        assert (config.theme, config.live, config.keys, config.themes) == ("", None, {}, {})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("colour = 1", "unknown key 'colour'"),
        ("keys = 1", "keys = 1: must be a table"),
        ("[themes]\na = 1", "themes.a = 1: must be a table"),
        ("[themes.a]\nprimary = '#000000'\ndark = 1", "themes.a.dark = 1: must be true or false"),
        ("[keys]\nruns = 1", "keys.runs = 1: must be text"),
        ("[keys]\nrnu = 'f5'", "unknown action 'rnu'; did you mean run"),
        ("live = 'no'", "live = 'no': must be true or false"),
        ("pictures = 1", "pictures = 1: must be true or false"),
        ("theme = 3", "theme = 3: must be text"),
        ("[themes.a]\npanel = '#000000'", "themes.a: must have the colour primary"),
        ("[themes.a]\nprimary = 'red'", "must be a colour such as"),
        ("[themes.a]\nprimry = '#000000'", "did you mean primary"),
        ("= 1", "not TOML"),
    ],
)
def test_invalid_entries_of_the_file_are_named(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "config.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        load_config(path, KEY_IDS)


async def test_user_keys_and_theme_apply_from_the_first_start(tmp_path: Path) -> None:
    path = tmp_path / "config.toml"
    path.write_text(USER_CONFIG)
    app = FivtuiApp(state=tmp_path / "session.json", config=path)
    async with app.run_test(size=(80, 24)) as pilot:
        await until_shown(pilot, "F1 keys")
        # Each welcome text fits on one line.
        lines = welcome_text(app.session.key_names).splitlines()
        assert "F12 keep a run" in lines[-1]
        await until_screen(pilot, lambda text: all(line in text for line in lines))
        assert app.theme == "mine"
        await until_key_bar(pilot, "f12 Run ")
        await pilot.resize_terminal(120, 40)
        await pilot.press("alt+4")
        await until_shown(pilot, "Follow Alt+C")
        await until_shown(pilot, " M Map ")
        await pilot.press("f5")
        await pilot.press("f12")
        await until(pilot, lambda: app.session.runs.displayed is not None)
        await until(pilot, lambda: not app.screen.query("#welcome"))
        assert [run.number for run in app.session.runs] == [1]
    second_app = FivtuiApp(state=tmp_path / "session.json", config=path)
    async with second_app.run_test(size=(80, 24)):
        assert second_app.theme == "mine"
        assert not second_app.session.live_enabled
        assert not second_app.screen.query("#welcome")


async def test_an_invalid_file_is_reported_and_the_default_keys_stay(tmp_path: Path) -> None:
    path = tmp_path / "config.toml"
    path.write_text("theme = 'nowhere'")
    app = FivtuiApp(config=path)
    async with app.run_test(size=(80, 24)) as pilot:
        await until_shown(pilot, "unknown theme 'nowhere'")
        await until_key_bar(pilot, "F5 Run")
