"""Chart sheets: axis labels beside the axes, and the legend below.

A sheet is a list of columns, each a list of charts from top to bottom.
"""

import numpy as np
import pytest

from fivtui.charts import Chart, Sheet, Trace
from fivtui.charts.sheet import sheet_figure

X = np.linspace(0.0, 1.0, 11)


def line_chart(label: str, *names: str) -> Chart:
    return Chart("t (s)", label, tuple(Trace(name, X, X) for name in names))


def test_axis_labels_lie_beside_their_charts_if_one_column_has_more_charts() -> None:
    figure = sheet_figure(
        Sheet([[line_chart("a", "x")], [line_chart("b"), line_chart("c")]], (7.2, 4.4))
    )
    figure.draw_without_rendering()
    left_axes, *right = figure.axes
    for axes in right:
        assert axes.yaxis.label.get_window_extent().x0 > left_axes.get_window_extent().x1


# The width has room for three columns: 4 names need two rows, for which two columns are enough.
@pytest.mark.parametrize(("count", "columns"), [(1, 1), (3, 3), (4, 2), (7, 3)])
def test_a_legend_has_as_few_columns_as_its_rows_allow(count: int, columns: int) -> None:
    names = [f"a name of some length {number}" for number in range(count)]
    (legend,) = sheet_figure(Sheet([[line_chart("y (m)", *names)]], (7.2, 3.0))).legends
    assert legend._ncols == columns  # type: ignore[attr-defined]
