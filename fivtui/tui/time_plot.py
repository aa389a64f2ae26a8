"""A plot over time, and the strip that marks separation."""

import math
from collections.abc import Sequence
from typing import ClassVar, Final

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Grid
from textual.geometry import Size
from textual.strip import Strip
from textual.widgets import Static
from textual_hires_canvas import Canvas, HiResMode
from textual_plot import LegendLocation, PlotWidget
from textual_plot.axis_formatter import NumericAxisFormatter
from textual_plot.plot_widget import Legend

from .messages import EndAsked, WindowReset
from .plot_data import (
    FloatArray,
    axis_limits,
    envelope,
    round_ticks,
    separated_share,
    shading,
    tick_labels,
)

MARGIN_LEFT: Final = 8
_FRAME: Final = 1
_ZOOM: Final = PlotWidget.ZOOM_GROUP
_PAN: Final = PlotWidget.PAN_GROUP
_TICK_WIDTH: Final = 6
_TICK_HEIGHT: Final = 2


class RoundTicks(NumericAxisFormatter):
    """Ticks that never crowd each other, with labels that fit the margin.

    Parameters
    ----------
    unit : str
        Appended to the last label.

    Attributes
    ----------
    most : int
        Number of ticks that there is room for.
    """

    most = 2

    def __init__(self, unit: str = "") -> None:
        self._unit = unit

    def get_ticks(self, min_: float, max_: float, max_ticks: int = 8) -> list[float]:
        """Ticks for an axis."""
        return round_ticks(min_, max_, min(self.most, max_ticks))

    def get_labels_for_ticks(self, ticks: Sequence[float]) -> list[str]:
        """Labels of a few characters, the last with the unit."""
        labels = tick_labels(ticks)
        return [*labels[:-1], f"{labels[-1]}{self._unit}"] if labels else []


class StyledCanvas(Canvas):
    """A canvas of which every line has a style, also before it knows its size.

    Textual's filter for NO_COLOR cannot take lines without.
    """

    def render_line(self, y: int) -> Strip:
        """A line of the canvas, blank if there is none yet."""
        strip = super().render_line(y)
        return strip if strip.cell_length else Strip.blank(self.size.width, self.rich_style)


class TimePlot(PlotWidget, inherit_bindings=False):
    """A signal over time, reduced to what its columns can show.

    Parameters
    ----------
    label : str
        Quantity and unit.
    time_axis : bool
        Whether the ticks of the time axis are labelled.
    id : str
        Identifier of the widget.
    """

    COMPONENT_CLASSES: ClassVar[set[str]] = {"plot--signal", "plot--zero"}
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("plus,equals_sign,k,up", "zoom_x_in", "Zoom in", key_display="+", group=_ZOOM),
        Binding("minus,j,down", "zoom_x_out", "Zoom out", key_display="-", group=_ZOOM),
        Binding("left,h", "pan_left", "Earlier", key_display="←", group=_PAN),
        Binding("right,l", "pan_right", "Later", key_display="→", group=_PAN),
        Binding("r", "reset_scales", "Whole"),
        Binding("e", "show_end", "End"),
    ]

    def __init__(self, label: str, *, time_axis: bool, id: str) -> None:  # noqa: A002
        super().__init__(id=id)
        self._label = label
        self.set_reactive(PlotWidget.margin_left, MARGIN_LEFT)
        self.set_reactive(PlotWidget.margin_top, 0)
        self.set_reactive(PlotWidget.margin_bottom, int(time_axis))
        self._ticks_x, self._ticks_y = RoundTicks(" s"), RoundTicks()
        self.set_x_formatter(self._ticks_x)
        self.set_y_formatter(self._ticks_y)

    def compose(self) -> ComposeResult:
        """The parts that the base class has, on canvases of our own."""
        with Grid():
            for part in ("margin-top", "margin-left", "plot", "margin-bottom"):
                yield StyledCanvas(1, 1, id=part)
        yield Legend(id="legend")

    @property
    def plot_size(self) -> Size:
        """Cells inside the frame."""
        size = self.query_one("#plot", Canvas).size
        return Size(max(size.width - 2 * _FRAME, 1), max(size.height - 2 * _FRAME, 1))

    def show(self, t: FloatArray, values: FloatArray, window: tuple[float, float]) -> None:
        """Draw a signal.

        Parameters
        ----------
        t, values : ndarray, shape (n,)
            Ascending times, s, and the signal.
        window : tuple of float
            First and last time shown, s.
        """
        # Two dots of a braille character lie side by side.
        size = self.plot_size
        t, values = envelope(t, values, window, 2 * size.width)
        low, high = axis_limits(float(values.min()), float(values.max()))
        self._ticks_x.most = max(size.width // _TICK_WIDTH, 2)
        self._ticks_y.most = max(math.ceil(size.height / _TICK_HEIGHT), 2)
        self.clear()
        # With the layout the base class adapts its canvases, which may have another size now.
        self.refresh(layout=True)
        self.set_xlimits(*window)
        self.set_ylimits(low, high)
        if low < 0.0 < high:
            self.plot(window, (0.0, 0.0), self._style("plot--zero"), hires_mode=HiResMode.BRAILLE)
        self.plot(
            t,
            values,
            self._style("plot--signal"),
            hires_mode=HiResMode.BRAILLE,
            label=self._label,
        )
        self.show_legend(LegendLocation.TOPLEFT)

    def _style(self, component: str) -> str:
        return str(self.get_component_rich_style(component))

    def action_reset_scales(self) -> None:
        """Ask for the whole horizon."""
        self.post_message(WindowReset())

    def action_show_end(self) -> None:
        """Ask for the last part of the horizon."""
        self.post_message(EndAsked())


class SeparationStrip(Static):
    """One line under a plot: the denser a column, the longer the slider is off the belt in it."""

    def show(
        self, intervals: Sequence[tuple[float, float]], window: tuple[float, float], columns: int
    ) -> None:
        """Mark the separated intervals.

        Parameters
        ----------
        intervals : sequence of (start, end)
            Ascending and disjoint, s.
        window : tuple of float
            First and last time shown, s.
        columns : int
            Number of columns.
        """
        label = "off belt".ljust(MARGIN_LEFT + _FRAME)
        self.update(label + shading(separated_share(intervals, window, columns)))
