"""The tabs of maps: a value such as the growth rate, or safe friction, over two parameters.

The parameters on the axes are the mapped ones, all others are fixed. Each mapped value is a view.
"""

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np
from textual import on
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Input

from fivtui.charts import NearestPoint
from fivtui.maps import MU_FREE_VALUES
from fivtui.model import InputError
from fivtui.scene import Scene
from fivtui.tui.chart import ChartView, ShadeScale
from fivtui.tui.session import SAFETY_MAPS, DisplayedStudy, Job, Session
from fivtui.tui.tabs.preview import Preview, Sketch, about_here
from fivtui.tui.tabs.requests.map import (
    EXAMPLES,
    TITLES,
    FloatArray,
    map_request,
    mapped_values,
    point_text,
    point_texts,
)

from .study_pane import ResultInputs, StudyPane

if TYPE_CHECKING:
    from fivtui.maps import StabilityMap
    from fivtui.ranges import NamedRange

# Keys of the stored ranges of maps, and of maps of values that do not depend on μ.
_RANGES_SETTING: Final = "over"
_RANGES_WITHOUT_MU: Final = "over-others"
# Delay between the last edit and the computation of the map, s.
_MAP_DELAY: Final = 0.1
# Duration of a point of a map of safe friction where `relative_duration` is 1, s.
_POINT_S: Final = {"safe-mu": 1.2e-2, "coexistence": 1.5e-3}
_SKETCH_X: Final = np.linspace(0.0, 1.0, 80)
# Sketch and question of the views of safe friction.
_PREVIEWS: Final[Mapping[str, tuple[Sketch, str]]] = {
    "safe-mu": (
        Sketch(
            x="F",
            y="k_nl",
            curves=[
                (_SKETCH_X, level / (_SKETCH_X + 0.15)) for level in (0.1, 0.2, 0.35, 0.55, 0.8)
            ],
            labels={"high": (0.02, 0.0), "low safe μ": (0.65, 1.0)},
        ),
        "Below which friction coefficient does no knock start vibration?",
    ),
    "coexistence": (
        Sketch(
            x="μ",
            y="F",
            curves=[(0.2 + width * (1.0 - _SKETCH_X) ** 1.5, _SKETCH_X) for width in (0.2, 0.75)],
            labels={"safe": (0.03, 0.0), "after a knock": (0.46, 0.0), "squeals": (0.6, 1.0)},
        ),
        "Where is it safe, where does a knock start vibration, and where does it squeal by itself?",
    ),
}


class _MapStudy(StudyPane):
    # What the tabs of maps have in common.

    KIND: ClassVar[str] = "map"
    VERB: ClassVar[str] = "Map"
    INPUT: ClassVar[str] = "over"
    EXAMPLE: ClassVar[str] = EXAMPLES["growth-rate"]
    INPUT_FORMAT: ClassVar[str] = "two ranges NAME=START:STOP:COUNT"
    VIEW_SETTING: ClassVar[str] = "value"
    PAGE: ClassVar[str] = "map-view"
    ANSWER: ClassVar[Sequence[str]] = ("unstable", "safe μ", "squeals")

    def compose_views(self) -> ComposeResult:
        """One chart, and the scale of its shades."""
        with Vertical(id=self.PAGE):
            yield (chart := ChartView("map-chart", runs_points=True))
            yield ShadeScale(chart)

    @property
    def input_setting(self) -> str:
        """The key of the stored ranges; maps of values that do not depend on μ have their own."""
        return _RANGES_WITHOUT_MU if self.view in MU_FREE_VALUES else _RANGES_SETTING

    @property
    def initial_text(self) -> str:
        """The stored ranges, or else the example for the mapped value."""
        return self.stored_setting(self.input_setting, EXAMPLES[self.view])

    def parse(self, scene: Scene, text: str) -> "tuple[NamedRange, NamedRange]":  # noqa: ARG002
        """The two ranges of the input."""
        return map_request(text, self.view)

    @property
    def axes(self) -> dict[str, FloatArray]:
        """The values along both axes within the limits of the plot."""
        view = self.query_one(ChartView).view
        return {
            named_range.name: mapped_values(named_range, axis)
            for named_range, axis in zip(
                map_request(self.text, self.view), (view.x, view.y), strict=True
            )
        }

    def request(self) -> Any:
        """Parameters, axes, mapped value and separation."""
        session = self.session
        return session.parameters(), self.axes, self.view, session.separation

    def start_from_inputs(self) -> None:
        """Map the edited scene within the limits of the plot."""
        self.start(partial(self.compute, self.request()))

    def compute(self, request: Any, job: Job) -> "StabilityMap":
        """Compute a map."""
        from fivtui.maps import compute_map

        parameters, axes, value, separation = request
        return compute_map(parameters, axes, value, separation=separation, progress=job.report)

    def details_text(self, result: "StabilityMap") -> str:
        """Number of points of the map, and the key that runs one."""
        return f"{result.values.size} points; Enter: run one"

    def inputs_of(self, result: "StabilityMap") -> ResultInputs:
        """The fixed parameters of a map."""
        varied = [*result.names, *(["mu"] if result.value in MU_FREE_VALUES else [])]
        return ResultInputs(result.parameters, varied, {"separation": result.separation})

    def draw(self) -> None:
        """Draw the map, or its absence."""
        super().draw()
        self.query_one(ShadeScale).redraw()

    def draw_result(self, result: "StabilityMap") -> None:
        """Draw the map with the edited point."""
        from fivtui.maps import map_chart

        chart = map_chart(result, self.parameters)
        self.query_one(ChartView).show(chart)

    def submit_input(self) -> None:
        """Stop the current map and map the typed ranges."""
        self.fit_axes()
        self.stop()
        self.toggle_computation()

    def show_view(self, name: str) -> None:
        """Change the mapped value."""
        self.stop()
        super().show_view(name)
        range_input, ranges = self.query_one("#over", Input), self.initial_text
        if range_input.value != ranges:
            # The axis limits belong to different parameters.
            range_input.value = ranges
            self.fit_axes()
        self.check_input()

    def read_point(self, result: "StabilityMap", point: NearestPoint) -> tuple[dict[str, str], str]:
        """Field texts of a point of the map."""
        return point_texts(result, point), point_text(result, point)

    def command_request(self) -> Any:
        """The displayed result; without result there is no command."""
        return self.required_result().value


class SafeFrictionPane(_MapStudy):
    """Safe friction, or the regions of coexistence, over two parameters of the edited scene."""

    NAME: ClassVar[str] = "safe-mu"
    QUANTITIES: ClassVar[Mapping[str, str]] = SAFETY_MAPS
    VIEWS: ClassVar[Mapping[str, str]] = QUANTITIES
    SKETCH: ClassVar[Sketch | None] = _PREVIEWS["safe-mu"][0]

    def compose_preview(self) -> ComposeResult:
        """The preview of the current view."""
        yield Preview(*_PREVIEWS[self.view])

    @property
    def study_key(self) -> str:
        """The maps of both values are stored."""
        return self.view

    def show_view(self, name: str) -> None:
        """Show the map of a value, if there is one."""
        super().show_view(name)
        self.query_one(Preview).ask(*_PREVIEWS[name])
        if self.displayed is None:
            self.show_status("")

    def start_text(self) -> str:
        """The number of points, and their usual duration."""
        try:
            points = math.prod(len(values) for values in self.axes.values())
        except InputError:
            return "maps two ranges"
        seconds = points * _POINT_S[self.view]
        return f"maps {points} points, {about_here(seconds)}"


class MapPane(_MapStudy):
    """Growth rate, μ_c or unstable modes over two parameters; the map follows every edit.

    A map read from a file is displayed until the user computes another one.
    """

    NAME: ClassVar[str] = "map"
    QUANTITIES: ClassVar[Mapping[str, str]] = TITLES
    VIEWS: ClassVar[Mapping[str, str]] = QUANTITIES

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        # The computed map; not stored with the session, because it is recomputed quickly.
        self._computed: DisplayedStudy[StabilityMap] | None = None
        # The inputs of that map, compared to find whether it is outdated.
        self._inputs: object = None

    @property
    def displayed(self) -> "DisplayedStudy[StabilityMap] | None":
        """A map read from a file, or else the computed map."""
        return super().displayed or self._computed

    def computed_scene(self, result: "StabilityMap", edited: Scene) -> Scene:
        """The edited scene, which a computed map follows; else the scene of a map that was read."""
        return super().computed_scene(result, edited) if super().displayed else edited

    def scene_changed(self) -> None:
        """Recompute the map if a fixed parameter has changed."""
        super().scene_changed()
        if self._error or self.NAME in self.session.studies:
            # The bar displays the error of the input, or the status of a map that was read.
            return
        try:
            inputs = self._current_inputs()
        except InputError as error:
            self.show_status(str(error))
            return
        if inputs != self._inputs:
            self.call_after_pause(_MAP_DELAY, self._recompute)

    @on(ChartView.LimitsChanged)
    def _recompute_visible_part(self, event: ChartView.LimitsChanged) -> None:
        # Compute the visible part again, at full resolution.
        event.stop()
        self.scene_changed()

    def _recompute(self) -> None:
        if self._error or self.NAME in self.session.studies:
            return
        try:
            self.start_from_inputs()
        except InputError as error:
            self.show_status(str(error))

    def _current_inputs(self) -> object:
        # The map does not depend on the edited values of the mapped parameters.
        session, view = self.session, self.query_one(ChartView).view
        ranges = map_request(self.text, self.view)
        mapped_names = [named_range.name for named_range in ranges]
        values = session.parameters().as_dict().items()
        fixed = tuple((name, value) for name, value in values if name not in mapped_names)
        return ranges, (view.x, view.y), fixed, self.view, session.separation

    def start_from_inputs(self) -> None:
        """Compute the map; it replaces one that was read."""
        self._inputs = self._current_inputs()
        super().start_from_inputs()
        self.session.studies.pop(self.NAME, None)

    def show_result(self, result: "StabilityMap") -> None:
        """Display a computed map."""
        self._computed = DisplayedStudy(result, "")
        self.scene_changed()

    def show_view(self, name: str) -> None:
        """Map another value."""
        super().show_view(name)
        try:
            self.request()
        except InputError as error:
            # The displayed map shows a different value.
            self._computed = None
            self.draw()
            self.query_one(ChartView).show(None, empty_text=str(error))
        self.toggle_computation()
