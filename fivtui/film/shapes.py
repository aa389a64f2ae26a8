"""The slider, its springs, its forces and the belt at a time, as lines in metres."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Mode, build_course, friction_force
from fivtui.transient import Trajectory, Transient

FloatArray = NDArray[np.float64]

MODE_NAMES: Final[Mapping[Mode, str]] = {
    Mode.SEPARATED: "off the belt",
    Mode.CONTACT: "sliding",
    Mode.FORWARD: "sliding forward",
    Mode.BACKWARD: "sliding backward",
    Mode.STICK: "sticking",
}
# Sizes relative to the extent of the motion: block, foot, springs, marks on the belt, arrows.
_BLOCK: Final = 0.32
_FOOT: Final = 0.04
_SPRING_LENGTH: Final = 0.4
_MARK_DISTANCE: Final = 0.16
_PRELOAD_ARROW: Final = 0.2
_ARROW: Final = 0.4
_HEAD: Final = 0.06
_MARGIN: Final = 0.06
# Lower limit of the size of a motion, m.
_LEAST_SIZE: Final = 1e-30
_TURNS: Final = 5


@dataclass(frozen=True, slots=True)
class Shape:
    """A line of a picture."""

    name: str
    x: FloatArray
    y: FloatArray


@dataclass(frozen=True, slots=True)
class Layout:
    """Sizes and positions that stay the same while the slider moves, m; `force` is in N."""

    size: float
    free: float
    anchor_x: float
    anchor_y: float
    middle: float
    x_range: tuple[float, float]
    y_range: tuple[float, float]
    force: float


def layout_of(motion: Trajectory) -> Layout:
    """The layout that shows a whole motion to scale, with x to the right and y upwards."""
    x_min, x_max = float(motion.x.min()), float(motion.x.max())
    y_min, y_max = float(motion.y.min()), float(motion.y.max())
    size = max(x_max - x_min, y_max - y_min, -y_min, _LEAST_SIZE)
    half, edge = 0.5 * _BLOCK * size, _MARGIN * size
    free = 1.1 * max(-y_min, 0.0) + 0.12 * size
    anchor_x = x_min - half - _SPRING_LENGTH * size
    anchor_y = max(y_max, 0.0) + free + 2.0 * half + _SPRING_LENGTH * size
    return Layout(
        size,
        free,
        anchor_x,
        anchor_y,
        free + half,
        (anchor_x - 2.5 * edge, x_max + half + (_ARROW + _MARGIN) * size),
        (-3.0 * edge, anchor_y + 2.5 * edge),
        float(np.abs(motion.P).max()),
    )


def shapes_at(run: Transient, layout: Layout, state: Trajectory, travel: float) -> list[Shape]:
    """The shapes at a time."""
    size, half = layout.size, 0.5 * _BLOCK * layout.size
    x, y, force = float(state.x[0]), float(state.y[0]), float(state.P[0])
    mode = Mode(int(state.mode[0]))
    bottom, top = layout.free + y, layout.free + y + 2.0 * half
    # The contact spring ends in a foot, which hangs above the belt while the slider is off it.
    foot_bottom = y if mode is Mode.SEPARATED else 0.0
    foot_top = foot_bottom + _FOOT * size
    spring_width = 0.035 * size
    springs = (
        _spring((layout.anchor_x, layout.middle), (x - half, 0.5 * (bottom + top)), spring_width),
        _spring((layout.anchor_x, layout.anchor_y), (x - half, top), spring_width),
    )
    shapes = [
        Shape("belt", *_points((layout.x_range[0], 0.0), (layout.x_range[1], 0.0))),
        _marks(layout, travel),
        _walls(layout),
        Shape("springs", *_join(springs)),
        Shape("contact spring", *_spring((x, foot_top), (x, bottom), spring_width)),
        _box("foot", (x - 0.8 * half, x + 0.8 * half), (foot_bottom, foot_top)),
        _box("block", (x - half, x + half), (bottom, top)),
        _arrow("preload", (x, top + _PRELOAD_ARROW * size), (x, top), _HEAD * size),
    ]
    if layout.force > 0.0 and mode is not Mode.SEPARATED:
        scale = _ARROW * size / layout.force
        p, rates = build_course(run.parameters, run.over_time).after(float(state.t[0]))
        friction = friction_force(p, (x, float(state.vx[0]), y, float(state.vy[0])), mode, rates)
        right = x + half
        shapes += [
            _arrow("contact force", (right, 0.0), (right, scale * force), _HEAD * size),
            _arrow("friction", (right, 0.0), (right + scale * friction, 0.0), _HEAD * size),
        ]
    return shapes


def _points(*points: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    x, y = np.array(points).T
    return x, y


def _join(
    lines: Sequence[tuple[FloatArray, FloatArray]],
) -> tuple[FloatArray, FloatArray]:
    # Join lines into one, with gaps between them.
    x, y = (
        np.concatenate([part for line in lines for part in (line[axis], [np.nan])])
        for axis in (0, 1)
    )
    return x[:-1], y[:-1]


def _marks(layout: Layout, travel: float) -> Shape:
    # Strokes on the belt, which move with it.
    distance = _MARK_DISTANCE * layout.size
    low, high = layout.x_range
    mark_xs = np.arange(low + travel % distance, high, distance)
    slant = 0.4 * distance
    strokes = [_points((x, 0.0), (x - slant, -2.0 * slant)) for x in mark_xs.tolist()]
    return Shape("marks", *_join(strokes))


def _walls(layout: Layout) -> Shape:
    reach = 0.12 * layout.size
    x, upright_y, slanted_y = layout.anchor_x, layout.middle, layout.anchor_y
    upright = _points((x, upright_y - reach), (x, upright_y + reach))
    slanted = _points((x - reach, slanted_y - reach), (x + reach, slanted_y + reach))
    return Shape("walls", *_join([upright, slanted]))


def _spring(
    start: tuple[float, float], end: tuple[float, float], width: float
) -> tuple[FloatArray, FloatArray]:
    along = np.concatenate([[0.0], np.linspace(0.15, 0.85, 2 * _TURNS + 2), [1.0]])
    across = np.array([0.0, 0.0, *([1.0, -1.0] * _TURNS), 0.0, 0.0]) * width
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = max(math.hypot(dx, dy), _LEAST_SIZE)
    return (
        start[0] + dx * along - dy / length * across,
        start[1] + dy * along + dx / length * across,
    )


def _box(name: str, x_range: tuple[float, float], y_range: tuple[float, float]) -> Shape:
    (start, end), (low, high) = x_range, y_range
    edge = ((start, low), (end, low), (end, high), (start, high), (start, low))
    return Shape(name, *_points(*edge))


def _arrow(name: str, tail: tuple[float, float], tip: tuple[float, float], head: float) -> Shape:
    dx, dy = tip[0] - tail[0], tip[1] - tail[1]
    length = max(math.hypot(dx, dy), _LEAST_SIZE)
    along, head = (dx / length, dy / length), min(head, 0.5 * length)
    back = (tip[0] - head * along[0], tip[1] - head * along[1])
    side = (0.5 * head * along[1], 0.5 * head * along[0])
    return Shape(
        name,
        *_points(
            tail,
            tip,
            (back[0] - side[0], back[1] + side[1]),
            tip,
            (back[0] + side[0], back[1] - side[1]),
        ),
    )
