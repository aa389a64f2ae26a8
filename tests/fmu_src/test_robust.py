"""The FMU in bulk and in bare surroundings: many instances, many steps, no packages at all."""

import subprocess
import sys
from pathlib import Path

import fmpy
import pytest

from fmu_src.build.builder import build_fmu
from fmu_src.slave.variables import REFERENCES
from tests.support.fmu_driver import Driver
from tests.support.fmu_tools import interpreted

HOST = Path(__file__).parents[1].joinpath("support", "fmu_bare_host.py")
linux = pytest.mark.skipif(fmpy.platform != "linux64", reason="the bare host is for Linux")


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_fmu(tmp_path_factory.mktemp("fmu") / "slider_belt.fmu")


@pytest.fixture(scope="module")
def extracted(fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("extracted")
    fmpy.extract(str(fmu), str(folder))
    return folder


def bare_run(folder: Path, steps: int) -> tuple[float, list[int]]:
    """y at 5 s and the memory along further steps, in a Python without packages."""
    guid = fmpy.read_model_description(folder).guid
    references = [str(REFERENCES["y"]), str(REFERENCES["F"])]
    done = subprocess.run(
        [sys.executable, "-I", "-S", str(HOST), str(folder), guid, *references, str(steps)],
        cwd="/",
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    y, memory = done.stdout.splitlines()
    return float.fromhex(y), [int(kb) for kb in memory.split()]


def test_a_thousand_instances_live_in_one_process(fmu: Path) -> None:
    with Driver(fmu) as driver:
        ends = driver.drive(("a", "many", 1000))[0].value
    assert set(ends) == {interpreted(t_end=0.1).final.y}
    assert len(ends) == 1000


@linux
def test_it_needs_no_package_and_its_memory_does_not_grow(extracted: Path) -> None:
    y, memory = bare_run(extracted, 100_000)
    assert y == interpreted(t_end=5.0).final.y
    assert memory[-1] - memory[1] < 300


@linux
@pytest.mark.whole
def test_its_memory_does_not_grow_over_a_million_steps(extracted: Path) -> None:
    _, memory = bare_run(extracted, 1_000_000)
    assert memory[-1] - memory[1] < 300


ENDING = """
import atexit, fmpy, sys
asked = []
register = atexit.register
def noting(function, *args, **more):
    asked.append(getattr(function, "__name__", ""))
    return register(function, *args, **more)
atexit.register = noting
for _ in range(2):
    fmpy.simulate_fmu(sys.argv[1], stop_time=0.1)
print(asked.count("finalizePythonInterpreter"))
"""


@linux
def test_the_wrapper_lets_go_of_the_interpreter_before_the_process_ends(fmu: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", ENDING, str(fmu)],
        capture_output=True,
        text=True,
        check=False,
        timeout=300.0,
    )
    # fmpy unpacks the archive anew for every run: two libraries.
    assert (done.stdout, done.returncode) == ("2\n", 0), done.stderr
