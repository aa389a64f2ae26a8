from collections.abc import AsyncIterator

import pytest
from textual.pilot import Pilot
from textual.widgets import Checkbox, Input, Select

from fivtui.core import kernel_choice
from fivtui.core.parameters import Parameters
from fivtui.core.stability import stability
from fivtui.presets import PRESETS
from fivtui.tui.app import FivtuiApp
from fivtui.tui.chart_view import ChartView
from fivtui.tui.runs import RunState
from fivtui.tui.tab_book import TabBook
from fivtui.tui.tabs import TABS
from tests.tui_support import (
    ENDLESS,
    app_of,
    endless_simulate,
    flat_text_of,
    focus,
    run_to_end,
    text_of,
    type_into,
    until,
    until_shown,
    until_told,
)

USUAL = (80, 24)


@pytest.fixture(autouse=True)
def _interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    # A long run stays long, whatever has been compiled by then.
    monkeypatch.setattr(kernel_choice, "chosen", lambda _kernel: None)


@pytest.fixture
async def pilot() -> AsyncIterator[Pilot[None]]:
    async with FivtuiApp().run_test(size=USUAL, notifications=True) as started:
        await started.pause()
        yield started


async def test_the_base_scene_and_its_verdict_are_there_at_once(pilot: Pilot[None]) -> None:
    shown = text_of(pilot)
    assert "UNSTABLE: growth rate +0.6304 1/s, 0.9186 Hz" in shown
    assert "μ_c 0.4394 (unstable above)" in shown
    assert "x_e 0.1583 m  y_e -0.6292 m  P_e 56.37 N" in shown
    assert "F5 Run" in shown
    assert "F1 Help" in shown
    assert "no run yet" in shown


async def test_the_form_shows_every_field_with_its_unit(pilot: Pilot[None]) -> None:
    lines = [" ".join(line.split()) for line in text_of(pilot).splitlines()]
    for words in ("k_nl 100 − + N/m^3", "μ 0.7 − +", "c_1 0.32 − + N s/m", "tol 1e-12 − +"):
        assert any(line.startswith(words) for line in lines), words


async def test_a_form_with_a_scene_shows_that_scene() -> None:
    async with FivtuiApp(PRESETS["stiff-contact"], "stiff-contact").run_test(
        size=USUAL, notifications=True
    ) as pilot:
        await pilot.pause()
        assert "stiff-contact" in text_of(pilot)
        assert (await focus(pilot, "k_nl")).value == "300"


async def test_the_verdict_follows_while_a_value_is_typed(pilot: Pilot[None]) -> None:
    await type_into(pilot, "mu", "0.3")
    assert "STABLE: growth rate -0.03" in text_of(pilot)
    assert "UNSTABLE" not in text_of(pilot)
    assert "base (changed)" in text_of(pilot)


async def test_an_invalid_text_is_explained_below_its_field(pilot: Pilot[None]) -> None:
    await type_into(pilot, "m", "0")
    lines = text_of(pilot).splitlines()
    row = next(index for index, line in enumerate(lines) if line.startswith(" m  "))
    assert "m = 0: allowed is 0 < m <=" in lines[row + 1]
    assert "NO VERDICT: invalid input" in text_of(pilot)
    await type_into(pilot, "m", "5")
    assert "allowed is 0 < m" not in text_of(pilot).splitlines()[row + 1]
    assert "UNSTABLE" in text_of(pilot)


async def test_markup_in_an_input_is_shown_as_it_is(pilot: Pilot[None]) -> None:
    editor = await focus(pilot, "m")
    editor.value = "[bold]5[/bold"
    await until_shown(pilot, "m = '[bold]5[/bold'")


async def test_a_set_without_equilibrium_has_no_verdict_and_says_why(pilot: Pilot[None]) -> None:
    await type_into(pilot, "k3", "0")
    await type_into(pilot, "F", "-5")
    assert "NO VERDICT" in text_of(pilot)
    assert "no equilibrium" in flat_text_of(pilot)


async def test_arrows_nudge_the_number_in_focus(pilot: Pilot[None]) -> None:
    editor = await focus(pilot, "mu")
    await pilot.press("up")
    assert editor.value == "0.71"
    await pilot.press("down", "down", "shift+down")
    assert editor.value == "0.689"
    growth = stability(Parameters(mu=0.689)).growth_rate
    assert f"growth rate {growth:+.4g}" in text_of(pilot)


async def test_nudging_faster_than_the_screen_loses_no_step(pilot: Pilot[None]) -> None:
    editor = await focus(pilot, "F")
    await pilot.press(*["up"] * 10)
    await until(pilot, lambda: editor.value == "90")
    assert app_of(pilot).session.texts["F"] == "90"


async def test_buttons_nudge_by_mouse(pilot: Pilot[None]) -> None:
    await pilot.click("#row-F NudgeButton:last-of-type")
    await until(pilot, lambda: app_of(pilot).session.texts["F"] != "80")
    assert (await focus(pilot, "F")).value == app_of(pilot).session.texts["F"]


async def test_separation_is_switched_in_words(pilot: Pilot[None]) -> None:
    box = pilot.app.screen.query_one(Checkbox)
    box.focus()
    await pilot.press("space")
    assert "ignored" in text_of(pilot)
    assert not app_of(pilot).session.scene().separation


async def test_the_method_is_chosen_from_a_list(pilot: Pilot[None]) -> None:
    pilot.app.screen.query_one(Select).focus()
    await pilot.press("enter", "down", "enter")
    await until(pilot, lambda: app_of(pilot).session.texts["method"] == "rk4")


async def test_a_field_and_all_fields_are_reset(pilot: Pilot[None]) -> None:
    await type_into(pilot, "F", "90")
    await type_into(pilot, "mu", "0.3")
    await pilot.press("f8")
    assert "base (changed)" in text_of(pilot)
    assert app_of(pilot).session.changed == ["F"]
    await pilot.press("shift+f8")
    assert "(changed)" not in text_of(pilot)
    assert (await focus(pilot, "F")).value == "80"


async def test_enter_goes_on_to_the_next_field(pilot: Pilot[None]) -> None:
    await focus(pilot, "m")
    await pilot.press("enter")
    assert pilot.app.focused is pilot.app.screen.query_one("#row-k1").query_one(Input)


async def test_the_hint_tells_meaning_and_range_of_the_field_in_focus(pilot: Pilot[None]) -> None:
    await focus(pilot, "c2")
    assert "vertical damping" in text_of(pilot)
    assert "0 <= c2 <= 1e+09 N s/m" in text_of(pilot)


async def test_a_run_ends_in_plots_and_summary(pilot: Pilot[None]) -> None:
    await run_to_end(pilot)
    shown = text_of(pilot)
    assert "peak |y| 10.50 m · steady half range 4.401 m" in shown
    assert "74 separations · off the belt 71.01 s (71 %)" in shown
    assert "run 1 done in" in shown
    assert "tol 1e-12" in shown
    assert "y / m" in shown
    assert "P / N" in shown
    assert any(line.rstrip().endswith("100") for line in shown.splitlines())
    strip = next(line for line in shown.splitlines() if "off belt" in line)
    assert "▓▓▓" in strip
    assert any("⣿" in line for line in shown.splitlines())


async def test_results_are_marked_once_the_inputs_changed(pilot: Pilot[None]) -> None:
    await run_to_end(pilot)
    assert "inputs changed" not in text_of(pilot)
    await focus(pilot, "F")
    await pilot.press("up")
    await until_shown(pilot, "run 1 done, inputs changed since")


async def test_zooming_moves_both_plots_and_the_strip(pilot: Pilot[None]) -> None:
    await run_to_end(pilot)
    pilot.app.screen.query_one("#plot-P").focus()
    await pilot.press("e")
    await until_shown(pilot, "90 95 100")
    strip = next(line for line in text_of(pilot).splitlines() if "off belt" in line)
    assert "███" in strip
    assert "░" in strip
    await pilot.press("r")
    await until_shown(pilot, "0 50 100")
    await pilot.press("plus", "plus", "h")
    await until(pilot, lambda: "0 50 100" not in flat_text_of(pilot))
    for name in ("#plot-y", "#plot-P"):
        x = pilot.app.screen.query_one(name, ChartView).view.x
        assert x is not None
        assert 0.0 < x.low < x.high < 100.0


async def test_zooming_out_stops_at_the_horizon(pilot: Pilot[None]) -> None:
    await run_to_end(pilot)
    plot = pilot.app.screen.query_one("#plot-y", ChartView)
    plot.focus()
    await pilot.press("minus", "minus", "l", "l")
    await pilot.pause()
    assert plot.chart is not None
    x, _ = plot.view.axes(plot.chart)
    assert (x.low, x.high) == (0.0, 100.0)


async def test_a_long_run_is_stopped_and_the_next_one_works(pilot: Pilot[None]) -> None:
    session = app_of(pilot).session
    await type_into(pilot, "t_end", ENDLESS)
    await pilot.press("f5")
    await until_shown(pilot, "Stop")
    long = session.runs.active
    assert long is not None
    await until(pilot, lambda: long.fraction > 0.0)
    await until_shown(pilot, "left")
    assert "F5 Stop" in text_of(pilot)
    editor = await focus(pilot, "F")
    await pilot.press("up")
    assert editor.value == "81"
    await pilot.press("f5")
    assert long.state is RunState.STOPPED
    await until_told(pilot, "run 1 stopped at")
    assert "F5 Run" in text_of(pilot)
    await type_into(pilot, "t_end", "100")
    await run_to_end(pilot)
    assert "run 2 done" in text_of(pilot)
    assert long.result is None
    assert [run.state for run in session.runs] == [RunState.STOPPED, RunState.DONE]


async def test_the_button_runs_and_stops_by_mouse(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fivtui.runner.simulate", endless_simulate)
    runs = app_of(pilot).session.runs
    await pilot.click("#run-button")
    await until(pilot, lambda: runs.active is not None)
    await pilot.click("#run-button")
    await until(pilot, lambda: runs.active is None)
    assert runs.newest is not None
    assert runs.newest.state is RunState.STOPPED


async def test_quitting_does_not_wait_for_a_long_run() -> None:
    app = FivtuiApp()
    async with app.run_test(size=USUAL, notifications=True) as pilot:
        await type_into(pilot, "t_end", ENDLESS)
        await pilot.press("f5")
        await until(pilot, lambda: app.session.runs.active is not None)
    # The test would hang here if the thread were not told to end.
    assert app.session.runs.active is None


async def test_a_wrong_input_is_not_run_but_reported(pilot: Pilot[None]) -> None:
    await type_into(pilot, "tol", "1")
    await pilot.press("f5")
    await until_told(pilot, "tol = 1: allowed is 1e-13 <= tol <= 0.01")
    assert app_of(pilot).session.runs.newest is None


async def test_a_failed_run_is_reported_and_logged(pilot: Pilot[None]) -> None:
    await type_into(pilot, "k3", "0")
    await type_into(pilot, "F", "-5")
    await pilot.press("f5")
    await until_shown(pilot, "run 1 failed")
    await pilot.press("alt+9")
    await until_shown(pilot, "ERROR: run 1: no equilibrium")


async def test_an_unexpected_failure_is_reported_without_traceback(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(_run: object) -> None:
        raise ZeroDivisionError("by zero")

    monkeypatch.setattr("fivtui.tui.run_desk.execute", broken)
    await pilot.press("f5")
    await until_told(pilot, "unexpected ZeroDivisionError: by zero")
    assert "run 1 failed" in text_of(pilot)
    assert "Traceback" not in text_of(pilot)


async def test_the_tabs_are_filled_when_they_are_shown(pilot: Pilot[None]) -> None:
    await until_shown(pilot, "critical μ, linear 1.018")
    await run_to_end(pilot)
    for _ in range(len(TABS)):
        await pilot.press("f2")
    assert pilot.app.screen.query_one(TabBook).active == "transient"
    await pilot.press("alt+8")
    await until_shown(pilot, "range of y -2.685 to 10.50 m")
    await pilot.press("alt+9")
    await until_shown(pilot, "run 1 done; peak |y| 10.50 m")
    await pilot.press("shift+f2")
    await until_shown(pilot, "range of y -2.685 to 10.50 m")
    await pilot.press("alt+1")
    await type_into(pilot, "F", "100")
    await until_shown(pilot, "critical μ 0.597")


async def test_a_run_of_the_list_is_shown_again(pilot: Pilot[None]) -> None:
    await run_to_end(pilot)
    await type_into(pilot, "F", "40")
    await run_to_end(pilot)
    await until(pilot, lambda: "peak |y| 10.50 m" not in text_of(pilot))
    await pilot.press("f3")
    await until_shown(pilot, "1 done 10.50 4.401")
    await pilot.press("j", "enter")
    await until_shown(pilot, "peak |y| 10.50 m")
    await pilot.press("f3")
    await until(pilot, lambda: "half range m" not in text_of(pilot))


@pytest.mark.parametrize(
    ("size", "words"),
    [
        ((80, 24), ("P / N", "off belt", "kg", "74 separations")),
        ((200, 60), ("P / N", "off belt", "stiffness of the 45° coupling spring", "P 0 to 2071 N")),
        ((60, 20), ("peak |y|", "F5 Run", "k_1")),
        ((40, 12), ("UNSTABLE", "F5 Run", "y / m")),
    ],
)
async def test_every_size_shows_form_verdict_and_result(
    size: tuple[int, int], words: tuple[str, ...]
) -> None:
    async with FivtuiApp().run_test(size=size, notifications=True) as pilot:
        await pilot.pause()
        await pilot.press("f5")
        runs = app_of(pilot).session.runs
        await until(pilot, lambda: runs.newest is not None and runs.active is None)
        for word in ("UNSTABLE", *words):
            await until_shown(pilot, word)


async def test_resizing_draws_the_plots_to_their_new_edges(pilot: Pilot[None]) -> None:
    await run_to_end(pilot)
    for size in ((160, 50), (60, 20), (100, 30)):
        await pilot.resize_terminal(*size)
        await until(pilot, lambda: frame_reaches_the_edge(text_of(pilot)))


def frame_reaches_the_edge(shown: str) -> bool:
    lines = shown.splitlines()
    axes = [line.rstrip() for line in lines if "t / s " in line]
    return bool(axes) and all(len(line) == len(lines[0]) for line in axes)


async def test_essential_keys_come_first_also_when_a_plot_has_its_own(pilot: Pilot[None]) -> None:
    await run_to_end(pilot)
    pilot.app.screen.query_one("#plot-y").focus()
    await until(pilot, lambda: "Zoom" in text_of(pilot).splitlines()[-1])
    footer = text_of(pilot).splitlines()[-1]
    assert footer.startswith("F5 Run F1 Help")


async def test_a_theme_is_followed_by_the_plots(pilot: Pilot[None]) -> None:
    await run_to_end(pilot)
    plot = pilot.app.screen.query_one("#plot-y", ChartView)

    def background() -> object:
        return next(iter(plot.render_line(2))).style

    before = background()
    pilot.app.theme = "gruvbox"
    await until(pilot, lambda: background() != before)


async def test_without_colour_all_is_said_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    app = FivtuiApp()
    assert app.no_color
    async with app.run_test(size=USUAL, notifications=True) as pilot:
        await run_to_end(pilot)
        assert "UNSTABLE" in text_of(pilot)
        await type_into(pilot, "mu", "x")
        assert "NO VERDICT: invalid input" in text_of(pilot)
