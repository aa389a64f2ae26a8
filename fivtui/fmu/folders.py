"""Folders that FMUs are extracted to: such as every FMU can handle, and used again.

A library that a process has loaded may stay in its memory after it was closed: that of a Python
FMU always does. Loaded again from a file of the same name it takes no more room, so an FMU is
extracted to the folder that it had before, if no other run in this process uses it.
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

# Where to extract if the folder for temporary files has a name that FMUs cannot handle.
_FALLBACKS: Final[tuple[str, ...]] = ("/tmp", "/var/tmp") if os.name == "posix" else ()  # noqa: S108
_PREFIX: Final = "fivtui-fmu-"

_lock: Final = threading.Lock()
# Folders in which no FMU is now, by process, place and content of the FMU that was there.
_free: Final[dict[tuple[int, str, bytes], list[str]]] = {}


class Folder:
    """A folder for one extracted FMU.

    Attributes
    ----------
    path : str
        Its path.
    spoilt : bool
        Whether what was loaded from it must not be used again: after a fatal error of the FMU.
    """

    def __init__(self, path: str) -> None:
        self.path = path
        self.spoilt = False


@contextmanager
def folder_for(fmu: Path) -> Iterator[Folder]:
    """Make an empty folder for an FMU, and remove it with its content when the context ends.

    Parameters
    ----------
    fmu : Path
        The FMU.

    Yields
    ------
    Folder
        The same one as before for an FMU of the same content, unless that is in use.

    Raises
    ------
    OSError
        If the FMU cannot be read or the folder not be made.
    ComputationError
        If there is no folder for temporary files that FMUs can handle.
    """
    place = _place()
    with fmu.open("rb") as file:
        key = (os.getpid(), place, hashlib.file_digest(file, "sha256").digest())
    with _lock:
        free = _free.setdefault(key, [])
        known = free.pop() if free else None
    folder = Folder(_made(known, place))
    try:
        yield folder
    finally:
        shutil.rmtree(folder.path, ignore_errors=True)
        if not folder.spoilt:
            with _lock:
                free.append(folder.path)


def _made(known: str | None, place: str) -> str:
    # Somebody may have made a folder of this name in the meantime; then it is not ours.
    if known is not None:
        try:
            Path(known).mkdir(0o700)
        except FileExistsError:
            known = None
    return known or tempfile.mkdtemp(prefix=_PREFIX, dir=place)


def _place() -> str:
    usual = str(Path(tempfile.gettempdir()).absolute())
    for place in (usual, *_FALLBACKS):
        if is_plain(place) and os.access(place, os.W_OK | os.X_OK):
            return place
    raise ComputationError(
        f"the folder for temporary files, {usual}, has characters that FMUs cannot handle",
        "set TMPDIR to a folder of ASCII letters and digits",
    )


def is_plain(folder: str) -> bool:
    """Whether the wrapper of Python FMUs finds its files in a folder.

    Parameters
    ----------
    folder : str
        An absolute path.

    Returns
    -------
    bool
        False if its address has a character in percent notation other than a space, which is all
        that the wrapper decodes; it crashes the process then.
    """
    return "%" not in Path(folder).as_uri().replace("%20", "")
