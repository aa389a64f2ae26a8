"""The tab of sweeps: amplitudes over a parameter, for both cases."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from textual import on
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.message import Message
from textual.widgets import Input, Static

from fivtui.core.errors import InputError

from .chart_view import ChartView
from .job_pane import JobPane
from .jobs import Job
from .messages import PointOpened
from .session import Session
from .sweep_view import (
    EXAMPLE,
    SweepPoints,
    count_words,
    point_texts,
    points_of,
    sweep_chart,
    sweep_parts,
    sweep_request,
)

if TYPE_CHECKING:
    from fivtui.core.sweep import Rows


class SweepPane(JobPane):
    """Peak and steady half range over a parameter of the scene edited."""

    VERB: ClassVar[str] = "Sweep"
    HINT: ClassVar[str] = "F10 sweeps; Enter on a point opens its transient"
    VIEWS: ClassVar[Mapping[str, str]] = {"amplitudes": "Amplitudes"}

    @dataclass
    class Grown(Message):
        """More points are known."""

        job: Job
        points: SweepPoints

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._points: SweepPoints | None = None

    def compose_bar(self) -> ComposeResult:
        """What varies."""
        yield Static("vary", classes="words")
        yield Input(EXAMPLE, id="vary", compact=True, select_on_focus=False)

    def compose_views(self) -> ComposeResult:
        """One chart."""
        with Vertical(id="amplitudes"):
            yield ChartView("sweep-chart", nothing="nothing swept yet", openable=True)

    def begin(self) -> None:
        """Sweep the scene edited."""
        text = self.query_one("#vary", Input).value
        study = sweep_request(self.session.scene(), text)
        (name,) = study.design.axes

        def compute(job: Job) -> SweepPoints:
            parts: list[Rows] = []
            for rows in sweep_parts(study, job.report):
                parts.append(rows)
                self.post_message(self.Grown(job, points_of(name, parts)))
            return points_of(name, parts)

        self._points = None
        self.start(compute)
        self.query_one(ChartView).view.reset()

    @on(Input.Submitted, "#vary")
    def _submitted(self, event: Input.Submitted) -> None:
        event.stop()
        if self.job is None:
            self.work()

    @on(Grown)
    def _grown(self, event: Grown) -> None:
        event.stop()
        if event.job is self.job:
            self._points = event.points

    def progressed(self) -> None:
        """Show the points that are known."""
        self.draw()

    def take(self, result: SweepPoints) -> None:
        """Show all points."""
        self._points = result
        self.say(count_words(result))
        self.draw()

    def scene_changed(self) -> None:
        """Mark the value edited."""
        self.draw()

    def draw(self) -> None:
        """Draw what is known."""
        if self._points is None:
            return
        try:
            now = float(getattr(self.session.parameters(), self._points.name))
        except InputError:
            now = None
        self.query_one(ChartView).show(sweep_chart(self._points, now))

    @on(ChartView.Opened)
    def _opened(self, event: ChartView.Opened) -> None:
        if self._points is not None:
            texts = point_texts(self._points, event.point)
            words = ", ".join(f"{name} = {text}" for name, text in texts.items())
            self.post_message(PointOpened(texts, f"opened {words}"))
