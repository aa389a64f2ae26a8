"""The branches tab: stable and unstable limit cycles along a parameter.

A branch begins at the Hopf point, where the equilibrium loses stability, or at a limit cycle found
by simulation.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import ClassVar, Final, Literal

import numpy as np
from textual import on
from textual.app import ComposeResult
from textual.widgets import Button

from fivtui.charts import NearestPoint
from fivtui.orbits import CycleBranch, CyclePoint, branch, branch_chart, branch_extents, event_name
from fivtui.ranges import parse_ends
from fivtui.scene import Scene
from fivtui.tui.chart import ChartView
from fivtui.tui.session import base_scene, replace_symbols, scene_texts
from fivtui.tui.tabs.job_pane import FACTS
from fivtui.tui.tabs.preview import Sketch

from .study_pane import ResultInputs, StudyPane

# Duration of the run of a limit cycle, in its periods.
_PERIODS_PER_RUN: Final = 20
# Key of the stored origin of the branch, and labels of its button.
_ORIGIN_SETTING: Final = "from"
Origin = Literal["hopf", "cycle"]
_ORIGINS: Final[Mapping[Origin, str]] = {"hopf": "from the Hopf point", "cycle": "from a cycle"}
# A sketch of a branch that folds where unstable limit cycles become stable.
_SKETCH_Y: Final = np.linspace(0.0, 1.0, 81)
_SKETCH_X: Final = 0.2 + 1.6 * (_SKETCH_Y - 0.4) ** 2


class BranchesPane(StudyPane):
    """Branch of limit cycles of the edited scene along any parameter."""

    NAME: ClassVar[str] = "branch"
    AT_START: ClassVar[bool] = True
    VERB: ClassVar[str] = "Follow"
    EXAMPLE: ClassVar[str] = "μ=0.2:1"
    INPUT_FORMAT: ClassVar[str] = "NAME=LOW:HIGH or NAME"
    VIEWS: ClassVar[Mapping[str, str]] = {"branch": "Branch"}
    SKETCH: ClassVar[Sketch | None] = Sketch(
        question="From which value on does a knock start vibration, and how large is it?",
        x="μ",
        y="±y of limit cycles",
        curves=((_SKETCH_X[32:], _SKETCH_Y[32:]),),
        dots=((_SKETCH_X[:32:2], _SKETCH_Y[:32:2]),),
        labels={"stable": (0.65, 0.7), "unstable": (0.05, 0.0)},
    )
    START: ClassVar[str] = "follows the limit cycles along this range"

    @property
    def example(self) -> str:
        """A range of μ."""
        return f"μ={self.friction_range}"

    def compose_bar(self) -> ComposeResult:
        """The parameter with its range, and the start of the branch."""
        yield from super().compose_bar()
        yield Button(_ORIGINS[self._origin], id="branch-from", compact=True)

    @property
    def _origin(self) -> Origin:
        return "cycle" if self.stored_setting(_ORIGIN_SETTING, "") == "cycle" else "hopf"

    @on(Button.Pressed, "#branch-from")
    def _switch_origin(self, event: Button.Pressed) -> None:
        event.stop()
        self.store_setting(_ORIGIN_SETTING, "hopf" if self._origin == "cycle" else "cycle")
        event.button.label = _ORIGINS[self._origin]
        event.button.refresh(layout=True)

    def parse(self, scene: Scene, text: str) -> partial[CycleBranch]:
        """The computation of the branch along a parameter and its range, such as ``μ=0.2:1``."""
        name, ends = parse_ends(replace_symbols(text), self.EXAMPLE)
        low, high = ends or (None, None)
        return partial(
            branch,
            scene.parameters,
            name,
            low=low,
            high=high,
            origin=self._origin,
            separation=scene.separation,
        )

    def answer_text(self, result: CycleBranch) -> str:
        """The events along the branch."""
        return FACTS.join(f"{event_name(event.kind)} {event.value:.4g}" for event in result.events)

    def details_text(self, result: CycleBranch) -> str:
        """How the branch ends."""
        # The first end is where the branch begins.
        _, last_end = result.ends
        return f"the branch {last_end}"

    def inputs_of(self, result: CycleBranch) -> ResultInputs:
        """The system of a branch."""
        return ResultInputs(result.parameters, [result.name], {"separation": result.separation})

    def draw_result(self, result: CycleBranch) -> None:
        """Draw the branch with the edited value."""
        value = None if self.edited is None else getattr(self.edited.parameters, result.name)
        self.query_one(ChartView).show(branch_chart(result, value))

    def read_point(self, result: CycleBranch, point: NearestPoint) -> tuple[dict[str, str], str]:
        """Field texts of the nearest limit cycle."""
        cycle = nearest_cycle(result, point.x, point.y)
        kind = "stable" if cycle.stable else "unstable"
        text = f"the {kind} limit cycle at {result.name} = {cycle.value:.6g}, period "
        return scene_texts(orbit_scene(result, cycle)), f"{text}{cycle.period:.5g} s"


def nearest_cycle(result: CycleBranch, x: float, y: float) -> CyclePoint:
    """The limit cycle nearest to a point of the chart: parameter `x`, half range `y`."""
    values = np.array([cycle.value for cycle in result.points])
    half_ranges = np.array([cycle.half_range for cycle in result.points])
    x_extent, y_extent = branch_extents(result)
    distances = np.hypot((values - x) / x_extent, (half_ranges - y) / y_extent)
    return result.points[int(distances.argmin())]


def orbit_scene(result: CycleBranch, cycle: CyclePoint) -> Scene:
    """The scene that begins on a limit cycle of a branch and lasts twenty of its periods."""
    return replace(
        base_scene(),
        parameters=result.parameters.with_values({result.name: cycle.value}),
        separation=result.separation,
        start=cycle.start,
        t_end=float(f"{_PERIODS_PER_RUN * cycle.period:.6g}"),
    )
