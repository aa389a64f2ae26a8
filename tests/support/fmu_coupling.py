"""The scripted reference master for other hosts: slider-belt and actuator through fmpy."""

import shutil
from pathlib import Path
from typing import Any

import fmpy

# y and P of the slider-belt and F of the actuator at the end of every communication step.
Row = tuple[float, float, float]


def _instance(fmu: Path) -> tuple[str, Any, dict[str, int]]:
    folder = fmpy.extract(str(fmu))
    description = fmpy.read_model_description(folder)
    instance = fmpy.instantiate_fmu(folder, description)
    instance.setupExperiment(startTime=0.0)
    instance.enterInitializationMode()
    instance.exitInitializationMode()
    return folder, instance, {v.name: v.valueReference for v in description.modelVariables}


def coupled(
    slider_belt: Path, actuator: Path, *, steps: int, h: float, first: Row | None = None
) -> list[Row]:
    """Step both in parallel and exchange preload and contact force in between.

    `first` has the inputs of the first step; by default they are the outputs at the start.
    """
    s_folder, s, s_names = _instance(slider_belt)
    a_folder, a, a_names = _instance(actuator)
    (force,), (preload,) = s.getReal([s_names["P"]]), a.getReal([a_names["F"]])
    if first is not None:
        _, force, preload = first
    rows = []
    for count in range(steps):
        s.setReal([s_names["F"]], [preload])
        a.setReal([a_names["P"]], [force])
        s.doStep(count * h, h)
        a.doStep(count * h, h)
        y, force = s.getReal([s_names["y"], s_names["P"]])
        (preload,) = a.getReal([a_names["F"]])
        rows.append((y, force, preload))
    for instance, folder in ((s, s_folder), (a, a_folder)):
        instance.terminate()
        instance.freeInstance()
        shutil.rmtree(folder)
    return rows
