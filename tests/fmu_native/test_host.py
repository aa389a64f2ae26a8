"""The native FMU in processes without Python, and its C sources under invalid and random calls.

The tests need programs of this machine (`host`). Only `pytest -m whole` runs those marked `whole`.
"""

import os
import runpy
import shutil
import subprocess
import sys
import zipfile
from importlib.util import find_spec
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu

from fivtui import simulate
from fmu_src.build.builder import build_fmu
from fmu_src.build.c_sources import NATIVE, model_guid, sources
from fmu_src.build.components import COMPONENTS
from fmu_src.slave.actuator_variables import ACTUATOR_TABLE
from fmu_src.slave.variables import REFERENCES, SLIDER_BELT_TABLE
from tests.support.fmu_instance import FmuInstance

pytestmark = [
    pytest.mark.host,
    pytest.mark.skipif(fmpy.platform != "linux64", reason="the hosts in C run on Linux only"),
]
ROOT = Path(__file__).parents[2]
HEADERS = Path(fmpy.__file__).parent / "c-code"
# Fused multiply-add would change the bits of a run.
OPTIONS = ("-std=c11", "-Wall", "-Wno-psabi", "-ffp-contract=off", f"-I{HEADERS}")


@pytest.fixture(scope="module")
def compiler() -> list[str]:
    """The command of a C compiler."""
    if shutil.which("cc") is not None:
        return ["cc"]
    if find_spec("ziglang") is not None:
        return [sys.executable, "-m", "ziglang", "cc"]
    pytest.skip("there is no compiler")


def compile_program(program: Path, compiler: list[str], *arguments: str) -> Path:
    process = subprocess.run(
        [*compiler, *OPTIONS, *arguments, "-o", str(program)],
        capture_output=True,
        text=True,
        check=False,
    )
    if process.returncode != 0 and "libasan" in process.stderr:
        pytest.skip("the compiler has no sanitizers")
    assert (process.returncode, process.stderr) == (0, "")
    return program


def compile_attack(folder: Path, compiler: list[str], *arguments: str) -> Path:
    """Compile the FMU's sources with attack.c, which makes invalid and random calls."""
    for name, text in sources("SliderBelt").items():
        folder.joinpath(name).write_text(text, encoding="utf-8")
    source_files = [str(path) for path in folder.glob("*.c")]
    attack = str(Path(__file__).with_name("attack.c"))
    # Low limits of internal steps, and of parts of a communication step, end each attack early.
    flags = [
        f"-I{folder}",
        "-DMAX_STEPS=3000",
        "-DMAX_PARTS=3000",
        *arguments,
        *source_files,
        attack,
        "-lm",
    ]
    return compile_program(folder / "attack", compiler, *flags)


def run_without_python(program: Path, *arguments: object) -> str:
    environment = {name: value for name, value in os.environ.items() if "PYTHON" not in name}
    process = subprocess.run(
        [str(program), *map(str, arguments)],
        env=environment,
        cwd=program.parent,
        capture_output=True,
        text=True,
        check=False,
        timeout=600.0,
    )
    assert (process.returncode, process.stderr) == (0, "")
    return process.stdout


def test_a_host_in_c_gets_the_native_bits_without_python(
    folder: Path, compiler: list[str], tmp_path: Path
) -> None:
    source = ROOT / "examples" / "host.c"
    # The example must stay short enough to read.
    assert len(source.read_text(encoding="utf-8").splitlines()) <= 75
    program = compile_program(tmp_path / "host", compiler, str(source), "-ldl")
    libraries = subprocess.run(["ldd", str(program)], capture_output=True, text=True, check=False)
    assert "python" not in libraries.stdout
    native = simulate(t_end=100.0, kernel="compiled")
    output = run_without_python(program, folder)
    assert output == f"y = {native.final.y:.17g} m, separations: {native.events.separations}\n"
    # The page of the manual shows this output.
    assert output in (ROOT / "docs" / "how-to" / "fmu-in-c.md").read_text(encoding="utf-8")
    # Without an FMU the host says why it ends.
    for arguments, message in ((), "usage: "), ((tmp_path,), "modelDescription.xml: "):
        command = [str(program), *map(str, arguments)]
        process = subprocess.run(command, capture_output=True, text=True, check=False)
        assert process.returncode == 1
        assert message in process.stderr


def test_the_library_calls_its_own_functions_where_its_host_has_the_same_names(
    folder: Path, compiler: list[str], tmp_path: Path
) -> None:
    source = Path(__file__).with_name("namesake.c")
    host = compile_program(
        tmp_path / "host",
        compiler,
        "-rdynamic",
        f"-DY_REFERENCE={REFERENCES['y']}",
        str(source),
        "-ldl",
    )
    library = folder / "binaries" / "linux64" / "SliderBelt.so"
    token = fmpy.read_model_description(str(folder)).guid
    y = simulate(t_end=1.0, kernel="compiled").final.y
    assert float.fromhex(run_without_python(host, library, token)) == y


def test_a_master_in_c_couples_with_output_derivatives_to_the_bits_of_the_example(
    compiler: list[str], tmp_path: Path
) -> None:
    steps, t_end = 50, 1.0
    references = {"SLIDER": SLIDER_BELT_TABLE.references, "ACTUATOR": ACTUATOR_TABLE.references}
    macros = [
        f"-D{model}_{name.upper()}={references[model][name]}"
        for model, names in (("SLIDER", ("F", "P", "y")), ("ACTUATOR", ("F", "P")))
        for name in names
    ]
    source = str(Path(__file__).with_name("coupled.c"))
    program = compile_program(tmp_path / "coupled", compiler, *macros, source, "-ldl")
    models = [
        argument
        for model in ("SliderBelt", "BrakeActuator")
        for argument in (NATIVE / f"{model}.so", model_guid(model))
    ]
    y, *rows = run_without_python(program, *models, steps, t_end).splitlines()
    example = runpy.run_path(str(ROOT / "examples" / "fmu_coupled.py"))
    assert float.fromhex(y) == example["coupled"](steps, t_end, extrapolate=True)[0]
    rates = [[float.fromhex(number) for number in row.split()] for row in rows]
    assert len(rates) == 3
    assert all(by_2 == by_3 != 0.0 for by_2, by_3 in rates)


def exported_names(library: Path) -> set[str]:
    """Names that a library exports."""
    command = ["nm", "-D", "--defined-only", str(library)]
    process = subprocess.run(command, capture_output=True, text=True, check=True)
    return {line.split()[-1] for line in process.stdout.splitlines()}


@pytest.mark.whole
@pytest.mark.parametrize("fmi", ["2", "3"])
@pytest.mark.parametrize("component", COMPONENTS)
def test_the_sources_compile_to_the_same_bits(component: str, fmi: str, tmp_path: Path) -> None:
    for tool in ("cmake", "nm"):
        if shutil.which(tool) is None:
            pytest.skip(f"there is no {tool}")
    fmu = tmp_path / "sources.fmu"
    build_fmu(fmu, component=component, flavour="native", fmi=fmi, sources=True)
    assert validate_fmu(str(fmu)) == []
    runs = [fmpy.simulate_fmu(str(fmu), stop_time=10.0, fmi_type="CoSimulation")]
    with zipfile.ZipFile(fmu) as archive:
        source_members = {
            n: archive.read(n) for n in archive.namelist() if not n.startswith("binaries")
        }
    with zipfile.ZipFile(fmu, "w") as archive:
        for name, content in source_members.items():
            archive.writestr(name, content)
    command = [sys.executable, "-m", "fmpy", "compile", str(fmu)]
    process = subprocess.run(command, capture_output=True, text=True, check=False)
    assert process.returncode == 0, process.stdout + process.stderr
    runs.append(fmpy.simulate_fmu(str(fmu), stop_time=10.0, fmi_type="CoSimulation"))
    assert runs[0].tolist() == runs[1].tolist()
    # Any FMU has the functions of both versions of FMI. Other exported names could clash with
    # functions of the host or its libraries.
    fmpy.extract(str(fmu), str(tmp_path / "compiled"))
    (library,) = (tmp_path / "compiled" / "binaries").rglob("*.so")
    assert {name[:4] for name in exported_names(library)} == {"fmi2", "fmi3"}


@pytest.mark.parametrize("name", ["wärme", "a#b", "50%", "with a space", "%20"])
def test_the_library_runs_from_any_folder(fmu: Path, tmp_path: Path, name: str) -> None:
    fmpy.extract(str(fmu), str(tmp_path / name))
    with FmuInstance(tmp_path / name).begin() as instance:
        instance.step(1.0)
        assert instance.get("y") == [simulate(t_end=1.0, kernel="compiled").final.y]


def test_the_library_is_unloaded_with_its_instance(fmu: Path, tmp_path: Path) -> None:
    maps = Path("/proc/self/maps")
    for number in range(20):
        folder = tmp_path / f"copy{number}"
        fmpy.extract(str(fmu), str(folder))
        with FmuInstance(folder).begin() as instance:
            instance.step(0.1)
            assert str(folder) in maps.read_text()
        assert str(folder) not in maps.read_text()


# Steps and instances over which memory may not grow, and rounds of each attack: a function of
# attack.c that passes damaged states or calls FMI functions at random.
@pytest.mark.parametrize(
    ("steps", "instances", "rounds"),
    [(30_000, 300, 100), pytest.param(1_000_000, 10_000, 3000, marks=pytest.mark.whole)],
)
def test_invalid_and_random_calls_cause_no_fault_and_no_memory_growth(
    compiler: list[str], tmp_path: Path, steps: int, instances: int, rounds: int
) -> None:
    program = compile_attack(tmp_path, compiler, "-Og")
    # The program prints how many pages of memory remain after the steps, and after the instances.
    output = run_without_python(program, steps, instances, rounds, 0)
    remaining_pages = [int(line) for line in output.splitlines()]
    assert len(remaining_pages) == 2
    # The allocator keeps a few pages; a leak in every step or instance would take more.
    assert max(remaining_pages) < 25


@pytest.mark.whole
def test_the_sanitizers_report_no_error(compiler: list[str], tmp_path: Path) -> None:
    checks = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-O1", "-g"]
    program = compile_attack(tmp_path, compiler, *checks, "-fno-strict-aliasing")
    # 52,000 sequences of random calls.
    run_without_python(program, 1000, 100, 6500, 1)


def test_the_attack_calls_every_exported_function() -> None:
    if shutil.which("nm") is None:
        pytest.skip("there is no nm")
    attack = Path(__file__).with_name("attack.c").read_text(encoding="utf-8")
    names = exported_names(NATIVE / "SliderBelt.so")
    assert {name for name in names if f"{name}(" not in attack} == set()
