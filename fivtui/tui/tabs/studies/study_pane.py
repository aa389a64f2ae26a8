"""A pane that computes, shows, exports and opens results of a kind of study."""

from collections.abc import Mapping
from functools import partial
from typing import Any, ClassVar

from textual import on
from textual.app import ComposeResult
from textual.events import DescendantBlur, DescendantFocus
from textual.widgets import Button, Input

from fivtui.charts import Heading, NearestPoint
from fivtui.model import InputError, Parameters
from fivtui.ranges import decimal_points
from fivtui.scene import Scene
from fivtui.studies import study
from fivtui.tui.chart import ChartView, TextInput
from fivtui.tui.session import DisplayedStudy, Job, Session, study_line
from fivtui.tui.tabs.exports.export import Export, as_displayed, scene_study_export
from fivtui.tui.tabs.job_pane import JobBar, JobPane
from fivtui.tui.tabs.messages import PointOpened


class StudyPane(JobPane):
    """A tab of a study, built from its kind in the registry, its input and its choices.

    A result is displayed whether it was computed here, read from a file, or restored.

    Attributes
    ----------
    NAME : str
        Kind of study, also identifier of the tab.
    INPUT, EXAMPLE : str
        Identifier and initial text of the input; there is none without example.
    FORM : str
        What may be typed into it; displayed while it has the focus.
    CHOICE : str
        Stored setting of the buttons of which one is active.
    CHOICES : mapping of str to str
        Identifiers and titles of these buttons.
    """

    INPUT: ClassVar[str] = ""
    EXAMPLE: ClassVar[str] = ""
    FORM: ClassVar[str] = ""
    CHOICE: ClassVar[str] = ""
    CHOICES: ClassVar[Mapping[str, str]] = {}

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._typing = False
        self._error = ""
        self._prepared: DisplayedStudy[Any] | None = None

    # The input

    def compose_input(self) -> ComposeResult:
        """The input of the bar."""
        yield TextInput(
            self.initial_text,
            respell=decimal_points,
            id=self.INPUT,
            classes="study-input",
            compact=True,
            select_on_focus=False,
        )

    @property
    def input_setting(self) -> str:
        """The setting that stores the text of the input."""
        return "vary"

    @property
    def initial_text(self) -> str:
        """The stored text of the input, or else the example."""
        return self.setting(self.input_setting, self.EXAMPLE)

    @property
    def text(self) -> str:
        """The text of the input; empty if there is none."""
        return self.query_one(".study-input", TextInput).value if self.EXAMPLE else ""

    def parse(self, scene: Scene, text: str) -> Any:  # noqa: ARG002
        """The request that the input says of a scene; raises `InputError` if it is wrong."""
        return scene

    def request(self) -> Any:
        """The request that the input says of the edited scene; raises `InputError`."""
        return self.parse(self.session.scene(), self.text)

    @on(Input.Changed, ".study-input")
    def _edited(self, event: Input.Changed) -> None:
        event.stop()
        # Not of the event: it may be that of an earlier setting.
        self.keep(self.input_setting, event.input.value)
        self.check_input()

    def check_input(self) -> None:
        """Display what is wrong in the input."""
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
    def _submitted(self, event: Input.Submitted) -> None:
        event.stop()
        self.submitted()

    def submitted(self) -> None:
        """Start the job unless it is running; called for Enter in the input."""
        if self.job is None:
            self.work()

    @on(DescendantFocus)
    @on(DescendantBlur)
    def _show_form(self) -> None:
        # What may be typed, or the usual words again; the two events may come in any order.
        focused = self.screen.focused
        self._typing = isinstance(focused, Input) and self in focused.ancestors
        self.show_bar()

    def say(self, words: str) -> None:
        """Display words in the bar while no job is running."""
        self._typing = False
        super().say(words)

    def show_bar(self) -> None:
        """Display progress, or what is wrong in the input, or what may be typed, or the words."""
        words = self._error or (self.FORM if self._typing else self.words)
        self.query_one(JobBar).show(self.job, words, wrong=bool(self._error))

    # The choices

    @property
    def chosen(self) -> str:
        """Identifier of the active choice."""
        stored = self.setting(self.CHOICE, "")
        return stored if stored in self.CHOICES else next(iter(self.CHOICES))

    def compose_choices(self) -> ComposeResult:
        """A button for every choice."""
        for name, title in self.CHOICES.items():
            classes = "choice -active" if name == self.chosen else "choice"
            yield Button(title, id=f"{self.CHOICE}-{name}", classes=classes, compact=True)

    def mark_choice(self, name: str) -> None:
        """Mark a choice as the active one."""
        for button in self.query(".choice"):
            button.set_class(button.id == f"{self.CHOICE}-{name}", "-active")

    @on(Button.Pressed, ".choice")
    def _chosen(self, event: Button.Pressed) -> None:
        event.stop()
        self.choose(str(event.button.id).removeprefix(f"{self.CHOICE}-"))

    def choose(self, name: str) -> None:
        """Make a choice the active one."""
        self.keep(self.CHOICE, name)
        self.mark_choice(name)
        self.draw()

    # The result

    @property
    def displayed(self) -> DisplayedStudy[Any] | None:
        """The displayed result."""
        return self.session.studies.get(self.NAME)

    @property
    def parameters(self) -> Parameters | None:
        """The edited parameters; None if one is invalid."""
        try:
            return self.session.parameters()
        except InputError:
            return None

    def begin(self) -> None:
        """Compute the study of the edited scene."""
        self.start(partial(self.compute, self.request()))
        if self.EXAMPLE:
            self.fit_axes()

    def compute(self, request: Any, job: Job) -> Any:
        """The result of a request; called in a thread, calls `job.report` often."""
        raise NotImplementedError

    def fit_axes(self) -> None:
        """Drop the limits of the axes: they were chosen for another result."""
        for chart in self.query(ChartView):
            chart.view.reset()

    def reset_charts(self) -> None:
        """Display all of every chart: a result of another kind was read."""
        self.fit_axes()
        for chart in self.query(ChartView):
            chart.view.hidden.clear()

    def take(self, result: Any) -> None:
        """Display a computed result."""
        self.session.studies[self.NAME] = DisplayedStudy(result, self.session.name)
        self.scene_changed()

    def scene_changed(self) -> None:
        """Display the result beside the edited scene."""
        if self._error:
            # It may have been wrong for the previous scene alone.
            self.check_input()
        self.draw()
        displayed = self.displayed
        if displayed is not None and self.job is None:
            self.say(self.result_status(displayed))

    def draw(self) -> None:
        """Draw the current view."""
        displayed = self.displayed
        if displayed is None:
            for chart in self.query(ChartView):
                chart.show(None)
            return
        if displayed is not self._prepared:
            self._prepared = displayed
            if displayed.source:
                self.stop()
        self.draw_result(displayed.value)

    def draw_result(self, result: Any) -> None:
        """Draw the current view of a result."""
        raise NotImplementedError

    def result_status(self, displayed: DisplayedStudy[Any]) -> str:
        """What the bar says of a result."""
        raise NotImplementedError

    # Points, exports, command line

    @on(ChartView.Opened)
    def _opened(self, event: ChartView.Opened) -> None:
        displayed = self.displayed
        if displayed is not None:
            texts, words = self.point_of(displayed.value, event.point)
            self.post_message(PointOpened(texts, f"opened {words}"))

    def point_of(self, result: Any, point: NearestPoint) -> tuple[dict[str, str], str]:
        """Field texts of a point of the chart, and the point in words."""
        raise NotImplementedError

    def heading(self, result: Any) -> Heading:
        """The heading of an exported figure."""
        raise NotImplementedError

    def required(self) -> DisplayedStudy[Any]:
        """The displayed result; raises `InputError` if there is none."""
        if self.displayed is None:
            raise InputError(f"no {study(self.NAME).data} to export yet: press F10")
        return self.displayed

    def export(self, what: str) -> Export:
        """The result; its figure as displayed, from a table the whole figure."""
        displayed = self.required()
        name = displayed.name or self.session.name
        whole = scene_study_export(what, self.NAME, displayed.value, name)
        return as_displayed(whole, self.visible_charts(), self.heading(displayed.value))

    def command_line(self) -> str:
        """The command for the displayed result, or else for the edited scene."""
        displayed = self.displayed
        of = self.command_request() if displayed is None else self.request_of(displayed.value)
        return study_line(self.NAME, of, self.session.origin)

    def command_request(self) -> Any:
        """What the registry makes the command from where there is no result."""
        return self.request()

    def request_of(self, result: Any) -> Any:
        """What the registry makes the command of a result from."""
        return result
