"""CPU time of a communication step in a host written in C: ``python -m tests.benchmarks.fmu_host``.

Both flavours of the FMU and, beside them, a bouncing ball in C; CPU time, the best of a few. The
Python flavour needs the library of this Python.
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
STEPS: Final = (1e-3, 1e-2)
ROUNDS: Final = 5
# Enough steps that the start of a process is negligible; fewer for steps that take microseconds.
COUNT: Final = 500_000
COUNT_OF_PYTHON: Final = 20_000


class Cost(NamedTuple):
    """CPU time of a step, of a step with five outputs (both ns), and of an instance (µs)."""

    step: float
    read: float
    instance: float


class Timed(NamedTuple):
    """Library, GUID and resources of an FMU, and a library that its host loads first."""

    library: Path
    guid: str
    resources: str = ""
    preload: str = ""


def compiled(folder: Path, name: str, *options: str) -> Path:
    """Compile a C file of this folder to a program or library."""
    target = folder / Path(name).stem
    compiler = shlex.split(os.environ.get("CC", "cc"))
    flags = [str(_HERE / name), f"-I{_HEADERS}", "-O2", "-o", str(target), *options]
    subprocess.run([*compiler, *flags], check=True)
    return target


def cost(host: Path, fmu: Timed, h: float, count: int, rounds: int = ROUNDS) -> Cost:
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


def fmus_in(folder: Path) -> dict[str, Timed]:
    """The FMUs to time, by name."""
    timed = {}
    for flavour in ("native", "python"):
        file = build_fmu(folder / f"{flavour}.fmu", flavour=flavour)
        content = folder / flavour
        fmpy.extract(str(file), str(content))
        preload = _libpython() if flavour == "python" else ""
        if flavour == "native" or preload:
            timed[flavour] = Timed(
                content / "binaries" / "linux64" / "SliderBelt.so",
                fmpy.read_model_description(str(content)).guid,
                (content / "resources").as_uri(),
                preload,
            )
    ball = compiled(folder, "bouncing_ball.c", "-shared", "-fPIC")
    return {"bouncing ball in C": Timed(ball, "ball"), **timed}


def _libpython() -> str:
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
        host = compiled(folder, "fmu_host.c", "-ldl")
        rows = []
        for title, fmu in fmus_in(folder).items():
            for h in STEPS:
                costs = cost(host, fmu, h, COUNT_OF_PYTHON if fmu.preload else COUNT)
                rows.append((title, f"{h:g} s", *(f"{value:.1f}" for value in costs)))
        header = ("FMU", "step", "doStep, ns", "with 5 outputs, ns", "instance, µs")
        print_rows("A host in C", header, rows)


if __name__ == "__main__":
    main()
