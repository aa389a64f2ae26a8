"""What the FMU costs beside FMUs that do nothing: ``python -m tests.benchmarks.fmu``.

The FMUs beside it have the same outputs: one is a pythonfmu slave, the other C, if there is a
compiler. All are driven by fmpy in this process, in turn; times are CPU time, the best of a few.
"""

import shutil
import subprocess
import tempfile
import time
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import fmpy
from pythonfmu import FmuBuilder

from fmu_src.build.builder import build_fmu
from fmu_src.slave.variable import Role
from fmu_src.slave.variables import VARIABLES

STEP: Final = 1e-3
STEPS: Final = 20_000
ROUNDS: Final = 5
OUTPUTS: Final = [v.name for v in VARIABLES if v.role is Role.OUTPUT]

_PYTHON: Final = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class NoOp(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.value = 0.0
        for name in OUTPUTS:
            self.register_variable(
                Real(name, causality=Fmi2Causality.output, getter=lambda: self.value)
            )

    def do_step(self, current_time, step_size):
        return True
"""
_C: Final = """
#include <stddef.h>
static char instance;
void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources,
                      const void *functions, int visible, int logging) { return &instance; }
void fmi2FreeInstance(void *c) {}
int fmi2SetupExperiment(void *c, int has_tolerance, double tolerance, double start, int has_stop,
                        double stop) { return 0; }
int fmi2EnterInitializationMode(void *c) { return 0; }
int fmi2ExitInitializationMode(void *c) { return 0; }
int fmi2Terminate(void *c) { return 0; }
int fmi2DoStep(void *c, double t, double h, int no_set) { return 0; }
int fmi2GetReal(void *c, const unsigned *references, size_t count, double *values) {
    for (size_t i = 0; i < count; i++) values[i] = 0.0;
    return 0;
}
#define ABSENT(name) int fmi2##name(void) { return 3; }
"""
# What a host looks for and never calls here.
_ABSENT: Final = (
    *("CancelStep", "Reset", "GetTypesPlatform", "GetVersion", "SetDebugLogging"),
    *("SetReal", "GetInteger", "SetInteger", "GetBoolean", "SetBoolean", "GetString", "SetString"),
    *("GetFMUstate", "SetFMUstate", "FreeFMUstate", "GetDirectionalDerivative"),
    *("SerializedFMUstateSize", "SerializeFMUstate", "DeSerializeFMUstate"),
    *("SetRealInputDerivatives", "GetRealOutputDerivatives", "GetStatus", "GetRealStatus"),
    *("GetIntegerStatus", "GetBooleanStatus", "GetStringStatus"),
)


def python_no_op(folder: Path) -> Path:
    """A pythonfmu FMU with the outputs of the slider-belt and a `do_step` that does nothing."""
    script = folder / "no_op.py"
    script.write_text(_PYTHON.replace("OUTPUTS", repr(OUTPUTS)))
    target = folder / "no_op.fmu"
    return Path(FmuBuilder.build_FMU(script, dest=target, needsExecutionTool="false"))


def c_no_op(folder: Path, python: Path) -> Path | None:
    """The same FMU with a binary made from C; None without a compiler."""
    compiler = shutil.which("cc")
    if compiler is None or fmpy.platform != "linux64":
        return None
    source, library, target = folder / "no_op.c", folder / "NoOp.so", folder / "c_no_op.fmu"
    source.write_text(_C + "".join(f"ABSENT({name})\n" for name in _ABSENT))
    command = [compiler, "-O2", "-shared", "-fPIC", "-o", str(library), str(source)]
    subprocess.run(command, check=True)
    with zipfile.ZipFile(python) as old, zipfile.ZipFile(target, "w") as new:
        new.writestr("modelDescription.xml", old.read("modelDescription.xml"))
        new.write(library, "binaries/linux64/NoOp.so")
    return target


@contextmanager
def instance(fmu: Path) -> Iterator[Any]:
    """An initialized instance."""
    folder = fmpy.extract(fmu)
    slave = fmpy.instantiate_fmu(folder, fmpy.read_model_description(folder, validate=False))
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    try:
        yield slave
    finally:
        slave.terminate()
        slave.freeInstance()
        shutil.rmtree(folder)


def cost_of_a_step(fmu: Path) -> float:
    """CPU seconds of one `do_step` of 1 ms, over 20 s."""
    with instance(fmu) as slave:
        do_step = slave.doStep
        begin = time.process_time()
        for count in range(STEPS):
            do_step(count * STEP, STEP)
        return (time.process_time() - begin) / STEPS


def cost_of_a_simulation(fmu: Path) -> float:
    """CPU seconds of fmpy's `simulate_fmu` over 100 s at 0.01 s, all outputs recorded."""
    folder = fmpy.extract(fmu)
    description = fmpy.read_model_description(folder, validate=False)
    begin = time.process_time()
    result = fmpy.simulate_fmu(
        folder,
        model_description=description,
        stop_time=100.0,
        output_interval=0.01,
        validate=False,
    )
    taken = time.process_time() - begin
    assert result.size == 10_001
    shutil.rmtree(folder)
    return taken


def best_of(
    measure: Callable[[Path], float], fmus: Mapping[str, Path], rounds: int = ROUNDS
) -> dict[str, float]:
    """The least of several measurements of each FMU, made in turn."""
    return {
        name: min(taken)
        for name, taken in zip(
            fmus,
            zip(*([measure(fmu) for fmu in fmus.values()] for _ in range(rounds)), strict=True),
            strict=True,
        )
    }


def main() -> None:
    """Print the costs, and their ratio to those of the no-op in Python."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        fmus = {"slider-belt": build_fmu(folder / "slider_belt.fmu")}
        fmus["no-op, pythonfmu"] = python_no_op(folder)
        native = c_no_op(folder, fmus["no-op, pythonfmu"])
        if native is None:
            print("no C compiler: no C FMU beside them")
        else:
            fmus["no-op, C"] = native
        for title, measure, unit, scale in (
            ("do_step of 1 ms, base scene", cost_of_a_step, "µs", 1e6),
            ("simulate_fmu, 100 s at 0.01 s", cost_of_a_simulation, "ms", 1e3),
        ):
            print(title)
            costs = best_of(measure, fmus)
            for fmu, cost in costs.items():
                ratio = cost / costs["no-op, pythonfmu"]
                print(f"  {fmu:18}{cost * scale:9.2f} {unit}{ratio:8.2f} times the no-op")


if __name__ == "__main__":
    main()
