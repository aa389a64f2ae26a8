"""The FMU with many instances, many steps, and in a Python without any packages."""

import json
import os
import subprocess
import sys
from pathlib import Path

import fmpy
import pytest

from fmu_src.slave.variables import REFERENCES
from tests.support.fmu_driver import Driver
from tests.support.fmu_tools import simulate_interpreted

HOST = Path(__file__).parents[1].joinpath("support", "fmu_bare_host.py")
# Greatest growth of the memory over many steps, kB.
MAX_GROWTH_KB = 300
linux = pytest.mark.skipif(fmpy.platform != "linux64", reason="the bare host is for Linux")


@pytest.fixture(scope="module")
def extracted(fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("extracted")
    fmpy.extract(str(fmu), str(folder))
    return folder


def bare_run(folder: Path, steps: int) -> tuple[float, int]:
    """y at 5 s, and the memory growth over further steps, kB, in a Python without packages."""
    guid = fmpy.read_model_description(folder).guid
    references = [str(REFERENCES["y"]), str(REFERENCES["F"])]
    process = subprocess.run(
        [sys.executable, "-I", "-S", str(HOST), str(folder), guid, *references, str(steps)],
        cwd="/",
        capture_output=True,
        text=True,
        check=False,
    )
    assert (process.returncode, process.stderr) == (0, "")
    y, memory = process.stdout.splitlines()
    # The memory after each tenth of the steps; growth counts from the second one on.
    memory_kb = [int(kb) for kb in memory.split()]
    return float.fromhex(y), memory_kb[-1] - memory_kb[1]


@pytest.mark.parametrize("count", [200, pytest.param(1000, marks=pytest.mark.whole)])
def test_many_instances_live_in_one_process(fmu: Path, count: int) -> None:
    with Driver(fmu) as driver:
        # Each instance makes one step to 0.1 s.
        (answer,) = driver.drive(("a", "many", count))
    assert answer.value == [simulate_interpreted(t_end=0.1).final.y] * count


@linux
def test_the_fmu_needs_no_package_and_its_memory_does_not_grow(extracted: Path) -> None:
    y, growth_kb = bare_run(extracted, 100_000)
    assert y == simulate_interpreted(t_end=5.0).final.y
    assert growth_kb < MAX_GROWTH_KB


@linux
@pytest.mark.whole
def test_the_memory_does_not_grow_over_a_million_steps(extracted: Path) -> None:
    _, growth_kb = bare_run(extracted, 1_000_000)
    assert growth_kb < MAX_GROWTH_KB


EXIT_SCRIPT = """
import atexit, ctypes, json, sys
import fmpy

released = []
look_up = ctypes.CDLL.__getattr__

def record_release(library, name):
    function = look_up(library, name)
    if name == "finalizePythonInterpreter":
        released.append(library._name)
    return function

def loaded():
    with open("/proc/self/maps") as maps:
        paths = {line.split()[5] for line in maps if "/" in line}
    return sorted(path for path in paths if path.endswith("/SliderBelt.so"))

# The first instance of the FMU registers the release of its libraries at exit. This report, which
# is registered before, comes after the release.
atexit.register(lambda: print(json.dumps([counts, loaded(), sorted(released)])))
# To release a library, the FMU looks up its function `finalizePythonInterpreter` by ctypes.
ctypes.CDLL.__getattr__ = record_release
counts = []
for _ in range(12):
    fmpy.simulate_fmu(sys.argv[1], stop_time=0.1)
    counts.append(len(loaded()))
folder = fmpy.extract(sys.argv[1], sys.argv[2])
unreleased = fmpy.instantiate_fmu(folder, fmpy.read_model_description(folder))
"""


@linux
def test_the_wrapper_is_unloaded_by_its_host_or_released_before_the_process_ends(
    fmu: Path, tmp_path: Path
) -> None:
    # The host loads libraries by the path of the extracted files, even through a symbolic link.
    tmp_path.joinpath("real").mkdir()
    tmp_path.joinpath("link").symlink_to(tmp_path / "real")
    process = subprocess.run(
        [sys.executable, "-c", EXIT_SCRIPT, str(fmu), str(tmp_path / "instance")],
        env={**os.environ, "TMPDIR": str(tmp_path / "link")},
        capture_output=True,
        text=True,
        check=False,
        timeout=300.0,
    )
    assert process.returncode == 0, process.stderr
    counts, loaded, released = json.loads(process.stdout)
    # fmpy extracts the archive anew for every run. The linker may keep the first library loaded, as
    # its definitions of symbols that are unique in a process (C++) serve all later copies.
    assert set(counts) <= {0, 1}
    assert str(tmp_path / "instance" / "binaries" / "linux64" / "SliderBelt.so") in loaded
    assert sorted(map(os.path.realpath, released)) == loaded
