"""The tab of the trade-off: what accuracy costs on this machine."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar

from textual import on
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Button, DataTable, Static

from fivtui.core.errors import InputError
from fivtui.scene import Scene

from .chart_view import ChartView
from .job_pane import JobPane
from .jobs import Job
from .session import Session
from .tradeoff_view import COLUMNS, TITLES, present_row, present_words, table_rows, tradeoff_chart

if TYPE_CHECKING:
    from fivtui.tradeoff import Tradeoff

_PREFIX = "quantity-"


class TradeoffPane(JobPane):
    """Errors against CPU time of the scene edited, by every method and setting."""

    VERB: ClassVar[str] = "Measure"
    HINT: ClassVar[str] = "F10 runs the scene by every method, about 7 s of CPU time"
    VIEWS: ClassVar[Mapping[str, str]] = {"errors": "Plot", "settings": "Table"}

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._result: Tradeoff | None = None
        self._quantity = "final"

    def compose_bar(self) -> ComposeResult:
        """The quantities whose errors can be shown."""
        yield Static("error of", classes="words")
        for name, title in TITLES.items():
            classes = "quantity -active" if name == self._quantity else "quantity"
            yield Button(title, id=f"{_PREFIX}{name}", classes=classes, compact=True)

    def compose_views(self) -> ComposeResult:
        """The plot with what the present setting delivers, and the table."""
        with Vertical(id="errors"):
            yield ChartView("errors-chart", nothing="not measured yet")
            yield Static("", id="present", markup=False)
        yield DataTable[str](id="settings", cursor_type="row", zebra_stripes=True)

    def on_mount(self) -> None:
        """Show errors and times over decades."""
        view = self.query_one("#errors-chart", ChartView).view
        view.log_x = view.log_y = True

    def begin(self) -> None:
        """Measure the scene edited."""
        scene = self.session.scene()

        def measure(job: Job) -> "Tradeoff":
            from fivtui.tradeoff import measure_tradeoff

            return measure_tradeoff(scene, progress=job.report)

        self.start(measure)

    def take(self, result: "Tradeoff") -> None:
        """Show what was measured."""
        self._result = result
        self.scene_changed()

    def scene_changed(self) -> None:
        """Show what the setting edited delivers."""
        if self._result is not None:
            scene = self._scene()
            outdated = scene is None or not _same(scene, self._result.scene)
            words = "the scene has changed since" if outdated else "this scene, this machine"
            self.say(f"{words}; {len(self._result.rows)} settings")
            self.draw()

    def _scene(self) -> Scene | None:
        try:
            return self.session.scene()
        except InputError:
            return None

    def draw(self) -> None:
        """Draw the view that is shown."""
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
            table = self.query_one("#settings", DataTable)
            table.clear(columns=True)
            table.add_columns(*COLUMNS)
            table.add_rows(table_rows(result, self._quantity, present))

    @on(Button.Pressed, ".quantity")
    def _chosen(self, event: Button.Pressed) -> None:
        event.stop()
        self._quantity = str(event.button.id).removeprefix(_PREFIX)
        for button in self.query(".quantity"):
            button.set_class(button is event.button, "-active")
        self.draw()


def _same(one: Scene, other: Scene) -> bool:
    # What was measured does not depend on method and accuracy.
    def physics(scene: Scene) -> tuple[object, ...]:
        return scene.parameters, scene.separation, scene.start, scene.t_end

    return physics(one) == physics(other)
