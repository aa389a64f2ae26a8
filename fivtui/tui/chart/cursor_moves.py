"""Positions and moves of the cursors of a chart. Imports no Textual.

The active cursor is the one that keys move. Usually it stands at a sample of x. In a plane, where y
is no function of x, it stands at a point; along a curve it stands at a value, such as a time. Axis
positions run from 0 to 1 over the visible part of an axis. A cursor without position is off. Keys
and clicks move pinned cursors; a cursor that is not pinned follows the pointer. A map is a chart
with a backdrop: values over the plane, drawn as shades.
"""

from typing import Final

from fivtui.charts import (
    Chart,
    Position,
    Trace,
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
            _place_cursor(chart, view, _INITIAL_POSITIONS[is_second])


def _place_cursor(chart: Chart, view: View, initial_position: float) -> None:
    trace = _top_curve(chart, view)
    if trace is None:
        move_cursor(chart, view, (initial_position, 0.5))
    elif trace.curve_values is not None:
        index = int(initial_position * (trace.curve_values.size - 1))
        view.cursors.move((float(trace.curve_values[index]), 0.0))


def _top_curve(chart: Chart, view: View) -> Trace | None:
    # The topmost visible curve: keys move cursors along it.
    if not chart.curve_label:
        return None
    curves = [trace for _, trace in view.visible_traces(chart) if trace.curve_values is not None]
    return curves[-1] if curves and curves[-1].x.size else None


def cursor_position(chart: Chart, view: View) -> Position | None:
    """Axis positions of the active cursor; None if it is off."""
    position = view.cursors.active_position
    if position is None:
        return None
    if chart.is_plane or chart.curve_label:
        points = points_at(chart, view, position)
        if chart.curve_label and not points:
            return None
        # The cursor stands at the point of the topmost trace, which is the last one.
        position = crosshair(chart, position, points[-1:])
    x, y = view.axes(chart)
    return float(x.positions([position[0]])[0]), float(y.positions([position[1]])[0])


def move_cursor(chart: Chart, view: View, position: Position, direction: int = 0) -> None:
    """Move the active cursor to the sample or point nearest to a pair of axis positions.

    If `direction` is not 0, the cursor moves at least to the next sample in this direction.
    """
    x, y = view.axes(chart)
    point = (x.value(position[0]), y.value(position[1]))
    if chart.curve_label:
        curve_value = nearest_curve_value(chart, view, point)
        if curve_value is None:
            return
        point = (curve_value, 0.0)
    elif chart.is_plane:
        point = crosshair(chart, point, points_at(chart, view, point))
    else:
        point = (_nearest_sample_x(chart, view, point[0], direction), point[1])
    view.cursors.move(point)


def _nearest_sample_x(chart: Chart, view: View, x: float, direction: int) -> float:
    # x of the nearest sample of the topmost trace; with a direction, at least the next sample.
    traces = [trace for _, trace in view.visible_traces(chart) if trace.x.size]
    if not traces:
        return x
    values, old_position = traces[-1].x, view.cursors.active_position
    index = nearest_index(values, x)
    if direction and old_position is not None and float(values[index]) == old_position[0]:
        index = min(max(index + (1 if direction > 0 else -1), 0), values.size - 1)
    return float(values[index])


def step_cursor(chart: Chart, view: View, step: tuple[int, int], size: tuple[int, int]) -> bool:
    """Move the active cursor by cells to the right and up; returns whether the plot panned.

    `size` is the number of columns and rows of the plot.
    """
    right, up = step
    trace = _top_curve(chart, view)
    if trace is not None:
        _step_along_curve(view, trace, right)
        return False
    position = cursor_position(chart, view)
    if position is None:
        return False
    change = right / size[0], up / size[1]
    new_x, new_y = position[0] + change[0], position[1] + change[1]
    if chart.is_plane:
        new_x, new_y = _next_point(chart, view, position, change)
    is_outside = not 0.0 <= new_x <= 1.0
    if is_outside:
        # Pan the plot to keep the cursor visible.
        view.pan(chart, change[0])
    move_cursor(chart, view, (min(max(new_x, 0.0), 1.0), min(max(new_y, 0.0), 1.0)), right)
    return is_outside


def _next_point(chart: Chart, view: View, position: Position, change: Position) -> Position:
    # Step until the nearest point changes. If it does not, keep the position; on a map, return the
    # position outside, so that the plot pans.
    x, y = view.axes(chart)

    def nearest(new_x: float, new_y: float) -> list[Position]:
        # Positions only: a value that is NaN would differ from itself.
        points = points_at(chart, view, (x.value(new_x), y.value(new_y)))
        return [(point.x, point.y) for point in points]

    old_points = nearest(*position)
    new_x, new_y = position
    while 0.0 <= new_x <= 1.0 and 0.0 <= new_y <= 1.0:
        new_x, new_y = new_x + change[0], new_y + change[1]
        if nearest(new_x, new_y) != old_points:
            return new_x, new_y
    return position if chart.backdrop is None else (new_x, new_y)


def _step_along_curve(view: View, trace: Trace, cells: int) -> None:
    position = view.cursors.active_position
    if trace.curve_values is not None and position is not None:
        step = cells * max(trace.curve_values.size // _STEPS_PER_CURVE, 1)
        index = nearest_index(trace.curve_values, position[0]) + step
        index = min(max(index, 0), trace.curve_values.size - 1)
        view.cursors.move((float(trace.curve_values[index]), 0.0))
