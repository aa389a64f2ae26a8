"""The slider on the belt as a chart."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from fivtui.charts import STRONG, Chart, Trace
from fivtui.model import Mode
from fivtui.signals import motion_at
from fivtui.transient import Transient

from .shapes import MODE_NAMES, Layout, Shape, join_lines, shapes_at
from .timing import Timing

# By trace: the role of its colour, and the shapes that form it.
_TRACES: Final[Mapping[str, tuple[str, tuple[str, ...]]]] = {
    "belt": ("belt", ("belt", "marks", "walls")),
    "springs": ("reference", ("springs", "contact spring")),
    "slider": (STRONG, ("block", "foot")),
    "preload": ("series-2", ("preload",)),
    "contact force": ("series-1", ("contact force",)),
    "friction": ("friction", ("friction",)),
}
# Character of the slider by mode; in other modes it slides.
_MODE_MARKS: Final = {Mode.SEPARATED: "○", Mode.STICK: "■"}
_SLIDING_MARK: Final = "▬"


def belt_chart(run: Transient, layout: Layout, timing: Timing, t: float, aspect: float) -> Chart:
    """The slider on the belt at a time, s, to scale; `aspect` is the plot's width over height."""
    x_range, y_range = _fit_aspect(layout.x_range, layout.y_range, aspect)
    state = motion_at(run, np.array([t]))
    mode = Mode(int(state.mode[0]))
    shapes = shapes_at(run, layout, state, timing.belt_travel(run, t, layout.width))
    traces = tuple(
        _trace(
            name,
            colour,
            [shapes[shape_name] for shape_name in shape_names],
            _MODE_MARKS.get(mode, _SLIDING_MARK),
        )
        for name, (colour, shape_names) in _TRACES.items()
        # The shapes of a trace exist together: those of belt forces only in contact.
        if shape_names[0] in shapes
    )
    note = f"{t:.5g} s, {MODE_NAMES[mode]}, ×{timing.speed:.3g}"
    return Chart(
        "x (m)",
        "height (m)",
        traces,
        note=note,
        x_range=x_range,
        y_range=y_range,
        to_scale=True,
    )


def _trace(name: str, colour: str, shapes: list[Shape], slider_mark: str) -> Trace:
    # Not ordered: outlines, in which y is not a function of x.
    x, y = join_lines([(shape.x, shape.y) for shape in shapes])
    mark = slider_mark if name == "slider" else ""
    return Trace(name, x, y, ordered=False, mark=mark, colour=colour)


def _fit_aspect(
    x_range: tuple[float, float], y_range: tuple[float, float], aspect: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    # Expand one of the ranges to the aspect ratio.
    width, height = x_range[1] - x_range[0], y_range[1] - y_range[0]
    extra_width, extra_height = max(aspect * height - width, 0.0), max(width / aspect - height, 0.0)
    x_start = x_range[0] - 0.5 * extra_width
    return (x_start, x_start + width + extra_width), (y_range[0], y_range[1] + extra_height)
