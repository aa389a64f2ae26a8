"""A co-simulation master for slider-belt and brake actuator: ``python examples/fmu_coupled.py``."""

import tempfile
from pathlib import Path
from typing import Any

from fmpy import extract, instantiate_fmu, read_model_description

from fmu_src.build.builder import build_fmu


def initialized_instance(component: str, folder: Path) -> tuple[Any, dict[str, list[int]]]:
    """An initialized instance, and a list with the value reference of each variable by name."""
    fmu = build_fmu(folder / f"{component}.fmu", component=component)
    files = extract(fmu, folder / component)
    description = read_model_description(files)
    instance = instantiate_fmu(files, description)
    instance.setupExperiment(startTime=0.0)
    instance.enterInitializationMode()
    instance.exitInitializationMode()
    return instance, {v.name: [v.valueReference] for v in description.modelVariables}


def coupled(steps: int, t_end: float, *, extrapolate: bool) -> tuple[float, float]:
    """Exchange F and P, held or extrapolated, at each step; y, m, and separations after t_end s."""
    h = t_end / steps
    with tempfile.TemporaryDirectory() as folder:
        slider, i = initialized_instance("slider-belt", Path(folder))
        actuator, j = initialized_instance("brake-actuator", Path(folder))
        outputs = (actuator, j["F"]), (slider, i["P"])
        for step in range(steps):
            (F,), (P,) = actuator.getReal(j["F"]), slider.getReal(i["P"])
            slider.setReal(i["F"], [F]), actuator.setReal(j["P"], [P])
            if extrapolate:
                slopes = [f.getRealOutputDerivatives(r, [1]) for f, r in outputs]
                slider.setRealInputDerivatives(i["F"], [1], slopes[0])
                actuator.setRealInputDerivatives(j["P"], [1], slopes[1])
            slider.doStep(step * h, h), actuator.doStep(step * h, h)
        y, separations = slider.getReal(i["y"] + i["separations"])
        slider.freeInstance(), actuator.freeInstance()
    return y, separations


if __name__ == "__main__":
    for steps in (500, 1000, 2000, 4000):
        (held, _), (y, count) = (coupled(steps, 5.0, extrapolate=flag) for flag in (False, True))
        print(f"{steps} steps: y held {held:.5f}, extrapolated {y:.5f} m, {count:.0f} separations")
