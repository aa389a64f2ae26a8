"""The tab of runs: plots and numbers of the displayed run, plots of the overlaid runs.

While a scene is edited, the live curve, a run of the edited scene, replaces the displayed run; the
ghost is the curve before the edit. The view "difference" subtracts the run chosen as baseline.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.events import Resize
from textual.widgets import Static

from fivtui.charts import Cursors, Heading
from fivtui.equilibrium import stability
from fivtui.measured import describe_verdict
from fivtui.model import ComputationError, InputError
from fivtui.results import Row
from fivtui.signals import spectrum_chart
from fivtui.studies import study
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
    LiveRun,
    Run,
    RunState,
    Session,
    change_rows,
    compute_outcome,
    late_separation_warning,
    legend_names,
    result_summary,
    study_command,
)

from .export import FIGURE, Export, belt_export, charts_export, run_export, study_export
from .job_pane import ActionPane
from .messages import LiveRequested, RunRequested
from .motion.belt import BeltView
from .motion.measured import MEASURED, MEASURED_KEY, MeasuredView
from .tab_book import TABS
from .tables import RowsView, flow_facts

# Quantities of the time histories from the top.
_QUANTITIES: Final = ("y", "P", "x")
# Name, mark and colour of the ghost, the live curve before an edit.
_GHOST: Final = ("before", "·", "ghost")
_LIVE_OFF: Final = "The live curve is off: press Run, or switch it on in the palette."
# Charts that display a text while there is no curve, the first ones of their views.
_FIRST_CHARTS: Final = ("plot-y", "phase-y", "plot-spectrum", "belt-picture")
# Views whose data are points of their charts; that of other views is the trajectory.
_POINT_VIEWS: Final = ("spectrum", "difference")
_NO_CHART: Final = "no chart to export in this view"
_NO_BASELINE: Final = "no difference: set another run as baseline (b in the run list)"


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
        MEASURED: "Measured",
        "result": "Result",
    }
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("g,home", "show_end(False)", "Start of the run", show=False),
        Binding("G,end", "show_end(True)", "End of the run", show=False),
        Binding(MEASURED_KEY, "show_measured", "Measured data", show=False),
    ]

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        # What is plotted: first the displayed run or the live curve, then the overlaid runs.
        self._plotted: list[PlottedRun] = []
        # The run or live curve that is plotted first; None if a live run has failed.
        self._first: Run | LiveRun | None = None
        # The results that are plotted.
        self._results: list[Transient] = []
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
            yield ChartView("plot-spectrum", log="y")
        with Vertical(id="difference"):
            yield ChartView("difference-y", empty_text=_NO_BASELINE)
            yield ChartView("difference-P")
        yield BeltView()
        yield MeasuredView()
        yield RowsView(id="result")

    # The action

    def toggle_computation(self) -> None:
        """Run the edited scene, or stop the run."""
        self.post_message(RunRequested())

    def status_changed(self) -> None:
        """Display the status of the live curve, or else the progress or state of the newest run."""
        self.mark_result(outdated=self.session.live.is_outdated)
        session, text = self.session, self.session.live.status
        active, newest = session.runs.active, session.runs.newest
        if newest is None:
            text = text or ("" if session.live_enabled else "live curve off")
        else:
            is_outdated = session.is_outdated(newest)
            # Before the next edit, the failure of the run replaces the status of the live curve.
            has_failed = newest.state is RunState.FAILED and not is_outdated
            if active is not None or has_failed or not text:
                text = _state_text(newest, self._next_step_text(), is_outdated=is_outdated)
        self.show_action(active, text)

    def _next_step_text(self) -> str:
        # Key, title and question of the tab that leads on; empty without such a tab.
        tab, question = self.session.next_step
        titles = {spec.id: spec.title for spec in TABS}
        return f"{self.session.key_names[f'tab-{tab}']} {titles[tab]}: {question}" if tab else ""

    # Display

    def scene_changed(self) -> None:
        """Request the live curve."""
        self.post_message(LiveRequested())

    def run_changed(self, run: Run | None) -> None:
        """Display the live curve if it is visible, else a run; and the overlaid runs."""
        live, runs = self.session.live, self.session.runs
        first = live.curve if live.visible else run
        result = None if first is None else first.result
        if result is None and not live.visible:
            self._clear()
            return
        self._show_summary([live.error] if result is None else _summary(result))
        # Runs are named by what distinguishes their scenes.
        listed = [run for run in reversed(runs.plotted) if run.overlaid or not live.visible]
        names = legend_names({run.number: run.scene for run in listed})
        lines = [
            (run.result, name, *run.look, run.number)
            for run, name in zip(listed, names, strict=True)
            if run.result is not None
        ]
        # The live curve is drawn over the overlaid runs, these over the ghost.
        if live.curve is not None:
            # It has the style of the next run.
            number = runs.count + 1
            look = Run(number, live.curve.scene).look
            lines.insert(0, (live.curve.result, live.curve.name, *look, number))
        if live.ghost is not None and all(result is not live.ghost for result, *_ in lines):
            lines.append((live.ghost, *_GHOST, 0))
        self._results = [result for result, *_ in lines]
        self._show([plotted_run(*line) for line in lines], first)

    def _show_summary(self, lines: Sequence[str]) -> None:
        self._facts = lines
        self.query_one("#summary", Static).update(flow_facts(lines, self.size.width))

    def _clear(self) -> None:
        # Without a run the live curve is drawn, unless it is off.
        session = self.session
        if session.runs.active is not None:
            return
        self._show_summary([])
        text = session.live.status if session.live_enabled else _LIVE_OFF
        for chart in self.query(ChartView):
            chart.show(None, empty_text=text if chart.id in _FIRST_CHARTS else None)
        self.query_one("#result", RowsView).show([], text)
        self._show([], None)
        self.post_message(LiveRequested())

    def run_progressed(self, run: Run) -> None:
        """Display the part of a run computed so far."""
        trajectory, system, t_end = run.trajectory_so_far, run.scene.system, run.scene.t_end
        if trajectory is not None:
            mark, colour = run.look
            name = run.name
            plotted = partial_run(trajectory, system, t_end, name=name, mark=mark, colour=colour)
            self._show([plotted], run)

    def _show(self, plotted: Sequence[PlottedRun | None], first: Run | LiveRun | None) -> None:
        # A run without a trajectory is None.
        self._plotted = [run for run in plotted if run is not None]
        self._first = first
        self.draw()

    def draw(self) -> None:
        """Draw the current view."""
        self.set_class(self.view == MEASURED, "-measured")
        if not self._plotted:
            return
        first = self._first
        result = None if first is None else first.result
        match self.view:
            case "time":
                self._draw_time()
            case "phase":
                self._draw_phase()
            case "spectrum":
                self._draw_spectrum()
            case "difference":
                self._draw_difference()
            case "belt" if result is not None:
                # The time is that of the first cursor of the time histories, if it is on.
                cursor = self.shared_cursors.get(TIME_LABEL, Cursors()).first
                self.query_one(BeltView).show_run(result, cursor and cursor[0])
            case "measured" if result is not None:
                self.query_one(MeasuredView).show_run(result)
            case "result" if first is not None and result is not None:
                self._draw_result(first, result)

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
        outcome = compute_outcome(lambda: spectrum_chart(self._plotted, self._window))
        view = self.query_one("#plot-spectrum", ChartView)
        view.show(outcome.result, empty_text=outcome.error)

    def _draw_difference(self) -> None:
        # The baseline is the chosen run, or else the ghost.
        first, run, ghost = self._first, self.session.runs.baseline, self.session.live.ghost
        result, name = (ghost, _GHOST[0]) if run is None else (run.result, run.name)
        baseline = None if result is None or run is first else plotted_run(result, name)
        names = [name for name in ("y", "P") if self.query_one(f"#difference-{name}").display]
        for name in names:
            chart = None
            if first is not None and baseline is not None:
                shown = replace(self._plotted[0], name=first.name)
                strip, x_axis = name == names[0], name == names[-1]
                chart = difference_chart(name, shown, baseline, strip=strip, x_axis=x_axis)
            self.query_one(f"#difference-{name}", ChartView).show(chart)

    def _draw_result(self, first: Run | LiveRun, result: Transient) -> None:
        # The numbers, with differences to the baseline if there is one.
        baseline = self.session.runs.baseline
        rows = transient_rows(result, first.accuracy_text if isinstance(first, Run) else "")
        if baseline is not None and baseline.result is not None and baseline is not first:
            heading = Row("baseline", baseline.name, f"{first.name} − {baseline.name}:")
            rows += [Row("", ""), heading, *change_rows(result, baseline.result)]
        self.query_one("#result", RowsView).show(rows)

    @property
    def _chosen_window(self) -> tuple[float, float] | None:
        # The chosen limits of time.
        chosen = self.query_one("#plot-y", ChartView).view.x
        return None if chosen is None else (chosen.low, chosen.high)

    @property
    def _window(self) -> tuple[float, float]:
        # Without chosen limits, the second half of the run.
        return self._chosen_window or second_half(float(self._plotted[0].trajectory.t[-1]))

    # Exports

    def export(self, kind: str) -> Export:
        """The displayed charts as figure; as data the trajectory, or the points of the charts."""
        view, charts = self.view, self.visible_charts()
        export = run_export(kind, self._first)
        results = self._results[:1] if view == MEASURED else self._results
        heading = Heading(
            [result.parameters for result in results],
            ignores_separation=not any(result.separation for result in results),
        )
        if view == MEASURED:
            validation = self.query_one(MeasuredView).validation
            heading = replace(heading, text=describe_verdict(validation))
            stem = f"{export.stem}-{study('validation').stem(validation)}"
            return study_export(
                kind, "validation", validation, stem, charts=charts, heading=heading
            )
        # The figure of the numbers is that of the run.
        if (kind == FIGURE and view != "result") or view in _POINT_VIEWS:
            if charts is None:
                raise InputError(_NO_BASELINE if view == "difference" else _NO_CHART)
            subject, stem = export.subject, export.stem
            if view != "time":
                subject, stem = f"{subject}, {view}", f"{stem}-{view}"
            export = charts_export(kind, subject, stem, charts, heading)
        if view == "belt":
            speed = self.query_one(BeltView).speed
            export = belt_export(export, results[0], self._chosen_window, speed)
        return export

    def command_line(self) -> str:
        """The command that computes the displayed run, or compares it with measured data."""
        run = self.session.runs.displayed
        if self.view != MEASURED or run is None:
            return super().command_line()
        request = run.scene, self.query_one(MeasuredView).options
        return study_command("validation", request, self.session)

    # Layout

    @on(Resize)
    def _fit(self) -> None:
        self._show_summary(self._facts)
        self.draw()

    def action_show_measured(self) -> None:
        """Show the view of measured data, and go to its input."""
        self.show_view(MEASURED)
        # The field from which the key comes keeps the focus until then.
        self.call_later(self.focus_content, self.page, bar_first=True)

    def action_show_end(self, at_end: bool) -> None:
        """Limit the time to the start or the end of the run, for phases and the spectrum, too."""
        if self._plotted:
            chart = time_chart("y", self._plotted, strip=False, x_axis=False)
            for name in _QUANTITIES:
                self.query_one(f"#plot-{name}", ChartView).view.show_end(chart, at_end=at_end)
            self.draw()


def _state_text(run: Run, next_step: str, *, is_outdated: bool) -> str:
    # `next_step`: what leads on from a result. `is_outdated`: whether the inputs have changed.
    text = f"{run.name} {run.state.value}"
    if is_outdated:
        return f"{text}, inputs changed since"
    if run.result is not None and run.result.stats.cpu_s is not None:
        engine = "" if run.engine == NATIVE_ENGINE else f", {run.engine}"
        text += f" · {next_step} ·" if next_step else ""
        text += f" in {run.result.stats.cpu_s:.2g} s{engine}, {run.accuracy_text}"
    return text


def _summary(result: Transient) -> list[str]:
    # The lines of the summary; a warning follows the first.
    lines = result_summary(result)
    with suppress(ComputationError, InputError):
        linear_stability = stability(result.parameters, separation=result.separation)
        lines[1:1] = filter(None, [late_separation_warning(result, linear_stability)])
    return lines
