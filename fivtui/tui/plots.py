"""The plots of one run on one time axis."""

from textual import on
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.events import Resize
from textual.widgets import Static
from textual_plot import PlotWidget

from fivtui.core.outcome import Transient
from fivtui.core.trajectory import COLUMNS

from .messages import EndAsked, WindowReset
from .time_plot import SeparationStrip, TimePlot

_LABELS = {column.name: f"{column.name} / {column.unit}" for column in COLUMNS}
_LEAST_WINDOW = 1e-6
_LAST_PART = 0.1


class TransientPlots(Vertical):
    """y and P over time, and between them the strip that marks separation."""

    def __init__(self) -> None:
        super().__init__(id="plots", classes="-empty")
        self._result: Transient | None = None
        self._window = (0.0, 1.0)

    def compose(self) -> ComposeResult:
        """The parts from top to bottom."""
        yield Static("Nothing to show yet.", id="nothing")
        yield TimePlot(_LABELS["y"], time_axis=False, id="plot-y")
        yield SeparationStrip(id="strip", markup=False)
        yield TimePlot(_LABELS["P"], time_axis=True, id="plot-P")

    @property
    def window(self) -> tuple[float, float]:
        """First and last time shown, s."""
        return self._window

    def show(self, result: Transient) -> None:
        """Show a result over its whole horizon.

        Parameters
        ----------
        result : Transient
            Computed with sample times.
        """
        self._result = result
        self.remove_class("-empty")
        # The plots get their sizes first: they are drawn for the columns that they have.
        self.call_after_refresh(self.show_all)

    @on(WindowReset)
    def show_all(self) -> None:
        """Show the whole horizon."""
        if self._result is not None:
            self.show_window(0.0, self._result.t_end)

    @on(EndAsked)
    def show_end(self) -> None:
        """Show the last part of the horizon."""
        if self._result is not None:
            t_end = self._result.t_end
            self.show_window((1.0 - _LAST_PART) * t_end, t_end)

    def show_window(self, low: float, high: float) -> None:
        """Show a part of the horizon.

        Parameters
        ----------
        low, high : float
            First and last time, s; moved into the horizon.
        """
        if self._result is None:
            return
        t_end = self._result.t_end
        span = min(max(high - low, _LEAST_WINDOW * t_end), t_end)
        low = min(max(low, 0.0), t_end - span)
        self._window = (low, low + span)
        self.redraw()

    def redraw(self) -> None:
        """Draw what is shown, for the size and the theme of now."""
        if self._result is None or self._result.trajectory is None:
            return
        motion = self._result.trajectory
        # Where there is no room for P, y has the labels of the time axis.
        alone = not self.query_one("#plot-P").display
        self.query_one("#plot-y", TimePlot).margin_bottom = int(alone)
        for name, values in (("y", motion.y), ("P", motion.P)):
            self.query_one(f"#plot-{name}", TimePlot).show(motion.t, values, self._window)
        columns = self.query_one("#plot-y", TimePlot).plot_size.width
        intervals = self._result.separated_intervals
        self.query_one(SeparationStrip).show(intervals, self._window, columns)

    @on(PlotWidget.ScaleChanged)
    def _scale_changed(self, event: PlotWidget.ScaleChanged) -> None:
        event.stop()
        self.show_window(event.x_min, event.x_max)

    def on_resize(self, _event: Resize) -> None:
        """Reduce the signals anew, once the plots have their new sizes."""
        self.call_after_refresh(self.redraw)
