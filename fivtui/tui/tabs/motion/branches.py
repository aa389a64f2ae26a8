"""The branches tab: limit cycles along a parameter, stable or not."""

from collections.abc import Mapping
from typing import ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Button, Static

from fivtui.charts import Heading
from fivtui.model import InputError
from fivtui.orbits import CycleBranch, branch_chart, event_name
from fivtui.scene import Scene
from fivtui.tui.chart import ChartView
from fivtui.tui.session import DisplayedStudy, Job, study_line
from fivtui.tui.tabs.charts.branches import (
    EXAMPLE,
    Origin,
    nearest_cycle,
    orbit_scene,
    parse_branch,
)
from fivtui.tui.tabs.charts.sweep import point_texts
from fivtui.tui.tabs.exports.export import Export, as_displayed, scene_study_export
from fivtui.tui.tabs.job_pane import JobPane
from fivtui.tui.tabs.messages import PointOpened

_KIND: Final = "branch"
_VARY: Final = "vary"
_FROM: Final = "from"
_NOTHING: Final = "no branch to export yet: press F10"
_ORIGINS: Final[Mapping[Origin, str]] = {"hopf": "from the Hopf point", "cycle": "from a cycle"}


class BranchesPane(JobPane):
    """Branch of limit cycles of the edited scene along any parameter."""

    NAME: ClassVar[str] = _KIND
    VERB: ClassVar[str] = "Follow"
    HINT: ClassVar[str] = "F10: follow, Enter: run an orbit"
    FORM: ClassVar[str] = "NAME=LOW:HIGH or NAME"
    VIEWS: ClassVar[Mapping[str, str]] = {"branch": "Branch"}

    def compose_bar(self) -> ComposeResult:
        """The parameter with its range, and where the branch begins."""
        yield Static("along", classes="words")
        yield self.study_input("along", _VARY, EXAMPLE)
        yield Button(_ORIGINS[self._origin], id="branch-from", compact=True)

    def compose_views(self) -> ComposeResult:
        """One chart."""
        with Vertical(id="branch"):
            yield ChartView("branch-chart", nothing="no branch yet: press F10", openable=True)

    @property
    def _origin(self) -> Origin:
        return "cycle" if self.setting(_FROM, "") == "cycle" else "hopf"

    @property
    def _displayed(self) -> DisplayedStudy[CycleBranch] | None:
        return self.session.studies.get(_KIND)

    def check_text(self, scene: Scene, text: str) -> None:  # noqa: ARG002
        """Raise `InputError` if the text is not what `FORM` says."""
        parse_branch(text)

    def begin(self) -> None:
        """Follow a branch of the edited scene."""
        name, ends = parse_branch(self.text)
        low, high = (None, None) if ends is None else ends
        scene, origin = self.session.scene(), self._origin

        def compute(job: Job) -> CycleBranch:
            from fivtui.orbits import branch

            return branch(
                scene.parameters,
                name,
                low=low,
                high=high,
                origin=origin,
                separation=scene.separation,
                progress=job.report,
            )

        self.start(compute)
        self.query_one(ChartView).view.reset()

    def take(self, result: CycleBranch) -> None:
        """Display a branch."""
        self.session.studies.put(_KIND, DisplayedStudy(result, self.session.name))
        self.scene_changed()

    def scene_changed(self) -> None:
        """Mark the edited value."""
        displayed = self._displayed
        if displayed is not None and displayed.source:
            self.stop()
        if displayed is not None and self.job is None:
            found = displayed.value
            events = [f"{event_name(event.kind)} {event.value:.4g}" for event in found.events]
            self.say("; ".join(filter(None, [" ".join(events), f"its end: it {found.ends[1]}"])))
        self.draw()

    def draw(self) -> None:
        """Draw the branch."""
        displayed = self._displayed
        if displayed is not None:
            chart = branch_chart(displayed.value, self._now(displayed.value.name))
            self.query_one(ChartView).show(chart)

    def _now(self, name: str) -> float | None:
        try:
            return self.session.parameters().as_dict().get(name)
        except InputError:
            return None

    @on(Button.Pressed, "#branch-from")
    def _turned(self, event: Button.Pressed) -> None:
        event.stop()
        self.keep(_FROM, "hopf" if self._origin == "cycle" else "cycle")
        event.button.label = _ORIGINS[self._origin]
        event.button.refresh(layout=True)

    @on(ChartView.Opened)
    def _opened(self, event: ChartView.Opened) -> None:
        displayed = self._displayed
        if displayed is None:
            return
        result = displayed.value
        point = nearest_cycle(result, event.point.x, event.point.y)
        kind = "stable" if point.stable else "unstable"
        words = f"opened the {kind} limit cycle at {result.name} = {point.value:.6g}, period "
        texts = point_texts(orbit_scene(result, point))
        self.post_message(PointOpened(texts, f"{words}{point.period:.5g} s"))

    def export(self, what: str) -> Export:
        """The branch; its figure as displayed."""
        displayed = self._displayed
        if displayed is None:
            raise InputError(_NOTHING)
        found = displayed.value
        heading = Heading([found.parameters], (found.name,), ignored=not found.separation)
        whole = scene_study_export(what, _KIND, found, displayed.name)
        return as_displayed(whole, self.visible_charts(), heading)

    def command_line(self) -> str:
        """The command for the displayed branch."""
        displayed = self._displayed
        if displayed is None:
            raise InputError(_NOTHING)
        return study_line(_KIND, displayed.value, self.session.origin)
