"""The map tab: a value such as the growth rate over two parameters, updated on every edit.

The parameters on the axes are the mapped ones, all others are fixed. A map read from a file is
displayed until the user computes another one.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np
from textual import on
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.widgets import Input, Static

from fivtui.charts import Heading, NearestPoint, scale_text
from fivtui.model import InputError
from fivtui.scene import Scene
from fivtui.tui.chart import ChartView
from fivtui.tui.session import DisplayedStudy, Job, Session
from fivtui.tui.tabs.requests.map import (
    EXAMPLE,
    EXAMPLE_WITHOUT_MU,
    TITLES,
    WITHOUT_MU,
    FloatArray,
    map_request,
    mapped_values,
    point_text,
    point_texts,
)

from .study_pane import StudyPane

if TYPE_CHECKING:
    from fivtui.maps import StabilityMap
    from fivtui.ranges import NamedRange

# Keys of the stored ranges of maps, and of maps of values that do not depend on μ.
_RANGES_SETTING: Final = "over"
_RANGES_WITHOUT_MU: Final = "over-others"
# Delay between the last edit and the computation of the map, s.
_MAP_DELAY: Final = 0.1
# Maximum number of values per axis of a map of safe friction: a point takes milliseconds.
_MAX_AXIS_VALUES: Final = 41


def thin_values(values: FloatArray) -> FloatArray:
    """Select at most `_MAX_AXIS_VALUES` of the values, evenly."""
    if values.size <= _MAX_AXIS_VALUES:
        return values
    indices = np.linspace(0, values.size - 1, _MAX_AXIS_VALUES).round().astype(int)
    selected: FloatArray = values[indices]
    return selected


class MapPane(StudyPane):
    """Growth rate, μ_c, unstable modes or safe friction over two parameters of the edited scene."""

    NAME: ClassVar[str] = "map"
    VERB: ClassVar[str] = "Map"
    INPUT: ClassVar[str] = "over"
    EXAMPLE: ClassVar[str] = EXAMPLE
    INPUT_FORMAT: ClassVar[str] = "two ranges NAME=START:STOP:COUNT"
    CHOICE_SETTING: ClassVar[str] = "value"
    CHOICES: ClassVar[Mapping[str, str]] = TITLES
    VIEWS: ClassVar[Mapping[str, str]] = {"map-view": "Map"}

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        # The computed map; not stored with the session, because it is recomputed quickly.
        self._computed: DisplayedStudy[StabilityMap] | None = None
        # The inputs of that map, compared to find whether it is outdated.
        self._inputs: object = None

    def compose_bar(self) -> ComposeResult:
        """The mapped value and the two ranges."""
        with Horizontal(classes="values"):
            yield from self.compose_choices()
        yield from self.compose_input()

    def compose_views(self) -> ComposeResult:
        """One chart, and the scale of its shades."""
        with Vertical(id="map-view"):
            yield ChartView("map-chart", runs_points=True)
            yield Static("", id="scale", markup=False)

    @property
    def input_setting(self) -> str:
        """The key of the stored ranges; maps of values that do not depend on μ have their own."""
        return _RANGES_WITHOUT_MU if self.choice in WITHOUT_MU else _RANGES_SETTING

    @property
    def initial_text(self) -> str:
        """The stored ranges; a map without μ of its own takes those of the other maps if valid."""
        ranges_text = self.stored_setting(_RANGES_SETTING, EXAMPLE)
        if self.choice not in WITHOUT_MU:
            return ranges_text
        try:
            map_request(ranges_text, self.choice)
        except InputError:
            ranges_text = EXAMPLE_WITHOUT_MU
        return self.stored_setting(_RANGES_WITHOUT_MU, ranges_text)

    def parse(self, scene: Scene, text: str) -> "tuple[NamedRange, NamedRange]":  # noqa: ARG002
        """The two ranges of the input."""
        return map_request(text, self.choice)

    @property
    def displayed(self) -> "DisplayedStudy[StabilityMap] | None":
        """A map read from a file, or else the computed map."""
        return super().displayed or self._computed

    def scene_changed(self) -> None:
        """Recompute the map if a fixed parameter has changed."""
        super().scene_changed()
        if self.NAME in self.session.studies:
            return
        try:
            _, inputs = self._axes_and_inputs()
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
        if self.NAME in self.session.studies:
            return
        try:
            self.start_from_inputs()
        except InputError as error:
            self.show_status(str(error))

    def _axes_and_inputs(self) -> tuple[dict[str, FloatArray], object]:
        # The values along both axes within the limits of the plot, and all inputs of the map.
        ranges = map_request(self.text, self.choice)
        parameters, view = self.session.parameters(), self.query_one(ChartView).view
        limits = (view.x, view.y)
        axes = {
            named_range.name: mapped_values(named_range, axis)
            for named_range, axis in zip(ranges, limits, strict=True)
        }
        # The map does not depend on the edited values of the mapped parameters.
        fixed = tuple(
            (name, value) for name, value in parameters.as_dict().items() if name not in axes
        )
        return axes, (ranges, limits, fixed, self.choice, self.session.separation)

    def start_from_inputs(self) -> None:
        """Compute the map."""
        axes, self._inputs = self._axes_and_inputs()
        parameters, separation = self.session.parameters(), self.session.separation
        value = self.choice

        def compute(job: Job) -> "StabilityMap":
            from fivtui.maps import SAFETY_VALUES, compute_map

            mapped = axes
            if value in SAFETY_VALUES:
                # A point takes long.
                mapped = {name: thin_values(values) for name, values in axes.items()}
            return compute_map(
                parameters, mapped, value, separation=separation, progress=job.report
            )

        self.session.studies.pop(self.NAME, None)
        self.start(compute)

    def show_result(self, result: "StabilityMap") -> None:
        """Display a computed map."""
        self._computed = DisplayedStudy(result, "")
        self.scene_changed()

    def result_status(self, displayed: "DisplayedStudy[StabilityMap]") -> str:
        """Number of points of the map, or the file from which it was read."""
        if displayed.source:
            return f"read from {displayed.source}; F10 maps the edited scene"
        return f"{displayed.value.values.size} points; Enter: run one"

    def draw_result(self, result: "StabilityMap") -> None:
        """Draw the map with the edited point."""
        from fivtui.maps import map_chart

        chart = map_chart(result, self.parameters)
        self.query_one(ChartView).show(chart)
        # The backdrop of a map is its values as shades.
        if chart.backdrop is not None:
            self.query_one("#scale", Static).update(scale_text(chart.backdrop.shades))

    def submit_input(self) -> None:
        """Stop the current map and map the typed ranges."""
        self.fit_axes()
        self.stop()
        self.toggle_computation()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:  # noqa: ARG002
        """All actions are enabled: each value of the map counts as a view."""
        return True

    def action_next_view(self) -> None:
        """Map the next value."""
        names = list(TITLES)
        self.activate_choice(names[(names.index(self.choice) + 1) % len(names)])

    def activate_choice(self, name: str) -> None:
        """Change the mapped value."""
        self.store_setting(self.CHOICE_SETTING, name)
        self.mark_choice(name)
        range_input, ranges = self.query_one("#over", Input), self.initial_text
        if range_input.value != ranges:
            # The axis limits belong to different parameters.
            range_input.value = ranges
            self.fit_axes()
        self.stop()
        self.check_input()
        try:
            self._axes_and_inputs()
        except InputError as error:
            # The displayed map shows a different value.
            self._computed = None
            self.query_one(ChartView).show(None, empty_text=str(error))
            self.query_one("#scale", Static).update("")
        self.toggle_computation()

    def read_point(self, result: "StabilityMap", point: NearestPoint) -> tuple[dict[str, str], str]:
        """Field texts of a point of the map."""
        return point_texts(result, point), point_text(result, point)

    def heading(self, result: "StabilityMap") -> Heading:
        """The parameters that are not mapped."""
        return Heading([result.parameters], result.names, ignores_separation=not result.separation)

    def command_request(self) -> Any:
        """The displayed result; without result there is no command."""
        return self.required_result().value
