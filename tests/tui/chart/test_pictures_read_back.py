"""Pictures of charts: positions of curves, guides and shades, by the tick labels."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from fivtui.charts.axis import Axis
from fivtui.charts.chart import (
    MAX_JOINED_SAMPLES,
    Backdrop,
    Chart,
    Cursors,
    Guide,
    Strip,
    Trace,
    View,
)
from fivtui.charts.shades import Shade
from fivtui.tui.chart.picture import MARGIN, draw
from tests.support.reading_charts import Reading

FloatArray = NDArray[np.float64]


def function_chart(y: Callable[[FloatArray], FloatArray], low: float, high: float) -> Chart:
    x = np.linspace(low, high, 501)
    return Chart("x (s)", "y (m)", (Trace("", x, y(x)),))


@pytest.mark.parametrize(
    "function",
    [lambda x: 5.0 + 2.0 * x, lambda x: 40.0 - 3.0 * x, lambda x: 10.0 + 4.0 * np.sin(0.7 * x)],
)
def test_a_curve_agrees_with_the_tick_labels(function: Callable[[FloatArray], FloatArray]) -> None:
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
    chart = Chart("x (s)", "y / 1", (Trace("", x, 2e3 * x**-1.5),))
    read = Reading(draw(chart, View(log_x=True, log_y=True), 80, 30), log_x=True, log_y=True)
    for at, up in read.dots():
        expected = np.log10(2e3) - 1.5 * at
        assert up == pytest.approx(expected, abs=1.6 * (read.y_per_row + 1.5 * read.x_per_column))
    assert min(at for at, _ in read.dots()) == pytest.approx(-3.0, abs=2 * read.x_per_column)
    assert max(at for at, _ in read.dots()) == pytest.approx(2.0, abs=2 * read.x_per_column)


def test_points_guides_and_shades_stand_at_their_coordinates() -> None:
    point = Trace("now", np.array([7.0]), np.array([210.0]), look="points", ordered=False, mark="◆")
    line = Trace("line", np.array([5.0, 9.0]), np.array([100.0, 400.0]), ordered=False)
    guides = (Guide(6.0, "at six"), Guide(300.0, "three hundred", vertical=False))
    read = Reading(draw(Chart("a (N)", "b (m)", (line, point), guides=guides), View(), 80, 30))
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


def test_only_the_latest_points_of_a_long_orbit_are_joined() -> None:
    # First 20 corners far apart, then many points in one place, and two joined points at the end.
    x = np.concatenate([np.tile([0.0, 10.0], 10), np.full(MAX_JOINED_SAMPLES - 2, 2.0), [2.0, 8.0]])
    y = np.concatenate([np.tile([0.0, 10.0], 10), np.full(MAX_JOINED_SAMPLES - 2, 9.0), [9.0, 9.0]])
    chart = Chart("a (m)", "b (m)", (Trace("", x, y, ordered=False),), tight=False)
    read = Reading(draw(chart, View(), 80, 30))
    dots = read.dots()
    assert any(read.near(dot, (5.0, 9.0)) for dot in dots)
    assert not any(read.near(dot, (5.0, 5.0)) for dot in dots)
    for corner in ((0.0, 0.0), (10.0, 10.0)):
        assert any(read.near(dot, corner) for dot in dots)


def test_shades_agree_with_their_axes() -> None:
    x, y = np.linspace(0.0, 10.0, 41), np.linspace(100.0, 300.0, 31)
    levels = ((x[:, None] > 6.0) & (y[None, :] < 160.0)).astype(np.intp)
    shades = (Shade(" ", "plot"), Shade("█", "plot"))
    backdrop = Backdrop(x, y, levels, shades, np.add.outer(x, y), "sum (N)")
    chart = Chart("a (m)", "b (kg)", (), backdrop=backdrop)
    read = Reading(draw(chart, View(), 80, 30))
    shaded = read.marks("█")
    assert min(at for at, _ in shaded) == pytest.approx(6.0, abs=0.3 + read.x_per_column)
    assert max(at for at, _ in shaded) == pytest.approx(10.0, abs=0.3 + read.x_per_column)
    assert max(up for _, up in shaded) == pytest.approx(160.0, abs=8.0 + read.y_per_row)
    assert min(up for _, up in shaded) == pytest.approx(100.0, abs=8.0 + read.y_per_row)
    heading = draw(chart, View(cursors=Cursors((7.6, 199.0))), 80, 30).text()
    assert heading.startswith("a 7.5 m  b 200 kg  sum 207.5 N")


def test_coarse_shades_fill_their_range_to_its_ends_and_nothing_beyond() -> None:
    x, y, levels = np.array([2.0, 4.0, 6.0]), np.array([100.0, 200.0, 300.0]), np.zeros((3, 3))
    backdrop = Backdrop(x, y, levels.astype(np.intp), (Shade("█", "plot"),), levels, "one")
    view = View(x=Axis(0.0, 8.0), y=Axis(0.0, 400.0))
    read = Reading(draw(Chart("a (m)", "b (kg)", (), backdrop=backdrop), view, 90, 30))
    shaded = np.array(read.marks("█"))
    for axis, ends, cell in ((0, (2.0, 6.0), read.x_per_column), (1, (100, 300), read.y_per_row)):
        assert shaded[:, axis].min() == pytest.approx(ends[0], abs=1.5 * cell)
        assert shaded[:, axis].max() == pytest.approx(ends[1], abs=1.5 * cell)


def test_the_strip_marks_its_intervals_under_their_times() -> None:
    off = Strip("off belt", "off the belt", [(10.0, 20.0), (30.0, 32.5)])
    chart = dataclasses.replace(function_chart(np.sin, 0.0, 50.0), strips=(off,))
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
    chart = Chart("t (s)", "y (m)", (Trace("low", x, 0.0 * x), Trace("high", x, 0.0 * x + 9.0)))
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
    view = View(cursors=Cursors((16.0, 0.0)))
    picture = draw(chart, view, 70, 24)
    read = Reading(picture)
    assert picture.text().startswith("x 16 s  y 37 m")
    (mark,) = read.marks("◆")
    assert read.near(mark, (16.0, 37.0))
    # The centre of the mark's cell maps back to the cursor's position.
    column = next(c.index("◆") for c in read.cells if "◆" in c)
    row = next(r for r, c in enumerate(read.cells) if "◆" in c)
    across, up = picture.axis_positions(MARGIN + column, picture.plot_area[1] + row)
    x, y = view.axes(chart)
    assert x.value(across) == pytest.approx(16.0, abs=read.x_per_column)
    assert y.value(up) == pytest.approx(37.0, abs=read.y_per_row)
