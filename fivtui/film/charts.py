"""The slider on the belt as a chart."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from fivtui.charts import Chart, Trace
from fivtui.model import Mode
from fivtui.signals import motion_at
from fivtui.transient import Transient

from .shapes import MODE_NAMES, Layout, Shape, shapes_at
from .timing import Timing

# Names of the shapes by trace.
_TRACES: Final[Mapping[str, tuple[str, ...]]] = {
    "belt": ("belt", "marks", "walls"),
    "springs": ("springs", "contact spring"),
    "slider": ("block", "foot"),
    "preload": ("preload",),
    "contact force": ("contact force",),
    "friction": ("friction",),
}
_FOOT_MARKS: Final = {Mode.SEPARATED: "○", Mode.STICK: "■"}
_SLIDING_MARK: Final = "▬"


def belt_chart(run: Transient, layout: Layout, timing: Timing, t: float, aspect: float) -> Chart:
    """The slider on the belt at a time, s, to scale in a plot of width over height `aspect`."""
    x_range, y_range = _fit_aspect(layout.x_range, layout.y_range, aspect)
    state = motion_at(run, np.array([t]))
    mode = Mode(int(state.mode[0]))
    travel = timing.travel(run, t, layout.x_range[1] - layout.x_range[0])
    shapes = {shape.name: shape for shape in shapes_at(run, layout, state, travel)}
    traces = tuple(
        _trace(name, [shapes[part] for part in parts], _FOOT_MARKS.get(mode, _SLIDING_MARK))
        for name, parts in _TRACES.items()
        if parts[0] in shapes
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


def _trace(name: str, shapes: list[Shape], foot_mark: str) -> Trace:
    parts = [part for shape in shapes for part in (shape, None)][:-1]
    gap = np.array([np.nan])
    x = np.concatenate([gap if part is None else part.x for part in parts])
    y = np.concatenate([gap if part is None else part.y for part in parts])
    return Trace(name, x, y, ordered=False, mark=foot_mark if name == "slider" else "")


def _fit_aspect(
    x_range: tuple[float, float], y_range: tuple[float, float], aspect: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    # Expand one of the ranges to the aspect ratio.
    width, height = x_range[1] - x_range[0], y_range[1] - y_range[0]
    extra_width, extra_height = max(aspect * height - width, 0.0), max(width / aspect - height, 0.0)
    x_start = x_range[0] - 0.5 * extra_width
    return (x_start, x_start + width + extra_width), (y_range[0], y_range[1] + extra_height)
