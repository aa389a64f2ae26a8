"""The sweep tab: amplitudes over one or two parameters, with and without separation.

A member is one run of a sweep. A chart over two parameters has a backdrop, values as shades.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np
from textual.app import ComposeResult
from textual.containers import Vertical

from fivtui.charts import NearestPoint
from fivtui.model import InputError
from fivtui.scene import Scene
from fivtui.tui.chart import ChartView, ShadeScale
from fivtui.tui.session import DisplayedStudy, Job, Session, scene_texts, symbol_of
from fivtui.tui.tabs.exports.export import Export
from fivtui.tui.tabs.job_pane import FACTS
from fivtui.tui.tabs.messages import Reported
from fivtui.tui.tabs.preview import Sketch, about, about_here
from fivtui.tui.tabs.requests.sweep import (
    EXAMPLE,
    MAX_UNCONFIRMED,
    count_text,
    failure_text,
    partial_sweep,
    point_scene,
    point_separation,
    sweep_parts,
    sweep_request,
)

from .study_pane import ResultInputs, StudyPane, sweep_inputs

if TYPE_CHECKING:
    from fivtui.sweeps import Rows, Study, Sweep

# Duration of a run by the native solver where `relative_duration` is 1, s.
_TYPICAL_RUN_S: Final = 1e-3
_INCOMPLETE: Final = "the sweep is incomplete and cannot be exported: Sweep computes it again"


class SweepPane(StudyPane):
    """Peak and half peak-to-peak of y over one or two parameters of the edited scene."""

    NAME: ClassVar[str] = "sweep"
    VERB: ClassVar[str] = "Sweep"
    INPUT: ClassVar[str] = "vary"
    EXAMPLE: ClassVar[str] = EXAMPLE
    INPUT_FORMAT: ClassVar[str] = "NAME=START:STOP:COUNT or NAME=A,B,C, or peak-over-belt-speed"
    VIEWS: ClassVar[Mapping[str, str]] = {"amplitudes": "Amplitudes"}
    SKETCH: ClassVar[Sketch | None] = Sketch(
        x="F",
        y="peak |y|",
        curves=(
            ([0.0, 0.2, 0.4, 0.6, 0.8, 1.0], [0.01, 0.03, 0.13, 0.34, 0.61, 0.97]),
            ([0.0, 0.07, 0.1, 1.0], [0.01, 0.02, 0.09, 0.09]),
        ),
        labels={"separation considered": (0.22, 0.75), "ignored": (0.75, 0.2)},
    )
    QUESTION: ClassVar[str] = "How large does the motion become over one or two parameters?"

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        # A large sweep that starts only if it is requested again.
        self._unconfirmed_study: Study | None = None

    def compose_views(self) -> ComposeResult:
        """One chart."""
        with Vertical(id="amplitudes"):
            yield (chart := ChartView("sweep-chart", runs_points=True))
            yield ShadeScale(chart)

    def parse(self, scene: Scene, text: str) -> "Study":
        """The sweep of a scene over the ranges of the input."""
        return sweep_request(scene, text)

    def start_text(self) -> str:
        """The number of runs, and their duration from that of a run of the edited scene."""
        try:
            study: Study = self.request()
        except InputError:
            return "runs the scene with each value"
        run_s = self.session.live.expected_duration(self.session.scene())
        duration = about_here(study.members * _TYPICAL_RUN_S)
        if run_s is not None:
            duration = about(study.members * run_s)
        return f"computes {study.members} runs, {duration}"

    def start_from_inputs(self) -> None:
        """Sweep the edited scene; a large sweep starts at a second request."""
        study: Study = self.request()
        unconfirmed, self._unconfirmed_study = self._unconfirmed_study, study
        if study.members > MAX_UNCONFIRMED and study != unconfirmed:
            text = f"{study.members} runs: press Sweep again to compute them"
            self.show_status(text)
            self.post_message(Reported(text))
            return
        self._unconfirmed_study = None
        self.session.studies.pop(self.NAME, None)
        super().start_from_inputs()

    def compute(self, request: "Study", job: Job) -> "Sweep":
        """Compute a sweep in parts, and display each part."""
        parts: list[Rows] = []
        for rows in sweep_parts(request, job.report):
            parts.append(rows)
            self.call_later(self._show_part, job, partial_sweep(request, parts))
        return partial_sweep(request, parts)

    def _show_part(self, job: Job, result: "Sweep") -> None:
        if job is self.job:
            self.session.studies[self.NAME] = DisplayedStudy(result, self.session.name)

    def show_progress(self) -> None:
        """Display the members computed so far."""
        self.draw()

    def answer_text(self, result: "Sweep") -> str:
        """The range of the peak of y, and the number of members."""
        peaks = result.table.numbers.get("y_abs", np.array([]))
        peaks = peaks[np.isfinite(peaks)]
        extent = f"peak |y| {peaks.min():.4g} to {peaks.max():.4g} m" if peaks.size else ""
        return FACTS.join(filter(None, (extent, count_text(result))))

    def details_text(self, result: "Sweep") -> str:
        """The failures of members."""
        return failure_text(result)

    def inputs_of(self, result: "Sweep") -> ResultInputs:
        """The inputs of a sweep."""
        return sweep_inputs(result.study)

    def draw_result(self, result: "Sweep") -> None:
        """Draw the computed members, with the edited values of the swept parameters."""
        from fivtui.sweeps import grid_chart, sweep_chart

        names = list(result.study.design.axes)
        values = {} if self.parameters is None else self.parameters.as_dict()
        edited = tuple(values[name] for name in names if name in values)
        if len(names) == 1:
            chart = sweep_chart(result, edited[0] if edited else None)
        else:
            point = (edited[0], edited[1]) if len(edited) > 1 else None
            chart = grid_chart(result, self.session.separation, point)
        self.query_one(ChartView).show(chart)
        self.query_one(ShadeScale).redraw()

    def read_point(self, result: "Sweep", point: NearestPoint) -> tuple[dict[str, str], str]:
        """Field texts of a member."""
        separation = point_separation(result.study, point, self.session.separation)
        texts = scene_texts(point_scene(result.study, point, separation))
        values = zip(result.study.design.axes, (point.x, point.y), strict=False)
        description = ", ".join(f"{symbol_of(name)} = {value:g}" for name, value in values)
        return texts, f"{description}, separation {texts['separation']}"

    def export(self, kind: str) -> Export:
        """The sweep if it is complete; its figure as displayed."""
        displayed = self.displayed
        if displayed is not None:
            result: Sweep = displayed.value
            if result.table.members < result.study.members:
                raise InputError(_INCOMPLETE)
        return super().export(kind)

    def request_for(self, result: "Sweep") -> "Study":
        """The study of a sweep."""
        return result.study
