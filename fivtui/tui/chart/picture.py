"""A chart drawn in characters: rows of styled text. Imports no Textual.

The plot area shows the backdrop (shades), guides (reference lines), traces and cursors of a chart.
The heading is above it, ticks are left of it, and strips (marked intervals of x) are below it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from operator import itemgetter
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
    NearestPoint,
    Position,
    Span,
    Trace,
    View,
    covered_shares,
    crosshair,
    guide_style,
    heading_spans,
    points_at,
    reduce_trace,
    shade_text,
    trace_band,
    trace_mark,
    trace_style,
)

from .raster import DOTS_X, Raster

# Columns left of the plot area, with the tick labels of y.
MARGIN: Final = 8
_COLUMNS_PER_TICK: Final = 8
_ROWS_PER_TICK: Final = 2
# Rows of the plot for which lines of a heading are omitted: more for a legend, fewer for texts that
# are needed, such as values at cursors.
_MIN_ROWS_BELOW_LEGEND: Final = 7
_MIN_ROWS_BELOW_NEEDED: Final = 2
# Where traces share cells, each is drawn in stripes of this many columns.
_STRIPE_WIDTH: Final = 2
# Bits of the Braille dots that fill a cell inside a dense trace.
_FILLING_MASK: Final = 0b10010101
_ALL_DOTS: Final = 0b11111111
_BLANK: Final = ord(" ")
_VERTICAL: Final = ord("│")
_HORIZONTAL: Final = ord("─")
_CROSSING: Final = ord("┼")
# Character of the line and style of both cursors.
_CURSORS: Final = ((ord("│"), "cursor"), (ord("┊"), "cursor-2"))


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

    def axis_positions(self, column: float, row: float) -> tuple[float, float]:
        """Axis positions of the middle of a character cell; from 0 to 1 inside the plot area."""
        area = self.plot_area
        x = (column - area.first_column + 0.5) / area.columns
        return x, 1.0 - (row - area.top_row + 0.5) / area.rows


def draw(chart: Chart, view: View, width: int, height: int, *, reserved: int = 0) -> Picture:
    """Draw a chart in `width` by `height` characters; `reserved` columns of line 1 stay blank."""
    bottom_rows = len(chart.strips) + int(chart.x_axis)
    x_axis, y_axis = view.axes(chart)
    cursors = (view.cursors.first, view.cursors.second)
    cursor_points = [points_at(chart, view, position) for position in cursors]
    lines, needed_lines = _wrap_spans(*heading_spans(chart, view, *cursor_points), width, reserved)
    # A long heading loses its last lines, to leave a few rows for the plot.
    free_rows = height - bottom_rows
    needed_rows = min(needed_lines, free_rows - _MIN_ROWS_BELOW_NEEDED)
    heading_rows = max(needed_rows, free_rows - _MIN_ROWS_BELOW_LEGEND, 1)
    del lines[heading_rows:]
    top_row = len(lines)
    columns, rows = max(width - MARGIN, 1), max(height - top_row - bottom_rows, 1)
    canvas = _Canvas(columns, rows, x_axis, y_axis)
    if chart.backdrop is not None:
        canvas.draw_backdrop(chart.backdrop)
    canvas.draw_guides(chart)
    canvas.draw_curves(list(view.visible_traces(chart)))
    for index, trace in view.visible_traces(chart):
        canvas.draw_points(index, trace)
    canvas.draw_guide_labels()
    if len(chart.traces) > 1:
        canvas.draw_trace_numbers(chart, view)
    # The first cursor is drawn over the second.
    for index in (1, 0):
        canvas.draw_cursor(index, chart, cursors[index], cursor_points[index])
    margin = _row_labels(y_axis, *y_axis.ticks(_tick_counts(columns, rows)[1]), rows)
    for label, row in zip(margin, canvas.rows(), strict=True):
        lines.append([(label, "tick"), *row])
    for strip in chart.strips:
        shares = covered_shares(strip.intervals, (x_axis.low, x_axis.high), columns)
        label_span = (strip.label[:MARGIN].rjust(MARGIN), "tick")
        lines.append([label_span, *canvas.strip_spans(shade_text(shares), chart, cursors)])
    if chart.x_axis:
        lines.append(_column_labels(x_axis, chart.x_label, columns))
    return Picture(lines[:height], PlotArea(MARGIN, top_row, columns, rows))


def axis_ticks(x_axis: Axis, y_axis: Axis, columns: int, rows: int) -> AxisTicks:
    """The ticks of both axes of a plot."""
    x_count, y_count = _tick_counts(columns, rows)
    return x_axis.ticks(x_count)[0], y_axis.ticks(y_count)[0]


def _tick_counts(columns: int, rows: int) -> tuple[int, int]:
    # Greatest numbers of ticks of x and y.
    return max(columns // _COLUMNS_PER_TICK, 2), max(rows // _ROWS_PER_TICK, 2)


class _Canvas:
    # The cells of the plot area: code points of characters, and indices of style names.

    def __init__(self, columns: int, rows: int, x_axis: Axis, y_axis: Axis) -> None:
        self._columns, self._rows = columns, rows
        self._x_axis, self._y_axis = x_axis, y_axis
        self._characters = np.full((rows, columns), _BLANK, dtype=np.uint32)
        self._styles = np.zeros((rows, columns), dtype=np.intp)
        self._style_names = ["plot"]
        # Bits of the dots at the edges of each trace with lines or dots, by its index.
        self._edges: dict[int, NDArray[np.uint32]] = {}
        # Row, first column, text and style of the labels of guides.
        self._guide_labels: list[tuple[int, int, str, int]] = []

    def _style_id(self, name: str) -> int:
        # Index of a style; a new style is appended.
        if name not in self._style_names:
            self._style_names.append(name)
        return self._style_names.index(name)

    def draw_backdrop(self, backdrop: Backdrop) -> None:
        # Coordinates of the middle of the columns and rows.
        x_positions = (np.arange(self._columns) + 0.5) / self._columns
        y_positions = 1.0 - (np.arange(self._rows) + 0.5) / self._rows
        cell_x = np.array([self._x_axis.value(position) for position in x_positions.tolist()])
        cell_y = np.array([self._y_axis.value(position) for position in y_positions.tolist()])
        x_indices, y_indices = _nearest(backdrop.x, cell_x), _nearest(backdrop.y, cell_y)
        levels = backdrop.levels[x_indices[None, :], y_indices[:, None]]
        shades = [(ord(shade.character), self._style_id(shade.style)) for shade in backdrop.shades]
        characters, styles = np.array(shades, dtype=np.intp).T
        outside_x = (cell_x < backdrop.x[0]) | (cell_x > backdrop.x[-1])
        outside_y = (cell_y < backdrop.y[0]) | (cell_y > backdrop.y[-1])
        inside = ~(outside_x[None, :] | outside_y[:, None])
        self._characters[inside] = characters[levels][inside]
        self._styles[inside] = styles[levels][inside]
        for x, y, text in backdrop.labels:
            column, row = self._column_at(x), self._row_at(y)
            if column is not None and row is not None:
                padded = f" {text} "
                self._write(row, column - len(padded) // 2, padded, self._style_id("plot"))

    def draw_guides(self, chart: Chart) -> None:
        labels = self._guide_labels
        for guide in chart.guides:
            style = self._style_id(guide_style(guide))
            axis = self._x_axis if guide.vertical else self._y_axis
            position = float(axis.positions([guide.value])[0])
            if not 0.0 <= position <= 1.0:
                continue
            if guide.vertical:
                column = _cell_index(position, self._columns)
                self._draw_line(self._characters[:, column], _VERTICAL, _HORIZONTAL)
                self._styles[:, column] = style
                # Labels have separate rows, so that neighbours do not overlap.
                labels.append((min(len(labels), self._rows - 1), column + 1, guide.label, style))
            else:
                row = self._rows - 1 - _cell_index(position, self._rows)
                self._draw_line(self._characters[row], _HORIZONTAL, _VERTICAL)
                self._styles[row] = style
                labels.append((row, self._columns - len(guide.label), guide.label, style))

    def draw_guide_labels(self) -> None:
        for row, column, label, style in self._guide_labels:
            self._write(row, column, label, style)

    @staticmethod
    def _draw_line(cells: NDArray[np.uint32], line: int, crossed_line: int) -> None:
        cells[:] = np.where(cells == crossed_line, _CROSSING, line)

    def _write(self, row: int, column: int, text: str, style: int) -> None:
        column = max(min(column, self._columns - len(text)), 0)
        text = text[: self._columns - column]
        self._characters[row, column : column + len(text)] = [ord(character) for character in text]
        self._styles[row, column : column + len(text)] = style

    def _trace_positions(self, trace: Trace) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        # Axis positions (0 to 1) of the points, reduced to the resolution of the plot.
        x, y = reduce_trace(trace, self._x_axis, DOTS_X * self._columns)
        return self._x_axis.positions(x), self._y_axis.positions(y)

    def draw_curves(self, traces: Sequence[tuple[int, Trace]]) -> None:
        """Draw lines and dots; of several traces only the top one is filled where it is dense."""
        lines = [(index, trace) for index, trace in reversed(traces) if trace.look != "points"]
        if not lines:
            return
        # The topmost trace is first. Bits of its dots by row and column, all and inside.
        rasters = [self._raster(trace, *self._trace_positions(trace)) for _, trace in lines]
        cells = np.array([raster.cells for raster in rasters])
        inner_cells = np.array([raster.inner_cells for raster in rasters])
        styles = np.array([self._style_id(trace_style(trace, index)) for index, trace in lines])
        filling = inner_cells[0] & (_FILLING_MASK if lines[0][1].ordered else _ALL_DOTS)
        self._characters[filling > 0] = Raster.BLANK + filling[filling > 0]
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
        is_drawn = counts > 0
        self._characters[is_drawn] = Raster.BLANK + cell_dots[is_drawn]
        self._styles[is_drawn] = styles[is_shown.argmax(axis=0)][is_drawn]
        self._edges = {index: edge for (index, _), edge in zip(lines, dots, strict=True)}

    def draw_points(self, index: int, trace: Trace) -> None:
        """Draw the marks of a trace."""
        if trace.look in ("points", "marked"):
            x, y = self._trace_positions(trace)
            style = self._style_id(trace_style(trace, index))
            inside = (x >= 0.0) & (x <= 1.0) & (y >= 0.0) & (y <= 1.0)
            cells = self._cells_at(x[inside], y[inside])
            self._characters[cells] = ord(trace_mark(trace, index))
            self._styles[cells] = style

    def _raster(self, trace: Trace, x: NDArray[np.float64], y: NDArray[np.float64]) -> Raster:
        raster = Raster(self._columns, self._rows)
        if trace.look == "dots":
            raster.draw_dots(x, y)
        elif trace.ordered:
            raster.draw_lines(x, y)
            band = trace_band(trace, self._x_axis, DOTS_X * self._columns)
            raster.fill_columns(*map(self._y_axis.positions, band))
        else:
            # Unordered traces are not reduced to what the plot resolves. To limit the time, lines
            # join the last samples only.
            dot_count = max(x.size - MAX_JOINED_SAMPLES, 0)
            raster.draw_dots(x[:dot_count], y[:dot_count])
            raster.draw_lines(x[dot_count:], y[dot_count:])
        return raster

    def _cells_at(
        self, x: NDArray[np.float64], y: NDArray[np.float64]
    ) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        # Rows and columns of axis positions.
        columns = np.minimum((x * self._columns).astype(np.intp), self._columns - 1)
        rows = self._rows - 1 - np.minimum((y * self._rows).astype(np.intp), self._rows - 1)
        return rows, columns

    def draw_trace_numbers(self, chart: Chart, view: View) -> None:
        # Numbers distinguish lines without colour. They stand at evenly spaced x, or at the end of
        # an unordered trace.
        count = len(chart.traces)
        for index, trace in view.visible_traces(chart):
            if trace.look != "line" or not trace.x.size:
                continue
            target_x = self._x_axis.value((index + 0.5) / count)
            sample = int(np.searchsorted(trace.x, target_x)) if trace.ordered else trace.x.size - 1
            sample = min(sample, trace.x.size - 1)
            x = float(self._x_axis.positions([trace.x[sample]])[0])
            y = float(self._y_axis.positions([trace.y[sample]])[0])
            if 0.0 <= x <= 1.0 and 0.0 <= y <= 1.0:
                (row,), (column,) = self._cells_at(np.array([x]), np.array([y]))
                # A dense trace has its number at its nearest edge.
                edge_rows = np.flatnonzero(self._edges[index][:, column])
                if edge_rows.size:
                    row = edge_rows[np.abs(edge_rows - row).argmin()]
                self._characters[row, column] = ord(trace_mark(trace, index))
                self._styles[row, column] = self._style_id(trace_style(trace, index))

    def draw_cursor(
        self, index: int, chart: Chart, position: Position | None, points: Sequence[NearestPoint]
    ) -> None:
        if position is None:
            return
        vertical, style_name = _CURSORS[index]
        style = self._style_id(style_name)
        x, y = crosshair(chart, position, points)
        column, row = self._column_at(x), self._row_at(y)
        if column is not None and not chart.curve_label:
            cells = self._characters[:, column]
            cells[cells == _BLANK] = vertical
            self._styles[:, column] = style
        if row is not None and chart.is_plane and not chart.curve_label:
            cells = self._characters[row]
            cells[cells == _BLANK] = _HORIZONTAL
            self._styles[row] = style
        for point in points:
            column, row = self._column_at(point.x), self._row_at(point.y)
            if column is not None and row is not None:
                self._characters[row, column] = ord(CURSOR_SIGNS[index])
                self._styles[row, column] = style

    def _column_at(self, x: float) -> int | None:
        position = float(self._x_axis.positions([x])[0])
        return _cell_index(position, self._columns) if 0.0 <= position <= 1.0 else None

    def _row_at(self, y: float) -> int | None:
        height = float(self._y_axis.positions([y])[0])
        return self._rows - 1 - _cell_index(height, self._rows) if 0.0 <= height <= 1.0 else None

    def strip_spans(
        self, shades: str, chart: Chart, cursors: Sequence[Position | None]
    ) -> Iterator[Span]:
        """The shades of a row below the plot, with the cursors."""
        styles, characters = ["strip"] * len(shades), list(shades)
        for index in (1, 0):
            position = cursors[index]
            column = None if position is None or chart.is_plane else self._column_at(position[0])
            if column is not None:
                line, styles[column] = _CURSORS[index]
                characters[column] = chr(line)
        for style, group in groupby(zip(characters, styles, strict=True), key=itemgetter(1)):
            yield "".join(character for character, _ in group), style

    def rows(self) -> Iterator[list[Span]]:
        """The rows from the top, split into runs of one style."""
        for characters, styles in zip(self._characters, self._styles, strict=True):
            text = "".join(map(chr, characters.tolist()))
            bounds = [0, *(np.flatnonzero(np.diff(styles)) + 1).tolist(), len(text)]
            yield [
                (text[start:stop], self._style_names[int(styles[start])])
                for start, stop in pairwise(bounds)
            ]


def _cell_index(position: float, cells: int) -> int:
    # Index of the cell at an axis position; position 1 is in the last cell.
    return min(int(position * cells), cells - 1)


def _nearest(axis: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.intp]:
    # Indices of the values along `axis` that are nearest to `values`.
    upper = np.clip(np.searchsorted(axis, values), 1, axis.size - 1)
    lower_is_nearer = values - axis[upper - 1] < axis[upper] - values
    return upper - lower_is_nearer.astype(np.intp)


def _row_labels(axis: Axis, ticks: Sequence[float], labels: Sequence[str], rows: int) -> list[str]:
    # The margin of every row: the line of the axis, with a tick and its label.
    margin = ["│".rjust(MARGIN)] * rows
    for tick, label in zip(ticks, labels, strict=True):
        row = rows - 1 - _cell_index(float(axis.positions([tick])[0]), rows)
        if 0 <= row < rows:
            margin[row] = label[: MARGIN - 1].rjust(MARGIN - 1) + "┤"
    return margin


def _column_labels(axis: Axis, label: str, columns: int) -> list[Span]:
    # The line of tick labels of x. The name of the axis is left of it, or if long, at its end.
    ticks, labels = axis.ticks(_tick_counts(columns, 0)[0])
    left_label = label if len(label) < MARGIN else ""
    end_label = "" if left_label else label[:columns]
    line = [" "] * (columns - len(end_label))
    free_column = 0
    for tick, text in zip(ticks, labels, strict=True):
        tick_column = _cell_index(float(axis.positions([tick])[0]), columns)
        start = max(min(tick_column - len(text) // 2, columns - len(text)), 0)
        if start >= free_column and start + len(text) <= len(line) - bool(end_label):
            line[start : start + len(text)] = text
            free_column = start + len(text) + 1
    return [(left_label.ljust(MARGIN), "label"), ("".join(line), "tick"), (end_label, "label")]


def _wrap_spans(
    spans: Sequence[Span], needed_spans: int, width: int, reserved: int
) -> tuple[list[list[Span]], int]:
    # Wrap between spans; a span longer than a line is cut. Returns the lines, and how many of them
    # contain the first `needed_spans` spans.
    lines: list[list[Span]] = [[]]
    free_width, needed_lines = width - reserved, 1
    for span_index, (text, style) in enumerate(spans):
        if len(text.rstrip()) > free_width and lines[-1]:
            lines[-1].append((" " * free_width, "plot"))
            lines.append([])
            free_width = width
        fitting_text = text[: max(free_width, 0)]
        lines[-1].append((fitting_text, style))
        free_width -= len(fitting_text)
        needed_lines = len(lines) if span_index < needed_spans else needed_lines
    lines[-1].append((" " * free_width, "plot"))
    lines[0].append((" " * reserved, "plot"))
    return lines, needed_lines
