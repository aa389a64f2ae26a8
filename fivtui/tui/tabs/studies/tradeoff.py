"""The trade-off tab: error against CPU time of methods and their settings, on this machine.

A setting is a method with a tolerance or step; the current one is that of the edited scene. It is
on the Pareto front if no other measured setting is both faster and more accurate. The floor is the
uncertainty of the errors themselves.
"""

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar, Final

from textual.app import ComposeResult
from textual.containers import Vertical

from fivtui.scene import Scene
from fivtui.tradeoffs import (
    QUICK_S,
    MeasuredSetting,
    Tradeoff,
    cheapest,
    measure_tradeoff,
    settings_table,
    tradeoff_chart,
)
from fivtui.transient import uses_step
from fivtui.tui.chart import ChartView
from fivtui.tui.session import Job
from fivtui.tui.tabs.preview import Sketch, about
from fivtui.tui.tabs.tables import ListTable

from .study_pane import QUANTITY_PAGE, ResultInputs, StudyPane

# Settings whose values differ by fewer decades than this count as equal.
_EQUAL_DECADES: Final = 0.3


def current_setting(result: Tradeoff, scene: Scene) -> MeasuredSetting | None:
    """The measured setting nearest to that of a scene.

    None if its method was not measured, or if error targets or a default choose the setting.
    """
    if scene.accuracy:
        return None
    rows = [
        row
        for row in result.rows
        if row.setting.method == scene.method
        and row.setting.kernel != "interpreted"
        and row.error is not None
        and getattr(scene, row.setting.knob) is not None
    ]
    return min(rows, key=lambda row: _decades(row, scene), default=None)


def _decades(row: MeasuredSetting, scene: Scene) -> float:
    # Ratio of a measured tolerance or step to that of a scene, in decades.
    return abs(math.log10(row.setting.value / getattr(scene, row.setting.knob)))


def setting_text(result: Tradeoff, scene: Scene, quantity: str) -> str:
    """Error and time of a scene's setting, and the cheapest setting that is as accurate."""
    if scene.accuracy:
        return "; ".join(
            f"{name} to {error:g}: {_row_text(cheapest(result.rows, name, error), name)}"
            for name, error in scene.accuracy
        )
    current = current_setting(result, scene)
    if current is None or current.error is None:
        if scene.step is None and uses_step(scene.method):
            # Measured settings have steps, to which no step of the scene could be compared.
            return f"{scene.method} with its default step: enter a step to see its error"
        return f"{scene.method} was not measured"
    is_same = _decades(current, scene) < _EQUAL_DECADES
    text = f"{'now' if is_same else 'nearest measured:'} {_row_text(current, quantity)}"
    # Errors below the reference's uncertainty count as equal.
    error = max(current.error.of(quantity), result.floor.of(quantity))
    better = cheapest(result.rows, quantity, error)
    if better is None or better.setting == current.setting or better.cpu_s >= current.cpu_s:
        return f"{text}; no measured setting is as accurate in less time"
    ratio = current.cpu_s / better.cpu_s
    return f"{text}; as accurate, {ratio:.2g} times faster: {_row_text(better, quantity)}"


def _row_text(row: MeasuredSetting | None, quantity: str) -> str:
    if row is None or row.error is None:
        return "no setting measured"
    measurement = f"error {row.error.of(quantity):.1e}, {1e3 * row.cpu_s:.3g} ms"
    return f"{row.setting.label} {row.setting.text}, {measurement}"


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
    # The half range is ± half the peak-to-peak of y over the second half of the run.
    QUANTITIES: ClassVar[Mapping[str, str]] = {
        "final": "State",
        "peak": "Peak",
        "half_range": "±2nd ½",
        "events": "Events",
    }
    VIEWS: ClassVar[Mapping[str, str]] = {**QUANTITIES, "settings": "Table"}
    SKETCH: ClassVar[Sketch | None] = Sketch(
        question="Which method reaches an accuracy in the shortest time?",
        x="CPU time",
        y="error",
        curves=(([0.05, 0.4], [0.95, 0.05]), ([0.35, 0.95], [0.95, 0.35])),
        labels={"taylor": (0.3, 0.3), "rk4": (0.75, 0.75)},
    )
    START: ClassVar[str] = "measures all methods and settings"
    REQUEST: ClassVar[str] = "scene"

    def compose_views(self) -> ComposeResult:
        """Chart and table."""
        with Vertical(id=QUANTITY_PAGE):
            yield ChartView("errors-chart", log="xy")
        yield ListTable[str]("settings", wrapped="method", omitted=_OMITTED, fixed_columns=1)

    def start_text(self) -> str:
        """What the key measures, and the CPU time that it takes on every machine."""
        return f"{self.START}, {about(QUICK_S)}"

    @staticmethod
    def parse(scene: Scene, text: str) -> Scene:  # noqa: ARG004
        """The scene, which must not have tables over time."""
        scene.check_constant("a trade-off")
        return scene

    def compute(self, request: Scene, job: Job) -> Tradeoff:
        """Measure a scene."""
        return measure_tradeoff(request, progress=job.report)

    def answer_text(self, result: Tradeoff) -> str:
        """Error and time of the setting of the edited scene, and a faster setting."""
        edited = self.edited
        return "" if edited is None else setting_text(result, edited, self.quantity)

    def inputs_of(self, result: Tradeoff) -> ResultInputs:
        """The measured motion; method and accuracy do not count."""
        names = ("separation", "start", "t_end", "over_time")
        settings = {name: getattr(result.scene, name) for name in names}
        return ResultInputs(result.scene.parameters, (), settings)

    def draw_result(self, result: Tradeoff) -> None:
        """Draw the current view, with error and time of the current setting."""
        current = None if self.edited is None else current_setting(result, self.edited)
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
