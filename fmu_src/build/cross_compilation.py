"""Compile binaries of native FMUs for other platforms with ziglang, when an FMU is built."""

import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from operator import methodcaller
from pathlib import Path
from typing import Final

from fivtui.io import output_path, temporary_folder, write_atomically
from fivtui.kernel import FLAGS
from fivtui.model import ComputationError, InputError

from .c_sources import STEPPING_UNIT, reproducible_options, sources, sources_hash
from .platforms import PLATFORMS

_TIMEOUT_S: Final = 600.0
# Longest line of the compiler that an error shows, in characters.
_LONGEST_MESSAGE: Final = 200

# Compiler options by instruction set, for the unit that computes the Taylor steps. The FMU chooses
# the instruction set that its processor supports.
_X86: Final[Mapping[str, Sequence[str]]] = {
    "baseline": ["-march=x86_64"],
    "avx2": ["-march=x86_64_v3"],
}
_ARM: Final[Mapping[str, Sequence[str]]] = {"baseline": []}


def compile_binary(model: str, platform: str) -> bytes:
    """Compile the binary of a model for one of `PLATFORMS`.

    Raises `InputError` if ziglang is not installed, `ComputationError` if it fails.
    """
    if find_spec("ziglang") is None:
        raise InputError(f"platform {platform}: needs ziglang: install fivtui[cross]")
    from fmpy import __file__ as fmpy_file

    target = PLATFORMS[platform]
    with temporary_folder() as folder:
        source_folder = _source_folder(model, folder)
        headers = Path(str(fmpy_file)).parent / "c-code"
        # Code of Windows libraries is always position-independent.
        flags = [f for f in FLAGS if not (f == "-fPIC" and target.suffix == ".dll")]
        options = ["-target", target.triple, *flags, "-I.", f"-I{headers}"]
        units = [path.name for path in source_folder.glob("*.c") if path.stem != STEPPING_UNIT]
        if (source_folder / f"{STEPPING_UNIT}.c").is_file():
            instruction_sets = _X86 if target.is_x86 else _ARM
            for variant, variant_options in instruction_sets.items():
                units.append(str(folder / f"{variant}.o"))
                variant_flags = [*variant_options, f"-DVARIANT={variant}", "-c", "-o", units[-1]]
                _run_compiler(source_folder, *options, *variant_flags, f"{STEPPING_UNIT}.c")
            options += ["-DWITH_AVX2"] if "avx2" in instruction_sets else []
        library = folder / f"{model}{target.suffix}"
        options += ["-O2", "-shared", "-s", *reproducible_options(library.name)]
        _run_compiler(source_folder, *options, *sorted(units), "-o", str(library))
        return library.read_bytes()


def _source_folder(model: str, scratch: Path) -> Path:
    """Write a model's C files to a folder in the cache of ziglang, or else in `scratch`.

    ziglang reuses compiled files only if the paths of the sources are the same.
    """
    folder = (_cache_folder() or scratch) / "fivtui" / sources_hash() / model
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in sources(model).items():
        file, content = folder / name, text.encode()
        if not file.is_file() or file.read_bytes() != content:
            replaceable_file = output_path(file, force=True)
            write_atomically(replaceable_file, methodcaller("write", content))
    return folder


def _cache_folder() -> Path | None:
    """The cache folder of ziglang; None if it is not writable."""
    local = os.environ.get("LOCALAPPDATA") if os.name == "nt" else None
    default = os.environ.get("XDG_CACHE_HOME") or local or Path.home() / ".cache"
    folder = Path(os.environ.get("ZIG_GLOBAL_CACHE_DIR") or Path(default, "zig")).absolute()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


def _run_compiler(folder: Path, *arguments: str) -> None:
    cache = str(_cache_folder() or folder)
    try:
        subprocess.run(  # noqa: S603, a compiler
            [sys.executable, "-m", "ziglang", "cc", *arguments],
            cwd=folder,
            # A local cache set by the user is used; a global one that is not writable is replaced.
            env={
                "ZIG_LOCAL_CACHE_DIR": cache,
                **os.environ,
                "ZIG_GLOBAL_CACHE_DIR": cache,
            },
            check=True,
            capture_output=True,
            text=True,
            timeout=_TIMEOUT_S,
        )
    except (OSError, subprocess.SubprocessError) as error:
        output = getattr(error, "stderr", None) or str(error)
        lines = [line for line in output.splitlines() if "error" in line.lower()]
        raise ComputationError(
            f"ziglang cannot compile the FMU: {(lines or [output.strip()])[0][:_LONGEST_MESSAGE]}",
            "build it for the platform of this machine alone",
        ) from None
