"""Belts and tables over time: their fields, shown if the scene has them, and how to add them."""

import re
from pathlib import Path

import pytest
from textual.pilot import Pilot
from textual.widgets import Input

from fivtui.model import InputError, time_table
from fivtui.scene import PRESETS
from fivtui.tui.persistence.state_file import load_session, save_state, session_state
from fivtui.tui.session import Session
from fivtui.tui.session.scene_differences import difference_text, legend_names
from tests.support.laboratory import (
    answer,
    app_of,
    choose,
    command_line,
    until,
    until_hidden,
    until_notice,
    until_screen,
    until_shown,
)

SIZE = (100, 36)
BASE = PRESETS["base"]


async def test_fields_of_the_belt_appear_and_disappear(pilot: Pilot[None]) -> None:
    session = app_of(pilot).session
    await until_hidden(pilot, "v_belt")
    await choose(pilot, "finite speed", "Belt of finite speed")
    await until_shown(pilot, "v_belt 1 − + m/s")
    assert session.parameters().v_belt == 1.0
    row = pilot.app.screen.query_one("#row-v_belt").query_one(Input)
    await until(pilot, lambda: row.has_focus)
    await until_shown(pilot, "at finite belt speed")
    await pilot.press("up")
    await until(pilot, lambda: session.texts["v_belt"] == "1.1")
    await choose(pilot, "faster than", "Belt faster than the slider")
    await until(pilot, lambda: session.parameters().v_belt is None)
    await until_hidden(pilot, "v_belt")
    # A field without effect names the parameter that it needs. Any step of a field lets the form
    # show texts that were set in the session.
    session.set_text("mu_s", "0.9")
    await pilot.press("up")
    await until_shown(pilot, "no effect without v_belt")
    session.set_text("v_belt", "1")
    await pilot.press("up")
    await until_hidden(pilot, "no effect")


async def test_tables_are_read_shown_in_the_form_and_removed(
    pilot: Pilot[None], tmp_path: Path
) -> None:
    session = app_of(pilot).session
    (tmp_path / "ramp.csv").write_text("time,F\n0,20\n4,90\n")
    await choose(pilot, "parameters over", "Parameters over time from a file…")
    await until_shown(pilot, "columns time and F")
    await answer(pilot, "ramp.csv")
    await until_notice(pilot, "tables over time from ramp.csv")
    await until_shown(pilot, "no zones: F changes over time")
    await until_screen(pilot, lambda text: bool(re.search("at t = 0: (UN)?STABLE", text)))

    def form_text(text: str) -> str:
        form_width = 31
        rows = " ".join(line[:form_width].strip("│ ") for line in text.splitlines())
        return " ".join(rows.split())

    await until_screen(
        pilot, lambda text: "at t = 0; 20 to 90 N, table 0 to 4 s" in form_text(text)
    )
    assert dict(session.scene().over_time)["F"].values == (20.0, 90.0)
    assert session.scene().parameters.F == 20.0
    # It is an ordinary edit: marked as a change of the loaded scene.
    assert session.changed_fields == ["F"]
    assert session.name == "base"
    await until_shown(pilot, "base (changed)")
    with pytest.raises(InputError, match="no option sets over_time"):
        command_line(session)
    await choose(pilot, "drop the", "Drop the tables over time")
    await until_notice(pilot, "tables over time dropped")
    # The gauge is shown again, with its mark.
    await until_shown(pilot, "●")
    assert not session.scene().over_time
    assert session.texts["F"] == "20"
    await pilot.press("ctrl+z")
    assert session.scene().over_time
    # The loaded scene has no table, so F8 restores its value.
    pilot.app.screen.query_one("#row-F").query_one(Input).focus()
    await pilot.press("f8")
    await until(pilot, lambda: session.texts["F"] == "80")
    assert not session.changed_fields
    await pilot.press("ctrl+z", "ctrl+z")
    assert session.texts["F"] == "80"
    assert not session.over_time


async def test_tables_are_restored_and_distinguish_runs(tmp_path: Path) -> None:
    session_path = tmp_path / "session.json"
    session = Session(BASE, "base")
    tables = (("F", time_table("F", [(0.0, 20.0), (4.0, 90.0)])),)
    session.set_text("mu", "0.5")
    session.set_tables(tables)
    save_state(session_state(session), {}, {}, session_path)
    restored_session = load_session(session_path)
    assert restored_session is not None
    assert restored_session.edit_state == session.edit_state
    assert restored_session.changed_fields == ["F", "mu"]
    scene_with_table = restored_session.scene()
    restored_session.set_tables(())
    scene_without_table = restored_session.scene()
    assert difference_text(scene_with_table, scene_without_table) == "F=over time"
    assert difference_text(scene_without_table, scene_with_table) == "F=20"
    assert legend_names({1: scene_with_table, 2: scene_without_table}) == ["F over time", "F 20 N"]
