"""Atomic writing of a file or of a set of files, and locks that end with their process.

A file is written as a draft: under a temporary name beside its target, with a lock. It is published
by renaming it to its target. A killed run leaves a draft without a lock, which the next run that
writes the same target removes.
"""

import hashlib
import json
import os
import secrets
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path
from typing import Any, BinaryIO, Final, NamedTuple

from fivtui.model import InputError

from .files import check_output, resolve_path, unwritable_error

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


_PREFIX: Final = ".fivtui-"
# Lengths of the parts of a temporary name, in hexadecimal digits and in bytes: a hash of the
# target's name, and random bytes.
_HASH_DIGITS: Final = 12
_RANDOM_BYTES: Final = 8
# Glob pattern of all temporary files.
TEMPORARY_GLOB: Final = f"{_PREFIX}*.tmp"


def write_atomically(path: Path, write: Callable[[BinaryIO], None]) -> None:
    """Write a file completely or not at all; the file must not exist unless replaceable."""
    drafts = _DRAFTS.get()
    if drafts is not None:
        drafts.add(path, write)
        return
    with publish_together():
        write_atomically(path, write)


@contextmanager
def publish_together() -> Iterator[None]:
    """Publish all files written in the context at its end, or none if it fails."""
    with _Drafts() as drafts:
        token = _DRAFTS.set(drafts)
        try:
            yield
        finally:
            _DRAFTS.reset(token)
        drafts.publish()


def save_json(data: Any, path: Path) -> None:
    """Write data as JSON with `write_atomically`."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, indent=2) + "\n"
    save_bytes(text.encode(), path)


def save_bytes(content: bytes, path: Path) -> None:
    """Write bytes with `write_atomically`."""

    def write(file: BinaryIO) -> None:
        file.write(content)

    write_atomically(path, write)


class _Draft(NamedTuple):
    # The path that was given, the same without links, and the temporary file.
    path: Path
    target: Path
    temporary_path: Path
    file: BinaryIO


class _Drafts(ExitStack):
    """Complete files under temporary names, which are removed unless they are published."""

    def __init__(self) -> None:
        super().__init__()
        self._drafts: list[_Draft] = []

    def add(self, path: Path, write: Callable[[BinaryIO], None]) -> None:
        """Write a file under a temporary name."""
        check_output(path)
        target = resolve_path(path)
        try:
            _remove_abandoned_files(target)
            temporary_path, file = self._open_temporary(target)
            # A file that `write` itself writes atomically is published by itself.
            token = _DRAFTS.set(None)
            try:
                write(file)
            finally:
                _DRAFTS.reset(token)
            file.flush()
            os.fsync(file.fileno())
        except OSError as error:
            raise unwritable_error(path, error) from None
        self._drafts.append(_Draft(path, target, temporary_path, file))

    def publish(self) -> None:
        """Rename the temporary files to their targets."""
        # Another program may have created a target in the meantime.
        for draft in self._drafts:
            check_output(draft.path)
        for draft in self._drafts:
            try:
                if draft.target.exists():
                    shutil.copymode(draft.target, draft.temporary_path)
                if sys.platform == "win32":
                    # An open file cannot be renamed.
                    draft.file.close()
                draft.temporary_path.replace(draft.target)
            except OSError as error:
                raise unwritable_error(draft.path, error) from None

    def _open_temporary(self, target: Path) -> tuple[Path, BinaryIO]:
        # Open a new temporary file, locked if the file system supports locks. Before the lock is
        # taken, another process may remove the file as abandoned: then try another name.
        while True:
            temporary_path = target.with_name(
                f"{_temporary_prefix(target)}{secrets.token_hex(_RANDOM_BYTES)}.tmp"
            )
            self.callback(temporary_path.unlink, missing_ok=True)
            file = temporary_path.open("xb")
            self.callback(_close_quietly, file)
            try:
                lock_file(file.fileno())
            except (BlockingIOError, PermissionError):
                continue
            except OSError:
                return temporary_path, file
            if temporary_path.exists():
                return temporary_path, file


# The files that the current context publishes together; None outside of such a context.
_DRAFTS: ContextVar[_Drafts | None] = ContextVar("files that appear together", default=None)


def _close_quietly(file: BinaryIO) -> None:
    # If writing failed, closing fails for the same reason.
    with suppress(OSError):
        file.close()


def _temporary_prefix(target: Path) -> str:
    # The beginning of all temporary names of a target.
    return f"{_PREFIX}{hashlib.sha256(os.fsencode(target.name)).hexdigest()[:_HASH_DIGITS]}-"


def _remove_abandoned_files(target: Path) -> None:
    # If a temporary file of the target has no lock, the process that wrote it has ended.
    prefix, names = _temporary_prefix(target), []
    # A writable folder may be unreadable.
    with suppress(OSError), os.scandir(target.parent) as entries:
        names = [entry.name for entry in entries if entry.name.startswith(prefix)]
    for name in names:
        with suppress(OSError):
            _remove_unlocked(target.with_name(name))


def _remove_unlocked(path: Path) -> None:
    # Raises `OSError` if the file is locked, or cannot be opened or removed.
    handle = os.open(path, os.O_RDWR | getattr(os, "O_NOFOLLOW", 0))
    try:
        lock_file(handle)
        if sys.platform != "win32":
            path.unlink()
    finally:
        os.close(handle)
    if sys.platform == "win32":
        # An open file cannot be removed.
        path.unlink()


class LockedError(InputError):
    """Another process holds the lock that is needed."""


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
