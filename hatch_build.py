"""Build hook: compiles the kernel in C when the package is installed.

One shared library holds the kernel for all instruction sets of the processor's family; the program
selects one when it loads the library (`fivtui.kernel.native`). If compilation fails, a file with
the reason replaces the library, and the installation continues. The program then reports the
reason and runs interpreted.
"""

import os
import platform
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final, NamedTuple

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

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
_GLIBC: Final = "2.17"
_MACOS: Final = "11.0"
_TIMEOUT_S: Final = 600.0


class CompilerError(Exception):
    """The kernel cannot be compiled."""


def compile_kernel(folder: Path, target: Path) -> str:
    """Compile the kernel in `folder` into the library `target`; returns the compiler's name.

    Raises
    ------
    CompilerError
        If no compiler succeeds.
    """
    return _compile_with_any([lambda *context: _kernel_plan(folder, target, *context)])


def compile_all(root: Path, kernel: Path, fmus: Path) -> tuple[str, str | None]:
    """Compile the kernel below `root` into the folder `kernel`, the FMUs' binaries into `fmus`.

    Returns the compiler's name, and the reason for missing binaries of FMUs, None if they exist.

    Raises
    ------
    CompilerError
        If no compiler succeeds with the kernel.
    """

    def plan_kernel(compiler: str, scratch: Path) -> "_Plan":
        return _kernel_plan(root / FOLDER, kernel / LIBRARY, compiler, scratch)

    headers = _fmi_headers()
    if headers is None:
        return _compile_with_any(
            [plan_kernel]
        ), "fmpy, which has the headers of FMI, is not installed"
    try:
        plans = [plan_kernel, lambda *context: _fmu_plan(root, fmus, headers, *context)]
        return _compile_with_any(plans), None
    except CompilerError as error:
        return _compile_with_any([plan_kernel]), str(error)


# Compiler arguments by object file, and object files by library.
class _Plan(NamedTuple):
    objects: dict[str, list[str]]
    libraries: dict[Path, list[str]]


def _compile_with_any(plans: Sequence[Callable[[str, Path], _Plan]]) -> str:
    failures = []
    for name, command in _compilers():
        try:
            _compile(plans, name, command)
        except (OSError, subprocess.SubprocessError) as error:
            output = getattr(error, "stderr", None) or str(error)
            lines = [line for line in output.strip().splitlines() if "error" in line.lower()]
            failures.append(f"{name}: {(lines or [output.strip()])[0][:200]}")
        else:
            return name
    raise CompilerError("; ".join(failures) or "no C compiler: install ziglang or cc")


def _compilers() -> list[tuple[str, list[str]]]:
    # Prefer ziglang, which is the same on every machine, to the local compiler.
    compilers = []
    if find_spec("ziglang") is not None:
        zig = [sys.executable, "-m", "ziglang", "cc"]
        if sys.platform == "linux" and platform.libc_ver()[0] == "glibc":
            zig += ["-target", f"{platform.machine()}-linux-gnu.{_GLIBC}"]
        elif sys.platform == "darwin":
            processor = platform.machine().replace("arm64", "aarch64")
            zig += ["-target", f"{processor}-macos.{_MACOS}"]
        compilers.append(("ziglang", zig))
    cc = shlex.split(os.environ.get("CC", "cc"))
    if shutil.which(cc[0]) is not None:
        compilers.append((cc[0], cc))
    return compilers


def _variants(compiler: str) -> dict[str, list[str]]:
    # Compiler options by instruction set.
    x86 = platform.machine().lower() in ("x86_64", "amd64")
    variants = {}
    for variant, processor in (_X86_PROCESSORS if x86 else {"baseline": ""}).items():
        # zig writes processor names with underscores.
        processor_name = processor.replace("-", "_") if compiler == "ziglang" else processor
        options = [f"-march={processor_name}"] if processor else []
        options += ["-mprefer-vector-width=512"] if variant == "avx512" else []
        variants[variant] = [*options, f"-DVARIANT={variant}"]
    return variants


def _kernel_plan(folder: Path, target: Path, compiler: str, scratch: Path) -> _Plan:
    text = _import_generator("fivtui.kernel.field_text", folder.parents[1])
    for name, header in text.headers().items():
        (scratch / name).write_text(header, encoding="utf-8")
    definitions = [f'-DSOURCES="{text.sources_digest(folder)}"', f'-DCOMPILER="{compiler}"']
    objects = {"loading": [*text.FLAGS, *definitions, str(folder / "loading.c")]}
    common = [*text.FLAGS, f"-I{scratch}", f"-I{folder}"]
    for variant, options in _variants(compiler).items():
        # Registers wider than those of AVX2 slow one run down.
        for unit in _LANE_UNITS if variant == "avx512" else (*_SINGLE_RUN_UNITS, *_LANE_UNITS):
            objects[f"{unit}_{variant}"] = [*common, *options, str(folder / f"{unit}.c")]
    return _Plan(objects, {target: list(objects)})


def _fmi_headers() -> Path | None:
    # Do not import fmpy, which loads other packages.
    package = find_spec("fmpy")
    folder = Path(str(package.origin)).parent / "c-code" if package is not None else None
    return folder if folder is not None and (folder / "fmi2Functions.h").is_file() else None


def _fmu_plan(root: Path, home: Path, headers: Path, compiler: str, scratch: Path) -> _Plan:
    text = _import_generator("fmu_src.build.c_sources", root)
    for name, content in text.generated_files().items():
        (scratch / name).write_text(content, encoding="utf-8")
    native = root / FMU_FOLDER
    folders = native, root / FOLDER, scratch, headers
    flags = _import_generator("fivtui.kernel.field_text", root).FLAGS
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
        libraries[home / f"{model}{LIBRARY_SUFFIX}"] = needed
    return _Plan(objects, libraries)


def _import_generator(name: str, root: Path) -> Any:
    # Import a module that generates C text; it needs only the standard library.
    sys.path.insert(0, str(root))
    try:
        return import_module(name)
    finally:
        sys.path.remove(str(root))


def _compile(
    plans: Sequence[Callable[[str, Path], _Plan]], name: str, command: Sequence[str]
) -> None:
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        environment = dict(os.environ)
        if name == "ziglang":
            # Use temporary caches unless the environment sets them.
            for cache in ("GLOBAL", "LOCAL"):
                environment.setdefault(f"ZIG_{cache}_CACHE_DIR", folder)

        def run(*arguments: str) -> None:
            subprocess.run(  # noqa: S603, a compiler
                [*command, *arguments],
                env=environment,
                check=True,
                capture_output=True,
                text=True,
                timeout=_TIMEOUT_S,
            )

        planned = [plan(name, scratch) for plan in plans]
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
            libraries = [] if sys.platform == "win32" else ["-lm"]
            if target.suffix == ".dylib":
                # Without this option the library records the path of the temporary folder.
                libraries.append(f"-Wl,-install_name,@rpath/{target.name}")
            run("-shared", "-s", *object_files, "-o", str(library), *libraries)
            # Replace a library that is in use; do not overwrite it.
            new = target.with_name(f"{target.name}.{os.getpid()}")
            shutil.copyfile(library, new)
            new.replace(target)


def _platform_tag(compiler: str) -> str:
    if compiler == "ziglang" and sys.platform == "linux" and platform.libc_ver()[0] == "glibc":
        return f"manylinux_{_GLIBC.replace('.', '_')}_{platform.machine()}"
    return sysconfig.get_platform().replace("-", "_").replace(".", "_")


class KernelBuildHook(BuildHookInterface):  # type: ignore[type-arg, unused-ignore]
    """Compiles the kernel into wheels; into the sources themselves where these are installed."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, and add the libraries or the reasons why there are none."""
        if self.target_name != "wheel":
            return
        root = Path(self.root)
        editable = version == "editable"
        self._temporary = None if editable else tempfile.TemporaryDirectory()
        homes = {
            folder: root / folder
            if self._temporary is None
            else Path(self._temporary.name) / folder
            for folder in (FOLDER, FMU_FOLDER)
        }
        for folder, home in homes.items():
            home.mkdir(parents=True, exist_ok=True)
            _remove_products(root / folder if editable else home)
        try:
            compiler, why = compile_all(root, *homes.values())
        except CompilerError as error:
            why = str(error)
            (homes[FOLDER] / REASON).write_text(f"{error}\n", encoding="utf-8")
            self.app.display_warning(f"The kernel is not compiled: {error}")
        else:
            build_data["pure_python"] = False
            build_data["tag"] = f"py3-none-{_platform_tag(compiler)}"
            if compiler != "ziglang":
                self.app.display_warning(f"The kernel is compiled by {compiler}, not by ziglang")
        if why is not None:
            (homes[FMU_FOLDER] / FMU_REASON).write_text(f"{why}\n", encoding="utf-8")
            self.app.display_warning(f"There will be no native FMU: {why}")
        if self._temporary is not None:
            for folder, home in homes.items():
                for file in home.iterdir():
                    build_data["force_include"][str(file)] = str(folder / file.name)

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:  # noqa: ARG002
        """Remove what was compiled outside the sources."""
        temporary = getattr(self, "_temporary", None)
        if temporary is not None:
            temporary.cleanup()


def _remove_products(folder: Path) -> None:
    products = (LIBRARY, REASON, FMU_REASON, *(f"{model}{LIBRARY_SUFFIX}" for model in FMU_MODELS))
    for name in products:
        (folder / name).unlink(missing_ok=True)


def main() -> None:
    """Compile in place, for those who work on the kernel."""
    root = Path(__file__).parent
    for folder in (FOLDER, FMU_FOLDER):
        _remove_products(root / folder)
    compiler, why = compile_all(root, root / FOLDER, root / FMU_FOLDER)
    if why is not None:
        (root / FMU_FOLDER / FMU_REASON).write_text(f"{why}\n", encoding="utf-8")
    sys.stdout.write(f"compiled by {compiler}\n" + (f"no native FMU: {why}\n" if why else ""))


if __name__ == "__main__":
    main()
