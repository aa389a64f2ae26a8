"""Tables look the same from their first frame on, whatever was listed earlier."""

import pytest
from rich.text import Text
from textual.app import App, ComposeResult

from fivtui.tui.app import FivtuiApp
from fivtui.tui.tabs.tables import ListTable, shorten
from tests.support.laboratory import show_tab, text_of, until_shown

MAP_TAB, PAPER_TAB, RUN_LIST = "alt+3", "alt+0", "f3"
COLUMNS = ("figure", "what it shows")
LONG_ROWS = {"1": ("a key of many words", "long " * 20)}
SHORT_ROWS: dict[str, tuple[str | Text, ...]] = {
    "1": ("2a to 2c", "x"),
    "2": (Text("■ 10"), "y"),
}


class TableApp(App[None]):
    def compose(self) -> ComposeResult:
        yield ListTable[str | Text]()


def first_lines(table: ListTable[str | Text]) -> list[str]:
    return [table.render_line(y).text for y in range(3)]


async def test_columns_have_their_final_width_from_the_first_frame() -> None:
    async with TableApp().run_test(size=(44, 10)) as pilot:
        table: ListTable[str | Text] = pilot.app.query_one(ListTable)
        table.fill(COLUMNS, SHORT_ROWS)
        first_frame = first_lines(table)
        await pilot.pause()
        assert first_lines(table) == first_frame
        assert first_frame[0].split() == ["figure", "what", "it", "shows"]
        assert first_frame[2].split() == ["■", "10", "y"]


async def test_column_widths_do_not_depend_on_earlier_content() -> None:
    async with TableApp().run_test(size=(44, 10)) as pilot:
        table: ListTable[str | Text] = pilot.app.query_one(ListTable)
        table.fill(COLUMNS, SHORT_ROWS)
        await pilot.pause()
        lines_without_history = first_lines(table)
        for rows in (LONG_ROWS, SHORT_ROWS):
            table.fill(COLUMNS, rows)
            await pilot.pause()
        assert first_lines(table) == lines_without_history


# The tab is opened first, or after the map and the run list.
@pytest.mark.parametrize("earlier_keys", [[], [MAP_TAB, RUN_LIST]])
async def test_the_list_of_figures_has_room_for_its_headings(earlier_keys: list[str]) -> None:
    async with FivtuiApp().run_test(size=(80, 24)) as pilot:
        for key in earlier_keys:
            await pilot.press(key)
        await show_tab(pilot, PAPER_TAB)
        await until_shown(pilot, "what it shows")
        # Two blanks separate the headings; the last heading is not cut.
        headings = next(line for line in text_of(pilot).splitlines() if "figure  " in line)
        assert headings.rstrip("│ ").endswith("what it shows")


async def test_a_narrow_table_omits_one_column_and_wraps_another() -> None:
    columns = ("verdict", "statement", "stated")
    rows = {"1": ("holds", "the slider leaves the belt as soon as it can", "a number")}

    class ClaimsApp(App[None]):
        def compose(self) -> ComposeResult:
            yield ListTable[str | Text](wrapped="statement", omitted=("stated",))

    async with ClaimsApp().run_test(size=(44, 10)) as pilot:
        table: ListTable[str | Text] = pilot.app.query_one(ListTable)
        table.fill(columns, rows)
        narrow = first_lines(table)
        assert "stated" not in narrow[0]
        assert " ".join(" ".join(narrow[1:3]).split()) == (
            "holds the slider leaves the belt as soon as it can"
        )
        await pilot.resize_terminal(90, 10)
        await pilot.pause()
        assert first_lines(table)[0].split() == ["verdict", "statement", "stated"]


@pytest.mark.parametrize(
    ("width", "shown"),
    [
        # Width 0: no limit.
        (0, "fold 0.2779 touch 0.3; ends"),
        (27, "fold 0.2779 touch 0.3; ends"),
        (26, "fold 0.2779 touch 0.3…"),
        (22, "fold 0.2779 touch 0.3…"),
        (21, "fold 0.2779 touch…"),
        (3, "fo…"),
    ],
)
def test_words_that_do_not_fit_are_omitted_and_marked(width: int, shown: str) -> None:
    assert shorten("fold 0.2779 touch 0.3; ends", width) == shown
