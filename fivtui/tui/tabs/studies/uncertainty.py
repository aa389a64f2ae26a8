"""The uncertainty tab: how likely squeal is where parameters scatter, and what drives it.

Sobol indices are the shares of the variance of a quantity that each scattered parameter causes. A
region has the samples with one outcome: no squeal, squeal after a knock, or squeal by itself.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import ClassVar, Final

import numpy as np
from textual.app import ComposeResult
from textual.containers import Vertical

from fivtui.charts import Heading
from fivtui.reliability import (
    Uncertainty,
    compute_uncertainty,
    displayed_quantity,
    excess_remark,
    histogram_chart,
    parse_inputs,
    probability_text,
    quantity_name,
    rank_inputs,
    samples_chart,
    scattered_study,
)
from fivtui.scene import Scene
from fivtui.sweeps import Study, local_engine
from fivtui.tui.chart import ChartView
from fivtui.tui.session import Job, replace_symbols, symbol_of
from fivtui.tui.tabs.preview import Sketch
from fivtui.tui.tabs.tables import ListTable

from .study_pane import QUANTITY_PAGE, SweepStudyPane

SAMPLES: Final = 4096
# Columns of the table of Sobol indices. The first-order index is the share of the variance that an
# input causes alone, the total index that with others. The last columns are the share in a linear
# model, and a bar.
_COLUMNS: Final = ("quantity", "input", "alone", "with others", "if linear", "0 … 1")
# Columns of a bar from 0 to 1.
_BAR_LENGTH: Final = 12
# Samples and a boundary of the sketch: fractions of two irrational numbers fill the plane evenly.
_INDICES: Final = np.arange(80, dtype=np.float64)
_DOTS: Final = (0.618034 * _INDICES % 1.0, 0.754878 * _INDICES % 1.0)
_Y: Final = np.linspace(0.0, 1.0, 40)


def index_rows(result: Uncertainty) -> Sequence[Sequence[str]]:
    """Sobol indices of every quantity as rows of `_COLUMNS`, by decreasing total index."""
    rows = []
    for name, indices in result.indices.items():
        # From derivatives at the means of all inputs.
        linear_indices = result.local.get(name, {})
        for rank, (input_name, index) in enumerate(rank_inputs(indices)):
            first, total, linear = index.first, index.total, linear_indices.get(input_name)
            rows.append((
                "" if rank else quantity_name(name),
                symbol_of(input_name),
                f"{first.value:z.2f} ± {first.error:.2f}",
                f"{total.value:z.2f} ± {total.error:.2f}",
                "" if linear is None else f"{linear.share:.2f}",
                index_bar(first.value, total.value),
            ))  # fmt: skip
    return rows


def index_bar(first: float, total: float) -> str:
    """A bar from 0 to 1, dark up to the first-order index, light up to the total index."""
    dark, end = (round(_BAR_LENGTH * min(max(index, 0.0), 1.0)) for index in (first, total))
    return "█" * dark + "░" * max(end - dark, 0)


def index_remark(result: Uncertainty) -> str:
    """A note on Sobol indices above 1 or below 0; empty if there are none."""
    indices = (text for _, _, *texts, _, _ in index_rows(result) for text in texts)
    remarks = sorted({*map(excess_remark, indices)} - {""})
    return f", indices {' and '.join(remarks)}: sampling error" if remarks else ""


class UncertaintyPane(SweepStudyPane):
    """Probabilities, histograms and Sobol indices of the edited scene with scattered parameters."""

    NAME: ClassVar[str] = "uncertainty"
    VERB: ClassVar[str] = "Scatter"
    EXAMPLE: ClassVar[str] = "μ~uniform:0.2:0.8 F~normal:80:8"
    INPUT_FORMAT: ClassVar[str] = "NAME~normal:MEAN:SD ~uniform:LOW:HIGH"
    QUANTITIES: ClassVar[Mapping[str, str]] = {
        "growth_rate": "Growth",
        "critical_mu": "μ_c",
        "safe_mu": "Safe μ",
        "y_half_range": "±y",
        "P_max": "P",
    }
    VIEWS: ClassVar[Mapping[str, str]] = {"samples": "Samples", **QUANTITIES, "indices": "Drivers"}
    SKETCH: ClassVar[Sketch | None] = Sketch(
        question="How likely is squeal where parameters scatter, and what drives it?",
        x="μ",
        y="F",
        curves=((0.35 + 0.15 * _Y**2, _Y),),
        dots=(_DOTS,),
        labels={"no squeal": (0.04, 0.6), "squeals by itself": (0.55, 0.3)},
    )
    START: ClassVar[str] = f"computes {SAMPLES} samples of these distributions"
    TYPICAL_S: ClassVar[float] = 3.0

    @property
    def example(self) -> str:
        """The distributions of the scene, or else usual ones."""
        texts = [f"{symbol_of(name)}~{axis}" for name, axis in self.session.loaded.scatter]
        return " ".join(texts) or self.EXAMPLE

    def compose_views(self) -> ComposeResult:
        """Histogram of a quantity; Sobol indices; samples by region."""
        with Vertical(id=QUANTITY_PAGE):
            yield ChartView("histogram-chart")
        yield ListTable[str]("indices", wrapped="quantity", omitted=("if linear", "0 … 1"))
        with Vertical(id="samples"):
            yield ChartView("samples-chart")

    @staticmethod
    def parse(scene: Scene, text: str) -> Study:
        """The study of a scene with the distributions of the input, not with its own."""
        inputs = parse_inputs(replace_symbols(text).split())
        return scattered_study(replace(scene, scatter=()), inputs, samples=SAMPLES)

    def compute(self, request: Study, job: Job) -> Uncertainty:
        """Compute a study."""

        def store_estimate(_members: int, estimate: str) -> None:
            job.note = estimate

        # The engine computes the samples, here in threads of this process.
        return compute_uncertainty(
            request, local_engine(), progress=job.report, on_estimates=store_estimate
        )

    def answer_text(self, result: Uncertainty) -> str:
        """The probabilities."""
        return probability_text(result)

    def details_text(self, result: Uncertainty) -> str:
        """Number of samples, with remarks; on indices only beside them."""
        remark = index_remark(result) if self.view == "indices" else ""
        samples = f"{result.scatter.samples} samples{remark}"
        return "; ".join(filter(None, (samples, super().details_text(result))))

    def draw_result(self, result: Uncertainty) -> None:
        """Draw the current view of a study."""
        quantity = displayed_quantity(result, self.quantity)
        if self.view in self.QUANTITIES and quantity not in ("", self.view):
            # The result has no values of the chosen quantity.
            self.store_setting(self.VIEW_SETTING, quantity)
            self.show_titles()
        if self.view == "indices":
            table: ListTable[str] = self.query_one("#indices", ListTable)
            table.fill(_COLUMNS, {str(index): row for index, row in enumerate(index_rows(result))})
            return
        draw = samples_chart if self.view == "samples" else histogram_chart
        self.page.query_one(ChartView).show(draw(result, quantity))

    def heading(self, result: Uncertainty) -> Heading:
        """The parameters that do not scatter, and the probabilities."""
        return replace(super().heading(result), text=self.answer_text(result))
