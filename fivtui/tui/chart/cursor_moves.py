"""Positions and moves of the cursors of a chart. Imports no Textual.

The active cursor is the one that keys move. Usually it stands at a sample of x. In a plane, where y
is no function of x, it stands at a point; along a curve it stands at a value, such as a time. Axis
positions run from 0 to 1 over the visible part of an axis. A cursor without position is off. Keys
and clicks move pinned cursors; a cursor that is not pinned follows the pointer. A map is a chart
with a backdrop: values over the plane, drawn as shades.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.charts import (
    Chart,
    Position,
    View,
    crosshair,
    nearest_curve_value,
    nearest_index,
    points_at,
)

# Number of key presses from one end of a curve to the other.
_STEPS_PER_CURVE: Final = 500
# Initial positions of both cursors along the x axis or the curve.
_INITIAL_POSITIONS: Final = (0.5, 0.75)


def switch_cursor(chart: Chart, view: View, *, second: bool) -> None:
    """Make a cursor active, and switch it on if it is off; if it is active, switch it off.

    The second cursor also switches the first one on.
    """
    cursors = view.cursors
    position = cursors.second if second else cursors.first
    if cursors.pinned and position is not None and cursors.second_is_active is second:
        # Remove the active cursor; the other cursor, if it is on, becomes active.
        cursors.move(None)
        cursors.second_is_active = cursors.second is not None
        cursors.pinned = cursors.active_position is not None
        return
    cursors.pinned = True
    for is_second in (False, True) if second else (False,):
        cursors.second_is_active = is_second
        if cursors.active_position is None:
            initial_position, values = _INITIAL_POSITIONS[is_second], _curve_values(chart, view)
            if values is None:
                move_cursor(chart, view, (initial_position, 0.5))
            else:
                cursors.move((float(values[int(initial_position * (values.size - 1))]), 0.0))


def _curve_values(chart: Chart, view: View) -> NDArray[np.float64] | None:
    # Values of the topmost visible curve, along which keys move cursors.
    if not chart.curve_label:
        return None
    curves = [trace.curve_values for _, trace in view.visible_traces(chart)]
    return next((values for values in reversed(curves) if values is not None and values.size), None)


def cursor_position(chart: Chart, view: View) -> Position | None:
    """Axis positions of the active cursor; None if it is off."""
    position = view.cursors.active_position
    points = points_at(chart, view, position)
    if position is None or (chart.curve_label and not points):
        return None
    # The cursor stands at the point of the topmost trace, which is the last one.
    position = crosshair(chart, position, points[-1:])
    x, y = view.axes(chart)
    return float(x.positions(position[0])), float(y.positions(position[1]))


def move_cursor(chart: Chart, view: View, position: Position) -> None:
    """Move the active cursor to the sample or point nearest to a pair of axis positions."""
    x, y = view.axes(chart)
    cursor = _snap(chart, view, (x.value(position[0]), y.value(position[1])))
    if cursor is not None:
        view.cursors.move(cursor)


def _snap(chart: Chart, view: View, point: Position) -> Position | None:
    # The position of a cursor nearest to a point (x, y); None without a curve to move along.
    if chart.curve_label:
        curve_value = nearest_curve_value(chart, view, point)
        return None if curve_value is None else (curve_value, 0.0)
    points = points_at(chart, view, point)
    if points and not chart.is_plane:
        # The nearest sample of the topmost trace, which is the last one.
        return points[-1].x, point[1]
    return crosshair(chart, point, points)


def step_cursor(chart: Chart, view: View, step: tuple[int, int], size: tuple[int, int]) -> bool:
    """Move the active cursor by cells to the right and up; returns whether the plot panned.

    `size` is the number of columns and rows of the plot.
    """
    values, cursor = _curve_values(chart, view), view.cursors.active_position
    if values is not None and cursor is not None:
        step_size = max(values.size // _STEPS_PER_CURVE, 1)
        index = nearest_index(values, cursor[0]) + step[0] * step_size
        view.cursors.move((float(values[min(max(index, 0), values.size - 1)]), 0.0))
        return False
    position = cursor_position(chart, view)
    if position is None:
        return False
    x, y = view.axes(chart)
    change = step[0] / size[0], step[1] / size[1]
    # Step until the cursor would be elsewhere.
    new_x, new_y = position
    old_cursor = new_cursor = _snap(chart, view, (x.value(new_x), y.value(new_y)))
    while new_cursor == old_cursor and 0.0 <= new_x <= 1.0 and 0.0 <= new_y <= 1.0:
        new_x, new_y = new_x + change[0], new_y + change[1]
        new_cursor = _snap(chart, view, (x.value(new_x), y.value(new_y)))
    if new_cursor == old_cursor and chart.is_plane and chart.backdrop is None:
        # No point is in this direction; maps pan, because they are computed where they are shown.
        return False
    is_outside = not 0.0 <= new_x <= 1.0
    if is_outside:
        # Pan the plot to keep the cursor visible.
        view.pan(chart, change[0])
    move_cursor(chart, view, (min(max(new_x, 0.0), 1.0), min(max(new_y, 0.0), 1.0)))
    return is_outside
