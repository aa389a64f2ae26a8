"""Output files: never overwritten unasked, never an input."""

import os
import sys
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

from fivtui.model import InputError

if sys.platform == "win32":
    from pathlib import WindowsPath as _SystemPath
else:
    from pathlib import PosixPath as _SystemPath

# A file, after what it is called in messages, such as ``--out``.
Named = tuple[str, Path]


class ReplaceablePath(_SystemPath):
    """A path at which an existing file may be replaced."""

    __slots__ = ()


def output_path(path: str | Path, *, force: bool = False) -> Path:
    """A path for a file to be written; with `force` it may replace an existing file."""
    if force:
        return ReplaceablePath(path)
    return path if isinstance(path, Path) else Path(path)


def is_replaceable(path: Path) -> bool:
    """Whether a file at a path may be replaced."""
    return isinstance(path, ReplaceablePath)


def check_suffix(path: Path, kind: str, allowed: Iterable[str]) -> str:
    """The suffix of a file in lower case; `InputError` if it is not one of `allowed`."""
    suffix, suffixes = path.suffix.lower(), tuple(allowed)
    if suffix not in suffixes:
        names = ", ".join(suffixes)
        raise InputError(f"{path}: the suffix of a {kind} file must be one of {names}")
    return suffix


def check_output(path: Path) -> None:
    """Raise `InputError` if a file cannot be written, before anything is computed.

    That is if it exists (unless the path is replaceable), is not a regular file, has no folder, or
    writing is not permitted.
    """
    try:
        _check_target(path, resolved(path))
    except OSError as error:
        raise cannot_write(path, error) from None


def _check_target(path: Path, target: Path) -> None:
    if target.is_dir():
        raise InputError(f"{path}: is a folder, not a file")
    if target.exists():
        if not target.is_file():
            raise InputError(f"{path}: is not a regular file")
        if not is_replaceable(path):
            raise InputError(f"{path}: exists already; choose another name or force overwriting")
        if not os.access(target, os.W_OK):
            raise InputError(f"{path}: cannot be written: the file is read-only")
    folder = target.parent
    if not folder.is_dir():
        raise InputError(f"{path}: there is no folder {folder}")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{path}: cannot be written: no permission to write in {folder}")


def check_apart(
    outputs: Sequence[Named], inputs: Sequence[Named] = (), folders: Sequence[Named] = ()
) -> None:
    """Raise `InputError` if an output is the same file as another output or an input.

    Two names may be one file through hard or symbolic links, or where the folder ignores case. No
    file may be in one of `folders`, which are for intermediate results.
    """
    for index, (name, path) in enumerate(outputs):
        for files, rule in (
            (outputs[:index], "; every output must be a file of its own"),
            (inputs, ", which is read; an output must be another file"),
        ):
            for label, used in files:
                if _same(resolved(path), resolved(used)):
                    raise InputError(f"{name} {path}: is the same file as {label} {used}{rule}")
    for name, folder in folders:
        for label, path in (*outputs, *inputs):
            target = resolved(path)
            if any(_same(above, folder) for above in (target, *target.parents)):
                raise InputError(
                    f"{label} {path}: is in the folder {folder}, where {name} keeps intermediate "
                    "results; choose another place"
                )


def _same(first: Path, second: Path) -> bool:
    # Whether two resolved names are the same file, existing or not.
    if first == second:
        return True
    try:
        if first.exists() or second.exists():
            return first.samefile(second)
        if not first.parent.samefile(second.parent):
            return False
    except OSError:
        return False
    return first.name == second.name or (
        first.name.casefold() == second.name.casefold() and _ignores_case(first.parent)
    )


def _ignores_case(folder: Path) -> bool:
    try:
        with tempfile.NamedTemporaryFile(prefix=".fivtui-", dir=folder) as file:
            path = Path(file.name)
            return path.with_name(path.name.upper()).exists()
    except OSError:
        return False


def parts_folder(out: Path) -> Path:
    """The folder for pieces of a file that is not complete: ``FILE.parts``."""
    target = resolved(out)
    return target.with_name(f"{target.name}.parts")


def files_text(*paths: Path) -> str:
    """Names of files with the folder that they are in: ``a.csv, b.csv in /home/me/runs``."""
    folders: dict[Path, list[str]] = {}
    for path in paths:
        folders.setdefault(path.absolute().parent, []).append(path.name)
    return "; ".join(f"{', '.join(names)} in {folder}" for folder, names in folders.items())


def resolved(path: Path) -> Path:
    """The absolute path behind symbolic links; `InputError` if no file can have the name."""
    if "\0" in str(path):
        raise InputError(f"{str(path)!r}: not the name of a file")
    target = Path(os.path.realpath(path))
    # A path that is still a link is a loop.
    if os.path.islink(target):  # noqa: PTH114, a name too long is no link
        raise InputError(
            f"{path}: is a symbolic link that leads back to itself; it must be a file, or a link "
            "to one"
        )
    return target


def cannot_write(path: Path, error: OSError) -> InputError:
    """The error for a file that the system does not allow to be written."""
    return InputError(f"{path}: cannot be written: {error.strerror or error}")
