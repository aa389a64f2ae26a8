"""Inputs of tabs and dialogs: no character is lost, and errors are marked at once."""

import pytest
from textual.events import Paste
from textual.pilot import Pilot
from textual.widgets import Input

from fivtui.ranges import with_decimal_point, with_decimal_points
from fivtui.tui.chart import ChartView
from fivtui.tui.chart.widget.limits_dialog import LimitsDialog
from fivtui.tui.tabs.studies.map import MapPane
from fivtui.tui.tabs.studies.uncertainty import UncertaintyPane
from fivtui.tui.tabs.transient import TransientPane
from tests.support.laboratory import run_to_end, show_tab, until, until_hidden, until_shown

SIZE = (160, 40)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("mu=0,1:0,8:5", "mu=0.1:0.8:5"),
        ("F~normal:80,5:8,25 mu~uniform:0,1:,8", "F~normal:80.5:8.25 mu~uniform:0.1:.8"),
        ("-0,5:1,5e1", "-0.5:1.5e1"),
        ("0,1 : 0,5", "0.1 : 0.5"),
        # Lists, and texts that may become one, stay unchanged.
        ("F=20,40 mu=0,5", "F=20,40 mu=0,5"),
        ("mu=1,2,3:4:5", "mu=1,2,3:4:5"),
        ("mu=0:1,2,3", "mu=0:1,2,3"),
    ],
)
def test_decimal_commas_in_ranges_are_points(text: str, expected: str) -> None:
    assert with_decimal_points(text) == expected
    typed = ""
    for letter in text:
        typed = with_decimal_points(typed + letter)
    # While typing the result is the same, unless the text becomes a list.
    if "," not in expected:
        assert typed == expected


def test_a_decimal_comma_in_a_number_is_a_point() -> None:
    for text, expected in (
        ("0,7", "0.7"),
        (" -,5e-3 ", " -.5e-3 "),
        ("2,5 %", "2.5 %"),
        ("1,2,3", "1,2,3"),
        ("1.2,3", "1.2,3"),
        ("a,5", "a,5"),
        ("0,7 N", "0,7 N"),
    ):
        assert with_decimal_point(text) == expected


# Key and name of the tab, an invalid text, its error, and a valid text.
INPUTS = (
    ("alt+6", "sweep", "mu=0,1:200:5", "mu = 200: must be from 0 to 100", "mu=0.1:2:5"),
    ("alt+3", "map", "mu=0:1:5 F=5:x:3", "F = 'x': not a number; must be", "mu=0:1:5 F=5:9:3"),
    # The message of the third one repeats the text, which the input shows, too.
    ("alt+7", "uncertainty", "F~normal:80:-8", "F~normal:80:-8", "F~normal:80:8"),
    ("alt+9", "identification", "a.csv --fit q", "unknown parameter 'q'", "a,1.csv --fit mu=0.1:1"),
    ("alt+4", "branch", "mu=0,1", "must be NAME or NAME=LOW:HIGH", "mu=0.1:0.9"),
)


async def test_a_wrong_text_in_a_tab_is_marked_at_once(pilot: Pilot[None]) -> None:
    for key, name, invalid_text, error, valid_text in INPUTS:
        await show_tab(pilot, key)
        text_input = pilot.app.screen.query_one(f"#{name}-input", Input)
        text_input.focus()
        await until(pilot, lambda: text_input.has_focus)  # noqa: B023
        for text, is_valid in ((invalid_text, False), (valid_text, True)):
            await pilot.press("end", "ctrl+u")
            pilot.app.post_message(Paste(f"{text}\n"))
            await until(pilot, lambda: text_input.has_class("-invalid") is not is_valid)  # noqa: B023
            assert text_input.value == text.replace("0,1:", "0.1:")
            await (until_hidden if is_valid else until_shown)(pilot, error)
        # Escape leaves the input; keys of the tab work again.
        await pilot.press("escape")
        await until(pilot, lambda: isinstance(pilot.app.focused, ChartView))


async def test_enter_on_a_wrong_text_stops_no_computation(pilot: Pilot[None]) -> None:
    await show_tab(pilot, "alt+7")
    pane = pilot.app.screen.query_one(UncertaintyPane)
    await pilot.press("f10")
    await until(pilot, lambda: pane.job is not None)
    job = pane.job
    text_input = pane.query_one("#uncertainty-input", Input)
    text_input.value = "μ~unif"
    await until(pilot, lambda: text_input.has_class("-invalid"))
    text_input.post_message(Input.Submitted(text_input, text_input.value))
    await pilot.pause()
    assert job is not None
    assert not job.stopped
    pane.stop()


async def test_a_map_that_ends_during_wrong_input_leaves_no_error(pilot: Pilot[None]) -> None:
    await show_tab(pilot, "alt+3")
    pane = pilot.app.screen.query_one(MapPane)
    over = pane.query_one("#map-input", Input)
    over.value = "mu=0:1:5 F=5:x:3"
    await until_shown(pilot, "F = 'x'")
    # As after the end of a map that began before.
    pane.scene_changed()
    over.value = "mu=0:1:5 F=5:9:3"
    await until(pilot, lambda: not over.has_class("-invalid"))
    await until_hidden(pilot, "F = 'x'")


async def test_wrong_numbers_beside_measured_data_are_marked_at_once(pilot: Pilot[None]) -> None:
    await run_to_end(pilot)
    pilot.app.screen.query_one(TransientPane).show_view("measured")
    text_input = pilot.app.screen.query_one("#measured-data", Input)
    text_input.focus()
    await until(pilot, lambda: text_input.has_focus)
    for option, error in (
        ("--scale 0,5x", "not a number"),
        ("--shift later", "must be a time in s, or auto"),
        ("--quantity z", "unknown quantity"),
        ("--band 1 --share 5", "must be a percentage"),
        ("--bnad 5%", "unknown option"),
        ("~no-user/b.csv", "2 files: must be one"),
    ):
        text_input.value = f"a.csv {option}"
        await until_shown(pilot, error)
        assert text_input.has_class("-invalid")
    text_input.value = "a.csv --band "
    await until(pilot, lambda: not text_input.has_class("-invalid"))
    await pilot.press("end", *"5,5")
    assert text_input.value == "a.csv --band 5.5"
    await until_shown(pilot, "--band N|N%: Half width of the tolerance band")
    await pilot.press("escape")
    await until(pilot, lambda: isinstance(pilot.app.focused, ChartView))


async def test_wrong_limits_of_an_axis_are_marked_at_once(pilot: Pilot[None]) -> None:
    await show_tab(pilot, "alt+2")
    await pilot.press("alt+p", "i")
    await until(pilot, lambda: isinstance(pilot.app.screen, LimitsDialog))
    await until(pilot, lambda: isinstance(pilot.app.focused, Input))
    await pilot.press(*"0,5:0,1")
    await until_shown(pilot, "LOW must be below HIGH")
    await pilot.press("backspace", "9")
    await until_shown(pilot, "LOW:HIGH, or empty to fit the data")
    assert isinstance(pilot.app.focused, Input)
    assert pilot.app.focused.value == "0.5:0.9"
