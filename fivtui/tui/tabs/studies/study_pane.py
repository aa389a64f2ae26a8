"""A pane that computes, displays and exports the results of one kind of study."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple

from textual import on
from textual.app import ComposeResult
from textual.events import DescendantBlur, DescendantFocus
from textual.widgets import Input

from fivtui.charts import Heading, NearestPoint
from fivtui.model import InputError, Parameters
from fivtui.ranges import with_decimal_points
from fivtui.scene import Scene
from fivtui.studies import study
from fivtui.transient import START_SPECS
from fivtui.tui.chart import ChartView, TextInput
from fivtui.tui.session import (
    DisplayedStudy,
    Job,
    Session,
    change_texts,
    duration_text,
    study_command,
)
from fivtui.tui.tabs.exports.export import Export, scene_study_export
from fivtui.tui.tabs.job_pane import FACTS, JobPane
from fivtui.tui.tabs.messages import PointRunRequested, Reported
from fivtui.tui.tabs.preview import Preview, Sketch, about_here

if TYPE_CHECKING:
    from fivtui.sweeps import Study

# Key of the quantity displayed last.
_QUANTITY_SETTING: Final = "quantity"
# Class of a pane whose result is not that of the edited scene, and the note after its titles.
_OUTDATED: Final = "-outdated"
_OUTDATED_NOTE: Final = "another scene"


class ResultInputs(NamedTuple):
    """What a result depends on: parameters, except the varied ones, and settings of its scene."""

    parameters: Parameters
    varied: Sequence[str]
    settings: Mapping[str, Any]


class StudyPane(JobPane):
    """The tab of a kind of study; a subclass defines input, views, computation and charts.

    From the edited scene and the text of the input, `parse` makes a request, from which `compute`
    makes the result. A displayed result may also come from a file or from the saved session.

    Attributes
    ----------
    NAME : str
        Identifier of the tab.
    KIND : str
        Kind of study in the registry, if it has another name.
    INPUT, EXAMPLE : str
        Identifier and initial text of the input; without `EXAMPLE` there is no input.
    INPUT_FORMAT : str
        Format of the input, displayed while it has the focus.
    QUANTITIES : mapping of str to str
        Identifiers and titles of the views that share a page and display a quantity each.
    PAGE : str
        Identifier of this page.
    SKETCH, QUESTION : Sketch or None, str
        Shape of a typical result, and the question it answers; displayed before the first result.
    START, TYPICAL_S : str, float
        What starting the study does, as a verb with objects, and its usual duration, s, as
        measured where `relative_duration` is 1.
    NOTES : sequence of str
        Further sentences before the first result.
    ANSWER : sequence of str
        Labels of the rows of a result that answer the question.
    """

    STATUS_BELOW: ClassVar[bool] = True
    KIND: ClassVar[str] = ""
    INPUT: ClassVar[str] = ""
    EXAMPLE: ClassVar[str] = ""
    INPUT_FORMAT: ClassVar[str] = ""
    QUANTITIES: ClassVar[Mapping[str, str]] = {}
    PAGE: ClassVar[str] = ""
    SKETCH: ClassVar[Sketch | None] = None
    QUESTION: ClassVar[str] = ""
    START: ClassVar[str] = ""
    TYPICAL_S: ClassVar[float] = 0.0
    NOTES: ClassVar[Sequence[str]] = ()
    ANSWER: ClassVar[Sequence[str]] = ()

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        # Whether the input has the focus, so that the bar shows its format.
        self._is_typing = False
        # Error message of the input.
        self._error = ""
        self.kind = self.KIND or self.NAME
        self._drawn_result: DisplayedStudy[Any] | None = None

    def compose_preview(self) -> ComposeResult:
        """The preview of the first result."""
        if self.SKETCH is not None:
            yield Preview(self.SKETCH, self.QUESTION)

    # The input

    def compose_bar(self) -> ComposeResult:
        """The input, if there is one."""
        if self.EXAMPLE:
            yield TextInput(
                self.initial_text,
                replace_commas=with_decimal_points,
                id=self.INPUT,
                classes="study-input",
                compact=True,
                select_on_focus=False,
            )

    @property
    def input_setting(self) -> str:
        """Key of the setting that stores the text of the input."""
        return "vary"

    @property
    def initial_text(self) -> str:
        """The stored text of the input, or else the example."""
        return self.stored_setting(self.input_setting, self.EXAMPLE)

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
        try:
            scene = self.session.scene()
        except InputError:
            scene = self.session.loaded
        self._error = ""
        try:
            self.parse(scene, self.text)
        except InputError as error:
            self._error = str(error)
        self.query_one(".study-input").set_class(bool(self._error), "-invalid")
        self.show_bar()

    @on(Input.Submitted, ".study-input")
    def _submit(self, event: Input.Submitted) -> None:
        event.stop()
        self.submit_input()

    def submit_input(self) -> None:
        """Start the job unless it is running; called for Enter in the input."""
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

    def _show_preview(self) -> None:
        is_empty = self.SKETCH is not None and self.displayed is None
        self.set_class(is_empty, "-empty")
        if is_empty:
            keys = self.session.key_names
            edit = [(keys["go-bar"], "goes to the input above.")] if self.EXAMPLE else []
            notes = [("", note) for note in self.NOTES]
            action = self.start_text() if self.job is None else "stops the computation"
            start = keys["compute"], f"{action}."
            self.query_one(Preview).show(start, *edit, *notes)

    def start_text(self) -> str:
        """What the key of the computation does, and how long it usually takes."""
        return f"{self.START}, {about_here(self.TYPICAL_S)}"

    # The views

    @property
    def title_note(self) -> str:
        """A note on a result of another scene; else empty."""
        return _OUTDATED_NOTE if self.has_class(_OUTDATED) else ""

    def page_of(self, view: str) -> str:
        """Identifier of the page that displays a view."""
        return self.PAGE if view in self.QUANTITIES else view

    @property
    def quantity(self) -> str:
        """The displayed quantity; where a view shows none, the one displayed last."""
        return self.view if self.view in self.QUANTITIES else self.default_view

    @property
    def default_view(self) -> str:
        """The view of the quantity that was displayed last."""
        stored = self.stored_setting(_QUANTITY_SETTING, "")
        return stored if stored in self.QUANTITIES else super().default_view

    def show_view(self, name: str) -> None:
        """Show a view by its identifier."""
        if name in self.QUANTITIES:
            self.store_setting(_QUANTITY_SETTING, name)
        super().show_view(name)

    # The result

    @property
    def displayed(self) -> DisplayedStudy[Any] | None:
        """The displayed result."""
        return self.session.studies.get(self.study_key)

    @property
    def study_key(self) -> str:
        """Key of the result in the session."""
        return self.NAME

    @property
    def parameters(self) -> Parameters | None:
        """The edited parameters; None if one is invalid."""
        try:
            return self.session.parameters()
        except InputError:
            return None

    def start_from_inputs(self) -> None:
        """Compute the study of the edited scene."""
        self.start(partial(self.compute, self.request()))
        # Without an input, the chart keeps its quantities, and chosen limits stay valid.
        if self.EXAMPLE:
            self.fit_axes()

    def compute(self, request: Any, job: Job) -> Any:
        """The result of a request; called in a thread, calls `job.report` often."""
        raise NotImplementedError

    def fit_axes(self) -> None:
        """Fit the axes to the new result: the limits were chosen for an earlier one."""
        for chart in self.query(ChartView):
            chart.view.reset()

    def reset_charts(self) -> None:
        """Fit the axes and show all traces, after a result was read."""
        self.fit_axes()
        for chart in self.query(ChartView):
            chart.view.hidden.clear()

    def show_result(self, result: Any) -> None:
        """Display a computed result, and log its answer."""
        self.session.studies[self.study_key] = DisplayedStudy(result, self.session.name)
        self.scene_changed()
        report = f"{study(self.kind).contents_name} done in {duration_text(self.duration)}"
        facts = filter(None, self.answer_text(result).split(FACTS))
        self.post_message(Reported("; ".join([report, *facts]), routine=True))

    def scene_changed(self) -> None:
        """Display the result beside the edited scene."""
        if self._error:
            # The input may be valid for the new scene.
            self.check_input()
        self.draw()

    def _show_result_status(self, displayed: DisplayedStudy[Any], outdated: str) -> None:
        self.answer = self.answer_text(displayed.value)
        if self.job is None:
            source = f"read from {displayed.source}" if displayed.source else ""
            texts = (source, outdated, self.details_text(displayed.value))
            self.show_status("; ".join(filter(None, texts)), self.answer)

    def _find_outdated(self, result: Any) -> str:
        # The values of a result that the edited scene does not have; empty if it has all.
        advice = f"{self.session.key_names['compute']} computes again"
        try:
            scene = self.session.scene()
            computed_scene = self.computed_scene(result, scene)
        except InputError:
            # Invalid fields, or an edited value that the result's parameters do not allow.
            return f"of {_OUTDATED_NOTE}: {advice}"
        changes = change_texts(computed_scene, scene)
        if not changes:
            return ""
        rest = f" and {len(changes) - 1} more" if len(changes) > 1 else ""
        return f"of {changes[0]}{rest}: {advice}"

    def computed_scene(self, result: Any, edited: Scene) -> Scene:
        """The edited scene with the values on which a result depends, except varied ones."""
        inputs, values = self.inputs_of(result), edited.parameters.as_dict()
        varied_values = {name: values[name] for name in inputs.varied if name in values}
        parameters = inputs.parameters.with_values(varied_values)
        return replace(edited, parameters=parameters, **inputs.settings)

    def inputs_of(self, result: Any) -> ResultInputs:
        """The inputs on which a result depends."""
        raise NotImplementedError

    def draw(self) -> None:
        """Draw the current view."""
        displayed = self.displayed
        if displayed is None:
            for chart in self.query(ChartView):
                chart.show(None)
            self.answer = ""
            self._mark_outdated("")
            self._show_preview()
            return
        if displayed is not self._drawn_result:
            self._drawn_result = displayed
            if displayed.source:
                # A result read from a file replaces the one being computed.
                self.stop()
        self.draw_result(displayed.value)
        outdated = self._find_outdated(displayed.value)
        self._mark_outdated(outdated)
        self._show_result_status(displayed, outdated)

    def _mark_outdated(self, text: str) -> None:
        is_outdated = bool(text)
        if is_outdated is not self.has_class(_OUTDATED):
            self.set_class(is_outdated, _OUTDATED)
            self.show_titles()

    def draw_result(self, result: Any) -> None:
        """Draw the current view of a result."""
        raise NotImplementedError

    def answer_text(self, result: Any) -> str:
        """What a result says in numbers, as facts joined by `FACTS`.

        By default, the rows of its table that are named in `ANSWER`.
        """
        rows = study(self.kind).rows(result) if self.ANSWER else []
        return FACTS.join(f"{row.label} {row.value}" for row in rows if row.label in self.ANSWER)

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
        inputs = self.inputs_of(result)
        ignores_separation = inputs.settings.get("separation") is False
        return Heading([inputs.parameters], inputs.varied, ignores_separation)

    def required_result(self) -> DisplayedStudy[Any]:
        """The displayed result; raises `InputError` if there is none."""
        if self.displayed is None:
            contents = study(self.kind).contents_name
            raise InputError(f"no {contents} to export yet: press {self.VERB}")
        return self.displayed

    def export(self, kind: str) -> Export:
        """Figure or data of the result; the figure is the displayed charts, if there are any."""
        displayed = self.required_result()
        return scene_study_export(
            kind,
            self.kind,
            displayed.value,
            displayed.name or self.session.name,
            charts=self.visible_charts(),
            heading=self.heading(displayed.value),
        )

    def command_line(self) -> str:
        """The command that computes the displayed result; without result, the edited scene."""
        displayed = self.displayed
        request = self.command_request() if displayed is None else self.request_for(displayed.value)
        return study_command(self.kind, request, self.session.origin)

    def command_request(self) -> Any:
        """The request that the command line computes if there is no result."""
        return self.request()

    def request_for(self, result: Any) -> Any:
        """The request whose computation gives a result, for the command line."""
        return result


def sweep_inputs(study: "Study") -> ResultInputs:
    """The inputs of a sweep."""
    axes = study.design.axes
    names = ["t_end", "method", "over_time", "accuracy"]
    if not study.accuracy:
        names.append("tol")
    if axes.keys().isdisjoint(START_SPECS):
        names.append("start")
    settings = {name: getattr(study, name) for name in names}
    if len(study.cases) == 1:
        settings["separation"] = study.cases[0]
    return ResultInputs(study.parameters, (*axes, *dict(study.over_time)), settings)
