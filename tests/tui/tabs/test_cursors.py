"""Two cursors over all plots of the transient, and limits that persist."""

import pytest
from textual.pilot import Pilot

from fivtui.charts.axis import Axis
from fivtui.tui.app import FivtuiApp
from fivtui.tui.persistence.state_file import session_state
from tests.support.laboratory import (
    app_of,
    chart_of,
    click_view,
    focus,
    run_to_end,
    show_all_quantities,
    text_of,
    until,
    until_hidden,
    until_shown,
)

SIZE = (80, 24)


def chart_lines(pilot: Pilot[None], name: str) -> list[str]:
    """The screen text of a chart."""
    region = chart_of(pilot, name).region
    screen_lines = text_of(pilot).splitlines()
    return [line[region.x : region.right] for line in screen_lines[region.y : region.bottom]]


async def test_two_cursors_are_on_all_plots_with_differences_and_units(
    pilot: Pilot[None],
) -> None:
    await run_to_end(pilot)
    await show_all_quantities(pilot)
    run = app_of(pilot).session.runs.displayed
    assert run is not None
    assert run.result is not None
    motion = run.result.trajectory
    assert motion is not None
    chart_of(pilot, "plot-x").focus()
    await pilot.press("c")
    await until_shown(pilot, "x (m) t 50 s x ")
    await until_shown(pilot, "C: second cursor")
    await pilot.press("C")
    await until_shown(pilot, "t ◆50 ◇75 s Δt 25 s 1/Δt 0.04 Hz")
    sample_indices = [int(abs(motion.t - t).argmin()) for t in (50.0, 75.0)]
    for quantity, unit in (("y", "m"), ("x", "m"), ("P", "N")):
        a, b = (float(getattr(motion, quantity)[index]) for index in sample_indices)
        heading, *plot_lines = chart_lines(pilot, f"plot-{quantity}")
        reading = f"{quantity} ({unit})  {quantity} ◆{a:.5g} ◇{b:.5g} Δ{b - a:.5g} {unit}"
        assert heading.strip() == reading
        assert any("◆" in line for line in plot_lines)
        assert any("◇" in line for line in plot_lines)
    # The cursors also cross the strip.
    (strip,) = (line for line in chart_lines(pilot, "plot-y") if "off belt" in line)
    assert "│" in strip
    assert "┊" in strip
    # Keys move the second cursor; another plot shows the same two.
    await pilot.press("left")
    cursors = chart_of(pilot, "plot-y").view.cursors
    assert cursors.first is not None
    assert cursors.first[0] == 50.0
    assert cursors.second is not None
    assert cursors.second[0] < 75.0
    chart_of(pilot, "plot-P").focus()
    # c makes the first cursor the active one, which keys move.
    await pilot.press("c", "right")
    await until(pilot, lambda: cursors.first is not None and cursors.first[0] > 50.0)
    # The phase portraits mark the same times along their curves.
    await pilot.press("v")
    await until_shown(pilot, "ẏ ◆")
    assert chart_of(pilot, "phase-y").view.cursors is cursors
    assert chart_of(pilot, "phase-x").view.cursors is cursors
    index = int(abs(motion.t - cursors.first[0]).argmin())
    await until_shown(pilot, f"y ◆{motion.y[index]:.5g} ")
    await pilot.press("n")
    await until_shown(pilot, f"ẋ ◆{motion.vx[index]:.5g} ")
    old_position = cursors.first
    await pilot.press("left")
    assert old_position is not None
    assert cursors.first is not None
    assert 0.0 < old_position[0] - cursors.first[0] < 0.2
    # The spectrum has its own cursors, at frequencies.
    await pilot.press("v")
    chart_of(pilot, "plot-spectrum").focus()
    await pilot.press("c", "C")
    await until_shown(pilot, "1/Δf")
    await until_shown(pilot, "Hz Δf ")
    # The slider is shown at the time of the first cursor.
    await click_view(pilot, "belt")
    await until_shown(pilot, f"{cursors.first[0]:.5g} s, ")
    # Keys switch the cursors off one by one, or both.
    await click_view(pilot, "time")
    chart_of(pilot, "plot-y").focus()
    # c removes the first cursor if it is active.
    await pilot.press("c")
    assert cursors.first is None
    assert cursors.second is not None
    await pilot.press("escape")
    assert cursors.second is None
    await until_shown(pilot, "amplitude of y")


@pytest.mark.whole
@pytest.mark.parametrize("size", [(80, 24), (120, 35), (200, 60)])
async def test_cursor_values_are_never_cut(size: tuple[int, int]) -> None:
    async with FivtuiApp().run_test(size=size) as pilot:
        await run_to_end(pilot)
        await show_all_quantities(pilot)
        await focus(pilot, "mu")
        await pilot.press("up")
        await until(pilot, lambda: app_of(pilot).session.live.curve is not None)
        chart_of(pilot, "plot-y").focus()
        await pilot.press("c", "C", "shift+up", "plus")
        await until_shown(pilot, "1/Δt")
        for name, unit in (("plot-y", "m"), ("plot-x", "m"), ("plot-P", "N")):
            chart_text = " ".join(" ".join(chart_lines(pilot, name)).split())
            for trace in ("before", "live"):
                _, _, reading = chart_text.partition(f"{trace} ◆")
                value, second, difference, shown_unit = reading.split()[:4]
                assert float(second.removeprefix("◇")) - float(value) == pytest.approx(
                    float(difference.removeprefix("Δ")), rel=1e-2, abs=1e-3
                )
                assert shown_unit == unit
            # The smallest terminal has no room for the note on chosen limits.
            _, height = size
            _, least_height = SIZE
            if height > least_height:
                assert ("zoom t, y" if name == "plot-y" else "zoom t") in chart_text
        await until_shown(pilot, " Hz")


@pytest.mark.whole
async def test_the_right_button_places_the_second_cursor(pilot: Pilot[None]) -> None:
    await run_to_end(pilot)
    cursors = chart_of(pilot, "plot-y").view.cursors
    await pilot.hover("#plot-y", offset=(20, 2))
    await until_shown(pilot, "t 32.89")
    assert not cursors.pinned
    await pilot.click("#plot-y", offset=(20, 2))
    await pilot.click("#plot-y", offset=(30, 2), button=3)
    await until_shown(pilot, "Δt 26.32 s")
    assert cursors.pinned
    # A cursor that follows the pointer does not count as the first.
    await pilot.press("escape")
    chart_of(pilot, "plot-y").focus()
    await pilot.press("escape")
    await pilot.click("#plot-y", offset=(30, 2), button=3)
    await until_shown(pilot, "t ◆50 ◇59.21 s")


async def test_chosen_limits_persist_are_marked_and_name_a_new_run_outside_of_them(
    pilot: Pilot[None],
) -> None:
    await run_to_end(pilot)
    chart_view = chart_of(pilot, "plot-y")
    chart_view.focus()
    await until_hidden(pilot, "zoom")
    await pilot.press("i", "tab", *"-12:12", "enter")
    await until(pilot, lambda: chart_view.view.y == Axis(-12.0, 12.0))
    await until_shown(pilot, "y (m) zoom y")
    await until_hidden(pilot, "outside")
    # A larger motion exceeds the limits.
    field = await focus(pilot, "mu")
    field.value = "1.2"
    await until(pilot, lambda: app_of(pilot).session.texts["mu"] == "1.2")
    await run_to_end(pilot)
    await until_shown(pilot, "run 2 partly outside, r: fit")
    assert "zoom" not in "".join(chart_lines(pilot, "plot-x"))
    # The state stores the run since which the limits hold.
    state = session_state(app_of(pilot).session)
    assert state.data["views"]["plot-y"].newest_run_when_zoomed == 1
    # Limits chosen while the run is visible give no notice, unless all of it is outside.
    chart_view.focus()
    await pilot.press("shift+up")
    await until_hidden(pilot, "outside")
    await pilot.press("i", "tab", *["backspace"] * 20, *"200:300", "enter")
    await until_shown(pilot, "run 2 outside, r: fit")
    await pilot.press("r")
    await until_hidden(pilot, "outside")
    await until_hidden(pilot, "zoom")
