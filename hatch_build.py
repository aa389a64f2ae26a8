"""Build hook: compiles the kernel in C when the package is installed.

One shared library holds the kernel for every instruction set of the processor's family; the program
chooses when it loads it (`fivtui.kernel.native`). Where it cannot be compiled the installation goes
on without it, and the reason is installed in its place: the program says it and runs interpreted.
"""

import hashlib
import os
import platform
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

FOLDER: Final = Path("fivtui", "kernel")
# What is read instead of the library where there is none.
REASON: Final = "libfivtui.txt"
_SUFFIXES: Final = {"win32": ".dll", "darwin": ".dylib"}
LIBRARY: Final = "libfivtui" + _SUFFIXES.get(sys.platform, ".so")
# Instruction sets by name, and what chooses them; the machine's own where there is no choice.
_X86: Final = {"baseline": "x86-64", "avx2": "x86-64-v3", "avx512": "x86-64-v4"}
# The bits of a run are decided by what is written: no product and sum is fused by the compiler.
_FLAGS: Final = [
    *("-std=c11", "-O3", "-g0", "-fPIC", "-fvisibility=hidden", "-Wall", "-Wno-psabi"),
    *("-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math", "-fno-strict-aliasing"),
]
_GLIBC: Final = "2.17"
_TIMEOUT_S: Final = 600.0


class CompilerError(Exception):
    """The kernel cannot be compiled."""


def sources_digest(folder: Path) -> str:
    """The digest of the kernel's text, by which a library that is older than it is told."""
    content = hashlib.sha256()
    for path in sorted([*folder.glob("*.c"), *folder.glob("*.h")]):
        content.update(path.name.encode() + b"\0" + path.read_bytes().replace(b"\r\n", b"\n"))
    return content.hexdigest()[:32]


def compile_kernel(folder: Path, target: Path) -> str:
    """Compile the kernel in `folder` into the library `target`; returns which compiler did.

    Raises
    ------
    CompilerError
        If no compiler can.
    """
    failures = []
    for name, command in _compilers():
        try:
            _compile(folder, target, name, command)
        except (OSError, subprocess.SubprocessError) as error:
            output = getattr(error, "stderr", None) or str(error)
            lines = [line for line in output.strip().splitlines() if "error" in line.lower()]
            failures.append(f"{name}: {(lines or [output.strip()])[0][:200]}")
        else:
            return name
    raise CompilerError("; ".join(failures) or "there is neither ziglang nor a compiler cc")


def _compilers() -> list[tuple[str, list[str]]]:
    # The same compiler on every machine, else what this one has.
    found = []
    if find_spec("ziglang") is not None:
        zig = [sys.executable, "-m", "ziglang", "cc"]
        if sys.platform == "linux" and platform.libc_ver()[0] == "glibc":
            zig += ["-target", f"{platform.machine()}-linux-gnu.{_GLIBC}"]
        found.append(("ziglang", zig))
    cc = shlex.split(os.environ.get("CC", "cc"))
    if shutil.which(cc[0]) is not None:
        found.append((cc[0], cc))
    return found


def _compile(folder: Path, target: Path, name: str, command: Sequence[str]) -> None:
    x86 = platform.machine().lower() in ("x86_64", "amd64")
    with tempfile.TemporaryDirectory() as scratch:
        environment = dict(os.environ)
        if name == "ziglang":
            # Nothing is left behind, unless a cache is asked for.
            for cache in ("GLOBAL", "LOCAL"):
                environment.setdefault(f"ZIG_{cache}_CACHE_DIR", scratch)

        def run(*arguments: str) -> None:
            subprocess.run(  # noqa: S603, a compiler
                [*command, *arguments],
                env=environment,
                check=True,
                capture_output=True,
                text=True,
                timeout=_TIMEOUT_S,
            )

        about = [f'-DSOURCES="{sources_digest(folder)}"', f'-DCOMPILER="{name}"']
        parts = {"loading.o": [*about, str(folder / "loading.c")]}
        for variant, processor in (_X86 if x86 else {"baseline": ""}).items():
            # zig spells processors in its own way.
            spelled = processor.replace("-", "_") if name == "ziglang" else processor
            options = [f"-march={spelled}"] if processor else []
            options += ["-mprefer-vector-width=512"] if variant == "avx512" else []
            for unit in ("single", "lanes", "vary"):
                source = str(folder / f"{unit}.c")
                parts[f"{unit}_{variant}.o"] = [*options, f"-DVARIANT={variant}", source]
        objects = [str(Path(scratch, part)) for part in parts]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            list(
                pool.map(
                    lambda made, given: run(*_FLAGS, *given, "-c", "-o", made),
                    objects,
                    parts.values(),
                )
            )
        made = str(Path(scratch, target.name))
        run("-shared", "-s", *objects, "-o", made, *([] if sys.platform == "win32" else ["-lm"]))
        # A library in use is replaced, not overwritten.
        new = target.with_name(f"{target.name}.{os.getpid()}")
        shutil.copyfile(made, new)
        new.replace(target)


def _platform_tag(compiler: str) -> str:
    if compiler == "ziglang" and sys.platform == "linux" and platform.libc_ver()[0] == "glibc":
        return f"manylinux_{_GLIBC.replace('.', '_')}_{platform.machine()}"
    return sysconfig.get_platform().replace("-", "_").replace(".", "_")


class KernelBuildHook(BuildHookInterface):  # type: ignore[type-arg, unused-ignore]
    """Compiles the kernel into wheels; into the sources themselves where these are installed."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, and add the library or the reason why there is none."""
        if self.target_name != "wheel":
            return
        root = Path(self.root)
        folder = root / FOLDER
        editable = version == "editable"
        self._made = None if editable else tempfile.TemporaryDirectory()
        home = folder if self._made is None else Path(self._made.name)
        library, reason = home / LIBRARY, home / REASON
        for old in (library, reason):
            old.unlink(missing_ok=True)
        try:
            compiler = compile_kernel(folder, library)
        except CompilerError as error:
            reason.write_text(f"{error}\n", encoding="utf-8")
            self.app.display_warning(f"The kernel is not compiled: {error}")
            made = reason
        else:
            made = library
            build_data["pure_python"] = False
            build_data["tag"] = f"py3-none-{_platform_tag(compiler)}"
            if compiler != "ziglang":
                self.app.display_warning(f"The kernel is compiled by {compiler}, not by ziglang")
        if not editable:
            build_data["force_include"][str(made)] = str(FOLDER / made.name)

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:  # noqa: ARG002
        """Remove what was compiled outside the sources."""
        made = getattr(self, "_made", None)
        if made is not None:
            made.cleanup()


if __name__ == "__main__":
    # In place, for those who work on the kernel.
    _folder = Path(__file__).parent / FOLDER
    (_folder / REASON).unlink(missing_ok=True)
    sys.stdout.write(f"compiled by {compile_kernel(_folder, _folder / LIBRARY)}\n")
