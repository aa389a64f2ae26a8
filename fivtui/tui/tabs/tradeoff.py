"""The trade-off tab: error against CPU time on this machine."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar

from textual import on
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Button, Static

from fivtui.charts import Heading
from fivtui.model import InputError
from fivtui.scene import Scene
from fivtui.tradeoffs import tradeoff_chart
from fivtui.tui.chart import ChartView
from fivtui.tui.session import DisplayedStudy, Job, Session, study_line

from .charts.tradeoff import (
    TITLES,
    columns_of,
    present_row,
    present_words,
    table_rows,
)
from .exports.export import Export, as_displayed, scene_study_export
from .job_pane import JobPane
from .tables import ListTable

if TYPE_CHECKING:
    from fivtui.tradeoffs import Tradeoff

_PREFIX = "quantity-"
_QUANTITY = "quantity"
_NOTHING = "no trade-off to export yet: press F10"


class _Settings(ListTable[str]):
    wrapped, dropped = "method", ("sep.", "steps", "remark")


class TradeoffPane(JobPane):
    """Errors against CPU time of the edited scene, for every method and setting."""

    NAME: ClassVar[str] = "trade-off"
    VERB: ClassVar[str] = "Measure"
    HINT: ClassVar[str] = "F10: measure (about 7 s)"
    VIEWS: ClassVar[Mapping[str, str]] = {"errors": "Plot", "settings": "Table"}
    LOG_AXES: ClassVar[Mapping[str, str]] = {"errors-chart": "xy"}

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        kept = self.setting(_QUANTITY, "")
        self._quantity = kept if kept in TITLES else next(iter(TITLES))
        self._last: DisplayedStudy[Tradeoff] | None = None

    def compose_bar(self) -> ComposeResult:
        """The quantities whose error can be displayed."""
        yield Static("error of", classes="words")
        for name, title in TITLES.items():
            classes = "quantity -active" if name == self._quantity else "quantity"
            yield Button(title, id=f"{_PREFIX}{name}", classes=classes, compact=True)

    def compose_views(self) -> ComposeResult:
        """Chart with the current setting in words, and table."""
        with Vertical(id="errors"):
            yield ChartView("errors-chart", nothing="not measured yet: press F10")
            yield Static("", id="present", markup=False)
        yield _Settings(id="settings", cursor_type="row", zebra_stripes=True, fixed_columns=1)

    def begin(self) -> None:
        """Measure the edited scene."""
        scene = self.session.scene()

        def measure(job: Job) -> "Tradeoff":
            from fivtui.tradeoffs import measure_tradeoff

            return measure_tradeoff(scene, progress=job.report)

        self.start(measure)

    def take(self, result: "Tradeoff") -> None:
        """Display the measurement."""
        self.session.studies.put("trade-off", DisplayedStudy(result, result.scene.name))
        self.scene_changed()

    @property
    def _result(self) -> "Tradeoff | None":
        # Measured here, read from a file, or restored.
        displayed = self.session.studies.get("trade-off")
        return None if displayed is None else displayed.value

    def scene_changed(self) -> None:
        """Display what the edited setting delivers."""
        displayed = self.session.studies.get("trade-off")
        if displayed is not None:
            if displayed is not self._last and displayed.source:
                self.stop()
            self._last = displayed
            scene = self._scene()
            outdated = scene is None or not _same(scene, displayed.value.scene)
            words = "the scene has changed since" if outdated else "this scene, this machine"
            if displayed.source:
                words = f"{'another' if outdated else 'this'} scene, read from {displayed.source}"
            if self.job is None:
                self.say(f"{words}, {len(displayed.value.rows)} rows")
            self.draw()

    def _scene(self) -> Scene | None:
        try:
            return self.session.scene()
        except InputError:
            return None

    def draw(self) -> None:
        """Draw the current view."""
        result = self._result
        if result is None:
            return
        scene = self._scene()
        present = None if scene is None else present_row(result, scene)
        if self.view == "errors":
            chart = tradeoff_chart(result, self._quantity, present)
            self.query_one("#errors-chart", ChartView).show(chart)
            words = ""
            if scene is not None:
                words = present_words(result, scene, self._quantity, present)
            self.query_one("#present", Static).update(words)
        else:
            rows = table_rows(result, self._quantity, present)
            table: ListTable[str] = self.query_one("#settings", ListTable)
            table.fill(columns_of(result), {str(place): row for place, row in enumerate(rows)})

    @on(Button.Pressed, ".quantity")
    def _chosen(self, event: Button.Pressed) -> None:
        event.stop()
        self._quantity = str(event.button.id).removeprefix(_PREFIX)
        self.keep(_QUANTITY, self._quantity)
        for button in self.query(".quantity"):
            button.set_class(button is event.button, "-active")
        self.draw()

    def export(self, what: str) -> Export:
        """The measurement; its chart as displayed."""
        displayed = self.session.studies.get("trade-off")
        if displayed is None:
            raise InputError(_NOTHING)
        scene = displayed.value.scene
        heading = Heading([scene.parameters], ignored=not scene.separation)
        whole = scene_study_export(what, "trade-off", displayed.value, displayed.name)
        return as_displayed(whole, self.visible_charts(), heading)

    def command_line(self) -> str:
        """The command for the displayed measurement, or else the edited scene."""
        result = self._result
        scene = self.session.scene() if result is None else result.scene
        return study_line("trade-off", scene, self.session.origin)


def _same(one: Scene, other: Scene) -> bool:
    # A measurement does not depend on method and accuracy.
    def physics(scene: Scene) -> tuple[object, ...]:
        return scene.parameters, scene.separation, scene.start, scene.t_end

    return physics(one) == physics(other)
