"""CPU time of a communication step in a host written in C: ``python -m tests.benchmarks.fmu_host``.

Times both flavours of the FMU and, for comparison, a bouncing ball in C; the least of several CPU
times counts. The Python flavour needs a shared library of this Python.
"""

import os
import shlex
import shutil
import subprocess
import sysconfig
import tempfile
from pathlib import Path
from typing import Final, NamedTuple

import fmpy

from fivtui.console.printing import print_rows
from fmu_src.build.builder import build_fmu

_HERE: Final = Path(__file__).parent
_HEADERS: Final = Path(fmpy.__file__).parent / "c-code"
STEP_SIZES: Final = (1e-3, 1e-2)
ROUNDS: Final = 5
# Enough steps that the start of a process is negligible; fewer for steps that take microseconds.
STEP_COUNT: Final = 500_000
PYTHON_STEP_COUNT: Final = 20_000


class Cost(NamedTuple):
    """CPU time of a step and of a step with five outputs, ns, and of an instance, µs."""

    step: float
    read: float
    instance: float


class TimedFmu(NamedTuple):
    """An FMU, a library that its host loads first, and the number of steps to take."""

    library: Path
    guid: str
    resources: str = ""
    preload: str = ""
    step_count: int = STEP_COUNT


def compile_c(folder: Path, name: str, *options: str) -> Path:
    """Compile a C file of this folder to a program or library."""
    target = folder / Path(name).stem
    compiler = shlex.split(os.environ.get("CC", "cc"))
    flags = [str(_HERE / name), f"-I{_HEADERS}", "-O2", "-o", str(target), *options]
    subprocess.run([*compiler, *flags], check=True)
    return target


def measure_cost(host: Path, fmu: TimedFmu, h: float, count: int, rounds: int = ROUNDS) -> Cost:
    """The minimum over several measurements."""
    command = [host, fmu.library, fmu.guid, fmu.resources, h, count]
    environment = os.environ | ({"LD_PRELOAD": fmu.preload} if fmu.preload else {})
    costs = []
    for _ in range(rounds):
        process = subprocess.run(
            [str(argument) for argument in command],
            env=environment,
            check=True,
            capture_output=True,
            text=True,
        )
        costs.append(Cost(*map(float, process.stdout.split())))
    return Cost(*map(min, zip(*costs, strict=True)))


def build_fmus(folder: Path) -> dict[str, TimedFmu]:
    """The FMUs to time, by name."""
    timed = {}
    for flavour in ("native", "python"):
        file = build_fmu(folder / f"{flavour}.fmu", flavour=flavour)
        content = folder / flavour
        fmpy.extract(str(file), str(content))
        preload = _find_libpython() if flavour == "python" else ""
        if flavour == "native" or preload:
            timed[flavour] = TimedFmu(
                content / "binaries" / "linux64" / "SliderBelt.so",
                fmpy.read_model_description(str(content)).guid,
                (content / "resources").as_uri(),
                preload,
                PYTHON_STEP_COUNT if flavour == "python" else STEP_COUNT,
            )
    ball = compile_c(folder, "bouncing_ball.c", "-shared", "-fPIC")
    return {"bouncing ball in C": TimedFmu(ball, "ball"), **timed}


def _find_libpython() -> str:
    names = [sysconfig.get_config_var(name) for name in ("INSTSONAME", "LDLIBRARY")]
    for name in filter(None, names):
        path = Path(str(sysconfig.get_config_var("LIBDIR"))) / str(name)
        if path.suffix != ".a" and path.is_file():
            return str(path)
    return ""


def main() -> None:
    """Print the costs."""
    if shutil.which("cc") is None or fmpy.platform != "linux64":
        raise SystemExit("the host is for Linux, and needs a compiler")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        host = compile_c(folder, "fmu_host.c", "-ldl")
        rows = []
        for title, fmu in build_fmus(folder).items():
            for h in STEP_SIZES:
                costs = measure_cost(host, fmu, h, fmu.step_count)
                rows.append((title, f"{h:g} s", *(f"{value:.1f}" for value in costs)))
        header = ("FMU", "step", "doStep, ns", "with 5 outputs, ns", "instance, µs")
        print_rows("A host in C", header, rows)


if __name__ == "__main__":
    main()
