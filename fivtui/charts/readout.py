"""The points of a chart at its two cursors, and the heading above the plot.

A chart may be a plane: y is not a function of x, as for maps and phase portraits. Its backdrop are
the values of a map on a grid (x, y), drawn as shades. The level of a grid point is the index of its
shade.

The heading has the label, then the values at the cursors or else the legend. It consists of
spans, which are texts with the names of their styles.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .axis import Axis
from .chart import Backdrop, Chart, Position, Trace, View, trace_mark, trace_style, values_within

# Signs of the first cursor and the second.
CURSOR_SIGNS: Final = "◆◇"
# A label such as ``y (m)``: symbol and unit.
_LABEL_PATTERN: Final = re.compile(r"(.*) \(([^()]*)\)")
# Significant digits of values, and of the positions of two cursors.
_VALUE_DIGITS: Final = 5
_POSITION_DIGITS: Final = 6
# Units of differences whose inverse is displayed, with the unit of the inverse.
_INVERSE_UNITS: Final = {"s": "Hz", "Hz": "s"}
# In notes on runs outside the limits, the number of a run replaces a longer name.
_MAX_NAME_LENGTH: Final = 8
# Separates the parts of a note; lines break only between parts.
_NOTE_SEPARATOR: Final = re.compile(r"(?<=,) | {2,}")
# Text for a point without value.
_MISSING_TEXT: Final = "none"
# Index of the "trace" of points in the backdrop.
_BACKDROP: Final = -1

# A text and the name of its style; after a blank, the action of a click on the text.
Span = tuple[str, str]


def split_label(label: str) -> tuple[str, str]:
    """Symbol and unit of a label such as ``y (m)``; the unit may be empty."""
    match = _LABEL_PATTERN.fullmatch(label)
    return (label, "") if match is None else (match[1], match[2])


# Points


@dataclass(frozen=True, slots=True)
class NearestPoint:
    """The point of a chart nearest to a cursor; `trace` is its index, -1 for the backdrop.

    `missing_text` is displayed if `value` is NaN.
    """

    trace: int
    x: float
    y: float
    value: float = math.nan
    missing_text: str = _MISSING_TEXT


def points_at(chart: Chart, view: View, position: Position | None) -> list[NearestPoint]:
    """The points at a cursor; empty without a position.

    A chart with a backdrop: the nearest point of its grid. With a `curve_label`: a point of each
    visible trace whose `curve_values` include the first coordinate of `position`. This is a value
    such as time, by which cursors move along the curves. In another plane: the nearest point of all
    traces. For functions of x: a point of each trace whose x includes that of the cursor, or else
    of the nearest traces.
    """
    if position is None:
        return []
    if chart.backdrop is not None:
        return [_nearest_in_backdrop(chart.backdrop, position)]
    axes, cursor = view.axes(chart), position[0]
    # The nearest point of each trace, and its distance from the cursor.
    points: list[NearestPoint] = []
    distances: list[float] = []
    for index, trace in view.visible_traces(chart):
        values = trace.x if trace.ordered else None
        if chart.curve_label:
            values = trace.curve_values
        if values is not None and values.size:
            # The distance is zero within the range of the trace.
            nearest = nearest_index(values, cursor)
            distance = max(float(values[0]) - cursor, cursor - float(values[-1]), 0.0)
        elif not chart.curve_label and (match := _nearest_xy(trace, axes, position)) is not None:
            nearest, distance = match
        else:
            continue
        points.append(NearestPoint(index, float(trace.x[nearest]), float(trace.y[nearest])))
        distances.append(distance)
    if not points:
        return []
    min_distance = min(distances)
    if chart.curve_label:
        return [point for point, distance in zip(points, distances, strict=True) if not distance]
    if chart.is_plane:
        return [points[distances.index(min_distance)]]
    return [
        point for point, distance in zip(points, distances, strict=True) if distance == min_distance
    ]


def crosshair(chart: Chart, position: Position, points: Sequence[NearestPoint]) -> Position:
    """The point where the lines of a cursor cross; in a plane, its nearest point."""
    return (points[0].x, points[0].y) if chart.is_plane and points else position


def nearest_index(values: NDArray[np.float64], value: float) -> int:
    """Index of the nearest of ascending values."""
    return int(nearest_indices(values, np.array(value)))


def nearest_indices(values: NDArray[np.float64], targets: NDArray[np.float64]) -> NDArray[np.intp]:
    """Indices of the ascending values that are nearest to targets."""
    lower = np.clip(np.searchsorted(values, targets) - 1, 0, max(values.size - 2, 0))
    upper = np.minimum(lower + 1, values.size - 1)
    return np.where(targets - values[lower] <= values[upper] - targets, lower, upper)


def nearest_curve_value(chart: Chart, view: View, position: Position) -> float | None:
    """The element of `curve_values` at the point nearest to a position (x, y), over all curves."""
    axes, value, min_distance = view.axes(chart), None, math.inf
    for _, trace in view.visible_traces(chart):
        match = _nearest_xy(trace, axes, position)
        if trace.curve_values is None or match is None:
            continue
        index, distance = match
        if distance <= min_distance:
            value, min_distance = float(trace.curve_values[index]), distance
    return value


def _nearest_in_backdrop(backdrop: Backdrop, position: Position) -> NearestPoint:
    column, row = nearest_index(backdrop.x, position[0]), nearest_index(backdrop.y, position[1])
    value = float(backdrop.values[column, row])
    # The shade also says why a value is missing, such as "none" or "not known".
    shade = backdrop.shades[int(backdrop.levels[column, row])]
    return NearestPoint(
        _BACKDROP, float(backdrop.x[column]), float(backdrop.y[row]), value, shade.missing_text
    )


def _nearest_xy(
    trace: Trace, axes: tuple[Axis, Axis], position: Position
) -> tuple[int, float] | None:
    # Index of the point of a trace nearest to a position (x, y), and its squared distance in
    # lengths of the axes; None if no point is finite.
    (x_axis, y_axis), (x, y) = axes, position
    dx = x_axis.positions(trace.x) - x_axis.positions([x])
    dy = y_axis.positions(trace.y) - y_axis.positions([y])
    squared_distance = dx * dx + dy * dy
    if not np.isfinite(squared_distance).any():
        return None
    index = int(np.nanargmin(squared_distance))
    return index, float(squared_distance[index])


# Heading


def heading_spans(chart: Chart, view: View) -> tuple[list[Span], int]:
    """The texts above a plot, and the number of leading texts that must not be omitted.

    The label; values at the points of both cursors, or else note and legend; notes on the limits.
    """
    limit_spans = [*_outside_spans(chart, view), *_zoom_spans(chart, view)]
    if values := readout_spans(chart, view):
        title = [(f"{chart.y_label} ", "label"), *values]
        return [*title, *limit_spans], len(title)
    notes = [f" {part}" for part in _NOTE_SEPARATOR.split(chart.note) if part]
    title = [(part, "label") for part in (chart.y_label, *notes)]
    return [*title, *limit_spans, *_legend_spans(chart, view)], len(title) + len(limit_spans)


def has_long_heading(chart: Chart, view: View) -> bool:
    """Whether a heading may be long: with a cursor, or with traces outside the limits."""
    cursors = view.cursors
    return (cursors.first or cursors.second) is not None or bool(_outside_spans(chart, view))


def _legend_spans(chart: Chart, view: View) -> list[Span]:
    # A single trace needs no legend.
    if len(chart.traces) < 2:
        return []
    spans = []
    for index, trace in enumerate(chart.traces):
        style = "hidden" if index in view.hidden else trace_style(trace, index)
        is_plain_line = trace.look == "line" and not trace.mark
        mark = "─" if is_plain_line else trace_mark(trace, index)
        # A blank separates a letter from the name.
        gap = " " if mark.isalpha() else ""
        # A click hides or shows the trace.
        spans.append((f" {index + 1}{gap}{mark}{gap}{trace.name}", f"{style} trace({index + 1})"))
    return spans


def _zoom_spans(chart: Chart, view: View) -> list[Span]:
    # The symbols of the axes whose limits were chosen.
    axis_labels = ((view.x, chart.x_label), (view.y, chart.y_label))
    names = [split_label(label)[0] for axis, label in axis_labels if axis is not None]
    return [(f" zoom {', '.join(names)}", "zoomed")] if names else []


def _outside_spans(chart: Chart, view: View) -> list[Span]:
    # Notes on traces outside the chosen limits, and on runs partly outside that were added since.
    # Runs are numbered from 1; a trace that is not a run has the number 0.
    if view.x is None and view.y is None:
        return []
    axes, spans = view.axes(chart), []
    for _, trace in view.visible_traces(chart):
        is_outside, is_partly_outside = _outside_limits(trace, axes)
        is_added_later = view.y is not None and trace.number > view.newest_run_when_zoomed
        if is_outside or (is_partly_outside and is_added_later):
            name = trace.name
            if trace.number and len(name) > _MAX_NAME_LENGTH:
                name = f"run {trace.number}"
            where = "outside" if is_outside else "partly outside"
            text = f"{name or split_label(chart.y_label)[0]} {where}"
            spans.append((f"  {text}, r: fit", "outside"))
    return spans


def _outside_limits(trace: Trace, axes: tuple[Axis, Axis]) -> tuple[bool, bool]:
    # Whether a trace is entirely outside the limits, and whether it is partly outside.
    x_axis, y_axis = axes
    y_values = values_within(trace, x_axis) if trace.ordered else trace.y
    if not (np.isfinite(trace.x).any() and np.isfinite(y_values).any()):
        return False, False
    x_min, x_max = float(np.nanmin(trace.x)), float(np.nanmax(trace.x))
    y_min, y_max = float(np.nanmin(y_values)), float(np.nanmax(y_values))
    is_outside = (
        x_max < x_axis.low or x_min > x_axis.high or y_max < y_axis.low or y_min > y_axis.high
    )
    is_partly_outside = y_min < y_axis.low or y_max > y_axis.high
    if not trace.ordered:
        # An ordered trace may extend beyond the limits of x.
        is_partly_outside |= x_min < x_axis.low or x_max > x_axis.high
    return is_outside, is_partly_outside


def cursor_texts(label: str, first: float, second: float) -> list[str]:
    """Positions of two cursors, their difference, and for times and frequencies its inverse."""
    name, unit = split_label(label)
    positions = " ".join(
        f"{sign}{value:.{_POSITION_DIGITS}g}"
        for sign, value in zip(CURSOR_SIGNS, (first, second), strict=True)
    )
    phrases = [f"{name} {positions} {unit}".rstrip()]
    difference = second - first
    phrases.append(f"Δ{name} {_number_text(difference)} {unit}".rstrip())
    if unit in _INVERSE_UNITS and difference:
        phrases.append(f"1/Δ{name} {_number_text(1.0 / abs(difference))} {_INVERSE_UNITS[unit]}")
    return phrases


def cursor_points(chart: Chart, view: View) -> tuple[list[NearestPoint], list[NearestPoint]]:
    """The points at the first cursor and at the second."""
    return points_at(chart, view, view.cursors.first), points_at(chart, view, view.cursors.second)


def readout_spans(chart: Chart, view: View) -> list[Span]:
    """The values at the points of both cursors; empty without points."""
    first, second = cursor_points(chart, view)
    if not (first or second):
        return []
    at_cursors = (first, second)
    if chart.backdrop is not None:
        labels = ((chart.x_label, "x"), (chart.y_label, "y"), (chart.backdrop.label, "value"))
        return [
            (_reading(label, at_cursors, attribute) + "  ", "readout")
            for label, attribute in labels
        ]
    if chart.is_plane and not chart.curve_label:
        # Each cursor is at one point; with two cursors the first one's trace gives the style.
        (point,) = first or second
        trace = chart.traces[point.trace]
        name = "" if first and second else trace.name
        x_text = _reading(chart.x_label, at_cursors, "x")
        y_text = _reading(chart.y_label, at_cursors, "y", name)
        return [(f"{x_text}  ", "readout"), (f"{y_text} ", trace_style(trace, point.trace))]
    spans: list[Span] = []
    # With two cursors, signs show to which of them a single value belongs.
    with_signs = bool(first and second)
    position = view.cursors.first if first else view.cursors.second
    if chart.curve_label and not with_signs and position is not None:
        name, unit = split_label(chart.curve_label)
        spans.append((f"{name} {_number_text(position[0])} {unit} ", "readout"))
    elif not with_signs:
        spans.append((_reading(chart.x_label, at_cursors, "x") + " ", "readout"))
    if len(chart.traces) > 1 and not chart.curve_label:
        spans.append((f" {split_label(chart.y_label)[0]}", "readout"))
    for index, trace in enumerate(chart.traces):
        on_trace = [[point for point in points if point.trace == index] for points in at_cursors]
        if not any(on_trace):
            continue
        style, name = trace_style(trace, index), trace.name if len(chart.traces) > 1 else ""
        if chart.curve_label:
            spans.append((f"{name} " if name else "", style))
            x_text = _reading(chart.x_label, on_trace, "x", with_sign=with_signs)
            y_text = _reading(chart.y_label, on_trace, "y", with_sign=with_signs)
            spans += [(f"{x_text} ", style), (f"{y_text} ", style)]
        else:
            text = _reading(chart.y_label, on_trace, "y", name, with_sign=with_signs)
            spans.append((f" {text}", style))
    return spans


def _reading(
    label: str,
    at_cursors: Sequence[Sequence[NearestPoint]],
    attribute: str,
    name: str = "",
    *,
    with_sign: bool = False,
) -> str:
    # An attribute of the point at one cursor, or those at both cursors and their difference. `name`
    # replaces the symbol of the label; `with_sign` adds the sign of the cursor to a single value.
    symbol, unit = split_label(label)
    points = [points[0] for points in at_cursors if points]
    values = [float(getattr(point, attribute)) for point in points]
    value_texts = [
        _number_text(value, point.missing_text) for value, point in zip(values, points, strict=True)
    ]
    if len(points) == 1:
        first, _ = at_cursors
        sign = CURSOR_SIGNS[0 if first else 1] if with_sign else ""
        return f"{name or symbol} {sign}{value_texts[0]} {unit}".rstrip()
    pair = f"{CURSOR_SIGNS[0]}{value_texts[0]} {CURSOR_SIGNS[1]}{value_texts[1]}"
    difference = _number_text(values[1] - values[0])
    return f"{name or symbol} {pair} Δ{difference} {unit}".rstrip()


def _number_text(value: float, missing_text: str = _MISSING_TEXT) -> str:
    return missing_text if math.isnan(value) else f"{value:.{_VALUE_DIGITS}g}"
