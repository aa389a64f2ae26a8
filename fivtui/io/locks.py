"""A file lock that ends with the process that holds it."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fivtui.model import InputError


class LockedError(InputError):
    """Another process holds a lock."""


@contextmanager
def hold_lock(path: Path, holder: str) -> Iterator[None]:
    """Hold a lock on a file; `LockedError`, which names `holder`, if another process has it."""
    try:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None
    try:
        try:
            lock_file(handle)
        except (BlockingIOError, PermissionError):
            raise LockedError(f"{path.parent}: is in use by {holder}") from None
        except OSError as error:
            raise InputError(f"{path}: cannot be locked: {error.strerror or error}") from None
        yield
    finally:
        os.close(handle)


if sys.platform == "win32":
    import msvcrt

    def lock_file(handle: int) -> None:
        """Lock an open file; `PermissionError` if another process has it."""
        msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def lock_file(handle: int) -> None:
        """Lock an open file until it is closed; `BlockingIOError` if it is locked already."""
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
