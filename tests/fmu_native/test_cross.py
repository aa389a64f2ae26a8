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
from fivtui import simulate
from fivtui.cli import run
from fivtui.fmu.check import check_fmu
from fivtui.model.errors import InputError
from fmu_src.build import cross, native
from fmu_src.build.builder import build_fmu
from fmu_src.build.native_text import FLAGS, sources

needs_zig = pytest.mark.skipif(
    find_spec("ziglang") is None, reason="ziglang is not installed (extra cross)"
)
# First bytes of a binary: ELF and its processor, DOS, Mach-O of 64 bits and its processor.
_X86, _ARM = 0x01000007, 0x0100000C
BEGIN = {
    "linux64/SliderBelt.so": b"\x7fELF",
    "win64/SliderBelt.dll": b"MZ",
    "darwin64/SliderBelt.dylib": struct.pack("<II", 0xFEEDFACF, _X86),
    "aarch64-linux/SliderBelt.so": b"\x7fELF",
    "aarch64-windows/SliderBelt.dll": b"MZ",
    "aarch64-darwin/SliderBelt.dylib": struct.pack("<II", 0xFEEDFACF, _ARM),
}
PLATFORMS = ("linux64", "win64", "darwin64", "aarch64-linux", "aarch64-windows", "aarch64-darwin")
_ELF_ARM = 183


def processor_of(library: bytes) -> int:
    """The processor that an ELF library is for."""
    (machine,) = struct.unpack_from("<H", library, 18)
    return int(machine)


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
    words = ["fmu", "build", "--flavour", "native", "--platform", ",".join(PLATFORMS[::-1])]
    assert run([*words, "--out", str(fmu)]) == 0
    assert check_fmu(fmu) == []
    with zipfile.ZipFile(fmu) as archive:
        found = {name for name in archive.namelist() if name.startswith("binaries/")}
        assert found == {f"binaries/{name}" for name in BEGIN}
        for name, begin in BEGIN.items():
            binary = archive.read(f"binaries/{name}")
            assert binary.startswith(begin), name
            for function in (b"fmi2DoStep", b"fmi2SerializeFMUstate", b"fmi3DoStep"):
                assert function in binary, name
        assert processor_of(archive.read("binaries/aarch64-linux/SliderBelt.so")) == _ELF_ARM
        assert processor_of(archive.read("binaries/linux64/SliderBelt.so")) != _ELF_ARM


@pytest.mark.parametrize(
    ("fmi", "folders"), [("2", {"aarch64-linux", "linux64"}), ("3", {"aarch64-linux"})]
)
def test_on_arm_binaries_stand_where_importers_look_for_them(
    fmi: str, folders: set[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(native, "_machine", lambda: ("linux", "aarch64"))
    monkeypatch.setattr(native, "_binary", lambda model: model.encode())
    fmu = build_fmu(tmp_path / "arm.fmu", flavour="native", fmi=fmi)
    with zipfile.ZipFile(fmu) as archive:
        found = {name for name in archive.namelist() if name.startswith("binaries/")}
        assert found == {f"binaries/{folder}/SliderBelt.so" for folder in folders}
        assert {archive.read(name) for name in found} == {b"SliderBelt"}


def test_on_other_processors_there_is_no_native_flavour(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(native, "_machine", lambda: ("linux", "riscv64"))
    with pytest.raises(InputError, match="for linux, riscv64: there is none; build the Python"):
        build_fmu(tmp_path / "m.fmu", flavour="native")
    assert "riscv64" in str(native.why_no_native())


def assert_native_bits(program: str, host: Path) -> None:
    done = subprocess.run(
        [program, str(host)], cwd=host.parent, capture_output=True, text=True, check=False
    )
    *found, switches = done.stdout.split()
    native_run = simulate(t_end=9999 * 0.01 + 0.01, kernel="compiled")
    final = native_run.final
    exact = [final.x, final.vx, final.y, final.vy]
    assert [float.fromhex(number) for number in found] == [*exact, *exact]
    assert int(switches) == native_run.switch_times.size


@pytest.fixture
def sources_of_host(tmp_path: Path) -> list[str]:
    """What a program in C that runs the FMU is compiled from."""
    for name, text in sources("SliderBelt").items():
        tmp_path.joinpath(name).write_text(text, encoding="utf-8")
    headers = Path(fmpy.__file__).parent / "c-code"
    flags = [flag for flag in FLAGS if flag not in ("-fPIC", "-fvisibility=hidden")]
    source = str(Path(__file__).with_name("run.c"))
    return [*flags, f"-I{tmp_path}", f"-I{headers}", source]


@needs_zig
@pytest.mark.whole
@pytest.mark.host
def test_the_binary_for_windows_has_the_native_bits(
    tmp_path: Path, sources_of_host: list[str]
) -> None:
    wine = shutil.which("wine")
    if wine is None:
        pytest.skip("there is no wine")
    host, library = tmp_path / "host.exe", tmp_path / "SliderBelt.dll"
    library.write_bytes(cross.compiled_for("SliderBelt", "win64"))
    given = ["-target", "x86_64-windows-gnu", *sources_of_host, str(library)]
    cross._run(tmp_path, *given, "-o", str(host))
    assert_native_bits(wine, host)


@needs_zig
@pytest.mark.whole
@pytest.mark.host
def test_on_arm_it_has_the_native_bits(tmp_path: Path, sources_of_host: list[str]) -> None:
    qemu = shutil.which("qemu-aarch64") or shutil.which("qemu-aarch64-static")
    if qemu is None:
        pytest.skip("there is no qemu-aarch64")
    host = tmp_path / "host"
    units = [str(path) for path in tmp_path.glob("*.c")]
    given = ["-target", "aarch64-linux-musl", "-static", *sources_of_host, *units, "-lm"]
    cross._run(tmp_path, *given, "-o", str(host))
    assert_native_bits(qemu, host)
