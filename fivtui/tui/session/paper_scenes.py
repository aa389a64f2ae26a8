"""A scene for each of the paper's figures, to begin with. Imports no Textual."""

import dataclasses
from collections.abc import Iterator

from fivtui.model.parameters import PARAMETERS
from fivtui.paper.families import PANELS, SEPARATION
from fivtui.scene.scene import Scene


def paper_scenes() -> Iterator[tuple[Scene, str]]:
    """A scene a figure: of its lines the one that is nearest to the base set.

    Yields
    ------
    scene : Scene
        Named after the figure or its panel, such as ``fig-13``; what varies along the line has the
        value of the base set.
    caption : str
        What the figure shows.
    """
    for key, panel in PANELS.items():
        distances = [_distance(panel.by, line.scene) for line in panel.lines]
        scene = panel.lines[distances.index(min(distances))].scene
        yield dataclasses.replace(scene, name=f"fig-{key}", description=""), panel.caption


def _distance(by: str, scene: Scene) -> float:
    if by == SEPARATION:
        return float(not scene.separation)
    return abs(scene.parameters.as_dict()[by] - PARAMETERS[by].default)
