"""The map tab: stability over two parameters, updated on every edit."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np
from textual import on
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.timer import Timer
from textual.widgets import Button, Input, Static

from fivtui.charts import Heading
from fivtui.model import InputError, Parameters
from fivtui.scene import Scene
from fivtui.tui.chart import ChartView
from fivtui.tui.session import Job, Session, study_line

from .charts.map import (
    EXAMPLE,
    EXAMPLE_WITHOUT_MU,
    VALUES,
    WITHOUT_MU,
    FloatArray,
    map_chart,
    map_request,
    map_scale,
    point_texts,
    point_words,
    values_in,
)
from .exports.export import Export, as_displayed, scene_study_export
from .job_pane import JobPane
from .messages import PointOpened

if TYPE_CHECKING:
    from fivtui.maps import StabilityMap

_PREFIX: Final = "value-"
_VALUE: Final = "value"
# Settings with the ranges of maps, and of those of values that do not depend on μ.
_OVER: Final = "over"
_OVER_OTHERS: Final = "over-others"
_NOTHING: Final = "no map yet: press F10"
_PAUSE: Final = 0.1
# A map of safe friction takes milliseconds a point.
_MOST_OF_AXIS: Final = 41


def thinned(values: FloatArray) -> FloatArray:
    """At most as many values as a map of safe friction has along an axis of the laboratory."""
    if values.size <= _MOST_OF_AXIS:
        return values
    chosen = np.linspace(0, values.size - 1, _MOST_OF_AXIS).round().astype(int)
    found: FloatArray = values[chosen]
    return found


class MapPane(JobPane):
    """Growth rate, μ_c, unstable modes or safe friction over two parameters of the edited scene."""

    NAME: ClassVar[str] = "map"
    VERB: ClassVar[str] = "Map"
    FORM: ClassVar[str] = "NAME=START:STOP:COUNT, two of them"
    VIEWS: ClassVar[Mapping[str, str]] = {"map-view": "Map"}

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._computed: StabilityMap | None = None
        kept = self.setting(_VALUE, "")
        self._value = kept if kept in VALUES else next(iter(VALUES))
        self._key: object = None
        self._waiting: Timer | None = None

    def compose_bar(self) -> ComposeResult:
        """The mapped value and the two ranges."""
        with Horizontal(classes="values"):
            for name, title in VALUES.items():
                classes = "value -active" if name == self._value else "value"
                yield Button(title, id=f"{_PREFIX}{name}", classes=classes, compact=True)
        yield self.study_input("over", self._ranges_key, self._ranges)

    def compose_views(self) -> ComposeResult:
        """One chart, and what its shades mean."""
        with Vertical(id="map-view"):
            yield ChartView("map-chart", openable=True)
            yield Static("", id="scale", markup=False)

    @property
    def _ranges_key(self) -> str:
        return _OVER_OTHERS if self._value in WITHOUT_MU else _OVER

    @property
    def _ranges(self) -> str:
        # The ranges for the mapped value; at first those of the other values, if they fit.
        usual = self.setting(_OVER, EXAMPLE)
        try:
            map_request(usual, self._value)
        except InputError:
            usual = EXAMPLE_WITHOUT_MU if self._value in WITHOUT_MU else usual
        return self.setting(self._ranges_key, usual)

    @property
    def _result(self) -> "StabilityMap | None":
        # A map read from a file stays until another one is computed.
        read = self.session.studies.get("map")
        return self._computed if read is None else read.value

    def scene_changed(self) -> None:
        """Recompute the map if another parameter has changed."""
        super().scene_changed()
        self.draw()
        read = self.session.studies.get("map")
        if read is not None:
            self.stop()
            self.say(f"read from {read.source}; F10 maps the edited scene")
            return
        try:
            key = self._request()[-1]
        except InputError as error:
            self.say(str(error))
            return
        if key != self._key:
            if self._waiting is not None:
                self._waiting.stop()
            self._waiting = self.set_timer(_PAUSE, self._again)

    @on(ChartView.Moved)
    def _moved(self, event: ChartView.Moved) -> None:
        # The visible part is computed again at full resolution.
        event.stop()
        self.scene_changed()

    def _again(self) -> None:
        if self.session.studies.get("map") is not None:
            return
        try:
            self.begin()
        except InputError as error:
            self.say(str(error))

    def _request(self) -> tuple[dict[str, FloatArray], Parameters, object]:
        first, second = map_request(self.text, self._value)
        p = self.session.parameters()
        # The mapped parameters' own values do not matter.
        others = tuple(
            (name, value)
            for name, value in p.as_dict().items()
            if name not in (first.name, second.name)
        )
        view = self.query_one(ChartView).view
        chosen = (view.x, view.y)
        over = {
            each.name: values_in(each, axis)
            for each, axis in zip((first, second), chosen, strict=True)
        }
        return over, p, (first, second, chosen, others, self._value, self.session.separation)

    def check_text(self, scene: Scene, text: str) -> None:  # noqa: ARG002
        """Raise `InputError` if the text is not what `FORM` says."""
        map_request(text, self._value)

    def begin(self) -> None:
        """Compute the map."""
        over, p, key = self._request()
        value, separation = self._value, self.session.separation

        def compute(job: Job) -> "StabilityMap":
            from fivtui.maps import SAFETY_VALUES, compute_map

            thin = value in SAFETY_VALUES
            chosen = {name: thinned(v) if thin else v for name, v in over.items()}
            return compute_map(p, chosen, value, separation=separation, progress=job.report)

        self._key = key
        self.session.studies.put("map", None)
        self.start(compute)

    def take(self, result: "StabilityMap") -> None:
        """Display the map."""
        self._computed = result
        self.say(f"{result.values.size} points; Enter: run one")
        self.draw()

    def draw(self) -> None:
        """Draw the map."""
        result = self._result
        if result is None:
            return
        try:
            now = self.session.parameters()
        except InputError:
            now = None
        self.query_one(ChartView).show(map_chart(result, now))
        self.query_one("#scale", Static).update(map_scale(result))

    def submitted(self) -> None:
        """Map the ranges typed, in place of those being mapped."""
        self.query_one(ChartView).view.reset()
        self.stop()
        self.work()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:  # noqa: ARG002
        """All actions apply: a view of the map is a value."""
        return True

    def action_turn_view(self) -> None:
        """Map the next value."""
        names = list(VALUES)
        self._choose(names[(names.index(self._value) + 1) % len(names)])

    @on(Button.Pressed, ".value")
    def _chosen(self, event: Button.Pressed) -> None:
        event.stop()
        self._choose(str(event.button.id).removeprefix(_PREFIX))

    def _choose(self, value: str) -> None:
        self._value = value
        self.keep(_VALUE, value)
        self.store_under(self._ranges_key)
        over = self.query_one("#over", Input)
        ranges = self._ranges
        if over.value != ranges:
            # The limits are those of other parameters.
            over.value = ranges
            self.query_one(ChartView).view.reset()
        for button in self.query(".value"):
            button.set_class(button.id == f"{_PREFIX}{value}", "-active")
        self.stop()
        self._check_input()
        try:
            self._request()
        except InputError as error:
            # The displayed map is of another value.
            self._computed = None
            self.query_one(ChartView).show(None, nothing=str(error))
            self.query_one("#scale", Static).update("")
        self.work()

    @on(ChartView.Opened)
    def _opened(self, event: ChartView.Opened) -> None:
        result = self._result
        if result is not None:
            words = f"opened {point_words(result, event.point)}"
            self.post_message(PointOpened(point_texts(result, event.point), words))

    def export(self, what: str) -> Export:
        """The map; its figure as displayed."""
        read, result = self.session.studies.get("map"), self._result
        if result is None:
            raise InputError(_NOTHING)
        name = self.session.name if read is None else read.name
        heading = Heading([result.parameters], result.names, ignored=not result.separation)
        whole = scene_study_export(what, "map", result, name)
        return as_displayed(whole, self.visible_charts(), heading)

    def command_line(self) -> str:
        """The command that computes the map."""
        result = self._result
        if result is None:
            raise InputError(_NOTHING)
        return study_line("map", result, self.session.origin)
