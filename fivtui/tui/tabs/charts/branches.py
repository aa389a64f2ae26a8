"""The input of the branches tab, and what its chart points at. Imports no Textual."""

import dataclasses
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from fivtui.orbits import CycleBranch, CyclePoint, sizes_of
from fivtui.ranges import parse_ends
from fivtui.scene import Scene
from fivtui.tui.session import base_scene, plain_names

FloatArray = NDArray[np.float64]

EXAMPLE: Final = "μ=0.2:1"
Origin = Literal["hopf", "cycle"]
# Periods of an orbit that is run.
_PERIODS: Final = 20


def parse_branch(text: str) -> tuple[str, tuple[float, float] | None]:
    """The parameter and its range in text such as ``μ=0.2:1``; the range may be missing."""
    return parse_ends(plain_names(text), EXAMPLE)


def nearest_cycle(result: CycleBranch, x: float, y: float) -> CyclePoint:
    """The limit cycle that is nearest to a point of the chart."""
    values = np.array([point.value for point in result.points])
    heights = np.array([point.half_range for point in result.points])
    sizes = sizes_of(result)
    away = np.hypot((values - x) / sizes[0], (heights - y) / sizes[1])
    return result.points[int(away.argmin())]


def orbit_scene(result: CycleBranch, point: CyclePoint) -> Scene:
    """The scene that begins on a limit cycle of a branch and lasts twenty of its periods."""
    return dataclasses.replace(
        base_scene(),
        parameters=result.parameters.with_values({result.name: point.value}),
        separation=result.separation,
        start=point.start,
        t_end=float(f"{_PERIODS * point.period:.6g}"),
    )
