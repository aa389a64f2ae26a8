"""The tabs of maps: a value such as the growth rate, or safe friction, over two parameters.

The parameters on the axes are the mapped ones, all others are fixed. Each mapped value is a view.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray
from textual import on
from textual.timer import Timer
from textual.widgets import Input

from fivtui.charts import Axis, NearestPoint
from fivtui.maps import (
    MU_FREE_VALUES,
    StabilityMap,
    check_map,
    check_points,
    compute_map,
    map_chart,
)
from fivtui.model import ALL_PARAMETERS, InputError
from fivtui.ranges import NamedRange, parse_ranges
from fivtui.scene import Scene
from fivtui.studies import study
from fivtui.tui.chart import ChartView
from fivtui.tui.session import (
    SAFETY_MAPS,
    DisplayedStudy,
    base_scene,
    replace_symbols,
    scene_texts,
    symbol_of,
)
from fivtui.tui.tabs.job_pane import FACTS
from fivtui.tui.tabs.preview import Sketch, about_here

from .study_pane import ResultInputs, StudyPane

FloatArray = NDArray[np.float64]

# Usual ranges by mapped value; values of safety, which take longer, have fewer points.
EXAMPLES: Final = {
    "growth-rate": "μ=0:1.5:121 F=5:120:93",
    "critical-mu": "F=5:120:93 k_nl=20:500:61",
    "unstable-modes": "μ=0:1.5:121 F=5:120:93",
    "safe-mu": "F=5:120:24 k_nl=20:500:25",
    "coexistence": "μ=0:1.5:31 F=5:120:24",
}
_MAX_POINTS: Final = 1_000_000
# Significant digits of the coordinates of an opened point.
_DIGITS: Final = 9
# Labels of the rows of a map that say how much of it is dangerous.
_ANSWER: Final = ("unstable", "safe μ", "squeals")
# Keys of the stored ranges of maps, and of maps of values that do not depend on μ.
_RANGES_SETTING: Final = "over"
_RANGES_WITHOUT_MU: Final = "over-others"
# Delay between the last edit and the computation of the map, s.
_MAP_DELAY: Final = 0.1
# Duration of a point of a map of safe friction where `relative_duration` is 1, s.
_POINT_S: Final = {"safe-mu": 1.2e-2, "coexistence": 1.5e-3}
_SKETCH_X: Final = np.linspace(0.0, 1.0, 80)
# Sketches of the views of safe friction.
_SKETCHES: Final[Mapping[str, Sketch]] = {
    "safe-mu": Sketch(
        question="Below which friction coefficient does no knock start vibration?",
        x="F",
        y="k_nl",
        curves=[(_SKETCH_X, level / (_SKETCH_X + 0.15)) for level in (0.1, 0.2, 0.35, 0.55, 0.8)],
        labels={"high": (0.02, 0.0), "low safe μ": (0.65, 1.0)},
    ),
    "coexistence": Sketch(
        question="Where is it safe, where does a knock start vibration, and where does it squeal "
        "by itself?",
        x="μ",
        y="F",
        curves=[(0.2 + width * (1.0 - _SKETCH_X) ** 1.5, _SKETCH_X) for width in (0.2, 0.75)],
        labels={"safe": (0.03, 0.0), "after a knock": (0.46, 0.0), "squeals": (0.6, 1.0)},
    ),
}


def map_ranges(text: str, value: str) -> tuple[NamedRange, NamedRange]:
    """Parse the two ranges of a map, such as ``μ=0:1.5:121 F=5:120:93``; the first is along x.

    `value` is the mapped value, a key of `EXAMPLES`. Raises `InputError` for an invalid text.
    """
    range_texts = replace_symbols(text).split()
    if len(range_texts) != 2:
        raise InputError(f"{text!r}: must be two ranges, e.g. {EXAMPLES[value]}")
    try:
        first, second = parse_ranges("map", range_texts)
    except InputError as error:
        raise InputError(str(error).removeprefix("map ")) from None
    check_map(value, (first.name, second.name))
    check_points(first.count * second.count, _MAX_POINTS)
    return first, second


def mapped_values(named_range: NamedRange, axis: Axis | None) -> FloatArray:
    """The values of a range, or the same number of values between chosen axis limits."""
    if axis is None:
        return named_range.values()
    spec = ALL_PARAMETERS[named_range.name]
    low, high = max(axis.low, spec.lower), min(axis.high, spec.upper)
    if low >= high:
        return named_range.values()
    spacing = np.geomspace if axis.log and low > 0.0 else np.linspace
    values: FloatArray = spacing(low, high, named_range.count)
    return values


class _MapStudy(StudyPane):
    # What the tabs of maps have in common.

    AT_START: ClassVar[bool] = True
    VERB: ClassVar[str] = "Map"
    EXAMPLE: ClassVar[str] = EXAMPLES["growth-rate"]
    INPUT_FORMAT: ClassVar[str] = "two ranges NAME=START:STOP:COUNT"
    VIEW_SETTING: ClassVar[str] = "value"

    @property
    def input_setting(self) -> str:
        """The key of the stored ranges; maps of values that do not depend on μ have their own."""
        return _RANGES_WITHOUT_MU if self.view in MU_FREE_VALUES else _RANGES_SETTING

    @property
    def example(self) -> str:
        """Usual ranges for the mapped value."""
        return EXAMPLES[self.view]

    @property
    def axes(self) -> dict[str, FloatArray]:
        """The values along both axes within the limits of the plot."""
        view = self.query_one(ChartView).view
        ranges = zip(map_ranges(self.text, self.view), (view.x, view.y), strict=True)
        return {named_range.name: mapped_values(named_range, axis) for named_range, axis in ranges}

    def parse(self, scene: Scene, text: str) -> partial[StabilityMap]:  # noqa: ARG002
        """The computation of the map within the limits of the plot."""
        separation = scene.separation
        return partial(compute_map, scene.parameters, self.axes, self.view, separation=separation)

    def start_from_inputs(self) -> None:
        """Map the edited scene within the limits of the plot."""
        self.start(partial(self.compute, self.request()))

    def answer_text(self, result: StabilityMap) -> str:
        """How much of the map is dangerous."""
        rows = study(self.kind).rows(result)
        return FACTS.join(f"{row.label} {row.value}" for row in rows if row.label in _ANSWER)

    def details_text(self, result: StabilityMap) -> str:
        """Number of points of the map, and the key that runs one."""
        return f"{result.values.size} points; Enter: run one"

    def inputs_of(self, result: StabilityMap) -> ResultInputs:
        """The fixed parameters of a map."""
        varied = [*result.names, *(["mu"] if result.value in MU_FREE_VALUES else [])]
        return ResultInputs(result.parameters, varied, {"separation": result.separation})

    def draw_result(self, result: StabilityMap) -> None:
        """Draw the map with the edited point."""
        parameters = None if self.edited is None else self.edited.parameters
        self.query_one(ChartView).show(map_chart(result, parameters))

    def show_view(self, name: str) -> None:
        """Change the mapped value."""
        self.stop()
        self.status = ""
        super().show_view(name)
        self.query_one(".study-input", Input).value = self.initial_text
        self.check_input()

    @staticmethod
    def read_point(result: StabilityMap, point: NearestPoint) -> tuple[dict[str, str], str]:
        """Texts of the parameters and of separation at a point of the map, and its coordinates."""
        coordinates = [float(f"{value:.{_DIGITS}g}") for value in (point.x, point.y)]
        values = dict(zip(result.names, coordinates, strict=True))
        parameters = result.parameters.with_values(values)
        scene = replace(base_scene(), parameters=parameters, separation=result.separation)
        texts = scene_texts(scene)
        description = ", ".join(f"{symbol_of(name)} = {texts[name]}" for name in result.names)
        return {name: texts[name] for name in (*ALL_PARAMETERS, "separation")}, description


class SafeFrictionPane(_MapStudy):
    """Safe friction, or the regions of coexistence, over two parameters of the edited scene."""

    NAME: ClassVar[str] = "safe-mu"
    QUANTITIES: ClassVar[Mapping[str, str]] = SAFETY_MAPS
    VIEWS: ClassVar[Mapping[str, str]] = QUANTITIES
    SKETCH: ClassVar[Sketch | None] = _SKETCHES["safe-mu"]

    @property
    def sketch(self) -> Sketch:
        """The sketch of the current view."""
        return _SKETCHES[self.view]

    def start_text(self) -> str:
        """The number of points, and their usual duration."""
        try:
            points = math.prod(map(len, self.axes.values()))
        except InputError:
            return "maps two ranges"
        return f"maps {points} points, {about_here(points * _POINT_S[self.view])}"


class MapPane(_MapStudy):
    """Growth rate, μ_c or unstable modes over two parameters; the map follows every edit.

    A map read from a file is displayed until the user computes another one.
    """

    NAME: ClassVar[str] = "map"
    QUANTITIES: ClassVar[Mapping[str, str]] = {
        "growth-rate": "Growth",
        "critical-mu": "μ_c",
        "unstable-modes": "Modes",
    }
    VIEWS: ClassVar[Mapping[str, str]] = QUANTITIES

    # The computed map; not stored with the session, because it is recomputed quickly.
    _computed: DisplayedStudy[StabilityMap] | None = None
    # The inputs of that map, compared to find whether it is outdated.
    _inputs: object = None
    # The pause after the last edit.
    _pause: Timer | None = None

    @property
    def displayed(self) -> DisplayedStudy[StabilityMap] | None:
        """A map read from a file, or else the computed map of the current value."""
        computed = self._computed
        is_current = computed is not None and computed.value.value == self.view
        return super().displayed or (computed if is_current else None)

    @on(ChartView.LimitsChanged)
    def scene_changed(self) -> None:
        """Display the map, and compute it if its inputs or the limits of the plot have changed."""
        super().scene_changed()
        if self._pause is not None:
            self._pause.stop()
        self._pause = self.set_timer(_MAP_DELAY, self._follow)

    def _follow(self) -> None:
        # The bar displays the error of the input, or the status of a map that was read.
        if self._error or super().displayed:
            return
        try:
            if self._current_inputs() != self._inputs:
                self.start_from_inputs()
        except InputError as error:
            self.show_status(str(error))

    def _current_inputs(self) -> object:
        # The map does not depend on the edited values of the mapped parameters.
        axes, scene = self.axes, self.session.scene()
        values = scene.parameters.as_dict().items()
        fixed = [(name, value) for name, value in values if name not in axes]
        points = [(name, axis.tolist()) for name, axis in axes.items()]
        return fixed, points, self.view, scene.separation

    def start_from_inputs(self) -> None:
        """Compute the map; it replaces one that was read."""
        self._inputs = self._current_inputs()
        super().start_from_inputs()
        self.session.studies.pop(self.NAME, None)

    def show_result(self, result: StabilityMap) -> None:
        """Display a computed map."""
        self._computed = DisplayedStudy(result, "")
        self.scene_changed()

    def show_view(self, name: str) -> None:
        """Map another value."""
        super().show_view(name)
        self.toggle_computation()
