"""The points of a chart at its cursors, and the heading above the plot."""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .axis import Axis
from .chart import Backdrop, Chart, Position, Trace, View, trace_mark, trace_style, values_within

CURSOR_SIGNS: Final = "◆◇"
_LABEL_PATTERN: Final = re.compile(r"(.*) \(([^()]*)\)")
_VALUE_DIGITS: Final = 5
_POSITION_DIGITS: Final = 6
_INVERSE_UNITS: Final = {"s": "Hz", "Hz": "s"}
# In notes on runs outside the limits, the number of a run replaces a longer name.
_MAX_NAME_LENGTH: Final = 8

# Separates the parts of a note; lines break only between parts.
_NOTE_SEPARATOR: Final = re.compile(r"(?<=,) | {2,}")

# Text for a point without value.
_MISSING_TEXT: Final = "none"

# A text and the name of its style.
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

    A chart with a backdrop: its nearest point. With a `curve_label`: a point of each visible trace
    whose `curve_values` include the position. Another plane: the nearest point of all traces. A
    function of x: a point of each trace that includes the position, or else of the nearest traces.
    """
    if position is None:
        return []
    if chart.backdrop is not None:
        return [_nearest_in_backdrop(chart.backdrop, position)]
    axes = view.axes(chart)
    candidates: list[tuple[float, NearestPoint]] = []
    for index, trace in view.visible_traces(chart):
        values = trace.curve_values if chart.curve_label else trace.x if trace.ordered else None
        if values is not None and values.size:
            best = nearest_index(values, position[0])
            distance = max(float(values[0]) - position[0], position[0] - float(values[-1]), 0.0)
            candidates.append((distance, NearestPoint(index, *_coordinates(trace, best))))
        elif not chart.curve_label and (point := _nearest_xy(trace, axes, position)) is not None:
            candidates.append((point[1], NearestPoint(index, *_coordinates(trace, point[0]))))
    if not candidates:
        return []
    if chart.curve_label:
        return [point for distance, point in candidates if not distance]
    if chart.is_plane:
        return [min(candidates, key=lambda candidate: candidate[0])[1]]
    min_distance = min(distance for distance, _ in candidates)
    return [point for distance, point in candidates if distance == min_distance]


def crosshair(chart: Chart, position: Position, points: Sequence[NearestPoint]) -> Position:
    """The point where the lines of a cursor cross; in a plane, its nearest point."""
    return (points[0].x, points[0].y) if chart.is_plane and points else position


def nearest_index(values: NDArray[np.float64], value: float) -> int:
    """Index of the nearest of ascending values."""
    upper = int(np.searchsorted(values, value))
    candidates = [index for index in (upper - 1, upper) if 0 <= index < values.size]
    return min(candidates, key=lambda index: abs(float(values[index]) - value))


def nearest_curve_value(chart: Chart, view: View, position: Position) -> float | None:
    """The element of `curve_values` at the point nearest to a position (x, y), over all curves."""
    axes, min_distance = view.axes(chart), math.inf
    value = None
    for _, trace in view.visible_traces(chart):
        point = _nearest_xy(trace, axes, position)
        if trace.curve_values is not None and point is not None and point[1] <= min_distance:
            value, min_distance = float(trace.curve_values[point[0]]), point[1]
    return value


def _nearest_in_backdrop(backdrop: Backdrop, position: Position) -> NearestPoint:
    column = int(np.abs(backdrop.x - position[0]).argmin())
    row = int(np.abs(backdrop.y - position[1]).argmin())
    value = float(backdrop.values[column, row])
    shade = backdrop.shades[int(backdrop.levels[column, row])]
    return NearestPoint(
        -1, float(backdrop.x[column]), float(backdrop.y[row]), value, shade.missing_text
    )


def _coordinates(trace: Trace, index: int) -> tuple[float, float]:
    return float(trace.x[index]), float(trace.y[index])


def _nearest_xy(
    trace: Trace, axes: tuple[Axis, Axis], position: Position
) -> tuple[int, float] | None:
    dx = axes[0].positions(trace.x) - axes[0].positions([position[0]])
    dy = axes[1].positions(trace.y) - axes[1].positions([position[1]])
    squared_distance = dx * dx + dy * dy
    if not np.isfinite(squared_distance).any():
        return None
    index = int(np.nanargmin(squared_distance))
    return index, float(squared_distance[index])


# Heading


def heading_spans(
    chart: Chart, view: View, first: Sequence[NearestPoint], second: Sequence[NearestPoint]
) -> tuple[list[Span], int]:
    """The texts above a plot, and the number of leading texts that must not be omitted.

    Values at the points of both cursors, or else label and legend; then notes on the limits.
    """
    limit_spans = [*_outside_spans(chart, view), *_zoom_spans(chart, view)]
    if first or second:
        readout_spans = _readout_spans(chart, view, first, second)
        return [*readout_spans, *limit_spans], len(readout_spans)
    notes = [f" {part}" for part in _NOTE_SEPARATOR.split(chart.note) if part]
    title = [(part, "label") for part in (chart.y_label, *notes)]
    return [*title, *limit_spans, *_legend_spans(chart, view)], len(title) + len(limit_spans)


def needs_full_line(chart: Chart, view: View) -> bool:
    """Whether a heading is long: with two cursors, or with traces outside the limits."""
    return view.cursors.second is not None or bool(_outside_spans(chart, view))


def _legend_spans(chart: Chart, view: View) -> list[Span]:
    spans = []
    for index, trace in enumerate(chart.traces) if len(chart.traces) > 1 else ():
        style = "hidden" if index in view.hidden else trace_style(trace, index)
        plain = trace.look == "line" and not trace.mark
        mark = "─" if plain else trace_mark(trace, index)
        # A blank separates a letter from the name.
        gap = " " if mark.isalpha() else ""
        spans.append((f" {index + 1}{gap}{mark}{gap}{trace.name}", style))
    return spans


def _zoom_spans(chart: Chart, view: View) -> list[Span]:
    chosen = ((view.x, chart.x_label), (view.y, chart.y_label))
    names = [split_label(label)[0] for axis, label in chosen if axis is not None]
    return [(f" zoom {', '.join(names)}", "zoomed")] if names else []


def _outside_spans(chart: Chart, view: View) -> list[Span]:
    # Notes on traces outside the chosen limits, and on newer runs partly outside.
    if view.x is None and view.y is None:
        return []
    axes, spans = view.axes(chart), []
    for _, trace in view.visible_traces(chart):
        outside, partly = _outside_limits(trace, axes)
        if outside or (partly and view.y is not None and trace.number > view.newest_run):
            is_short = not trace.number or len(trace.name) <= _MAX_NAME_LENGTH
            name = trace.name if is_short else f"run {trace.number}"
            text = f"{name or split_label(chart.y_label)[0]} {'' if outside else 'partly '}outside"
            spans.append((f"  {text}, r: fit", "outside"))
    return spans


def _outside_limits(trace: Trace, axes: tuple[Axis, Axis]) -> tuple[bool, bool]:
    # Whether a trace is entirely outside the limits, and whether it is partly outside.
    x, y = axes
    values = values_within(trace, x) if trace.ordered else trace.y
    if not (np.isfinite(trace.x).any() and np.isfinite(values).any()):
        return bool(trace.x.size and not values.size), False
    pairs = ((trace.x, x), (values, y))
    ends = [(float(np.nanmin(part)), float(np.nanmax(part)), axis) for part, axis in pairs]
    outside = any(high < axis.low or low > axis.high for low, high, axis in ends)
    # An ordered trace may extend beyond the limits of x.
    checked = ends[1:] if trace.ordered else ends
    return outside, any(low < axis.low or high > axis.high for low, high, axis in checked)


def cursor_texts(label: str, first: float, second: float) -> list[str]:
    """Positions of two cursors, their difference, and for times and frequencies its inverse."""
    name, unit = split_label(label)
    a, b = (f"{value:.{_POSITION_DIGITS}g}" for value in (first, second))
    phrases = [f"{name} {CURSOR_SIGNS[0]}{a} {CURSOR_SIGNS[1]}{b} {unit}".rstrip()]
    difference = second - first
    phrases.append(f"Δ{name} {_number_text(difference)} {unit}".rstrip())
    if unit in _INVERSE_UNITS and difference:
        phrases.append(f"1/Δ{name} {_number_text(1.0 / abs(difference))} {_INVERSE_UNITS[unit]}")
    return phrases


def _readout_spans(
    chart: Chart, view: View, first: Sequence[NearestPoint], second: Sequence[NearestPoint]
) -> list[Span]:
    groups = (first, second)
    if chart.backdrop is not None:
        labels: list[tuple[str, Callable[[NearestPoint], float]]] = [
            (chart.x_label, lambda point: point.x),
            (chart.y_label, lambda point: point.y),
            (chart.backdrop.label, lambda point: point.value),
        ]
        return [(_reading(label, groups, get) + "  ", "readout") for label, get in labels]
    if chart.is_plane and not chart.curve_label:
        (point,) = first or second
        style = trace_style(chart.traces[point.trace], point.trace)
        name = chart.traces[point.trace].name if not (first and second) else ""
        x_text = _reading(chart.x_label, groups, lambda point: point.x) + "  "
        y_text = _reading(chart.y_label, groups, lambda point: point.y, name)
        return [(x_text, "readout"), (y_text + " ", style)]
    spans: list[Span] = []
    signs = bool(first and second)
    position = view.cursors.first if first else view.cursors.second
    if chart.curve_label and not signs and position is not None:
        name, unit = split_label(chart.curve_label)
        spans.append((f"{name} {_number_text(position[0])} {unit} ", "readout"))
    elif not signs:
        spans.append((_reading(chart.x_label, groups, lambda point: point.x) + " ", "readout"))
    if len(chart.traces) > 1 and not chart.curve_label:
        spans.append((f" {split_label(chart.y_label)[0]}", "readout"))
    for index, trace in enumerate(chart.traces):
        trace_points = [[point for point in points if point.trace == index] for points in groups]
        if not any(trace_points):
            continue
        style, name = trace_style(trace, index), trace.name if len(chart.traces) > 1 else ""
        if chart.curve_label:
            spans.append((f"{name} " * bool(name), style))
            x_text = _reading(chart.x_label, trace_points, lambda point: point.x, signs=signs)
            y_text = _reading(chart.y_label, trace_points, lambda point: point.y, signs=signs)
            spans += [(f"{x_text} ", style), (f"{y_text} ", style)]
        else:
            text = _reading(chart.y_label, trace_points, lambda point: point.y, name, signs=signs)
            spans.append((f" {text}", style))
    return spans


def _reading(
    label: str,
    groups: Sequence[Sequence[NearestPoint]],
    coordinate: Callable[[NearestPoint], float],
    name: str = "",
    *,
    signs: bool = False,
) -> str:
    # The value at one cursor, or the values at both cursors and their difference. `signs` adds
    # the sign of the cursor to a single value.
    symbol, unit = split_label(label)
    points = [at_cursor[0] for at_cursor in groups if at_cursor]
    value_texts = [_number_text(coordinate(point), point.missing_text) for point in points]
    if len(points) == 1:
        sign = CURSOR_SIGNS[not groups[0]] if signs else ""
        return f"{name or symbol} {sign}{value_texts[0]} {unit}".rstrip()
    pair = f"{CURSOR_SIGNS[0]}{value_texts[0]} {CURSOR_SIGNS[1]}{value_texts[1]}"
    difference = _number_text(coordinate(points[1]) - coordinate(points[0]))
    return f"{name or symbol} {pair} Δ{difference} {unit}".rstrip()


def _number_text(value: float, missing_text: str = _MISSING_TEXT) -> str:
    return missing_text if math.isnan(value) else f"{value:.{_VALUE_DIGITS}g}"
