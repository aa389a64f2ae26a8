"""The application from its start to its end: a run fills all tabs, at every size."""

from collections.abc import Iterator

import pytest
from textual.pilot import Pilot
from textual.widgets import Input

from fivtui.tui.app import FivtuiApp
from fivtui.tui.chart.widget.chart_view import ChartView
from fivtui.tui.session.runs import RunState
from fivtui.tui.tabs.tab_book import TABS
from tests.support.kernels import INTERPRETED
from tests.support.laboratory import (
    ENDLESS,
    app_of,
    chart_of,
    click_view,
    endless_simulate,
    flat_text_of,
    focus,
    run_to_end,
    show_all_quantities,
    text_of,
    type_into,
    until,
    until_hidden,
    until_notice,
    until_screen,
    until_shown,
)

SIZE = (80, 24)


@pytest.fixture
def interpreted() -> Iterator[None]:
    """Use the interpreted kernel, so that long runs stay long."""
    with INTERPRETED:
        yield


async def test_a_finished_run_fills_plots_summary_and_tabs(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    # Render every frame, as for a terminal; other tests render only the texts that they read.
    monkeypatch.setattr("tests.support.laboratory.every_frame", True)
    # The critical friction coefficient μ_c, and μ.
    await until_shown(pilot, "0.439 0.7")
    await run_to_end(pilot)
    await show_all_quantities(pilot)
    screen_text = text_of(pilot)
    for phrase in (
        "amplitude of y ±4.401 m, still falling",
        "run 1 done · Alt+4 Branches: safe?",
        "y (m)",
        "P (N)",
        "⢕",
    ):
        assert phrase in screen_text, phrase
    assert any(line.endswith("100│") for line in screen_text.splitlines())
    # Shades of the strip, from ░ to █, are the share of time off the belt in each column.
    contact_strip = next(line for line in screen_text.splitlines() if "off belt" in line)
    assert "▓▓▓" in contact_strip
    assert "inputs changed" not in screen_text

    plot = chart_of(pilot, "plot-y")
    pilot.app.screen.query_one("#plot-P").focus()
    await pilot.press("G")
    await until_shown(pilot, "90 92 94 96 98 100")
    contact_strip = next(line for line in text_of(pilot).splitlines() if "off belt" in line)
    assert "███" in contact_strip
    assert "░" in contact_strip
    await pilot.press("r")
    await until_shown(pilot, "0 20 40 60 80 100")
    await pilot.press("plus", "plus", "h")
    await until(pilot, lambda: "0 20 40 60 80 100" not in flat_text_of(pilot))
    for name in ("#plot-y", "#plot-P"):
        x = pilot.app.screen.query_one(name, ChartView).view.x
        assert x is not None
        assert 0.0 < x.low < x.high < 100.0
    await pilot.press("r", "minus", "minus", "l", "l")
    await pilot.pause()
    assert plot.chart is not None
    full_axis, _ = plot.view.axes(plot.chart)
    assert (full_axis.low, full_axis.high) == (0.0, 100.0)

    def background() -> object:
        return next(iter(plot.render_line(2))).style

    colour_before = background()
    pilot.app.theme = "gruvbox"
    await until(pilot, lambda: background() != colour_before)

    await pilot.resize_terminal(160, 40)
    await until_shown(pilot, "still falling · 74 separations")
    await pilot.resize_terminal(*SIZE)
    plot.focus()
    visited_tabs = []
    for _ in range(len(TABS)):
        await pilot.press("f2")
        visited_tabs.append(app_of(pilot).session.tab)
    assert sorted(visited_tabs) == sorted(tab.id for tab in TABS)
    assert app_of(pilot).session.tab == "transient"
    # The view Result and the tab Log.
    await click_view(pilot, "result")
    await until_shown(pilot, "range of y -2.68537 to")
    await pilot.press("alt+minus")
    await until_shown(pilot, "run 1 done; amplitude of y ±4.401 m")
    await pilot.press("f2")
    await until_shown(pilot, "range of y -2.68537 to")
    # Without the live curve, the state of the run stays.
    await pilot.press("alt+l")
    await type_into(pilot, "F", "100")
    await until_shown(pilot, "growth rate +0.4136 1/s")
    await until_shown(pilot, "run 1 done, inputs changed since")


@pytest.mark.usefixtures("interpreted")
async def test_a_run_starts_after_a_long_run_was_stopped(pilot: Pilot[None]) -> None:
    session = app_of(pilot).session
    await type_into(pilot, "t_end", ENDLESS)
    await pilot.press("f5")
    await until_shown(pilot, "Stop")
    long_run = session.runs.active
    assert long_run is not None
    await until(pilot, lambda: long_run.fraction > 0.0)
    await until_shown(pilot, "left")
    await until_shown(pilot, "F5 Stop")
    editor = await focus(pilot, "F")
    await pilot.press("up")
    assert editor.value == "81"
    await pilot.press("f5")
    assert long_run.state is RunState.STOPPED
    await until_notice(pilot, "run 1 stopped at")
    await until_shown(pilot, "F5 Run")
    await type_into(pilot, "t_end", "100")
    await run_to_end(pilot)
    await until_shown(pilot, "run 2 done")
    assert long_run.result is None
    assert [run.state for run in session.runs] == [RunState.STOPPED, RunState.DONE]


@pytest.mark.usefixtures("interpreted")
async def test_inputs_of_the_first_screen_compose_also_where_textual_starts_tasks_eagerly() -> None:
    app = FivtuiApp()

    async def quit_when_ready(pilot: Pilot[object]) -> None:
        assert pilot.app.screen.query(Input)
        pilot.app.exit(return_code=7)

    await app.run_async(headless=True, auto_pilot=quit_when_ready)
    assert app.return_code == 7


async def test_quitting_does_not_wait_for_a_long_run() -> None:
    app = FivtuiApp()
    async with app.run_test(size=SIZE) as pilot:
        await type_into(pilot, "t_end", ENDLESS)
        await pilot.press("f5")
        await until(pilot, lambda: app.session.runs.active is not None)
    # This line is reached only if quitting has stopped the thread.
    assert app.session.runs.active is None


async def test_the_button_starts_and_stops_a_run_and_failures_are_shown_and_logged(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    runs = app_of(pilot).session.runs
    with monkeypatch.context() as patched:
        patched.setattr("fivtui.scene.run.compute", endless_simulate)
        await pilot.click(".action")
        await until(pilot, lambda: runs.active is not None)
        # A button ignores clicks while it is drawn as pressed.
        button = pilot.app.screen.query_one(".action")
        await until(pilot, lambda: not button.has_class("-active"))
        await pilot.click(".action")
        await until(pilot, lambda: runs.active is None)
        assert runs.newest is not None
        assert runs.newest.state is RunState.STOPPED

    await type_into(pilot, "tol", "1")
    await pilot.press("f5")
    await until_notice(pilot, "tol = 1: must be from 1e-13 to 0.01")
    assert len(list(runs)) == 1
    # Reset all fields.
    await pilot.press("shift+f8")

    await type_into(pilot, "k3", "0")
    await type_into(pilot, "F", "-5")
    await pilot.press("f5")
    await until_shown(pilot, "run 2 failed")
    await pilot.press("alt+minus")
    await until_shown(pilot, "ERROR: run 2: no equilibrium")

    def raise_zero_division(_run: object) -> None:
        raise ZeroDivisionError("by zero")

    monkeypatch.setattr("fivtui.tui.lab.run_actions.execute", raise_zero_division)
    await pilot.press("f5")
    await until_notice(pilot, "unexpected ZeroDivisionError: by zero")
    await until_shown(pilot, "run 3 failed")
    await until_hidden(pilot, "Traceback")


async def test_every_size_shows_form_verdict_and_result(pilot: Pilot[None]) -> None:
    await run_to_end(pilot)
    # "shown native 10.50" is in the list of runs: plotted, engine, peak |y|.
    for (width, height), phrases in (
        ((80, 24), ("y (m)", "off belt", "kg", "amplitude of y", " 0.7 ")),
        ((200, 60), ("P (N)", "off belt", "friction coefficient", "P 0 to 2071 N")),
        ((200, 60), ("±y 2nd half", "shown native 10.50")),
        ((60, 20), ("amplitude of y", "F5 Run", "k1")),
        ((40, 12), ("UNSTABLE", "F5 Run", "y (m)")),
        ((39, 12), ("too small for fivtui: it needs 40 columns and 10 lines",)),
        ((100, 9), ("too small",)),
        ((100, 30), ("UNSTABLE", "F5 Run", "y (m)")),
    ):
        await pilot.resize_terminal(width, height)
        for phrase in phrases:
            await until_shown(pilot, phrase)
        # Up to 12 lines have no room for an axis.
        if height > 12:
            await until_screen(pilot, time_axes_reach_the_right_edge)


def time_axes_reach_the_right_edge(screen_text: str) -> bool:
    lines = screen_text.splitlines()
    axis_lines = [line.rstrip("│ ") + "│" for line in lines if "t (s) " in line]
    return bool(axis_lines) and all(len(line) == len(lines[0]) for line in axis_lines)


async def test_without_colour_verdicts_are_shown_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    app = FivtuiApp()
    assert app.no_color
    async with app.run_test(size=SIZE) as pilot:
        await run_to_end(pilot)
        await until_shown(pilot, "UNSTABLE")
        await type_into(pilot, "mu", "-")
        await until_shown(pilot, "NO VERDICT: invalid input")
