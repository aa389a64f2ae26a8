"""Computed signals of a run, with their derivatives by parameters and components of the start."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import (
    ALL_PARAMETERS,
    DERIVATIVE_STEP,
    Progress,
    spring_force,
    static_start,
    static_start_change,
)
from fivtui.scene import Scene
from fivtui.taylor import Seed
from fivtui.transient import START_SPECS, Request, compute_variation

Floats = NDArray[np.float64]

# Tolerance of the runs; their derivatives are about as accurate as the motion.
_TOL: Final = 1e-11
# Limit of the steps of a run; stiffnesses that need more do not fit measured signals.
_MAX_STEPS: Final = 100_000
_STATE_INDEX: Final = {"x": 0, "vx": 1, "y": 2, "vy": 3}
_START_INDEX: Final = {name: index for index, name in enumerate(START_SPECS)}


def scene_at(scene: Scene, values: Mapping[str, float]) -> Scene:
    """The scene with values of parameters and of components of the start, by name."""
    scene = scene.with_values({n: value for n, value in values.items() if n in ALL_PARAMETERS})
    if values.keys().isdisjoint(_START_INDEX):
        return scene
    start = static_start(scene.system) if isinstance(scene.start, str) else scene.start
    x, vx, y, vy = (values.get(name, start[index]) for name, index in _START_INDEX.items())
    return replace(scene, start=(x, vx, y, vy))


def compute_signals(
    scene: Scene,
    values: Mapping[str, float],
    t: Floats,
    quantities: Sequence[str],
    work: Progress,
) -> tuple[Floats, Floats]:
    """Signals of a run at times t, shape (n, s), and their derivatives by `values`, (n, s, u).

    The run has the `values` of parameters and of components of the start, by name.
    """
    run_scene = scene_at(scene, values)
    seeds = [_seed(run_scene, name, values if scene.start == "static" else None) for name in values]
    request = Request(run_scene.system, float(t[-1]), _TOL, run_scene.start, max_steps=_MAX_STEPS)
    samples = compute_variation(request, seeds, work, t).samples
    states, changes = samples[:, 0], samples[:, 1:]
    signals = np.empty((t.size, len(quantities)))
    slopes = np.empty((t.size, len(quantities), len(values)))
    for column, quantity in enumerate(quantities):
        if quantity != "P":
            signals[:, column] = states[:, _STATE_INDEX[quantity]]
            slopes[:, column] = changes[:, :, _STATE_INDEX[quantity]]
            continue
        p, y = run_scene.parameters, states[:, _STATE_INDEX["y"]]
        is_off = (y > 0.0) & scene.separation
        signals[:, column] = np.where(is_off, 0.0, spring_force(p, y))
        for index, name in enumerate(values):
            perturbed = p.perturbed({name: 1.0})
            complex_y = y + 1j * DERIVATIVE_STEP * changes[:, index, _STATE_INDEX["y"]]
            slope = spring_force(perturbed, complex_y).imag / DERIVATIVE_STEP
            slopes[:, column, index] = np.where(is_off, 0.0, slope)
    return signals, slopes


def _seed(scene: Scene, name: str, static_without: Collection[str] | None) -> Seed:
    # The change of start and parameters by a name. A static start changes with parameters, but for
    # the components in `static_without`; it is None for a start in numbers.
    if name in _START_INDEX:
        x, vx, y, vy = (float(component == name) for component in _START_INDEX)
        return Seed((x, vx, y, vy), {})
    if static_without is None:
        return Seed((0.0, 0.0, 0.0, 0.0), {name: 1.0})
    changes = zip(_START_INDEX, static_start_change(scene.system, name), strict=True)
    x, vx, y, vy = (0.0 if component in static_without else change for component, change in changes)
    return Seed((x, vx, y, vy), {name: 1.0})
