"""Folders to extract FMUs to, reused and with plain paths that every FMU can handle.

A closed library may stay in memory. Loading it again from the same path takes no more memory, so an
FMU is extracted to its former folder, unless a run in this process uses it.
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

# Where to extract if the path of the folder for temporary files is not plain.
_FALLBACKS: Final[tuple[str, ...]] = ("/tmp", "/var/tmp") if os.name == "posix" else ()  # noqa: S108
_PREFIX: Final = "fivtui-fmu-"

_lock: Final = threading.Lock()
# Free folders, by process, parent folder and content of the FMU that was there.
_free: Final[dict[tuple[int, str, bytes], list[str]]] = {}


class Folder:
    """A folder for one extracted FMU; `spoilt` after a fatal error: it must not be used again."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.spoilt = False


@contextmanager
def folder_for(fmu: Path) -> Iterator[Folder]:
    """Create an empty folder for an FMU; it is removed when the context ends.

    FMUs of the same content get the same folder, unless it is in use. Raises `OSError` if the FMU
    cannot be read or the folder not be created, and `ComputationError` if the path of the folder
    for temporary files is not plain.
    """
    parent = _parent_folder()
    with fmu.open("rb") as file:
        key = (os.getpid(), parent, hashlib.file_digest(file, "sha256").digest())
    with _lock:
        free = _free.setdefault(key, [])
        path = free.pop() if free else None
    folder = Folder(_create_folder(path, parent))
    try:
        yield folder
    finally:
        shutil.rmtree(folder.path, ignore_errors=True)
        if not folder.spoilt:
            with _lock:
                free.append(folder.path)


def _create_folder(path: str | None, parent: str) -> str:
    # A different process may have created this folder meanwhile.
    if path is not None:
        try:
            Path(path).mkdir(0o700)
        except FileExistsError:
            path = None
    return path or tempfile.mkdtemp(prefix=_PREFIX, dir=parent)


def _parent_folder() -> str:
    usual = str(Path(tempfile.gettempdir()).absolute())
    for parent in (usual, *_FALLBACKS):
        if is_plain(parent) and os.access(parent, os.W_OK | os.X_OK):
            return parent
    raise ComputationError(
        f"the folder for temporary files, {usual}, has characters that FMUs cannot handle",
        "set TMPDIR to a folder of ASCII letters and digits",
    )


def is_plain(folder: str) -> bool:
    """Whether the wrapper of Python FMUs can handle an absolute path.

    The wrapper decodes no percent notation but that of a space, and crashes on any other.
    """
    return "%" not in Path(folder).as_uri().replace("%20", "")
