"""Charts of the tabs: data, names and units of their traces."""

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

from fivtui.charts.chart import Cursors, View
from fivtui.charts.readout import NearestPoint, points_at
from fivtui.equilibrium.charts import frequency_chart, growth_chart, plane_chart
from fivtui.equilibrium.eigenvalues import stability
from fivtui.equilibrium.scan import mode_scan
from fivtui.maps import map_chart, stability_map
from fivtui.model import System
from fivtui.model.parameters import Parameters
from fivtui.scene.presets import PRESETS
from fivtui.signals.charts import spectrum_chart
from fivtui.simulation import simulate
from fivtui.sweeps import grid_chart, sweep_chart
from fivtui.tradeoffs import tradeoff_chart
from fivtui.tradeoffs.measure import Tradeoff
from fivtui.tradeoffs.report import settings_table
from fivtui.tradeoffs.settings import MeasuredSetting, Setting
from fivtui.transient.charts import (
    PlottedRun,
    difference_chart,
    phase_chart,
    plotted_run,
    time_chart,
)
from fivtui.transient.errors import Deviation
from fivtui.transient.result import Transient
from fivtui.tui.chart.picture import draw
from fivtui.tui.tabs.studies.map import MapPane
from fivtui.tui.tabs.studies.sweep import point_scene
from tests.support import paper_model
from tests.support.reading_charts import Reading
from tests.test_figures_read_back import invented_sweep, output_value

FloatArray = NDArray[np.float64]


# Motion


@pytest.fixture(scope="module")
def runs() -> tuple[Transient, Transient]:
    times = np.linspace(0.0, 3.0, 1501)
    considered, ignored = (
        simulate(t_end=3.0, separation=case, samples=times, tol=1e-9) for case in (True, False)
    )
    return considered, ignored


@pytest.fixture(scope="module")
def motions(runs: tuple[Transient, Transient]) -> list[PlottedRun]:
    names = (("run 1", "■"), ("run 2", "●"))
    plotted = [plotted_run(run, *name) for run, name in zip(runs, names, strict=True)]
    return [motion for motion in plotted if motion is not None]


def test_charts_over_time_have_the_quantity_of_their_label(motions: list[PlottedRun]) -> None:
    expected = {case: paper_model.motion(3.0, separation=case) for case in (True, False)}
    for quantity, label, column in (
        ("x", "x (m)", 0),
        ("vx", "ẋ (m/s)", 1),
        ("y", "y (m)", 2),
        ("vy", "ẏ (m/s)", 3),
        ("P", "P (N)", 4),
    ):
        chart = time_chart(quantity, motions, strip=True, x_axis=True)
        assert (chart.x_label, chart.y_label) == ("t (s)", label)
        assert chart.x_range == (0.0, 3.0)
        # The first run is drawn last, on top.
        assert [trace.name for trace in chart.traces] == ["run 2", "run 1"]
        assert [trace.mark for trace in chart.traces] == ["●", "■"]
        for trace, case in zip(chart.traces, (False, True), strict=True):
            t, rows = expected[case]
            scale = np.abs(rows[:, column]).max()
            np.testing.assert_allclose(
                trace.y, np.interp(trace.x, t, rows[:, column]), rtol=0.0, atol=5e-4 * scale
            )
        (guide,) = chart.guides
        assert (guide.value, guide.vertical) == (0.0, False)
        (strip,) = chart.strips
        t, rows = expected[True]
        separated_times = [time for time, y in zip(t, rows[:, 2], strict=True) if y > 0.1]
        assert all(
            any(start < time < end for start, end in strip.intervals)
            for time in separated_times[::20]
        )
        assert sum(end - start for start, end in strip.intervals) == pytest.approx(
            float(np.mean(rows[:, 2] > 0.0)) * 3.0, abs=0.01
        )
        assert draw(chart, View(), 80, 20).text().startswith(label)


def test_a_phase_portrait_has_velocity_over_displacement(motions: list[PlottedRun]) -> None:
    for quantity, labels, column in (
        ("y", ("y (m)", "ẏ (m/s)"), 2),
        ("x", ("x (m)", "ẋ (m/s)"), 0),
    ):
        chart = phase_chart(quantity, motions, (1.0, 2.0))
        assert (chart.x_label, chart.y_label) == labels
        assert chart.note == "t 1 to 2 s"
        assert [(guide.value, guide.label, guide.vertical) for guide in chart.guides] == (
            [(0.0, "y = 0", True)] if quantity == "y" else []
        )
        trace = chart.traces[1]
        assert trace.name == "run 1"
        t, rows = paper_model.motion(3.0, separation=True)
        in_window = (t > 1.0 - 1e-9) & (t < 2.0 + 1e-9)
        np.testing.assert_allclose(trace.x, rows[in_window, column], atol=2e-3)
        np.testing.assert_allclose(trace.y, rows[in_window, column + 1], atol=2e-2)


def test_a_spectrum_has_its_peak_at_the_frequency_in_hertz(motions: list[PlottedRun]) -> None:
    t = np.linspace(0.0, 80.0, 8001)
    y = -0.7 + 0.4 * np.sin(2.0 * np.pi * 1.25 * t) + 0.05 * np.sin(2.0 * np.pi * 2.5 * t)
    trajectory = dataclasses.replace(motions[0].trajectory, t=t, y=y)
    motion = dataclasses.replace(motions[0], trajectory=trajectory, t_end=80.0)
    chart = spectrum_chart([motion], (40.0, 80.0))
    assert (chart.x_label, chart.y_label) == ("f (Hz)", "|y| (m)")
    assert chart.x_range == pytest.approx((0.0, 10.0), rel=1e-4)
    assert [(guide.label, guide.vertical) for guide in chart.guides] == [
        ("f₁", True),
        ("2f₁", True),
        ("3f₁", True),
    ]
    assert [guide.value for guide in chart.guides] == pytest.approx([1.25, 2.5, 3.75], rel=1e-4)
    assert chart.note == "f₁ 1.25 Hz, period 0.8 s, t 40 to 80 s"
    (trace,) = chart.traces
    for frequency, amplitude in ((0.0, 0.7), (1.25, 0.4), (2.5, 0.05)):
        is_near = np.abs(trace.x - frequency) < 0.1
        assert trace.y[is_near].max() == pytest.approx(amplitude, rel=0.02)
    assert trace.y[(trace.x > 1.4) & (trace.x < 2.3)].max() < 1e-3
    reading = Reading(draw(chart, View(log_y=True), 90, 30), log_y=True)
    top = max((dot for dot in reading.dots() if dot[0] > 0.6), key=lambda dot: dot[1])
    assert top[0] == pytest.approx(1.25, abs=2 * reading.x_per_column)
    assert 10.0 ** top[1] == pytest.approx(0.4, rel=0.6)


def test_a_spectrum_without_vibration_marks_no_frequency(motions: list[PlottedRun]) -> None:
    t = np.linspace(0.0, 1.0, 20)
    at_rest = dataclasses.replace(motions[0].trajectory, t=t, y=np.full(20, -0.7))
    chart = spectrum_chart([dataclasses.replace(motions[0], trajectory=at_rest)], (0.0, 1.0))
    assert (chart.guides, chart.note) == ((), "t 0 to 1 s, no vibration")
    assert chart.traces[0].y[0] == pytest.approx(0.7)


def test_a_difference_is_the_run_minus_its_baseline(motions: list[PlottedRun]) -> None:
    chart = difference_chart("P", motions[0], motions[1], strip=False, x_axis=True)
    assert (chart.x_label, chart.y_label, chart.note) == ("t (s)", "ΔP (N)", "run 1 − run 2")
    _, considered = paper_model.motion(3.0, separation=True)
    _, ignored = paper_model.motion(3.0, separation=False)
    (trace,) = chart.traces
    np.testing.assert_allclose(trace.y, considered[:, 4] - ignored[:, 4], atol=0.5)
    assert chart.x_range == (0.0, 3.0)


# Equilibrium


def test_modes_over_mu_are_drawn_in_hertz_and_one_over_seconds() -> None:
    p = Parameters()
    result, scan = stability(p), mode_scan(System(p), 1.5)
    growth, frequency = growth_chart(scan, p, result), frequency_chart(scan, p, result)
    assert (growth.x_label, growth.y_label) == ("μ", "Re λ (1/s)")
    assert (frequency.x_label, frequency.y_label) == ("μ", "Im λ/(2π) (Hz)")
    assert [trace.name for trace in growth.traces] == ["mode 1", "mode 2"]
    for index in (0, 40, 160):
        mu = growth.traces[0].x[index]
        assert mu == frequency.traces[0].x[index] == pytest.approx(1.5 * index / 240)
        eigenvalues = paper_model.eigenvalues(mu=float(mu))
        for rate, hertz in zip(growth.traces, frequency.traces, strict=True):
            drawn = complex(rate.y[index], 2.0 * np.pi * hertz.y[index])
            assert np.abs(eigenvalues - drawn).min() < 1e-6
    vertical_guides = [(paper_model.critical_mu(), "μ_c 0.4394", True), (0.7, "μ 0.7", True)]
    zero_guide = (0.0, "", False)
    for chart, expected in ((growth, [zero_guide, *vertical_guides]), (frequency, vertical_guides)):
        for guide, (value, label, vertical) in zip(chart.guides, expected, strict=True):
            assert guide.value == pytest.approx(value, abs=1e-8)
            assert (guide.label, guide.vertical) == (label, vertical)


def test_eigenvalues_lie_in_the_plane_with_growth_to_the_right() -> None:
    p = Parameters()
    chart = plane_chart(stability(p), mode_scan(System(p), 1.5))
    assert (chart.x_label, chart.y_label) == ("Re λ (1/s)", "Im λ (rad/s)")
    path, current = chart.traces
    assert (path.name, current.name) == ("μ 0 to 1.5", "now")
    expected = paper_model.eigenvalues()
    # Sort by frequency, the real part here: growth rates of a conjugate pair are equal.
    np.testing.assert_allclose(
        np.sort_complex((current.y + 1j * current.x).round(7)),
        np.sort_complex((expected.imag + 1j * expected.real).round(7)),
        atol=2e-7,
    )
    for value in paper_model.eigenvalues(mu=0.0):
        assert np.abs(path.x + 1j * path.y - value).min() < 1e-6
    reading = Reading(draw(chart, View(), 90, 40))
    marks = reading.marks("◆")
    assert len(marks) == 4
    for value in expected:
        assert any(reading.near(mark, (value.real, value.imag)) for mark in marks)
    assert any("unstable →" in cells for cells in reading.cells)


# Sweeps, maps, trade-offs


def test_a_sweep_chart_names_every_output_and_case() -> None:
    outputs = ("x_abs", "y_half_range", "y_abs")
    result = invented_sweep({"F": (80.0, 20.0, 50.0)}, outputs)
    chart = sweep_chart(result, 33.0)
    assert chart.x_label == "F (N)"
    assert chart.y_label.endswith("(m)")
    # The outputs about y in two cases; x_abs is not drawn.
    assert len({trace.mark for trace in chart.traces}) == len(chart.traces) == 4
    for index, trace in enumerate(chart.traces):
        quantity, case = trace.name.split(", ")
        output = outputs.index("y_abs" if quantity == "peak" else "y_half_range")
        assert trace.x.tolist() == [20.0, 50.0, 80.0]
        # `output_value`: the invented values, different functions of F for each output and case.
        np.testing.assert_allclose(trace.y, output_value(output, case == "considered", trace.x))
        # The curve decides about separation, not the edited scene.
        point = NearestPoint(trace=index, x=1.0, y=1.0)
        scene = point_scene(result.study, point, edited_separation=False)
        assert scene.separation == (case == "considered")
    (guide,) = chart.guides
    assert (guide.value, guide.label, guide.vertical) == (33.0, "33", True)
    force_chart = sweep_chart(invented_sweep({"mu": (0.1, 0.2)}, ("P_max",)))
    assert (force_chart.x_label, force_chart.y_label) == ("μ", "greatest contact force (N)")
    assert force_chart.guides == ()


def test_a_grid_of_a_sweep_has_its_values_at_their_coordinates() -> None:
    result = invented_sweep({"F": (20.0, 40.0, 60.0), "mu": (0.9, 0.1)}, ("x_abs", "y_abs"))
    for case in (True, False):
        chart = grid_chart(result, case, (30.0, 0.4))
        assert (chart.x_label, chart.y_label) == ("F (N)", "μ")
        backdrop = chart.backdrop
        assert backdrop is not None
        assert backdrop.label == "peak of |y| (m)"
        assert chart.note.endswith("considered" if case else "ignored")
        assert backdrop.x.tolist() == [20.0, 40.0, 60.0]
        assert backdrop.y.tolist() == [0.1, 0.9]
        for x_index, force in enumerate((20.0, 40.0, 60.0)):
            for y_index, mu in enumerate((0.1, 0.9)):
                value = backdrop.values[x_index, y_index]
                assert value == pytest.approx(output_value(1, case, force, mu))
        assert np.all(np.diff(backdrop.levels[:, 0]) >= 0)
        (current,) = chart.traces
        assert (current.x.tolist(), current.y.tolist()) == ([30.0], [0.4])
        point = points_at(chart, View(), (57.0, 0.2))[0]
        scene = point_scene(result.study, point, case)
        assert (scene.parameters.F, scene.parameters.mu, scene.separation) == (60.0, 0.1, case)
        study_from_start = dataclasses.replace(
            result.study, start=(0.1, 0.2, -0.3, 0.4), t_end=7.0, tol=1e-6
        )
        opened_scene = point_scene(study_from_start, point, case)
        assert (opened_scene.start, opened_scene.t_end, opened_scene.tol) == (
            (0.1, 0.2, -0.3, 0.4),
            7.0,
            1e-6,
        )


def test_a_map_shows_values_boundary_and_point_at_their_coordinates() -> None:
    mu, force = np.linspace(0.0, 1.5, 31), np.linspace(10.0, 110.0, 5)
    result = stability_map(Parameters(), {"mu": mu, "F": force})
    chart = map_chart(result, Parameters(F=45.0, mu=1.2))
    assert (chart.x_label, chart.y_label) == ("μ", "F (N)")
    assert (chart.x_range, chart.y_range) == ((0.0, 1.5), (10.0, 110.0))
    backdrop = chart.backdrop
    assert backdrop is not None
    assert backdrop.label == chart.note == "growth rate (1/s)"
    for point in ((2, 1), (20, 4), (29, 0)):
        x_index, y_index = point
        expected = paper_model.growth_rate(mu=float(mu[x_index]), F=float(force[y_index]))
        assert backdrop.values[point] == pytest.approx(expected, abs=1e-7)
        shade = backdrop.shades[backdrop.levels[point]]
        assert shade.style == ("danger" if expected > 0.0 else "safe")
    boundary, current = chart.traces
    for preload in force.tolist():
        critical = paper_model.critical_mu(F=preload)
        assert np.abs(boundary.x[np.isclose(boundary.y, preload)] - critical).min() < 0.05
    assert (current.x.tolist(), current.y.tolist()) == ([1.2], [45.0])
    reading = Reading(draw(chart, View(), 90, 30))
    (mark,) = reading.marks("◆")
    assert reading.near(mark, (1.2, 45.0))
    heading = draw(chart, View(cursors=Cursors((1.0, 60.0))), 90, 30).text().splitlines()[0]
    rate = paper_model.growth_rate(mu=1.0, F=60.0)
    assert heading.split() == [
        "F",
        "(N)",
        "μ",
        "1",
        "F",
        "60",
        "N",
        "growth",
        "rate",
        f"{rate:.5g}",
        "1/s",
    ]
    # -1 is the backdrop, which is no trace.
    texts, _ = MapPane.read_point(result, NearestPoint(trace=-1, x=0.65, y=85.0))
    assert (texts["mu"], texts["F"], texts["k1"]) == ("0.65", "85", "100")
    modes = map_chart(stability_map(Parameters(), {"mu": mu, "F": force}, "unstable-modes"), None)
    assert modes.note == "unstable modes"
    critical_map = map_chart(
        stability_map(Parameters(), {"k_nl": np.array([500.0, 50.0]), "F": force}, "critical-mu"),
        None,
    )
    assert (critical_map.x_label, critical_map.note) == ("k_nl (N/m^3)", "μ_c")
    assert critical_map.backdrop is not None
    assert critical_map.backdrop.x.tolist() == [50.0, 500.0]
    assert critical_map.backdrop.values[0, 4] == pytest.approx(
        paper_model.critical_mu(k_nl=50.0, F=110.0), abs=1e-8
    )


def test_a_trade_off_has_errors_over_seconds_and_rows_in_milliseconds() -> None:
    rows = [
        MeasuredSetting(
            Setting(method, kernel="", knob="tol", value=1e-6), cpu_s=cpu_s, steps=17, error=error
        )
        for method, cpu_s, error in (
            (
                "taylor",
                0.02,
                Deviation(final=1e-6, peak=2e-7, half_range=3e-8, events=4e-5, separations=2),
            ),
            (
                "rk4",
                0.3,
                Deviation(final=5e-4, peak=6e-5, half_range=7e-6, events=8e-3, separations=2),
            ),
        )
    ]
    floor = Deviation(final=1e-13, peak=2e-14, half_range=3e-15, events=4e-12, separations=0)
    result = Tradeoff(PRESETS["base"], None, floor, rows, [])
    for name, label in (
        ("final", "error of final state"),
        ("peak", "error of peak"),
        ("half_range", "error of half peak-to-peak, 2nd half"),
        ("events", "error of events (s)"),
    ):
        chart = tradeoff_chart(result, name, rows[0])
        assert chart.x_label == "CPU (s)"
        assert chart.y_label == label
        assert [trace.name for trace in chart.traces] == ["taylor", "rk4", "now"]
        for trace, source in zip(chart.traces, (*rows, rows[0]), strict=True):
            assert trace.x.tolist() == [source.cpu_s]
            assert trace.y.tolist() == [getattr(source.error, name)]
        (guide,) = chart.guides
        assert (guide.value, guide.vertical) == (getattr(floor, name), False)
    columns, table = settings_table(result)
    cells = [dict(zip(columns, line, strict=True)) for line in table]
    assert [(cell["method"], cell["setting"], cell["CPU ms"], cell["steps"]) for cell in cells] == [
        ("taylor", "tol=1e-06", "20", "17"),
        ("rk4", "tol=1e-06", "300", "17"),
    ]
    for name, column in (
        ("final", "final state"),
        ("peak", "peak |y|"),
        ("half_range", "half peak-to-peak"),
        ("events", "events s"),
    ):
        assert [float(cell[column]) for cell in cells] == [
            pytest.approx(getattr(source.error, name)) for source in rows
        ]
    assert [(cell["separations"], cell["best for"]) for cell in cells] == [
        ("+2", "FPHE"),
        ("+2", ""),
    ]
