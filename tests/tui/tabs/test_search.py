"""Keys of vi and the search with / in lists, texts and charts."""

from textual.pilot import Pilot
from textual.widgets import DataTable, Static

from fivtui.tui.lab.form.form import FieldList
from tests.support.laboratory import app_of, chart_of, run_to_end, until, until_hidden, until_shown

SIZE = (100, 30)


async def test_a_list_is_searched_and_moved_in(pilot: Pilot[None]) -> None:
    await pilot.press("alt+0")
    await until_shown(pilot, "what it shows")
    await pilot.press("alt+p")
    table = pilot.app.screen.query_one("#figures", DataTable)
    await until(pilot, lambda: table.has_focus and table.row_count > 15)
    await pilot.press("slash", *"horiz", "backspace", "enter")
    await until(pilot, lambda: table.has_focus)
    first_match = table.cursor_row
    assert "Horizontal displacement" in str(table.get_row_at(first_match))
    # There is no other match.
    await pilot.press("n")
    assert table.cursor_row == first_match
    await pilot.press("slash", *"over time", "enter")
    await until(pilot, lambda: table.has_focus)
    await pilot.press("N")
    assert table.cursor_row == first_match - 1
    await pilot.press("n")
    assert table.cursor_row == first_match
    # A search that is cancelled leaves the cursor in its row.
    await pilot.press("slash", *"2z")
    await until_shown(pilot, "no match: 2z")
    await pilot.press("escape")
    await until(pilot, lambda: table.has_focus)
    assert table.cursor_row == first_match
    await pilot.press("G")
    assert table.cursor_row == table.row_count - 1
    await pilot.press("g", "g", "ctrl+d")
    assert 0 < table.cursor_row < table.row_count - 1
    await pilot.press("ctrl+u")
    assert table.cursor_row == 0


async def test_a_field_is_found_by_its_meaning(pilot: Pilot[None]) -> None:
    await pilot.press("escape", "slash", *"preload", "enter")
    fields = pilot.app.screen.query_one(FieldList)
    await until(pilot, lambda: fields.has_focus)
    assert fields.row.field.name == "F"
    await pilot.press("slash", *"state at", "enter")
    await until(pilot, lambda: fields.has_focus and fields.row.field.name == "start")
    # In an input of text these keys are text.
    await pilot.press("slash", "escape", "i", "slash")
    await until(pilot, lambda: "/" in app_of(pilot).session.texts["start"])


async def test_a_search_in_the_help_hides_other_lines(pilot: Pilot[None]) -> None:
    await pilot.press("f1")
    await until_shown(pilot, "Keys that work now")
    help_rows = pilot.app.screen.query_one(".lines", Static)
    height = help_rows.size.height
    await pilot.press("slash", *"engine")
    await pilot.press("enter")
    await until(pilot, lambda: 0 < help_rows.size.height < height)
    await until_shown(pilot, "Next engine")
    await until_hidden(pilot, "Reset the field")
    await pilot.press("slash", "escape")
    await until(pilot, lambda: help_rows.size.height == height)


async def test_keys_of_vi_show_the_ends_of_a_run_and_move_its_cursor(pilot: Pilot[None]) -> None:
    await run_to_end(pilot)
    await pilot.press("alt+p")
    view = chart_of(pilot, "plot-y").view
    linked = chart_of(pilot, "plot-P").view

    def limits() -> tuple[float, float] | None:
        return (
            None
            if view.x is None or view.x != linked.x
            else (round(view.x.low, 9), round(view.x.high, 9))
        )

    await pilot.press("G")
    await until(pilot, lambda: limits() == (90.0, 100.0))
    await pilot.press("ctrl+u")
    await until(pilot, lambda: limits() == (85.0, 95.0))
    await pilot.press("g")
    await until(pilot, lambda: limits() == (0.0, 10.0))
    await pilot.press("c", "G")
    await until(pilot, lambda: view.cursors.first is not None and view.cursors.first[0] == 10.0)
    await pilot.press("g")
    await until(pilot, lambda: view.cursors.first is not None and view.cursors.first[0] == 0.0)
    # In a phase portrait the keys limit the time of the run.
    await pilot.press("v", "G")
    await until(pilot, lambda: limits() == (90.0, 100.0))
