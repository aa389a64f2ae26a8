"""Scenes of the paper's figures. Imports no Textual."""

import dataclasses
from collections.abc import Iterator

from fivtui.model import PARAMETERS
from fivtui.paper import PANELS, SEPARATION
from fivtui.scene import Scene


def paper_scenes() -> Iterator[tuple[Scene, str]]:
    """Each figure's scene nearest to the default parameters, and the figure's caption."""
    for key, panel in PANELS.items():
        distances = [_distance(panel.by, line.scene) for line in panel.lines]
        scene = panel.lines[distances.index(min(distances))].scene
        yield dataclasses.replace(scene, name=f"fig-{key}", description=""), panel.caption


def _distance(parameter: str, scene: Scene) -> float:
    if parameter == SEPARATION:
        return float(not scene.separation)
    return abs(scene.parameters.as_dict()[parameter] - PARAMETERS[parameter].default)
