"""A pane that computes, displays and exports the results of one kind of study."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, ClassVar, Final, NamedTuple

from textual import on
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.events import DescendantBlur, DescendantFocus
from textual.widgets import Input

from fivtui.charts import Heading, NearestPoint
from fivtui.model import InputError, Parameters
from fivtui.ranges import number_text, with_decimal_points
from fivtui.scene import Scene
from fivtui.studies import study
from fivtui.transient import START_SPECS
from fivtui.tui.chart import ChartView, ShadeScale, TextInput
from fivtui.tui.session import (
    SAFETY_MAPS,
    DisplayedStudy,
    Job,
    Session,
    change_texts,
    compute_outcome,
    study_command,
)
from fivtui.tui.tabs.export import Export, study_export
from fivtui.tui.tabs.job_pane import FACTS, JobPane
from fivtui.tui.tabs.messages import PointRunRequested
from fivtui.tui.tabs.preview import Preview, Sketch, about_here
from fivtui.tui.tabs.views_pane import OUTDATED_NOTE

# Identifier of the page that views of quantities share.
QUANTITY_PAGE: Final = "quantities"
# Key of the quantity displayed last.
_QUANTITY_SETTING: Final = "quantity"


class ResultInputs(NamedTuple):
    """What a result depends on: parameters, except the varied ones, and settings of its scene."""

    parameters: Parameters
    varied: Sequence[str]
    settings: Mapping[str, Any]


class StudyPane(JobPane):
    """The tab of a kind of study; a subclass defines input, views, computation and charts.

    From the edited scene and the text of the input, `parse` makes a request, from which `compute`
    makes the result. A displayed result may also come from a file or from the saved session.
    """

    STATUS_BELOW: ClassVar[bool] = True
    # Initial text of the input; if empty, there is no input. Its format, displayed while it is
    # focused.
    EXAMPLE: ClassVar[str] = ""
    INPUT_FORMAT: ClassVar[str] = ""
    # Identifiers and titles of the views that display a quantity each, in `QUANTITY_PAGE`.
    QUANTITIES: ClassVar[Mapping[str, str]] = {}
    # What starting the study does, as a verb with objects; its usual duration, s, as measured where
    # `relative_duration` is 1; further sentences before the first result.
    START: ClassVar[str] = ""
    TYPICAL_S: ClassVar[float] = 0.0
    NOTE: ClassVar[str] = ""
    # Attribute of a result that is its request; if empty, the result itself says its command.
    REQUEST: ClassVar[str] = ""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        # Whether the input has the focus, so that the bar shows its format.
        self._is_typing = False
        # Error message of the input.
        self._error = ""
        self.kind = "map" if self.NAME in SAFETY_MAPS else self.NAME
        # The example for the last scene.
        self._example = self.example

    # The input

    def compose_bar(self) -> ComposeResult:
        """The input, if there is one."""
        if self.EXAMPLE:
            yield TextInput(
                self.initial_text,
                replace_commas=with_decimal_points,
                id=f"{self.NAME}-input",
                classes="study-input",
                compact=True,
                select_on_focus=False,
            )

    @property
    def input_setting(self) -> str:
        """Key of the setting that stores the text of the input."""
        return "vary"

    @property
    def example(self) -> str:
        """The initial text of the input for the edited scene."""
        return self.EXAMPLE

    @property
    def initial_text(self) -> str:
        """The stored text of the input, or else the example."""
        return self.stored_setting(self.input_setting, self.example)

    @property
    def friction_range(self) -> str:
        """Usual values of μ that the edited scene allows: μ must not exceed `mu_s`."""
        mu_s = (self.edited or self.session.loaded).parameters.mu_s
        high = min(1.0, mu_s or 1.0)
        return f"{number_text(min(0.2, high / 2.0))}:{number_text(high)}"

    @property
    def text(self) -> str:
        """The text of the input; empty if there is none."""
        return self.query_one(".study-input", TextInput).value if self.EXAMPLE else ""

    @property
    def input_format(self) -> str:
        """The format of the input, displayed while it has the focus."""
        return self.INPUT_FORMAT

    def parse(self, scene: Scene, text: str) -> Any:  # noqa: ARG002
        """The request for a scene and the text of the input; raises `InputError` if invalid."""
        return scene

    def request(self) -> Any:
        """The request for the edited scene and the input; raises `InputError` if invalid."""
        return self.parse(self.session.scene(), self.text)

    @on(Input.Changed, ".study-input")
    def _store_input(self, event: Input.Changed) -> None:
        event.stop()
        # Store the current value: the value of the event may belong to an earlier choice.
        self.store_setting(self.input_setting, event.input.value)
        self.check_input()

    def check_input(self) -> None:
        """Check the input and display its error."""
        scene = self.edited or self.session.loaded
        self._error = compute_outcome(lambda: self.parse(scene, self.text)).error
        self.query_one(".study-input").set_class(bool(self._error), "-invalid")
        self.show_bar()

    @on(Input.Submitted, ".study-input")
    def _submit(self, event: Input.Submitted) -> None:
        # Compute what was typed, in place of what is being computed; an invalid text stops nothing.
        event.stop()
        if not self._error:
            self.fit_axes()
            self.stop()
        if self.job is None:
            self.toggle_computation()

    @on(DescendantFocus)
    @on(DescendantBlur)
    def _show_format(self) -> None:
        # Display the format of a focused input, else the status. The events may come in any order.
        focused = self.screen.focused
        self._is_typing = isinstance(focused, Input) and self in focused.ancestors
        self.show_bar()

    def show_status(self, status: str, answer: str = "") -> None:
        """Display an answer and a status in the bar while no job is running."""
        self._is_typing = False
        super().show_status(status, answer)

    def show_bar(self) -> None:
        """Display the progress of a job, an error of the input, its format, or the status."""
        text = self._error or (self.input_format if self._is_typing else self.status)
        answer = "" if self._error else self.answer
        self.show_action(self.job, text, answer=answer, is_error=bool(self._error))
        self._show_preview()

    # Before the first result

    @property
    def sketch(self) -> Sketch | None:
        """The sketch of the result of the current view."""
        return self.SKETCH

    def _show_preview(self) -> None:
        sketch = self.sketch if self.displayed is None else None
        self.set_class(sketch is not None, "-empty")
        if sketch is not None:
            keys = self.session.key_names
            edit = [(keys["go-bar"], "goes to the input above.")] if self.EXAMPLE else []
            if self.job is None:
                action, note = self.start_text(), self.NOTE
            else:
                action, note = "stops the computation", self.job.note
            # Why a scene with tables over time cannot be studied.
            refusal = compute_outcome(self.request).error if self.session.over_time else ""
            start = ("", f"{refusal}.") if refusal else (keys["compute"], f"{action}.")
            self.query_one(Preview).show(sketch, start, *edit, *([("", note)] if note else []))

    def start_text(self) -> str:
        """What the key of the computation does, and how long it usually takes."""
        return f"{self.START}, {about_here(self.TYPICAL_S)}"

    # The views

    def compose_views(self) -> ComposeResult:
        """By default one chart, whose points can be opened, and the scale of its shades."""
        with Vertical(id=self.page_of(self.view)):
            yield (chart := ChartView(f"{self.kind}-chart", runs_points=True))
            yield ShadeScale(chart)

    def page_of(self, view: str) -> str:
        """Identifier of the page that displays a view."""
        return QUANTITY_PAGE if view in self.QUANTITIES else view

    @property
    def quantity(self) -> str:
        """The displayed quantity; where a view shows none, the one displayed last."""
        names = (self.view, self.stored_setting(_QUANTITY_SETTING, ""), *self.QUANTITIES)
        return next(name for name in names if name in self.QUANTITIES)

    def show_view(self, name: str) -> None:
        """Show a view by its identifier; charts of another quantity have other limits."""
        if name in self.QUANTITIES:
            if name != self.quantity:
                self.fit_axes()
            self.store_setting(_QUANTITY_SETTING, name)
        super().show_view(name)

    # The result

    @property
    def displayed(self) -> DisplayedStudy[Any] | None:
        """The displayed result."""
        return self.session.studies.get(self.study_key)

    @property
    def study_key(self) -> str:
        """Key of the result in the session; each map of safety has its own."""
        return self.view if self.view in SAFETY_MAPS else self.NAME

    @property
    def edited(self) -> Scene | None:
        """The edited scene; None if a field is invalid."""
        return compute_outcome(self.session.scene).result

    def start_from_inputs(self) -> None:
        """Compute the study of the edited scene."""
        self.start(partial(self.compute, self.request()))
        # Without an input, the chart keeps its quantities, and chosen limits stay valid.
        if self.EXAMPLE:
            self.fit_axes()

    def compute(self, request: Any, job: Job) -> Any:
        """The result of a request; called in a thread, calls `job.report` often.

        By default, a request is a function of the callback that gets the progress.
        """
        return request(progress=job.report)

    def show_result(self, result: Any) -> None:
        """Display a computed result, and log its answer."""
        self.session.studies[self.study_key] = DisplayedStudy(result, self.session.name)
        self.scene_changed()
        self.log_result(study(self.kind).contents_name, self.answer_text(result).split(FACTS))

    def scene_changed(self) -> None:
        """Display the result beside the edited scene; an unedited example follows the scene."""
        if self.EXAMPLE:
            text_input, old_example = self.query_one(".study-input", TextInput), self._example
            self._example = self.example
            if text_input.value == old_example:
                text_input.value = self._example
        if self._error:
            # The input may be valid for the new scene.
            self.check_input()
        self.draw()

    def _find_outdated(self, result: Any) -> str:
        # The values of a result that the edited scene does not have; empty if it has all.
        advice = f"{self.session.key_names['compute']} computes again"
        try:
            scene = self.session.scene()
            # The edited scene with the values on which the result depends, except varied ones.
            inputs, values = self.inputs_of(result), scene.parameters.as_dict()
            varied_values = {name: values[name] for name in inputs.varied if name in values}
            parameters = inputs.parameters.with_values(varied_values)
            computed_scene = replace(scene, parameters=parameters, **inputs.settings)
        except InputError:
            # Invalid fields, or an edited value that the result's parameters do not allow.
            return f"of {OUTDATED_NOTE}: {advice}"
        changes = change_texts(computed_scene, scene)
        if not changes:
            return ""
        rest = f" and {len(changes) - 1} more" if len(changes) > 1 else ""
        return f"of {changes[0]}{rest}: {advice}"

    def inputs_of(self, result: Any) -> ResultInputs:
        """The inputs on which a result depends."""
        raise NotImplementedError

    def draw(self) -> None:
        """Draw the current view."""
        displayed, outdated = self.displayed, ""
        if displayed is None:
            for chart in self.query(ChartView):
                chart.show(None)
            self.answer = ""
            self._show_preview()
        else:
            self.draw_result(displayed.value)
            outdated = self._find_outdated(displayed.value)
            self.answer = self.answer_text(displayed.value)
            if self.job is None:
                source = f"read from {displayed.source}" if displayed.source else ""
                texts = (source, outdated, self.details_text(displayed.value))
                self.show_status("; ".join(filter(None, texts)), self.answer)
        for scale in self.query(ShadeScale):
            scale.redraw()
        self.mark_result(outdated=bool(outdated))

    def draw_result(self, result: Any) -> None:
        """Draw the current view of a result."""
        raise NotImplementedError

    def answer_text(self, result: Any) -> str:
        """What a result says in numbers, as facts joined by `FACTS`."""
        raise NotImplementedError

    def details_text(self, result: Any) -> str:
        """What follows the answer; by default the warning of a result."""
        return study(self.kind).warning(result) or ""

    # Points, exports, command line

    @on(ChartView.PointChosen)
    def _run_point(self, event: ChartView.PointChosen) -> None:
        displayed = self.displayed
        if displayed is not None:
            texts, description = self.read_point(displayed.value, event.point)
            self.post_message(PointRunRequested(texts, f"opened {description}"))

    def read_point(self, result: Any, point: NearestPoint) -> tuple[dict[str, str], str]:
        """The texts of the form's fields for a point of the chart, and a description of it."""
        raise NotImplementedError

    def heading(self, result: Any) -> Heading:
        """The heading of an exported figure: the parameters that do not vary."""
        parameters, varied, settings = self.inputs_of(result)
        return Heading([parameters], varied, ignores_separation=settings.get("separation") is False)

    def required_result(self) -> DisplayedStudy[Any]:
        """The displayed result; raises `InputError` if there is none."""
        if self.displayed is None:
            contents = study(self.kind).contents_name
            raise InputError(f"no {contents} to export yet: press {self.VERB}")
        return self.displayed

    def export(self, kind: str) -> Export:
        """Figure or data of the result; the figure is the displayed charts, if there are any."""
        displayed = self.required_result()
        result, name = displayed.value, displayed.name or self.session.name
        stem = f"{name}-{study(self.kind).stem(result)}"
        charts, heading = self.visible_charts(), self.heading(result)
        return study_export(kind, self.kind, result, stem, charts=charts, heading=heading)

    def command_line(self) -> str:
        """The command that computes the displayed result; without result, the edited scene."""
        if self.displayed is None and self.REQUEST:
            request = self.request()
        else:
            result = self.required_result().value
            request = getattr(result, self.REQUEST) if self.REQUEST else result
        return study_command(self.kind, request, self.session)


class SweepStudyPane(StudyPane):
    """The tab of a kind of study whose results come from the members of a sweep."""

    REQUEST: ClassVar[str] = "study"

    def inputs_of(self, result: Any) -> ResultInputs:
        """The inputs of a sweep."""
        request = result.study
        axes = request.design.axes
        names = ["t_end", "method", "over_time", "accuracy"]
        names += [] if request.accuracy else ["tol"]
        names += ["start"] if axes.keys().isdisjoint(START_SPECS) else []
        settings = {name: getattr(request, name) for name in names}
        if len(request.cases) == 1:
            settings["separation"] = request.cases[0]
        return ResultInputs(request.parameters, (*axes, *dict(request.over_time)), settings)
