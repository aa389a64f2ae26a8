"""Builds of the FMU: content, reproducibility and errors."""

import ast
import inspect
import re
import sys
import zipfile
from importlib import import_module
from importlib.metadata import PackageNotFoundError
from pathlib import Path, PurePosixPath

import fmpy
import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.util import read_csv, read_ref_opt_file
from fmpy.validation import validate_fmu
from lxml import etree

from fivtui import Parameters, simulate
from fivtui.fmu.check import check_fmu
from fivtui.io import is_replaceable
from fivtui.model.errors import InputError
from fivtui.version import __version__
from fmu_src.build import builder, description
from fmu_src.build.builder import build_fmu
from fmu_src.build.components import COMPONENTS
from fmu_src.build.description import base_exponents
from fmu_src.slave.variables import VARIABLES
from tests.support.fmu_driver import Driver
from tests.support.fmu_tools import build_python_fmu
from tests.support.processes import run_python

ROOT = Path(__file__).parents[2]


def test_the_mode_is_also_an_integer_and_an_enumeration(fmu: Path) -> None:
    mode_outputs = ("mode", "mode_integer", "mode_enumeration")
    run = fmpy.simulate_fmu(
        str(fmu), stop_time=6.0, output_interval=0.1, output=["y", "time", *mode_outputs]
    )
    assert set(run["mode"]) == {0.0, 1.0}
    assert np.array_equal(run["mode"], run["mode_integer"])
    assert np.array_equal(run["mode"], run["mode_enumeration"])
    assert np.array_equal(run["mode"] == 1.0, run["y"] <= 0.0)


@pytest.mark.parametrize("component", COMPONENTS)
def test_every_component_follows_the_schema_of_the_standard(component: str, tmp_path: Path) -> None:
    fmu = build_python_fmu(tmp_path / "m.fmu", component=component)
    folder = Path(fmpy.__file__).parent / "schema" / "fmi2"
    schema = etree.XMLSchema(etree.parse(folder / "fmi2ModelDescription.xsd"))
    with zipfile.ZipFile(fmu) as archive:
        schema.assertValid(etree.fromstring(archive.read("modelDescription.xml")))
    assert check_fmu(fmu) == []


@pytest.mark.parametrize("component", COMPONENTS)
def test_the_reference_run_in_the_fmu_can_be_repeated(component: str, tmp_path: Path) -> None:
    fmu = build_python_fmu(tmp_path / "m.fmu", component=component)
    model = COMPONENTS[component].model
    with zipfile.ZipFile(fmu) as archive:
        for name in ("in.csv", "ref.csv", "ref.opt"):
            (tmp_path / name).write_bytes(archive.read(f"extra/{model}_{name}"))
    options = read_ref_opt_file(tmp_path / "ref.opt")
    reference = read_csv(tmp_path / "ref.csv")
    inputs = read_csv(tmp_path / "in.csv")
    # Importers extrapolate inputs differently, so the table covers the whole run.
    assert inputs["time"].tolist() == [0.0, 10.0, 10.0, 20.0]
    assert (options["StartTime"], options["StopTime"]) == (0.0, 20.0)
    assert reference["time"] == pytest.approx(np.arange(2001) * 0.01)
    run = fmpy.simulate_fmu(
        str(fmu),
        stop_time=options["StopTime"],
        output_interval=options["StepSize"],
        relative_tolerance=options["RelTol"],
        input=inputs,
        output=reference.dtype.names[1:],
    )
    for name in reference.dtype.names:
        assert run[name] == pytest.approx(reference[name], rel=1e-8, abs=1e-8), name


def test_the_reference_run_agrees_with_the_independent_integrator() -> None:
    # The preload jumps from 80 N to 120 N at 10 s.
    reference = COMPONENTS["slider-belt"].reference_run()
    times = np.asarray(reference.outputs["time"])
    before_jump = times <= 10.0
    first = simulate(t_end=10.0, method="rk4", step=1e-3, samples=times[before_jump])
    start = (first.final.x, first.final.vx, first.final.y, first.final.vy)
    second = simulate(
        Parameters(F=120.0),
        t_end=10.0,
        start=start,
        method="rk4",
        step=1e-3,
        samples=times[~before_jump] - 10.0,
    )
    assert first.trajectory is not None
    assert second.trajectory is not None
    for name, error in (("x", 1e-7), ("y", 1e-7), ("P", 5e-5)):
        pieces = [getattr(run.trajectory, name) for run in (first, second)]
        assert reference.outputs[name] == pytest.approx(np.concatenate(pieces), abs=error)


def test_an_unknown_unit_is_refused() -> None:
    with pytest.raises(KeyError):
        base_exponents("furlong/m")


def test_modules_in_the_fmu_import_only_the_standard_library_and_each_other(fmu: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        names = [n for n in archive.namelist() if re.match(r"resources/fivtui_.*\.py", n)]
        trees = {name: ast.parse(archive.read(name)) for name in names}
    assert len(trees) > 15
    # All folders up to the FMU's package, without `resources` and the root.
    folders = {parent for n in names for parent in PurePosixPath(n).parents[:-2]}
    assert {f"{folder}/__init__.py" for folder in folders} <= set(names)
    # One package contains all modules but the one that the wrapper imports.
    (package,) = {name.split("/")[1] for name in names if name.count("/") > 1}
    allowed = {*sys.stdlib_module_names, "pythonfmu", package}
    for name, tree in trees.items():
        for node in ast.walk(tree):
            modules = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.level == 0:
                modules = [str(node.module)]
            for module in modules:
                assert module.split(".")[0] in allowed, name


def test_the_core_in_the_fmu_is_the_core_of_the_project(fmu: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        core_members = {
            n: archive.read(n)
            for n in archive.namelist()
            if re.search("/fivtui/(model|taylor)/", n)
        }
    files = {name: content for name, content in core_members.items() if content}
    assert len(files) >= 8
    for name, content in files.items():
        # In the FMU, fivtui is a subpackage of a package with a hash in its name.
        source = re.sub(
            rb"^from fivtui_[0-9a-f]+\.(?=fivtui\.)", b"from ", content, flags=re.MULTILINE
        )
        assert source == (ROOT / "fivtui" / name.partition("/fivtui/")[2]).read_bytes()


def test_the_archive_is_compressed_and_documented(fmu: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        entries = {entry.filename: entry for entry in archive.infolist()}
        index = archive.read("documentation/index.html").decode()
    assert fmu.stat().st_size < 0.5 * sum(entry.file_size for entry in entries.values())
    assert next(iter(entries)) == "modelDescription.xml"
    assert "documentation/licenses/pythonfmu.txt" in entries
    assert {"binaries/linux64/SliderBelt.so", "binaries/win64/SliderBelt.dll"} <= set(entries)
    assert all(variable.name in index for variable in VARIABLES)


def test_the_same_project_builds_the_same_bytes_anywhere_at_the_same_date(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1000000000")
    first = build_python_fmu(tmp_path / "first.fmu")
    code = (
        "import sys; from fmu_src.build.builder import build_fmu; "
        "build_fmu(sys.argv[1], flavour='python')"
    )
    run_python(
        "-c",
        code,
        "rebuilt.fmu",
        cwd=tmp_path,
        environment={"PYTHONHASHSEED": "7", "TZ": "Asia/Tokyo"},
    )
    assert (tmp_path / "rebuilt.fmu").read_bytes() == first.read_bytes()


def test_the_guid_is_the_same_at_another_date(
    fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    old = read_model_description(build_python_fmu(tmp_path / "old.fmu"))
    assert old.generationDateAndTime == "1970-01-01T00:00:00Z"
    assert old.guid == read_model_description(fmu).guid


@pytest.mark.parametrize("date", ["today", "1e9", "9" * 30])
def test_an_invalid_date_is_refused(
    date: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", date)
    with pytest.raises(InputError, match=r"SOURCE_DATE_EPOCH = .*: must be seconds since 1970"):
        build_python_fmu(tmp_path / "m.fmu")


def test_a_source_folder_that_is_not_installed_has_the_same_licence(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    installed = description.project_license()

    def raise_not_found(package: str) -> None:
        raise PackageNotFoundError(package)

    monkeypatch.setattr(description, "distribution", raise_not_found)
    assert description.project_license() == installed


@pytest.mark.parametrize("flavour", ["python", "native"])
@pytest.mark.parametrize("component", COMPONENTS)
def test_the_fmu_has_its_licence_figure_icon_and_terminals(
    component: str, flavour: str, tmp_path: Path
) -> None:
    fmu = build_fmu(tmp_path / "m.fmu", component=component, flavour=flavour)
    description = read_model_description(fmu)
    assert description.generationTool is not None
    assert description.generationTool.startswith(f"fivtui {__version__}")
    assert description.version == __version__
    with zipfile.ZipFile(fmu) as archive:
        license_lines = archive.read("documentation/licenses/license.txt").decode().splitlines()
        assert description.copyright in license_lines
        page = archive.read("documentation/index.html").decode()
        assert '<img src="diagram.svg"' in page
        states = {"slider-belt": "x, y, vx, vy", "brake-actuator": "F"}[component]
        assert f"Continuous states, in this order: {states}." in page
        pictures = ["model.png", "terminalsAndIcons/icon.png"]
        assert {archive.read(name)[:4] for name in pictures} == {b"\x89PNG"}
        for name in ("documentation/diagram.svg", "terminalsAndIcons/icon.svg"):
            assert etree.fromstring(archive.read(name)).tag.endswith("svg")
        terminals = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
    folder = Path(fmpy.__file__).parent / "schema" / "fmi3"
    etree.XMLSchema(etree.parse(folder / "fmi3TerminalsAndIcons.xsd")).assertValid(terminals)
    causalities = {v.name: v.causality for v in description.modelVariables}
    members = {
        (terminal.get("name"), member.get("memberName")): causalities[member.get("variableName")]
        for terminal in terminals.iter("Terminal")
        for member in terminal
    }
    preload = {("preload", "F"): "input", ("preload", "P"): "output"}
    friction = {("friction", "force"): "output", ("friction", "speed"): "input"}
    if component == "slider-belt":
        assert members == preload | friction
    else:
        # Both ends of the terminal "preload" have opposite directions.
        assert members == dict(zip(preload, reversed(preload.values()), strict=True))


def test_building_does_not_change_the_process(tmp_path: Path) -> None:
    build_python_fmu(tmp_path / "first.fmu")
    state_before = sys.path[:], set(sys.modules), Path.cwd(), set(sys.path_importer_cache)
    build_python_fmu(tmp_path / "second.fmu")
    state_after = sys.path[:], set(sys.modules), Path.cwd(), set(sys.path_importer_cache)
    assert state_before == state_after
    assert sorted(path.name for path in tmp_path.iterdir()) == ["first.fmu", "second.fmu"]


def test_two_different_builds_run_in_one_process(
    fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    original = builder._read_source

    def read_altered_source(package: str, name: str) -> str:
        return original(package, name).replace('"mass of the slider"', '"another meaning"')

    monkeypatch.setattr(builder, "_read_source", read_altered_source)
    altered_fmu = build_python_fmu(tmp_path / "other.fmu")
    monkeypatch.undo()
    first, second = read_model_description(fmu), read_model_description(altered_fmu)
    assert first.guid != second.guid
    with Driver(fmu, altered_fmu) as driver:
        answers = driver.drive(
            ("a", "new", 0),
            ("b", "new", 1),
            ("a", "init", {"mu": 0.5}),
            ("b", "init", {"mu": 0.9}),
            ("a", "step", 0.0, 5.0),
            ("b", "step", 0.0, 5.0),
            ("a", "get", ["y", "mu"]),
            ("b", "get", ["y", "mu"]),
            ("", "modules"),
        )
    assert answers[6].value[1] == 0.5
    assert answers[7].value[1] == 0.9
    assert answers[6].value[0] != answers[7].value[0]
    # Each FMU has a package, and a module that the wrapper imports.
    modules = [name for name in answers[8].value if name != "fivtui"]
    assert len(modules) == 2 * 2


def test_hundreds_of_instances_run_in_one_process(fmu: Path) -> None:
    with Driver(fmu) as driver:
        # `many` runs instances and gives the final y of each; `path_length` is that of `sys.path`.
        outputs, _, length_before, _, length_after = driver.drive(
            ("a", "many", 60),
            ("a", "many", 1),
            ("", "path_length"),
            ("a", "many", 1),
            ("", "path_length"),
        )
        for _ in range(200):
            assert driver.drive(("a", "many", 1))[0].value == outputs.value[:1]
        assert (
            driver.drive(("", "path_length"))[0].value == length_before.value == length_after.value
        )
    assert len(set(outputs.value)) == 1


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("model.zip", ".fmu"),
        ("model", ".fmu"),
        ("absent/model.fmu", "there is no folder"),
        ("taken.fmu", "exists already"),
        ("folder.fmu", "is a folder"),
    ],
)
def test_an_invalid_target_is_refused_and_nothing_is_written(
    name: str, message: str, tmp_path: Path
) -> None:
    (tmp_path / "taken.fmu").write_text("mine")
    (tmp_path / "folder.fmu").mkdir()
    with pytest.raises(InputError, match=re.escape(message)):
        build_python_fmu(tmp_path / name)
    assert (tmp_path / "taken.fmu").read_text() == "mine"
    assert len(list(tmp_path.iterdir())) == 2


def test_an_unknown_component_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="did you mean brake-actuator"):
        build_python_fmu(tmp_path / "m.fmu", component="actuator")


def test_force_replaces_a_file(tmp_path: Path) -> None:
    target = tmp_path / "taken.fmu"
    target.write_text("old")
    built = build_python_fmu(target, force=True)
    assert built == target
    # The permission to replace the file does not pass to users of the returned path.
    assert not is_replaceable(built)
    assert validate_fmu(str(target)) == []


def test_a_failed_build_keeps_the_old_file_and_does_not_change_the_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "taken.fmu"
    target.write_text("old")
    monkeypatch.setattr(
        "fmu_src.build.builder._read_source", lambda *_: "raise RuntimeError('broken')\n"
    )
    path, modules = sys.path[:], set(sys.modules)
    with pytest.raises(RuntimeError, match="broken"):
        build_python_fmu(target, force=True)
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]
    assert (sys.path, set(sys.modules)) == (path, modules)


def test_the_fmu_has_the_original_wrapper_without_its_builder(tmp_path: Path) -> None:
    with zipfile.ZipFile(build_python_fmu(tmp_path / "slider_belt.fmu")) as archive:
        wrapper_sources = {
            Path(name).stem: archive.read(name).decode()
            for name in archive.namelist()
            if name.startswith("resources/pythonfmu/")
        }
    assert "builder" not in wrapper_sources
    assert "builder" not in wrapper_sources["__init__"]
    for name in ("fmi2slave", "variables", "enums", "default_experiment"):
        assert wrapper_sources[name] == inspect.getsource(import_module(f"pythonfmu.{name}"))
    source_lines = inspect.getsource(import_module("pythonfmu")).splitlines()
    assert set(source_lines) - set(wrapper_sources["__init__"].splitlines()) == {
        "from .builder import FmuBuilder"
    }


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fmi": "1"}, "FMI 1: must be 2 or 3"),
        ({"fmi": "3"}, "FMI 3: needs the native flavour, not the python flavour"),
    ],
)
def test_an_unsupported_version_of_fmi_is_refused(
    options: dict[str, str], message: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=message):
        build_python_fmu(tmp_path / "m.fmu", fmi=options["fmi"])
