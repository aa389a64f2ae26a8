"""Binaries of the native FMU for other platforms, compiled by ziglang."""

import shutil
import struct
import subprocess
import zipfile
from importlib.util import find_spec
from pathlib import Path

import fmpy
import pytest

import hatch_build
from fivtui.cli import run
from fivtui.fmu.check import check_fmu
from fivtui.model.errors import InputError
from fmu_src.build import cross
from fmu_src.build.builder import build_fmu
from fmu_src.build.native_text import FLAGS

needs_zig = pytest.mark.skipif(
    find_spec("ziglang") is None, reason="ziglang is not installed (extra cross)"
)
# First bytes of a binary: ELF, DOS, Mach-O of 64 bits.
BEGIN = {
    "linux64/SliderBelt.so": b"\x7fELF",
    "win64/SliderBelt.dll": b"MZ",
    "darwin64/SliderBelt.dylib": struct.pack("<I", 0xFEEDFACF),
}


def test_the_flags_are_those_of_the_build_hook() -> None:
    assert list(FLAGS) == hatch_build._FLAGS


def test_without_ziglang_its_extra_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cross, "find_spec", lambda _name: None)
    other = "win64" if fmpy.platform != "win64" else "linux64"
    with pytest.raises(InputError, match=f"platform {other}: needs the package ziglang, of the"):
        build_fmu(tmp_path / "m.fmu", flavour="native", platforms=[other])


@needs_zig
@pytest.mark.whole
def test_one_fmu_holds_binaries_of_several_platforms(tmp_path: Path) -> None:
    fmu = tmp_path / "all.fmu"
    words = ["fmu", "build", "--flavour", "native", "--platform", "linux64,win64,darwin64"]
    assert run([*words, "--out", str(fmu)]) == 0
    assert check_fmu(fmu) == []
    with zipfile.ZipFile(fmu) as archive:
        for name, begin in BEGIN.items():
            binary = archive.read(f"binaries/{name}")
            assert binary.startswith(begin), name
            for function in (b"fmi2DoStep", b"fmi2SerializeFMUstate", b"fmi3DoStep"):
                assert function in binary, name


@needs_zig
@pytest.mark.whole
@pytest.mark.host
def test_the_binary_for_windows_runs_under_wine(tmp_path: Path) -> None:
    wine = shutil.which("wine")
    if wine is None:
        pytest.skip("there is no wine")
    host, library = tmp_path / "host.exe", tmp_path / "SliderBelt.dll"
    library.write_bytes(cross.compiled_for("SliderBelt", "win64"))
    source = tmp_path / "host.c"
    source.write_text(
        "#include <stdio.h>\n#include <windows.h>\nint main(void) {\n"
        'HMODULE m = LoadLibraryA("SliderBelt.dll");\n'
        'const char *(*version)(void) = m ? (void *)GetProcAddress(m, "fmi2GetVersion") : 0;\n'
        'puts(version ? version() : "none"); return 0; }\n'
    )
    cross._run(tmp_path, "-target", "x86_64-windows-gnu", str(source), "-o", str(host))
    done = subprocess.run([wine, str(host)], cwd=tmp_path, capture_output=True, check=False)
    assert done.stdout.split() == [b"2.0"]
