"""The tab of runs: plots and numbers of the displayed run, plots of the overlaid runs.

While a scene is edited, the live curve, a run of the edited scene, replaces the displayed run; the
ghost is the curve before the edit. The view "difference" subtracts the run chosen as baseline.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.events import Resize
from textual.widgets import Static

from fivtui.charts import Heading
from fivtui.equilibrium import stability
from fivtui.model import ComputationError, InputError
from fivtui.results import Row
from fivtui.signals import spectrum_chart
from fivtui.transient import (
    TIME_LABEL,
    PlottedRun,
    Transient,
    difference_chart,
    partial_run,
    path_chart,
    phase_chart,
    plotted_run,
    second_half,
    time_chart,
    transient_rows,
)
from fivtui.tui.chart import ChartView
from fivtui.tui.session import (
    NATIVE_ENGINE,
    Run,
    RunState,
    Session,
    change_rows,
    default_style,
    late_separation_warning,
    legend_names,
    result_summary,
    study_command,
)

from .job_pane import ActionPane
from .messages import LiveRequested, RunRequested
from .motion.belt import BeltView
from .motion.measured import MeasuredView
from .tab_book import TABS
from .tables import RowsView, flow_facts

if TYPE_CHECKING:
    from .exports.export import Export

# Quantities of the time histories from the top.
_QUANTITIES: Final = ("y", "P", "x")
# Mark and colour of the ghost, the live curve before an edit.
_GHOST_STYLE: Final = ("·", "ghost")
_LIVE_OFF: Final = "The live curve is off: press Run, or switch it on in the palette."
# Charts that display a text while there is no curve, the first ones of their views.
_FIRST_CHARTS: Final = ("plot-y", "phase-y", "plot-spectrum", "belt-picture")
# Key of the view of measured data, and of the stored text of its input.
_MEASURED_KEY: Final = "m"
_MEASURED: Final = "measured"
_NO_SPECTRUM: Final = "no chart to export: too few samples in its time window"
_NO_BASELINE: Final = "no difference: set another run as baseline (b in the run list)"
_NO_EXPORT: Final = "this view of the live curve has no export: press Run first"


class TransientPane(ActionPane):
    """Plots of the displayed and the overlaid runs, and the numbers of the displayed run."""

    NAME: ClassVar[str] = "transient"
    VERB: ClassVar[str] = "Run"
    KEY: ClassVar[str] = "run"
    VIEWS: ClassVar[Mapping[str, str]] = {
        "time": "Time",
        "phase": "Phase",
        "spectrum": "Spectrum",
        "difference": "Difference",
        "belt": "Belt",
        "measured": "Measured",
        "result": "Result",
    }
    LOG_AXES: ClassVar[Mapping[str, str]] = {"plot-spectrum": "y"}
    COMMON_X_LIMITS: ClassVar[Sequence[Sequence[str]]] = (
        tuple(f"plot-{name}" for name in _QUANTITIES),
        ("difference-y", "difference-P"),
    )
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("g,home", "show_end(False)", "Start of the run", show=False),
        Binding("G,end", "show_end(True)", "End of the run", show=False),
        Binding(_MEASURED_KEY, "show_measured", "Measured data", show=False),
    ]

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        # What is plotted: first the displayed run or the live curve, then the overlaid runs.
        self._plotted: list[PlottedRun] = []
        # The run that is plotted first; None if it is the live curve.
        self._first_run: Run | None = None
        # The facts of the summary.
        self._facts: Sequence[str] = []

    def compose(self) -> ComposeResult:
        """The views and the summary."""
        yield from super().compose()
        yield Static("", id="summary", markup=False)

    def compose_views(self) -> ComposeResult:
        """Time histories, phase portraits, spectrum, difference, belt, measured data, numbers."""
        with Vertical(id="time"):
            for quantity in _QUANTITIES:
                yield ChartView(f"plot-{quantity}")
        with Horizontal(id="phase"):
            yield ChartView("phase-y")
            yield ChartView("phase-x")
            yield ChartView("phase-path")
        with Vertical(id="spectrum"):
            yield ChartView("plot-spectrum")
        with Vertical(id="difference"):
            yield ChartView("difference-y", empty_text=_NO_BASELINE)
            yield ChartView("difference-P")
        yield BeltView("belt")
        yield MeasuredView(
            "measured",
            self.stored_setting(_MEASURED, ""),
            partial(self.store_setting, _MEASURED),
            _MEASURED_KEY,
        )
        yield RowsView(id="result")

    # The action

    def toggle_computation(self) -> bool:
        """Run the edited scene, or stop the run."""
        self.post_message(RunRequested())
        return True

    def status_changed(self) -> None:
        """Display the status of the live curve, or else the progress or state of the newest run."""
        runs, live_status = self.session.runs, self.session.live.status
        newest = runs.newest
        is_outdated = newest is not None and self.session.is_outdated(newest)
        if newest is not None and newest.state is RunState.FAILED and not is_outdated:
            # Before the next edit, the failure of the run replaces the status of the live curve.
            live_status = ""
        if live_status and runs.active is None:
            self.show_action(None, live_status)
        elif newest is None:
            self.show_action(None, "" if self.session.live_enabled else "live curve off")
        else:
            text = _state_text(newest, self._next_step_text(), is_outdated=is_outdated)
            self.show_action(runs.active, text)

    def _next_step_text(self) -> str:
        # Key, title and question of the tab that leads on; empty without such a tab.
        tab, question = self.session.next_step
        titles = [spec.title for spec in TABS if spec.id == tab]
        return f"{self.session.key_names[f'tab-{tab}']} {titles[0]}: {question}" if titles else ""

    # Display

    def scene_changed(self) -> None:
        """Request the live curve."""
        self.post_message(LiveRequested())

    def run_changed(self, run: Run | None) -> None:
        """Display the live curve if it is visible, else a run; and the overlaid runs."""
        if self.session.live.visible:
            self._show_live()
            return
        if run is None or run.result is None:
            self._clear()
            return
        self._show_summary(_summary(run.result))
        self._show(_plotted_runs(reversed(self.session.runs.plotted)), run)

    def _show_live(self) -> None:
        # The live curve is drawn over the overlaid runs, these over the ghost.
        live, runs = self.session.live, self.session.runs
        summary_lines: list[str] = [live.error]
        plotted: list[PlottedRun | None] = []
        if live.curve is not None:
            result = live.curve.result
            summary_lines = _summary(result)
            # The live curve has the style of the next run.
            number = runs.count + 1
            style = default_style(number)
            plotted.append(
                plotted_run(result, "live", style.marker_sign, style.colour_role, number)
            )
        overlaid = [run for run in reversed(runs.plotted) if run.overlaid]
        plotted += _plotted_runs(overlaid)
        if live.ghost is not None and all(run.result is not live.ghost for run in overlaid):
            plotted.append(plotted_run(live.ghost, "before", *_GHOST_STYLE))
        self._show_summary(summary_lines)
        self._show(plotted, None)

    def _show_summary(self, lines: Sequence[str]) -> None:
        self._facts = lines
        self.query_one("#summary", Static).update(flow_facts(lines, self.size.width))

    def _clear(self) -> None:
        # Without a run the live curve is drawn, unless it is off.
        session = self.session
        if session.runs.active is not None:
            return
        self._plotted, self._first_run = [], None
        self._show_summary([])
        text = session.live.status if session.live_enabled else _LIVE_OFF
        for chart in self.query(ChartView):
            chart.show(None, empty_text=text if chart.id in _FIRST_CHARTS else None)
        self.query_one("#result", RowsView).show([], text)
        self.draw()
        self.post_message(LiveRequested())

    def run_progressed(self, run: Run) -> None:
        """Display the part of a run computed so far."""
        trajectory = run.partial.trajectory()
        if trajectory is not None:
            plotted = partial_run(
                trajectory,
                run.scene.system,
                run.scene.t_end,
                name=_run_name(run),
                mark=run.style.marker_sign,
                colour=run.style.colour_role,
            )
            self._show([plotted], run)

    def _show(self, plotted: Sequence[PlottedRun | None], first: Run | None) -> None:
        # A run without a trajectory is None.
        self._plotted = [run for run in plotted if run is not None]
        self._first_run = first
        self.draw()

    def draw(self) -> None:
        """Draw the current view."""
        self.set_class(self.view == "measured", "-measured")
        if not self._plotted:
            return
        draw = {
            "time": self._draw_time,
            "phase": self._draw_phase,
            "spectrum": self._draw_spectrum,
            "difference": self._draw_difference,
            "belt": self._draw_belt,
            "measured": self._draw_measured,
            "result": self._draw_result,
        }
        draw[self.view]()

    def _draw_time(self) -> None:
        shown = [name for name in _QUANTITIES if self.query_one(f"#plot-{name}").display]
        for quantity in shown:
            # The strip of separations is shown once, and so is the time axis.
            strip, x_axis = quantity == shown[0], quantity == shown[-1]
            chart = time_chart(quantity, self._plotted, strip=strip, x_axis=x_axis)
            self.query_one(f"#plot-{quantity}", ChartView).show(chart)

    def _draw_phase(self) -> None:
        for quantity in ("y", "x"):
            chart = self.query_one(f"#phase-{quantity}", ChartView)
            chart.show(phase_chart(quantity, self._plotted, self._window))
        self.query_one("#phase-path", ChartView).show(path_chart(self._plotted, self._window))

    def _draw_spectrum(self) -> None:
        view = self.query_one("#plot-spectrum", ChartView)
        try:
            view.show(spectrum_chart(self._plotted, self._window))
        except InputError as error:
            view.show(None, empty_text=str(error))

    def _draw_difference(self) -> None:
        # The baseline is the chosen run, or else the ghost.
        run, ghost = self.session.runs.baseline, self.session.live.ghost
        baseline = None
        if run is None:
            baseline = None if ghost is None else plotted_run(ghost, "before")
        elif run is not self._first_run:
            baseline = _plotted_run(run, _run_name(run))
        name = "live" if self._first_run is None else _run_name(self._first_run)
        shown = replace(self._plotted[0], name=name)
        for quantity in ("y", "P"):
            chart = None
            if baseline is not None:
                is_top = quantity == "y"
                chart = difference_chart(quantity, shown, baseline, strip=is_top, x_axis=not is_top)
            self.query_one(f"#difference-{quantity}", ChartView).show(chart)

    def _draw_belt(self) -> None:
        # The time is that of the first cursor of the time histories, if it is on.
        result = self._result
        if result is not None:
            self.query_one(BeltView).show_run(result, self._cursor_time())

    def _draw_measured(self) -> None:
        result = self._result
        if result is not None:
            self.query_one(MeasuredView).show_run(result)

    def _draw_result(self) -> None:
        # The numbers, with differences to the baseline if there is one.
        live, run = self.session.live.curve, self.session.runs.displayed
        result, baseline = self._result, self.session.runs.baseline
        if result is None:
            return
        rows = transient_rows(result, "" if live is not None or run is None else run.accuracy_text)
        if baseline is not None and baseline.result is not None and baseline.result is not result:
            name = "live" if live is not None or run is None else _run_name(run)
            heading = Row("baseline", _run_name(baseline), f"{name} − {_run_name(baseline)}:")
            rows += [Row("", ""), heading, *change_rows(result, baseline.result)]
        self.query_one("#result", RowsView).show(rows)

    @property
    def _result(self) -> Transient | None:
        # The result of the live curve, or else of the displayed run.
        live, run = self.session.live, self.session.runs.displayed
        if live.curve is not None:
            return live.curve.result
        return None if run is None else run.result

    def _cursor_time(self) -> float | None:
        cursors = self.shared_cursors.get(TIME_LABEL)
        return None if cursors is None or cursors.first is None else cursors.first[0]

    @property
    def _window(self) -> tuple[float, float]:
        # The chosen time window; without chosen limits, the second half of the run.
        chosen = self.query_one("#plot-y", ChartView).view.x
        t_reached = float(self._plotted[0].trajectory.t[-1])
        return second_half(t_reached) if chosen is None else (chosen.low, chosen.high)

    def export(self, kind: str) -> "Export":
        """The displayed charts as figure; as data the trajectory, or the points of the charts."""
        from .exports.export import FIGURE, charts_export, points_export, run_export

        live, run, charts = self.session.live, self.session.runs.displayed, self.visible_charts()
        plotted_runs = self.session.runs.plotted
        results = [run.result for run in plotted_runs if run.result is not None]
        if live.visible:
            base_export = self._live_export(kind)
            overlaid = [run.result for run in plotted_runs if run.overlaid]
            first = None if live.curve is None else live.curve.result
            results = [result for result in (first, live.ghost, *overlaid) if result is not None]
        elif run is not None and run.result is not None and self.view in ("belt", "measured"):
            return self._view_export(kind, run)
        else:
            base_export = run_export(kind, run)
        if kind != FIGURE and self.view in ("time", "phase"):
            # The trajectory of the run.
            return base_export
        if charts is None:
            raise InputError(_NO_BASELINE if self.view == "difference" else _NO_SPECTRUM)
        # All other exports are those of the charts, named after the run.
        subject, stem = base_export.subject, Path(base_export.file_name).stem
        if self.view != "time":
            subject = subject if live.visible else f"{subject}, {self.view}"
            stem = f"{stem}-{self.view}"
        if kind != FIGURE:
            return points_export(subject, stem, charts)
        parameters = [result.parameters for result in results]
        ignores_separation = not any(result.separation for result in results)
        heading = Heading(parameters, ignores_separation=ignores_separation)
        return charts_export(subject, stem, charts, heading)

    def _live_export(self, kind: str) -> "Export":
        from .exports.export import study_export

        curve = self.session.live.curve
        if curve is None or self.view == "belt" or self.visible_charts() is None:
            raise InputError(_NO_EXPORT)
        return study_export(kind, "run", curve.result, f"{curve.scene.name}-live", "the live curve")

    def _view_export(self, kind: str, run: Run) -> "Export":
        from .exports.export import belt_export, scene_study_export, with_displayed_charts

        charts = self.visible_charts()
        if self.view == "belt":
            chosen = self.query_one("#plot-y", ChartView).view.x
            window = None if chosen is None else (chosen.low, chosen.high)
            return belt_export(kind, run, charts, window, self.query_one(BeltView).speed)
        validation = self.query_one(MeasuredView).validation
        name = f"{run.scene.name}-{run.number}"
        export = scene_study_export(kind, "validation", validation, name)
        verdict, ignored = self.query_one(MeasuredView).verdict, not run.scene.separation
        heading = Heading([run.scene.parameters], ignores_separation=ignored, text=verdict)
        return with_displayed_charts(export, charts, heading)

    def command_line(self) -> str:
        """The command that computes the displayed run, or compares it with measured data."""
        run = self.session.runs.displayed
        if self.view != "measured" or run is None:
            return super().command_line()
        request = run.scene, self.query_one(MeasuredView).options
        return study_command("validation", request, self.session.origin)

    # Layout

    @on(Resize)
    def _fit(self) -> None:
        self._show_summary(self._facts)
        self.draw()

    def action_show_measured(self) -> None:
        """Show the view of measured data, and go to its input."""
        self.show_view("measured")
        # The field from which the key comes keeps the focus until then.
        self.call_later(self.focus_within, self.page, bar_first=True)

    def action_show_end(self, at_end: bool) -> None:
        """Limit the time to the start or the end of the run, for phases and the spectrum, too."""
        if self._plotted:
            chart = time_chart("y", self._plotted, strip=False, x_axis=False)
            for name in _QUANTITIES:
                self.query_one(f"#plot-{name}", ChartView).view.show_end(chart, at_end=at_end)
            self.draw()


def _state_text(run: Run, next_step: str, *, is_outdated: bool) -> str:
    # `next_step`: what leads on from a result. `is_outdated`: whether the inputs have changed.
    text = f"{_run_name(run)} {run.state.value}"
    if is_outdated:
        return f"{text}, inputs changed since"
    if run.result is not None and run.result.stats.cpu_s is not None:
        engine = "" if run.engine == NATIVE_ENGINE else f", {run.engine}"
        text += f" · {next_step} ·" if next_step else ""
        text += f" in {run.result.stats.cpu_s:.2g} s{engine}, {run.accuracy_text}"
    return text


def _run_name(run: Run) -> str:
    return f"run {run.number}"


def _summary(result: Transient) -> list[str]:
    # The lines of the summary; a warning follows the first.
    first, *details = result_summary(result)
    return [first, *_warnings(result), *details]


def _plotted_runs(runs: Iterable[Run]) -> list[PlottedRun | None]:
    # Runs named by what distinguishes their scenes.
    run_list = list(runs)
    names = legend_names({run.number: run.scene for run in run_list})
    return list(map(_plotted_run, run_list, names))


def _plotted_run(run: Run, name: str) -> PlottedRun | None:
    if run.result is None:
        return None
    style = run.style
    return plotted_run(run.result, name, style.marker_sign, style.colour_role, run.number)


def _warnings(result: Transient) -> list[str]:
    try:
        linear_stability = stability(result.parameters, separation=result.separation)
    except (ComputationError, InputError):
        return []
    warning = late_separation_warning(result, linear_stability)
    return [warning] if warning else []
