"""Every host computes the same motion, coupled with the brake actuator or alone.

Programs such as fmusim (of Reference-FMUs) and OMSimulator are tested where PATH has them.
"""

import csv
import itertools
import json
import os
import runpy
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import fmpy
import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd

from fivtui import Parameters, simulate
from fivtui.model import Mode
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


# Flavours and versions of FMI. libcosim, and fmpy for coupled FMUs, do not support FMI 3.0.
VARIANTS = ((PYTHON, "2"), (NATIVE, "2"), (NATIVE, "3"))
with_fmi_2 = pytest.mark.parametrize("variant", VARIANTS[:2], indirect=True)


@pytest.fixture(scope="module", params=VARIANTS)
def variant(request: pytest.FixtureRequest) -> tuple[str, str]:
    flavour, fmi = request.param
    return flavour, fmi


@pytest.fixture(scope="module")
def flavour(variant: tuple[str, str]) -> str:
    return variant[0]


@pytest.fixture(scope="module")
def folder(variant: tuple[str, str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_system(tmp_path_factory.mktemp("system"), *variant)


@pytest.fixture(scope="module")
def reference_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_system(tmp_path_factory.mktemp("reference"), NATIVE, "2")


def build_system(folder: Path, flavour: str, fmi: str) -> Path:
    """Write `brake.ssp` and its two FMUs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SOURCE_DATE_EPOCH", DATE)
        build_ssp(folder / "brake.ssp", flavour=flavour, fmi=fmi)
    with zipfile.ZipFile(folder / "brake.ssp") as archive:
        for name in ("slider_belt", "brake_actuator"):
            (folder / f"{name}.fmu").write_bytes(archive.read(f"resources/{name}.fmu"))
    return folder


def fmus_in(folder: Path) -> tuple[Path, Path]:
    return folder / "slider_belt.fmu", folder / "brake_actuator.fmu"


@pytest.fixture(scope="module")
def reference_rows(reference_folder: Path) -> list[Row]:
    # Both native FMUs, stepped by a loop in Python that exchanges their outputs.
    return run_coupled(*fmus_in(reference_folder), steps=STEPS, h=H)


@pytest.fixture(scope="module")
def tuned_rows(reference_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Row]:
    # OUTPUTS of the native slider-belt, whose belt runs backward and whose k1 changes.
    extracted = tmp_path_factory.mktemp("extracted")
    fmpy.extract(str(reference_folder / "slider_belt.fmu"), str(extracted))
    rows = []
    with FmuInstance(extracted) as instance:
        instance.begin(finite_belt=True, **START)
        for step in range(STEPS):
            if step == STEPS // 2:
                instance.set(**CHANGE)
            instance.step(H)
            y, P_max, sticks = instance.get(*OUTPUTS)
            rows.append((y, P_max, sticks))
    assert rows[-1][-1] > 1
    return rows


def test_the_coupled_fmus_vibrate_and_the_preload_reacts_to_the_contact_force(
    reference_rows: list[Row],
) -> None:
    preloads = [preload for _, _, preload in reference_rows]
    assert preloads[0] == pytest.approx(80.0, abs=1.0)
    assert max(preloads) > 82.0
    assert min(force for _, force, _ in reference_rows) == 0.0


def variants_and_hosts(hosts: Sequence[Callable[..., object]]) -> list[tuple[Any, str]]:
    names = [host.__name__ for host in hosts]
    return [(v, name) for v in VARIANTS for name in names if v[1] == "2" or "libcosim" not in name]


@pytest.mark.host
@pytest.mark.parametrize(("variant", "host"), variants_and_hosts(HOSTS), indirect=["variant"])
def test_a_host_agrees_with_the_reference(
    host: str, folder: Path, reference_rows: list[Row], tmp_path: Path
) -> None:
    assert_same(run_host(host, folder, tmp_path), reference_rows)


@pytest.mark.host
@pytest.mark.parametrize(("variant", "host"), variants_and_hosts(TUNED_HOSTS), indirect=["variant"])
def test_a_host_reverses_the_belt_tunes_and_reads_totals_as_fmpy_does(
    host: str, folder: Path, tuned_rows: list[Row], tmp_path: Path
) -> None:
    assert_same(run_host(host, folder, tmp_path), tuned_rows)


@pytest.mark.host
def test_fmusim_reverses_the_belt_tunes_and_reads_totals_as_fmpy_does(
    flavour: str, folder: Path, tuned_rows: list[Row], tmp_path: Path
) -> None:
    t_end, values = STEPS * H, {"k1": Parameters().k1} | START
    inputs = [(t_end * part, values) for part in (0.0, 0.5)]
    inputs += [(t_end * part, CHANGE) for part in (0.5, 1.0)]
    with (tmp_path / "inputs.csv").open("w") as file:
        writer = csv.writer(file)
        writer.writerow(["time", *CHANGE])
        writer.writerows([t, *(row[name] for name in CHANGE)] for t, row in inputs)
    options: list[tuple[object, ...]] = [("--interface-type", "cs"), ("--output-interval", H)]
    options += [("--stop-time", t_end), ("--input-file", "inputs.csv")]
    options += [("--output-file", "result.csv")]
    options += [("--start-value", name, v) for name, v in [("finite_belt", "true"), *START.items()]]
    options += [("--output-variable", name) for name in OUTPUTS]
    arguments = (*itertools.chain(*options), folder / "slider_belt.fmu")
    _, *rows = run_program("fmusim", flavour, tmp_path, *arguments)
    assert_same([(row["y"], row["P_max"], row["sticks"]) for row in rows], tuned_rows)


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


def run_program(
    name: str, flavour: str, folder: Path, *arguments: object
) -> list[dict[str, float]]:
    """Rows of the table `result.csv` that a program of PATH writes."""
    if shutil.which(name) is None:
        pytest.skip(f"there is no {name}")
    process = subprocess.run(
        [name, *map(str, arguments)],
        cwd=folder,
        env=program_environment(flavour),
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, (process.stdout + process.stderr)[-2000:]
    assert "error:" not in process.stdout
    with (folder / "result.csv").open() as file:
        table = csv.DictReader(file)
        return [{name: float(value) for name, value in row.items()} for row in table]


def run_omsimulator(flavour: str, folder: Path, *arguments: object) -> dict[str, float]:
    """The last values of all variables."""
    options = ("--resultFile=result.csv", "--stripRoot=true")
    return run_program("OMSimulator", flavour, folder, *options, *arguments)[-1]


@pytest.mark.host
@pytest.mark.parametrize("ports", [False, True])
def test_omsimulator_agrees_with_the_reference(
    ports: bool, variant: tuple[str, str], reference_folder: Path, tmp_path: Path
) -> None:
    flavour, fmi = variant
    archive = build_ssp(tmp_path / "brake.ssp", flavour=flavour, fmi=fmi, ports=ports)
    end = run_omsimulator(flavour, tmp_path, "--stopTime=1", archive)
    # The archive sets steps of 1 ms.
    *_, expected = run_coupled(*fmus_in(reference_folder), steps=1000, h=1e-3)
    values = tuple(end[name] for name in ("slider_belt.y", "slider_belt.P", "brake_actuator.F"))
    # The file has twelve digits.
    assert values == pytest.approx(expected, rel=1e-11)
    if ports:
        assert end["y"] == end["slider_belt.y"]


@pytest.mark.host
def test_omsimulator_reads_totals_counts_and_the_mode(
    variant: tuple[str, str], folder: Path, tmp_path: Path
) -> None:
    flavour, _ = variant
    fmu = folder / "slider_belt.fmu"
    options = ("--mode=cs", "--stopTime=21", "--stepSize=0.01")
    end = run_omsimulator(flavour, tmp_path, *options, fmu)
    run = simulate(t_end=21.0, samples=[21.0])
    assert run.trajectory is not None
    values = [end[name] for name in ("y", "y_peak", "P_max", "separations", "mode_enumeration")]
    expected = [run.final.y, run.peak.y_abs, run.contact_force.max, run.events.separations]
    # In contact: the mode off the belt is 0, as is the value of an output that is not read.
    (mode,) = run.trajectory.mode
    assert mode == Mode.CONTACT
    expected.append(mode)
    assert values == pytest.approx(expected, rel=1e-11)


@pytest.mark.host
def test_omsimulator_extrapolates_by_output_derivatives(tmp_path: Path) -> None:
    archive = build_ssp(tmp_path / "brake.ssp")
    options = ("--stopTime=1", "--inputExtrapolation=true")
    y = run_omsimulator(NATIVE, tmp_path, *options, archive)["slider_belt.y"]
    coupled = runpy.run_path(str(Path(__file__).parents[2] / "examples/fmu_coupled.py"))["coupled"]
    (held, _), (extrapolated, _) = (coupled(1000, 1.0, extrapolate=flag) for flag in (False, True))
    assert abs(y - extrapolated) < 0.05 * abs(held - extrapolated)


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


@with_fmi_2
def test_fmpy_runs_the_archive_with_inputs_of_zero_in_the_first_step(folder: Path) -> None:
    # The stop time is between two steps: rounding does not change their number.
    run = simulate_ssp(str(folder / "brake.ssp"), stop_time=1.0 - 0.5 * H, step_size=H)
    # A row of y, P and F: the inputs P and F of the first step are zero.
    zero_row = (0.0, 0.0, 0.0)
    expected = run_coupled(*fmus_in(folder), steps=run.size, h=H, first=zero_row)
    names = ("slider_belt.y", "slider_belt.P", "brake_actuator.F")
    columns = (run[name].tolist() for name in names)
    assert_same(list(zip(*columns, strict=True)), expected)


def test_the_archive_follows_the_standard_and_its_bytes_are_reproducible(
    variant: tuple[str, str], folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", DATE)
    assert_valid(folder / "brake.ssp", folder)
    flavour, fmi = variant
    rebuilt_archive = build_ssp(tmp_path / "rebuilt.ssp", flavour=flavour, fmi=fmi)
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


@with_fmi_2
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
