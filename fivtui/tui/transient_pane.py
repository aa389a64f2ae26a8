"""The tab of the transient: motion over time, phase portraits, spectrum, and what came out."""

from typing import ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.events import Resize
from textual.widgets import Button, ContentSwitcher, Static

from fivtui.core.errors import ComputationError, InputError
from fivtui.core.outcome import Transient
from fivtui.core.stability import stability

from .axis import Axis
from .chart_view import ChartView
from .pane import Pane
from .report import remark, result_brief
from .runs import Run
from .session import Session
from .transient_charts import (
    Motion,
    motion_of,
    phase_chart,
    separated_samples,
    spectrum_chart,
    steady_window,
    time_chart,
)

# What is shown over time, from the top, and what goes first where there is little room.
_QUANTITIES: Final = ("y", "x", "P")
_FIRST: Final = ("y", "P", "x")
_LEAST_ROWS: Final = 6
_LAST_PART: Final = 0.1
_NOTHING: Final = "nothing to show yet: F5 runs"
_VIEWS: Final = {"time": "Time", "phase": "Phase", "spectrum": "Spectrum"}


class TransientPane(Pane):
    """Plots and summary of the run shown, with those drawn beside it."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("v", "turn_view", "View"),
        Binding("e", "show_end", "End"),
    ]

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._motions: list[Motion] = []

    def compose(self) -> ComposeResult:
        """The views, of which one is shown, and the summary."""
        with Horizontal(classes="bar"):
            for name, title in _VIEWS.items():
                yield Button(title, id=f"view-{name}", compact=True)
        with ContentSwitcher(initial="time", id="plots"):
            with Vertical(id="time"):
                for quantity in _QUANTITIES:
                    yield ChartView(f"plot-{quantity}", nothing=_NOTHING)
            with Horizontal(id="phase"):
                yield ChartView("phase-y", nothing=_NOTHING)
                yield ChartView("phase-x", nothing=_NOTHING)
            with Vertical(id="spectrum"):
                yield ChartView("plot-spectrum", nothing=_NOTHING)
        yield Static("", id="summary", markup=False)

    def on_mount(self) -> None:
        """Show amplitudes over decades."""
        self.query_one("#plot-spectrum", ChartView).view.log_y = True
        self._mark_view()

    # What is shown

    def run_changed(self, run: Run | None) -> None:
        """Show the result of a run, and those drawn beside it."""
        if run is None or run.result is None:
            return
        first, *others = result_brief(run.result)
        lines = [first, *_remarks(run.result), *others]
        self.query_one("#summary", Static).update("\n".join(lines))
        beside = [each for each in self.session.runs if each.overlaid and each is not run]
        self._show([each for each in map(_motion, [run, *beside]) if each is not None])

    def run_progressed(self, run: Run) -> None:
        """Show what is known of a run that goes on."""
        trajectory = run.growth.trajectory()
        if trajectory is not None:
            separated = separated_samples(trajectory)
            name = f"run {run.number}"
            style = run.style
            self._show(
                [
                    Motion(
                        name,
                        trajectory,
                        separated,
                        run.scene.t_end,
                        style.marker_sign,
                        style.colour_code,
                    )
                ]
            )

    def theme_changed(self) -> None:
        """Draw the plots in the colours of now."""
        for view in self.query(ChartView):
            view.redraw()

    def _show(self, motions: list[Motion]) -> None:
        self._motions = motions
        self._draw()

    def _draw(self) -> None:
        if not self._motions:
            return
        draw = {"time": self._draw_time, "phase": self._draw_phase, "spectrum": self._draw_spectrum}
        draw[self._view]()

    @property
    def _view(self) -> str:
        return self.query_one("#plots", ContentSwitcher).current or "time"

    def _draw_time(self) -> None:
        charts = [self.query_one(f"#plot-{name}", ChartView) for name in _QUANTITIES]
        visible = [chart for chart in charts if chart.display]
        for quantity, chart in zip(_QUANTITIES, charts, strict=True):
            if chart.display:
                strip, x_axis = chart is visible[0], chart is visible[-1]
                chart.show(time_chart(quantity, self._motions, strip=strip, x_axis=x_axis))

    def _draw_phase(self) -> None:
        for quantity in ("y", "x"):
            chart = self.query_one(f"#phase-{quantity}", ChartView)
            chart.show(phase_chart(quantity, self._motions, self._window))

    def _draw_spectrum(self) -> None:
        view = self.query_one("#plot-spectrum", ChartView)
        try:
            view.show(spectrum_chart(self._motions, self._window))
        except InputError as error:
            view.show(None, nothing=str(error))

    @property
    def _window(self) -> tuple[float, float]:
        # The part of time that is shown; of the whole, what is called steady.
        chosen = self.query_one("#plot-y", ChartView).view.x
        reached = float(self._motions[0].trajectory.t[-1])
        return steady_window(reached) if chosen is None else (chosen.low, chosen.high)

    # Room and views

    @on(Resize)
    def _fit(self, _event: Resize) -> None:
        room = max(self.query_one("#plots").size.height // _LEAST_ROWS, 1)
        for name in _QUANTITIES:
            self.query_one(f"#plot-{name}").display = name in _FIRST[:room]
        self._draw()

    @on(ChartView.Moved)
    def _moved(self, event: ChartView.Moved) -> None:
        charts = [self.query_one(f"#plot-{name}", ChartView) for name in _QUANTITIES]
        if event.view not in charts:
            return
        source = event.view.view
        for chart in charts:
            if chart is not event.view:
                chart.view.x, chart.view.log_x = source.x, source.log_x
                chart.redraw()

    def action_show_end(self) -> None:
        """Show the last part of the horizon."""
        if self._motions:
            t_end = self._motions[0].t_end
            for name in _QUANTITIES:
                chart = self.query_one(f"#plot-{name}", ChartView)
                chart.view.x = Axis((1.0 - _LAST_PART) * t_end, t_end)
            self._draw()

    def action_turn_view(self) -> None:
        """Show the next view."""
        names = list(_VIEWS)
        self.show_view(names[(names.index(self._view) + 1) % len(names)])

    @on(Button.Pressed)
    def _pressed(self, event: Button.Pressed) -> None:
        event.stop()
        self.show_view(str(event.button.id).removeprefix("view-"))

    def show_view(self, name: str) -> None:
        """Show a view.

        Parameters
        ----------
        name : str
            ``"time"``, ``"phase"`` or ``"spectrum"``.
        """
        self.query_one("#plots", ContentSwitcher).current = name
        self._mark_view()
        self._draw()
        self.query_one(f"#{name}").query(ChartView).first().focus()

    def _mark_view(self) -> None:
        for name in _VIEWS:
            self.query_one(f"#view-{name}", Button).set_class(name == self._view, "-active")


def _motion(run: Run) -> Motion | None:
    if run.result is None:
        return None
    style = run.style
    return motion_of(run.result, f"run {run.number}", style.marker_sign, style.colour_code)


def _remarks(result: Transient) -> list[str]:
    try:
        found = stability(result.parameters, separation=result.separation)
    except ComputationError:
        return []
    words = remark(result, found)
    return [words] if words else []
