"""A chart as data: traces, reference lines, shades; and its visible part.

The terminal draws a `Chart` within the limits of its `View`; matplotlib draws the charts of a
`Sheet` as a figure. Attributes that only one of them uses are described so. The laboratory is
fivtui's terminal program.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Parameters

from .axis import Axis, axis_for
from .colours import series_role
from .shades import ColourScale, Shades

FloatArray = NDArray[np.float64]
# Lower and upper limit of an axis in figures; None fits a limit to the data.
FigureLimits = tuple[float | None, float | None]
# How a trace is drawn; `Trace` describes the values.
Look = Literal["line", "points", "dots", "marked", "bars", "area"]

# Width of a full figure, inches.
FIGURE_WIDTH: Final = 7.2
# Lines join this many last samples of an unordered trace; earlier samples are drawn as dots.
MAX_JOINED_SAMPLES: Final = 16_384
# Roles of the colours of reference lines that have a meaning.
_GUIDE_COLOURS: Final = {"critical": "danger", "safe": "safe", "belt": "belt"}
# Limits of x show all data if they are shorter than the data by at most this fraction.
_LENGTH_TOLERANCE: Final = 1e-6
# Limits of y include a line without label or role if it is at most this fraction of their length
# outside those of the data.
_GUIDE_REACH: Final = 0.3
# Part of the data that is shown at their start or end if the limits showed all data.
_END_SHARE: Final = 0.1
# Dashes and colours of runs with separation considered (True) and ignored (False).
CASE_LINES: Final[Mapping[bool, Any]] = {True: (0.0, (4.0, 1.5)), False: "-"}
CASE_COLOURS: Final[Mapping[bool, Sequence[str]]] = {
    True: ("series-2", "series-3", "series-5", "series-7"),
    False: ("series-1", "series-4", "series-6"),
}
# Colours of lines in the order of a figure's legend, close to those of the paper that README.md
# names: black, blue, red, yellow. Red is the colour of danger, which no line has.
LINE_COLOURS: Final = ("series-3", "series-1", "series-4", "series-2")


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """A named series of points.

    Attributes
    ----------
    name : str
        Short name for the legend.
    x, y : ndarray, shape (n,)
        The points; NaN is a gap.
    look : "line", "points", "dots", "marked", "bars" or "area"
        "line": a line. "points": a character per point. "dots": a dot per point. "marked": a line
        with a character per point. In figures only, "bars": bars from x = 0; "area": the area
        that the points enclose.
    ordered : bool
        Whether x ascends, so that y is a function of x. Such a trace is drawn with at most four
        points per column of the plot.
    mark : str
        Character of the points; if empty, a line is marked by its number in the legend, from 1.
    colour : str
        Key of `INKS`; if empty, that of the role in figures, or of a series.
    curve_values : ndarray, shape (n,), optional
        Values of the points, such as times, that ascend along the curve. A cursor that moves along
        it, see `Chart.curve_label`, is at one of these values.
    number : int
        Number of the run in the laboratory; 0 if the trace is not a run.
    role : str
        Key of `ROLES` in `sheet.py`, the styles in figures.
    marker : str
        Matplotlib's marker of the points in figures; if empty, the marker of the role.
    values : ndarray, shape (n,), optional
        Values of the points, by which figures colour them.
    intervals : tuple of ndarray, optional
        Lower and upper ends of the error intervals of bars.
    style : mapping
        Properties in figures, as matplotlib names them; they override those of the role.
    """

    name: str
    x: FloatArray
    y: FloatArray
    look: Look = "line"
    ordered: bool = True
    mark: str = ""
    colour: str = ""
    curve_values: FloatArray | None = None
    number: int = 0
    role: str = ""
    marker: str = ""
    values: FloatArray | None = None
    intervals: tuple[FloatArray, FloatArray] | None = None
    style: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Guide:
    """A labelled reference line at a value of x (vertical) or of y.

    Attributes
    ----------
    value : float
        Position of the line.
    label : str
        Text beside the line in the terminal, and in the legend of figures.
    vertical : bool
        Whether the line is at a value of x.
    role : str
        Key of `ROLES`, the styles in figures; ``"floor"`` shades the area below the line. Limits
        that fit the data include horizontal lines that have a role or a label.
    """

    value: float
    label: str = ""
    vertical: bool = True
    role: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Strip:
    """Intervals along x that are marked below the plot.

    Attributes
    ----------
    label : str
        Name in the margin, of few characters.
    meaning : str
        Name in legends.
    intervals : sequence of (start, end)
        Ascending and disjoint.
    """

    label: str
    meaning: str
    intervals: Sequence[tuple[float, float]]


@dataclass(frozen=True, slots=True, eq=False)
class Contours:
    """Lines of equal values over the plane of a backdrop, drawn in figures.

    Attributes
    ----------
    values : ndarray, shape (n, k)
        The values; NaN where undefined.
    line_values : sequence of float
        Values of the lines.
    role : str
        Key of `ROLES`, the styles in figures.
    name : str
        Entry in the legend; if empty, there is none.
    label : str
        Format of the labels on lines, such as ``%g m``; if empty, there are no labels.
    """

    values: FloatArray
    line_values: Sequence[float]
    role: str = "contours"
    name: str = ""
    label: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Backdrop:
    """Values over the plane, drawn as shades behind the traces.

    Attributes
    ----------
    x, y : ndarray, shapes (n,) and (k,)
        Ascending coordinates.
    levels : ndarray of int, shape (n, k)
        Index into `shades` of every point.
    shades : sequence of Shade
        How the points of every level are drawn.
    values : ndarray, shape (n, k)
        The values themselves; NaN where undefined.
    label : str
        Quantity and unit of the values.
    contours : sequence of Contours
        Lines over the shades in figures.
    labels : sequence of tuple of float, float and str
        Positions and texts of labels in the plane.
    """

    x: FloatArray
    y: FloatArray
    levels: NDArray[np.intp]
    shades: Shades
    values: FloatArray
    label: str
    contours: Sequence[Contours] = ()
    labels: Sequence[tuple[float, float, str]] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Chart:
    """A plot.

    Attributes
    ----------
    x_label, y_label : str
        Quantities with units.
    traces : tuple of Trace
        The last trace is drawn on top; keys 1 to 9 hide and show traces.
    guides : tuple of Guide
        Reference lines.
    backdrop : Backdrop, optional
        Shades behind the traces.
    colour_scale : ColourScale, optional
        Scale of the values of traces in figures.
    strips : tuple of Strip
        Rows of intervals marked below the plot, from the top.
    note : str
        Short text in the heading.
    title : str
        Title above the chart in figures.
    x_axis : bool
        Whether the ticks of the x axis are labelled.
    y_names : sequence of str
        Tick labels of y = 0, 1, … in figures; if empty, ticks are numbers.
    stacked : bool
        Whether figures stack the areas of traces over the same x.
    x_margins : bool
        Whether the x axis has margins; without them it ends where the data end.
    x_range, y_range : tuple of float, optional
        Limits before any zoom; if None, the axes fit the data.
    to_scale : bool
        Whether both axes have the same scale.
    curve_label : str
        Quantity and unit of the `curve_values` of traces; if not empty, cursors move along the
        curves, else over the plot.
    log : str
        Axes with a logarithmic scale in figures: ``"x"``, ``"y"``, ``"xy"`` or none.
    linear_within : float
        If not 0, the x axis in figures is linear up to this magnitude and logarithmic beyond.
    legend : "below", "above" or "inside"
        Position of the legend in figures: below all charts, above this chart, or inside it.
    figure_x, figure_y : tuple of float or None
        Limits in figures; None fits a limit to the data.
    """

    x_label: str
    y_label: str
    traces: tuple[Trace, ...]
    guides: tuple[Guide, ...] = ()
    backdrop: Backdrop | None = None
    colour_scale: ColourScale | None = None
    strips: tuple[Strip, ...] = ()
    note: str = ""
    title: str = ""
    x_axis: bool = True
    y_names: Sequence[str] = ()
    stacked: bool = False
    x_margins: bool = False
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None
    to_scale: bool = False
    curve_label: str = ""
    log: str = ""
    linear_within: float = 0.0
    legend: Literal["below", "above", "inside"] = "below"
    figure_x: FigureLimits = (None, None)
    figure_y: FigureLimits = (None, None)

    @property
    def cursor_label(self) -> str:
        """Quantity and unit of the positions of cursors; empty if positions are points (x, y)."""
        return self.curve_label or ("" if self.is_plane else self.x_label)

    @property
    def is_plane(self) -> bool:
        """Whether y is not a function of x; then both axes zoom and pan together."""
        return self.backdrop is not None or not all(trace.ordered for trace in self.traces)


Position = tuple[float, float]


@dataclass(slots=True)
class Cursors:
    """The two cursors of a chart, or of all charts over the same quantity.

    Attributes
    ----------
    first, second : tuple of float or None
        Positions (x, y). In a chart with a `curve_label`, x is one of the `curve_values`. y has a
        meaning only in a plane (`Chart.is_plane`) without that label.
    second_is_active : bool
        Whether the second cursor is active: keys move it.
    pinned : bool
        Whether the cursors are fixed: they do not follow the pointer.
    """

    first: Position | None = None
    second: Position | None = None
    second_is_active: bool = False
    pinned: bool = False

    @property
    def active_position(self) -> Position | None:
        """The position of the active cursor, which keys move."""
        return self.second if self.second_is_active else self.first

    def move(self, position: Position | None) -> None:
        """Move or remove the active cursor, which keys move."""
        if self.second_is_active:
            self.second = position
        else:
            self.first = position

    def clear(self) -> None:
        """Remove both cursors."""
        self.first = self.second = None
        self.second_is_active = self.pinned = False


@dataclass(slots=True)
class View:
    """The visible part of a chart.

    Attributes
    ----------
    x, y : Axis or None
        Chosen limits; None to fit the data.
    log_x, log_y : bool
        Whether the scales are logarithmic.
    hidden : set of int
        Indices of hidden traces.
    cursors : Cursors
        The cursors.
    newest_run_when_zoomed : int
        Greatest number of a displayed run when the limits were chosen; later runs may lie outside.
    rows : int
        Rows of characters of the plot, for ticks of y that are whole rows apart; 0 in figures.
    """

    x: Axis | None = None
    y: Axis | None = None
    log_x: bool = False
    log_y: bool = False
    hidden: set[int] = field(default_factory=set)
    cursors: Cursors = field(default_factory=Cursors)
    newest_run_when_zoomed: int = 0
    rows: int = 0

    def visible_traces(self, chart: Chart) -> Iterator[tuple[int, Trace]]:
        """The indices and traces of the chart that are not hidden."""
        return (
            (index, trace) for index, trace in enumerate(chart.traces) if index not in self.hidden
        )

    def axes(self, chart: Chart) -> tuple[Axis, Axis]:
        """The x and y axes: the chosen limits, or limits that fit the visible data."""
        x = self.x or self._fitted_x(chart)
        return x, self.y or self._fitted_y(chart, x)

    def _fitted_x(self, chart: Chart) -> Axis:
        if chart.x_range is not None and not self.log_x:
            return Axis(*chart.x_range)
        parts = [trace.x for _, trace in self.visible_traces(chart)]
        if chart.backdrop is not None:
            parts.append(chart.backdrop.x)
        if not self.log_x and not chart.x_margins and parts and not chart.is_plane:
            # x ascends: the ends suffice.
            parts = [part[[0, -1]] for part in parts if part.size]
        return axis_for(parts, log=self.log_x, tight=not chart.x_margins)

    def _fitted_y(self, chart: Chart, x: Axis) -> Axis:
        rows = 0 if chart.to_scale else self.rows
        if chart.y_range is not None and not self.log_y:
            return axis_for([chart.y_range], tight=True, rows=rows)
        parts = [
            values_within(trace, x) if trace.ordered else trace.y
            for _, trace in self.visible_traces(chart)
        ]
        if chart.backdrop is not None:
            return axis_for([*parts, chart.backdrop.y], log=self.log_y, tight=True, rows=rows)
        if chart.stacked and parts:
            parts = [np.zeros(1), np.sum(parts, axis=0)]
        for guide in chart.guides:
            if not guide.vertical:
                data = axis_for(parts, log=self.log_y)
                is_near = -_GUIDE_REACH <= data.positions(guide.value) <= 1.0 + _GUIDE_REACH
                if guide.label or guide.role or is_near:
                    parts.append(np.array([guide.value]))
        return axis_for(parts, log=self.log_y, rows=rows)

    def set_limits(self, chart: Chart, x: Axis | None, y: Axis | None) -> None:
        """Set the limits of both axes; None fits an axis to the data."""
        self.x, self.y = x, y
        self.newest_run_when_zoomed = max((trace.number for trace in chart.traces), default=0)

    def zoom(self, chart: Chart, factor: float, centre: tuple[float, float] = (0.5, 0.5)) -> None:
        """Zoom in (factor below 1) or out; only along x if y is a function of x.

        `centre` is the fixed point, as fractions of both axes.
        """
        x, y = self.axes(chart)
        zoomed_x = self._clamp_x(chart, x.transform(zoom=factor, centre=centre[0]))
        zoomed_y = y.transform(zoom=factor, centre=centre[1]) if chart.is_plane else self.y
        self.set_limits(chart, zoomed_x, zoomed_y)

    def zoom_y(self, chart: Chart, factor: float, centre: float = 0.5) -> None:
        """Zoom in (factor below 1) or out, only along y."""
        self.set_limits(chart, self.x, self.axes(chart)[1].transform(zoom=factor, centre=centre))

    def pan(self, chart: Chart, right: float, up: float = 0.0) -> None:
        """Move the limits by fractions of the axes' lengths."""
        x, y = self.axes(chart)
        self.set_limits(
            chart,
            self._clamp_x(chart, x.transform(shift=right)) if right else self.x,
            y.transform(shift=up) if up else self.y,
        )

    def show_end(self, chart: Chart, *, at_end: bool) -> None:
        """Move the limits of x to the start or end of the data; without limits, show a tenth."""
        data_axis = self._fitted_x(chart)
        length = _END_SHARE
        if self.x is not None:
            low, high = data_axis.positions([self.x.low, self.x.high]).tolist()
            length = min(high - low, 1.0)
        self.set_limits(chart, data_axis.transform(zoom=length, centre=float(at_end)), self.y)

    def _clamp_x(self, chart: Chart, x: Axis) -> Axis | None:
        # Where y is a function of x, limits stay within the data; None if they show all data.
        if chart.is_plane:
            return x
        low, high = self._fitted_x(chart).positions([x.low, x.high]).tolist()
        length = high - low
        if length >= 1.0 - _LENGTH_TOLERANCE:
            return None
        # How far the limits exceed the data, as fractions of the data axis; over `length` they are
        # fractions of x.
        below, above = max(-low, 0.0), max(high - 1.0, 0.0)
        return x.transform(shift=below / length - above / length)

    def reset(self) -> None:
        """Fit the limits to the data again."""
        self.x = self.y = None

    def toggle_log(self, *, x: bool) -> None:
        """Switch an axis between linear and logarithmic; its limits fit the data again."""
        if x:
            self.log_x, self.x = not self.log_x, None
        else:
            self.log_y, self.y = not self.log_y, None

    def toggle_trace(self, chart: Chart, index: int) -> bool:
        """Hide or show a trace. Returns False if there is no trace with this index."""
        if not 0 <= index < len(chart.traces):
            return False
        self.hidden ^= {index}
        return True


@dataclass(frozen=True, slots=True, eq=False)
class VisibleCharts:
    """The visible charts of a tab in order, each with its view."""

    panels: Sequence[tuple[Chart, View]]
    side_by_side: bool = False


def values_within(trace: Trace, x: Axis) -> FloatArray:
    """The values y of an ordered trace within the limits of x, plus a sample beyond each limit."""
    first, stop = np.searchsorted(trace.x, [x.low, x.high])
    return trace.y[max(int(first) - 1, 0) : int(stop) + 1]


def column_edges(x: Axis, columns: int) -> FloatArray:
    """The values of x at the edges of columns of equal width."""
    return x.values(np.linspace(0.0, 1.0, columns + 1))


def trace_style(trace: Trace, index: int) -> str:
    """Role of the colour of a trace, by default that of a series."""
    return trace.colour or series_role(index)


def guide_style(guide: Guide) -> str:
    """Role of the colour of a reference line."""
    return _GUIDE_COLOURS.get(guide.role, "reference")


def trace_mark(trace: Trace, index: int) -> str:
    """Character that marks a trace; by default the last digit of a line's legend number, else ●."""
    if trace.mark:
        return trace.mark
    return str(index + 1)[-1] if trace.look == "line" else "●"


@dataclass(frozen=True, slots=True)
class Heading:
    """The content of a figure's heading.

    Attributes
    ----------
    parameters : sequence of Parameters
        Parameter sets of all traces; the heading lists their common values.
    omitted : sequence of str
        Parameters that the heading omits, because they vary along an axis.
    ignores_separation : bool
        Whether all traces ignore separation.
    text : str
        What the charts show in words or numbers, in a line before the parameters.
    """

    parameters: Sequence[Parameters]
    omitted: Sequence[str] = ()
    ignores_separation: bool = False
    text: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """Charts that form a figure.

    Attributes
    ----------
    columns : sequence of sequences of Chart or None
        Columns from the left, with their charts from the top; None leaves a gap.
    size : tuple of float
        Width and height, inches.
    title : str
        Title above the charts, in matplotlib's mathtext.
    widths, heights : sequence of float
        Ratios of the widths of columns and the heights of rows; if empty, all are equal.
    parts : sequence of Sheet
        Sheets from the top, in place of columns.
    small_text : bool
        Whether the font is small, for many panels.
    """

    columns: Sequence[Sequence[Chart | None]]
    size: tuple[float, float]
    title: str = ""
    widths: Sequence[float] = ()
    heights: Sequence[float] = ()
    parts: Sequence["Sheet"] = ()
    small_text: bool = False
