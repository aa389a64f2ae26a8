"""The native FMU as a file: its content, and builds that are refused.

An FMU of the native flavour contains a library compiled from C, one of the Python flavour runs
Python code. Their files differ, their results agree.
"""

import re
import subprocess
import zipfile
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

from fivtui.cli import run
from fivtui.fmu.check import check_fmu
from fivtui.model.errors import InputError
from fmu_src.build import native, native_failure
from fmu_src.build.builder import build_fmu
from fmu_src.build.components import COMPONENTS
from fmu_src.build.ssp import build_ssp
from tests.support.fmu_coupling import run_coupled


@pytest.mark.parametrize("component", COMPONENTS)
def test_the_fmu_follows_the_schema_and_has_no_problems(component: str, tmp_path: Path) -> None:
    fmu = build_fmu(tmp_path / "m.fmu", component=component, flavour="native")
    assert validate_fmu(str(fmu)) == []
    assert check_fmu(fmu) == []
    schema = Path(fmpy.__file__).parent / "schema" / "fmi2" / "fmi2ModelDescription.xsd"
    with zipfile.ZipFile(fmu) as archive:
        text = archive.read("modelDescription.xml")
        names = {name.partition("/")[0] for name in archive.namelist()}
    etree.XMLSchema(etree.parse(schema)).assertValid(etree.fromstring(text))
    folders = {"binaries", "documentation", "extra", "terminalsAndIcons"}
    assert names == {"modelDescription.xml", "model.png"} | folders


def test_the_same_project_builds_the_same_bytes_at_the_same_date(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1000000000")
    fmus = [build_fmu(tmp_path / f"{name}.fmu", flavour="native") for name in ("first", "second")]
    assert fmus[0].read_bytes() == fmus[1].read_bytes()
    date = fmpy.read_model_description(fmus[0]).generationDateAndTime
    assert date == "2001-09-09T01:46:40Z"


def test_the_fmu_reproduces_its_reference_run(fmu: Path, folder: Path) -> None:
    table = np.genfromtxt(folder / "extra" / "SliderBelt_ref.csv", delimiter=",", names=True)
    rows = np.genfromtxt(folder / "extra" / "SliderBelt_in.csv", delimiter=",", names=True)
    result = fmpy.simulate_fmu(
        str(fmu), stop_time=20.0, output_interval=0.01, input=rows, fmi_type="CoSimulation"
    )
    for name in ("x", "y", "separations"):
        assert result[name] == pytest.approx(table[name], rel=1e-8, abs=1e-8)


# `host`: the test depends on a program of this machine, nm.
@pytest.mark.skipif(fmpy.platform != "linux64", reason="nm reads libraries of Linux")
@pytest.mark.host
def test_only_functions_of_fmi_are_exported(folder: Path) -> None:
    library = str(folder / "binaries" / "linux64" / "SliderBelt.so")
    try:
        process = subprocess.run(["nm", "-D", library], capture_output=True, text=True, check=True)
    except FileNotFoundError:
        pytest.skip("there is no nm")
    # A line of nm: address, type and name of a defined symbol, T for a function. Symbols that the
    # library needs have no address, and the type U or w (weak).
    lines = [line.split() for line in process.stdout.splitlines()]
    defined = [line for line in lines if len(line) == 3]
    exported = {name for _, kind, name in defined if kind == "T"}
    headers = Path(fmpy.__file__).parent / "c-code"
    texts = [file.read_text(encoding="utf-8") for file in headers.glob("fmi[23]FunctionTypes.h")]
    declared = set(re.findall(r"(fmi[23]\w+)TYPE\s*\(", "".join(texts)))
    assert len(declared) > 100
    assert exported == declared
    # No data are exported.
    assert {kind for _, kind, _ in defined} == {"T"}
    # Needed names with the version of glibc that has them, such as memcpy@GLIBC_2.14: version 2.17
    # is the oldest that wheels for Linux (manylinux2014) require.
    needed = " ".join(line[-1] for line in lines if line[0] in ("U", "w"))
    versions = re.findall(r"@GLIBC_(\d+)\.(\d+)", needed)
    assert all((int(major), int(minor)) <= (2, 17) for major, minor in versions)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"flavour": "rust"}, "unknown flavour 'rust'"),
        ({"flavour": "native", "fmi": "1"}, "FMI 1: must be 2 or 3"),
        (
            {"flavour": "python", "platforms": ["win64"]},
            "platforms: the python flavour always includes Linux and Windows",
        ),
        ({"flavour": "native", "platforms": ["vax"]}, "unknown platform 'vax'"),
        ({"flavour": "python", "sources": True}, "sources: the python flavour has no C files"),
        ({"flavour": "native", "component": "wheel"}, "unknown component 'wheel'"),
    ],
)
def test_unsupported_options_are_refused(
    options: dict[str, Any], message: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=re.escape(message)):
        build_fmu(tmp_path / "m.fmu", **options)


def test_without_a_binary_the_reason_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert native_failure() is None
    # The folder of the compiled libraries, and the file in which the installation stores why it
    # could not compile them. At first neither a library nor a reason is there.
    monkeypatch.setattr(native, "NATIVE", tmp_path)
    monkeypatch.setattr(native, "_FAILURE_FILE", tmp_path / "native.txt")
    assert "not compiled: not installed; install fivtui anew" in str(native_failure())
    (tmp_path / "native.txt").write_text("there is no compiler\n", encoding="utf-8")
    assert run(["fmu", "build", "--out", str(tmp_path / "m.fmu")]) == 2
    assert capsys.readouterr().err == f"fivtui: {native_failure()}\n"
    assert "there is no compiler" in str(native_failure())


def test_a_binary_of_other_sources_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The binary contains the hash of its sources, 32 hexadecimal digits. Here the hash of the
    # installed sources is replaced, as if they had changed.
    monkeypatch.setattr(native, "sources_hash", lambda: "0" * 32)
    with pytest.raises(InputError, match="compiled from other sources"):
        build_fmu(tmp_path / "m.fmu", flavour="native")


def test_a_system_of_native_fmus_is_that_of_python_fmus(tmp_path: Path) -> None:
    ends = []
    for flavour in ("python", "native"):
        system = build_ssp(tmp_path / f"{flavour}.ssp", flavour=flavour)
        with zipfile.ZipFile(system) as archive:
            assert archive.namelist()[0] == "SystemStructure.ssd"
            archive.extractall(tmp_path / flavour)
        fmus = tmp_path / flavour / "resources"
        slider, actuator = fmus / "slider_belt.fmu", fmus / "brake_actuator.fmu"
        ends.append(run_coupled(slider, actuator, steps=200, h=0.01)[-1])
    assert ends[0] == pytest.approx(ends[1], rel=1e-9)
