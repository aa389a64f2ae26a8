"""A co-simulation of slider-belt and actuator in fmpy: the reference for co-simulation tools."""

import shutil
from pathlib import Path
from typing import Any

import fmpy

# y and P of the slider-belt and F of the actuator at the end of every communication step.
Row = tuple[float, float, float]


def _instance(fmu: Path) -> tuple[str, Any, dict[str, int]]:
    # The folder of an extracted FMU, its instance, and its value references by variable name.
    folder = fmpy.extract(str(fmu))
    description = fmpy.read_model_description(folder)
    instance = fmpy.instantiate_fmu(folder, description)
    instance.setupExperiment(startTime=0.0)
    instance.enterInitializationMode()
    instance.exitInitializationMode()
    return folder, instance, {v.name: v.valueReference for v in description.modelVariables}


def run_coupled(
    slider_belt: Path, actuator: Path, *, steps: int, h: float, first: Row | None = None
) -> list[Row]:
    """Step both FMUs in parallel by `h` s, and exchange preload and contact force after every step.

    P and F of `first` are the inputs of the first step, by default the outputs at the start; its y
    is not used.
    """
    slider_folder, slider_fmi, slider_references = _instance(slider_belt)
    actuator_folder, actuator_fmi, actuator_references = _instance(actuator)
    (force,), (preload,) = (
        slider_fmi.getReal([slider_references["P"]]),
        actuator_fmi.getReal([actuator_references["F"]]),
    )
    if first is not None:
        _, force, preload = first
    rows = []
    for step_index in range(steps):
        slider_fmi.setReal([slider_references["F"]], [preload])
        actuator_fmi.setReal([actuator_references["P"]], [force])
        slider_fmi.doStep(step_index * h, h)
        actuator_fmi.doStep(step_index * h, h)
        y, force = slider_fmi.getReal([slider_references["y"], slider_references["P"]])
        (preload,) = actuator_fmi.getReal([actuator_references["F"]])
        rows.append((y, force, preload))
    for instance, folder in ((slider_fmi, slider_folder), (actuator_fmi, actuator_folder)):
        instance.terminate()
        instance.freeInstance()
        shutil.rmtree(folder)
    return rows
