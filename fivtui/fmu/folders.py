"""Folders to extract FMUs to, with paths of plain characters that every FMU can handle.

The library of an FMU may stay in memory after it is closed. Loaded again from the same path, it
takes no more memory. So an FMU is extracted to the path of its last run, unless another run of this
process uses it.
"""

import hashlib
import os
import shutil
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from fivtui.model import ComputationError

# Parent folders to use if the path of the folder for temporary files is not plain.
_FALLBACKS: Final[tuple[str, ...]] = ("/tmp", "/var/tmp") if os.name == "posix" else ()  # noqa: S108
_PREFIX: Final = "fivtui-fmu-"

_lock: Final = threading.Lock()
# Paths of unused folders, by process, parent folder and hash of the FMU extracted to them before.
_unused_paths: Final[dict[tuple[int, str, bytes], list[str]]] = {}


class Folder:
    """A folder for one extracted FMU; it is not used again if the FMU `failed_fatally`."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.failed_fatally = False


@contextmanager
def reserve_folder(fmu: Path) -> Iterator[Folder]:
    """Create an empty folder for an FMU; it is removed when the context ends.

    It has the path of an earlier folder for the same content, unless that is in use. Raises
    `OSError` if the FMU cannot be read or the folder cannot be created, and `ComputationError` if
    no parent folder has a plain path.
    """
    parent = _parent_folder()
    with fmu.open("rb") as file:
        key = (os.getpid(), parent, hashlib.file_digest(file, "sha256").digest())
    with _lock:
        unused_paths = _unused_paths.setdefault(key, [])
        path = unused_paths.pop() if unused_paths else None
    folder = Folder(_create_folder(path, parent))
    try:
        yield folder
    finally:
        shutil.rmtree(folder.path, ignore_errors=True)
        if not folder.failed_fatally:
            with _lock:
                unused_paths.append(folder.path)


def _create_folder(path: str | None, parent: str) -> str:
    # Another process may have created this folder meanwhile.
    if path is not None:
        try:
            Path(path).mkdir(0o700)
        except FileExistsError:
            path = None
    return path or tempfile.mkdtemp(prefix=_PREFIX, dir=parent)


def _parent_folder() -> str:
    system_parent = str(Path(tempfile.gettempdir()).absolute())
    for parent in (system_parent, *_FALLBACKS):
        if is_plain_path(parent) and os.access(parent, os.W_OK | os.X_OK):
            return parent
    raise ComputationError(
        f"the folder for temporary files, {system_parent}, has characters that FMUs cannot handle",
        "set TMPDIR to a folder of ASCII letters and digits",
    )


def is_plain_path(folder: str) -> bool:
    """Whether FMUs in Python can handle an absolute path.

    PythonFMU's library, which loads their code, decodes only ``%20`` in the URI of the path; it
    crashes on other escapes.
    """
    return "%" not in Path(folder).as_uri().replace("%20", "")
