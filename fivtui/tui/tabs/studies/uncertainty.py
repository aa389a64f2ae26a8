"""The uncertainty tab: how likely squeal is where parameters scatter, and what drives it.

Sobol indices are the shares of the variance of a quantity that each scattered parameter causes. A
region has the samples with one outcome: no squeal, squeal after a knock, or squeal by itself.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np
from textual.app import ComposeResult
from textual.containers import Vertical

from fivtui.charts import Heading
from fivtui.scene import Scene
from fivtui.tui.chart import ChartView
from fivtui.tui.session import Job, Session, symbol_of
from fivtui.tui.tabs.preview import Preview, Sketch
from fivtui.tui.tabs.requests.uncertainty import (
    COLUMNS,
    EXAMPLE,
    SAMPLES,
    TITLES,
    index_remark,
    index_rows,
    uncertainty_request,
)
from fivtui.tui.tabs.tables import ListTable

from .study_pane import ResultInputs, StudyPane, sweep_inputs

if TYPE_CHECKING:
    from fivtui.reliability import Uncertainty
    from fivtui.sweeps import Study


# Samples and a boundary of the sketch: fractions of two irrational numbers fill the plane evenly.
_INDICES: Final = np.arange(80, dtype=np.float64)
_DOTS: Final = (0.618034 * _INDICES % 1.0, 0.754878 * _INDICES % 1.0)
_Y: Final = np.linspace(0.0, 1.0, 40)


class UncertaintyPane(StudyPane):
    """Probabilities, histograms and Sobol indices of the edited scene with scattered parameters."""

    NAME: ClassVar[str] = "uncertainty"
    VERB: ClassVar[str] = "Scatter"
    INPUT: ClassVar[str] = "scattered"
    EXAMPLE: ClassVar[str] = EXAMPLE
    INPUT_FORMAT: ClassVar[str] = "NAME~normal:MEAN:SD ~uniform:LOW:HIGH"
    QUANTITIES: ClassVar[Mapping[str, str]] = TITLES
    PAGE: ClassVar[str] = "histogram"
    VIEWS: ClassVar[Mapping[str, str]] = {"samples": "Samples", **TITLES, "indices": "Drivers"}
    SKETCH: ClassVar[Sketch | None] = Sketch(
        x="μ",
        y="F",
        curves=((0.35 + 0.15 * _Y**2, _Y),),
        dots=(_DOTS,),
        labels={"no squeal": (0.04, 0.6), "squeals by itself": (0.55, 0.3)},
    )
    QUESTION: ClassVar[str] = "How likely is squeal where parameters scatter, and what drives it?"
    START: ClassVar[str] = f"computes {SAMPLES} samples of these distributions"
    TYPICAL_S: ClassVar[float] = 3.0

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        # The probabilities estimated from the samples so far, as text.
        self._estimate = ""

    @property
    def initial_text(self) -> str:
        """The stored text of the input, or else the distributions of the scene or the example."""
        texts = [f"{symbol_of(name)}~{axis}" for name, axis in self.session.loaded.scatter]
        return self.stored_setting(self.input_setting, " ".join(texts) or self.EXAMPLE)

    def compose_views(self) -> ComposeResult:
        """Histogram of a quantity; Sobol indices; samples by region."""
        with Vertical(id="histogram"):
            yield ChartView("histogram-chart")
        yield ListTable[str]("indices", wrapped=COLUMNS[0], omitted=("if linear", "0 … 1"))
        with Vertical(id="samples"):
            yield ChartView("samples-chart")

    def parse(self, scene: Scene, text: str) -> "Study":
        """The study of a scene with the distributions of the input."""
        return uncertainty_request(scene, text)

    def start_from_inputs(self) -> None:
        """Scatter the parameters of the edited scene."""
        super().start_from_inputs()
        self._estimate = ""

    def compute(self, request: "Study", job: Job) -> "Uncertainty":
        """Compute a study."""
        from fivtui.reliability import compute_uncertainty
        from fivtui.sweeps import local_engine

        # The engine computes the samples, here in threads of this process.
        return compute_uncertainty(
            request, local_engine(), progress=job.report, on_estimates=self._store_estimate
        )

    def _store_estimate(self, _members: int, estimate: str) -> None:
        # Called by the computing thread; the screen displays it with the progress.
        self._estimate = estimate

    def show_progress(self) -> None:
        """Display estimated probabilities with their errors before the first result."""
        if self.displayed is None and self._estimate:
            self.query_one(Preview).show(("", self._estimate))

    def answer_text(self, result: "Uncertainty") -> str:
        """The probabilities."""
        from fivtui.reliability import probability_text

        return probability_text(result)

    def details_text(self, result: "Uncertainty") -> str:
        """Number of samples, with remarks; on indices only beside them."""
        remark = index_remark(result) if self.view == "indices" else ""
        samples = f"{result.scatter.samples} samples{remark}"
        return "; ".join(filter(None, (samples, super().details_text(result))))

    def inputs_of(self, result: "Uncertainty") -> ResultInputs:
        """The inputs of a study."""
        return sweep_inputs(result.study)

    def draw_result(self, result: "Uncertainty") -> None:
        """Draw the current view of a study."""
        from fivtui.reliability import displayed_quantity, histogram_chart, samples_chart

        quantity = displayed_quantity(result, self.quantity)
        if self.view in self.QUANTITIES and quantity not in ("", self.view):
            # The result has no values of the chosen quantity.
            self.store_setting(self.VIEW_SETTING, quantity)
            self.show_titles()
        if self.view == "indices":
            table: ListTable[str] = self.query_one("#indices", ListTable)
            rows = index_rows(result)
            table.fill(COLUMNS, {str(index): row for index, row in enumerate(rows)})
            return
        draw = samples_chart if self.view == "samples" else histogram_chart
        self.page.query_one(ChartView).show(draw(result, quantity))

    def show_view(self, name: str) -> None:
        """Show a view; the histogram of another quantity has other limits."""
        if name in self.QUANTITIES and name != self.quantity:
            self.query_one("#histogram-chart", ChartView).view.reset()
        super().show_view(name)

    def heading(self, result: "Uncertainty") -> Heading:
        """The parameters that do not scatter, and the probabilities."""
        return replace(super().heading(result), text=self.answer_text(result))

    def request_for(self, result: "Uncertainty") -> "Study":
        """The study of a result."""
        return result.study
