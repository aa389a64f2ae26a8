"""The fit tab: parameters fitted to measured signals and features."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Final

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical

from fivtui.charts import Heading
from fivtui.identification import Identification, IdentifyOptions, fit_charts, prepare_fit, unit_of
from fivtui.scene import Scene
from fivtui.studies import study
from fivtui.transient import START_SPECS
from fivtui.tui.chart import ChartView
from fivtui.tui.session import Job, replace_symbols, scene_texts, symbol_of
from fivtui.tui.tabs.job_pane import FACTS
from fivtui.tui.tabs.messages import PointRunRequested
from fivtui.tui.tabs.option_input import OptionInput, option_help, read_option_text
from fivtui.tui.tabs.preview import FILE_FORMAT, MEASURED_SKETCH, Sketch
from fivtui.tui.tabs.tables import RowsView

from .study_pane import ResultInputs, StudyPane

_NO_SIGNALS: Final = "Features have no signals over time: v shows the fitted values."


class IdentificationPane(StudyPane):
    """Parameters of the edited scene fitted to measured records and features."""

    NAME: ClassVar[str] = "identification"
    VERB: ClassVar[str] = "Fit"
    EXAMPLE: ClassVar[str] = "--target critical-mu=0.45±0.01 --fit F"
    INPUT_FORMAT: ClassVar[str] = "FILE.csv --signal NAME --fit NAME=LOW:HIGH --target NAME=N±SD"
    VIEWS: ClassVar[Mapping[str, str]] = {"fit": "Signals", "fitted-values": "Values"}
    SKETCH: ClassVar[Sketch | None] = replace(
        MEASURED_SKETCH, question="Which values explain what a rig did?"
    )
    START: ClassVar[str] = "fits the values of the input"
    REQUEST: ClassVar[str] = "request"
    # Index of the measured signal that is shown, beyond the last from the first again.
    _signal_index = 0
    NOTE: ClassVar[str] = f"To fit a record, enter rig.csv --signal y --fit μ. {FILE_FORMAT}"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("enter", "apply_values", "Apply", key_display="⏎", tooltip="Run the fitted values"),
        Binding("s", "next_signal", "Next signal"),
    ]

    def compose_views(self) -> ComposeResult:
        """Both signals and the residuals; the fitted values."""
        with Vertical(id="fit"):
            yield ChartView("fit-signals", empty_text=_NO_SIGNALS)
            yield ChartView("fit-residuals")
        yield RowsView(id="fitted-values")

    def compose_bar(self) -> ComposeResult:
        """The files and options of the fit."""
        identifier = f"{self.NAME}-input"
        yield OptionInput(self.initial_text, IdentifyOptions, id=identifier, classes="study-input")

    @property
    def input_format(self) -> str:
        """The meaning of the option being typed."""
        return option_help(IdentifyOptions, self.text, self.INPUT_FORMAT)

    @staticmethod
    def parse(scene: Scene, text: str) -> tuple[Scene, IdentifyOptions]:
        """The scene, and the options of `fivtui identify` in a text; files may come first."""
        scene.check_constant("a fit")
        options, files = read_option_text(IdentifyOptions, text)
        options = replace(
            options,
            measured=(*files, *map(Path, options.measured)),
            fit=tuple(map(replace_symbols, options.fit)),
            own=tuple(map(replace_symbols, options.own)),
        )
        prepare_fit(scene, options)
        return scene, options

    def compute(self, request: tuple[Scene, IdentifyOptions], job: Job) -> Identification:
        """Fit the parameters of a scene."""
        return prepare_fit(*request)(progress=job.report)

    def show_result(self, result: Identification) -> None:
        """Display a fit."""
        self._signal_index = 0
        super().show_result(result)
        if not result.t.size:
            # Targets have no signals to draw.
            self.show_view("fitted-values")

    def answer_text(self, result: Identification) -> str:
        """The fitted values with their units."""
        return FACTS.join(
            f"{symbol_of(key)} {value.value:.5g} {unit_of(key)}".rstrip()
            for key, value in result.fit.items()
        )

    def inputs_of(self, result: Identification) -> ResultInputs:
        """The values that were not fitted."""
        # Names of fitted values may be followed by the number of a file.
        fitted = [key.partition(".")[0] for key in result.fit]
        settings: dict[str, Any] = {"separation": result.scene.separation}
        if result.t.size and START_SPECS.keys().isdisjoint(fitted):
            settings["start"] = result.scene.start
        return ResultInputs(result.scene.parameters, fitted, settings)

    def draw_result(self, result: Identification) -> None:
        """Draw both signals and the residuals of a record, or list the values."""
        if self.view != "fit":
            self.query_one(RowsView).show(study(self.NAME).rows(result), "")
            return
        pairs = fit_charts(result)
        charts = pairs[self._signal_index % len(pairs)] if pairs else (None, None)
        for chart_view, chart in zip(self.query(ChartView), charts, strict=True):
            chart_view.show(chart)

    def action_next_signal(self) -> None:
        """Show the next measured signal."""
        self._signal_index += 1
        self.fit_axes()
        self.draw()

    def action_apply_values(self) -> None:
        """Take the fitted values into the form, and run them."""
        if self.displayed is not None:
            result: Identification = self.displayed.value
            report = f"opened the fit; {result.warning or self.answer_text(result)}"
            self.post_message(PointRunRequested(scene_texts(result.scene), report))

    def heading(self, result: Identification) -> Heading:
        """The fitted parameters."""
        return Heading([result.parameters], ignores_separation=not result.scene.separation)
