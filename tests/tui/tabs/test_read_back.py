"""Charts of the terminal read back: where curves pass, by the ticks beside them, and the words."""

import dataclasses
import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fivtui.equilibrium import stability_rows
from fivtui.equilibrium.eigenvalues import stability
from fivtui.equilibrium.map import stability_map
from fivtui.equilibrium.scan import mode_scan
from fivtui.model.parameters import Parameters
from fivtui.scene.presets import PRESETS
from fivtui.simulation import simulate
from fivtui.tradeoffs.measure import Tradeoff
from fivtui.tradeoffs.settings import MeasuredSetting, Setting
from fivtui.transient import transient_rows
from fivtui.transient.errors import Deviation
from fivtui.transient.result import Transient
from fivtui.tui.chart.axis import Axis
from fivtui.tui.chart.chart import (
    MOST_JOINED,
    Backdrop,
    Chart,
    Guide,
    NearestPoint,
    Trace,
    View,
    nearest,
)
from fivtui.tui.chart.picture import MARGIN, Picture, draw
from fivtui.tui.session.comparison import change_rows, changes, percent_text
from fivtui.tui.session.report import result_brief, stability_brief
from fivtui.tui.tabs.charts.map import map_chart, point_texts
from fivtui.tui.tabs.charts.stability import frequency_chart, growth_chart, plane_chart
from fivtui.tui.tabs.charts.sweep import case_of, grid_chart, point_scene, points_of, sweep_chart
from fivtui.tui.tabs.charts.tradeoff import table_rows, tradeoff_chart
from fivtui.tui.tabs.charts.transient import (
    PlottedRun,
    difference_chart,
    phase_chart,
    plotted_run,
    spectrum_chart,
    time_chart,
)
from tests.support import own_slider
from tests.test_figures_read_back import made_up, output_value

FloatArray = NDArray[np.float64]
BITS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])


class Reading:
    """A drawn chart as its user reads it: places by the labels of the ticks next to them."""

    def __init__(self, picture: Picture, *, log_x: bool = False, log_y: bool = False) -> None:
        self.lines = picture.text().splitlines()
        left, top, columns, rows = picture.plot
        assert left == MARGIN
        self.cells = [line[left : left + columns] for line in self.lines[top : top + rows]]
        beside = [
            (row + 0.5, float(line[: MARGIN - 1]))
            for row, line in enumerate(self.lines[top : top + rows])
            if line[MARGIN - 1] == "┤"
        ]
        below = [
            (0.5 * (word.start() + word.end()), float(word[0]))
            for word in re.finditer(r"\S+", self.lines[-1][MARGIN:])
            # A label at an edge is moved inwards.
            if re.fullmatch(r"[-+.e\d]+", word[0]) and word.start() > 0 and word.end() < columns
        ]
        self.x, self.x_per_column = self._scale(below, log_x)
        self.y, self.y_per_row = self._scale(beside, log_y)

    @staticmethod
    def _scale(
        ticks: list[tuple[float, float]], log: bool
    ) -> tuple[Callable[[float], float], float]:
        assert len(ticks) > 1
        places, values = np.array(ticks).T
        slope, start = np.polyfit(places, np.log10(values) if log else values, 1).tolist()
        # Every tick stands in its cell.
        off = start + slope * places - (np.log10(values) if log else values)
        assert np.abs(off).max() <= 1.1 * abs(slope)
        return lambda place: start + slope * place, abs(slope)

    def dots(self) -> list[tuple[float, float]]:
        """Where the dots are, in the scales of the axes: logarithms where those are."""
        found = []
        for row, cells in enumerate(self.cells):
            for column, cell in enumerate(cells):
                if 0x2800 <= ord(cell) < 0x2900:
                    down, right = np.nonzero(BITS & (ord(cell) - 0x2800))
                    found += [
                        (self.x(column + 0.25 + 0.5 * r), self.y(row + 0.125 + 0.25 * d))
                        for d, r in zip(down.tolist(), right.tolist(), strict=True)
                    ]
        return found

    def marks(self, character: str) -> list[tuple[float, float]]:
        """Where a character stands."""
        return [
            (self.x(column + 0.5), self.y(row + 0.5))
            for row, cells in enumerate(self.cells)
            for column, cell in enumerate(cells)
            if cell == character
        ]

    def near(self, found: tuple[float, float], expected: tuple[float, float]) -> bool:
        """Whether a place is another but for a cell or so."""
        return (
            abs(found[0] - expected[0]) <= 1.6 * self.x_per_column
            and abs(found[1] - expected[1]) <= 1.6 * self.y_per_row
        )


def function_chart(y: Callable[[FloatArray], FloatArray], low: float, high: float) -> Chart:
    x = np.linspace(low, high, 501)
    return Chart("x / s", "y / m", (Trace("", x, y(x)),))


@pytest.mark.parametrize(
    "function",
    [lambda x: 5.0 + 2.0 * x, lambda x: 40.0 - 3.0 * x, lambda x: 10.0 + 4.0 * np.sin(0.7 * x)],
)
def test_a_curve_passes_where_its_ticks_say(function: Callable[[FloatArray], FloatArray]) -> None:
    chart = function_chart(function, 10.0, 20.0)
    read = Reading(draw(chart, View(), 70, 24))
    dots = read.dots()
    x = np.array([at for at, _ in dots])
    assert x.min() == pytest.approx(10.0, abs=2 * read.x_per_column)
    assert x.max() == pytest.approx(20.0, abs=2 * read.x_per_column)
    steepest = 4.0 * read.x_per_column
    for at, up in dots:
        assert up == pytest.approx(function(np.array(at)), abs=1.6 * read.y_per_row + steepest)
    columns = {round(at / read.x_per_column) for at, _ in dots}
    assert len(columns) > 55


def test_logarithmic_scales_straighten_powers() -> None:
    x = np.geomspace(1e-3, 1e2, 400)
    chart = Chart("x / s", "y / 1", (Trace("", x, 2e3 * x**-1.5),))
    read = Reading(draw(chart, View(log_x=True, log_y=True), 80, 30), log_x=True, log_y=True)
    for at, up in read.dots():
        expected = np.log10(2e3) - 1.5 * at
        assert up == pytest.approx(expected, abs=1.6 * (read.y_per_row + 1.5 * read.x_per_column))
    assert min(at for at, _ in read.dots()) == pytest.approx(-3.0, abs=2 * read.x_per_column)
    assert max(at for at, _ in read.dots()) == pytest.approx(2.0, abs=2 * read.x_per_column)


def test_points_guides_and_shades_stand_at_their_coordinates() -> None:
    here = Trace("now", np.array([7.0]), np.array([210.0]), look="points", ordered=False, mark="◆")
    line = Trace("line", np.array([5.0, 9.0]), np.array([100.0, 400.0]), ordered=False)
    guides = (Guide(6.0, "at six"), Guide(300.0, "three hundred", vertical=False))
    read = Reading(draw(Chart("a / N", "b / m", (line, here), guides=guides), View(), 80, 30))
    (mark,) = read.marks("◆")
    assert read.near(mark, (7.0, 210.0))
    for at in ((6.5, 212.5), (8.0, 325.0)):
        assert any(read.near(dot, at) for dot in read.dots())
    assert not any(read.near(dot, (5.0, 350.0)) for dot in read.dots())
    vertical = [at for at in read.marks("│") if at[1] < 290.0]
    assert vertical
    assert all(abs(at[0] - 6.0) <= 1.1 * read.x_per_column for at in vertical)
    horizontal = read.marks("─")
    assert len(horizontal) > 40
    assert all(abs(at[1] - 300.0) <= 1.1 * read.y_per_row for at in horizontal)
    (named,) = [row for row, cells in enumerate(read.cells) if "three hundred" in cells]
    assert read.y(named + 0.5) == pytest.approx(300.0, abs=1.1 * read.y_per_row)
    (beside,) = [cells.index("at six") for cells in read.cells if "at six" in cells]
    assert read.x(beside - 0.5) == pytest.approx(6.0, abs=1.1 * read.x_per_column)


def test_of_a_long_orbit_the_latest_points_alone_are_joined() -> None:
    # 20 corners far apart, the first of many points; then two points, joined.
    x = np.concatenate([np.tile([0.0, 10.0], 10), np.full(MOST_JOINED - 2, 2.0), [2.0, 8.0]])
    y = np.concatenate([np.tile([0.0, 10.0], 10), np.full(MOST_JOINED - 2, 9.0), [9.0, 9.0]])
    chart = Chart("a / m", "b / m", (Trace("", x, y, ordered=False),), tight=False)
    read = Reading(draw(chart, View(), 80, 30))
    dots = read.dots()
    assert any(read.near(dot, (5.0, 9.0)) for dot in dots)
    assert not any(read.near(dot, (5.0, 5.0)) for dot in dots)
    for corner in ((0.0, 0.0), (10.0, 10.0)):
        assert any(read.near(dot, corner) for dot in dots)


def test_shades_lie_over_their_own_axes() -> None:
    x, y = np.linspace(0.0, 10.0, 41), np.linspace(100.0, 300.0, 31)
    levels = ((x[:, None] > 6.0) & (y[None, :] < 160.0)).astype(np.intp)
    shades = ((" ", "plot"), ("█", "plot"))
    backdrop = Backdrop(x, y, levels, shades, np.add.outer(x, y), "sum / N")
    chart = Chart("a / m", "b / kg", (), backdrop=backdrop)
    read = Reading(draw(chart, View(), 80, 30))
    shaded = read.marks("█")
    assert min(at for at, _ in shaded) == pytest.approx(6.0, abs=0.3 + read.x_per_column)
    assert max(at for at, _ in shaded) == pytest.approx(10.0, abs=0.3 + read.x_per_column)
    assert max(up for _, up in shaded) == pytest.approx(160.0, abs=8.0 + read.y_per_row)
    assert min(up for _, up in shaded) == pytest.approx(100.0, abs=8.0 + read.y_per_row)
    told = draw(chart, View(cursor=(7.6, 199.0)), 80, 30).text()
    assert told.startswith("a 7.5  b 200  sum 207.5 N")


def test_coarse_shades_fill_their_range_to_its_ends_and_nothing_beyond() -> None:
    x, y, levels = np.array([2.0, 4.0, 6.0]), np.array([100.0, 200.0, 300.0]), np.zeros((3, 3))
    backdrop = Backdrop(x, y, levels.astype(np.intp), (("█", "plot"),), levels, "one")
    view = View(x=Axis(0.0, 8.0), y=Axis(0.0, 400.0))
    read = Reading(draw(Chart("a / m", "b / kg", (), backdrop=backdrop), view, 90, 30))
    shaded = np.array(read.marks("█"))
    for place, ends, cell in ((0, (2.0, 6.0), read.x_per_column), (1, (100, 300), read.y_per_row)):
        assert shaded[:, place].min() == pytest.approx(ends[0], abs=1.5 * cell)
        assert shaded[:, place].max() == pytest.approx(ends[1], abs=1.5 * cell)


def test_the_strip_marks_its_intervals_under_their_times() -> None:
    chart = dataclasses.replace(
        function_chart(np.sin, 0.0, 50.0), strip=[(10.0, 20.0), (30.0, 32.5)]
    )
    picture = draw(chart, View(), 88, 20)
    read = Reading(picture)
    strip = read.lines[-2]
    assert strip.startswith("off belt")
    full = [column for column, cell in enumerate(strip[MARGIN:]) if cell == "█"]
    inside = [read.x(column + 0.5) for column in full]
    assert [at for at in inside if at < 25.0] == pytest.approx(
        np.linspace(10.0, 20.0, 17)[:-1] + 0.3, abs=0.7
    )
    assert min(at for at in inside if at > 25.0) >= 30.0 - 0.7
    assert max(inside) <= 32.5 + 0.7
    blank = [read.x(c + 0.5) for c, cell in enumerate(strip[MARGIN:]) if cell == " "]
    assert not any(10.7 < at < 19.3 for at in blank)
    zoomed = Reading(draw(chart, View(x=Axis(28.0, 36.0)), 88, 20))
    marked = [zoomed.x(c + 0.5) for c, cell in enumerate(zoomed.lines[-2][MARGIN:]) if cell == "█"]
    assert min(marked) == pytest.approx(30.0, abs=2 * zoomed.x_per_column)
    assert max(marked) == pytest.approx(32.5, abs=2 * zoomed.x_per_column)


def test_a_hidden_curve_is_struck_out_and_leaves_no_dot() -> None:
    x = np.linspace(0.0, 1.0, 101)
    chart = Chart("t / s", "y / m", (Trace("low", x, 0.0 * x), Trace("high", x, 0.0 * x + 9.0)))
    view = View(y=Axis(-1.0, 10.0))
    assert {round(up) for _, up in Reading(draw(chart, view, 60, 24)).dots()} == {0, 9}
    view.toggle_trace(chart, 1)
    picture = draw(chart, view, 60, 24)
    assert {round(up) for _, up in Reading(picture).dots()} == {0}
    styles = dict(picture.lines[0])
    assert styles[" 2─high"] == "hidden"
    assert styles[" 1─low"] == "trace-1"


def test_the_cursor_stands_at_the_sample_that_it_reads() -> None:
    chart = function_chart(lambda x: 5.0 + 2.0 * x, 10.0, 20.0)
    view = View(cursor=(16.0, 0.0))
    picture = draw(chart, view, 70, 24)
    read = Reading(picture)
    assert picture.text().startswith("x 16  y 37")
    (mark,) = read.marks("◆")
    assert read.near(mark, (16.0, 37.0))
    # The middle of that cell is that place again.
    column = next(c.index("◆") for c in read.cells if "◆" in c)
    row = next(r for r, c in enumerate(read.cells) if "◆" in c)
    across, up = picture.place(MARGIN + column, picture.plot[1] + row)
    x, y = view.axes(chart)
    assert x.value(across) == pytest.approx(16.0, abs=read.x_per_column)
    assert y.value(up) == pytest.approx(37.0, abs=read.y_per_row)


# The motion


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
    made = [plotted_run(run, *name) for run, name in zip(runs, names, strict=True)]
    return [motion for motion in made if motion is not None]


def test_charts_over_time_have_the_quantity_of_their_label(motions: list[PlottedRun]) -> None:
    own = {case: own_slider.motion(3.0, separation=case) for case in (True, False)}
    for quantity, label, column in (
        ("x", "x / m", 0),
        ("vx", "ẋ / m/s", 1),
        ("y", "y / m", 2),
        ("vy", "ẏ / m/s", 3),
        ("P", "P / N", 4),
    ):
        chart = time_chart(quantity, motions, strip=True, x_axis=True)
        assert (chart.x_label, chart.y_label) == ("t / s", label)
        assert chart.x_range == (0.0, 3.0)
        assert [trace.name for trace in chart.traces] == ["run 2", "run 1"]
        assert [trace.mark for trace in chart.traces] == ["●", "■"]
        for trace, case in zip(chart.traces, (False, True), strict=True):
            t, rows = own[case]
            scale = np.abs(rows[:, column]).max()
            np.testing.assert_allclose(
                trace.y, np.interp(trace.x, t, rows[:, column]), rtol=0.0, atol=5e-4 * scale
            )
        (guide,) = chart.guides
        assert (guide.value, guide.vertical) == (0.0, False)
        assert chart.strip is not None
        t, rows = own[True]
        off = [time for time, y in zip(t, rows[:, 2], strict=True) if y > 0.1]
        assert all(any(a < time < b for a, b in chart.strip) for time in off[::20])
        assert sum(b - a for a, b in chart.strip) == pytest.approx(
            float(np.mean(rows[:, 2] > 0.0)) * 3.0, abs=0.01
        )
        assert draw(chart, View(), 80, 20).text().startswith(label)


def test_a_phase_portrait_has_velocity_over_displacement(motions: list[PlottedRun]) -> None:
    for quantity, labels, column in (
        ("y", ("y / m", "ẏ / m/s"), 2),
        ("x", ("x / m", "ẋ / m/s"), 0),
    ):
        chart = phase_chart(quantity, motions, (1.0, 2.0))
        assert (chart.x_label, chart.y_label) == labels
        assert chart.note == "t 1 to 2 s"
        assert [(g.value, g.label, g.vertical) for g in chart.guides] == (
            [(0.0, "y = 0", True)] if quantity == "y" else []
        )
        trace = chart.traces[1]
        assert trace.name == "run 1"
        t, rows = own_slider.motion(3.0, separation=True)
        inside = (t > 1.0 - 1e-9) & (t < 2.0 + 1e-9)
        np.testing.assert_allclose(trace.x, rows[inside, column], atol=2e-3)
        np.testing.assert_allclose(trace.y, rows[inside, column + 1], atol=2e-2)


def test_a_spectrum_has_its_peak_at_the_frequency_in_hertz(motions: list[PlottedRun]) -> None:
    t = np.linspace(0.0, 80.0, 8001)
    y = -0.7 + 0.4 * np.sin(2.0 * np.pi * 1.25 * t) + 0.05 * np.sin(2.0 * np.pi * 2.5 * t)
    first = dataclasses.replace(motions[0].trajectory, t=t, y=y)
    shown = dataclasses.replace(motions[0], trajectory=first, t_end=80.0)
    chart = spectrum_chart([shown], (40.0, 80.0))
    assert (chart.x_label, chart.y_label) == ("f / Hz", "|y| / m")
    assert chart.x_range == pytest.approx((0.0, 10.0), rel=1e-4)
    assert [(g.label, g.vertical) for g in chart.guides] == [
        ("f₁", True),
        ("2f₁", True),
        ("3f₁", True),
    ]
    assert [g.value for g in chart.guides] == pytest.approx([1.25, 2.5, 3.75], rel=1e-4)
    assert chart.note == "f₁ 1.25 Hz, period 0.8 s, t 40 to 80 s"
    (trace,) = chart.traces
    for frequency, amplitude in ((0.0, 0.7), (1.25, 0.4), (2.5, 0.05)):
        near = np.abs(trace.x - frequency) < 0.1
        assert trace.y[near].max() == pytest.approx(amplitude, rel=0.02)
    assert trace.y[(trace.x > 1.4) & (trace.x < 2.3)].max() < 1e-3
    read = Reading(draw(chart, View(log_y=True), 90, 30), log_y=True)
    top = max((dot for dot in read.dots() if dot[0] > 0.6), key=lambda dot: dot[1])
    assert top[0] == pytest.approx(1.25, abs=2 * read.x_per_column)
    assert 10.0 ** top[1] == pytest.approx(0.4, rel=0.6)


def test_a_spectrum_without_vibration_marks_no_frequency(motions: list[PlottedRun]) -> None:
    t = np.linspace(0.0, 1.0, 20)
    still = dataclasses.replace(motions[0].trajectory, t=t, y=np.full(20, -0.7))
    chart = spectrum_chart([dataclasses.replace(motions[0], trajectory=still)], (0.0, 1.0))
    assert (chart.guides, chart.note) == ((), "t 0 to 1 s, no vibration")
    assert chart.traces[0].y[0] == pytest.approx(0.7)


def test_a_difference_is_the_run_minus_its_baseline(motions: list[PlottedRun]) -> None:
    chart = difference_chart("P", motions[0], motions[1], x_axis=True)
    assert (chart.x_label, chart.y_label, chart.note) == ("t / s", "ΔP / N", "run 1 − run 2")
    _, one = own_slider.motion(3.0, separation=True)
    _, other = own_slider.motion(3.0, separation=False)
    (trace,) = chart.traces
    np.testing.assert_allclose(trace.y, one[:, 4] - other[:, 4], atol=0.5)
    assert chart.x_range == (0.0, 3.0)


# The equilibrium


def test_modes_over_mu_are_drawn_in_hertz_and_one_over_seconds() -> None:
    p = Parameters()
    found, scan = stability(p), mode_scan(p, 1.5)
    growth, frequency = growth_chart(scan, p, found), frequency_chart(scan, p, found)
    assert (growth.x_label, growth.y_label) == ("μ", "Re λ / 1/s")
    assert (frequency.x_label, frequency.y_label) == ("μ", "Im λ/2π / Hz")
    assert [trace.name for trace in growth.traces] == ["mode 1", "mode 2"]
    for place in (0, 40, 160):
        mu = growth.traces[0].x[place]
        assert mu == frequency.traces[0].x[place] == pytest.approx(1.5 * place / 240)
        own = own_slider.eigenvalues(mu=float(mu))
        for rate, hertz in zip(growth.traces, frequency.traces, strict=True):
            seen = complex(rate.y[place], 2.0 * np.pi * hertz.y[place])
            assert np.abs(own - seen).min() < 1e-6
    marks = [(own_slider.critical_mu(), "μ_c 0.4394", True), (0.7, "μ 0.7", True)]
    level = (0.0, "", False)
    for chart, expected in ((growth, [level, *marks]), (frequency, marks)):
        for guide, (value, label, vertical) in zip(chart.guides, expected, strict=True):
            assert guide.value == pytest.approx(value, abs=1e-8)
            assert (guide.label, guide.vertical) == (label, vertical)


def test_eigenvalues_lie_in_the_plane_with_growth_to_the_right() -> None:
    p = Parameters()
    chart = plane_chart(stability(p), mode_scan(p, 1.5))
    assert (chart.x_label, chart.y_label) == ("Re λ / 1/s", "Im λ / rad/s")
    path, now = chart.traces
    assert (path.name, now.name) == ("μ 0 to 1.5", "now")
    own = own_slider.eigenvalues()
    np.testing.assert_allclose(
        np.sort_complex((now.y + 1j * now.x).round(7)),
        np.sort_complex((own.imag + 1j * own.real).round(7)),
        atol=2e-7,
    )
    for value in own_slider.eigenvalues(mu=0.0):
        assert np.abs(path.x + 1j * path.y - value).min() < 1e-6
    read = Reading(draw(chart, View(), 90, 40))
    marks = read.marks("◆")
    assert len(marks) == 4
    for value in own:
        assert any(read.near(mark, (value.real, value.imag)) for mark in marks)
    assert any("unstable →" in cells for cells in read.cells)


def number_of(text: str) -> float:
    return float(re.findall(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?", text)[0])


def test_rows_of_the_equilibrium_say_what_they_are() -> None:
    rows = {row.label: row for row in stability_rows(stability(Parameters()))}
    x, y, force = own_slider.equilibrium()
    own = own_slider.eigenvalues()
    upper = sorted((v for v in own.tolist() if v.imag > 0.0), key=lambda v: v.imag)
    expected = {
        "growth rate": (own.real.max(), "1/s"),
        "critical μ": (own_slider.critical_mu(), "(unstable above)"),
        "critical μ, linear": (own_slider.critical_mu(k_nl=0.0), ""),
        "equilibrium x": (x, "m"),
        "equilibrium y": (y, "m"),
        "contact force": (force, "N"),
    }
    for label, (value, unit) in expected.items():
        assert number_of(rows[label].value) == pytest.approx(value, rel=5e-4), label
        assert rows[label].value.endswith(unit)
    assert rows["verdict"].value == "UNSTABLE"
    doubling = np.log(2.0) / own.real.max()
    assert rows["growth rate"].note == f"amplitude doubles every {doubling:.4g} s"
    for number in (1, 2):
        eigenvalue, mode = rows[f"eigenvalue {number}"], rows[f"mode {number}"]
        real, imaginary = map(
            float, re.findall(r"[-+]?\d+\.\d+", eigenvalue.value.replace("± ", ""))
        )
        (match,) = [
            v for v in upper if abs(v.real - real) < 1e-5 and abs(v.imag - imaginary) < 1e-4
        ]
        assert eigenvalue.value.endswith("1/s")
        damping = number_of(mode.note)
        match = min(upper, key=lambda v: abs(-v.real / abs(v) - damping))
        assert damping == pytest.approx(-match.real / abs(match), rel=5e-3)
        assert number_of(mode.value) == pytest.approx(match.imag / (2.0 * np.pi), rel=1e-5)
        assert mode.value.endswith(" Hz")
    # At μ = 0.7 the modes of the base scene have merged; below they are apart.
    low = Parameters(mu=0.2)
    apart = {row.label: row for row in stability_rows(stability(low))}["frequency distance"]
    free = [v.imag for v in own_slider.eigenvalues(mu=0.2, c1=0.0, c2=0.0).tolist() if v.imag > 0]
    assert number_of(apart.value) == pytest.approx(abs(free[0] - free[1]) / 2 / np.pi, rel=1e-3)
    assert apart.value.endswith(" Hz")


def test_the_verdict_in_brief_has_its_numbers_and_units() -> None:
    p = Parameters()
    first, second, third, fourth = stability_brief(stability(p))
    own = own_slider.eigenvalues()
    leading = max((v for v in own.tolist() if v.imag > 0.0), key=lambda v: v.real)
    rate, hertz = f"{leading.real:+.4g} 1/s", f"{leading.imag / 2 / np.pi:.4g} Hz"
    assert first.startswith("UNSTABLE")
    assert rate in first
    assert hertz in first
    above = 100.0 * (0.7 / own_slider.critical_mu() - 1.0)
    assert "0.4394" in second
    assert f"{above:.3g} % above" in second
    x, y, force = own_slider.equilibrium()
    for part, value, unit in (("x_e", x, "m"), ("y_e", y, "m"), ("P_e", force, "N")):
        found = re.search(rf"{part} (\S+) {unit}\b", third)
        assert found is not None
        assert float(found[1]) == pytest.approx(value, rel=5e-4)
    assert hertz in fourth
    calm = Parameters(mu=0.2)
    brief = stability_brief(stability(calm))
    assert brief[0].startswith("STABLE")
    assert f"{100.0 * (1.0 - 0.2 / own_slider.critical_mu()):.3g} % below" in brief[1]


# What came out of a run


def test_rows_of_a_run_say_what_they_are(runs: tuple[Transient, Transient]) -> None:
    rows = transient_rows(runs[0], "asked")
    t, own = own_slider.motion(3.0, separation=True)
    x, vx, y, vy, force = own.T
    second = y[t >= 1.5]
    units = {"m": 2e-3, "m/s": 5e-3, "N": 5e-3, "s": 5e-3}
    expected = {
        "peak |y|": (np.abs(y).max(), "m"),
        "peak |x|": (np.abs(x).max(), "m"),
        "max ẋ": (vx.max(), "m/s"),
        "final x": (x[-1], "m"),
        "final ẋ": (vx[-1], "m/s"),
        "final y": (y[-1], "m"),
        "final ẏ": (vy[-1], "m/s"),
    }
    by_label = {row.label: row for row in rows}
    for label, (value, unit) in expected.items():
        assert number_of(by_label[label].value) == pytest.approx(value, rel=units[unit]), label
        assert by_label[label].value.split()[-1] == unit
    (half,) = [row for row in rows if "half" in row.label]
    assert number_of(half.value) == pytest.approx(0.5 * np.ptp(second), rel=2e-3)
    low, high = by_label["range of y"].value.split(" to ")
    assert (float(low), number_of(high)) == pytest.approx((y.min(), y.max()), rel=2e-3)
    low, high = by_label["contact force"].value.split(" to ")
    assert float(low) == pytest.approx(0.0, abs=1e-9)
    assert number_of(high) == pytest.approx(force.max(), rel=2e-3)
    assert high.endswith(" N")
    changes_ = t[1:][np.diff(y > 0.0)]
    lifted = int((np.diff((y > 0.0).astype(int)) > 0).sum())
    assert number_of(by_label["first switch"].value) == pytest.approx(changes_[0], abs=5e-3)
    assert number_of(by_label["last switch"].value) == pytest.approx(changes_[-1], abs=5e-3)
    assert by_label["reattachments"].value == str(changes_.size - lifted)
    off = float(np.mean(y > 0.0))
    assert by_label["separations"].value == str(lifted)
    time = by_label["time off the belt"]
    assert time.value.endswith(" s")
    assert number_of(time.value) == pytest.approx(3.0 * off, rel=2e-2)
    assert number_of(time.note) == pytest.approx(100.0 * off, rel=2e-2)
    assert time.note.endswith("% of the run")
    assert by_label["method"] == ("method", "taylor", "asked")
    assert by_label["steps"].value == str(runs[0].stats.steps)


def test_a_run_in_brief_has_its_numbers_and_units(runs: tuple[Transient, Transient]) -> None:
    t, own = own_slider.motion(3.0, separation=True)
    first, _, third, fourth = result_brief(runs[0])
    peak, steady = first.split(" · ")
    assert number_of(peak.replace("|y|", "")) == pytest.approx(np.abs(own[:, 2]).max(), rel=2e-3)
    assert peak.endswith(" m")
    half = 0.5 * np.ptp(own[t >= 1.5, 2])
    assert number_of(steady.partition("±")[2]) == pytest.approx(half, rel=2e-3)
    assert re.search(r"\d m\b", steady)
    force, across = third.split(" · ")
    assert number_of(force.partition(" to ")[2]) == pytest.approx(own[:, 4].max(), rel=2e-3)
    assert force.endswith(" N")
    assert number_of(across.partition("|x| ")[2]) == pytest.approx(
        np.abs(own[:, 0]).max(), rel=2e-3
    )
    assert number_of(fourth) == pytest.approx(own[:, 1].max(), rel=5e-3)
    assert fourth.endswith(" m/s")


def test_a_run_beside_a_baseline_has_differences_of_the_same_figures(
    runs: tuple[Transient, Transient],
) -> None:
    one, other = (own_slider.motion(3.0, separation=case)[1] for case in (True, False))
    found = {change.label: change for change in changes(*runs)}
    figures: Sequence[tuple[str, str, Callable[[FloatArray], Any]]] = (
        ("peak |y|", "m", lambda r: np.abs(r[:, 2]).max()),
        ("peak |x|", "m", lambda r: np.abs(r[:, 0]).max()),
        ("contact force max", "N", lambda r: r[:, 4].max()),
        ("max ẋ", "m/s", lambda r: r[:, 1].max()),
        ("final x", "m", lambda r: r[-1, 0]),
        ("final ẋ", "m/s", lambda r: r[-1, 1]),
        ("final y", "m", lambda r: r[-1, 2]),
        ("final ẏ", "m/s", lambda r: r[-1, 3]),
    )
    for label, unit, of in figures:
        change = found[label]
        assert change.unit == unit
        assert (change.value, change.baseline) == pytest.approx(
            (float(of(one)), float(of(other))), rel=5e-3
        )
        assert change.difference == change.value - change.baseline
        assert float(percent_text(change)) == pytest.approx(
            100.0 * (change.value - change.baseline) / abs(change.baseline), rel=6e-3
        )
    (half,) = [change for label, change in found.items() if "half" in label]
    assert half.value == pytest.approx(0.5 * np.ptp(one[750:, 2]), rel=5e-3)
    row = next(row for row in change_rows(*runs) if row.label == "peak |y|")
    assert number_of(row.value) == pytest.approx(found["peak |y|"].difference, rel=1e-3)
    assert row.note.startswith("from ")
    assert number_of(row.note) == pytest.approx(found["peak |y|"].baseline, rel=1e-3)


# Sweeps, maps, trade-offs


def test_a_sweeps_chart_has_every_output_and_case_under_its_name() -> None:
    result = made_up({"F": (80.0, 20.0, 50.0)}, ("x_abs", "y_half_range", "y_abs"))
    points = points_of(result)
    chart = sweep_chart(points, 33.0)
    assert chart.x_label == "F / N"
    assert chart.y_label.endswith("/ m")
    assert len({trace.mark for trace in chart.traces}) == len(chart.traces) == 4
    for index, trace in enumerate(chart.traces):
        what, case = trace.name.rsplit(" ", 1)
        place = 2 if what == "peak" else 1
        assert trace.x.tolist() == [20.0, 50.0, 80.0]
        np.testing.assert_allclose(trace.y, output_value(place, case == "considered", trace.x))
        assert case_of(result.study, points, NearestPoint(index, 1.0, 1.0), False) == (
            case == "considered"
        )
    (guide,) = chart.guides
    assert (guide.value, guide.label, guide.vertical) == (33.0, "33", True)
    other = sweep_chart(points_of(made_up({"mu": (0.1, 0.2)}, ("P_max",))), None)
    assert (other.x_label, other.y_label) == ("mu", "greatest contact force / N")
    assert other.guides == ()


def test_a_grid_of_a_sweep_has_its_values_over_its_own_axes() -> None:
    result = made_up({"F": (20.0, 40.0, 60.0), "mu": (0.9, 0.1)}, ("x_abs", "y_abs"))
    for case in (True, False):
        chart = grid_chart(result, case, (30.0, 0.4))
        assert (chart.x_label, chart.y_label) == ("F / N", "mu")
        backdrop = chart.backdrop
        assert backdrop is not None
        assert backdrop.label == "peak of |y| / m"
        assert chart.note.endswith("considered" if case else "ignored")
        assert backdrop.x.tolist() == [20.0, 40.0, 60.0]
        assert backdrop.y.tolist() == [0.1, 0.9]
        for i, force in enumerate((20.0, 40.0, 60.0)):
            for j, mu in enumerate((0.1, 0.9)):
                assert backdrop.values[i, j] == pytest.approx(output_value(1, case, force, mu))
        assert np.all(np.diff(backdrop.levels[:, 0]) >= 0)
        (now,) = chart.traces
        assert (now.x.tolist(), now.y.tolist()) == ([30.0], [0.4])
        found = nearest(chart, View(cursor=(57.0, 0.2)))[0]
        scene = point_scene(result.study, found, case)
        assert (scene.parameters.F, scene.parameters.mu, scene.separation) == (60.0, 0.1, case)
        moved = dataclasses.replace(result.study, start=(0.1, 0.2, -0.3, 0.4), t_end=7.0, tol=1e-6)
        opened = point_scene(moved, found, case)
        assert (opened.start, opened.t_end, opened.tol) == ((0.1, 0.2, -0.3, 0.4), 7.0, 1e-6)


def test_a_map_has_its_values_its_boundary_and_its_point_in_place() -> None:
    mu, force = np.linspace(0.0, 1.5, 31), np.linspace(10.0, 110.0, 5)
    result = stability_map(Parameters(), {"mu": mu, "F": force})
    chart = map_chart(result, Parameters(F=45.0, mu=1.2))
    assert (chart.x_label, chart.y_label) == ("mu", "F / N")
    assert (chart.x_range, chart.y_range) == ((0.0, 1.5), (10.0, 110.0))
    backdrop = chart.backdrop
    assert backdrop is not None
    assert backdrop.label == chart.note == "growth rate / 1/s"
    for i, j in ((2, 1), (20, 4), (29, 0)):
        own = own_slider.growth_rate(mu=float(mu[i]), F=float(force[j]))
        assert backdrop.values[i, j] == pytest.approx(own, abs=1e-7)
        shade = backdrop.shades[backdrop.levels[i, j]]
        assert shade[1] == ("unstable" if own > 0.0 else "stable")
    boundary, now = chart.traces
    for at in force.tolist():
        critical = own_slider.critical_mu(F=at)
        assert np.abs(boundary.x[np.isclose(boundary.y, at)] - critical).min() < 0.05
    assert (now.x.tolist(), now.y.tolist()) == ([1.2], [45.0])
    read = Reading(draw(chart, View(), 90, 30))
    (mark,) = read.marks("◆")
    assert read.near(mark, (1.2, 45.0))
    told = draw(chart, View(cursor=(1.0, 60.0)), 90, 30).text().splitlines()[0]
    rate = own_slider.growth_rate(mu=1.0, F=60.0)
    assert told.split() == ["mu", "1", "F", "60", "growth", "rate", f"{rate:.5g}", "1/s"]
    texts = point_texts(result, NearestPoint(-1, 0.65, 85.0))
    assert (texts["mu"], texts["F"], texts["k1"]) == ("0.65", "85", "100")
    modes = map_chart(stability_map(Parameters(), {"mu": mu, "F": force}, "unstable-modes"), None)
    assert modes.note == "unstable modes"
    critical_map = map_chart(
        stability_map(Parameters(), {"k_nl": np.array([500.0, 50.0]), "F": force}, "critical-mu"),
        None,
    )
    assert (critical_map.x_label, critical_map.note) == ("k_nl / N/m^3", "μ_c")
    assert critical_map.backdrop is not None
    assert critical_map.backdrop.x.tolist() == [50.0, 500.0]
    assert critical_map.backdrop.values[0, 4] == pytest.approx(
        own_slider.critical_mu(k_nl=50.0, F=110.0), abs=1e-8
    )


def test_a_trade_off_has_errors_over_seconds_and_rows_in_milliseconds() -> None:
    rows = [
        MeasuredSetting(
            Setting("taylor", "", "tol", 1e-6), 0.02, 17, Deviation(1e-6, 2e-7, 3e-8, 4e-5, 2)
        ),
        MeasuredSetting(
            Setting("rk4", "", "tol", 1e-6), 0.3, 17, Deviation(5e-4, 6e-5, 7e-6, 8e-3, 2)
        ),
    ]
    floor = Deviation(1e-13, 2e-14, 3e-15, 4e-12, 0)
    result = Tradeoff(PRESETS["base"], None, floor, rows, [])
    for name, label in (
        ("final", "error of final state / 1"),
        ("peak", "error of peak / 1"),
        ("half_range", "error of half range / 1"),
        ("events", "error of events / s"),
    ):
        chart = tradeoff_chart(result, name, rows[0])
        assert chart.x_label == "CPU time / s"
        if name != "half_range":
            assert chart.y_label == label
        assert [trace.name for trace in chart.traces] == ["taylor", "rk4", "now"]
        for trace, source in zip(chart.traces, (*rows, rows[0]), strict=True):
            assert trace.x.tolist() == [source.cpu_s]
            assert trace.y.tolist() == [getattr(source.error, name)]
        (guide,) = chart.guides
        assert (guide.value, guide.vertical) == (getattr(floor, name), False)
        table = table_rows(result, name, rows[1])
        assert [line[:4] for line in table] == [
            ("taylor", "tol=1e-06", "20", "17"),
            ("rk4", "tol=1e-06", "300", "17"),
        ]
        assert [float(line[4]) for line in table] == [
            pytest.approx(getattr(source.error, name)) for source in rows
        ]
        assert [line[5:] for line in table] == [("+2", "best"), ("+2", "now")]
