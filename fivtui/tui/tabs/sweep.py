"""The sweep tab: amplitudes over one or two parameters, with and without separation."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.message import Message
from textual.widgets import Static

from fivtui.charts import Heading
from fivtui.model import InputError
from fivtui.scene import Scene
from fivtui.tui.chart import ChartView
from fivtui.tui.session import DisplayedStudy, Job, Session, study_line, symbol_of

from .charts.map_shades import scale_words
from .charts.sweep import (
    ASKED_FROM,
    EXAMPLE,
    SweepPoints,
    case_of,
    count_words,
    grid_chart,
    point_scene,
    point_texts,
    points_of,
    sweep_chart,
    sweep_of,
    sweep_parts,
    sweep_request,
)
from .exports.export import Export, as_displayed, scene_study_export
from .job_pane import JobPane
from .messages import PointOpened, Reported

if TYPE_CHECKING:
    from fivtui.sweeps import Rows, Study, Sweep

_NOTHING: Final = "no sweep to export yet: press F10"
_PARTIAL: Final = "the sweep is incomplete and cannot be exported: F10 computes it again"


class SweepPane(JobPane):
    """Peak and half peak-to-peak over parameters of the edited scene."""

    NAME: ClassVar[str] = "sweep"
    VERB: ClassVar[str] = "Sweep"
    HINT: ClassVar[str] = "F10: compute, Enter: run a point"
    FORM: ClassVar[str] = "NAME=START:STOP:COUNT or NAME=A,B,C, or peak-over-belt-speed"
    VIEWS: ClassVar[Mapping[str, str]] = {"amplitudes": "Amplitudes"}

    @dataclass
    class Grown(Message):
        """Posted when more members are known."""

        job: Job
        result: "Sweep"

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        # The large sweep that F10 computes when pressed again.
        self._asked: Study | None = None
        self._drawn: DisplayedStudy[Sweep] | None = None
        self._points: SweepPoints | None = None
        self._counted = ""

    def compose_bar(self) -> ComposeResult:
        """The swept ranges."""
        yield Static("vary", classes="words")
        yield self.study_input("vary", "vary", EXAMPLE)

    def compose_views(self) -> ComposeResult:
        """One chart."""
        with Vertical(id="amplitudes"):
            yield ChartView("sweep-chart", nothing="no sweep yet: press F10", openable=True)

    def check_text(self, scene: Scene, text: str) -> None:
        """Raise `InputError` if the text is not what `FORM` says."""
        sweep_request(scene, text)

    def begin(self) -> None:
        """Sweep the edited scene."""
        study = sweep_request(self.session.scene(), self.text)
        asked, self._asked = self._asked, study
        if study.members > ASKED_FROM and study != asked:
            words = f"{study.members} runs: F10 again computes them"
            self.say(words)
            self.post_message(Reported(words))
            return
        self._asked = None

        def compute(job: Job) -> "Sweep":
            parts: list[Rows] = []
            for rows in sweep_parts(study, job.report):
                parts.append(rows)
                self.post_message(self.Grown(job, sweep_of(study, parts)))
            return sweep_of(study, parts)

        self._show(None)
        self.start(compute)
        self.query_one(ChartView).view.reset()

    def _show(self, result: "Sweep | None") -> None:
        name = self.session.name
        self.session.studies.put("sweep", None if result is None else DisplayedStudy(result, name))
        self._catch_up()

    def _catch_up(self) -> None:
        # The session's sweep was computed here, read from a file, or restored.
        displayed = self.session.studies.get("sweep")
        if displayed is not self._drawn:
            if displayed is not None and displayed.source:
                self.stop()
            self._drawn = displayed
            single = displayed is not None and len(displayed.value.study.design.axes) == 1
            self._points = points_of(displayed.value) if displayed is not None and single else None
            if displayed is not None:
                source = f", read from {displayed.source}" if displayed.source else ""
                self._counted = f"{count_words(displayed.value)}{source}"
            if displayed is not None and self.job is None:
                self.say(self._counted)

    @on(Grown)
    def _grown(self, event: Grown) -> None:
        event.stop()
        if event.job is self.job:
            self._show(event.result)

    def progressed(self) -> None:
        """Display the members known so far."""
        self.draw()

    def take(self, result: "Sweep") -> None:
        """Display all members."""
        self._show(result)
        self.draw()

    def scene_changed(self) -> None:
        """Mark the edited value; display a sweep read from a file."""
        super().scene_changed()
        self._catch_up()
        self.draw()

    def draw(self) -> None:
        """Draw the known members."""
        view, displayed = self.query_one(ChartView), self._drawn
        if displayed is None:
            view.show(None)
            return
        now = self._now(list(displayed.value.study.design.axes))
        if self._points is not None:
            view.show(sweep_chart(self._points, None if now is None else now[0]))
        else:
            point = None if now is None else (now[0], now[1])
            chart = grid_chart(displayed.value, self.session.separation, point)
            view.show(chart)
            if self.job is None and chart.backdrop is not None:
                scale = scale_words(chart.backdrop.shades, chart.backdrop.scale)
                self.say(f"{self._counted}: {scale}")

    def _now(self, names: Sequence[str]) -> tuple[float, ...] | None:
        # The edited values of the swept parameters.
        try:
            p = self.session.parameters()
        except InputError:
            return None
        values = p.as_dict()
        if not all(name in values for name in names):
            return None
        return tuple(values[name] for name in names)

    @on(ChartView.Opened)
    def _opened(self, event: ChartView.Opened) -> None:
        if self._drawn is None:
            return
        study, point = self._drawn.value.study, event.point
        case = case_of(study, self._points, point, self.session.separation)
        scene = point_scene(study, point, case)
        texts = point_texts(scene)
        values = zip(study.design.axes, (point.x, point.y), strict=False)
        words = ", ".join(f"{symbol_of(name)} = {value:g}" for name, value in values)
        words = f"opened {words}, separation {texts['separation']}"
        self.post_message(PointOpened(texts, words))

    def export(self, what: str) -> Export:
        """The sweep if it is complete; its figure as displayed."""
        displayed = self.session.studies.get("sweep")
        if displayed is None:
            raise InputError(_NOTHING)
        if len(displayed.value.table.reasons) < displayed.value.study.members:
            raise InputError(_PARTIAL)
        study = displayed.value.study
        heading = Heading([study.parameters], tuple(study.design.axes))
        whole = scene_study_export(what, "sweep", displayed.value, displayed.name)
        return as_displayed(whole, self.visible_charts(), heading)

    def command_line(self) -> str:
        """The command for the displayed sweep, or else the one to compute."""
        displayed = self.session.studies.get("sweep")
        if displayed is None:
            study = sweep_request(self.session.scene(), self.text)
        else:
            study = displayed.value.study
        return study_line("sweep", study, self.session.origin)
