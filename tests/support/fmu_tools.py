"""FMUs for tests: modified copies, and an FMU of another project."""

import zipfile
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Final

from pythonfmu import FmuBuilder

from fivtui import build_fmu, simulate

# Runs with the interpreted kernel, which Python FMUs contain.
simulate_interpreted: Final = partial(simulate, kernel="interpreted")
build_python_fmu: Final = partial(build_fmu, flavour="python")

_ACCUMULATOR = """
from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real


class Accumulator(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.rate, self.total, self.count, self.on, self.gain = 1.0, 0.0, 0, True, 2
        inputs = {"causality": Fmi2Causality.input}
        outputs = {"causality": Fmi2Causality.output}
        discrete = {"variability": Fmi2Variability.discrete}
        self.register_variable(Real("rate", **inputs))
        self.register_variable(Boolean("on", **inputs, **discrete))
        self.register_variable(Integer("gain", **inputs, **discrete))
        self.register_variable(Real("total", **outputs))
        self.register_variable(Integer("count", **outputs, **discrete))

    def do_step(self, current_time, step_size):
        BEHAVIOUR
        if self.on:
            self.total += self.gain * self.rate * step_size
        self.count += 1
        return True
"""


def modified_copy(fmu: Path, target: Path, changes: Mapping[str, bytes | None]) -> Path:
    """Copy an FMU with changed file contents; None removes a file."""
    with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(target, "w") as copy:
        contents: dict[str, bytes | None] = {n: source.read(n) for n in source.namelist()}
        for name, content in {**contents, **changes}.items():
            if content is not None:
                copy.writestr(name, content)
    return target


def build_accumulator(folder: Path, behaviour: str = "pass") -> Path:
    """Build an FMU with Real, Integer and Boolean variables; `do_step` begins with `behaviour`."""
    script = folder / f"accumulator_{abs(hash(behaviour))}.py"
    script.write_text(_ACCUMULATOR.replace("BEHAVIOUR", behaviour))
    return Path(
        FmuBuilder.build_FMU(script, dest=folder / "accumulator.fmu", needsExecutionTool="false")
    )
