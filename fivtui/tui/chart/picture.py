"""A chart drawn in characters: rows of styled text. Imports no Textual."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from operator import itemgetter
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.charts import (
    CURSOR_SIGNS,
    MAX_JOINED_SAMPLES,
    Axis,
    Backdrop,
    Chart,
    NearestPoint,
    Position,
    Span,
    Trace,
    View,
    covered_shares,
    crosshair,
    heading_spans,
    nearest_points,
    reduce_trace,
    shade_text,
    trace_mark,
    trace_style,
)

from .raster import DOTS_X, Raster

MARGIN: Final = 8
_TICK_WIDTH: Final = 8
_TICK_HEIGHT: Final = 2
# Minimum rows of the plot below a long legend, and below read-outs.
_MIN_ROWS: Final = 7
_MIN_ROWS_READ: Final = 2
# Cells shared by several traces: width of their stripes in columns, number of dots of a dense cell,
# and pattern that thins the dots of a covered trace.
_STRIPE: Final = 2
_DENSE: Final = 5
_SPARSE: Final = 0x95
_VERTICAL: Final = ord("│")
_HORIZONTAL: Final = ord("─")
_CROSSED: Final = ord("┼")
# Line, character and style of the cursors.
_CURSORS: Final = ((ord("│"), "cursor"), (ord("┊"), "cursor-2"))


@dataclass(frozen=True, slots=True)
class Picture:
    """A chart drawn in characters."""

    lines: list[list[Span]]
    plot: tuple[int, int, int, int]

    def text(self) -> str:
        """The characters without styles, line by line."""
        return "\n".join("".join(text for text, _ in line) for line in self.lines)

    def axis_positions(self, column: float, row: float) -> tuple[float, float]:
        """Axis positions (0 to 1 inside the plot) of the middle of a character cell."""
        first_column, top, columns, rows = self.plot
        return (column - first_column + 0.5) / columns, 1.0 - (row - top + 0.5) / rows


def draw(chart: Chart, view: View, width: int, height: int, *, reserved: int = 0) -> Picture:
    """Draw a chart in `width` by `height` characters; `reserved` columns of line 1 stay blank."""
    below = len(chart.strips) + int(chart.x_axis)
    axes = view.axes(chart)
    cursors = (view.cursors.first, view.cursors.second)
    read_points = [nearest_points(chart, view, position) for position in cursors]
    lines, needed = _wrapped(*heading_spans(chart, view, *read_points), width, reserved)
    # Shorten the legend to keep a few rows for the plot.
    heading_rows = max(min(needed, height - below - _MIN_ROWS_READ), height - below - _MIN_ROWS, 1)
    del lines[heading_rows:]
    top = len(lines)
    columns, rows = max(width - MARGIN, 1), max(height - top - below, 1)
    canvas = _Canvas(columns, rows, axes)
    if chart.backdrop is not None:
        canvas.shade(chart.backdrop)
    canvas.guide(chart)
    canvas.curves(list(view.visible_traces(chart)))
    for index, trace in view.visible_traces(chart):
        canvas.points(index, trace)
    canvas.label_guides()
    if len(chart.traces) > 1:
        canvas.number(chart, view)
    for index in (1, 0):
        canvas.cursor(index, chart, cursors[index], read_points[index])
    ticks, labels = axes[1].ticks(max(rows // _TICK_HEIGHT, 2))
    margin = _row_labels(axes[1], ticks, labels, rows)
    for label, row in zip(margin, canvas.rows(), strict=True):
        lines.append([(label, "tick"), *row])
    for strip in chart.strips:
        share = covered_shares(strip.intervals, (axes[0].low, axes[0].high), columns)
        name = (strip.label[:MARGIN].rjust(MARGIN), "tick")
        lines.append([name, *canvas.strip(shade_text(share), chart, cursors)])
    if chart.x_axis:
        lines.append(_column_labels(axes[0], chart.x_label, columns))
    return Picture(lines[:height], (MARGIN, top, columns, rows))


class _Canvas:
    # The cells of the plot area: characters and styles.

    def __init__(self, columns: int, rows: int, axes: tuple[Axis, Axis]) -> None:
        self._columns, self._rows = columns, rows
        self._axes = axes
        self._characters = np.full((rows, columns), ord(" "), dtype=np.uint32)
        self._styles = np.zeros((rows, columns), dtype=np.intp)
        self._names = ["plot"]
        self._labels: list[tuple[int, int, str]] = []

    def _style(self, name: str) -> int:
        if name not in self._names:
            self._names.append(name)
        return self._names.index(name)

    def shade(self, backdrop: Backdrop) -> None:
        x, y = self._axes
        across = np.array([x.value((c + 0.5) / self._columns) for c in range(self._columns)])
        up = np.array([y.value(1.0 - (r + 0.5) / self._rows) for r in range(self._rows)])
        levels = backdrop.levels[
            _closest(backdrop.x, across)[None, :], _closest(backdrop.y, up)[:, None]
        ]
        shades = [(ord(shade.character), self._style(shade.style)) for shade in backdrop.shades]
        characters, styles = np.array(shades, dtype=np.intp).T
        outside = (across < backdrop.x[0]) | (across > backdrop.x[-1])
        beyond = (up < backdrop.y[0]) | (up > backdrop.y[-1])
        inside = ~(outside[None, :] | beyond[:, None])
        self._characters[inside] = characters[levels][inside]
        self._styles[inside] = styles[levels][inside]

    def guide(self, chart: Chart) -> None:
        style = self._style("guide")
        labels = self._labels
        for guide in chart.guides:
            axis = self._axes[0 if guide.vertical else 1]
            position = float(axis.positions([guide.value])[0])
            if not 0.0 <= position <= 1.0:
                continue
            if guide.vertical:
                column = _cell(position, self._columns)
                self._line(self._characters[:, column], _VERTICAL, _HORIZONTAL)
                self._styles[:, column] = style
                # One row per label, so that neighbours do not overlap.
                labels.append((min(len(labels), self._rows - 1), column + 1, guide.label))
            else:
                row = self._rows - 1 - _cell(position, self._rows)
                self._line(self._characters[row], _HORIZONTAL, _VERTICAL)
                self._styles[row] = style
                labels.append((row, self._columns - len(guide.label), guide.label))

    def label_guides(self) -> None:
        style = self._style("guide")
        for row, column, label in self._labels:
            self._write(row, column, label, style)

    @staticmethod
    def _line(cells: NDArray[np.uint32], line: int, crossing: int) -> None:
        cells[:] = np.where(cells == crossing, _CROSSED, line)

    def _write(self, row: int, column: int, text: str, style: int) -> None:
        column = max(min(column, self._columns - len(text)), 0)
        text = text[: self._columns - column]
        self._characters[row, column : column + len(text)] = [ord(c) for c in text]
        self._styles[row, column : column + len(text)] = style

    def _places(self, trace: Trace) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        x, y = reduce_trace(trace, self._axes[0], DOTS_X * self._columns)
        return self._axes[0].positions(x), self._axes[1].positions(y)

    def curves(self, traces: Sequence[tuple[int, Trace]]) -> None:
        """Draw lines and dots; in cells shared by several traces, stripes show each of them."""
        drawn = [(index, trace) for index, trace in traces if trace.look != "points"]
        rasters = [self._raster(trace, *self._places(trace)) for _, trace in drawn]
        if not rasters:
            return
        # From the top trace down.
        cells = np.array([raster.cells for raster in reversed(rasters)])
        styles = [self._style(trace_style(trace, index)) for index, trace in reversed(drawn)]
        present = cells > 0
        counts = present.sum(axis=0)
        stripe = np.arange(self._columns)[None, :] // _STRIPE
        turn = stripe % np.maximum(counts, 1)
        owned = present & (np.cumsum(present, axis=0) - 1 == turn)
        dense = np.bitwise_count(cells) >= _DENSE
        # Fewer dots distinguish the stripes without colour.
        covered = np.where(owned[1:] & dense[1:] & (turn > 0), cells[1:] & _SPARSE, 0).sum(axis=0)
        dots = np.where(covered > 0, covered, np.bitwise_or.reduce(cells, axis=0))
        where = counts > 0
        self._characters[where] = Raster.BLANK + dots[where]
        self._styles[where] = np.array(styles)[owned.argmax(axis=0)][where]

    def points(self, index: int, trace: Trace) -> None:
        """Draw the marks of a trace."""
        if trace.look in ("points", "marked"):
            across, up = self._places(trace)
            style = self._style(trace_style(trace, index))
            inside = (across >= 0.0) & (across <= 1.0) & (up >= 0.0) & (up <= 1.0)
            where = self._where(across[inside], up[inside])
            self._characters[where] = ord(trace_mark(trace, index))
            self._styles[where] = style

    def _raster(self, trace: Trace, across: NDArray[np.float64], up: NDArray[np.float64]) -> Raster:
        raster = Raster(self._columns, self._rows)
        if trace.look == "dots":
            raster.dots(across, up)
        elif trace.ordered:
            raster.lines(across, up)
        else:
            early = max(across.size - MAX_JOINED_SAMPLES, 0)
            raster.dots(across[:early], up[:early])
            raster.lines(across[early:], up[early:])
        return raster

    def _where(
        self, across: NDArray[np.float64], up: NDArray[np.float64]
    ) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        columns = np.minimum((across * self._columns).astype(np.intp), self._columns - 1)
        rows = self._rows - 1 - np.minimum((up * self._rows).astype(np.intp), self._rows - 1)
        return rows, columns

    def number(self, chart: Chart, view: View) -> None:
        # Marks distinguish lines without colour.
        count = len(chart.traces)
        for index, trace in view.visible_traces(chart):
            if trace.look != "line" or not trace.x.size:
                continue
            target = self._axes[0].value((index + 0.5) / count)
            sample = int(np.searchsorted(trace.x, target)) if trace.ordered else trace.x.size - 1
            sample = min(sample, trace.x.size - 1)
            across = float(self._axes[0].positions([trace.x[sample]])[0])
            up = float(self._axes[1].positions([trace.y[sample]])[0])
            if 0.0 <= across <= 1.0 and 0.0 <= up <= 1.0:
                row, column = self._where(np.array([across]), np.array([up]))
                self._characters[row, column] = ord(trace_mark(trace, index))
                self._styles[row, column] = self._style(trace_style(trace, index))

    def cursor(
        self, index: int, chart: Chart, where: Position | None, points: Sequence[NearestPoint]
    ) -> None:
        if where is None:
            return
        vertical, name = _CURSORS[index]
        style = self._style(name)
        across, up = crosshair(chart, where, points)
        column, row = self._column(across), self._row(up)
        if column is not None and not chart.curve_label:
            cells = self._characters[:, column]
            cells[cells == ord(" ")] = vertical
            self._styles[:, column] = style
        if row is not None and chart.plane and not chart.curve_label:
            cells = self._characters[row]
            cells[cells == ord(" ")] = _HORIZONTAL
            self._styles[row] = style
        for point in points:
            column, row = self._column(point.x), self._row(point.y)
            if column is not None and row is not None:
                self._characters[row, column] = ord(CURSOR_SIGNS[index])
                self._styles[row, column] = style

    def _column(self, x: float) -> int | None:
        across = float(self._axes[0].positions([x])[0])
        return _cell(across, self._columns) if 0.0 <= across <= 1.0 else None

    def _row(self, y: float) -> int | None:
        up = float(self._axes[1].positions([y])[0])
        return self._rows - 1 - _cell(up, self._rows) if 0.0 <= up <= 1.0 else None

    def strip(
        self, shades: str, chart: Chart, cursors: Sequence[Position | None]
    ) -> Iterator[Span]:
        """A row below the plot, with the cursors."""
        styles, characters = ["strip"] * len(shades), list(shades)
        for index in (1, 0):
            position = cursors[index]
            column = None if position is None or chart.plane else self._column(position[0])
            if column is not None:
                characters[column], styles[column] = chr(_CURSORS[index][0]), _CURSORS[index][1]
        for style, group in groupby(zip(characters, styles, strict=True), key=itemgetter(1)):
            yield "".join(character for character, _ in group), style

    def rows(self) -> Iterator[list[Span]]:
        """The rows from the top, split into runs of one style."""
        for characters, styles in zip(self._characters, self._styles, strict=True):
            text = "".join(map(chr, characters.tolist()))
            starts = [0, *(np.flatnonzero(np.diff(styles)) + 1).tolist(), len(text)]
            yield [
                (text[begin:end], self._names[int(styles[begin])])
                for begin, end in pairwise(starts)
            ]


def _cell(position: float, cells: int) -> int:
    return min(int(position * cells), cells - 1)


def _closest(axis: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.intp]:
    above = np.clip(np.searchsorted(axis, values), 1, axis.size - 1)
    nearer = values - axis[above - 1] < axis[above] - values
    return above - nearer.astype(np.intp)


def _row_labels(axis: Axis, ticks: Sequence[float], labels: Sequence[str], rows: int) -> list[str]:
    margin = ["│".rjust(MARGIN)] * rows
    for tick, label in zip(ticks, labels, strict=True):
        row = rows - 1 - _cell(float(axis.positions([tick])[0]), rows)
        if 0 <= row < rows:
            margin[row] = label[: MARGIN - 1].rjust(MARGIN - 1) + "┤"
    return margin


def _column_labels(axis: Axis, label: str, columns: int) -> list[Span]:
    # The label is left of the axis, or at its end if it is too long.
    ticks, labels = axis.ticks(max(columns // _TICK_WIDTH, 2))
    before = label if len(label) < MARGIN else ""
    after = "" if before else label[:columns]
    line = [" "] * (columns - len(after))
    free = 0
    for tick, text in zip(ticks, labels, strict=True):
        middle = _cell(float(axis.positions([tick])[0]), columns)
        start = max(min(middle - len(text) // 2, columns - len(text)), 0)
        if start >= free and start + len(text) <= len(line) - bool(after):
            line[start : start + len(text)] = text
            free = start + len(text) + 1
    return [(before.ljust(MARGIN), "label"), ("".join(line), "tick"), (after, "label")]


def _wrapped(
    spans: Sequence[Span], needed: int, width: int, reserved: int
) -> tuple[list[list[Span]], int]:
    # Wrap between spans, and cut off spans longer than a line. Also returns the number of lines of
    # the first `needed` spans.
    lines: list[list[Span]] = [[]]
    room, count = width - reserved, 1
    for number, (text, style) in enumerate(spans):
        if len(text.rstrip()) > room and lines[-1]:
            lines[-1].append((" " * room, "plot"))
            lines.append([])
            room = width
        part = text[: max(room, 0)]
        lines[-1].append((part, style))
        room -= len(part)
        count = len(lines) if number < needed else count
    lines[-1].append((" " * room, "plot"))
    lines[0].append((" " * reserved, "plot"))
    return lines, count
