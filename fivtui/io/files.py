"""Checks of output paths: overwriting must be allowed, and no output may be another or an input."""

import os
import sys
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

from fivtui.model import InputError

# Before Python 3.12 only the class of the operating system can be subclassed.
if sys.platform == "win32":
    from pathlib import WindowsPath as _SystemPath
else:
    from pathlib import PosixPath as _SystemPath

# The label of a file in messages, such as ``--out``, and its path.
LabelledPath = tuple[str, Path]


class ReplaceablePath(_SystemPath):
    """A path at which an existing file may be replaced."""

    __slots__ = ()


def output_path(path: str | Path, *, force: bool = False) -> Path:
    """A path for a file to be written; with `force` it may replace an existing file."""
    if force:
        return ReplaceablePath(path)
    return path if isinstance(path, Path) else Path(path)


def home_path(text: str) -> Path:
    """A typed path with the home folder in place of ``~``, if there is one."""
    return Path(os.path.expanduser(text))  # noqa: PTH111, which raises for an unknown user


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
    """Raise `InputError` if a file cannot be written; call it before the computation.

    The file must not exist unless the path is replaceable. Its folder must exist, and the user
    needs permission to write.
    """
    try:
        _check_target(path, resolve_path(path))
    except OSError as error:
        raise unwritable_error(path, error) from None


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


def check_distinct(
    outputs: Sequence[LabelledPath],
    inputs: Sequence[LabelledPath] = (),
    folders: Sequence[LabelledPath] = (),
) -> None:
    """Raise `InputError` if an output is the same file as another output or an input.

    Different paths can lead to the same file by hard or symbolic links, or where the folder ignores
    case. No file may be in one of `folders`, which are for intermediate results.
    """
    for index, (output_label, path) in enumerate(outputs):
        for files, rule in (
            (outputs[:index], "; every output must be a file of its own"),
            (inputs, ", which is read; an output must be another file"),
        ):
            for label, used_path in files:
                if _is_same_file(resolve_path(path), resolve_path(used_path)):
                    raise InputError(
                        f"{output_label} {path}: is the same file as {label} {used_path}{rule}"
                    )
    for folder_label, folder in folders:
        for label, path in (*outputs, *inputs):
            target = resolve_path(path)
            if any(_is_same_file(ancestor, folder) for ancestor in (target, *target.parents)):
                raise InputError(
                    f"{label} {path}: is in the folder {folder}, where {folder_label} keeps "
                    "intermediate results; choose another place"
                )


def _is_same_file(path: Path, other_path: Path) -> bool:
    # Whether two resolved paths lead to the same file; the file need not exist.
    if path == other_path:
        return True
    try:
        if path.exists() or other_path.exists():
            return path.samefile(other_path)
        if not path.parent.samefile(other_path.parent):
            return False
    except OSError:
        return False
    return path.name == other_path.name or (
        path.name.casefold() == other_path.name.casefold() and _ignores_case(path.parent)
    )


def _ignores_case(folder: Path) -> bool:
    # Whether names that differ by case alone are one file in a folder: tested by a temporary file.
    try:
        with tempfile.NamedTemporaryFile(prefix=".fivtui-", dir=folder) as file:
            path = Path(file.name)
            return path.with_name(path.name.upper()).exists()
    except OSError:
        return False


def parts_folder(out: Path) -> Path:
    """The folder for parts of a file that is not complete yet: ``FILE.parts``."""
    target = resolve_path(out)
    return target.with_name(f"{target.name}.parts")


def describe_files(*paths: Path) -> str:
    """Names of files, grouped by folder: ``a.csv, b.csv in /home/me/runs``."""
    folders: dict[Path, list[str]] = {}
    for path in paths:
        folders.setdefault(path.absolute().parent, []).append(path.name)
    return "; ".join(f"{', '.join(names)} in {folder}" for folder, names in folders.items())


def resolve_path(path: Path) -> Path:
    """Follow symbolic links to an absolute path; `InputError` if the path is invalid."""
    if "\0" in str(path):
        raise InputError(f"{str(path)!r}: not the name of a file")
    target = Path(os.path.realpath(path))
    # A path that is still a link is a loop.
    if os.path.islink(target):  # noqa: PTH114, which raises if the name is too long
        raise InputError(
            f"{path}: is a symbolic link that leads back to itself; it must be a file, or a link "
            "to one"
        )
    return target


def unwritable_error(path: Path, error: OSError) -> InputError:
    """The error for a file that the operating system refuses to write."""
    return InputError(f"{path}: cannot be written: {error.strerror or error}")
