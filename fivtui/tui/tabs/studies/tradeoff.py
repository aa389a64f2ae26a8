"""The trade-off tab: error against CPU time of methods and their settings, on this machine.

A setting is a method with a tolerance or step; the current one is that of the edited scene.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar, Final

from textual.app import ComposeResult
from textual.containers import Vertical

from fivtui.model import InputError
from fivtui.scene import Scene
from fivtui.tradeoffs import QUICK_S, MeasuredSetting, settings_table, tradeoff_chart
from fivtui.tui.chart import ChartView
from fivtui.tui.session import Job
from fivtui.tui.tabs.preview import Sketch, about
from fivtui.tui.tabs.requests.tradeoff import TITLES, current_setting, setting_text
from fivtui.tui.tabs.tables import ListTable

from .study_pane import ResultInputs, StudyPane

if TYPE_CHECKING:
    from fivtui.tradeoffs import Tradeoff


# Columns that a narrow table of settings omits.
_OMITTED: Final = (
    "sticks",
    "separations",
    "steps",
    "events s",
    "half peak-to-peak",
    "peak |y|",
    "best for",
)


class TradeoffPane(StudyPane):
    """Errors against CPU time of the edited scene, for every method and setting."""

    NAME: ClassVar[str] = "trade-off"
    VERB: ClassVar[str] = "Measure"
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

    def compose_views(self) -> ComposeResult:
        """Chart and table."""
        with Vertical(id="errors"):
            yield ChartView("errors-chart")
        yield ListTable[str]("settings", wrapped="method", omitted=_OMITTED, fixed_columns=1)

    def start_text(self) -> str:
        """What the key measures, and the CPU time that it takes on every machine."""
        return f"{self.START}, {about(QUICK_S)}"

    def compute(self, request: Scene, job: Job) -> "Tradeoff":
        """Measure a scene."""
        from fivtui.tradeoffs import measure_tradeoff

        return measure_tradeoff(request, progress=job.report)

    def answer_text(self, result: "Tradeoff") -> str:
        """Error and time of the setting of the edited scene, and a faster setting."""
        scene, current = self._edited_setting(result)
        return "" if scene is None else setting_text(result, scene, self.quantity, current)

    def inputs_of(self, result: "Tradeoff") -> ResultInputs:
        """The measured motion; method and accuracy do not count."""
        names = ("separation", "start", "t_end", "over_time")
        settings = {name: getattr(result.scene, name) for name in names}
        return ResultInputs(result.scene.parameters, (), settings)

    def _edited_setting(self, result: "Tradeoff") -> tuple[Scene | None, MeasuredSetting | None]:
        # The edited scene, and the measured setting that is nearest to its own.
        try:
            scene = self.session.scene()
        except InputError:
            return None, None
        return scene, current_setting(result, scene)

    def draw_result(self, result: "Tradeoff") -> None:
        """Draw the current view, with error and time of the current setting."""
        _, current = self._edited_setting(result)
        if self.view in self.QUANTITIES:
            chart = tradeoff_chart(result, self.quantity, current)
            self.query_one("#errors-chart", ChartView).show(chart)
        else:
            columns, cells = settings_table(result)
            rows: dict[str, Sequence[str]] = {}
            for number, (row, (*head, best)) in enumerate(zip(result.rows, cells, strict=True)):
                rows[str(number)] = (*head, f"{best} now".lstrip() if row is current else best)
            table: ListTable[str] = self.query_one("#settings", ListTable)
            # "final state" would not fit beside the method in 80 columns.
            table.fill([column.removeprefix("final ") for column in columns], rows)

    def request_for(self, result: "Tradeoff") -> Scene:
        """The scene of a measurement."""
        return result.scene
