"""Build hook: compiles the kernel in C when the package is installed or packed into a wheel.

One shared library holds the kernel for all instruction sets of the processor's family; the program
selects one when it loads the library (`fivtui.kernel.native`). If compilation fails, a file with
the reason replaces the library, and the installation continues. The program then reports the
reason and runs interpreted.

A second hook makes the readme of package indexes.

`python hatch_build.py` compiles in place, `python hatch_build.py --wheels DIST` builds the manual,
the wheels of all platforms with it, and the source distribution.
"""

import argparse
import hashlib
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final, NamedTuple
from unittest import mock

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface

ROOT: Final = Path(__file__).parent
FOLDER: Final = Path("fivtui", "kernel")
# File with the reason, in place of a missing library.
REASON: Final = "libfivtui.txt"
_SUFFIXES: Final = {"win32": ".dll", "darwin": ".dylib"}
LIBRARY_SUFFIX: Final = _SUFFIXES.get(sys.platform, ".so")
LIBRARY: Final = f"libfivtui{LIBRARY_SUFFIX}"
# Folder, reason file and names of the native FMU binaries.
FMU_FOLDER: Final = Path("fmu_src", "native")
FMU_REASON: Final = "native.txt"
FMU_MODELS: Final = ("SliderBelt", "BrakeActuator")
# Values of -march by instruction set; other processors have a single one.
_X86_PROCESSORS: Final = {"baseline": "x86-64", "avx2": "x86-64-v3", "avx512": "x86-64-v4"}
# C files of single runs, which gain nothing from registers wider than AVX2's; files of lanes.
_SINGLE_RUN_UNITS: Final = ("single", "belt", "vary", "orbit")
_LANE_UNITS: Final = ("lanes", "belt_lanes")
# Environment variable with the platform of a wheel, a name in `fmu_src.build.platforms`.
PLATFORM_VARIABLE: Final = "FIVTUI_PLATFORM"
# Environment variable with the folder of the manual as HTML, which wheels then contain.
MANUAL_VARIABLE: Final = "FIVTUI_MANUAL"
MANUAL_FOLDER: Final = "fivtui/manual"
# For one call of a compiler, s. The first one for Windows also compiles its C library.
_TIMEOUT_S: Final = 1800.0


class CompilerError(Exception):
    """The kernel cannot be compiled."""


class _Compiler(NamedTuple):
    """A C compiler, and what it compiles for: suffix of libraries, processor, tag of wheels."""

    name: str
    command: list[str]
    suffix: str
    is_x86: bool
    tag: str = ""

    @property
    def is_zig(self) -> bool:
        return self.name == "ziglang"


# Compiler arguments by object file, and object files by library.
class _Plan(NamedTuple):
    objects: dict[str, list[str]]
    libraries: dict[Path, list[str]]


_Planner = Callable[[_Compiler, Path], _Plan]


def compile_kernel(folder: Path, target: Path) -> str:
    """Compile the kernel in `folder` into the library `target`; returns the compiler's name.

    Raises
    ------
    CompilerError
        If no compiler succeeds.
    """
    compilers = _compilers(folder.parents[1])
    plan = partial(_kernel_plan, folder, target.parent)
    return _compile_with_any([plan], compilers).name


def compile_all(
    root: Path, kernel: Path, fmus: Path, platform_name: str = ""
) -> tuple[_Compiler, str | None]:
    """Compile the kernel below `root` into the folder `kernel`, the FMUs' binaries into `fmus`.

    `platform_name` is one of `fmu_src.build.platforms`, by default this machine. Returns the
    compiler, and the reason for missing binaries of FMUs, None if they exist.

    Raises
    ------
    CompilerError
        If no compiler succeeds with the kernel.
    """
    compilers = _compilers(root, platform_name)
    plan_kernel = partial(_kernel_plan, root / FOLDER, kernel)
    headers = _fmi_headers()
    if headers is None:
        why = "fmpy, which has the headers of FMI, is not installed"
        return _compile_with_any([plan_kernel], compilers), why
    try:
        plans = [plan_kernel, partial(_fmu_plan, root, fmus, headers)]
        return _compile_with_any(plans, compilers), None
    except CompilerError as error:
        return _compile_with_any([plan_kernel], compilers), str(error)


def _compile_with_any(plans: Sequence[_Planner], compilers: Sequence[_Compiler]) -> _Compiler:
    failures = []
    for compiler in compilers:
        try:
            _compile(plans, compiler)
        except (OSError, subprocess.SubprocessError) as error:
            output = getattr(error, "stderr", None) or f"{error}"[-200:]
            lines = [line for line in output.strip().splitlines() if "error" in line.lower()]
            failures.append(f"{compiler.name}: {(lines or [output.strip()])[0][:200]}")
        else:
            return compiler
    raise CompilerError("; ".join(failures) or "no C compiler: install ziglang or cc")


def _compilers(root: Path, platform_name: str = "") -> list[_Compiler]:
    # Prefer ziglang, which is the same on every machine, to the local compiler.
    compilers = []
    platforms = _import_generator("fmu_src.build.platforms", root)
    host = platforms.HOSTS.get((sys.platform, platform.machine().lower()))
    if sys.platform == "linux" and platform.libc_ver()[0] != "glibc":
        host = None
    if find_spec("ziglang") is not None:
        zig = [sys.executable, "-m", "ziglang", "cc"]
        if (name := platform_name or host) is not None:
            target = platforms.PLATFORMS[name]
            zig += ["-target", target.triple]
            suffix, is_x86, tag = target.suffix, target.is_x86, target.wheel_tag
        else:
            suffix, is_x86, tag = LIBRARY_SUFFIX, _is_x86(), ""
        compilers.append(_Compiler("ziglang", zig, suffix, is_x86, tag))
    cc = shlex.split(os.environ.get("CC", "cc"))
    if platform_name in ("", host) and shutil.which(cc[0]) is not None:
        compilers.append(_Compiler(cc[0], cc, LIBRARY_SUFFIX, _is_x86()))
    return compilers


def _is_x86() -> bool:
    return platform.machine().lower() in ("x86_64", "amd64")


def _variants(compiler: _Compiler) -> dict[str, list[str]]:
    # Compiler options by instruction set.
    variants = {}
    for variant, processor in (_X86_PROCESSORS if compiler.is_x86 else {"baseline": ""}).items():
        # zig writes processor names with underscores.
        processor_name = processor.replace("-", "_") if compiler.is_zig else processor
        options = [f"-march={processor_name}"] if processor else []
        options += ["-mprefer-vector-width=512"] if variant == "avx512" else []
        variants[variant] = [*options, f"-DVARIANT={variant}"]
    return variants


def _kernel_plan(folder: Path, home: Path, compiler: _Compiler, scratch: Path) -> _Plan:
    text = _import_generator("fivtui.kernel.field_text", folder.parents[1])
    generated = _write_generated(text.equation_headers(), scratch)
    definitions = [f'-DSOURCES="{text.sources_digest(folder)}"', f'-DCOMPILER="{compiler.name}"']
    flags = _flags(text.FLAGS, compiler)
    objects = {"loading": [*flags, *definitions, str(folder / "loading.c")]}
    common = [*flags, f"-I{generated}", f"-I{folder}"]
    for variant, options in _variants(compiler).items():
        # Registers wider than those of AVX2 slow one run down.
        for unit in _LANE_UNITS if variant == "avx512" else (*_SINGLE_RUN_UNITS, *_LANE_UNITS):
            objects[f"{unit}_{variant}"] = [*common, *options, str(folder / f"{unit}.c")]
    return _Plan(objects, {home / f"libfivtui{compiler.suffix}": list(objects)})


def _flags(flags: Sequence[str], compiler: _Compiler) -> list[str]:
    # Code for Windows can be loaded at any address, and compilers refuse the option there.
    return [flag for flag in flags if (flag, compiler.suffix) != ("-fPIC", ".dll")]


def _fmi_headers() -> Path | None:
    # Do not import fmpy, which loads other packages.
    package = find_spec("fmpy")
    folder = Path(str(package.origin)).parent / "c-code" if package is not None else None
    return folder if folder is not None and (folder / "fmi2Functions.h").is_file() else None


def _fmu_plan(root: Path, home: Path, headers: Path, compiler: _Compiler, scratch: Path) -> _Plan:
    text = _import_generator("fmu_src.build.c_sources", root)
    fmi_headers = {path.name: path.read_text("utf-8") for path in headers.glob("fmi*.h")}
    generated = _write_generated({**text.generated_files(), **fmi_headers}, scratch)
    native = root / FMU_FOLDER
    folders = native, root / FOLDER, generated
    flags = _flags(_import_generator("fivtui.kernel.field_text", root).FLAGS, compiler)
    common = [*flags, *(f"-I{folder}" for folder in folders)]
    objects, libraries = {}, {}
    shared = list(text.SHARED_UNITS)
    for unit in text.SHARED_UNITS:
        objects[unit] = [*common, "-O2", str(native / f"{unit}.c")]
    stepping: list[str] = []
    for variant, options in [*_variants(compiler).items()][:2]:
        stepping.append(f"{text.STEPPING_UNIT}_{variant}")
        objects[stepping[-1]] = [*common, *options, str(native / f"{text.STEPPING_UNIT}.c")]
    chosen = ["-DWITH_AVX2"] if "stepping_avx2" in stepping else []
    for model, units in text.UNITS.items():
        for unit in units:
            objects[unit] = [*common, "-O2", *chosen, str(native / f"{unit}.c")]
        needed = [*shared, *units, *(stepping if "processor" in units else ())]
        libraries[home / f"{model}{compiler.suffix}"] = needed
    return _Plan(objects, libraries)


def _write_generated(texts: Mapping[str, str], scratch: Path) -> Path:
    # The folder of generated files. zig compiles nothing anew if their paths are the same, so they
    # are in its cache if there is a lasting one.
    content = "\0".join(f"{name}\0{text}" for name, text in sorted(texts.items()))
    name = f"fivtui-{hashlib.sha256(content.encode()).hexdigest()[:32]}"
    folder = Path(os.environ.get("ZIG_GLOBAL_CACHE_DIR", scratch)) / name
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        file = folder / name
        if not file.is_file() or file.read_text(encoding="utf-8") != text:
            # Another process may write or read the same file.
            new = file.with_name(f"{name}.{os.getpid()}")
            new.write_text(text, encoding="utf-8")
            new.replace(file)
    return folder


def _import_generator(name: str, root: Path) -> Any:
    # Import a module that generates C text; it needs only the standard library.
    sys.path.insert(0, str(root))
    try:
        return import_module(name)
    finally:
        sys.path.remove(str(root))


def _compile(plans: Sequence[_Planner], compiler: _Compiler) -> None:
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        environment = dict(os.environ)
        if compiler.is_zig:
            # Use temporary caches unless the environment sets them.
            for cache in ("GLOBAL", "LOCAL"):
                environment.setdefault(f"ZIG_{cache}_CACHE_DIR", folder)

        def run(*arguments: str) -> None:
            subprocess.run(  # noqa: S603, a compiler
                [*compiler.command, *arguments],
                env=environment,
                check=True,
                capture_output=True,
                text=True,
                timeout=_TIMEOUT_S,
            )

        planned = [plan(compiler, scratch) for plan in plans]
        objects = {part: arguments for plan in planned for part, arguments in plan.objects.items()}
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            list(
                pool.map(
                    lambda part: run(*objects[part], "-c", "-o", f"{folder}/{part}.o"),
                    objects,
                )
            )
        for target, parts in (pair for plan in planned for pair in plan.libraries.items()):
            library = scratch / target.name
            object_files = [f"{folder}/{part}.o" for part in parts]
            libraries = [] if target.suffix == ".dll" else ["-lm"]
            if target.suffix == ".dylib":
                # Without this option the library records the path of the temporary folder.
                libraries.append(f"-Wl,-install_name,@rpath/{target.name}")
            if target.suffix == ".dll" and compiler.is_zig:
                # Without this option the library records the time.
                libraries.append("-Wl,-Brepro")
            run("-shared", "-s", *object_files, "-o", str(library), *libraries)
            # Replace a library that is in use; do not overwrite it.
            new = target.with_name(f"{target.name}.{os.getpid()}")
            shutil.copyfile(library, new)
            new.replace(target)


class KernelBuildHook(BuildHookInterface):  # type: ignore[type-arg, unused-ignore]
    """Compiles the kernel into wheels; into the sources themselves where these are installed."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, and add the libraries or the reasons why there are none."""
        if self.target_name != "wheel":
            return
        root = Path(self.root)
        editable = version == "editable"
        if (manual := os.environ.get(MANUAL_VARIABLE)) and not editable:
            if not Path(manual, "index.html").is_file():
                self.app.abort(f"{MANUAL_VARIABLE} = {manual}: must have the manual's index.html")
            build_data["force_include"][manual] = MANUAL_FOLDER
        self._temporary = None if editable else tempfile.TemporaryDirectory()
        homes = {
            folder: root / folder
            if self._temporary is None
            else Path(self._temporary.name) / folder
            for folder in (FOLDER, FMU_FOLDER)
        }
        for home in homes.values():
            home.mkdir(parents=True, exist_ok=True)
        compiler = self._compile(root, *homes.values())
        if compiler is not None:
            build_data["pure_python"] = False
            local_tag = sysconfig.get_platform().replace("-", "_").replace(".", "_")
            build_data["tag"] = f"py3-none-{compiler.tag or local_tag}"
        if self._temporary is not None:
            for folder, home in homes.items():
                for file in home.iterdir():
                    build_data["force_include"][str(file)] = str(folder / file.name)

    def _compile(self, root: Path, kernel: Path, fmus: Path) -> _Compiler | None:
        # Compile into two folders, or write the reasons why not; a requested platform must succeed.
        platform_name = os.environ.get(PLATFORM_VARIABLE, "")
        # Libraries of an earlier installation stay until compilation has succeeded or failed.
        compiler = kernel_why = None
        try:
            compiler, why = compile_all(root, kernel, fmus, platform_name)
        except CompilerError as error:
            why = kernel_why = str(error)
            self.app.display_warning(f"The kernel is not compiled: {why}")
        _write_reason(kernel / REASON, kernel_why, [LIBRARY])
        _write_reason(fmus / FMU_REASON, why, [f"{model}{LIBRARY_SUFFIX}" for model in FMU_MODELS])
        if why is not None:
            if platform_name:
                self.app.abort(f"{platform_name}: {why}")
            self.app.display_warning(f"There will be no native FMU: {why}")
        if compiler is not None and not compiler.is_zig:
            self.app.display_warning(f"The kernel is compiled by {compiler.name}, not by ziglang")
        return compiler

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:  # noqa: ARG002
        """Remove what was compiled outside the sources."""
        temporary = getattr(self, "_temporary", None)
        if temporary is not None:
            temporary.cleanup()


class IndexReadmeHook(MetadataHookInterface):  # type: ignore[misc, unused-ignore]
    """Makes the readme of package indexes, which have none of the files that README.md links."""

    PLUGIN_NAME = "custom"

    def update(self, metadata: dict[str, Any]) -> None:
        """Replace pictures by what they show, and links to files by their texts."""
        text = (Path(self.root) / "README.md").read_text(encoding="utf-8")
        text = re.sub(r"!\[([^\]]*)\]\((?!https?:)[^)]*\)", r"*Picture: \1.*", text)
        text = re.sub(r"\[([^\]]*)\]\((?!https?:|#)[^)]*\)", r"\1", text)
        metadata["readme"] = {"content-type": "text/markdown", "text": text}


def _write_reason(file: Path, why: str | None, outdated: Sequence[str] = ()) -> None:
    # Write why libraries could not be compiled, or remove the file if they were. Remove outdated
    # libraries beside it, which would hide the reason.
    if why is None:
        file.unlink(missing_ok=True)
        return
    for library in outdated:
        file.with_name(library).unlink(missing_ok=True)
    file.write_text(f"{why}\n", encoding="utf-8")


def compile_in_place() -> None:
    """Compile into the sources, for those who work on the kernel.

    Libraries that cannot be compiled anew stay: they are used with the sources they were made of.
    """
    try:
        compiler, why = compile_all(ROOT, ROOT / FOLDER, ROOT / FMU_FOLDER)
    except CompilerError as error:
        sys.exit(f"the kernel is not compiled: {error}")
    _write_reason(ROOT / FOLDER / REASON, None)
    _write_reason(ROOT / FMU_FOLDER / FMU_REASON, why)
    sys.stdout.write(f"compiled by {compiler.name}\n" + (f"no native FMU: {why}\n" if why else ""))


def build_distributions(folder: Path, platform_names: Sequence[str] = ()) -> list[Path]:
    """Build the source distribution and the wheels of platforms, by default of all.

    Needs ziglang, and Sphinx for the manual, unless the environment names its folder. Ends the
    program if the manual cannot be built or a wheel cannot be compiled.
    """
    from hatchling.builders.sdist import SdistBuilder
    from hatchling.builders.wheel import WheelBuilder

    platforms = _import_generator("fmu_src.build.platforms", ROOT).PLATFORMS
    published = [name for name, target in platforms.items() if target.wheel_tag]
    if unknown := {*platform_names} - {*published}:
        sys.exit(f"no wheels for {', '.join(unknown)} (known: {', '.join(published)})")
    with tempfile.TemporaryDirectory() as scratch:
        manual = os.environ.get(MANUAL_VARIABLE) or _build_manual(Path(scratch))
        built = list(SdistBuilder(str(ROOT)).build(directory=str(folder)))
        for name in platform_names or published:
            variables = {PLATFORM_VARIABLE: name, MANUAL_VARIABLE: manual}
            with mock.patch.dict(os.environ, variables):
                built += WheelBuilder(str(ROOT)).build(directory=str(folder), versions=["standard"])
    return [Path(path) for path in built]


def _build_manual(scratch: Path) -> str:
    # Keep Sphinx's cache out of the manual.
    options = ["-W", "-q", "-b", "html", "-d", str(scratch / "cache")]
    manual = scratch / "manual"
    sphinx = [sys.executable, "-m", "sphinx", *options, str(ROOT / "docs"), str(manual)]
    if subprocess.run(sphinx, cwd=ROOT, check=False).returncode != 0:  # noqa: S603
        sys.exit(f"the manual cannot be built: install '.[docs]', or set {MANUAL_VARIABLE}")
    return str(manual)


def main() -> None:
    """Compile in place, or build distributions."""
    parser = argparse.ArgumentParser(description="Compile in place, or build distributions.")
    parser.add_argument("--wheels", metavar="DIST", type=Path, help="build wheels into this folder")
    parser.add_argument(
        "--platform", action="append", default=[], help="a wheel's platform; by default all"
    )
    arguments = parser.parse_args()
    if arguments.wheels is None:
        compile_in_place()
        return
    for path in build_distributions(arguments.wheels, arguments.platform):
        sys.stdout.write(f"{path}\n")


if __name__ == "__main__":
    main()
