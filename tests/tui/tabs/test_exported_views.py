"""Every view of every tab exported as SVG: texts and axis limits agree with the screen."""

import dataclasses
import re
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any
from xml.sax.saxutils import unescape

import numpy as np
import pytest
from textual.pilot import Pilot
from textual.widgets import Input

from fivtui.charts import charts_figure
from fivtui.charts.chart import Chart, View
from fivtui.identification import identify
from fivtui.orbits import branch
from fivtui.reliability import uncertainty
from fivtui.scene.presets import PRESETS
from fivtui.simulation import simulate
from fivtui.tradeoffs import measure
from fivtui.tui.app import FivtuiApp
from fivtui.tui.chart.widget.chart_view import ChartView
from fivtui.tui.session.session import DisplayedStudy
from fivtui.tui.tabs.export import FIGURE
from fivtui.tui.tabs.studies.sweep import SweepPane
from fivtui.tui.tabs.tab_book import TABS
from fivtui.tui.tabs.views_pane import ViewsPane
from tests.support.laboratory import app_of, lab_of, show_tab, until

BASE = PRESETS["base"]
# Views that are tables: they have no charts with which a figure could agree.
TABLE_VIEWS = {"facts", "settings", "indices", "figures", "claims", "fitted-values"}


def svg_texts(path: Path) -> list[str]:
    """Texts of an SVG, which draws them as outlines and names each line in a comment."""
    comments = re.findall(r"<!-- (.*?) -->", path.read_text(), re.DOTALL)
    return [" ".join(unescape(text).split()) for text in comments]


def screen_texts(chart: Chart, view: View) -> set[str]:
    """Texts of a chart on the screen, except the numbers of its axes."""
    x, y = view.axes(chart)
    labels = {chart.y_label, chart.note}
    # A guide is a labelled line at a value of x (vertical) or y.
    for guide in chart.guides:
        position = float((x if guide.vertical else y).positions([guide.value])[0])
        labels |= {guide.label} if 0.0 <= position <= 1.0 else set()
    labels |= {chart.x_label} if chart.x_axis else set()
    # Strips are rows of marked intervals below the plot. Legends explain those that have any.
    labels |= {strip.meaning for strip in chart.strips if strip.intervals}
    if len(chart.traces) > 1:
        labels |= {trace.name for _, trace in view.visible_traces(chart)}
    # A backdrop is a map: the plane behind the traces, with a shade for each range of values.
    if chart.backdrop is not None:
        labels |= {chart.backdrop.label, *(shade.text for shade in chart.backdrop.shades)}
    return {" ".join(text.split()) for text in labels} - {""}


@pytest.fixture
def disable_safe_friction_search() -> None:
    """Replace the fixture of this name in conftest, which disables the search: maps need it."""


@pytest.fixture
async def pilot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Pilot[None]]:
    monkeypatch.chdir(tmp_path)
    async with FivtuiApp().run_test(size=(140, 45)) as running_pilot:
        await running_pilot.pause()
        yield running_pilot


def pane_of(pilot: Pilot[None]) -> ViewsPane:
    lab = lab_of(pilot)
    assert isinstance(lab.tab_book.pane, ViewsPane)
    return lab.tab_book.pane


async def add_runs(pilot: Pilot[None]) -> None:
    session = app_of(pilot).session
    for index, F in enumerate((80.0, 100.0)):
        p = BASE.parameters.with_values({"F": F})
        scene = dataclasses.replace(BASE, parameters=p, separation=index == 0, t_end=20.0)
        samples = np.linspace(0.0, 20.0, 2001)
        result = simulate(p, t_end=20.0, separation=scene.separation, samples=samples)
        session.runs.add_loaded(scene, result, "")
    first, second = session.runs
    # Both runs are plotted: numbers of the displayed run are compared with those of the baseline.
    session.runs.displayed, session.runs.baseline = first, second
    # Measured data that differ from the first run by 2%, and a band around them: a tolerance of 10%
    # of half peak-to-peak.
    t = np.linspace(5.0, 15.0, 400)
    trajectory = first.result.trajectory  # type: ignore[union-attr]
    signal = np.interp(t, trajectory.t, trajectory.y)  # type: ignore[union-attr]
    measured_data = np.column_stack([t, 1.02 * signal])
    np.savetxt("measured.csv", measured_data, delimiter=",", header="t,y", comments="")
    session.settings["transient"] = {
        "measured": "measured.csv --band 10%",
    }


def add_studies(session: Any) -> None:
    curve = branch(BASE.parameters, "mu", low=0.25, high=0.45)
    session.studies["branch"] = DisplayedStudy(curve, "base")
    uncertainty_result = uncertainty(
        vary={"mu": "uniform:0.2:0.8", "F": "normal:80:8"}, samples=64, indices=False
    )
    session.studies["uncertainty"] = DisplayedStudy(uncertainty_result, "base")
    fit = identify(measured="measured.csv", fit=["mu"])
    session.studies["identification"] = DisplayedStudy(fit, "base")
    session.settings["sweep"] = {"vary": "F=60,80,100"}
    session.settings["map"] = {"over": "F=60:120:4 k_nl=80:120:3"}
    session.settings["paper"] = {"figure": "2a", "view": "figure"}


async def check_export(pilot: Pilot[None], name: str) -> set[str]:
    """Write the visible view and compare it with its charts; return the texts of the file."""
    pane = pane_of(pilot)
    charts = [
        (widget.chart, widget.view)
        for widget in pane.query_one(f"#{pane.view}").query(ChartView)
        if widget.display and widget.chart is not None
    ]
    assert charts, name
    figures = []
    draw_figure = charts_figure

    def draw_and_store(*arguments: Any) -> Any:
        figures.append(draw_figure(*arguments))
        return figures[-1]

    path = Path(f"{name}.svg")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fivtui.charts.charts_figure", draw_and_store)
        pane.export(FIGURE).write(path)
    file_texts = svg_texts(path)
    # A label of up to three lines has as many consecutive texts in the file.
    file_labels = {
        " ".join(file_texts[index : index + line_count])
        for line_count in (1, 2, 3)
        for index in range(len(file_texts))
    }
    for chart, view in charts:
        missing_texts = screen_texts(chart, view) - file_labels
        assert not missing_texts, (name, missing_texts, file_texts)
    panels = [axes for axes in figures[0].axes if axes.get_label() != "<colorbar>"]
    for axes, (chart, view) in zip(panels, charts, strict=True):
        for limits, scale, axis in zip(
            (axes.get_xlim(), axes.get_ylim()),
            (axes.get_xscale(), axes.get_yscale()),
            view.axes(chart),
            strict=True,
        ):
            assert limits == pytest.approx((axis.low, axis.high)), name
            assert scale == ("log" if axis.log else "linear"), name
    return set(file_texts)


# Only `pytest -m whole` runs this long test.
@pytest.mark.whole
async def test_every_view_is_exported_as_displayed(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    # CPU time of the measurement in the trade-off tab, s.
    monkeypatch.setattr(measure, "QUICK_S", 0.02)
    await add_runs(pilot)
    add_studies(app_of(pilot).session)
    # Texts by tab and view. The chart of a view depends on the quantity of a map and on the number
    # of varied parameters of a sweep: these charts have keys of their own.
    texts_by_view: dict[tuple[str, str], set[str]] = {}
    for tab in TABS:
        if tab.id == "log":
            continue
        await show_tab(pilot, tab.key)
        pane = pane_of(pilot)
        if tab.id in ("sweep", "trade-off"):
            await pilot.press("f10")
        if tab.id in ("sweep", "trade-off", "map"):
            # Maps are computed without a key.
            await until(pilot, lambda pane=pane: pane.visible_charts() is not None)  # type: ignore[misc]
            await until(pilot, lambda pane=pane: pane.job is None)  # type: ignore[misc]
        for view in pane.VIEWS:
            if view in TABLE_VIEWS:
                continue
            pane.show_view(view)
            if tab.id == "safe-mu":
                other = "mu=0.3:0.9:5" if view == "coexistence" else "k_nl=90:110:2"
                pane.query_one("#safe-mu-input", Input).value = f"F=100:120:3 {other}"
                await pilot.press("f10")
            await until(pilot, lambda pane=pane: pane.visible_charts() is not None)  # type: ignore[misc]
            texts_by_view[tab.id, view] = await check_export(pilot, f"{tab.id}-{view}")
            await zoom_charts(pilot, pane)
            await check_export(pilot, f"{tab.id}-{view}-zoomed")
        if isinstance(pane, SweepPane):
            pane.query_one("#sweep-input", Input).value = "F=60,100 mu=0.3,0.7"
            await pilot.press("f10")
            await until(pilot, lambda pane=pane: pane.job is None)  # type: ignore[misc]
            texts_by_view["sweep", "plane"] = await check_export(pilot, "plane")
    # The map of coexistence has named regions.
    assert "squeals" in texts_by_view["safe-mu", "coexistence"]
    assert texts_by_view["transient", "time"] >= {
        "F 80 N, separation considered",
        "F 100 N, separation ignored",
    }
    assert texts_by_view["map", "growth-rate"] >= {"growth rate (1/s)", "now", "boundary"}
    # Parameters that all curves share are in the title.
    assert any("$m$ = 5 kg" in text for text in texts_by_view["transient", "time"])


async def zoom_charts(pilot: Pilot[None], pane: ViewsPane) -> None:
    """Zoom, set a logarithmic axis, and hide a trace in the charts of a view."""
    for widget in pane.query_one(f"#{pane.view}").query(ChartView):
        # Maps, and charts whose axes have the same scale (`to_scale`), stay as they are.
        if widget.chart is None or widget.chart.backdrop is not None or widget.chart.to_scale:
            continue
        widget.action_zoom(-1)
        widget.action_trace(1)
        widget.action_log("y")
    await pilot.pause()
