"""The map tab: stability over two parameters, updated on every edit."""

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
    VALUES,
    WITHOUT_MU,
    FloatArray,
    map_request,
    point_texts,
    point_words,
    values_in,
)

from .study_pane import StudyPane

if TYPE_CHECKING:
    from fivtui.maps import StabilityMap
    from fivtui.ranges import NamedRange

# Settings that store the ranges of maps, and of maps of values that do not depend on μ.
_OVER: Final = "over"
_OVER_OTHERS: Final = "over-others"
# Delay of the map after the last edit, s.
_PAUSE: Final = 0.1
# Maximum values per axis of a map of safe friction, which takes milliseconds per point.
_MAX_AXIS_VALUES: Final = 41


def thinned(values: FloatArray) -> FloatArray:
    """Thin values to at most `_MAX_AXIS_VALUES`."""
    if values.size <= _MAX_AXIS_VALUES:
        return values
    chosen = np.linspace(0, values.size - 1, _MAX_AXIS_VALUES).round().astype(int)
    thin: FloatArray = values[chosen]
    return thin


class MapPane(StudyPane):
    """Growth rate, μ_c, unstable modes or safe friction over two parameters of the edited scene."""

    NAME: ClassVar[str] = "map"
    VERB: ClassVar[str] = "Map"
    INPUT: ClassVar[str] = "over"
    EXAMPLE: ClassVar[str] = EXAMPLE
    FORM: ClassVar[str] = "NAME=START:STOP:COUNT, two of them"
    CHOICE: ClassVar[str] = "value"
    CHOICES: ClassVar[Mapping[str, str]] = VALUES
    VIEWS: ClassVar[Mapping[str, str]] = {"map-view": "Map"}

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        # Not stored with the session, because it is recomputed quickly.
        self._computed: DisplayedStudy[StabilityMap] | None = None
        self._key: object = None

    def compose_bar(self) -> ComposeResult:
        """The mapped value and the two ranges."""
        with Horizontal(classes="values"):
            yield from self.compose_choices()
        yield from self.compose_input()

    def compose_views(self) -> ComposeResult:
        """One chart, and the scale of its shades."""
        with Vertical(id="map-view"):
            yield ChartView("map-chart", openable=True)
            yield Static("", id="scale", markup=False)

    @property
    def input_setting(self) -> str:
        """Values that do not depend on μ have separate ranges."""
        return _OVER_OTHERS if self.chosen in WITHOUT_MU else _OVER

    @property
    def initial_text(self) -> str:
        """The stored ranges for the mapped value, or else those of other maps if valid."""
        usual = self.setting(_OVER, EXAMPLE)
        try:
            map_request(usual, self.chosen)
        except InputError:
            usual = EXAMPLE_WITHOUT_MU if self.chosen in WITHOUT_MU else usual
        return self.setting(self.input_setting, usual)

    def parse(self, scene: Scene, text: str) -> "tuple[NamedRange, NamedRange]":  # noqa: ARG002
        """The two ranges of the input."""
        return map_request(text, self.chosen)

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
            key = self._edited_map()[-1]
        except InputError as error:
            self.show_status(str(error))
            return
        if key != self._key:
            self.after_pause(_PAUSE, self._again)

    @on(ChartView.LimitsChanged)
    def _moved(self, event: ChartView.LimitsChanged) -> None:
        # The visible part is computed again at full resolution.
        event.stop()
        self.scene_changed()

    def _again(self) -> None:
        if self.NAME in self.session.studies:
            return
        try:
            self.begin()
        except InputError as error:
            self.show_status(str(error))

    def _edited_map(self) -> tuple[dict[str, FloatArray], object]:
        # The mapped values of the visible part, and a key of all inputs of the map.
        ranges = map_request(self.text, self.chosen)
        p, view = self.session.parameters(), self.query_one(ChartView).view
        limits = (view.x, view.y)
        over = {
            named_range.name: values_in(named_range, axis)
            for named_range, axis in zip(ranges, limits, strict=True)
        }
        # The edited values of the mapped parameters do not matter.
        fixed = tuple((name, value) for name, value in p.as_dict().items() if name not in over)
        return over, (ranges, limits, fixed, self.chosen, self.session.separation)

    def begin(self) -> None:
        """Compute the map."""
        over, self._key = self._edited_map()
        p, value, separation = self.session.parameters(), self.chosen, self.session.separation

        def compute(job: Job) -> "StabilityMap":
            from fivtui.maps import SAFETY_VALUES, compute_map

            thin = value in SAFETY_VALUES
            chosen = {name: thinned(v) if thin else v for name, v in over.items()}
            return compute_map(p, chosen, value, separation=separation, progress=job.report)

        self.session.studies.pop(self.NAME, None)
        self.start(compute)

    def show_result(self, result: "StabilityMap") -> None:
        """Display a computed map."""
        self._computed = DisplayedStudy(result, "")
        self.scene_changed()

    def result_status(self, displayed: "DisplayedStudy[StabilityMap]") -> str:
        """Number of points, or the file of the map."""
        if displayed.source:
            return f"read from {displayed.source}; F10 maps the edited scene"
        return f"{displayed.value.values.size} points; Enter: run one"

    def draw_result(self, result: "StabilityMap") -> None:
        """Draw the map with the edited point."""
        from fivtui.maps import map_chart

        chart = map_chart(result, self.parameters)
        self.query_one(ChartView).show(chart)
        if chart.backdrop is not None:
            self.query_one("#scale", Static).update(scale_text(chart.backdrop.shades))

    def submitted(self) -> None:
        """Stop the current map and map the typed ranges."""
        self.fit_axes()
        self.stop()
        self.work()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:  # noqa: ARG002
        """Always enabled: the map has one view per value."""
        return True

    def action_turn_view(self) -> None:
        """Map the next value."""
        names = list(VALUES)
        self.choose(names[(names.index(self.chosen) + 1) % len(names)])

    def choose(self, name: str) -> None:
        """Change the mapped value."""
        self.keep(self.CHOICE, name)
        self.mark_choice(name)
        over, ranges = self.query_one("#over", Input), self.initial_text
        if over.value != ranges:
            # The axis limits belong to different parameters.
            over.value = ranges
            self.fit_axes()
        self.stop()
        self.check_input()
        try:
            self._edited_map()
        except InputError as error:
            # The displayed map shows a different value.
            self._computed = None
            self.query_one(ChartView).show(None, empty_text=str(error))
            self.query_one("#scale", Static).update("")
        self.work()

    def point_of(self, result: "StabilityMap", point: NearestPoint) -> tuple[dict[str, str], str]:
        """Field texts of a point of the map."""
        return point_texts(result, point), point_words(result, point)

    def heading(self, result: "StabilityMap") -> Heading:
        """The parameters that are not mapped."""
        return Heading([result.parameters], result.names, ignores_separation=not result.separation)

    def command_request(self) -> Any:
        """The displayed result: only results have a command."""
        return self.required().value
