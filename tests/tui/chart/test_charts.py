"""Axes, views and cursors of charts, and their pictures in characters."""

from dataclasses import replace
from functools import partial
from itertools import chain, pairwise

import numpy as np
import pytest
from hypothesis import given, strategies as st
from rich.text import Text
from textual.coordinate import Coordinate
from textual.pilot import Pilot

from fivtui.charts import INKS
from fivtui.charts.axis import Axis, axis_for, parse_limits
from fivtui.charts.chart import Backdrop, Chart, Cursors, Guide, Trace, View
from fivtui.charts.readout import cursor_texts, nearest_curve_value, points_at
from fivtui.charts.shades import Shade
from fivtui.model.errors import InputError
from fivtui.signals.charts import spectrum_chart
from fivtui.signals.spectra import spectrum
from fivtui.simulation import simulate
from fivtui.transient.charts import (
    difference_chart,
    partial_run,
    phase_chart,
    plotted_run,
    time_chart,
)
from fivtui.tui.chart.picture import MARGIN, draw
from fivtui.tui.chart.raster import Raster
from fivtui.tui.chart.widget.chart_view import ChartView
from fivtui.tui.chart.widget.drawn_chart import CHART_STYLES
from fivtui.tui.lab.run_list import RunsTable
from fivtui.tui.session import Run, base_scene
from tests.support.laboratory import chart_of, run_to_end, until

T = np.linspace(0.0, 10.0, 1001)
SINE = Chart("t (s)", "y (m)", (Trace("one", T, np.sin(T)), Trace("two", T, 2.0 * np.cos(T))))


@given(st.floats(-1e6, 1e6), st.floats(1e-3, 1e6), st.floats(0.0, 1.0))
def test_positions_on_an_axis_invert_its_values(low: float, span: float, position: float) -> None:
    axis = Axis(low, low + span)
    assert axis.positions([axis.value(position)])[0] == pytest.approx(position, abs=1e-6)


def test_a_logarithmic_axis_has_decades_and_only_positive_values() -> None:
    axis = Axis(1e-6, 1.0, log=True)
    assert axis.positions([1e-3])[0] == pytest.approx(0.5)
    assert np.isnan(axis.positions([0.0, -1.0])).all()
    assert axis.ticks(7)[1] == ["1e-06", "1e-05", "0.0001", "0.001", "0.01", "0.1", "1"]
    assert Axis(0.2, 6.0, log=True).ticks(8)[1] == ["0.2", "0.5", "1", "2", "5"]


def test_zooming_keeps_its_centre_and_a_nonempty_axis() -> None:
    for axis in (Axis(-1.0, 3.0), Axis(0.1, 1000.0, log=True)):
        zoomed = axis.transform(zoom=0.5, centre=0.25)
        assert zoomed.value(0.25) == pytest.approx(axis.value(0.25))
        for _ in range(5000):
            zoomed = zoomed.transform(zoom=0.5)
        assert zoomed.low < zoomed.high
        for _ in range(5000):
            zoomed = zoomed.transform(zoom=2.0, shift=0.1)
        assert np.isfinite([zoomed.low, zoomed.high]).all()


def test_axes_follow_the_finite_data() -> None:
    axis = axis_for([np.array([1.0, np.nan, 3.0]), np.array([np.inf, 2.0])], tight=True)
    assert (axis.low, axis.high) == (1.0, 3.0)
    assert axis_for([]).low < axis_for([]).high
    log_axis = axis_for([np.array([-1.0, 0.0, 10.0, 1000.0])], log=True, tight=True)
    assert (log_axis.low, log_axis.high) == pytest.approx((10.0, 1000.0))


@pytest.mark.parametrize("text", ["5", "3:1", "1:1", "a:b", "1:inf", "nan:1", "1:2:3", "-1e301:0"])
def test_invalid_limits_are_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"must be|below"):
        parse_limits("x", text)


def test_limits_are_parsed() -> None:
    assert parse_limits("x", " -1 : 2e3 ") == (-1.0, 2000.0)
    assert [parse_limits("x", text) for text in ("60,70", "60 70", "60, 70 ")] == [(60.0, 70.0)] * 3
    assert parse_limits("x", "  ") is None
    with pytest.raises(InputError, match="above 0"):
        parse_limits("x", "0:1", log=True)


def raster_text(raster: Raster) -> str:
    return "\n".join("".join(chr(Raster.BLANK + dots) for dots in row) for row in raster.cells)


def test_lines_are_cut_off_at_the_edges_and_gaps_stay_open() -> None:
    raster = Raster(4, 2)
    raster.draw_lines(np.array([-1.0, 2.0]), np.array([-1.0, 2.0]))
    assert raster_text(raster) == "⠀⠀⡠⠊\n⡠⠊⠀⠀"
    interrupted = Raster(4, 1)
    interrupted.draw_lines(np.array([0.0, 0.2, np.nan, 0.8, 1.0]), np.full(5, 1.0))
    assert raster_text(interrupted) == "⠉⠀⠀⠉"
    distant = Raster(4, 1)
    distant.draw_lines(np.array([-5.0, -2.0, 1e300]), np.array([0.5, 1e300, -1e300]))
    assert raster_text(distant) == "⠀" * 4


def test_a_picture_has_the_requested_size_and_all_labels() -> None:
    for width, height in ((10, 3), (47, 8), (100, 30), (200, 60)):
        picture = draw(SINE, View(), width, height)
        lines = picture.text().splitlines()
        assert len(lines) == height
        assert {len(line) for line in lines} == {width}
    lines = draw(SINE, View(), 200, 60).text().splitlines()
    assert lines[0].startswith("y (m) 1─one 2─two")
    # Leave eight columns of the first line free for buttons.
    narrow = draw(SINE, View(), 20, 14, reserved=8).text().splitlines()
    assert [line.strip() for line in narrow[:2]] == ["y (m) 1─one", "2─two"]
    assert {len(line) for line in narrow} == {20}
    assert draw(SINE, View(), 20, 6).plot_area.top_row == 1
    assert lines[-1].startswith("t (s)")
    assert lines[-1].rstrip().endswith("10")
    assert "1" in "".join(lines[1:-1])


def test_hidden_traces_are_not_drawn_and_limits_follow_the_others() -> None:
    view = View()
    assert view.axes(SINE)[1].high > 2.0
    assert view.toggle_trace(SINE, 1)
    assert view.axes(SINE)[1].high < 1.2
    assert not view.toggle_trace(SINE, 2)


def test_the_cursor_reads_the_nearest_sample_of_every_trace() -> None:
    view = View(cursors=Cursors((3.0001, 0.0)))
    readings = points_at(SINE, view, view.cursors.first)
    assert [(point.trace, point.x) for point in readings] == [(0, 3.0), (1, 3.0)]
    assert readings[0].y == pytest.approx(np.sin(3.0))
    assert draw(SINE, view, 80, 20).text().startswith("y (m) t 3 s  y one 0.14112 m two -1.98 m")
    plane = Chart("a", "b", (Trace("", np.cos(T), np.sin(T), ordered=False),))
    (point,) = points_at(plane, View(), (0.0, 0.9))
    assert (point.x, point.y) == pytest.approx((0.0, 1.0), abs=0.01)


def test_a_function_is_never_panned_off_its_data() -> None:
    view = View()
    view.zoom(SINE, 0.5)
    for _ in range(20):
        view.pan(SINE, 0.3)
    x, _ = view.axes(SINE)
    assert (x.low, x.high) == pytest.approx((5.0, 10.0))
    view.zoom(SINE, 100.0)
    assert view.x is None


@pytest.mark.parametrize("ordered", [True, False], ids=["over time", "in a plane"])
def test_of_several_dense_curves_the_top_one_is_filled_and_the_others_are_outlines(
    ordered: bool,
) -> None:
    t = np.linspace(0.0, 100.0, 20_001)
    # In a plane, ellipses that fill the area between the smallest and the largest one.
    x, y = (t, np.cos(8.0 * t)) if ordered else (np.sin(8.0 * t), np.cos(8.0 * t) * np.cos(0.1 * t))
    amplitudes = (1.0, 2.0, 3.0)
    # A style that identifies the characters of the curve.
    curves = [
        Trace(f"{a:g}", x, a * y, colour=f"#{a:.0f}", ordered=ordered, mark="●") for a in amplitudes
    ]
    for top in (2, 0):
        drawing_order = [curve for curve in curves if curve is not curves[top]] + [curves[top]]
        chart = Chart("x", "y", tuple(drawing_order), y_range=(-3.2, 3.2))
        picture = draw(chart, View(), 108, 33)
        # Characters and styles by row, in columns without numbers of curves.
        rows = [
            [(character, style) for text, style in line for character in text][MARGIN + 40 :][:8]
            for line in picture.lines[1:-1]
        ]
        upper_rows = [round((0.5 - a / 6.4) * len(rows) - 0.5) for a in amplitudes]
        for curve, upper_row in zip(curves, upper_rows, strict=True):
            near_edge = chain(*rows[max(upper_row - 1, 0) : upper_row + 2])
            assert curve.colour in {style for _, style in near_edge}
        # In a plane, gaps between the ellipses show what is below, also outside of the top one.
        if ordered:
            inside = chain(*rows[upper_rows[0] + 2 : len(rows) // 2])
            assert {style for _, style in inside} == {curves[top].colour}
            between = chain(*rows[upper_rows[1] + 2 : upper_rows[0] - 1])
            assert all((character == " ") == (top == 0) for character, _ in between)


def test_a_curve_of_many_periods_is_drawn_without_gaps_between_its_edges() -> None:
    t = np.linspace(0.0, 100.0, 10_001)
    for frequency in np.linspace(0.5, 4.0, 15):
        chart = Chart("t", "y", (Trace("", t, np.sin(2.0 * np.pi * frequency * t)),))
        lines = draw(chart, View(), 80, 20).text().splitlines()[1:-1]
        columns = list(zip(*(line[MARGIN + 3 : -3] for line in lines), strict=True))
        # The same rows in every column, up to their dots at the edges.
        drawn_rows = {tuple(cell != " " for cell in column) for column in columns}
        assert len(drawn_rows) == 1, frequency
        (is_drawn,) = drawn_rows
        assert sum(is_drawn) >= 16


def test_guides_shades_and_marks_are_drawn() -> None:
    # Index of the shade by μ and F: blank at μ = 0 and 1, ▒ at 2 and 3.
    levels = np.repeat([[0], [0], [1], [1]], 3, axis=1)
    chart = Chart(
        "μ",
        "F (N)",
        (Trace("here", np.array([1.5]), np.array([1.0]), look="points", mark="◆"),),
        guides=(Guide(0.5, "μ_c"),),
        backdrop=Backdrop(
            np.arange(4.0),
            np.arange(3.0),
            levels,
            (Shade(" ", "plot"), Shade("▒", "plot")),
            levels.astype(float),
            "growth (1/s)",
        ),
    )
    text = draw(chart, View(), 48, 12).text()
    plot_area = [line[MARGIN:] for line in text.splitlines()[1:-1]]
    assert any("μ_c" in line for line in plot_area)
    assert "◆" in text
    assert all("▒" not in line[:18] and line.endswith("▒") for line in plot_area)
    heading = draw(chart, View(cursors=Cursors((2.9, 0.2))), 48, 12).text()
    assert heading.startswith("F (N) μ 3  F 0 N  growth 1 1/s")


# With fewer than ten rows the ticks of some ranges are not whole rows apart.
@given(st.floats(-1e3, 1e3), st.floats(1e-4, 1e4), st.integers(12, 50), st.booleans())
def test_ticks_of_y_are_whole_rows_apart_and_all_have_their_values(
    low: float, span: float, height: int, log: bool
) -> None:
    low = abs(low) + 1e-3 if log else low
    values = np.array([low, low * (1e3 + span) if log else low + span])
    chart = Chart("t (s)", "y (m)", (Trace("", np.array([0.0, 1.0]), values),))
    view = View(log_y=log)
    picture = draw(chart, view, 60, height)
    column, top, _, rows = picture.plot_area
    margins = [line[:column] for line in picture.text().splitlines()[top : top + rows]]
    ticks = [(row, float(text[:-1])) for row, text in enumerate(margins) if text[-1] == "┤"]
    assert len(ticks) > 1
    (distance,) = {lower[0] - upper[0] for upper, lower in pairwise(ticks)}
    assert distance >= 2
    axis = view.axes(chart)[1]
    assert axis.low <= values[0] < values[1] <= axis.high
    for row, value in ticks:
        assert axis.positions(value) == pytest.approx(1.0 - (row + 0.5) / rows, abs=1e-3)


@pytest.mark.parametrize("end", [1.0, 7.3, 120.0, 5e-7, 3e8])
def test_no_label_of_a_tick_of_x_is_missing(end: float) -> None:
    chart = Chart("t (s)", "y", (Trace("", np.array([0.0, end]), np.array([0.0, 1.0])),))
    for width in range(30, 200, 7):
        picture = draw(chart, View(), width, 12)
        labels = [float(text) for text in picture.text().splitlines()[-1].split()[2:]]
        steps = np.diff(labels)
        assert labels[0] == 0.0
        assert steps == pytest.approx(np.full(len(labels) - 1, steps[0]))
        assert end - labels[-1] < 1.0001 * steps[0]
        # A long name of the axis is in the heading.
        heading, *_, last = draw(replace(chart, x_label="CPU time (s)"), View(), width, 12).lines
        assert heading[1][0] == " over CPU time (s)"
        assert [float(text) for text in "".join(text for text, _ in last).split()] == labels


def test_a_line_at_zero_is_shown_near_the_data_or_with_a_meaning() -> None:
    t = np.linspace(0.0, 1.0, 100)
    trace = Trace("", t, -0.63 + 0.01 * np.sin(60.0 * t))
    far, near = (replace(trace, y=trace.y + shift) for shift in (0.0, 0.615))
    zero = Guide(0.0, vertical=False)
    for guide, data, is_shown in (
        (zero, far, False),
        (zero, near, True),
        (replace(zero, label="belt"), far, True),
        (replace(zero, role="stability limit"), far, True),
    ):
        _, axis = View().axes(Chart("t (s)", "y (m)", (data,), guides=(guide,)))
        assert (axis.low <= 0.0 <= axis.high) is is_shown


def test_labels_of_plateaus_are_drawn_over_boundaries() -> None:
    x = np.linspace(0.0, 10.0, 21)
    levels = np.zeros((21, 21), dtype=np.intp)
    shades = (Shade("░", "plot"),)
    labels = ((5.0, 5.0, "0.278"),)
    backdrop = Backdrop(x, x, levels, shades, levels.astype(float), "μ", labels=labels)
    boundary = Trace("boundary", np.linspace(0.0, 10.0, 200), np.full(200, 5.0), ordered=False)
    chart = Chart("F (N)", "k (N/m)", (boundary,), backdrop=backdrop)
    assert " 0.278 " in draw(chart, View(), 60, 16).text()


def test_stacked_areas_add_up_and_have_patterns_of_their_own() -> None:
    x = np.linspace(0.0, 1.0, 50)
    traces = tuple(
        Trace(role, x, np.full(50, share), colour=role)
        for role, share in (("safe", 0.1), ("warning", 0.2), ("danger", 0.3))
    )
    chart = Chart("μ", "share", traces, stacked=True)
    view = View()
    picture = draw(chart, view, 60, 20)
    column, top, _, rows = picture.plot_area
    cells = [line[column + 5] for line in picture.text().splitlines()[top : top + rows]]
    values = [float(view.axes(chart)[1].value(1.0 - (row + 0.5) / rows)) for row in range(rows)]
    by_value = dict(zip(values, cells, strict=True))
    full = {
        role: {cell for value, cell in by_value.items() if low + 0.03 < value < high - 0.03}
        for role, low, high in (("safe", 0.0, 0.1), ("warning", 0.1, 0.3), ("danger", 0.3, 0.6))
    }
    assert [len(cells) for cells in full.values()] == [1, 1, 1]
    assert len(set.union(*full.values())) == 3
    # Nothing is above their sum.
    characters = set(draw(chart, View(y=Axis(0.61, 1.0)), 60, 20).text())
    assert characters.isdisjoint(map(chr, range(0x2800, 0x2900)))


def test_marks_on_a_dense_line_have_gaps_and_those_of_a_sparse_one_are_complete() -> None:
    x = np.linspace(0.0, 1.0, 200)
    for size, expected in ((200, range(3, 9)), (4, range(4, 5))):
        points = x[:: 200 // size][:size]
        trace = Trace("peak", points, np.full(size, 0.5), look="marked", mark="●")
        text = draw(Chart("F (N)", "y (m)", (trace,)), View(), 48, 12).text()
        assert text.count("●") in expected


@pytest.mark.parametrize(
    ("value", "log"), [(0.0, False), (5.0, False), (-3.0, False), (1e12, False), (5.0, True)]
)
def test_an_axis_of_one_value_contains_it(value: float, log: bool) -> None:
    for tight in (False, True):
        axis = axis_for([[value, value]], log=log, tight=tight)
        assert axis.low < value < axis.high


def test_chosen_ranges_set_the_axes_unless_they_are_logarithmic() -> None:
    values = np.array([1.0, 10.0])
    chart = Chart(
        "x", "y", (Trace("", values, values),), x_range=(-2.0, 20.0), y_range=(-3.0, 30.0)
    )
    x, y = View().axes(chart)
    assert (x.low, x.high, y.low, y.high) == (-2.0, 20.0, -3.0, 30.0)
    for axis in View(log_x=True, log_y=True).axes(chart):
        assert axis.log
        assert 0.0 < axis.low <= 1.0
        assert 10.0 <= axis.high <= 100.0


def test_a_million_samples_are_reduced() -> None:
    t = np.linspace(0.0, 100.0, 1_000_000)
    y = np.sin(50.0 * t)
    y[777_777] = 9.0
    text = draw(Chart("t (s)", "y (m)", (Trace("", t, y),)), View(), 80, 20).text()
    assert any(mark in text for mark in "⡇⢸⡀⢀⠁⠈")
    assert View().axes(Chart("t", "y", (Trace("", t, y),)))[1].high > 9.0


def test_a_spectrum_finds_amplitude_and_period() -> None:
    t = np.arange(0.0, 50.0, 0.01)
    result = spectrum(t, 3.0 + 0.5 * np.sin(2.0 * np.pi * 1.234 * t))
    assert result.fundamental == pytest.approx(1.234, abs=0.05 * result.resolution)
    assert result.amplitude.max() == pytest.approx(3.0, rel=1e-3)
    assert result.amplitude[1:].max() == pytest.approx(0.5, rel=0.2)
    assert result.period == pytest.approx(1.0 / 1.234, rel=1e-3)
    assert spectrum(t[:64], np.full(64, 2.0)).period is None
    with pytest.raises(InputError, match="9 samples; must be at least 16"):
        spectrum(t[:9], t[:9])
    with pytest.raises(InputError, match="evenly"):
        spectrum(t[:64] ** 2, t[:64])


def test_the_charts_of_the_base_scene_show_its_separation_and_frequency() -> None:
    run = simulate(samples=np.linspace(0.0, 100.0, 10_001))
    motion = plotted_run(run, "run 1")
    assert motion is not None
    picture_text = draw(time_chart("y", [motion], strip=True, x_axis=True), View(), 80, 20).text()
    assert "off belt" in picture_text
    assert "y (m)" in picture_text
    phase = phase_chart("y", [motion], (50.0, 100.0))
    assert phase.traces[0].x.size == 5001
    assert phase.is_plane
    peak_chart = spectrum_chart([motion], (50.0, 100.0))
    assert "f₁ 0.753" in peak_chart.note
    assert [guide.label for guide in peak_chart.guides] == ["f₁", "2f₁", "3f₁"]
    assert run.trajectory is not None
    intervals = partial_run(run.trajectory, run.system, run.t_end).separated
    assert len(intervals) == pytest.approx(len(run.separated_intervals), abs=2)
    assert sum(end - start for start, end in intervals) == pytest.approx(71.0, abs=1.0)


def test_a_trajectory_grows_by_parts_and_restarts() -> None:
    run = simulate(t_end=10.0, samples=np.linspace(0.0, 10.0, 1001))
    assert run.trajectory is not None
    names = ("t", "x", "vx", "y", "vy", "P", "mode")
    parts = [
        type(run.trajectory)(
            *(getattr(run.trajectory, name)[first : first + 100] for name in names)
        )
        for first in range(0, 1000, 100)
    ]
    active = Run(1, base_scene())
    assert active.trajectory_so_far is None
    for count, part in enumerate(parts, start=1):
        active.add_part(part)
        if count % 3 == 0:
            trajectory = active.trajectory_so_far
            assert trajectory is not None
            assert trajectory.t.size == 100 * count
    active.add_part(parts[0])
    trajectory = active.trajectory_so_far
    assert trajectory is not None
    assert trajectory.t.size == 100


def test_the_difference_of_two_motions_is_exact_where_they_share_their_times() -> None:
    times = np.linspace(0.0, 10.0, 101)
    motions = []
    for name, samples in (("a", times), ("b", times), ("c", np.linspace(0.0, 8.0, 1001))):
        motion = plotted_run(simulate(t_end=10.0, samples=samples), name)
        assert motion is not None
        motions.append(motion)
    exact = difference_chart("y", motions[0], motions[1], strip=False, x_axis=True)
    assert exact.note == "a − b"
    assert not exact.traces[0].y.any()
    assert "Δy (m) a − b" in draw(exact, View(), 60, 10).text()
    interpolated = difference_chart("P", motions[0], motions[2], strip=False, x_axis=True)
    assert interpolated.note == "a − c, interpolated"
    assert interpolated.traces[0].x[-1] == 8.0
    peak = motions[0].trajectory.P.max()
    assert np.abs(interpolated.traces[0].y).max() < 0.01 * peak


def test_every_part_of_a_chart_except_its_background_has_a_theme_style() -> None:
    assert [name for name, style in CHART_STYLES.items() if not style] == ["plot"]


async def test_charts_and_runs_follow_the_theme_in_their_colours(pilot: Pilot[None]) -> None:
    await run_to_end(pilot)
    chart_view = chart_of(pilot, "plot-y")
    for theme, background in (("textual-dark", "dark"), ("textual-light", "light")):
        pilot.app.theme = theme
        # The colour of the first run, in its curve and in the list.
        expected = getattr(INKS["series-1"], background)
        await until(pilot, partial(_has_colour, chart_view, expected))
        mark = pilot.app.screen.query_one(RunsTable).get_cell_at(Coordinate(0, 0))
        assert isinstance(mark, Text)
        assert expected in {str(span.style) for span in mark.spans}


def _has_colour(view: ChartView, code: str) -> bool:
    segments = [segment for y in range(view.size.height) for segment in view.render_line(y)]
    colours = [segment.style.color for segment in segments if segment.style is not None]
    return code in {colour.name for colour in colours if colour is not None}


def test_two_cursors_read_both_values_their_difference_and_the_unit() -> None:
    view = View(cursors=Cursors((3.0, 0.0), (5.0, 0.0)))
    sine = np.sin([3.0, 5.0])
    heading = draw(SINE, view, 80, 20).text().splitlines()[0]
    assert f"one ◆{sine[0]:.5g} ◇{sine[1]:.5g} Δ{sine[1] - sine[0]:.5g} m" in heading
    assert cursor_texts("t (s)", 3.0, 5.0) == ["t ◆3 ◇5 s", "Δt 2 s", "1/Δt 0.5 Hz"]
    assert cursor_texts("f (Hz)", 3.0, 2.5) == ["f ◆3 ◇2.5 Hz", "Δf -0.5 Hz", "1/Δf 2 s"]
    assert cursor_texts("μ", 1.0, 1.0) == ["μ ◆1 ◇1", "Δμ 0"]
    # In a small terminal the plot shrinks, but the cursor values are complete.
    small_text = " ".join(draw(SINE, view, 38, 6).text().split())
    for name, values in (("one", np.sin([3.0, 5.0])), ("two", 2.0 * np.cos([3.0, 5.0]))):
        a, b = values.tolist()
        assert f"{name} ◆{a:.5g} ◇{b:.5g} Δ{b - a:.5g} m" in small_text
    # A trace is not read at a cursor outside its range.
    short_and_long = Chart("t (s)", "y (m)", (Trace("a", T[:400], T[:400]), Trace("b", T, T)))
    heading = draw(short_and_long, view, 80, 20).text().splitlines()[0]
    assert heading.strip() == "y (m)  y a ◆3 m b ◆3 ◇5 Δ2 m"


def test_cursors_of_a_chart_along_curves_are_on_the_curves() -> None:
    circle = Trace("", np.cos(T), np.sin(T), ordered=False, curve_values=T)
    chart = Chart("x (m)", "y (m)", (circle,), curve_label="t (s)")
    assert chart.cursor_label == "t (s)"
    view = View(cursors=Cursors((0.0, 0.0), (4.71, 0.0)))
    first, second = (
        points_at(chart, view, cursor) for cursor in (view.cursors.first, view.cursors.second)
    )
    assert [(p.x, p.y) for p in first + second] == [
        pytest.approx((1.0, 0.0)),
        pytest.approx((0.0, -1.0), abs=0.01),
    ]
    assert points_at(chart, view, (11.0, 0.0)) == []
    assert nearest_curve_value(chart, view, (0.0, 1.2)) == pytest.approx(np.pi / 2, abs=0.01)
    text = draw(chart, view, 60, 20).text()
    assert text.count("◆") - text.splitlines()[0].count("◆") == 1
    # No vertical lines at the cursors.
    assert "│ │" not in text
    single_text = draw(chart, View(cursors=Cursors((0.0, 0.0))), 60, 20).text()
    assert single_text.startswith("y (m) t 0 s x 1 m y 0 m")


def test_a_long_note_continues_in_parts_on_the_next_lines() -> None:
    note = "f₁ 0.7538 Hz, period 1.327 s, t 50 to 100 s"
    chart = replace(SINE, note=note)
    lines = draw(chart, View(), 46, 14, reserved=18).text().splitlines()
    assert lines[0].rstrip() == "y (m) f₁ 0.7538 Hz,"
    assert note in " ".join(" ".join(lines[:3]).split())


def test_limits_are_marked_and_a_new_run_outside_of_them_is_named() -> None:
    def heading(view: View, number: int, values: np.ndarray) -> str:
        chart = Chart("t (s)", "y (m)", (Trace("new", T, values, number=number),))
        return draw(chart, view, 80, 20).text().splitlines()[0].strip()

    y_limited = View()
    y_limited.set_limits(SINE, None, Axis(-2.5, 2.5))
    assert heading(y_limited, 1, np.sin(T)) == "y (m) zoom y"
    assert heading(y_limited, 1, 3.0 * np.sin(T)).endswith("new partly outside, r: fit zoom y")
    # Number 0: not a run, so named only if it is entirely outside.
    assert heading(y_limited, 0, 3.0 * np.sin(T)) == "y (m) zoom y"
    assert heading(y_limited, 0, 3.0 + np.sin(0.1 * T)).endswith("new outside, r: fit zoom y")
    # Values exactly at the limits are not outside.
    assert heading(y_limited, 1, np.linspace(-2.5, 2.5, T.size)) == "y (m) zoom y"
    y_limited.newest_run_when_zoomed = 1
    assert heading(y_limited, 1, 3.0 * np.sin(T)) == "y (m) zoom y"
    after_data = View(x=Axis(20.0, 30.0))
    assert heading(after_data, 0, T).endswith("new outside, r: fit zoom t")
    x_limited = View(x=Axis(1.0, 2.0))
    assert heading(x_limited, 1, 3.0 * np.sin(T)) == "y (m) zoom t"
