"""A co-simulation master: slider-belt and brake actuator coupled through fmpy, step by step.

Run it as ``python examples/fmu_coupled.py``.
"""

import tempfile
from pathlib import Path
from typing import Any

from fmpy import extract, instantiate_fmu, read_model_description

from fmu_src.build.builder import build_fmu


def initialized_instance(component: str, folder: Path) -> tuple[Any, dict[str, int]]:
    """An initialized instance, and value references by name."""
    files = extract(build_fmu(folder / f"{component}.fmu", component=component), folder / component)
    description = read_model_description(files)
    instance = instantiate_fmu(files, description)
    instance.setupExperiment(startTime=0.0)
    instance.enterInitializationMode()
    instance.exitInitializationMode()
    return instance, {v.name: v.valueReference for v in description.modelVariables}


def main() -> None:
    """Exchange preload and contact force every 10 ms for 20 s."""
    with tempfile.TemporaryDirectory() as folder:
        slider, slider_references = initialized_instance("slider-belt", Path(folder))
        actuator, actuator_references = initialized_instance("brake-actuator", Path(folder))
        for count in range(2000):
            slider.setReal([slider_references["F"]], actuator.getReal([actuator_references["F"]]))
            actuator.setReal([actuator_references["P"]], slider.getReal([slider_references["P"]]))
            slider.doStep(count * 0.01, 0.01)
            actuator.doStep(count * 0.01, 0.01)
        (F,), names = actuator.getReal([actuator_references["F"]]), ("y", "separations")
        y, separations = slider.getReal([slider_references[name] for name in names])
        print(f"after 20 s: F {F:.3f} N, y {y:.5f} m, separations {separations:.0f}")


if __name__ == "__main__":
    main()
