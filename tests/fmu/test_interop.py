"""Every host that couples slider-belt and brake actuator computes the same motion."""

import csv
import json
import os
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from importlib.util import find_spec
from pathlib import Path

import fmpy
import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd

from fivtui.model.errors import InputError
from fmu_src.build.builder import NATIVE, PYTHON
from fmu_src.build.ssp import build_ssp
from tests.support.fmu_coupling import Row, run_coupled
from tests.support.fmu_hosts import CHANGE, HOSTS, OUTPUTS, START, TUNED_HOSTS
from tests.support.fmu_instance import FmuInstance

# Number and length (s) of the communication steps.
STEPS, H = 500, 0.01
# The Python package of each host. A host of HOSTS with the suffix `_ssp` reads `brake.ssp`.
PACKAGES = {
    "libcosim": "libcosimpy",
    "ecos": "ecospy",
    "container": "fmu_manipulation_toolbox",
}
# Date of the archive, s since 1970.
DATE = "1000000000"
# Folder of the shared libraries in the Python environment.
LIBRARIES = f"{sys.prefix}/lib"


@pytest.fixture(scope="module", params=[PYTHON, NATIVE])
def flavour(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    return name


@pytest.fixture(scope="module")
def folder(flavour: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("system")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SOURCE_DATE_EPOCH", DATE)
        build_ssp(folder / "brake.ssp", flavour=flavour)
    with zipfile.ZipFile(folder / "brake.ssp") as archive:
        for name in ("slider_belt", "brake_actuator"):
            (folder / f"{name}.fmu").write_bytes(archive.read(f"resources/{name}.fmu"))
    return folder


@pytest.fixture(scope="module")
def reference_rows(folder: Path) -> list[Row]:
    # Both FMUs, stepped by a loop in Python that exchanges their outputs.
    return run_coupled(folder / "slider_belt.fmu", folder / "brake_actuator.fmu", steps=STEPS, h=H)


def test_the_coupled_fmus_vibrate_and_the_preload_reacts_to_the_contact_force(
    reference_rows: list[Row],
) -> None:
    preloads = [preload for _, _, preload in reference_rows]
    assert preloads[0] == pytest.approx(80.0, abs=1.0)
    assert max(preloads) > 82.0
    assert min(force for _, force, _ in reference_rows) == 0.0


@pytest.mark.host
@pytest.mark.parametrize("host", [host.__name__ for host in HOSTS])
def test_a_host_agrees_with_the_reference(
    host: str, folder: Path, reference_rows: list[Row], tmp_path: Path
) -> None:
    assert_same(run_host(host, folder, tmp_path), reference_rows)


@pytest.mark.host
@pytest.mark.parametrize("host", [host.__name__ for host in TUNED_HOSTS])
def test_a_host_reverses_the_belt_tunes_and_reads_totals_as_fmpy_does(
    host: str, folder: Path, tmp_path: Path
) -> None:
    extracted = fmpy.extract(str(folder / "slider_belt.fmu"), str(tmp_path / "extracted"))
    with FmuInstance(Path(extracted)) as instance:
        instance.begin(finite_belt=True, **START)
        expected = []
        for step in range(STEPS):
            if step == STEPS // 2:
                instance.set(**CHANGE)
            instance.step(H)
            y, P_max, sticks = instance.get(*OUTPUTS)
            expected.append((y, P_max, sticks))
    assert expected[-1][-1] > 1
    assert_same(run_host(host, folder, tmp_path), expected)


def run_host(host: str, folder: Path, tmp_path: Path) -> list[Row]:
    """Run a host of `fmu_hosts.py` in a process of its own."""
    package = PACKAGES[host.removesuffix("_ssp").removesuffix("_tuned")]
    if find_spec(package) is None:
        pytest.skip(f"{package} is not installed (extra interop)")
    script = Path(__file__).parents[1].joinpath("support", "fmu_hosts.py")
    for file in ("brake.ssp", "slider_belt.fmu", "brake_actuator.fmu"):
        shutil.copy(folder / file, tmp_path)
    process = subprocess.run(
        [sys.executable, "-I", str(script), host, str(tmp_path), str(STEPS), str(H)],
        cwd=tmp_path,
        # ecos uses TBB, whose thread manager may be unloaded while still at work at process exit.
        env=os.environ | {"LD_LIBRARY_PATH": LIBRARIES, "TCM_ENABLE": "0"},
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
    )
    assert process.returncode == 0, process.stderr[-2000:]
    rows: list[Row] = json.loads(process.stdout.splitlines()[-1])
    return rows


def assert_same(results: list[Row], expected: list[Row], abs_error: float = 1e-9) -> None:
    # Hosts sum up the time with different rounding.
    assert len(results) == len(expected)
    for actual_row, expected_row in zip(results, expected, strict=True):
        assert actual_row == pytest.approx(expected_row, rel=1e-9, abs=abs_error)


@pytest.mark.host
def test_the_host_ecos_in_c_plus_plus_agrees_with_the_reference(
    flavour: str, folder: Path, reference_rows: list[Row], tmp_path: Path
) -> None:
    if sys.platform != "linux":
        pytest.skip("the test runs on Linux only")
    if find_spec("ecospy") is None:
        pytest.skip("ecospy, whose package has ecos as a program, is not installed (extra interop)")
    library = Path(sysconfig.get_config_var("LIBDIR")) / f"libpython3.{sys.version_info.minor}.so"
    if flavour == PYTHON and not library.exists():
        pytest.skip(f"this Python has no shared library {library}")
    spec = find_spec("ecospy")
    assert spec is not None
    assert spec.submodule_search_locations is not None
    program = tmp_path / "ecos"
    shutil.copy(Path(spec.submodule_search_locations[0]) / "binaries" / "ecos", program)
    program.chmod(0o755)
    command = [str(program), "simulate", "--path", str(folder / "brake.ssp")]
    command += ["--stopTime", str(STEPS * H), "--stepSize", str(H)]
    environment = os.environ | {"LD_LIBRARY_PATH": LIBRARIES}
    if flavour == PYTHON:
        # The program has no Python, which the FMU needs.
        environment["LD_PRELOAD"] = str(library)
    subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, check=True)
    with (tmp_path / "brake.csv").open() as file:
        table = list(csv.DictReader(file, skipinitialspace=True))
    names = ("slider_belt::y[REAL]", "slider_belt::P[REAL]", "brake_actuator::F[REAL]")
    outputs = [tuple(float(row[name]) for name in names) for row in table]
    # The program writes six decimals.
    assert_same([(y, P, F) for y, P, F in outputs[-STEPS:]], reference_rows, abs_error=1e-6)


def test_fmpy_runs_the_archive_with_inputs_of_zero_in_the_first_step(folder: Path) -> None:
    # The stop time is between two steps: rounding does not change their number.
    run = simulate_ssp(str(folder / "brake.ssp"), stop_time=1.0 - 0.5 * H, step_size=H)
    fmus = (folder / "slider_belt.fmu", folder / "brake_actuator.fmu")
    # A row of y, P and F: the inputs P and F of the first step are zero.
    zero_row = (0.0, 0.0, 0.0)
    expected = run_coupled(*fmus, steps=run.size, h=H, first=zero_row)
    names = ("slider_belt.y", "slider_belt.P", "brake_actuator.F")
    columns = (run[name].tolist() for name in names)
    assert_same(list(zip(*columns, strict=True)), expected)


def test_the_archive_follows_the_standard_and_its_bytes_are_reproducible(
    flavour: str, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", DATE)
    system = read_ssd(str(folder / "brake.ssp"), validate=True).system
    assert [element.name for element in system.elements] == ["brake_actuator", "slider_belt"]
    for element in system.elements:
        description = fmpy.read_model_description(folder / f"{element.name}.fmu")
        causalities = {v.name: v.causality for v in description.modelVariables}
        assert all(causalities[c.name] == c.kind for c in element.connectors)
    rebuilt_archive = build_ssp(tmp_path / "rebuilt.ssp", flavour=flavour)
    assert rebuilt_archive.read_bytes() == (folder / "brake.ssp").read_bytes()


def test_a_target_without_the_suffix_of_an_archive_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"\.ssp"):
        build_ssp(tmp_path / "brake.fmu")
