"""Compute the outputs that a scene requires."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from fivtui.equilibrium import Stability, stability
from fivtui.model import OnProgress
from fivtui.simulation import compute
from fivtui.transient import OnSamples, Samples

from .scene import Scene
from .verified import SceneTransient, simulate_to

# Rows of a trajectory.
DEFAULT_POINTS: Final = 5001


@dataclass(frozen=True, slots=True)
class SceneResult:
    """The outputs that a scene requires; None for an output that it does not require."""

    stability: Stability | None
    run: SceneTransient | None


def run_scene(
    scene: Scene, *, points: int = DEFAULT_POINTS, progress: OnProgress | None = None
) -> SceneResult:
    """Compute the `outputs` that a scene requires; a trajectory has `points` rows."""
    outputs = set(scene.outputs)
    stability_result = None
    if "stability" in outputs:
        stability_result = stability(scene.parameters, separation=scene.separation)
    run = None
    if outputs & {"transient", "trajectory"}:
        samples: Samples = "none"
        if "trajectory" in outputs:
            samples = np.linspace(0.0, scene.t_end, points)
        run = scene_transient(scene, samples=samples, progress=progress)
    return SceneResult(stability_result, run)


def scene_transient(
    scene: Scene,
    *,
    samples: Samples = "none",
    progress: OnProgress | None = None,
    on_samples: OnSamples | None = None,
    sensitivities: Sequence[str] = (),
) -> SceneTransient:
    """Compute the transient of a scene, to its tolerance or to its error targets."""
    request = scene.request(samples=samples, sensitivities=sensitivities)
    if scene.accuracy:
        verified = simulate_to(
            dict(scene.accuracy), request, progress=progress, on_samples=on_samples
        )
        return SceneTransient(verified.transient, verified)
    return SceneTransient(compute(request, progress=progress, on_samples=on_samples), None)
