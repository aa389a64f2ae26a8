"""The sweep tab: amplitudes over one or two parameters, with and without separation.

A member is one run of a sweep. A chart over two parameters has a backdrop, values as shades.
Case 1 considers separation, Case 2 ignores it.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import ClassVar, Final

import numpy as np

from fivtui.charts import NearestPoint
from fivtui.model import InputError, OnProgress, Progress, System
from fivtui.scene import Scene
from fivtui.sweeps import (
    SWEEP_PRESETS,
    Study,
    Sweep,
    check_memory_limit,
    compute_rows,
    concatenate,
    grid_chart,
    parse_design,
    scene_study,
    sweep_chart,
    sweep_curves,
)
from fivtui.transient import START_SPECS, resolve_start
from fivtui.tui.chart import ChartView
from fivtui.tui.session import (
    DisplayedStudy,
    Job,
    base_scene,
    check_drawable,
    replace_symbols,
    scene_texts,
    symbol_of,
)
from fivtui.tui.tabs.export import Export
from fivtui.tui.tabs.job_pane import FACTS
from fivtui.tui.tabs.preview import Sketch, about, about_here

from .study_pane import SweepStudyPane

# The chart displays a sweep in parts: minimum number of members of a part, and number of parts.
_MIN_PART_SIZE: Final = 16
_MAX_PARTS: Final = 500
# The plotted outputs: peak and half range of y.
_OUTPUTS: Final = ("y_abs", "y_half_range")
# Duration of a run by the native solver where `relative_duration` is 1, s.
_TYPICAL_RUN_S: Final = 1e-3


def partial_sweeps(study: Study, progress: OnProgress) -> Iterator[Sweep]:
    """Compute a sweep in parts, each with the rows so far; raises `Cancelled` if stopped."""
    members, monitor, parts = study.members, Progress(progress), []
    part_size = max(_MIN_PART_SIZE, members // _MAX_PARTS)
    for first in range(0, members, part_size):
        stop = min(first + part_size, members)
        part = monitor.stage(first / members, stop / members)
        parts.append(compute_rows(study, first, stop, part.callback))
        yield Sweep(study, concatenate(parts))


def point_scene(study: Study, point: NearestPoint, edited_separation: bool) -> Scene:
    """The scene at a point of a sweep's chart.

    A chart over one parameter shows both cases; one over two parameters shows that of the edited
    scene, `edited_separation`, if the sweep has it.
    """
    axes = study.design.axes
    if len(axes) == 1:
        _, separation = sweep_curves(study)[point.trace]
    else:
        separation = edited_separation if edited_separation in study.cases else study.cases[0]
    # Over one parameter, y is an output, which `zip` omits.
    values = dict(zip(axes, (point.x, point.y), strict=False))
    # A sweep may vary components of the start state.
    start_values = {name: values.pop(name) for name in START_SPECS if name in values}
    parameters, start = study.parameters.with_values(values), study.start
    if start_values:
        start_state = resolve_start(System(parameters, separation), start)
        start = tuple((dict(zip(START_SPECS, start_state, strict=True)) | start_values).values())
    return replace(
        base_scene(),
        parameters=parameters,
        separation=separation,
        start=start,
        t_end=study.t_end,
        tol=study.tol,
    )


class SweepPane(SweepStudyPane):
    """Peak and half peak-to-peak of y over one or two parameters of the edited scene."""

    NAME: ClassVar[str] = "sweep"
    VERB: ClassVar[str] = "Sweep"
    EXAMPLE: ClassVar[str] = "F=10:120:56"
    INPUT_FORMAT: ClassVar[str] = "NAME=START:STOP:COUNT or NAME=A,B,C, or peak-over-belt-speed"
    VIEWS: ClassVar[Mapping[str, str]] = {"amplitudes": "Amplitudes"}
    SKETCH: ClassVar[Sketch | None] = Sketch(
        question="How large does the motion become over one or two parameters?",
        x="F",
        y="peak |y|",
        curves=(
            ([0.0, 0.2, 0.4, 0.6, 0.8, 1.0], [0.01, 0.03, 0.13, 0.34, 0.61, 0.97]),
            ([0.0, 0.07, 0.1, 1.0], [0.01, 0.02, 0.09, 0.09]),
        ),
        labels={"separation considered": (0.22, 0.75), "ignored": (0.75, 0.2)},
    )

    @property
    def example(self) -> str:
        """A range of F, or of μ if F follows a table over time."""
        varies_mu = "F" in dict(self.session.over_time)
        return f"μ={self.friction_range}:41" if varies_mu else self.EXAMPLE

    @staticmethod
    def parse(scene: Scene, text: str) -> Study:
        """The sweep of a scene, in both cases, over one or two ranges, or that of a preset."""
        preset = SWEEP_PRESETS.get(text.strip())
        varied = replace_symbols(text).split() if preset is None else preset.varied
        try:
            design = parse_design(varied, "product")
        except InputError as error:
            raise InputError(str(error).replace("--vary ", "")) from None
        # The greatest ẋ shows which belts are always faster than the slider.
        speed_output = ("vx_max",) if "v_belt" in design.axes else ()
        study = scene_study(scene, design, cases=(True, False), outputs=(*_OUTPUTS, *speed_output))
        check_drawable(study)
        check_memory_limit(study)
        return study

    def start_text(self) -> str:
        """The number of runs, and their duration from that of a run of the edited scene."""
        try:
            runs = self.request().members
        except InputError:
            return "runs the scene with each value"
        run_s = self.session.live.expected_duration(self.session.scene())
        duration = about_here(runs * _TYPICAL_RUN_S) if run_s is None else about(runs * run_s)
        return f"computes {runs} runs, {duration}"

    def compute(self, request: Study, job: Job) -> Sweep:
        """Compute a sweep in parts, and display each part."""
        for result in partial_sweeps(request, job.report):
            self.call_later(self._show_part, job, result)
        return result

    def _show_part(self, job: Job, result: Sweep) -> None:
        if job is self.job:
            self.session.studies[self.NAME] = DisplayedStudy(result, self.session.name)

    def show_progress(self) -> None:
        """Display the members computed so far."""
        self.draw()

    def answer_text(self, result: Sweep) -> str:
        """The range of the peak of y, and the number of members."""
        peaks = result.table.numbers.get("y_abs", np.array([]))
        peaks = peaks[np.isfinite(peaks)]
        extent = f"peak |y| {peaks.min():.4g} to {peaks.max():.4g} m" if peaks.size else ""
        computed, members = result.table.members, result.study.members
        count = str(members) if computed == members else f"{computed} of {members}"
        return FACTS.join(filter(None, (extent, f"{count} transients")))

    def details_text(self, result: Sweep) -> str:
        """How many members failed, and why the first one did; empty if none."""
        table = result.table
        # Members that did not fail have an empty reason.
        reason = next(filter(None, table.reasons), "")
        return f"{table.failed} failed: {reason}" if table.failed else ""

    def draw_result(self, result: Sweep) -> None:
        """Draw the computed members, with the edited values of the swept parameters."""
        values = {} if self.edited is None else self.edited.parameters.as_dict()
        x, *others = (values.get(name) for name in result.study.design.axes)
        if not others:
            chart = sweep_chart(result, x)
        else:
            (y,) = others
            point = None if x is None or y is None else (x, y)
            chart = grid_chart(result, self.session.separation, point)
        self.query_one(ChartView).show(chart)

    def read_point(self, result: Sweep, point: NearestPoint) -> tuple[dict[str, str], str]:
        """Field texts of a member."""
        study = result.study
        texts = scene_texts(point_scene(study, point, self.session.separation))
        values = zip(study.design.axes, (point.x, point.y), strict=False)
        description = ", ".join(f"{symbol_of(name)} = {value:g}" for name, value in values)
        return texts, f"{description}, separation {texts['separation']}"

    def export(self, kind: str) -> Export:
        """The sweep if it is complete; its figure as displayed."""
        result: Sweep = self.required_result().value
        if result.table.members < result.study.members:
            raise InputError("the sweep is incomplete: Sweep computes it again before the export")
        return super().export(kind)
