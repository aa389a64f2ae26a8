"""A short run of any FMU, as a program of its own: the FMU may crash its process.

``python -m fivtui.fmu.probe FILE`` prints the problems of the FMU as JSON.
"""

import json
import math
import sys
from pathlib import Path
from typing import Any, Final

import numpy as np

from fivtui.model import ComputationError, InputError

from .instance import FmuFile, create_instance, extract_fmu, has_binary

# Communication steps of each run, and those of the default experiment if it has no step size.
_STEPS: Final = 10
_DEFAULT_STEPS: Final = 100


def find_problems(path: Path) -> list[str]:
    """Run an FMU for a few steps, and describe each problem in one line."""
    import fmpy

    with extract_fmu(path) as fmu:
        if not has_binary(fmu):
            return [f"there is no binary for this platform, {fmpy.platform}"]
        start, step = _start_and_step(fmu)
        stop = start + _STEPS * step
        first_run, second_run = (
            fmpy.simulate_fmu(
                fmu.folder, start_time=start, stop_time=stop, output_interval=step, validate=False
            )
            for _ in range(2)
        )
        problems = []
        end = first_run["time"][-1]
        if not math.isclose(end, stop, rel_tol=1e-9, abs_tol=1e-12):
            problems.append(f"the run ends at {end:g} s instead of {stop:g} s")
        for name in first_run.dtype.names:
            if not np.all(np.isfinite(first_run[name])):
                problems.append(f"the output {name} is not finite")
            elif not np.array_equal(first_run[name], second_run[name]):
                problems.append(f"the output {name} differs between two equal runs")
        interface = fmu.description.coSimulation
        if not problems and interface is not None and interface.canGetAndSetFMUstate:
            problems += _find_state_problems(fmu, start, step)
        return problems


def _start_and_step(fmu: FmuFile) -> tuple[float, float]:
    default, interface = fmu.description.defaultExperiment, fmu.description.coSimulation
    start = float(getattr(default, "startTime", None) or 0.0)
    stop = float(getattr(default, "stopTime", None) or start + 1.0)
    step = getattr(interface, "fixedInternalStepSize", None) or getattr(default, "stepSize", None)
    return start, float(step or (stop - start) / _DEFAULT_STEPS)


def _find_state_problems(fmu: FmuFile, start: float, step: float) -> list[str]:
    with create_instance(fmu) as (instance, _):
        _initialize(fmu, instance, start)
        _take_steps(instance, start, step)
        saved_state = instance.getFMUState()
        end = start + _STEPS * step
        _take_steps(instance, end, step)
        outputs = _read_outputs(fmu, instance)
        instance.setFMUState(saved_state)
        _take_steps(instance, end, step)
        restored = _read_outputs(fmu, instance)
        instance.freeFMUState(saved_state)
        instance.terminate()
    return [] if outputs == restored else ["continuing from a saved state gives other outputs"]


def _initialize(fmu: FmuFile, instance: Any, start: float) -> None:
    if fmu.description.fmiVersion == "2.0":
        instance.setupExperiment(startTime=start)
        instance.enterInitializationMode()
    else:
        instance.enterInitializationMode(startTime=start)
    instance.exitInitializationMode()


def _take_steps(instance: Any, start: float, step: float) -> None:
    for count in range(_STEPS):
        instance.doStep(start + count * step, step)


def _read_outputs(fmu: FmuFile, instance: Any) -> list[float]:
    real_type = "Real" if fmu.description.fmiVersion == "2.0" else "Float64"
    references = [
        v.valueReference
        for v in fmu.description.modelVariables
        if v.type == real_type and v.causality == "output" and not v.shape
    ]
    values: list[float] = getattr(instance, f"get{real_type}")(references)
    return values


def main() -> None:
    """Print the problems of the FMU given on the command line as the last line of output."""
    try:
        problems = find_problems(Path(sys.argv[1]))
    except (InputError, ComputationError) as error:
        problems = [str(error)]
    except Exception as error:  # noqa: BLE001
        problems = [f"the run fails: {' '.join(str(error).split())}"]
    print(json.dumps(problems))  # noqa: T201


if __name__ == "__main__":
    main()
