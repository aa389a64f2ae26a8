"""No text is cut at any size, and the README's picture agrees with the laboratory."""

import html
import re
from pathlib import Path

import pytest
from textual.pilot import Pilot
from textual.widgets import Button, Checkbox, Input, Select

from fivtui.model import PARAMETERS
from fivtui.tui.app import FivtuiApp
from fivtui.tui.lab.notices import NoticeView
from fivtui.tui.session import FIELDS
from fivtui.tui.tabs import TABS, Reported, TabLine
from tests.support.laboratory import (
    notices_of,
    show_tab,
    text_of,
    until,
    until_hidden,
    until_notice,
    until_shown,
    until_still,
)

PICTURE = Path(__file__).parents[2] / "examples" / "laboratory.svg"
SIZES = [(80, 24), (100, 30), (120, 35), (140, 40), (200, 60)]


async def test_panes_are_complete_and_titles_uncut_at_any_size() -> None:
    async with FivtuiApp().run_test(size=SIZES[0]) as pilot:
        for size in SIZES:
            await pilot.resize_terminal(*size)
            await until(pilot, lambda: pilot.app.size == size)  # noqa: B023
            await show_tab(pilot, "alt+2")
            await until_shown(pilot, "Re λ (1/s)")
            await until_still(pilot)
            check_panes(pilot, size)
            # The buttons measure errors and times of methods, or check the claims of the paper.
            for key, phrase in (
                ("alt+8", "State Peak ±2nd ½ Events Table"),
                ("alt+8", "F10 measures all methods"),
                ("alt+3", "Growth μ_c Modes"),
                ("alt+5", "Safe μ Regions"),
                ("alt+0", "Check F10 Enter: figure, o: scene"),
            ):
                if size in (SIZES[0], SIZES[-1]):
                    await show_tab(pilot, key)
                    await until_shown(pilot, phrase)
        # Titles of views are abbreviated in a narrow terminal.
        await show_tab(pilot, "alt+1")
        await until_shown(pilot, "Difference")
        await pilot.resize_terminal(80, 24)
        await until_shown(pilot, "Time Phase Spectrum Diff Belt Meas Result")
        await pilot.resize_terminal(120, 35)
        await until_shown(pilot, "Time Phase Spectrum Difference Belt Measured Result")


def check_panes(pilot: Pilot[None], size: tuple[int, int]) -> None:
    """Check edges, gauge, units and titles of the tabs."""
    width, height = size
    lines = text_of(pilot).splitlines()
    # All lines fill the width up to an edge, except those of the tabs and of the keys.
    *upper_lines, _key_line = (line.rstrip() for line in lines)
    (tab_line,) = (line for line in upper_lines if "Branches" in line)
    assert {line[-1] for line in upper_lines if line != tab_line} <= set("╮│╯")
    # All tabs have a title; a wide screen shows the digits of their keys, and groups of tabs.
    titles = [re.escape(tab.title) for tab in TABS]
    assert re.search(" .*".join(titles), tab_line)
    assert (re.search("3 Map +4 Branches", tab_line) is not None) is (width >= 100)
    assert (re.search("Stability +2 Modes", tab_line) is not None) is (width >= 120)
    # An edge separates the units of the form from the tab.
    form_region = pilot.app.screen.query_one("Form").region
    assert {
        line[form_region.right - 1] for line in lines[form_region.y : form_region.bottom]
    } <= set("╮│╯")
    (gauge_line,) = (line for line in lines if line.startswith("│ μ ") and "●" in line)
    assert "squeals by itself" in gauge_line
    assert any(line.split() == ["│", "0", "0.439", "0.7", "1.5", "│"] for line in lines)
    for name, spec in PARAMETERS.items():
        symbol = FIELDS[name].symbol
        (field_line,) = (
            line[: line.index("│", 1)] for line in lines if re.match(rf"│ {symbol} .*−  \+", line)
        )
        # A wide form also has the meaning of each field.
        meaning = spec.meaning if width >= 180 else ""
        assert field_line.rstrip().endswith(meaning or spec.unit or "+"), field_line
    if height >= 30:
        assert any("↑↓ step  F8 reset ─╯" in line for line in lines)
        assert "μ_c 0.4394" in text_of(pilot)
    # There is room for a second gauge, over F.
    assert ("F (N) " in text_of(pilot)) is (height >= 36)
    # On a large screen, the form has all help on the focused field, and the equations.
    assert ("default  0.7" in text_of(pilot)) is (width >= 180)


@pytest.mark.parametrize(
    "size",
    [(80, 24), *(pytest.param(size, marks=pytest.mark.whole) for size in SIZES[1:])],
)
async def test_notices_cover_no_control_that_is_clicked(size: tuple[int, int]) -> None:
    async with FivtuiApp().run_test(size=size) as pilot:
        screen = pilot.app.screen
        long_text = "as long as the words of some errors are " * 20
        for number in range(5):
            screen.post_message(Reported(f"number {number}", error=bool(number % 2)))
        await until_notice(pilot, "number 4")
        await until_shown(pilot, "▌ number 2 ")
        screen_text = text_of(pilot)
        assert "▌ number 4 " in screen_text
        assert "number 1" not in screen_text
        screen.post_message(Reported(long_text, error=True))
        await until_shown(pilot, "… (tab Log)")
        notices = notices_of(pilot)
        assert notices.region.height == 3
        assert notices.region.bottom == size[1] - 1
        for tab in TABS:
            await show_tab(pilot, tab.key)
            control_regions = [
                screen.find_widget(control).visible_region
                for control_class in (Button, Input, Checkbox, Select, TabLine)
                for control in screen.query(control_class)
                if control.is_on_screen
            ]
            assert control_regions
            assert not [
                region for region in control_regions if region and region.overlaps(notices.region)
            ], tab.id
        # A click removes a notice, and notices expire.
        notices.clear()
        screen.post_message(Reported("one", error=True))
        await until_shown(pilot, "▌ one ")
        await pilot.click(NoticeView)
        await until(pilot, lambda: not notices.display)
        await until_hidden(pilot, "▌ one")
        screen.post_message(Reported("two"))
        await until_shown(pilot, "▌ two ")
        notices._remove(notices.notices[0])
        await until(pilot, lambda: not notices.display)


def test_the_picture_of_the_readme_is_current() -> None:
    texts = re.findall(r"<text[^>]*>(.*?)</text>", PICTURE.read_text(encoding="utf-8"))
    picture_text = " ".join(html.unescape(" ".join(texts)).split())
    for phrase in (
        *(tab.title for tab in TABS),
        *(FIELDS[name].symbol for name in PARAMETERS),
        "Parameters",
        "Runs",
        "squeals by itself",
        # A basis of the safe friction coefficient, and this coefficient.
        "a global search",
        "0.278",
        "separation considered",
        "F5 Run F10 Compute F1 Help",
    ):
        assert phrase in picture_text, phrase
