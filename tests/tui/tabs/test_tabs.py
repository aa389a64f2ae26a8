"""Content and actions of the tabs: one start of the app for each tab."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from textual.pilot import Pilot
from textual.widgets import Input

from fivtui.equilibrium.scan import mode_scan, mu_scan_end
from fivtui.model import System
from fivtui.paper.claims.check import CLAIMS
from fivtui.paper.claims.claim import check
from fivtui.paper.results import PaperResults
from fivtui.scene.presets import PRESETS
from fivtui.tradeoffs import measure as tradeoff, tradeoff_chart
from fivtui.tradeoffs.measure import Tradeoff, measure_tradeoff
from fivtui.tui.session import runs
from fivtui.tui.tabs import TABS
from fivtui.tui.tabs.paper import claim_row, claim_text
from fivtui.tui.tabs.studies.tradeoff import current_setting, setting_text
from fivtui.tui.tabs.tab_book import TabBook
from fivtui.tui.tabs.tables import ListTable
from fivtui.tui.tabs.views_pane import ViewsPane
from tests.support.kernels import INTERPRETED
from tests.support.laboratory import (
    app_of,
    chart_of,
    click_view,
    endless_simulate,
    run_to_end,
    show_tab,
    type_into,
    until,
    until_hidden,
    until_screen,
    until_shown,
)

BASE = PRESETS["base"]
SIZE = (110, 30)


async def test_stability_is_shown_live_over_mu_and_in_the_plane(pilot: Pilot[None]) -> None:
    await pilot.press("alt+2")
    await until_shown(pilot, "Re λ (1/s)")
    await until_shown(pilot, "μ_c 0.4394")
    await until_shown(pilot, "μ 0.7")
    await type_into(pilot, "k_nl", "50")
    await until_shown(pilot, "μ_c 0.2975")
    chart_view = chart_of(pilot, "growth")
    chart_view.focus()
    await pilot.press("v")
    await until_shown(pilot, "Im λ (rad/s)")
    await until_screen(pilot, lambda text: text.count("◆") >= 4)
    await pilot.press("v")
    await until_shown(pilot, "damping ratio")
    await until_shown(pilot, "frequency distance")
    await click_view(pilot, "over-mu")
    chart_view.focus()
    await pilot.press("c", "shift+left", "enter")
    await until(pilot, lambda: app_of(pilot).session.runs.displayed is not None)
    texts = app_of(pilot).session.texts
    assert texts["mu"] != "0.7"
    displayed_run = app_of(pilot).session.runs.displayed
    assert displayed_run is not None
    assert displayed_run.scene.parameters.mu == float(texts["mu"])


async def test_cycling_through_views_never_focuses_a_text_input(
    pilot: Pilot[None],
) -> None:
    tabs_with_views = []
    for tab in TABS:
        await show_tab(pilot, tab.key)
        pane = pilot.app.screen.query_one(TabBook).pane
        if not isinstance(pane, ViewsPane) or len(pane.VIEWS) < 2:
            continue
        tabs_with_views.append(tab.id)
        pane.focus_content()
        visited_views = [pane.view]
        for _ in pane.VIEWS:
            await pilot.press("v")
            assert not isinstance(pilot.app.focused, Input)
            visited_views.append(pane.view)
        assert visited_views[-1] == visited_views[0]
        assert set(visited_views) == set(pane.VIEWS)
    assert {"stability", "transient"} <= set(tabs_with_views)


async def test_the_transient_has_views_and_every_plot_its_keys(
    pilot: Pilot[None],
) -> None:
    await run_to_end(pilot)
    chart_view = chart_of(pilot, "plot-y")
    chart_view.focus()
    await pilot.press("c", "right")
    await until_shown(pilot, "t 51")
    await pilot.press("escape", "y")
    assert chart_view.view.log_y
    await pilot.press("y", "i", *"10:2x", "enter")
    await until_shown(pilot, "not a number")
    await pilot.press("backspace", "0", "enter")
    await until(pilot, lambda: chart_view.view.x is not None)
    x = chart_of(pilot, "plot-P").view.x
    assert x is not None
    assert (x.low, x.high) == (10.0, 20.0)
    await pilot.press("v")
    await until_shown(pilot, "ẏ (m/s) t 10 to 20 s")
    await pilot.press("v")
    await until_shown(pilot, "f₁")
    await until_shown(pilot, "period 1.")
    await click_view(pilot, "time")
    assert chart_view.view.x is not None
    await pilot.hover("#plot-y", offset=(20, 3))
    await until_shown(pilot, "run 1 ")
    await pilot.mouse_down("#plot-y", offset=(20, 3))
    await pilot.hover("#plot-y", offset=(30, 3))
    await pilot.mouse_up("#plot-y", offset=(30, 3))
    await until(pilot, lambda: chart_view.view.x is not None and chart_view.view.x.low < 10.0)
    # The rightmost control in the heading of the chart fits the axes to the data.
    await pilot.click("#plot-y", offset=(chart_view.size.width - 1, 0))
    await until(pilot, lambda: chart_view.view.x is None)


@INTERPRETED
async def test_a_run_grows_in_the_plot_until_it_is_stopped(
    pilot: Pilot[None],
) -> None:
    await type_into(pilot, "t_end", "1e5")
    await pilot.press("f5")
    active = app_of(pilot).session.runs.active
    assert active is not None
    chart_view = chart_of(pilot, "plot-y")
    await until(
        pilot, lambda: chart_view.chart is not None and chart_view.chart.traces[0].x.size > 100
    )
    first_size = chart_view.chart.traces[0].x.size  # type: ignore[union-attr]
    await until(pilot, lambda: chart_view.chart.traces[0].x.size > first_size)  # type: ignore[union-attr]
    await until_shown(pilot, "off belt")
    await pilot.press("f5")
    await until(pilot, lambda: active.state is runs.RunState.STOPPED)


@pytest.fixture(scope="module")
def measured() -> Tradeoff:
    with pytest.MonkeyPatch.context() as patch:
        # Measure errors and times of the methods for 0.3 s of CPU time in place of 7 s.
        patch.setattr(tradeoff, "QUICK_S", 0.3)
        return measure_tradeoff(dataclasses.replace(BASE, t_end=10.0))


async def test_the_trade_off_is_measured_and_shown(
    pilot: Pilot[None], measured: Tradeoff, monkeypatch: pytest.MonkeyPatch
) -> None:
    measured_scenes = []

    def measure(scene: Any, progress: Any) -> Tradeoff:
        measured_scenes.append(scene)
        assert progress(0.5)
        return measured

    def measure_endlessly(scene: Any, progress: Any) -> None:
        endless_simulate(progress=progress)

    await pilot.press("alt+8")
    await until_shown(pilot, "F10 measures all methods")
    # A running job stops at once.
    monkeypatch.setattr("fivtui.tui.tabs.studies.tradeoff.measure_tradeoff", measure_endlessly)
    await pilot.press("f10")
    await until_shown(pilot, "Stop")
    await pilot.press("f10")
    await until_shown(pilot, "stopped at 0 %")
    monkeypatch.setattr("fivtui.tui.tabs.studies.tradeoff.measure_tradeoff", measure)
    await pilot.press("f10")
    await until_shown(pilot, "error of final state")
    assert measured_scenes == [app_of(pilot).session.scene()]
    await until_shown(pilot, "of t_end=10 (now 100): F10 computes again")
    await until_shown(pilot, "now taylor (compiled) tol=1e-12")
    await type_into(pilot, "t_end", "10")
    await until_hidden(pilot, "computes again")
    await click_view(pilot, "events")
    await until_shown(pilot, "error of events (s)")
    await click_view(pilot, "settings")
    await until_shown(pilot, "method setting CPU ms")
    table = pilot.app.screen.query_one("#settings", ListTable)
    assert sum("now" in text for text in table.row_texts()) == 1


async def test_figures_of_the_paper_are_computed_and_opened(pilot: Pilot[None]) -> None:
    await pilot.press("alt+0")
    await until_shown(pilot, "figure lines what it shows")
    pilot.app.screen.query_one("#figures").focus()
    await pilot.press("j", "j", "enter")
    await until_shown(pilot, "figure 3 computed")
    await until_shown(pilot, "Im λ (rad/s)")
    await pilot.press("n")
    await until_shown(pilot, "Re λ (1/s)")
    await until_shown(pilot, "k_nl 500")
    await pilot.press("o")
    await until_shown(pilot, "fig-3")
    assert app_of(pilot).session.scene().parameters.F == 20.0
    await click_view(pilot, "claims")
    await until_shown(pilot, "Equal damping is proportional to mass")


def test_the_modes_over_mu_agree_with_the_stability_of_each_point() -> None:
    from fivtui.equilibrium.eigenvalues import stability

    p = BASE.parameters
    scan = mode_scan(System(p), mu_scan_end(stability(p)))
    assert scan.mu[0] == 0.0
    assert scan.mu[-1] == 1.5
    for index in (0, 60, 240):
        expected = stability(p.with_values({"mu": float(scan.mu[index])}))
        assert np.sort(scan.eigenvalues[index].real) == pytest.approx(
            np.sort(expected.eigenvalues.real), abs=1e-9
        )
    is_unstable = scan.mu > 0.45
    assert np.all(scan.eigenvalues[is_unstable, 0].real > scan.eigenvalues[is_unstable, 1].real)


def test_the_current_setting_and_the_best_ones_are_marked(measured: Tradeoff) -> None:
    current = current_setting(measured, BASE)
    assert current is not None
    assert current.setting.text == "tol=1e-12"
    text = setting_text(measured, BASE, "final")
    assert text.startswith("now taylor (compiled) tol=1e-12, error ")
    chart = tradeoff_chart(measured, "final", current)
    assert chart.traces[-1].name == "now"
    scene_with_accuracy = dataclasses.replace(BASE, accuracy=(("peak", 1e-3),))
    assert current_setting(measured, scene_with_accuracy) is None
    assert setting_text(measured, scene_with_accuracy, "final").startswith("peak to 0.001: ")
    rk4 = dataclasses.replace(BASE, method="rk4")
    assert "enter a step" in setting_text(measured, rk4, "final")


def test_claims_have_rows_and_texts() -> None:
    results = PaperResults(workers=1)
    claim = CLAIMS[0]
    checked = check(claim, results)
    assert claim_row(claim, checked)[0] == "holds"
    assert claim_row(claim, None)[0] == "?"
    assert "computed: " in claim_text(claim, checked)
    assert "computed" not in claim_text(claim, None)
