"""The tabs of sweeps and maps: their results, and one run of the app for each tab."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from textual.pilot import Pilot
from textual.widgets import Input

from fivtui.charts import NearestPoint
from fivtui.charts.axis import Axis
from fivtui.charts.chart import Cursors, View
from fivtui.charts.readout import points_at
from fivtui.maps import map_chart, stability_map
from fivtui.model.errors import Cancelled, InputError
from fivtui.model.parameters import Parameters
from fivtui.scene.presets import PRESETS
from fivtui.simulation import simulate
from fivtui.sweeps import Sweep, grid_chart, sweep_chart
from fivtui.sweeps.rows import compute_rows
from fivtui.tui.chart.picture import draw
from fivtui.tui.session import Session, scene_texts
from fivtui.tui.tabs import SceneLoaded
from fivtui.tui.tabs.studies.map import MapPane, map_ranges, mapped_values
from fivtui.tui.tabs.studies.sweep import SweepPane, partial_sweeps, point_scene
from tests.support.laboratory import (
    app_of,
    chart_of,
    endless_simulate,
    lab_of,
    show_tab,
    until,
    until_notice,
    until_shown,
)

BASE = PRESETS["base"]


def test_a_sweep_agrees_with_single_runs() -> None:
    study = SweepPane.parse(BASE, "F=100:20:21")
    assert study.members == 42
    fractions: list[float] = []

    def store_fraction(fraction: float) -> bool:
        fractions.append(fraction)
        return True

    sweeps = list(partial_sweeps(study, store_fraction))
    # The rows arrive in parts, here of 16, so that the chart fills while the sweep runs.
    assert [sweep.table.members for sweep in sweeps] == [16, 32, 42]
    assert fractions == sorted(fractions)
    result = sweeps[-1]
    chart = sweep_chart(result, 80.0)
    peaks, half_ranges, *_ = chart.traces
    assert np.all(np.diff(peaks.x) > 0.0)
    run = simulate(Parameters(F=float(peaks.x[5])), t_end=100.0)
    assert peaks.y[5] == pytest.approx(run.peak.y_abs, rel=1e-9)
    assert half_ranges.y[5] == pytest.approx(run.steady.y_half_range)
    names = [trace.name for trace in chart.traces]
    assert names == [
        "peak, considered",
        "±y 2nd half, considered",
        "peak, ignored",
        "±y 2nd half, ignored",
    ]
    picture = draw(chart, View(), 80, 20).text()
    assert all(mark in picture for mark in "●◆◇")
    view = View(cursors=Cursors((60.2, 0.0)))
    points = points_at(chart, view, view.cursors.first)
    # The curve decides about separation, not the edited scene.
    peak_considered, *_, half_range_ignored = points
    scene = point_scene(study, peak_considered, edited_separation=False)
    assert (scene.parameters, scene.separation) == (Parameters(F=60.0), True)
    texts = scene_texts(point_scene(study, half_range_ignored, edited_separation=True))
    assert (texts["F"], texts["separation"], texts["t_end"]) == ("60", "ignored", "100")


def test_a_sweep_over_two_parameters_shades_the_computed_points() -> None:
    study = SweepPane.parse(replace(BASE, t_end=10.0), "F=20:80:4 mu=0.2,0.5,0.8")
    *_, result = partial_sweeps(study, lambda _: True)
    for case in (True, False):
        chart = grid_chart(result, case, (80.0, 0.5))
        backdrop = chart.backdrop
        assert backdrop is not None
        assert (chart.x_label, chart.y_label) == ("F (N)", "μ")
        run = simulate(Parameters(F=40.0, mu=0.8), t_end=10.0, separation=case)
        assert backdrop.values[1, 2] == pytest.approx(run.peak.y_abs, rel=1e-9)
        assert "◆" in draw(chart, View(), 80, 20).text()
        heading = draw(chart, View(cursors=Cursors((41.0, 0.79))), 80, 20).text()
        assert heading.startswith("μ F 40 N  μ 0.8  peak of |y| ")
        (point,) = points_at(chart, View(), (41.0, 0.79))
        scene = point_scene(study, point, case)
        assert (scene.parameters, scene.separation) == (Parameters(F=40.0, mu=0.8), case)
    # Rows alternate between the cases: four of seven consider separation.
    first_rows = compute_rows(study, 0, 7)
    shades = grid_chart(Sweep(study, first_rows), True, None).backdrop
    assert shades is not None
    assert np.isnan(shades.values).sum() == shades.values.size - 4
    with pytest.raises(InputError, match="use one name, or two"):
        SweepPane.parse(BASE, "F=1,2 mu=1,2 k1=1,2")


def test_failed_members_of_a_sweep_leave_a_gap_and_a_reason() -> None:
    study = SweepPane.parse(replace(BASE.with_values({"k_nl": 0.0}), t_end=1000.0), "mu=0.5,60,100")
    *_, result = partial_sweeps(study, lambda _: True)
    assert result.table.failed > 0
    assert "failed: " in SweepPane(Session()).details_text(result)
    assert np.isnan(sweep_chart(result).traces[2].y[-1])


def test_a_sweep_may_vary_the_start() -> None:
    study = SweepPane.parse(BASE, "y0=-1:0:3")
    scene = point_scene(study, NearestPoint(trace=0, x=-0.5, y=1.0), edited_separation=False)
    assert scene.start[2] == -0.5


def test_a_sweep_can_be_cancelled() -> None:
    study = SweepPane.parse(BASE, "F=20:100:200")
    with pytest.raises(Cancelled):
        list(partial_sweeps(study, lambda fraction: fraction < 0.1))


@pytest.mark.parametrize(
    ("text", "message"),
    [("F=1:2", "must be NAME"), ("G=1:2:3", "unknown parameter")],
)
def test_invalid_ranges_of_a_sweep_are_refused(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        SweepPane.parse(BASE, text)


def test_a_map_is_drawn_with_its_boundary_and_point() -> None:
    first, second = map_ranges("μ=0:1.5:61 F=5:120:47", "growth-rate")
    axis_values = {first.name: first.values(), second.name: second.values()}
    for value, label in (("growth-rate", "growth rate"), ("unstable-modes", "unstable modes")):
        result = stability_map(Parameters(), axis_values, value)
        chart = map_chart(result, Parameters())
        boundary = chart.traces[0]
        nearest = np.abs(boundary.y - 80.0).argmin()
        # The critical friction coefficient at a preload of 80 N.
        assert boundary.x[nearest] == pytest.approx(0.4394, abs=0.02)
        assert "◆" in draw(chart, View(), 80, 24).text()
        heading = draw(chart, View(cursors=Cursors((0.7, 80.0))), 80, 24).text()
        assert heading.startswith(f"F (N) μ 0.7  F 80 N  {label}")
    # Over preload and nonlinear stiffness the friction coefficient has one value.
    plane = {"F": np.linspace(5.0, 120.0, 24), "k_nl": np.linspace(20.0, 500.0, 13)}
    chart = map_chart(stability_map(Parameters(), plane, "critical-mu"))
    assert chart.traces[0].name == "boundaries at μ = 0.7"
    swapped_axes = {"F": second.values()[::-1], "mu": first.values()}
    swapped_chart = map_chart(stability_map(Parameters(), swapped_axes), None)
    assert swapped_chart.backdrop is not None
    assert np.all(np.diff(swapped_chart.backdrop.x) > 0.0)
    view = View(cursors=Cursors((80.0, 0.7)))
    (point,) = points_at(swapped_chart, view, view.cursors.first)
    result = stability_map(Parameters(), swapped_axes)
    texts, description = MapPane.read_point(result, point)
    assert (texts["F"], texts["mu"], texts["k1"]) == ("80", "0.7", "100")
    assert description == "F = 80, μ = 0.7"


def test_a_zoomed_map_has_as_many_points_as_the_full_map() -> None:
    mass, friction = map_ranges("m=1:9:5 mu=0:2:11", "growth-rate")
    assert mapped_values(mass, None).tolist() == [1.0, 3.0, 5.0, 7.0, 9.0]
    assert mapped_values(friction, Axis(0.5, 1.5)).tolist() == pytest.approx(
        np.linspace(0.5, 1.5, 11)
    )
    values_from_bound = mapped_values(mass, Axis(-3.0, 1.0))
    assert 0.0 < values_from_bound[0] < 1e-6
    assert values_from_bound[-1] == 1.0
    assert mapped_values(mass, Axis(-3.0, -1.0)).tolist() == mapped_values(mass, None).tolist()


@pytest.mark.parametrize("text", ["", "mu=0:1:5", "mu=0:1:5 mu=0:1:5", "mu=0:1:5000 F=1:2:5000"])
def test_invalid_ranges_of_a_map_are_refused(text: str) -> None:
    with pytest.raises(InputError):
        map_ranges(text, "growth-rate")


def test_a_map_of_critical_mu_over_mu_is_refused() -> None:
    with pytest.raises(InputError, match="must be over two other parameters"):
        map_ranges("F=1:2:3 μ=0:1:3", "critical-mu")


def test_a_sweep_that_is_too_large_for_the_memory_is_refused() -> None:
    with pytest.raises(InputError, match="20000000000 members: must be at most 1000000"):
        SweepPane.parse(BASE, "F=1:2:100000 mu=0:1:100000")


async def test_a_sweep_can_be_started_and_stopped_and_its_points_opened(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    await pilot.press("alt+6")
    await until_shown(pilot, "computes 112 runs")
    range_input = pilot.app.screen.query_one("#sweep-input", Input)
    range_input.focus()
    range_input.value = "F=60:100:1"
    await pilot.press("enter")
    await until_shown(pilot, "COUNT = 1: must be")
    # The error stays until the text is valid; then the hint appears again.
    pilot.app.screen.query_one("#sweep-chart").focus()
    range_input.focus()
    range_input.value = "F=60:100:100000"
    await until_shown(pilot, "NAME=START:STOP:COUNT or")
    range_input.value = "F=60:100:21"
    await pilot.press("enter")
    await until_shown(pilot, "42 transients")
    await until_shown(pilot, "peak, considered")
    chart_view = chart_of(pilot, "sweep-chart")
    chart_view.focus()
    await pilot.press("c", "shift+right", "enter")
    runs = app_of(pilot).session.runs
    await until(pilot, lambda: runs.displayed is not None)
    assert runs.displayed is not None
    assert runs.displayed.scene.parameters.F > 80.0
    assert app_of(pilot).session.texts["F"] != "80"
    monkeypatch.setattr(
        "fivtui.tui.tabs.studies.sweep.compute_rows",
        lambda _s, _a, _b, progress: endless_simulate(progress=progress),
    )
    await pilot.press("alt+6", "f10")
    await until_shown(pilot, "Stop")
    await pilot.press("f10")
    await until_shown(pilot, "stopped at")


async def test_a_map_follows_the_form_and_its_points_can_be_opened(pilot: Pilot[None]) -> None:
    await pilot.press("alt+3")
    # By default 121 values of μ times 93 of F.
    await until_shown(pilot, "11253 points")
    await until_shown(pilot, "░")
    session = app_of(pilot).session
    chart_view = chart_of(pilot, "map-chart")
    old_chart = chart_view.chart
    session.set_text("c1", "0.8")
    # Show the previous tab and this one again, which then follows the edit.
    await pilot.press("shift+f2", "f2")
    await until(pilot, lambda: chart_view.chart is not old_chart and chart_view.chart is not None)
    chart_view.focus()
    old_chart = chart_view.chart
    await pilot.press("plus", "plus")
    await until(pilot, lambda: chart_view.chart is not old_chart and chart_view.chart is not None)
    await until(pilot, lambda: chart_view.chart.backdrop.x[0] > 0.1)  # type: ignore[union-attr]
    await pilot.press("r")
    await until(pilot, lambda: chart_view.chart.backdrop.x[0] == 0.0)  # type: ignore[union-attr]
    await pilot.press("v")
    # A map of μ_c, which does not depend on μ, has ranges of F and k_nl: 93 times 61 values.
    await until_shown(pilot, "5673 points")
    assert chart_view.chart is not None
    assert chart_view.chart.y_label.startswith("k_nl")
    await pilot.press("v")
    await until_shown(pilot, "F (N) unstable modes")
    chart_view.focus()
    await pilot.press("c", "left")
    await until_shown(pilot, "μ 0.")
    await pilot.press("enter")
    await until(pilot, lambda: session.runs.displayed is not None)
    assert session.texts["mu"] != "0.7"
    assert session.texts["F"] != "80"


async def test_a_map_of_another_scene_is_marked_and_its_point_keeps_tables_over_time(
    pilot: Pilot[None],
) -> None:
    session, lab = app_of(pilot).session, lab_of(pilot)
    session.settings["map"] = {"over": "mu=0.1:0.8:8 F=5:120:8"}
    await show_tab(pilot, "alt+3")
    await until_shown(pilot, "64 points")
    pane: Any = lab.tab_book.pane
    # A stopped map stays that of the scene before.
    pane.start_from_inputs = lambda: None
    lab.post_message(SceneLoaded(PRESETS["brake-stop"], "brake-stop", "loaded"))
    await until_shown(pilot, "another scene")
    assert pane.has_class("-outdated")
    del pane.start_from_inputs
    await pilot.press("f10")
    await until_shown(pilot, "at t = 0")
    await until(pilot, lambda: not pane.has_class("-outdated"))
    assert "--set c2=2" in pane.command_line()
    state = session.edit_state
    chart_of(pilot, "map-chart").focus()
    await pilot.press("c", "left", "enter")
    await until_notice(pilot, "F: follows a table over time; must not be changed")
    assert session.edit_state == state
    assert not list(session.runs)
