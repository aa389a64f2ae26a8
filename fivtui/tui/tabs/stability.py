"""The stability tab: vibration modes over μ, eigenvalues, summary; updated on every edit.

The eigenvalues of the edited parameters are shown at once, the scan over μ after a short delay.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.worker import get_current_worker

from fivtui.charts import Heading
from fivtui.equilibrium import (
    ModeScan,
    Stability,
    frequency_chart,
    growth_chart,
    mode_scan,
    mu_scan_end,
    plane_chart,
    stability_rows,
)
from fivtui.model import Cancelled, ComputationError, InputError
from fivtui.ranges import number_text
from fivtui.tui.chart import ChartView
from fivtui.tui.session import Session, attractor_rows, base_scene

from .messages import PointRunRequested
from .tables import RowsView
from .views_pane import ViewsPane

if TYPE_CHECKING:
    from .exports.export import Export

# Delay between the last key and the scan over μ, s.
_SCAN_DELAY: Final = 0.05
# Significant digits of the μ of an opened point.
_MU_DIGITS: Final = 6


class StabilityPane(ViewsPane):
    """Stability of the edited parameter set."""

    NAME: ClassVar[str] = "stability"
    VIEWS: ClassVar[Mapping[str, str]] = {
        "over-mu": "Over μ",
        "plane": "Eigenvalues",
        "facts": "Summary",
    }
    COMMON_X_LIMITS: ClassVar[Sequence[Sequence[str]]] = (("growth", "frequency"),)

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        # The stability of the edited parameters; None with an error.
        self._stability: Stability | None = None
        self._error = ""
        # The eigenvalues over μ, and the inputs from which they are computed.
        self._scan: ModeScan | None = None
        self._scan_inputs: object = None

    def compose_views(self) -> ComposeResult:
        """Growth rates and frequencies, eigenvalues, summary."""
        with Vertical(id="over-mu"):
            yield ChartView("growth", runs_points=True)
            yield ChartView("frequency", runs_points=True)
        with Vertical(id="plane"):
            yield ChartView("eigenvalues")
        yield RowsView(id="facts")

    def scene_changed(self) -> None:
        """Display the stability of the edited parameters; the scan over μ follows."""
        try:
            stability = self.session.stability()
        except (InputError, ComputationError) as error:
            self._stability, self._error, self._scan_inputs = None, str(error), None
            self.draw()
            return
        self._stability = stability
        fixed_parameters = stability.parameters.with_values({"mu": 0.0})
        inputs = (fixed_parameters, self.session.separation, mu_scan_end(stability))
        if inputs != self._scan_inputs:
            self._scan_inputs = inputs
            self.call_after_pause(_SCAN_DELAY, self._start_scan)
        self.draw()

    def _start_scan(self) -> None:
        if self._stability is None:
            return
        inputs, stability = self._scan_inputs, self._stability

        def compute() -> None:
            worker = get_current_worker()
            try:
                scan = mode_scan(
                    stability.system,
                    mu_scan_end(stability),
                    should_continue=lambda: not worker.is_cancelled,
                )
            except (Cancelled, ComputationError):
                # Without an equilibrium at every μ there is no chart.
                return
            self.call_later(self._show_scan, inputs, scan)

        self.run_worker(compute, group="scan", thread=True, exclusive=True, exit_on_error=False)

    def _show_scan(self, inputs: object, scan: ModeScan) -> None:
        # Ignore the scan if the parameters have been edited since its start.
        if inputs == self._scan_inputs:
            self._scan = scan
            self.draw()

    def draw(self) -> None:
        """Draw the current view."""
        stability = self._stability
        if self.view == "facts":
            rows = [] if stability is None else stability_rows(stability)
            attractors = self.session.attractors
            if rows and attractors is not None:
                # After the row of the verdict.
                rows[1:1] = attractor_rows(attractors)
            self.query_one("#facts", RowsView).show(rows, self._error)
        elif self.view == "plane":
            chart = None if stability is None else plane_chart(stability, self._scan)
            self.query_one("#eigenvalues", ChartView).show(chart, empty_text=self._error)
        else:
            for name, make_chart in (("growth", growth_chart), ("frequency", frequency_chart)):
                chart = None
                if stability is not None and self._scan is not None:
                    chart = make_chart(self._scan, stability.parameters, stability)
                self.query_one(f"#{name}", ChartView).show(chart, empty_text=self._error)

    @on(ChartView.PointChosen)
    def _run_point(self, event: ChartView.PointChosen) -> None:
        text = number_text(float(f"{event.point.x:.{_MU_DIGITS}g}"))
        self.post_message(PointRunRequested({"mu": text}, f"opened μ = {text}"))

    def export(self, kind: str) -> "Export":
        """The displayed charts as figure; the modes over μ and the eigenvalues as data."""
        from .exports.export import scene_study_export, with_displayed_charts

        stability = self._stability
        if stability is None:
            raise InputError(f"no stability to export: {self._error}")
        export = scene_study_export(kind, "stability", stability, self.session.name)
        heading = Heading([stability.parameters], ignores_separation=not self.session.separation)
        return with_displayed_charts(export, self.visible_charts(), heading)

    def command_line(self) -> str:
        """The command that computes the stability of the edited parameters."""
        from fivtui.tui.session import study_command

        parameters, separation = self.session.parameters(), self.session.separation
        scene = replace(base_scene(), parameters=parameters, separation=separation)
        return study_command("stability", scene, self.session.origin)
