"""Charts below each other: one large chart, another by a key, and all where they fit."""

from textual.pilot import Pilot

from fivtui.tui.app import FivtuiApp
from tests.support.laboratory import app_of, chart_of, show_tab, text_of, until, until_shown

SIZE = (80, 24)


def quantities(pilot: Pilot[None]) -> list[str]:
    """The quantities that are drawn over time."""
    return [name for name in ("y", "x", "P") if chart_of(pilot, f"plot-{name}").is_on_screen]


async def until_drawn(pilot: Pilot[None]) -> None:
    await show_tab(pilot, "alt+1")
    await until(pilot, lambda: chart_of(pilot, "plot-y").chart is not None)


async def test_a_key_or_a_click_shows_each_quantity_and_all_of_them(pilot: Pilot[None]) -> None:
    await until_drawn(pilot)
    assert quantities(pilot) == ["y"]
    # The heading names the key.
    await until_shown(pilot, "n:next")
    await pilot.press("alt+p", "n")
    await until(pilot, lambda: quantities(pilot) == ["P"])
    await until_shown(pilot, "P (N)")
    await pilot.press("n")
    await until(pilot, lambda: quantities(pilot) == ["x"])
    await pilot.press("n")
    await until(pilot, lambda: quantities(pilot) == ["y", "x", "P"])
    # The time axis and the strip of separations are drawn once.
    texts = [chart_of(pilot, f"plot-{name}").text() for name in ("y", "P", "x")]
    assert ["off belt" in text for text in texts] == [True, False, False]
    assert ["t (s)" in text for text in texts] == [False, False, True]
    (row, column), *_ = (
        (row, line.index("n:next"))
        for row, line in enumerate(text_of(pilot).splitlines())
        if "n:next" in line
    )
    await pilot.click(offset=(column, row))
    await until(pilot, lambda: quantities(pilot) == ["y"])
    assert app_of(pilot).session.settings["transient"]["chart-time"] == "plot-y"


async def test_high_screens_show_all_quantities() -> None:
    async with FivtuiApp().run_test(size=(120, 50)) as pilot:
        await until_drawn(pilot)
        await until(pilot, lambda: quantities(pilot) == ["y", "x", "P"])
        heights = [chart_of(pilot, f"plot-{name}").size.height for name in ("y", "x", "P")]
        assert min(heights) >= 6
        # Cursors move no axis.
        await pilot.press("alt+p", "c")
        await until_shown(pilot, "C: second cursor")
        names = ("y", "x", "P")
        assert [chart_of(pilot, f"plot-{name}").size.height for name in names] == heights
        # A choice holds also where all would fit.
        await pilot.press("n")
        await until(pilot, lambda: quantities(pilot) == ["y"])


async def test_the_time_axis_moves_to_the_chart_that_remains() -> None:
    async with FivtuiApp().run_test(size=(120, 50)) as pilot:
        await until_drawn(pilot)
        await until(pilot, lambda: "t (s)" not in chart_of(pilot, "plot-y").text())
        await pilot.resize_terminal(80, 24)
        await until(pilot, lambda: "t (s)" in chart_of(pilot, "plot-y").text())


async def test_low_screens_show_one_chart_of_a_page_at_a_time(pilot: Pilot[None]) -> None:
    await show_tab(pilot, "alt+2")
    await until(pilot, lambda: chart_of(pilot, "growth").chart is not None)
    growth, frequency = chart_of(pilot, "growth"), chart_of(pilot, "frequency")
    assert (growth.is_on_screen, frequency.is_on_screen) == (True, False)
    picture = growth.current_picture()
    assert picture is not None
    assert picture.plot_area.rows >= 8
    # The focus follows the visible chart.
    await pilot.press("alt+p", "n")
    await until(pilot, lambda: frequency.is_on_screen and not growth.is_on_screen)
    assert pilot.app.focused is frequency
    await pilot.press("n")
    await until(pilot, lambda: frequency.is_on_screen and growth.is_on_screen)
