"""The slider, its springs, its forces and the belt at a time, as lines in metres."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Course, Mode, friction_force
from fivtui.transient import Trajectory, Transient

FloatArray = NDArray[np.float64]

# A run on a belt that is always faster slides in CONTACT; one on a belt of finite speed slides in
# FORWARD and BACKWARD, or sticks.
MODE_NAMES: Final[Mapping[Mode, str]] = {
    Mode.SEPARATED: "off the belt",
    Mode.CONTACT: "sliding",
    Mode.FORWARD: "sliding forward",
    Mode.BACKWARD: "sliding backward",
    Mode.STICK: "sticking",
}
# Lengths relative to `Layout.size`, the extent of the motion.
_BLOCK_WIDTH: Final = 0.32
_FOOT_HEIGHT: Final = 0.04
_SPRING_LENGTH: Final = 0.4
_SPRING_WIDTH: Final = 0.035
# Least length of the contact spring, which is above the foot.
_CONTACT_SPRING_LENGTH: Final = 0.12
_WALL_LENGTH: Final = 0.24
_MARK_DISTANCE: Final = 0.16
_PRELOAD_ARROW: Final = 0.2
# Length of the arrow of the greatest contact force.
_FORCE_ARROW: Final = 0.4
_ARROW_HEAD: Final = 0.06
_MARGIN: Final = 0.06
# The foot's width relative to that of the block.
_FOOT_WIDTH: Final = 0.8
# Lower limit of the size of a motion, m.
_MIN_SIZE: Final = 1e-30
_SPRING_TURNS: Final = 5


@dataclass(frozen=True, slots=True)
class Shape:
    """A line of a picture through points in metres; NaN is a gap."""

    name: str
    x: FloatArray
    y: FloatArray


@dataclass(frozen=True, slots=True)
class Layout:
    """Sizes and positions that stay the same while the slider moves, m.

    Heights are above the belt. At y = 0 the slider's block is at the height `clearance`; it moves
    to scale by x and y.

    Attributes
    ----------
    size : float
        Extent of the motion, to which the sizes of all shapes are relative.
    clearance : float
        Height of the block's lower edge at y = 0.
    anchor_x : float
        Position of both walls.
    wall_height, slanted_wall_height : float
        Heights of the walls of the horizontal and of the inclined spring.
    x_range, y_range : tuple of float
        Limits of the picture.
    max_force : float
        Greatest contact force, N, which scales the arrows of the forces.
    """

    size: float
    clearance: float
    anchor_x: float
    wall_height: float
    slanted_wall_height: float
    x_range: tuple[float, float]
    y_range: tuple[float, float]
    max_force: float

    @property
    def width(self) -> float:
        """Width of the picture, m."""
        return self.x_range[1] - self.x_range[0]


def layout_of(motion: Trajectory) -> Layout:
    """The layout that shows a whole motion to scale, with x to the right and y upwards."""
    x_min, x_max = float(motion.x.min()), float(motion.x.max())
    y_min, y_max = float(motion.y.min()), float(motion.y.max())
    # The contact spring is drawn longer by the greatest compression, −y_min.
    size = max(x_max - x_min, y_max - y_min, -y_min, _MIN_SIZE)
    half_block, margin = 0.5 * _BLOCK_WIDTH * size, _MARGIN * size
    # The lowest block stays above the foot.
    clearance = 1.1 * max(-y_min, 0.0) + _CONTACT_SPRING_LENGTH * size
    anchor_x = x_min - half_block - _SPRING_LENGTH * size
    slanted_wall_height = max(y_max, 0.0) + clearance + 2.0 * half_block + _SPRING_LENGTH * size
    return Layout(
        size=size,
        clearance=clearance,
        anchor_x=anchor_x,
        wall_height=clearance + half_block,
        slanted_wall_height=slanted_wall_height,
        x_range=(anchor_x - 2.5 * margin, x_max + half_block + (_FORCE_ARROW + _MARGIN) * size),
        y_range=(-3.0 * margin, slanted_wall_height + 2.5 * margin),
        max_force=float(np.abs(motion.P).max()),
    )


def shapes_at(
    run: Transient, layout: Layout, state: Trajectory, belt_travel: float
) -> dict[str, Shape]:
    """The shapes by name at a time, of which `state` is a trajectory with one sample.

    `belt_travel` is the distance that the belt has moved, m.
    """
    size, half_block = layout.size, 0.5 * _BLOCK_WIDTH * layout.size
    x, y, force = float(state.x[0]), float(state.y[0]), float(state.P[0])
    mode = Mode(int(state.mode[0]))
    bottom, top = layout.clearance + y, layout.clearance + y + 2.0 * half_block
    left_x, right_x = x - half_block, x + half_block
    # The contact spring ends in a foot. It is undeformed at y = 0, where the foot touches the belt,
    # and off the belt, where the foot hangs at the height y.
    foot_bottom = y if mode is Mode.SEPARATED else 0.0
    foot_top = foot_bottom + _FOOT_HEIGHT * size
    half_foot = _FOOT_WIDTH * half_block
    spring_width, head = _SPRING_WIDTH * size, _ARROW_HEAD * size
    springs = (
        _spring(
            (layout.anchor_x, layout.wall_height), (left_x, 0.5 * (bottom + top)), spring_width
        ),
        _spring((layout.anchor_x, layout.slanted_wall_height), (left_x, top), spring_width),
    )
    shapes = [
        Shape("belt", *_points((layout.x_range[0], 0.0), (layout.x_range[1], 0.0))),
        _marks(layout, belt_travel),
        _walls(layout),
        Shape("springs", *join_lines(springs)),
        Shape("contact spring", *_spring((x, foot_top), (x, bottom), spring_width)),
        _box("foot", (x - half_foot, x + half_foot), (foot_bottom, foot_top)),
        _box("block", (left_x, right_x), (bottom, top)),
        _arrow("preload", (x, top + _PRELOAD_ARROW * size), (x, top), head),
    ]
    if layout.max_force > 0.0 and mode is not Mode.SEPARATED:
        scale = _FORCE_ARROW * size / layout.max_force
        # The parameters just after the time, some of which may follow tables, and their rates.
        p, rates = Course(run.parameters, run.over_time).after(float(state.t[0]))
        friction = friction_force(p, (x, float(state.vx[0]), y, float(state.vy[0])), mode, rates)
        shapes += [
            _arrow("contact force", (right_x, 0.0), (right_x, scale * force), head),
            _arrow("friction", (right_x, 0.0), (right_x + scale * friction, 0.0), head),
        ]
    return {shape.name: shape for shape in shapes}


def _points(*points: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    x, y = np.array(points).T
    return x, y


def join_lines(
    lines: Sequence[tuple[FloatArray, FloatArray]],
) -> tuple[FloatArray, FloatArray]:
    """The coordinates x and y of several lines as those of one line with gaps of NaN."""
    x, y = (
        np.concatenate([part for line in lines for part in (line[axis], [np.nan])])
        for axis in (0, 1)
    )
    return x[:-1], y[:-1]


def _marks(layout: Layout, belt_travel: float) -> Shape:
    # Slanted strokes below the belt's surface, which move with the belt.
    distance = _MARK_DISTANCE * layout.size
    low, high = layout.x_range
    mark_xs = np.arange(low + belt_travel % distance, high, distance)
    slant = 0.4 * distance
    strokes = [_points((x, 0.0), (x - slant, -2.0 * slant)) for x in mark_xs.tolist()]
    return Shape("marks", *join_lines(strokes))


def _walls(layout: Layout) -> Shape:
    # The wall of the inclined spring is inclined by 45°.
    half = 0.5 * _WALL_LENGTH * layout.size
    x, upright_y, slanted_y = layout.anchor_x, layout.wall_height, layout.slanted_wall_height
    upright = _points((x, upright_y - half), (x, upright_y + half))
    slanted = _points((x - half, slanted_y - half), (x + half, slanted_y + half))
    return Shape("walls", *join_lines([upright, slanted]))


def _spring(
    start: tuple[float, float], end: tuple[float, float], width: float
) -> tuple[FloatArray, FloatArray]:
    # A zigzag with straight ends: its points relative to the length, and across the spring.
    along = np.concatenate([[0.0], np.linspace(0.15, 0.85, 2 * _SPRING_TURNS + 2), [1.0]])
    across = np.array([0.0, 0.0, *([1.0, -1.0] * _SPRING_TURNS), 0.0, 0.0]) * width
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = max(math.hypot(dx, dy), _MIN_SIZE)
    return (
        start[0] + dx * along - dy / length * across,
        start[1] + dy * along + dx / length * across,
    )


def _box(name: str, x_range: tuple[float, float], y_range: tuple[float, float]) -> Shape:
    (start, end), (low, high) = x_range, y_range
    corners = ((start, low), (end, low), (end, high), (start, high), (start, low))
    return Shape(name, *_points(*corners))


def _arrow(name: str, tail: tuple[float, float], tip: tuple[float, float], head: float) -> Shape:
    # A line from tail to tip, with two barbs at the tip; `head` is their length along the line, m.
    dx, dy = tip[0] - tail[0], tip[1] - tail[1]
    length = max(math.hypot(dx, dy), _MIN_SIZE)
    along_x, along_y = dx / length, dy / length
    head = min(head, 0.5 * length)
    base_x, base_y = tip[0] - head * along_x, tip[1] - head * along_y
    left_barb = (base_x - 0.5 * head * along_y, base_y + 0.5 * head * along_x)
    right_barb = (base_x + 0.5 * head * along_y, base_y - 0.5 * head * along_x)
    return Shape(name, *_points(tail, tip, left_barb, tip, right_barb))
