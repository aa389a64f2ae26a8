"""Wheels and source distribution: names, contents, binaries, the same bytes, and a first run.

`-m whole` builds the wheels of all platforms, which takes minutes. `.ci/run` runs the tests of this
machine's wheel alone, with the compiled files of its installation. Tests marked `host` depend on
what this machine has, here build tools and emulators.
"""

import json
import os
import platform
import re
import shutil
import struct
import subprocess
import sys
import tarfile
import venv
import zipfile
from collections.abc import Iterator
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

import hatch_build
from fivtui import Parameters, __version__, simulate
from fivtui.kernel import load_kernel
from fivtui.kernel.runs import RunColumns
from fmu_src.build.c_sources import MODELS
from fmu_src.build.platforms import HOSTS, PLATFORMS, Platform
from tests.fmu_native.test_cross import load_commands

ROOT = Path(__file__).parents[2]
HOST = HOSTS.get((sys.platform, platform.machine().lower()), "")
PUBLISHED = {name: target for name, target in PLATFORMS.items() if target.wheel_tag}
TOOLS = ("ziglang", "twine", "check_wheel_contents", "auditwheel")
MISSING_TOOLS = [name for name in TOOLS if find_spec(name) is None]
# Libraries that every Windows 10 has: its kernel and its C library.
_WINDOWS_LIBRARIES = re.compile(rb"(?i)^(kernel32|ntdll|api-ms-win-crt-[\w-]+)\.dll$")
_CODE_SIGNATURE = 0x1D
# Programs that run binaries of other platforms, with their arguments.
EMULATORS = {"win64": ["wine"], "aarch64-linux": ["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"]}

pytestmark = [
    pytest.mark.whole,
    pytest.mark.host,
    pytest.mark.skipif(
        bool(MISSING_TOOLS), reason=f"the extra release is not installed: {MISSING_TOOLS}"
    ),
]
of_this_machine = pytest.mark.skipif(HOST not in PUBLISHED, reason="no wheel is published for it")


def run_tool(*arguments: object, **details: Any) -> str:
    """Standard output of a program that must succeed."""
    process = subprocess.run(
        [str(argument) for argument in arguments],
        capture_output=True,
        text=True,
        check=False,
        **details,
    )
    assert process.returncode == 0, process.stdout + process.stderr
    return str(process.stdout)


@pytest.fixture(scope="session", autouse=True)
def manual(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The manual in the wheels: that of the environment, or a page in its place."""
    folder = tmp_path_factory.mktemp("manual")
    (folder / "index.html").write_text("<h1>A page in place of the manual</h1>", encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        if hatch_build.MANUAL_VARIABLE not in os.environ:
            patch.setenv(hatch_build.MANUAL_VARIABLE, str(folder))
        yield Path(os.environ[hatch_build.MANUAL_VARIABLE])


def build_into(folder: Path, *platforms: str, **variables: str) -> Path:
    """The folder with the distributions of platforms, built from the sources."""
    chosen = [argument for name in platforms for argument in ("--platform", name)]
    run_tool(
        *(sys.executable, "hatch_build.py", "--wheels", folder, *chosen),
        cwd=ROOT,
        env={**os.environ, **variables},
    )
    return folder


def digests(folder: Path) -> dict[str, str]:
    return {path.name: sha256(path.read_bytes()).hexdigest() for path in folder.iterdir()}


def wheel_of(folder: Path, name: str) -> Path:
    return folder / f"fivtui-{__version__}-py3-none-{PLATFORMS[name].wheel_tag}.whl"


@pytest.fixture(scope="session")
def dist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The source distribution and the wheel of this machine."""
    return build_into(tmp_path_factory.mktemp("dist"), HOST)


@pytest.fixture(scope="session")
def all_dist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The source distribution and the wheels of all platforms."""
    return build_into(tmp_path_factory.mktemp("all"))


def check_distributions(folder: Path) -> None:
    """The checks of package indexes, and of auditwheel for the wheels of Linux."""
    paths = sorted(folder.iterdir())
    wheels = [path for path in paths if path.suffix == ".whl"]
    assert run_tool(sys.executable, "-m", "twine", "check", "--strict", *paths).count("PASS") >= 2
    run_tool(sys.executable, "-m", "check_wheel_contents", *wheels, cwd=ROOT)
    for wheel in (wheel for wheel in wheels if "manylinux" in wheel.name):
        shown = " ".join(run_tool(sys.executable, "-m", "auditwheel", "show", wheel).split())
        (tag,) = (PLATFORMS[n].wheel_tag for n in PUBLISHED if wheel_of(folder, n) == wheel)
        assert f'consistent with the following platform tag: "{tag}"' in shown


@of_this_machine
def test_the_wheel_of_this_machine_passes_the_checks(dist: Path) -> None:
    assert {path.name for path in dist.iterdir()} == {
        f"fivtui-{__version__}.tar.gz",
        wheel_of(dist, HOST).name,
    }
    check_distributions(dist)


@of_this_machine
def test_a_second_build_of_this_machine_gives_the_same_bytes(dist: Path, tmp_path: Path) -> None:
    assert digests(build_into(tmp_path / "second", HOST)) == digests(dist)


@of_this_machine
def test_the_wheel_runs_in_an_empty_environment_without_a_compiler(
    dist: Path, manual: Path, tmp_path: Path
) -> None:
    venv.create(tmp_path / "venv", with_pip=True)
    programs = tmp_path / "venv" / ("Scripts" if sys.platform == "win32" else "bin")
    run_tool(
        *(programs / "python", "-m", "pip", "install", "-q", "--only-binary=:all:", "--no-compile"),
        *("-c", ROOT / ".ci" / "constraints.txt", wheel_of(dist, HOST)),
        env={name: value for name, value in os.environ.items() if name != "PYTHONPATH"},
    )
    # Only the environment's programs are found: no compiler, no zig.
    environment = {"PATH": str(programs), "HOME": str(tmp_path), "CC": "none"}
    if sys.platform == "win32":
        environment |= {"SYSTEMROOT": os.environ["SYSTEMROOT"], "TEMP": str(tmp_path)}
    for name in ("cc", "gcc", "clang", "zig"):
        assert shutil.which(name, path=environment["PATH"]) is None
    fivtui = str(programs / "fivtui")
    code = "import importlib.util as u; print(u.find_spec('ziglang'), u.find_spec('hatchling'))"
    assert run_tool(programs / "python", "-c", code, env=environment).split() == ["None"] * 2

    def run(*arguments: str) -> str:
        return run_tool(fivtui, *arguments, cwd=tmp_path, env=environment)

    assert run("--version") == f"fivtui {__version__}\n"
    (page,) = (tmp_path / "venv").rglob("fivtui/manual/index.html")
    assert run("docs").strip() == page.as_uri()
    assert page.read_bytes() == (manual / "index.html").read_bytes()
    run_there = json.loads(run("simulate", "--t-end", "20", "--json"))
    run_here = simulate(Parameters(), t_end=20.0)
    assert run_there["final"]["y"] == run_here.final.y
    code = "import fivtui.kernel; print(fivtui.kernel.why_interpreted())"
    assert run_tool(programs / "python", "-c", code, env=environment) == "None\n"
    # Native FMUs need only the C library where they run; those of the other flavour need Python.
    run("fmu", "build", "--flavour", "native", "--out", "m.fmu")
    assert "no problems" in run("fmu", "check", "m.fmu")
    final = json.loads(run("fmu", "run", "m.fmu", "--t-end", "20", "--json"))["final"]
    assert final["y"] == run_here.final.y
    # `compare` runs a scene with separation considered and ignored, in the kernel and in an FMU.
    # Its picture has contact force and displacements, as Figs. 10 to 12 of the paper.
    (tmp_path / "short.toml").write_text("fivtui_scene = 1\nt_end = 20.0\n", encoding="utf-8")
    assert run("compare", "short.toml", "--out", "compared")
    assert (tmp_path / "compared" / "figs-10-12.png").stat().st_size > 10_000


def test_the_wheels_of_all_platforms_pass_the_checks(all_dist: Path) -> None:
    expected = {wheel_of(all_dist, name).name for name in PUBLISHED}
    assert {path.name for path in all_dist.glob("*.whl")} == expected
    check_distributions(all_dist)


def test_wheels_hold_the_libraries_of_their_platform_and_no_tools(all_dist: Path) -> None:
    for name, target in PUBLISHED.items():
        with zipfile.ZipFile(wheel_of(all_dist, name)) as archive:
            names = set(archive.namelist())
            metadata = archive.read(f"fivtui-{__version__}.dist-info/WHEEL").decode()
            libraries = {
                "fivtui/kernel/libfivtui": archive.read(f"fivtui/kernel/libfivtui{target.suffix}"),
                **{
                    f"fmu_src/native/{model}": archive.read(
                        f"fmu_src/native/{model}{target.suffix}"
                    )
                    for model in MODELS
                },
            }
        assert f"Tag: py3-none-{target.wheel_tag}\n" in metadata
        assert "Root-Is-Purelib: false\n" in metadata
        binaries = {entry for entry in names if Path(entry).suffix in (".so", ".dll", ".dylib")}
        assert binaries == {f"{library}{target.suffix}" for library in libraries}
        tops = {entry.partition("/")[0] for entry in names}
        assert tops == {"fivtui", "fmu_src", f"fivtui-{__version__}.dist-info"}
        # A build that fails leaves this file, with the reason, in place of the library.
        assert "fivtui/kernel/libfivtui.txt" not in names
        for library, content in libraries.items():
            check_binary(content, target, library)


def check_binary(content: bytes, target: Platform, name: str) -> None:
    """A library is for the platform's system and processor, and needs only its system."""
    if target.suffix == ".so":
        (machine,) = struct.unpack_from("<H", content, 18)
        assert (content[:4], machine) == (b"\x7fELF", 62 if target.is_x86 else 183), name
    elif target.suffix == ".dylib":
        (processor,) = struct.unpack_from("<4xI", content)
        assert processor == (0x01000007 if target.is_x86 else 0x0100000C), name
        # macOS on ARM refuses code without a signature; zig signs it.
        assert target.is_x86 or _CODE_SIGNATURE in load_commands(content), name
        assert str(ROOT).encode() not in content, name
    else:
        assert set(map(bool, map(_WINDOWS_LIBRARIES.match, imported_libraries(content)))) == {True}


def imported_libraries(content: bytes) -> Iterator[bytes]:
    """The libraries that a 64-bit Windows library imports."""
    (start,) = struct.unpack_from("<I", content, 0x3C)
    machine, sections, optional_size = struct.unpack_from("<HH12xH", content, start + 4)
    assert machine == 0x8664
    (table,) = struct.unpack_from("<I", content, start + 24 + 120)
    headers = [
        struct.unpack_from("<8xIIII", content, start + 24 + optional_size + 40 * index)
        for index in range(sections)
    ]

    def offset(address: int) -> int:
        return next(
            int(address - virtual + raw)
            for size, virtual, _, raw in headers
            if virtual <= address < virtual + size
        )

    row = offset(table)
    while name := struct.unpack_from("<12xI", content, row)[0]:
        begin = offset(name)
        yield content[begin : content.index(b"\0", begin)]
        row += 20


def test_another_build_of_all_platforms_gives_the_same_bytes(
    all_dist: Path, tmp_path: Path
) -> None:
    # Nothing that was compiled before is used.
    cache = str(tmp_path / "cache")
    second = build_into(
        tmp_path / "second", ZIG_GLOBAL_CACHE_DIR=cache, ZIG_LOCAL_CACHE_DIR=cache, TZ="Asia/Tokyo"
    )
    assert digests(second) == digests(all_dist)


def test_the_source_distribution_builds_the_same_wheel(dist: Path, tmp_path: Path) -> None:
    (archive,) = dist.glob("*.tar.gz")
    with tarfile.open(archive) as file:
        file.extractall(tmp_path, filter="data")
    (source,) = tmp_path.iterdir()
    run_tool(
        *(sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation"),
        *("-w", tmp_path / "wheels", source),
    )
    (wheel,) = (tmp_path / "wheels").iterdir()
    assert wheel.read_bytes() == wheel_of(dist, HOST).read_bytes()


def test_a_platform_without_wheels_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="no wheels for vax"):
        hatch_build.build_distributions(tmp_path, ["vax"])


@pytest.mark.parametrize("name", [HOST, *EMULATORS])
def test_the_library_of_the_wheel_is_loaded_and_gives_the_same_bits(
    name: str, tmp_path: Path, all_dist: Path
) -> None:
    emulator = EMULATORS.get(name, []) if name != HOST else []
    if emulator and shutil.which(emulator[0]) is None:
        pytest.skip(f"not installed: {emulator[0]}")
    if emulator[1:] and not Path(emulator[-1]).is_dir():
        pytest.skip(f"the libraries of the platform are not in {emulator[-1]}")
    target = PLATFORMS[name]
    library = f"fivtui/kernel/libfivtui{target.suffix}"
    with zipfile.ZipFile(wheel_of(all_dist, name)) as archive:
        archive.extract(library, tmp_path)
    program = tmp_path / ("load.exe" if name == "win64" else "load")
    source = Path(__file__).with_name("load.c")
    zig = [sys.executable, "-m", "ziglang", "cc", "-target", target.triple]
    run_tool(*zig, "-O1", source, "-o", program, *([] if name == "win64" else ["-ldl"]))
    printed = run_tool(*emulator, program, tmp_path / library, cwd=tmp_path)
    numbers = [float.fromhex(text) for text in printed.split()]
    p = Parameters()
    # So short a run ends where it starts: at rest in the static position.
    start = simulate(p, t_end=1e-300).final
    run = load_kernel().begin_run(
        [p.m, p.k1, p.k2, p.k3, p.c1, p.c2, p.F, p.k_nl, p.mu],
        [start.x, start.vx, start.y, start.vy],
        separation=True,
        t_end=100.0,
        tol=1e-15,
        order=20,
    )
    while run.advance(1000).name == "RUNNING":
        pass
    outcome = RunColumns(*run.outcome)
    assert numbers == [outcome.x, outcome.vx, outcome.y, outcome.vy]
