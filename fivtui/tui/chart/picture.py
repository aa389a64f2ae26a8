"""A chart drawn in characters: rows of styled text. Imports no Textual.

The plot area shows the backdrop (shades), guides (reference lines), traces and cursors of a chart.
The heading is above it, ticks are left of it, and strips (marked intervals of x) are below it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fivtui.charts import (
    CURSOR_SIGNS,
    MAX_JOINED_SAMPLES,
    Axis,
    AxisTicks,
    Backdrop,
    Chart,
    Position,
    Span,
    Trace,
    View,
    column_edges,
    covered_shares,
    crosshair,
    cursor_points,
    dense_band,
    envelope,
    guide_style,
    heading_spans,
    nearest_indices,
    shade_text,
    trace_mark,
    trace_style,
)

from .raster import DOTS_X, Raster

# Least number of columns left of the plot area, with the tick labels of y.
MARGIN: Final = 8
_ROWS_PER_TICK: Final = 2
# Least columns per tick of x, greatest number of these ticks, and least gap between their labels.
_COLUMNS_PER_TICK: Final = 6
_MAX_X_TICKS: Final = 12
_LABEL_GAP: Final = 2
# Rows of the plot for which lines of a heading are omitted: more for a legend, fewer for texts that
# are needed, such as values at cursors.
_MIN_ROWS_BELOW_LEGEND: Final = 5
_MIN_ROWS_BELOW_NEEDED: Final = 2
# Columns from a mark on a line to the next.
_MARK_DISTANCE: Final = 8
# Where traces share cells, each is drawn in stripes of this many columns.
_STRIPE_WIDTH: Final = 2
# Bits of the Braille dots that fill a cell inside a dense trace.
_FILLING_MASK: Final = 0b10010101
# The same of stacked areas, from the lowest.
_AREA_MASKS: Final = (0b01000010, 0b10010101, 0b11111111)
_ALL_DOTS: Final = 0b11111111
_BLANK: Final = " "
_VERTICAL: Final = "│"
_HORIZONTAL: Final = "─"
_CROSSING: Final = "┼"
# Character of the line and style of both cursors.
_CURSORS: Final = ((_VERTICAL, "cursor"), ("┊", "cursor-2"))


class PlotArea(NamedTuple):
    """The position and size of the plot area in a picture, in character cells."""

    first_column: int
    top_row: int
    columns: int
    rows: int


@dataclass(frozen=True, slots=True)
class Picture:
    """A chart drawn in characters: its lines as spans of styled text."""

    lines: list[list[Span]]
    plot_area: PlotArea

    def text(self) -> str:
        """The characters without styles, line by line."""
        return "\n".join("".join(text for text, _ in line) for line in self.lines)

    def axis_positions(self, column: int, row: int) -> Position | None:
        """Axis positions of the middle of a character cell; None outside the plot area."""
        area = self.plot_area
        x = (column - area.first_column + 0.5) / area.columns
        y = 1.0 - (row - area.top_row + 0.5) / area.rows
        return (x, y) if 0.0 <= x <= 1.0 and 0.0 <= y <= 1.0 else None


def draw(chart: Chart, view: View, width: int, height: int, *, reserved: int = 0) -> Picture:
    """Draw a chart in `width` by `height` characters; `reserved` columns of line 1 stay blank."""
    bottom_rows = len(chart.strips) + int(chart.x_axis)
    spans, needed_spans = heading_spans(chart, view)
    if len(chart.x_label) > MARGIN:
        # The name of the x axis does not fit beside its ticks.
        spans.insert(1, (f" over {chart.x_label}", "label"))
        needed_spans += 1
    needed_rows = len(_wrap_spans(spans[:needed_spans], width, reserved))
    # A long heading loses its last lines, to leave a few rows for the plot.
    free_rows = height - bottom_rows
    needed_rows = min(needed_rows, free_rows - _MIN_ROWS_BELOW_NEEDED)
    heading_rows = max(needed_rows, free_rows - _MIN_ROWS_BELOW_LEGEND, 1)
    lines = _wrap_spans(spans, width, reserved)[:heading_rows]
    top_row = len(lines)
    view.rows = rows = max(height - top_row - bottom_rows, 1)
    x_axis, y_axis = view.axes(chart)
    margins = _margins(y_axis, rows)
    margin = len(margins[0])
    margins += [strip.label[:margin].rjust(margin) for strip in chart.strips]
    columns = max(width - margin, 1)
    canvas = _Canvas(chart, view, columns, rows)
    canvas.draw()
    lines += [[(text, "tick"), *row] for text, row in zip(margins, canvas.lines(), strict=True)]
    if chart.x_axis:
        lines.append(_x_axis_line(x_axis, chart.x_label, margin, columns))
    return Picture(lines[:height], PlotArea(margin, top_row, columns, rows))


def axis_ticks(chart: Chart, view: View, columns: int, rows: int) -> AxisTicks:
    """The ticks of both axes of a plot."""
    x_axis, y_axis = view.axes(chart)
    x_ticks = [tick for tick, _, _ in _x_labels(x_axis, columns)]
    return x_ticks, y_axis.ticks(_max_y_ticks(rows))[0]


def _max_y_ticks(rows: int) -> int:
    return max(rows // _ROWS_PER_TICK, 2)


class _Canvas:
    # The cells of the plot area: characters, and names of styles.

    def __init__(self, chart: Chart, view: View, columns: int, rows: int) -> None:
        self._chart, self._columns, self._rows = chart, columns, rows
        self._traces = list(view.visible_traces(chart))
        self._x_axis, self._y_axis = view.axes(chart)
        # Edges of the columns of dots.
        self._x_edges = column_edges(self._x_axis, DOTS_X * columns)
        self._cursors = (view.cursors.first, view.cursors.second)
        self._cursor_points = cursor_points(chart, view)
        # The plot and, below it, the strips.
        shape = rows + len(chart.strips), columns
        self._all_characters = np.full(shape, _BLANK)
        self._all_styles = np.full(shape, "plot", dtype=object)
        self._characters, self._strips = np.split(self._all_characters, [rows])
        self._styles, self._strip_styles = np.split(self._all_styles, [rows])
        self._strip_styles[:] = "strip"
        # Bits of the dots at the edges of each trace with lines or dots, by its index.
        self._edges: dict[int, NDArray[np.uint32]] = {}

    def draw(self) -> None:
        # Draw from the back to the front.
        chart = self._chart
        if chart.backdrop is not None:
            self._draw_shades(chart.backdrop)
        guide_labels = self._draw_guides()
        limits = (self._x_axis.low, self._x_axis.high)
        for cells, strip in zip(self._strips, chart.strips, strict=True):
            shares = covered_shares(strip.intervals, limits, self._columns)
            cells[:] = list(shade_text(shares))
        if chart.stacked:
            self._draw_areas()
        else:
            self._draw_curves()
        for x, y, text in chart.backdrop.labels if chart.backdrop is not None else ():
            self._write_at(x, y, f" {text} ", "plot")
        for index, trace in self._traces:
            if trace.look in ("points", "marked"):
                self._draw_marks(index, trace)
        for row, column, label, style in guide_labels:
            self._write(row, column, label, style)
        if len(chart.traces) > 1 and not chart.stacked:
            self._draw_trace_numbers()
        # The first cursor is drawn over the second.
        self._draw_cursor(1)
        self._draw_cursor(0)

    def _draw_shades(self, backdrop: Backdrop) -> None:
        # Coordinates of the middle of the columns and rows.
        cell_x = self._x_axis.values((np.arange(self._columns) + 0.5) / self._columns)
        cell_y = self._y_axis.values(1.0 - (np.arange(self._rows) + 0.5) / self._rows)
        x_indices = nearest_indices(backdrop.x, cell_x)
        levels = backdrop.levels[x_indices, nearest_indices(backdrop.y, cell_y)[:, None]]
        characters, styles = np.array(
            [(shade.character, shade.style) for shade in backdrop.shades], dtype=object
        ).T
        inside_x = (cell_x >= backdrop.x[0]) & (cell_x <= backdrop.x[-1])
        inside_y = (cell_y >= backdrop.y[0]) & (cell_y <= backdrop.y[-1])
        inside = inside_x[None, :] & inside_y[:, None]
        self._characters[inside] = characters[levels][inside]
        self._styles[inside] = styles[levels][inside]

    def _draw_guides(self) -> list[tuple[int, int, str, str]]:
        # Returns row, first column, text and style of the labels.
        labels: list[tuple[int, int, str, str]] = []
        for guide in self._chart.guides:
            style, label = guide_style(guide), guide.label
            cell = self._column_at(guide.value) if guide.vertical else self._row_at(guide.value)
            if cell is None:
                continue
            if guide.vertical:
                line, crossed_line = _VERTICAL, _HORIZONTAL
                # Labels have separate rows, so that neighbours do not overlap.
                labels.append((min(len(labels), self._rows - 1), cell + 1, label, style))
            else:
                line, crossed_line = _HORIZONTAL, _VERTICAL
                labels.append((cell, self._columns - len(label), label, style))
            cells = (slice(None), cell) if guide.vertical else (cell, slice(None))
            is_crossed = self._characters[cells] == crossed_line
            self._characters[cells] = np.where(is_crossed, _CROSSING, line)
            self._styles[cells] = style
        return labels

    def _write(self, row: int, column: int, text: str, style: str) -> None:
        column = max(min(column, self._columns - len(text)), 0)
        text = text[: self._columns - column]
        self._characters[row, column : column + len(text)] = list(text)
        self._styles[row, column : column + len(text)] = style

    def _write_at(self, x: float, y: float, text: str, style: str) -> None:
        # Write a text in the middle of a point, if it is inside the plot.
        row, column = self._row_at(y), self._column_at(x)
        if row is not None and column is not None:
            self._write(row, column - len(text) // 2, text, style)

    def _draw_curves(self) -> None:
        # Draw lines and dots; of several traces only the top one is filled where it is dense.
        lines = [pair for pair in reversed(self._traces) if pair[1].look != "points"]
        if not lines:
            return
        # The topmost trace is first. Bits of its dots by row and column, all and inside.
        rasters = [self._raster(trace) for _, trace in lines]
        cells = np.array([raster.cells for raster in rasters])
        inner_cells = np.array([raster.inner_cells for raster in rasters])
        styles = np.array([trace_style(trace, index) for index, trace in lines], dtype=object)
        filling = inner_cells[0] & (_FILLING_MASK if lines[0][1].ordered else _ALL_DOTS)
        self._draw_dots(filling)
        self._styles[filling > 0] = styles[0]
        # Curves of a plane are outlines only where they meet.
        is_alone = (cells > 0).sum(axis=0) == 1
        is_complete = np.array([not trace.ordered for _, trace in lines])[:, None, None] & is_alone
        dots = np.where(is_complete, cells, cells & ~inner_cells)
        has_dots = dots > 0
        counts = has_dots.sum(axis=0)
        # In cells that several edges share, successive stripes show the style of each in turn.
        ranks = np.cumsum(has_dots, axis=0) - 1
        stripes = np.arange(self._columns)[None, :] // _STRIPE_WIDTH
        is_shown = has_dots & (ranks == stripes % np.maximum(counts, 1))
        cell_dots = np.bitwise_or.reduce(dots, axis=0)
        cell_dots |= np.where(has_dots[0] & (counts == 1), filling, 0)
        self._draw_dots(cell_dots)
        is_drawn = counts > 0
        self._styles[is_drawn] = styles[is_shown.argmax(axis=0)][is_drawn]
        self._edges = {index: edge for (index, _), edge in zip(lines, dots, strict=True)}

    def _draw_areas(self) -> None:
        # Fill the areas of traces over the same x, each on top of those before it.
        edges = self._x_edges
        middles, bottom = 0.5 * (edges[1:] + edges[:-1]), np.zeros(edges.size - 1)
        dots, counts = np.zeros((2, self._rows, self._columns), dtype=np.uint32)
        for index, trace in self._traces:
            top = bottom + np.interp(middles, trace.x, trace.y, 0.0, 0.0)
            raster = Raster(self._columns, self._rows)
            limits = (self._y_axis.positions(values) for values in (bottom, top))
            raster.fill_columns(*(np.where(top > bottom, edge, np.nan) for edge in limits))
            dots |= raster.cells & _AREA_MASKS[index % len(_AREA_MASKS)]
            # A cell has the colour of the area with most dots.
            dot_counts = np.bitwise_count(raster.cells)
            self._styles[dot_counts > counts] = trace_style(trace, index)
            counts, bottom = np.maximum(counts, dot_counts), top
        self._draw_dots(dots)

    def _draw_dots(self, bits: NDArray[np.uint32]) -> None:
        # Draw the Braille characters with these dots.
        has_dots = bits > 0
        self._characters[has_dots] = (Raster.BLANK + bits[has_dots]).view("<U1")

    def _draw_marks(self, index: int, trace: Trace) -> None:
        x, y = self._x_axis.positions(trace.x), self._y_axis.positions(trace.y)
        inside = (x >= 0.0) & (x <= 1.0) & (y >= 0.0) & (y <= 1.0)
        columns = np.minimum(x[inside] * self._columns, self._columns - 1).astype(np.intp)
        rows = self._rows - 1 - np.minimum(y[inside] * self._rows, self._rows - 1).astype(np.intp)
        # The marks on a line have gaps, and those of another trace are in other columns.
        step = 1
        if trace.look == "marked" and trace.ordered and columns.size > 1:
            step = max(1, int(_MARK_DISTANCE * columns.size / (1 + np.ptp(columns))))
        marked = slice(step * (2 * index + 1) // _MARK_DISTANCE % step, None, step)
        self._characters[rows[marked], columns[marked]] = trace_mark(trace, index)
        self._styles[rows[marked], columns[marked]] = trace_style(trace, index)

    def _raster(self, trace: Trace) -> Raster:
        raster = Raster(self._columns, self._rows)
        x, y = trace.x, trace.y
        if trace.ordered:
            x, y = envelope(x, y, self._x_edges)
        x, y = self._x_axis.positions(x), self._y_axis.positions(y)
        if trace.look == "dots":
            raster.draw_dots(x, y)
        elif trace.ordered:
            raster.draw_lines(x, y)
            band = dense_band(trace.x, trace.y, self._x_edges)
            raster.fill_columns(*map(self._y_axis.positions, band))
        else:
            # Unordered traces are not reduced to what the plot resolves. To limit the time, lines
            # join the last samples only.
            dot_count = max(x.size - MAX_JOINED_SAMPLES, 0)
            raster.draw_dots(x[:dot_count], y[:dot_count])
            raster.draw_lines(x[dot_count:], y[dot_count:])
        return raster

    def _column_at(self, x: float) -> int | None:
        position = float(self._x_axis.positions(x))
        return _cell_index(position, self._columns) if 0.0 <= position <= 1.0 else None

    def _row_at(self, y: float) -> int | None:
        height = float(self._y_axis.positions(y))
        return self._rows - 1 - _cell_index(height, self._rows) if 0.0 <= height <= 1.0 else None

    def _draw_trace_numbers(self) -> None:
        # Numbers distinguish lines without colour. They stand at evenly spaced x, or at the end of
        # an unordered trace.
        for index, trace in self._traces:
            if trace.look != "line" or not trace.x.size:
                continue
            target_x = self._x_axis.value((index + 0.5) / len(self._chart.traces))
            sample = int(np.searchsorted(trace.x, target_x)) if trace.ordered else trace.x.size - 1
            sample = min(sample, trace.x.size - 1)
            row, column = self._row_at(trace.y[sample]), self._column_at(trace.x[sample])
            if row is not None and column is not None:
                # A dense trace has its number at its nearest edge.
                edge_rows = np.flatnonzero(self._edges[index][:, column])
                if edge_rows.size:
                    row = int(edge_rows[np.abs(edge_rows - row).argmin()])
                self._write(row, column, trace_mark(trace, index), trace_style(trace, index))

    def _draw_cursor(self, index: int) -> None:
        chart, position, points = self._chart, self._cursors[index], self._cursor_points[index]
        if position is None:
            return
        vertical, style = _CURSORS[index]
        x, y = crosshair(chart, position, points)
        column, row = self._column_at(x), self._row_at(y)
        if column is not None and not chart.curve_label:
            cells = self._characters[:, column]
            cells[cells == _BLANK] = vertical
            self._styles[:, column] = style
            if not chart.is_plane:
                self._strips[:, column], self._strip_styles[:, column] = vertical, style
        if row is not None and chart.is_plane and not chart.curve_label:
            cells = self._characters[row]
            cells[cells == _BLANK] = _HORIZONTAL
            self._styles[row] = style
        # Points of stacked areas are above those below them.
        for point in points if not chart.stacked else ():
            self._write_at(point.x, point.y, CURSOR_SIGNS[index], style)

    def lines(self) -> Iterator[list[Span]]:
        """The rows of plot and strips from the top, split into runs of one style."""
        for characters, styles in zip(self._all_characters, self._all_styles, strict=True):
            text = "".join(characters.tolist())
            bounds = [0, *(np.flatnonzero(styles[1:] != styles[:-1]) + 1).tolist(), len(text)]
            yield [(text[start:stop], styles[start]) for start, stop in pairwise(bounds)]


def _cell_index(position: float, cells: int) -> int:
    # Index of the cell at an axis position from 0 to 1, but for rounding errors.
    return min(max(int(position * cells), 0), cells - 1)


def _margins(axis: Axis, rows: int) -> list[str]:
    # The margin of every row: the line of the axis, with ticks and their labels.
    ticks, labels = axis.ticks(_max_y_ticks(rows))
    width = max(MARGIN, *(len(label) + 1 for label in labels))
    margins = ["│".rjust(width)] * rows
    for position, label in zip(axis.positions(ticks).tolist(), labels, strict=True):
        margins[rows - 1 - _cell_index(position, rows)] = label.rjust(width - 1) + "┤"
    return margins


def _x_labels(axis: Axis, columns: int) -> list[tuple[float, int, str]]:
    # The ticks of x, the first columns of their labels, and the labels: as many as have gaps.
    max_count = min(columns // _COLUMNS_PER_TICK, _MAX_X_TICKS)
    for count in range(max(max_count, 2), 0, -1):
        labels = []
        for tick, text in zip(*axis.ticks(count), strict=True):
            start = _cell_index(float(axis.positions(tick)), columns) - len(text) // 2
            labels.append((tick, max(min(start, columns - len(text)), 0), text))
        gaps = [after[1] - start - len(text) for (_, start, text), after in pairwise(labels)]
        if min(gaps, default=_LABEL_GAP) >= _LABEL_GAP:
            return labels
    return labels[:1]


def _x_axis_line(axis: Axis, label: str, margin: int, columns: int) -> list[Span]:
    # The name of the axis, if it is short, and the labels of the ticks.
    line = [" "] * columns
    for _, start, text in _x_labels(axis, columns):
        line[start : start + len(text)] = text
    name = label if len(label) <= MARGIN else ""
    return [(name.ljust(margin), "label"), ("".join(line), "tick")]


def _wrap_spans(spans: Sequence[Span], width: int, reserved: int) -> list[list[Span]]:
    # Wrap between spans; a span longer than a line is cut.
    lines: list[list[Span]] = [[]]
    free_width = width - reserved
    for text, style in spans:
        if len(text.rstrip()) > free_width and lines[-1]:
            lines[-1].append((" " * free_width, "plot"))
            lines.append([])
            free_width = width
        fitting_text = text[: max(free_width, 0)]
        lines[-1].append((fitting_text, style))
        free_width -= len(fitting_text)
    lines[-1].append((" " * free_width, "plot"))
    lines[0].append((" " * reserved, "plot"))
    return lines
