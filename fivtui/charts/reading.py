"""Read-outs of a chart: points at the cursors, and the heading above the plot."""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .axis import Axis
from .chart import Backdrop, Chart, Place, Trace, View, trace_mark, trace_style, within

CURSOR_SIGNS: Final = "◆◇"
_LABEL: Final = re.compile(r"(.*) \(([^()]*)\)")
_PRECISION: Final = 5
_PLACE_PRECISION: Final = 6
_INVERSES: Final = {"s": "Hz", "Hz": "s"}
# A longer name of a run outside the limits is replaced by its number.
_MAX_NAME: Final = 8

# Separates the parts of a note; lines break between parts only.
_PARTS: Final = re.compile(r"(?<=,) | {2,}")

# Read-out of a point without a value.
_MISSING: Final = "none"

# Text and its style.
Span = tuple[str, str]


def split_label(label: str) -> tuple[str, str]:
    """Symbol and unit of a label such as ``y (m)``; the unit may be empty."""
    match = _LABEL.fullmatch(label)
    return (label, "") if match is None else (match[1], match[2])


# Points


@dataclass(frozen=True, slots=True)
class NearestPoint:
    """The point of a chart nearest to a cursor; `trace` is -1 for the backdrop.

    `missing` is the read-out if `value` is NaN.
    """

    trace: int
    x: float
    y: float
    value: float = math.nan
    missing: str = _MISSING


def nearest(chart: Chart, view: View, position: Place | None) -> list[NearestPoint]:
    """The points at a cursor; empty without a position.

    Along curves, one point of each visible trace that reaches the position. Over x, the same, or
    else the nearest point. In a plane, the nearest point of all traces, or of the backdrop.
    """
    if position is None:
        return []
    if chart.backdrop is not None:
        return [_nearest_of(chart.backdrop, position)]
    axes = view.axes(chart)
    candidates: list[tuple[float, NearestPoint]] = []
    for index, trace in view.visible(chart):
        values = trace.along if chart.along else trace.x if trace.ordered else None
        if values is not None and values.size:
            best = nearest_index(values, position[0])
            beyond = max(float(values[0]) - position[0], position[0] - float(values[-1]), 0.0)
            candidates.append((beyond, NearestPoint(index, *_point(trace, best))))
        elif not chart.along and (point := _nearest_in_plane(trace, axes, position)) is not None:
            candidates.append((point[1], NearestPoint(index, *_point(trace, point[0]))))
    if not candidates:
        return []
    if chart.along:
        return [point for beyond, point in candidates if not beyond]
    if chart.plane:
        return [min(candidates, key=lambda candidate: candidate[0])[1]]
    least = min(beyond for beyond, _ in candidates)
    return [point for beyond, point in candidates if beyond == least]


def crosshair(chart: Chart, position: Place, points: Sequence[NearestPoint]) -> Place:
    """The crossing of the lines of a cursor: in a plane, the nearest point."""
    return (points[0].x, points[0].y) if chart.plane and points else position


def nearest_index(values: NDArray[np.float64], at: float) -> int:
    """Index of the nearest of ascending values."""
    above = int(np.searchsorted(values, at))
    near = [index for index in (above - 1, above) if 0 <= index < values.size]
    return min(near, key=lambda index: abs(float(values[index]) - at))


def nearest_along(chart: Chart, view: View, position: Place) -> float | None:
    """The value along the curves of a chart at the point nearest to a position in the plane."""
    axes, best = view.axes(chart), math.inf
    value = None
    for _, trace in view.visible(chart):
        point = _nearest_in_plane(trace, axes, position)
        if trace.along is not None and point is not None and point[1] <= best:
            value, best = float(trace.along[point[0]]), point[1]
    return value


def _nearest_of(backdrop: Backdrop, position: Place) -> NearestPoint:
    column = int(np.abs(backdrop.x - position[0]).argmin())
    row = int(np.abs(backdrop.y - position[1]).argmin())
    value = float(backdrop.values[column, row])
    shade = backdrop.shades[int(backdrop.levels[column, row])]
    return NearestPoint(-1, float(backdrop.x[column]), float(backdrop.y[row]), value, shade.missing)


def _point(trace: Trace, index: int) -> tuple[float, float]:
    return float(trace.x[index]), float(trace.y[index])


def _nearest_in_plane(
    trace: Trace, axes: tuple[Axis, Axis], position: Place
) -> tuple[int, float] | None:
    across = axes[0].place(trace.x) - axes[0].place([position[0]])
    along = axes[1].place(trace.y) - axes[1].place([position[1]])
    squared_distance = across * across + along * along
    if not np.isfinite(squared_distance).any():
        return None
    best = int(np.nanargmin(squared_distance))
    return best, float(squared_distance[best])


# Heading


def heading(
    chart: Chart, view: View, first: Sequence[NearestPoint], second: Sequence[NearestPoint]
) -> tuple[list[Span], int]:
    """The spans above a plot, and how many of them must not be omitted.

    Read-outs of the cursors, or else label and legend; traces outside the limits; zoomed axes.
    """
    limits = [*_outside(chart, view), *_zoomed(chart, view)]
    if first or second:
        read = _read(chart, view, first, second)
        return [*read, *limits], len(read)
    notes = [f" {part}" for part in _PARTS.split(chart.note) if part]
    title = [(part, "label") for part in (chart.y_label, *notes)]
    return [*title, *limits, *_legend(chart, view)], len(title) + len(limits)


def is_long(chart: Chart, view: View) -> bool:
    """Whether a heading needs a full line: for two cursors, or traces outside the limits."""
    return view.cursors.second is not None or bool(_outside(chart, view))


def _legend(chart: Chart, view: View) -> list[Span]:
    spans = []
    for index, trace in enumerate(chart.traces) if len(chart.traces) > 1 else ():
        style = "hidden" if index in view.hidden else trace_style(trace, index)
        plain = trace.look == "line" and not trace.mark
        mark = "─" if plain else trace_mark(trace, index)
        # Separate a letter from the name.
        gap = " " if mark.isalpha() else ""
        spans.append((f" {index + 1}{gap}{mark}{gap}{trace.name}", style))
    return spans


def _zoomed(chart: Chart, view: View) -> list[Span]:
    chosen = ((view.x, chart.x_label), (view.y, chart.y_label))
    names = [split_label(label)[0] for axis, label in chosen if axis is not None]
    return [(f" zoom {', '.join(names)}", "kept")] if names else []


def _outside(chart: Chart, view: View) -> list[Span]:
    # Traces outside chosen limits, and newer runs that are partly outside.
    if view.x is None and view.y is None:
        return []
    axes, spans = view.axes(chart), []
    for _, trace in view.visible(chart):
        away, cut = _outside_limits(trace, axes)
        if away or (cut and view.y is not None and trace.number > view.since):
            short = not trace.number or len(trace.name) <= _MAX_NAME
            name = trace.name if short else f"run {trace.number}"
            text = f"{name or split_label(chart.y_label)[0]} {'' if away else 'partly '}outside"
            spans.append((f"  {text}, r: fit", "outside"))
    return spans


def _outside_limits(trace: Trace, axes: tuple[Axis, Axis]) -> tuple[bool, bool]:
    # Whether a trace is entirely outside the limits, and whether it is partly outside.
    x, y = axes
    values = within(trace, x) if trace.ordered else trace.y
    if not (np.isfinite(trace.x).any() and np.isfinite(values).any()):
        return bool(trace.x.size and not values.size), False
    pairs = ((trace.x, x), (values, y))
    ends = [(float(np.nanmin(part)), float(np.nanmax(part)), axis) for part, axis in pairs]
    away = any(high < axis.low or low > axis.high for low, high, axis in ends)
    # A function of x may extend beyond the chosen range of x.
    beyond = ends[1:] if trace.ordered else ends
    return away, any(low < axis.low or high > axis.high for low, high, axis in beyond)


def cursor_words(label: str, first: float, second: float) -> list[str]:
    """Values at two cursors, their difference, and for times and frequencies its inverse."""
    name, unit = split_label(label)
    a, b = (f"{value:.{_PLACE_PRECISION}g}" for value in (first, second))
    phrases = [f"{name} {CURSOR_SIGNS[0]}{a} {CURSOR_SIGNS[1]}{b} {unit}".rstrip()]
    difference = second - first
    phrases.append(f"Δ{name} {_number(difference)} {unit}".rstrip())
    if unit in _INVERSES and difference:
        phrases.append(f"1/Δ{name} {_number(1.0 / abs(difference))} {_INVERSES[unit]}")
    return phrases


def _read(
    chart: Chart, view: View, first: Sequence[NearestPoint], second: Sequence[NearestPoint]
) -> list[Span]:
    both = (first, second)
    if chart.backdrop is not None:
        labels: list[tuple[str, Callable[[NearestPoint], float]]] = [
            (chart.x_label, lambda point: point.x),
            (chart.y_label, lambda point: point.y),
            (chart.backdrop.label, lambda point: point.value),
        ]
        return [(_values(label, both, of) + "  ", "readout") for label, of in labels]
    if chart.plane and not chart.along:
        (point,) = first or second
        style = trace_style(chart.traces[point.trace], point.trace)
        name = chart.traces[point.trace].name if not (first and second) else ""
        across = _values(chart.x_label, both, lambda point: point.x) + "  "
        up = _values(chart.y_label, both, lambda point: point.y, name)
        return [(across, "readout"), (up + " ", style)]
    spans: list[Span] = []
    signed = bool(first and second)
    position = view.cursors.first if first else view.cursors.second
    if chart.along and not signed and position is not None:
        name, unit = split_label(chart.along)
        spans.append((f"{name} {_number(position[0])} {unit} ", "readout"))
    elif not signed:
        spans.append((_values(chart.x_label, both, lambda point: point.x) + " ", "readout"))
    if len(chart.traces) > 1 and not chart.along:
        spans.append((f" {split_label(chart.y_label)[0]}", "readout"))
    for index, trace in enumerate(chart.traces):
        trace_points = [[point for point in points if point.trace == index] for points in both]
        if not any(trace_points):
            continue
        style, name = trace_style(trace, index), trace.name if len(chart.traces) > 1 else ""
        if chart.along:
            spans.append((f"{name} " * bool(name), style))
            across = _values(chart.x_label, trace_points, lambda point: point.x, signed=signed)
            up = _values(chart.y_label, trace_points, lambda point: point.y, signed=signed)
            spans += [(f"{across} ", style), (f"{up} ", style)]
        else:
            text = _values(chart.y_label, trace_points, lambda point: point.y, name, signed=signed)
            spans.append((f" {text}", style))
    return spans


def _values(
    label: str,
    both: Sequence[Sequence[NearestPoint]],
    of: Callable[[NearestPoint], float],
    name: str = "",
    *,
    signed: bool = False,
) -> str:
    # The value at one cursor, `signed` with its mark, or both values and their difference.
    symbol, unit = split_label(label)
    points = [at_cursor[0] for at_cursor in both if at_cursor]
    numbers = [_number(of(point), point.missing) for point in points]
    if len(points) == 1:
        sign = CURSOR_SIGNS[not both[0]] if signed else ""
        return f"{name or symbol} {sign}{numbers[0]} {unit}".rstrip()
    pair = f"{CURSOR_SIGNS[0]}{numbers[0]} {CURSOR_SIGNS[1]}{numbers[1]}"
    difference = _number(of(points[1]) - of(points[0]))
    return f"{name or symbol} {pair} Δ{difference} {unit}".rstrip()


def _number(value: float, missing: str = _MISSING) -> str:
    return missing if math.isnan(value) else f"{value:.{_PRECISION}g}"
