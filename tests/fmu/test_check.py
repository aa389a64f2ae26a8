"""Checks of FMUs: a valid FMU has no problem; faults of a broken FMU are reported."""

import re
import tempfile
import zipfile
from pathlib import Path

import fmpy
import pytest

from fivtui.fmu.check import check_fmu
from fivtui.fmu.run import run_fmu
from fivtui.model.errors import InputError
from fmu_src.build.builder import build_fmu
from tests.support.fmu_tools import build_accumulator, modified_copy

LIBRARIES = ("binaries/linux64/SliderBelt.so", "binaries/win64/SliderBelt.dll")


def read_member(fmu: Path, pattern: str) -> tuple[str, bytes]:
    with zipfile.ZipFile(fmu) as archive:
        (name,) = (name for name in archive.namelist() if re.fullmatch(pattern, name))
        return name, archive.read(name)


def test_the_fmu_of_this_project_has_no_problem(fmu: Path) -> None:
    assert check_fmu(fmu) == []


def test_checking_writes_nothing_to_the_terminal(
    fmu: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    check_fmu(fmu)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "there is no such file"),
        (b"not an archive", "not a zip archive"),
        (b"", "not a zip archive"),
    ],
)
def test_a_file_that_is_not_an_archive_is_wrong_input(
    content: bytes | None, message: str, tmp_path: Path
) -> None:
    path = tmp_path / "model.fmu"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=message):
        check_fmu(path)


def test_a_folder_and_an_archive_without_description_are_wrong_input(
    fmu: Path, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match="is a folder"):
        check_fmu(tmp_path)
    incomplete_fmu = modified_copy(fmu, tmp_path / "incomplete.fmu", {"modelDescription.xml": None})
    with pytest.raises(InputError, match=r"holds no modelDescription\.xml"):
        check_fmu(incomplete_fmu)


def test_an_invalid_description_is_reported(fmu: Path, tmp_path: Path) -> None:
    name, xml = read_member(fmu, r"modelDescription\.xml")
    broken = xml.replace(b'unit="N"', b'unit="furlong"')
    problems = check_fmu(modified_copy(fmu, tmp_path / "m.fmu", {name: broken}))
    assert any("furlong" in problem for problem in problems)
    problems = check_fmu(modified_copy(fmu, tmp_path / "m.fmu", {name: xml[:500]}))
    assert len(problems) >= 1
    assert all("\n" not in problem for problem in problems)


def test_a_missing_binary_is_reported(fmu: Path, tmp_path: Path) -> None:
    incomplete_fmu = modified_copy(fmu, tmp_path / "m.fmu", dict.fromkeys(LIBRARIES))
    (problem,) = check_fmu(incomplete_fmu)
    assert "no binary for this platform" in problem


@pytest.mark.skipif(fmpy.architecture == "aarch64", reason="the binary would be for this processor")
def test_a_binary_for_another_processor_does_not_count(tmp_path: Path) -> None:
    fmu = build_fmu(tmp_path / "native.fmu", flavour="native")
    (member,) = (n for n in zipfile.ZipFile(fmu).namelist() if n.startswith("binaries/"))
    folder, file = member.rsplit("/", 1)
    platform = folder.removeprefix("binaries/")
    system = {"linux64": "linux", "darwin64": "darwin", "win64": "windows"}[platform]
    foreign_member = f"binaries/aarch64-{system}/{file}"
    with zipfile.ZipFile(fmu, "a") as archive:
        archive.writestr(foreign_member, archive.read(member))
    # The copy in the folder for ARM says that the binary in this platform's folder is for ARM, too.
    (problem,) = check_fmu(fmu)
    assert "no binary for this platform" in problem
    with pytest.raises(InputError, match="has no binary for this platform"):
        run_fmu(fmu, t_end=1.0)


def test_a_damaged_file_is_reported(fmu: Path, tmp_path: Path) -> None:
    data = bytearray(fmu.read_bytes())
    with zipfile.ZipFile(fmu) as archive:
        offset = archive.getinfo(LIBRARIES[0]).header_offset
    # A byte of the compressed library, past its header in the archive.
    data[offset + 2000] ^= 255
    path = tmp_path / "m.fmu"
    path.write_bytes(data)
    assert any(f"{LIBRARIES[0]} in the archive is damaged" in p for p in check_fmu(path))


def test_files_outside_of_the_fmu_are_reported(fmu: Path, tmp_path: Path) -> None:
    path = modified_copy(fmu, tmp_path / "m.fmu", {"../escaped.txt": b"", "/root.txt": b""})
    problems = check_fmu(path)
    assert any("../escaped.txt" in problem for problem in problems)
    assert not (tmp_path.parent / "escaped.txt").exists()


def test_a_slave_that_cannot_be_instantiated_is_reported(fmu: Path, tmp_path: Path) -> None:
    name, _ = read_member(fmu, r"resources/fivtui_entry_.*\.py")
    path = modified_copy(fmu, tmp_path / "m.fmu", {name: b"raise RuntimeError('no slave')\n"})
    (problem,) = check_fmu(path)
    assert "crashes" in problem or "fails" in problem


@pytest.mark.parametrize(
    ("behaviour", "message"),
    [
        ("pass", None),
        ("return False", "the run ends at 0 s"),
        ("self.total = float('nan')", "the output total is not finite"),
        ("import random; self.total = random.random()", "differs between two equal runs"),
        ("import os; os.abort()", r"crashes the process that runs it \(SIGABRT\)"),
        ("raise ValueError('broken')", "fails"),
    ],
)
def test_a_fault_in_the_run_of_another_fmu_is_reported(
    behaviour: str, message: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The description that pythonfmu writes is not valid; only the run matters in this test.
    monkeypatch.setattr("fmpy.validation.validate_fmu", lambda _path: [])
    problems = check_fmu(build_accumulator(tmp_path, behaviour))
    if message is None:
        assert problems == []
    else:
        assert re.search(message, problems[0])


def test_an_fmu_that_hangs_is_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fmpy.validation.validate_fmu", lambda _path: [])
    monkeypatch.setattr("fivtui.fmu.check._TIMEOUT_S", 3.0)
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    monkeypatch.setenv("TMPDIR", str(folder))
    (problem,) = check_fmu(build_accumulator(tmp_path, "import time; time.sleep(60)"))
    assert problem == "a short run is not finished after 3 s"
    assert list(folder.iterdir()) == []
