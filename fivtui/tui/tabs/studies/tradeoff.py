"""The trade-off tab: error against CPU time of methods and their settings, on this machine.

A setting is a method with a tolerance or step; the current one is that of the edited scene.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Static

from fivtui.charts import Heading
from fivtui.model import InputError
from fivtui.scene import Scene
from fivtui.tradeoffs import tradeoff_chart
from fivtui.tui.chart import ChartView
from fivtui.tui.session import DisplayedStudy, Job
from fivtui.tui.tabs.preview import Sketch
from fivtui.tui.tabs.requests.tradeoff import (
    TITLES,
    current_setting,
    setting_text,
    table_columns,
    table_rows,
)
from fivtui.tui.tabs.tables import ListTable

from .study_pane import StudyPane, with_inputs

if TYPE_CHECKING:
    from fivtui.tradeoffs import Tradeoff


class _SettingsTable(ListTable[str]):
    wrapped_column, omitted_if_narrow = "method", ("sep.", "steps", "remark")


class TradeoffPane(StudyPane):
    """Errors against CPU time of the edited scene, for every method and setting."""

    NAME: ClassVar[str] = "trade-off"
    VERB: ClassVar[str] = "Measure"
    STATUS_BELOW: ClassVar[bool] = False
    QUANTITIES: ClassVar[Mapping[str, str]] = TITLES
    PAGE: ClassVar[str] = "errors"
    VIEWS: ClassVar[Mapping[str, str]] = {**TITLES, "settings": "Table"}
    LOG_AXES: ClassVar[Mapping[str, str]] = {"errors-chart": "xy"}
    SKETCH: ClassVar[Sketch | None] = Sketch(
        x="CPU time",
        y="error",
        curves=(([0.05, 0.4], [0.95, 0.05]), ([0.35, 0.95], [0.95, 0.35])),
        labels={"taylor": (0.3, 0.3), "rk4": (0.75, 0.75)},
    )
    QUESTION: ClassVar[str] = "Which method reaches an accuracy in the shortest time?"
    START: ClassVar[str] = "measures all methods and settings"
    TYPICAL_S: ClassVar[float] = 7.0

    def compose_views(self) -> ComposeResult:
        """Chart with the current setting as text, and table."""
        with Vertical(id="errors"):
            yield ChartView("errors-chart")
            yield Static("", id="present", markup=False)
        yield _SettingsTable(id="settings", cursor_type="row", zebra_stripes=True, fixed_columns=1)

    def compute(self, request: Scene, job: Job) -> "Tradeoff":
        """Measure a scene."""
        from fivtui.tradeoffs import measure_tradeoff

        return measure_tradeoff(request, progress=job.report)

    def result_status(self, displayed: "DisplayedStudy[Tradeoff]") -> str:
        """Where the result was measured, and the number of rows."""
        source = f"read from {displayed.source}" if displayed.source else "this machine"
        return f"{source}, {len(displayed.value.rows)} rows"

    def computed_scene(self, result: "Tradeoff", edited: Scene) -> Scene:
        """The edited scene with the measured motion; method and accuracy do not count."""
        names = ("separation", "start", "t_end", "over_time")
        settings = {name: getattr(result.scene, name) for name in names}
        return with_inputs(edited, result.scene.parameters, (), **settings)

    def _edited_scene(self) -> Scene | None:
        try:
            return self.session.scene()
        except InputError:
            return None

    def draw_result(self, result: "Tradeoff") -> None:
        """Draw the current view, with error and time of the current setting."""
        scene, quantity = self._edited_scene(), self.quantity
        current = None if scene is None else current_setting(result, scene)
        if self.view in self.QUANTITIES:
            chart = tradeoff_chart(result, quantity, current)
            self.query_one("#errors-chart", ChartView).show(chart)
            text = "" if scene is None else setting_text(result, scene, quantity, current)
            self.query_one("#present", Static).update(text)
        else:
            rows = table_rows(result, quantity, current)
            table: ListTable[str] = self.query_one("#settings", ListTable)
            table.fill(table_columns(result), {str(index): row for index, row in enumerate(rows)})

    def heading(self, result: "Tradeoff") -> Heading:
        """The parameters of the scene."""
        return Heading([result.scene.parameters], ignores_separation=not result.scene.separation)

    def request_for(self, result: "Tradeoff") -> Scene:
        """The scene of a measurement."""
        return result.scene
