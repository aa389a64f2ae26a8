"""The stability tab: modes over μ, eigenvalues, summary; updated on every edit."""

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
    plane_chart,
    scan_top,
    stability_rows,
)
from fivtui.model import Cancelled, ComputationError, InputError, Parameters
from fivtui.ranges import number_text
from fivtui.tui.chart import ChartView
from fivtui.tui.session import Session, attractor_rows, base_scene

from .messages import PointOpened
from .tables import RowsView
from .views_pane import ViewsPane

if TYPE_CHECKING:
    from .exports.export import Export

# Delay between the last key and the scan over μ, s.
_SCAN_DELAY: Final = 0.05
_MU_DIGITS: Final = 6


class StabilityPane(ViewsPane):
    """Stability of the edited parameter set."""

    NAME: ClassVar[str] = "stability"
    VIEWS: ClassVar[Mapping[str, str]] = {
        "over-mu": "Over μ",
        "plane": "Eigenvalues",
        "facts": "Summary",
    }
    LINKED: ClassVar[Sequence[Sequence[str]]] = (("growth", "frequency"),)

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._analysis: tuple[Parameters, Stability] | None = None
        self._error = ""
        self._scan_key: object = None
        self._scan: ModeScan | None = None

    def compose_views(self) -> ComposeResult:
        """Growth rates and frequencies, eigenvalues, summary."""
        with Vertical(id="over-mu"):
            yield ChartView("growth", openable=True)
            yield ChartView("frequency", openable=True)
        with Vertical(id="plane"):
            yield ChartView("eigenvalues")
        yield RowsView(id="facts")

    def scene_changed(self) -> None:
        """Display the stability of the edited parameters; the scan over μ follows."""
        try:
            p, result = self.session.parameters(), self.session.stability()
        except (InputError, ComputationError) as error:
            self._analysis, self._error, self._scan_key = None, str(error), None
            self.draw()
            return
        self._analysis = (p, result)
        top = scan_top(result)
        key = (p.with_values({"mu": 0.0}), self.session.separation, top)
        if key != self._scan_key:
            self._scan_key = key
            self.call_after_pause(_SCAN_DELAY, self._start_scan)
        self.draw()

    def _start_scan(self) -> None:
        if self._analysis is None:
            return
        key, (_, result) = self._scan_key, self._analysis

        def compute() -> None:
            worker = get_current_worker()
            try:
                scan = mode_scan(
                    result.system, scan_top(result), go_on=lambda: not worker.is_cancelled
                )
            except (Cancelled, ComputationError):
                # A missing equilibrium at one μ prevents the chart.
                return
            self.call_later(self._show_scan, key, scan)

        self.run_worker(compute, group="scan", thread=True, exclusive=True, exit_on_error=False)

    def _show_scan(self, key: object, scan: ModeScan) -> None:
        # Ignore the scan if the parameters have been edited since its start.
        if key == self._scan_key:
            self._scan = scan
            self.draw()

    def draw(self) -> None:
        """Draw the current view."""
        if self.view == "facts":
            rows = [] if self._analysis is None else stability_rows(self._analysis[1])
            attractors = self.session.attractors
            if rows and attractors is not None:
                rows[1:1] = attractor_rows(attractors)
            self.query_one("#facts", RowsView).show(rows, self._error)
        elif self.view == "plane":
            chart = None if self._analysis is None else plane_chart(self._analysis[1], self._scan)
            self.query_one("#eigenvalues", ChartView).show(chart, empty_text=self._error)
        else:
            for name, make_chart in (("growth", growth_chart), ("frequency", frequency_chart)):
                chart = None
                if self._analysis is not None and self._scan is not None:
                    chart = make_chart(self._scan, *self._analysis)
                self.query_one(f"#{name}", ChartView).show(chart, empty_text=self._error)

    @on(ChartView.Opened)
    def _run_point(self, event: ChartView.Opened) -> None:
        text = number_text(float(f"{event.point.x:.{_MU_DIGITS}g}"))
        self.post_message(PointOpened({"mu": text}, f"opened μ = {text}"))

    def export(self, kind: str) -> "Export":
        """The displayed charts as figure; the modes over μ and the eigenvalues as data."""
        from .exports.export import replace_figure, scene_study_export

        if self._analysis is None:
            raise InputError(f"no stability to export: {self._error}")
        export = scene_study_export(kind, "stability", self._analysis[1], self.session.name)
        heading = Heading([self._analysis[0]], ignores_separation=not self.session.separation)
        return replace_figure(export, self.visible_charts(), heading)

    def command_line(self) -> str:
        """The command that computes the stability of the edited parameters."""
        from fivtui.tui.session import study_command

        p = self.session.parameters()
        scene = replace(base_scene(), parameters=p, separation=self.session.separation)
        return study_command("stability", scene, self.session.origin)
