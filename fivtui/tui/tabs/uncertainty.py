"""The uncertainty tab: how likely squeal is where parameters scatter, and what drives it."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.widgets import Button, Static

from fivtui.charts import Heading
from fivtui.model import InputError
from fivtui.scene import Scene
from fivtui.tui.chart import ChartView
from fivtui.tui.session import DisplayedStudy, Job, Session, study_line

from .charts.uncertainty import (
    COLUMNS,
    EXAMPLE,
    TITLES,
    drawn,
    histogram_chart,
    index_remark,
    index_rows,
    samples_chart,
    truncation_words,
    uncertainty_request,
)
from .exports.export import Export, as_displayed, scene_study_export
from .job_pane import JobPane
from .tables import ListTable

if TYPE_CHECKING:
    from fivtui.reliability import Uncertainty

_KIND: Final = "uncertainty"
_PREFIX: Final = "scattered-"
_OUTPUT: Final = "output"
_VARY: Final = "vary"
_NOTHING: Final = "no uncertainty study to export yet: press F10"


class _IndexTable(ListTable[str]):
    wrapped = COLUMNS[0]
    dropped = ("if linear", "0 … 1")


class UncertaintyPane(JobPane):
    """Probabilities, histograms and Sobol indices of the edited scene with scattered parameters."""

    NAME: ClassVar[str] = _KIND
    VERB: ClassVar[str] = "Scatter"
    HINT: ClassVar[str] = "F10: compute"
    FORM: ClassVar[str] = "NAME~normal:MEAN:SD ~uniform:LOW:HIGH"
    VIEWS: ClassVar[Mapping[str, str]] = {
        "histogram": "Histogram",
        "indices": "Drivers",
        "samples": "Samples",
    }

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        kept = self.setting(_OUTPUT, "")
        self._output = kept if kept in TITLES else next(iter(TITLES))
        self._last: DisplayedStudy[Uncertainty] | None = None
        self._present = ""

    def compose_bar(self) -> ComposeResult:
        """The distributions."""
        yield self.study_input("scattered", _VARY, EXAMPLE)

    def compose_views(self) -> ComposeResult:
        """Histogram of a quantity, probabilities; table of Sobol indices; samples by region."""
        with Vertical(id="histogram"):
            with Horizontal(classes="bar"):
                for name, title in TITLES.items():
                    classes = "output -active" if name == self._output else "output"
                    yield Button(title, id=f"{_PREFIX}{name}", classes=classes, compact=True)
            yield ChartView("histogram-chart", nothing="nothing scattered yet: press F10")
            yield Static("", id="probabilities", markup=False)
        yield _IndexTable(id="indices", cursor_type="row", zebra_stripes=True)
        with Vertical(id="samples"):
            yield ChartView("samples-chart", nothing="nothing scattered yet: press F10")

    def check_text(self, scene: Scene, text: str) -> None:
        """Raise `InputError` if the text is not what `FORM` says."""
        uncertainty_request(scene, text)

    def begin(self) -> None:
        """Scatter the parameters of the edited scene."""
        study = uncertainty_request(self.session.scene(), self.text)
        self._present = ""

        def compute(job: Job) -> "Uncertainty":
            from fivtui.reliability import measured
            from fivtui.sweeps import local_engine

            return measured(study, local_engine(), progress=job.report, tell=self._tell)

        self.start(compute)
        for chart in self.query(ChartView):
            chart.view.reset()

    def _tell(self, _members: int, words: str) -> None:
        # Called by the computing thread; shown when the bar is.
        self._present = words

    def progressed(self) -> None:
        """Display the present probabilities and their errors."""
        view = self.query_one("#probabilities", Static)
        view.update(self._present)
        view.display = bool(self._present)

    def take(self, result: "Uncertainty") -> None:
        """Display a study."""
        self.session.studies.put(_KIND, DisplayedStudy(result, self.session.name))
        self.scene_changed()

    def scene_changed(self) -> None:
        """Display a study that was read from a file, or restored."""
        super().scene_changed()
        displayed = self.session.studies.get(_KIND)
        if displayed is not None and displayed is not self._last:
            if displayed.source:
                self.stop()
            self._last = displayed
            source = f", read from {displayed.source}" if displayed.source else ""
            result = displayed.value
            words = f"{result.scatter.samples} samples{source}"
            self.say(f"{words}{truncation_words(result)}{index_remark(result)}")
        self.draw()

    def draw(self) -> None:
        """Draw the current view."""
        if self._last is None:
            return
        result = self._last.value
        shown = drawn(result, self._output)
        for button in self.query(".output"):
            button.set_class(button.id == f"{_PREFIX}{shown}", "-active")
        if self.view == "indices":
            table: ListTable[str] = self.query_one("#indices", ListTable)
            rows = index_rows(result)
            table.fill(COLUMNS, {str(place): row for place, row in enumerate(rows)})
            return
        make = histogram_chart if self.view == "histogram" else samples_chart
        self.query_one(f"#{self.view}-chart", ChartView).show(make(result, self._output))
        if self.job is None:
            # They stand above the chart.
            self.query_one("#probabilities").display = False

    @on(Button.Pressed, ".output")
    def _chosen(self, event: Button.Pressed) -> None:
        event.stop()
        self._output = str(event.button.id).removeprefix(_PREFIX)
        self.keep(_OUTPUT, self._output)
        self.query_one("#histogram-chart", ChartView).view.reset()
        self.draw()

    def export(self, what: str) -> Export:
        """The study; its charts as displayed, from the table of indices the whole figure."""
        displayed = self.session.studies.get(_KIND)
        if displayed is None:
            raise InputError(_NOTHING)
        study = displayed.value.study
        heading = Heading([study.parameters], displayed.value.inputs)
        whole = scene_study_export(what, _KIND, displayed.value, displayed.name)
        return as_displayed(whole, self.visible_charts(), heading)

    def command_line(self) -> str:
        """The command for the displayed study, or else the one to compute."""
        displayed = self.session.studies.get(_KIND)
        if displayed is None:
            text = self.text
            study = uncertainty_request(self.session.scene(), text)
        else:
            study = displayed.value.study
        return study_line(_KIND, study, self.session.origin)
