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
    reading = Reading(draw(chart, View(), 70, 24))
    dots = reading.dots()
    dot_x = np.array([x for x, _ in dots])
    assert dot_x.min() == pytest.approx(10.0, abs=2 * reading.x_per_column)
    assert dot_x.max() == pytest.approx(20.0, abs=2 * reading.x_per_column)
    # No slope exceeds 4 m/s.
    change_per_column = 4.0 * reading.x_per_column
    for x, y in dots:
        assert y == pytest.approx(
            function(np.array(x)), abs=1.6 * reading.y_per_row + change_per_column
        )
    columns = {round(x / reading.x_per_column) for x, _ in dots}
    assert len(columns) > 55


def test_logarithmic_scales_straighten_powers() -> None:
    x = np.geomspace(1e-3, 1e2, 400)
    chart = Chart("x (s)", "y / 1", (Trace("", x, 2e3 * x**-1.5),))
    reading = Reading(draw(chart, View(log_x=True, log_y=True), 80, 30), log_x=True, log_y=True)
    for log_x, log_y in reading.dots():
        expected = np.log10(2e3) - 1.5 * log_x
        assert log_y == pytest.approx(
            expected, abs=1.6 * (reading.y_per_row + 1.5 * reading.x_per_column)
        )
    assert min(log_x for log_x, _ in reading.dots()) == pytest.approx(
        -3.0, abs=2 * reading.x_per_column
    )
    assert max(log_x for log_x, _ in reading.dots()) == pytest.approx(
        2.0, abs=2 * reading.x_per_column
    )


def test_points_lines_and_guides_are_drawn_at_their_coordinates() -> None:
    point = Trace("now", np.array([7.0]), np.array([210.0]), look="points", ordered=False, mark="◆")
    line = Trace("line", np.array([5.0, 9.0]), np.array([100.0, 400.0]), ordered=False)
    guides = (Guide(6.0, "at six"), Guide(300.0, "three hundred", vertical=False))
    reading = Reading(draw(Chart("a (N)", "b (m)", (line, point), guides=guides), View(), 80, 30))
    (mark,) = reading.marks("◆")
    assert reading.near(mark, (7.0, 210.0))
    for middle in ((6.5, 212.5), (8.0, 325.0)):
        assert any(reading.near(dot, middle) for dot in reading.dots())
    assert not any(reading.near(dot, (5.0, 350.0)) for dot in reading.dots())
    vertical = [position for position in reading.marks("│") if position[1] < 290.0]
    assert vertical
    assert all(abs(position[0] - 6.0) <= 1.1 * reading.x_per_column for position in vertical)
    horizontal = reading.marks("─")
    assert len(horizontal) > 40
    assert all(abs(position[1] - 300.0) <= 1.1 * reading.y_per_row for position in horizontal)
    (label_row,) = [row for row, cells in enumerate(reading.cells) if "three hundred" in cells]
    assert reading.y(label_row + 0.5) == pytest.approx(300.0, abs=1.1 * reading.y_per_row)
    (label_column,) = [cells.index("at six") for cells in reading.cells if "at six" in cells]
    assert reading.x(label_column - 0.5) == pytest.approx(6.0, abs=1.1 * reading.x_per_column)


def test_only_the_latest_points_of_a_long_orbit_are_joined() -> None:
    # 20 distant corners, then many equal points, and two joined points at the end.
    x = np.concatenate([np.tile([0.0, 10.0], 10), np.full(MAX_JOINED_SAMPLES - 2, 2.0), [2.0, 8.0]])
    y = np.concatenate([np.tile([0.0, 10.0], 10), np.full(MAX_JOINED_SAMPLES - 2, 9.0), [9.0, 9.0]])
    chart = Chart("a (m)", "b (m)", (Trace("", x, y, ordered=False),), x_margins=True)
    reading = Reading(draw(chart, View(), 80, 30))
    dots = reading.dots()
    assert any(reading.near(dot, (5.0, 9.0)) for dot in dots)
    assert not any(reading.near(dot, (5.0, 5.0)) for dot in dots)
    for corner in ((0.0, 0.0), (10.0, 10.0)):
        assert any(reading.near(dot, corner) for dot in dots)


def test_shades_agree_with_their_axes() -> None:
    x, y = np.linspace(0.0, 10.0, 41), np.linspace(100.0, 300.0, 31)
    levels = ((x[:, None] > 6.0) & (y[None, :] < 160.0)).astype(np.intp)
    shades = (Shade(" ", "plot"), Shade("█", "plot"))
    backdrop = Backdrop(x, y, levels, shades, np.add.outer(x, y), "sum (N)")
    chart = Chart("a (m)", "b (kg)", (), backdrop=backdrop)
    reading = Reading(draw(chart, View(), 80, 30))
    shaded = reading.marks("█")
    # Within about a spacing of the values and a character cell.
    assert min(x for x, _ in shaded) == pytest.approx(6.0, abs=0.3 + reading.x_per_column)
    assert max(x for x, _ in shaded) == pytest.approx(10.0, abs=0.3 + reading.x_per_column)
    assert max(y for _, y in shaded) == pytest.approx(160.0, abs=8.0 + reading.y_per_row)
    assert min(y for _, y in shaded) == pytest.approx(100.0, abs=8.0 + reading.y_per_row)
    heading = draw(chart, View(cursors=Cursors((7.6, 199.0))), 80, 30).text()
    assert heading.startswith("b (kg) a 7.5 m  b 200 kg  sum 207.5 N")


def test_coarse_shades_fill_their_range_to_its_ends_and_nothing_beyond() -> None:
    x, y, levels = np.array([2.0, 4.0, 6.0]), np.array([100.0, 200.0, 300.0]), np.zeros((3, 3))
    backdrop = Backdrop(x, y, levels.astype(np.intp), (Shade("█", "plot"),), levels, "one")
    view = View(x=Axis(0.0, 8.0), y=Axis(0.0, 400.0))
    reading = Reading(draw(Chart("a (m)", "b (kg)", (), backdrop=backdrop), view, 90, 30))
    shaded = np.array(reading.marks("█"))
    for axis, ends, cell in (
        (0, (2.0, 6.0), reading.x_per_column),
        (1, (100, 300), reading.y_per_row),
    ):
        assert shaded[:, axis].min() == pytest.approx(ends[0], abs=1.5 * cell)
        assert shaded[:, axis].max() == pytest.approx(ends[1], abs=1.5 * cell)


def test_the_strip_marks_its_intervals_under_their_times() -> None:
    off_belt = Strip("off belt", "off the belt", [(10.0, 20.0), (30.0, 32.5)])
    chart = dataclasses.replace(function_chart(np.sin, 0.0, 50.0), strips=(off_belt,))
    picture = draw(chart, View(), 88, 20)
    reading = Reading(picture)
    strip = reading.lines[-2]
    assert strip.startswith("off belt")
    full_columns = [column for column, cell in enumerate(strip[MARGIN:]) if cell == "█"]
    full_times = [reading.x(column + 0.5) for column in full_columns]
    # The interval of 10 s fills 16 columns of 0.625 s; compare their centres, to about a column.
    assert [t for t in full_times if t < 25.0] == pytest.approx(
        np.linspace(10.0, 20.0, 17)[:-1] + 0.3, abs=0.7
    )
    assert min(t for t in full_times if t > 25.0) >= 30.0 - 0.7
    assert max(full_times) <= 32.5 + 0.7
    blank_times = [reading.x(c + 0.5) for c, cell in enumerate(strip[MARGIN:]) if cell == " "]
    assert not any(10.7 < t < 19.3 for t in blank_times)
    zoomed = Reading(draw(chart, View(x=Axis(28.0, 36.0)), 88, 20))
    zoomed_times = [
        zoomed.x(c + 0.5) for c, cell in enumerate(zoomed.lines[-2][MARGIN:]) if cell == "█"
    ]
    assert min(zoomed_times) == pytest.approx(30.0, abs=2 * zoomed.x_per_column)
    assert max(zoomed_times) == pytest.approx(32.5, abs=2 * zoomed.x_per_column)


def test_a_hidden_curve_is_struck_out_in_the_legend_and_has_no_dots() -> None:
    x = np.linspace(0.0, 1.0, 101)
    chart = Chart("t (s)", "y (m)", (Trace("low", x, 0.0 * x), Trace("high", x, 0.0 * x + 9.0)))
    view = View(y=Axis(-1.0, 10.0))
    assert {round(y) for _, y in Reading(draw(chart, view, 60, 24)).dots()} == {0, 9}
    view.toggle_trace(chart, 1)
    picture = draw(chart, view, 60, 24)
    assert {round(y) for _, y in Reading(picture).dots()} == {0}
    styles = dict(picture.lines[0])
    assert styles[" 2─high"] == "hidden trace(2)"
    assert styles[" 1─low"] == "series-1 trace(1)"


def test_a_cursor_is_drawn_at_the_sample_whose_values_it_displays() -> None:
    chart = function_chart(lambda x: 5.0 + 2.0 * x, 10.0, 20.0)
    view = View(cursors=Cursors((16.0, 0.0)))
    picture = draw(chart, view, 70, 24)
    reading = Reading(picture)
    assert picture.text().startswith("y (m) x 16 s  y 37 m")
    (mark,) = reading.marks("◆")
    assert reading.near(mark, (16.0, 37.0))
    # The centre of the mark's cell maps back to the cursor's position.
    column = next(cells.index("◆") for cells in reading.cells if "◆" in cells)
    row = next(row for row, cells in enumerate(reading.cells) if "◆" in cells)
    position = picture.axis_positions(MARGIN + column, picture.plot_area.top_row + row)
    assert position is not None
    x, y = view.axes(chart)
    assert x.value(position[0]) == pytest.approx(16.0, abs=reading.x_per_column)
    assert y.value(position[1]) == pytest.approx(37.0, abs=reading.y_per_row)
