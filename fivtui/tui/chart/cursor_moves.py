"""Positions and moves of the cursors of a chart. Imports no Textual."""

from typing import Final

from fivtui.charts import (
    Chart,
    NearestPoint,
    Position,
    Trace,
    View,
    crosshair,
    nearest_along,
    nearest_index,
    nearest_points,
)

# Steps of a cursor along an entire curve, and initial positions of the cursors.
_STEPS: Final = 500
_APPEAR: Final = (0.5, 0.75)


def switch_cursor(chart: Chart, view: View, *, second: bool) -> None:
    """Switch a cursor on, or let keys move it; if they already do, switch it off."""
    cursors = view.cursors
    before = cursors.second if second else cursors.first
    if cursors.pinned and before is not None and cursors.second_moves is second:
        cursors.move(None)
        cursors.second_moves = cursors.second is not None
        cursors.pinned = cursors.moving is not None
        return
    cursors.pinned = True
    for number in (0, 1)[: second + 1]:
        cursors.second_moves = bool(number)
        if cursors.moving is None:
            _appear(chart, view, _APPEAR[number])
    cursors.second_moves = second


def _appear(chart: Chart, view: View, part: float) -> None:
    trace = _top_along(chart, view)
    if trace is None:
        move_cursor(chart, view, (part, 0.5))
    elif trace.curve_values is not None:
        view.cursors.move(
            (float(trace.curve_values[int(part * (trace.curve_values.size - 1))]), 0.0)
        )


def _top_along(chart: Chart, view: View) -> Trace | None:
    # The curve along which keys move a cursor.
    if not chart.curve_label:
        return None
    curves = [trace for _, trace in view.visible_traces(chart) if trace.curve_values is not None]
    return curves[-1] if curves and curves[-1].x.size else None


def cursor_place(chart: Chart, view: View) -> Position | None:
    """Position along the axes, from 0 to 1, of the cursor that keys move."""
    where = view.cursors.moving
    if where is None:
        return None
    if chart.plane or chart.curve_label:
        points = nearest_points(chart, view, where)
        if chart.curve_label and not points:
            return None
        where = crosshair(chart, where, points[-1:])
    x, y = view.axes(chart)
    return float(x.positions([where[0]])[0]), float(y.positions([where[1]])[0])


def move_cursor(chart: Chart, view: View, position: Position, direction: int = 0) -> None:
    """Move the cursor to the readable point nearest to a position along the axes.

    In a direction it moves at least to the next sample.
    """
    x, y = view.axes(chart)
    where = (x.value(position[0]), y.value(position[1]))
    if chart.curve_label:
        at = nearest_along(chart, view, where)
        if at is None:
            return
        where = (at, 0.0)
    elif chart.plane:
        where = crosshair(chart, where, nearest_points(chart, view, where))
    else:
        where = (_sampled(chart, view, where[0], direction), where[1])
    view.cursors.move(where)


def _sampled(chart: Chart, view: View, x: float, direction: int) -> float:
    # The nearest sample of the top trace; in a direction, at least the next one.
    traces = [trace for _, trace in view.visible_traces(chart) if trace.x.size]
    if not traces:
        return x
    values, before = traces[-1].x, view.cursors.moving
    at = nearest_index(values, x)
    if direction and before is not None and float(values[at]) == before[0]:
        at = min(max(at + (1 if direction > 0 else -1), 0), values.size - 1)
    return float(values[at])


def step_cursor(chart: Chart, view: View, step: tuple[int, int], cells: tuple[int, int]) -> bool:
    """Move a cursor by cells of the plot. Returns whether the plot was panned."""
    trace = _top_along(chart, view)
    if trace is not None:
        _step_along(view, trace, step[0])
        return False
    position = cursor_place(chart, view)
    if position is None:
        return False
    change = step[0] / cells[0], step[1] / cells[1]
    across, up = position[0] + change[0], position[1] + change[1]
    if chart.plane:
        across, up = _other_point(chart, view, position, change)
    beyond = not 0.0 <= across <= 1.0
    if beyond:
        # The cursor stays visible.
        view.pan(chart, step[0] / cells[0])
    move_cursor(chart, view, (min(max(across, 0.0), 1.0), min(max(up, 0.0), 1.0)), step[0])
    return beyond


def _other_point(chart: Chart, view: View, position: Position, change: Position) -> Position:
    # Repeat a step until it reaches a different point or leaves a map; else stay.
    x, y = view.axes(chart)

    def points_at(across: float, up: float) -> list[NearestPoint]:
        return nearest_points(chart, view, (x.value(across), y.value(up)))

    before = points_at(*position)
    across, up = position
    while 0.0 <= across <= 1.0 and 0.0 <= up <= 1.0:
        across, up = across + change[0], up + change[1]
        if points_at(across, up) != before:
            return across, up
    return position if chart.backdrop is None else (across, up)


def _step_along(view: View, trace: Trace, right: int) -> None:
    where = view.cursors.moving
    if trace.curve_values is not None and where is not None:
        step = right * max(trace.curve_values.size // _STEPS, 1)
        at = nearest_index(trace.curve_values, where[0]) + step
        at = min(max(at, 0), trace.curve_values.size - 1)
        view.cursors.move((float(trace.curve_values[at]), 0.0))
