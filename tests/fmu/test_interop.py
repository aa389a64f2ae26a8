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
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree as ET

import fmpy
import numpy as np
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


def program_environment(flavour: str) -> dict[str, str]:
    """The environment of a host that is a program for Linux without Python."""
    if sys.platform != "linux":
        pytest.skip("the test runs on Linux only")
    environment = os.environ | {"LD_LIBRARY_PATH": LIBRARIES}
    if flavour == PYTHON:
        name = f"libpython3.{sys.version_info.minor}.so"
        library = Path(sysconfig.get_config_var("LIBDIR")) / name
        if not library.exists():
            pytest.skip(f"this Python has no shared library {library}")
        environment["LD_PRELOAD"] = str(library)
    return environment


@pytest.mark.host
@pytest.mark.parametrize("ports", [False, True])
def test_omsimulator_agrees_with_the_reference(
    ports: bool, flavour: str, folder: Path, tmp_path: Path
) -> None:
    program = shutil.which("OMSimulator")
    if program is None:
        pytest.skip("there is no OMSimulator")
    environment = program_environment(flavour)
    archive = build_ssp(tmp_path / "brake.ssp", flavour=flavour, ports=ports)
    command = [program, "--stopTime=1", "--resultFile=result.csv", str(archive)]
    subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, check=True)
    with (tmp_path / "result.csv").open() as file:
        *_, end = csv.DictReader(file)
    # The archive sets steps of 1 ms.
    fmus = (folder / "slider_belt.fmu", folder / "brake_actuator.fmu")
    *_, expected = run_coupled(*fmus, steps=1000, h=1e-3)
    names = ("slider_belt.y", "slider_belt.P", "brake_actuator.F")
    y, P, F = (float(end[f"brake.brake.{name}"]) for name in names)
    # The file has twelve digits.
    assert (y, P, F) == pytest.approx(expected, rel=1e-11)
    if ports:
        assert float(end["brake.brake.y"]) == y


@pytest.mark.host
def test_the_host_ecos_in_c_plus_plus_agrees_with_the_reference(
    flavour: str, folder: Path, reference_rows: list[Row], tmp_path: Path
) -> None:
    if find_spec("ecospy") is None:
        pytest.skip("ecospy, whose package has ecos as a program, is not installed (extra interop)")
    environment = program_environment(flavour)
    spec = find_spec("ecospy")
    assert spec is not None
    assert spec.submodule_search_locations is not None
    program = tmp_path / "ecos"
    shutil.copy(Path(spec.submodule_search_locations[0]) / "binaries" / "ecos", program)
    program.chmod(0o755)
    command = [str(program), "simulate", "--path", str(folder / "brake.ssp")]
    command += ["--stopTime", str(STEPS * H), "--stepSize", str(H)]
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
    assert_valid(folder / "brake.ssp", folder)
    rebuilt_archive = build_ssp(tmp_path / "rebuilt.ssp", flavour=flavour)
    assert rebuilt_archive.read_bytes() == (folder / "brake.ssp").read_bytes()


def assert_valid(archive: Path, folder: Path) -> None:
    """Check an archive by its schema, and its connectors by the FMUs and connections."""
    system = read_ssd(str(archive), validate=True).system
    assert [element.name for element in system.elements] == ["brake_actuator", "slider_belt"]
    # Kinds by element, None for the system, and name.
    connectors: dict[tuple[str | None, str], str] = {
        (None, c.name): c.kind for c in system.connectors
    }
    for element in system.elements:
        description = fmpy.read_model_description(folder / f"{element.name}.fmu")
        causalities = {v.name: v.causality for v in description.modelVariables}
        assert all(causalities[c.name] == c.kind for c in element.connectors)
        connectors |= {(element.name, c.name): c.kind for c in element.connectors}
    for c in system.connections:
        source = c.startElement, c.startConnector
        target = c.endElement, c.endConnector
        assert connectors[source] == ("input" if source[0] is None else "output")
        assert connectors[target] == ("output" if target[0] is None else "input")
    targets = {(c.endElement, c.endConnector) for c in system.connections}
    inputs = {c for c, kind in connectors.items() if kind == "input" and c[0] is not None}
    assert inputs <= targets


def test_fmpy_runs_a_system_with_ports(flavour: str, folder: Path, tmp_path: Path) -> None:
    archive = build_ssp(tmp_path / "brake.ssp", flavour=flavour, ports=True)
    assert_valid(archive, folder)
    values = {"command": 90.0, "mu": 0.5, "v_belt": 1.0}
    inputs = {name: lambda _, value=value: value for name, value in values.items()}
    run = simulate_ssp(str(archive), stop_time=0.2 - 0.5 * H, step_size=H, input=inputs)
    for name, element in (("y", "slider_belt"), ("x_peak", "slider_belt"), ("F", "brake_actuator")):
        assert np.array_equal(run[name], run[f"{element}.{name}"])
    # The inputs reach the FMUs after the first step.
    assert run["friction_slider"][1:] == pytest.approx(0.5 * run["P"][1:], rel=1e-12)
    tau, gain = 0.05, 0.1
    F, P = run["F"], run["P"]
    target = 90.0 + gain * (90.0 - P[1:-1])
    assert F[2:] == pytest.approx(target + (F[1:-1] - target) * np.exp(-H / tau), rel=1e-12)


@pytest.mark.parametrize("ports", [False, True])
def test_the_archive_has_units_and_the_master_of_omsimulator(ports: bool, tmp_path: Path) -> None:
    path = build_ssp(tmp_path / "brake.ssp", ports=ports)
    with zipfile.ZipFile(path) as archive:
        root = ET.fromstring(archive.read("SystemStructure.ssd"))
        fmu = archive.read("resources/slider_belt.fmu")
    units = {v.name: v.unit for v in fmpy.read_model_description(BytesIO(fmu)).modelVariables}
    uri = "{http://ssp-standard.org/SSP1/SystemStructure"
    declared = {unit.get("name") for unit in root.iter(f"{uri}Common}}Unit")}
    slider = root.find(f".//{uri}Description}}Component[@name='slider_belt']")
    assert slider is not None
    for connector in slider.iter(f"{uri}Description}}Connector"):
        unit = connector[0].get("unit")
        assert unit == units[connector.get("name")]
        assert unit is None or unit in declared
    masters = [e for e in root.iter() if e.tag.endswith("}FixedStepMaster")]
    assert [master.get("description") for master in masters] == ["oms-ma"]


def test_a_target_without_the_suffix_of_an_archive_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"\.ssp"):
        build_ssp(tmp_path / "brake.fmu")
