"""The stability tab: vibration modes over μ, eigenvalues, summary; updated on every edit."""

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

from textual import on
from textual.app import ComposeResult
from textual.containers import Vertical

from fivtui.charts import Heading
from fivtui.equilibrium import (
    ModeScan,
    Stability,
    frequency_chart,
    growth_chart,
    plane_chart,
    stability_rows,
)
from fivtui.model import InputError
from fivtui.studies import study
from fivtui.tui.chart import ChartView
from fivtui.tui.session import attractor_rows, base_scene, compute_outcome, study_command

from .export import Export, study_export
from .messages import PointRunRequested
from .tables import RowsView
from .views_pane import ViewsPane


class StabilityPane(ViewsPane):
    """Stability of the edited parameter set."""

    NAME: ClassVar[str] = "stability"
    AT_START: ClassVar[bool] = True
    VIEWS: ClassVar[Mapping[str, str]] = {
        "over-mu": "Over μ",
        "plane": "Eigenvalues",
        "facts": "Summary",
    }

    # The stability of the edited parameters; None with an error.
    _stability: Stability | None = None
    _error = ""
    # The eigenvalues over μ; None without an equilibrium at μ = 0.
    _scan: ModeScan | None = None

    def compose_views(self) -> ComposeResult:
        """Growth rates and frequencies, eigenvalues, summary."""
        with Vertical(id="over-mu"):
            yield ChartView("growth", runs_points=True)
            yield ChartView("frequency", runs_points=True)
        with Vertical(id="plane"):
            yield ChartView("eigenvalues")
        yield RowsView(id="facts")

    def scene_changed(self) -> None:
        """Display the stability of the edited parameters."""
        outcome = compute_outcome(self.session.stability)
        stability, displayed = outcome.result, self._stability
        self._stability, self._error = stability, outcome.error
        if stability is not None and stability is not displayed:
            # This takes a few milliseconds.
            self._scan = compute_outcome(stability.modes_over_mu).result
        self.mark_result()
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
        text = f"{event.point.x:.6g}"
        self.post_message(PointRunRequested({"mu": text}, f"opened μ = {text}"))

    def export(self, kind: str) -> Export:
        """The displayed charts as figure; the modes over μ and the eigenvalues as data."""
        stability, charts = self._stability, self.visible_charts()
        if stability is None:
            raise InputError(f"no stability to export: {self._error}")
        heading = Heading([stability.parameters], ignores_separation=not self.session.separation)
        stem = f"{self.session.name}-{study('stability').stem(stability)}"
        return study_export(kind, "stability", stability, stem, charts=charts, heading=heading)

    def command_line(self) -> str:
        """The command that computes the stability of the edited parameters."""
        parameters, separation = self.session.parameters(), self.session.separation
        scene = replace(base_scene(), parameters=parameters, separation=separation)
        return study_command("stability", scene, self.session)
