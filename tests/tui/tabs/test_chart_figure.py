"""Exported figures show the visible content: their axes agree with the charts."""

from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Annotation
from textual.pilot import Pilot

from fivtui import safety_map
from fivtui.charts import Heading, figure_colour
from fivtui.charts.axis import Axis
from fivtui.charts.chart import Chart, Cursors, Guide, Trace, View, VisibleCharts
from fivtui.charts.displayed_charts import charts_figure, save_charts
from fivtui.io.tables import read_columns, read_header
from fivtui.maps import map_chart, stability_map
from fivtui.maps.result import REGIONS
from fivtui.model.errors import InputError
from fivtui.model.parameters import Parameters
from fivtui.simulation import simulate
from fivtui.transient.charts import phase_chart, plotted_run, time_chart
from fivtui.transient.result import Transient
from fivtui.tui.app import FivtuiApp
from fivtui.tui.chart.widget.chart_view import ChartView
from fivtui.tui.tabs.export import DATA, FIGURE
from fivtui.tui.tabs.transient import TransientPane
from fivtui.tui.tabs.views_pane import ViewsPane
from tests.support.laboratory import app_of, lab_of, show_tab, until

T = np.linspace(0.0, 10.0, 101)


def named_lines(axes: Axes) -> list[Line2D]:
    return [line for line in axes.get_lines() if not str(line.get_label()).startswith("_")]


def panels_of(figure: Figure) -> list[Axes]:
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]


def check_panel(axes: Axes, chart: Chart, view: View) -> None:
    x, y = view.axes(chart)
    assert axes.get_xlim() == pytest.approx((x.low, x.high))
    assert axes.get_ylim() == pytest.approx((y.low, y.high))
    assert axes.get_xscale() == ("log" if x.log else "linear")
    assert axes.get_yscale() == ("log" if y.log else "linear")
    assert " ".join(axes.get_ylabel().split()) == chart.y_label
    assert axes.get_xlabel() == (chart.x_label if chart.x_axis else "")
    lines = named_lines(axes)
    named_traces = [trace for _, trace in view.visible_traces(chart) if trace.name]
    if named_traces:
        assert len(lines) == len(named_traces)
    for line, trace in zip(lines, named_traces, strict=False):
        if trace.colour:
            assert to_hex(line.get_color()) == figure_colour(trace.colour)
        line_x = np.asarray(line.get_xdata())
        inside = (trace.x >= x.low) & (trace.x <= x.high)
        # Longer traces are reduced for drawing.
        if trace.x.size < 4000:
            assert set(trace.x[inside]) <= set(line_x)
    # The labels of guides are annotations; other texts are labels of contours and plateaus.
    guide_labels = [text.get_text() for text in axes.texts if isinstance(text, Annotation)]
    visible_guides = [
        guide
        for guide in chart.guides
        if 0.0 <= (x if guide.vertical else y).positions([guide.value])[0] <= 1.0
    ]
    assert guide_labels == [guide.label for guide in visible_guides if guide.label]


def trace(name: str, values: Any, **options: Any) -> Trace:
    return Trace(name, T, np.asarray(values), **options)


def test_a_chart_is_drawn_with_its_points_colours_markers_and_limits() -> None:
    sine = trace("run 1", np.sin(T), mark="●", colour="series-2")
    cosine = trace("run 2", np.cos(T), mark="■", colour="series-5")
    chart = Chart(
        "t (s)", "y (m)", (sine, cosine), (Guide(2.5, "here"), Guide(0.0, vertical=False))
    )
    figure = charts_figure(VisibleCharts([(chart, View(x=Axis(1.0, 4.0), y=Axis(-0.5, 2.0)))]))
    (axes,) = panels_of(figure)
    first, second = named_lines(axes)
    for line, source, marker in ((first, sine, "o"), (second, cosine, "s")):
        assert to_hex(line.get_color()) == figure_colour(source.colour)
        assert line.get_marker() == marker
        # The line reaches the edges: one more sample beyond each.
        inside = (source.x >= 0.9 - 1e-9) & (source.x <= 4.1 + 1e-9)
        np.testing.assert_array_equal(line.get_xdata(), source.x[inside])
        np.testing.assert_array_equal(line.get_ydata(), source.y[inside])
    assert axes.get_xlim() == (1.0, 4.0)
    assert axes.get_ylim() == (-0.5, 2.0)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("t (s)", "y (m)")
    vertical_line, horizontal_line = (
        line for line in axes.get_lines() if line not in (first, second)
    )
    assert vertical_line.get_xdata() == [2.5, 2.5]
    assert horizontal_line.get_ydata() == [0.0, 0.0]
    assert [text.get_text() for text in axes.texts] == ["here"]
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["run 1", "run 2"]


def test_runs_of_a_smaller_range_are_drawn_over_those_of_a_greater_one() -> None:
    amplitudes = (1.0, 3.0, 2.0)
    runs = [
        trace(f"{amplitude:g}", amplitude * np.sin(T), number=int(amplitude))
        for amplitude in amplitudes
    ]
    (axes,) = charts_figure(VisibleCharts([(Chart("t", "y", tuple(runs)), View())])).axes
    lines_from_below = sorted(named_lines(axes), key=Line2D.get_zorder)
    assert [line.get_label() for line in lines_from_below] == ["3", "2", "1"]


def test_every_point_of_a_short_line_is_marked_and_some_of_a_long_one() -> None:
    for count in (5, 101):
        values = np.linspace(0.0, 10.0, count)
        traces = [
            Trace(name, values, values, look="line", mark=mark)
            for name, mark in (("a", "●"), ("b", "■"))
        ]
        (axes,) = panels_of(
            charts_figure(VisibleCharts([(Chart("t", "y", tuple(traces)), View())]))
        )
        for line in named_lines(axes)[:2]:
            # About twelve marks on a long line.
            spacing: Any = line.get_markevery()
            assert spacing[1] == max(count // 12, 1)


def test_hidden_traces_are_not_drawn_and_not_in_the_legend() -> None:
    chart = Chart("t (s)", "y (m)", (trace("a", T), trace("b", 2.0 * T), trace("c", 3.0 * T)))
    figure = charts_figure(VisibleCharts([(chart, View(hidden={1}))]))
    (axes,) = panels_of(figure)
    assert [line.get_label() for line in named_lines(axes)] == ["a", "c"]
    # The other traces look as they do when all are shown.
    full_axes = charts_figure(VisibleCharts([(chart, View())])).axes[0]
    a, _, c = named_lines(full_axes)
    for original_line, line in zip((a, c), named_lines(axes), strict=True):
        assert original_line.get_color() == line.get_color()
        assert original_line.get_linestyle() == line.get_linestyle()


def test_logarithmic_axes_stay_logarithmic() -> None:
    chart = Chart("f (Hz)", "|y| (m)", (trace("a", 10.0**-T),))
    (axes,) = panels_of(charts_figure(VisibleCharts([(chart, View(log_y=True))])))
    check_panel(axes, chart, View(log_y=True))
    assert axes.get_yscale() == "log"


def test_reference_lines_have_the_colour_of_their_meaning() -> None:
    guides = (Guide(2.0, "critical", role="critical"), Guide(0.5, vertical=False))
    chart = Chart("t", "y", (trace("a", T),), guides)
    (axes,) = charts_figure(VisibleCharts([(chart, View())])).axes
    colours = {to_hex(line.get_color()) for line in axes.get_lines()}
    assert {figure_colour("danger"), figure_colour("reference")} <= colours


def test_times_off_the_belt_are_shaded_where_they_are() -> None:
    run = simulate(Parameters(), t_end=10.0, samples=T)
    motion = plotted_run(run, "run 1", "●", "series-2")
    assert motion is not None
    chart = time_chart("y", [motion], strip=True, x_axis=True)
    (axes,) = panels_of(charts_figure(VisibleCharts([(chart, View())])))
    (bars,) = axes.collections
    edges = [(path.get_extents().x0, path.get_extents().x1) for path in bars.get_paths()]
    assert run.separated_intervals
    np.testing.assert_allclose(edges, run.separated_intervals)


def test_points_keep_their_letters_and_distinct_colours() -> None:
    position = np.array([1.0])
    events = [
        Trace(name, position, position + shift, look="points", ordered=False, mark=name[0].upper())
        for shift, name in enumerate(("hopf", "fold"))
    ]
    samples = [
        Trace(mark, T, T + shift, look="points", ordered=False, mark=mark)
        for shift, mark in enumerate("○▫▲")
    ]
    (axes,) = panels_of(
        charts_figure(VisibleCharts([(Chart("a", "b", (*events, *samples)), View())]))
    )
    hopf, fold, *sample_lines = named_lines(axes)
    assert (hopf.get_marker(), fold.get_marker()) == ("$\\mathrm{H}$", "$\\mathrm{F}$")
    assert [line.get_marker() for line in sample_lines] == ["o", "s", "^"]
    assert len({to_hex(line.get_color()) for line in sample_lines}) == 3


def test_points_outside_of_a_logarithmic_axis_are_omitted() -> None:
    guides = (Guide(0.0, "zero", vertical=False), Guide(1.0, "one", vertical=False))
    chart = Chart("t (s)", "y (m)", (trace("a", np.sin(T)),), guides)
    (axes,) = panels_of(charts_figure(VisibleCharts([(chart, View(log_y=True))])))
    (line,) = named_lines(axes)
    vertices: Any = axes.transScale.transform_path(line.get_path()).vertices
    assert not np.isfinite(vertices[np.sin(T) <= 0.0, 1]).any()
    assert np.isfinite(vertices[np.sin(T) > 0.0, 1]).all()
    assert [text.get_text() for text in axes.texts] == ["one"]


def test_labels_of_neighbours_do_not_cover_each_other() -> None:
    guides = tuple(Guide(position, f"at {position:g}") for position in (5.0, 5.1, 9.0))
    chart = Chart("t (s)", "y (m)", (trace("a", T),), guides)
    (axes,) = panels_of(charts_figure(VisibleCharts([(chart, View())])))
    # Of two labels beside each other, the second is set lower.
    first_height, second_height, third_height = (text.xyann[1] for text in axes.texts)  # type: ignore[attr-defined]
    assert first_height == third_height > second_height


def test_a_picture_to_scale_keeps_its_aspect() -> None:
    outline = np.array([0.0, 1.0, 1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0, 1.0, 0.0])
    chart = Chart(
        "x (m)", "height (m)", (Trace("slider", *outline, ordered=False),), to_scale=True,
        x_range=(-5.0, 5.0), y_range=(0.0, 2.0),
    )  # fmt: skip
    (axes,) = panels_of(charts_figure(VisibleCharts([(chart, View())])))
    assert axes.get_aspect() == 1.0


def test_a_heading_lists_shared_parameters(tmp_path: Path) -> None:
    chart = Chart("t (s)", "y (m)", (trace("a", T),))
    # The sets differ in F, and μ is omitted, as if it varied along an axis.
    parameter_sets = [Parameters(), Parameters(F=70.0)]
    heading_content = Heading(parameter_sets, omitted=("mu",), ignores_separation=True)
    figure = charts_figure(VisibleCharts([(chart, View())]), heading_content)
    heading = figure.get_suptitle()
    assert "100\N{NO-BREAK SPACE}N/m" in heading
    assert heading.endswith("separation ignored")
    assert "F" not in heading
    assert "mu" not in heading


def test_cursors_are_drawn_with_their_values() -> None:
    # Pinned cursors do not follow the pointer.
    view = View(cursors=Cursors((2.5, 0.0), (5.0, 0.0), pinned=True))
    chart = Chart("t (s)", "y (m)", (trace("a", T), trace("b", 2.0 * T)), note="of a run")
    (axes,) = panels_of(charts_figure(VisibleCharts([(chart, view)])))
    note, *value_lines = axes.get_title().split("\n")
    assert note == "of a run"
    for label in ("Δt 2.5 s", "1/Δt 0.4 Hz", "a ◆2.5 ◇5 Δ2.5 m", "b ◆5 ◇10 Δ5 m"):
        assert label in " ".join(value_lines)
    cursor_lines = [line for line in axes.get_lines() if to_hex(line.get_color()) == to_hex("0.1")]
    vertical_lines = [line.get_xdata() for line in cursor_lines if line.get_marker() == "None"]
    assert np.asarray(vertical_lines).tolist() == [[2.5, 2.5], [5.0, 5.0]]
    points = [
        np.asarray(line.get_xydata()).tolist() for line in cursor_lines if line.get_marker() == "D"
    ]
    assert points == [[[2.5, 2.5], [2.5, 5.0]], [[5.0, 5.0], [5.0, 10.0]]]


def test_regions_of_a_map_keep_their_names_and_colours() -> None:
    axis_values = {"F": np.array([100.0, 110.0, 120.0]), "mu": np.linspace(0.1, 0.9, 9)}
    # Where a limit cycle coexists with the equilibrium, between "safe" and "squeals", the value is
    # the least displacement at rest, m, from which a release leads to the cycle.
    chart = map_chart(safety_map(None, axis_values, "coexistence"), None)
    figure = charts_figure(VisibleCharts([(chart, View())]))
    # The legend names the regions; their colours have no bar.
    assert panels_of(figure) == figure.axes
    (legend,) = figure.legends
    names = [text.get_text() for text in legend.get_texts()]
    assert names[:3] == list(REGIONS)
    patches = [patch for patch in legend.get_patches() if patch.get_label()]
    assert len({to_hex(patch.get_facecolor()) for patch in patches}) == 3


def test_an_unordered_curve_is_drawn_completely() -> None:
    run = simulate(Parameters(), t_end=10.0, samples=T)
    motion = plotted_run(run, "run 1", "●", "series-2")
    assert motion is not None
    chart = phase_chart("y", [motion], (5.0, 10.0))
    (axes,) = panels_of(charts_figure(VisibleCharts([(chart, View())])))
    (line,) = named_lines(axes)
    in_window = motion.trajectory.t >= 5.0
    np.testing.assert_array_equal(line.get_xdata(), motion.trajectory.y[in_window])
    np.testing.assert_array_equal(line.get_ydata(), motion.trajectory.vy[in_window])
    assert axes.get_title() == "t 5 to 10 s"


def test_a_map_is_drawn_with_values_boundary_and_the_current_point() -> None:
    axis_values = {"mu": np.linspace(0.0, 1.5, 7), "F": np.linspace(10.0, 110.0, 6)}
    result = stability_map(Parameters(), axis_values, "growth-rate")
    chart = map_chart(result, Parameters())
    figure = charts_figure(VisibleCharts([(chart, View(x=Axis(0.2, 1.0), y=Axis(20.0, 90.0)))]))
    (axes,) = panels_of(figure)
    (mesh,) = [collection for collection in axes.collections if isinstance(collection, QuadMesh)]
    assert chart.backdrop is not None
    used_levels = np.unique(chart.backdrop.levels)
    drawn_levels = np.asarray(mesh.get_array(), dtype=int)
    np.testing.assert_array_equal(used_levels[drawn_levels], chart.backdrop.levels.T)
    # Redder where it is unstable, greener where it is stable.
    colours: Any = mesh.cmap(mesh.norm(drawn_levels))
    red, green, _ = np.moveaxis(colours[..., :3], -1, 0)
    assert np.all(red != green)
    assert np.all((red > green) == (result.values.T >= 0.0))
    assert (axes.get_xlim(), axes.get_ylim()) == ((0.2, 1.0), (20.0, 90.0))
    boundary, marker = named_lines(axes)
    assert boundary.get_linestyle() == "None"
    assert np.asarray(marker.get_xydata()).tolist() == [[0.7, 80.0]]
    bar = next(axes for axes in figure.axes if axes.get_label() == "<colorbar>")
    assert bar.get_ylabel() == "growth rate (1/s)"
    labels = [label.get_text() for label in bar.get_yticklabels()]
    assert labels == [chart.backdrop.shades[level].text for level in used_levels]
    assert labels == ["-0.032", "≤0.5", "≤1", ">1"]
    assert result.values.max() > 1.0


def test_exported_data_are_the_visible_points(tmp_path: Path) -> None:
    chart = Chart("t (s)", "y (m)", (trace("a", T), trace("b", 2.0 * T), trace("c", -T)))
    view = View(x=Axis(2.0, 3.0), y=Axis(-1.0, 5.0), hidden={0})
    path = tmp_path / "a.csv"
    save_charts(VisibleCharts([(chart, view)]), path)
    columns, header = read_columns(path, "chart's data"), read_header(path, "chart's data")
    inside = (T >= 2.0) & (T <= 3.0) & (2.0 * T <= 5.0)
    np.testing.assert_array_equal(columns["x"], T[inside])
    np.testing.assert_array_equal(columns["y"], 2.0 * T[inside])
    assert set(columns["trace"]) == {2.0}
    assert header["panels"] == [{"x": "t (s)", "y": "y (m)", "traces": {"2": "b", "3": "c"}}]
    save_charts(VisibleCharts([(chart, view)]), tmp_path / "a.parquet")
    meanings = {
        field.name: field.metadata[b"meaning"].decode()
        for field in pq.read_schema(tmp_path / "a.parquet")
    }
    assert meanings == {
        "panel": "number of the chart, from the first",
        "trace": "number of the trace in its chart",
        "x": "along the x axis of the chart",
        "y": "along the y axis of the chart",
    }


# In the laboratory


@pytest.fixture(scope="module")
def results() -> list[Transient]:
    p = Parameters()
    return [simulate(p, t_end=20.0, tol=1e-6, separation=s, samples=2.0 * T) for s in (True, False)]


@pytest.fixture
async def pilot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, results: list[Transient]
) -> AsyncIterator[Pilot[None]]:
    monkeypatch.chdir(tmp_path)
    async with FivtuiApp().run_test(size=(120, 45)) as running_pilot:
        session = app_of(running_pilot).session
        for result in results:
            scene = replace(session.scene(), separation=result.separation)
            session.runs.add_loaded(scene, result, "")
        first, second = session.runs
        first.overlaid, session.runs.displayed, session.runs.baseline = True, second, first
        lab_of(running_pilot)._update_runs()
        await show_tab(running_pilot, "alt+1")
        yield running_pilot


def export_figure(pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch) -> Figure:
    figures: list[Figure] = []
    monkeypatch.setattr(
        "fivtui.charts.save_figure", lambda figure, *_, **__: figures.append(figure)
    )
    pane = lab_of(pilot).tab_book.pane
    assert pane is not None
    pane.export(FIGURE).write(Path("a.svg"))
    return figures[0]


def check_panels(pilot: Pilot[None], figure: Figure) -> None:
    pane = lab_of(pilot).tab_book.pane
    assert isinstance(pane, ViewsPane)
    chart_views = [
        chart_view
        for chart_view in pane.page.query(ChartView)
        if chart_view.display and chart_view.chart is not None
    ]
    panels = panels_of(figure)
    assert len(panels) == len(chart_views) > 0
    for axes, chart_view in zip(panels, chart_views, strict=True):
        assert chart_view.chart is not None
        check_panel(axes, chart_view.chart, chart_view.view)


async def test_every_view_of_a_transient_is_exported_as_displayed(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    pane = lab_of(pilot).tab_book.pane
    assert isinstance(pane, TransientPane)
    # The view of measured data needs a file, that of the numbers has no chart.
    views = [view for view in TransientPane.VIEWS if view not in ("measured", "result")]
    for view in views:
        pane.show_view(view)
        chart = pane.query_one(f"#{view}").query(ChartView).first()
        await until(pilot, lambda chart=chart: chart.chart is not None)  # type: ignore[misc]
        chart.action_zoom(-1)
        chart.action_zoom_y(-1)
        if view == "spectrum":
            chart.action_trace(1)
        if view == "time":
            chart.action_cursor(0)
        await pilot.pause()
        figure = export_figure(pilot, monkeypatch)
        check_panels(pilot, figure)
        if view == "time":
            assert " t " in f" {figure.axes[0].get_title()}"
            chart.action_cursor_off()
        labels = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
        run_names = ["separation considered", "separation ignored"]
        if view == "difference":
            assert [axes.get_ylabel() for axes in figure.axes] == ["Δy (m)", "ΔP (N)"]
            assert figure.axes[0].get_title() == "run 2 − run 1"
        elif view == "belt":
            assert labels[:3] == ["belt", "springs", "slider"]
        else:
            # The first spectrum is hidden.
            assert labels == (run_names[1:] if view == "spectrum" else run_names)

    for chart_view in pane.query(ChartView):
        chart_view.view.reset()
    columns = {}
    for view in views:
        pane.show_view(view)
        await pilot.pause()
        path = Path(f"{view}.csv")
        pane.export(DATA).write(path)
        columns[view] = read_columns(path, "data")
    assert columns["time"].keys() == columns["phase"].keys() >= {"t", "x", "vx", "y", "vy", "P"}
    difference = pane.query_one("#difference-P", ChartView).chart
    assert difference is not None
    in_second_panel = columns["difference"]["panel"] == 2
    np.testing.assert_array_equal(
        columns["difference"]["y"][in_second_panel], difference.traces[0].y
    )
    # The reset of the view does not show the first spectrum again.
    assert set(columns["spectrum"]["trace"]) == {2.0}

    app_of(pilot).session.runs.baseline = None
    pane.show_view("difference")
    with pytest.raises(InputError, match="set another run as baseline"):
        pane.export(FIGURE)


async def test_studies_are_exported_as_displayed(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    for key, view in (("alt+2", "over-mu"), ("alt+2", "plane"), ("alt+3", "growth-rate")):
        await show_tab(pilot, key)
        pane = lab_of(pilot).tab_book.pane
        assert isinstance(pane, ViewsPane)
        pane.show_view(view)
        await until(pilot, lambda pane=pane: pane.visible_charts() is not None)  # type: ignore[misc]
        chart = pane.page.query(ChartView).first()
        chart.view.x = Axis(-2.0, 1.0) if view == "plane" else Axis(0.25, 1.25)
        chart.redraw()
        check_panels(pilot, export_figure(pilot, monkeypatch))
