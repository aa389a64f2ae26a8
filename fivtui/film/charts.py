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
    moment = motion_at(run, np.array([t]))
    mode = Mode(int(moment.mode[0]))
    travel = timing.travel(run, t, layout.x_range[1] - layout.x_range[0])
    shapes = {shape.name: shape for shape in shapes_at(run, layout, moment, travel)}
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


def _trace(name: str, shapes: list[Shape], foot: str) -> Trace:
    parts = [part for shape in shapes for part in (shape, None)][:-1]
    gap = np.array([np.nan])
    x = np.concatenate([gap if part is None else part.x for part in parts])
    y = np.concatenate([gap if part is None else part.y for part in parts])
    return Trace(name, x, y, ordered=False, mark=foot if name == "slider" else "")


def _fit_aspect(
    across: tuple[float, float], up: tuple[float, float], aspect: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    # Expand the ranges to the aspect ratio.
    width, height = across[1] - across[0], up[1] - up[0]
    wider, higher = max(aspect * height - width, 0.0), max(width / aspect - height, 0.0)
    start = across[0] - 0.5 * wider
    return (start, start + width + wider), (up[0], up[1] + higher)
