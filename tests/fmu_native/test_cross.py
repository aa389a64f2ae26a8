"""Binaries of the native FMU for other platforms, compiled by ziglang.

Tests marked `whole` run only with ``pytest -m whole``. Those marked `host` need a program of this
machine: wine, which runs programs for Windows, or qemu, which runs those for ARM processors.
"""

import os
import platform
import shutil
import struct
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

import fmpy
import pytest

import hatch_build
from fivtui import simulate
from fivtui.cli import run
from fivtui.fmu.check import check_fmu
from fivtui.kernel import FLAGS
from fivtui.model.errors import InputError
from fmu_src.build import cross_compilation, native
from fmu_src.build.builder import build_fmu
from fmu_src.build.c_sources import reproducible_options, sources
from fmu_src.build.platforms import PLATFORMS

needs_zig = pytest.mark.skipif(
    find_spec("ziglang") is None, reason="ziglang is not installed (extra cross)"
)
# Processors in the header of 64-bit Mach-O binaries.
_X86, _ARM = 0x01000007, 0x0100000C
# Load commands of Mach-O: the library's install name, and the minimum version of the system.
_ID_DYLIB, _BUILD_VERSION = 0x0D, 0x32
FIRST_BYTES = {
    "linux64/SliderBelt.so": b"\x7fELF",
    "win64/SliderBelt.dll": b"MZ",
    "darwin64/SliderBelt.dylib": struct.pack("<II", 0xFEEDFACF, _X86),
    "aarch64-linux/SliderBelt.so": b"\x7fELF",
    "aarch64-windows/SliderBelt.dll": b"MZ",
    "aarch64-darwin/SliderBelt.dylib": struct.pack("<II", 0xFEEDFACF, _ARM),
}
_ELF_ARM = 183


def elf_processor(library: bytes) -> int:
    """The processor of an ELF library."""
    (machine,) = struct.unpack_from("<H", library, 18)
    return int(machine)


class RecordingCompiler:
    """Replaces the compiler: records its calls and writes an empty output file."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.calls: list[tuple[Path | None, Mapping[str, str], list[str]]] = []
        monkeypatch.setattr(subprocess, "run", self._run_compiler)

    def _run_compiler(
        self, command: list[str], *, env: Mapping[str, str], cwd: Path | None = None, **_: object
    ) -> None:
        self.calls.append((cwd, env, command))
        Path(command[command.index("-o") + 1]).write_bytes(b"")


@pytest.mark.parametrize(
    ("system", "processor", "name"),
    [
        ("darwin", "arm64", "aarch64-darwin"),
        ("darwin", "x86_64", "darwin64"),
        ("win32", "AMD64", "win64"),
    ],
)
def test_the_build_hook_compiles_and_links_for_the_same_platform(
    system: str, processor: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compiler = RecordingCompiler(monkeypatch)
    library = tmp_path / f"SliderBelt{PLATFORMS[name].suffix}"
    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setattr(platform, "machine", lambda: processor)
    monkeypatch.setattr(hatch_build, "find_spec", lambda _: True)
    # The search for a local compiler would call functions that only Windows has.
    monkeypatch.setattr(hatch_build.shutil, "which", lambda _: None)
    zig = hatch_build._compilers(hatch_build.ROOT)[0]
    assert zig.tag == PLATFORMS[name].wheel_tag
    assert zig.command[-2:] == ["-target", PLATFORMS[name].triple]
    # One object file, compiled without options, and the library that is linked from it.
    plan = hatch_build._Plan(objects={"unit": []}, libraries={library: ["unit"]})
    hatch_build._compile([lambda *_: plan], zig)
    assert set(reproducible_options(library.name)) < set(compiler.calls[-1][2])


@pytest.mark.parametrize(
    ("variables", "folder"),
    [
        ({"HOME": "HOME"}, "HOME/.cache/zig"),
        ({"HOME": "HOME", "XDG_CACHE_HOME": "XDG"}, "XDG/zig"),
        ({"XDG_CACHE_HOME": "XDG", "ZIG_GLOBAL_CACHE_DIR": "ZIG"}, "ZIG"),
        ({"XDG_CACHE_HOME": "file"}, None),
    ],
)
def test_a_second_build_reuses_the_sources_and_the_cache_of_the_first(
    variables: dict[str, str],
    folder: str | None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tmp_path.joinpath("file").touch()
    for name in ("XDG_CACHE_HOME", "ZIG_GLOBAL_CACHE_DIR", "ZIG_LOCAL_CACHE_DIR"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, str(tmp_path / value))
    monkeypatch.setattr(os, "name", "posix")
    monkeypatch.setattr(cross_compilation, "find_spec", lambda _: True)
    compiler = RecordingCompiler(monkeypatch)
    for _ in range(2):
        cross_compilation.compile_binary("SliderBelt", "win64")
    folders = {(cwd, env["ZIG_GLOBAL_CACHE_DIR"]) for cwd, env, _ in compiler.calls}
    if folder is None:
        # The cache is in the temporary folder of the build.
        assert len(folders) == 2
        assert not any(Path(cache).exists() for _, cache in folders)
        return
    ((source_folder, cache),) = folders
    assert cache == str(tmp_path / folder)
    assert source_folder is not None
    assert source_folder.is_relative_to(cache)
    assert {
        file.name: file.read_text(encoding="utf-8") for file in source_folder.iterdir()
    } == sources("SliderBelt")
    half = len(compiler.calls) // 2
    first, second = (
        [[Path(argument).name for argument in command] for _, _, command in calls]
        for calls in (compiler.calls[:half], compiler.calls[half:])
    )
    assert first == second


def load_commands(library: bytes) -> dict[int, bytes]:
    """The load commands of a Mach-O library of 64 bits, by their numbers."""
    (count,) = struct.unpack_from("<16xI", library)
    commands, offset = {}, 32
    for _ in range(count):
        number, size = struct.unpack_from("<II", library, offset)
        commands[number] = library[offset : offset + size]
        offset += size
    return commands


@needs_zig
@pytest.mark.whole
@pytest.mark.parametrize("name", ["darwin64", "aarch64-darwin"])
def test_libraries_for_macos_are_for_version_11_and_the_same_from_any_folder(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    libraries, files = [], []
    for folder in ("first", "second", "second"):
        root = tmp_path / folder
        root.mkdir(exist_ok=True)
        monkeypatch.setenv("ZIG_GLOBAL_CACHE_DIR", str(root / "cache"))
        monkeypatch.setattr(tempfile, "tempdir", str(root))
        libraries.append(cross_compilation.compile_binary("BrakeActuator", name))
        files.append({file: file.stat().st_mtime_ns for file in root.rglob("*.o")})
    assert libraries == [libraries[0]] * 3
    # The second build compiles nothing.
    assert files[2] == files[1] != {}
    commands = load_commands(libraries[0])
    (minimum_version,) = struct.unpack_from("<12xI", commands[_BUILD_VERSION])
    assert minimum_version == 11 << 16
    (start,) = struct.unpack_from("<8xI", commands[_ID_DYLIB])
    assert commands[_ID_DYLIB][start:].rstrip(b"\0") == b"@rpath/BrakeActuator.dylib"
    assert str(tmp_path).encode() not in libraries[0]


def test_without_ziglang_the_message_names_its_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cross_compilation, "find_spec", lambda _name: None)
    platform = "win64" if fmpy.platform != "win64" else "linux64"
    with pytest.raises(InputError, match=f"platform {platform}: needs ziglang: install fivtui"):
        build_fmu(tmp_path / "m.fmu", flavour="native", platforms=[platform])


@needs_zig
@pytest.mark.whole
def test_one_fmu_holds_binaries_of_several_platforms(tmp_path: Path) -> None:
    fmu = tmp_path / "all.fmu"
    arguments = [
        "fmu",
        "build",
        "--flavour",
        "native",
        "--platform",
        ",".join(reversed([*PLATFORMS])),
    ]
    assert run([*arguments, "--out", str(fmu)]) == 0
    assert check_fmu(fmu) == []
    with zipfile.ZipFile(fmu) as archive:
        binaries = {name for name in archive.namelist() if name.startswith("binaries/")}
        assert binaries == {f"binaries/{name}" for name in FIRST_BYTES}
        for name, first_bytes in FIRST_BYTES.items():
            binary = archive.read(f"binaries/{name}")
            assert binary.startswith(first_bytes), name
            for function in (b"fmi2DoStep", b"fmi2SerializeFMUstate", b"fmi3DoStep"):
                assert function in binary, name
        assert elf_processor(archive.read("binaries/aarch64-linux/SliderBelt.so")) == _ELF_ARM
        assert elf_processor(archive.read("binaries/linux64/SliderBelt.so")) != _ELF_ARM


# Before 2.0.4, FMI named no folder for ARM, and importers look in that of x86.
@pytest.mark.parametrize(
    ("fmi", "folders"), [("2", {"aarch64-linux", "linux64"}), ("3", {"aarch64-linux"})]
)
def test_arm_binaries_are_in_the_folders_that_importers_search(
    fmi: str, folders: set[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(native, "_machine", lambda: ("linux", "aarch64"))
    monkeypatch.setattr(native, "_read_binary", lambda model: model.encode())
    fmu = build_fmu(tmp_path / "arm.fmu", flavour="native", fmi=fmi)
    with zipfile.ZipFile(fmu) as archive:
        binaries = {name for name in archive.namelist() if name.startswith("binaries/")}
        assert binaries == {f"binaries/{folder}/SliderBelt.so" for folder in folders}
        assert {archive.read(name) for name in binaries} == {b"SliderBelt"}


def test_unsupported_processors_have_no_native_flavour(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(native, "_machine", lambda: ("linux", "riscv64"))
    reason = "no native FMU supports linux, riscv64; take the Python flavour"
    with pytest.raises(InputError, match=reason):
        build_fmu(tmp_path / "m.fmu", flavour="native")
    assert "riscv64" in str(native.native_failure())


def assert_results_of_kernel(emulator: str, program: Path) -> None:
    """Check that `program`, compiled from ``run.c``, gives the kernel's results to the bit."""
    process = subprocess.run(
        [emulator, str(program)], cwd=program.parent, capture_output=True, text=True, check=False
    )
    # The final state of the run by FMI 2.0, that of the run by FMI 3.0, and its number of switches.
    *states, switches = process.stdout.split()
    # The end of the last of 10 000 steps, as the program computes it: not exactly 100 s.
    kernel_run = simulate(t_end=9999 * 0.01 + 0.01, kernel="compiled")
    final = kernel_run.final
    exact = [final.x, final.vx, final.y, final.vy]
    assert [float.fromhex(number) for number in states] == [*exact, *exact]
    assert int(switches) == kernel_run.switch_times.size


@pytest.fixture
def program_arguments(tmp_path: Path) -> list[str]:
    """Compiler arguments for a program that runs the FMU."""
    for name, text in sources("SliderBelt").items():
        tmp_path.joinpath(name).write_text(text, encoding="utf-8")
    headers = Path(fmpy.__file__).parent / "c-code"
    # These two options are for libraries: code for any address, and hidden functions.
    flags = [flag for flag in FLAGS if flag not in ("-fPIC", "-fvisibility=hidden")]
    source = str(Path(__file__).with_name("run.c"))
    return [*flags, f"-I{tmp_path}", f"-I{headers}", source]


@needs_zig
@pytest.mark.whole
@pytest.mark.host
def test_the_binary_for_windows_gives_the_bits_of_the_kernel(
    tmp_path: Path, program_arguments: list[str]
) -> None:
    wine = shutil.which("wine")
    if wine is None:
        pytest.skip("there is no wine")
    program, library = tmp_path / "program.exe", tmp_path / "SliderBelt.dll"
    library.write_bytes(cross_compilation.compile_binary("SliderBelt", "win64"))
    flags = ["-target", "x86_64-windows-gnu", *program_arguments, str(library)]
    cross_compilation._run_compiler(tmp_path, *flags, "-o", str(program))
    assert_results_of_kernel(wine, program)


@needs_zig
@pytest.mark.whole
@pytest.mark.host
def test_the_binary_for_arm_gives_the_bits_of_the_kernel(
    tmp_path: Path, program_arguments: list[str]
) -> None:
    qemu = shutil.which("qemu-aarch64") or shutil.which("qemu-aarch64-static")
    if qemu is None:
        pytest.skip("there is no qemu-aarch64")
    program = tmp_path / "program"
    units = [str(path) for path in tmp_path.glob("*.c")]
    flags = ["-target", "aarch64-linux-musl", "-static", *program_arguments, *units, "-lm"]
    cross_compilation._run_compiler(tmp_path, *flags, "-o", str(program))
    assert_results_of_kernel(qemu, program)
