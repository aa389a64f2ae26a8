"""Atomic writing of a file, or of a set of files.

A file is written under a temporary name beside its target, locked, and then renamed. A killed run
leaves a temporary file without a lock; the next run that writes the same target removes it.
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

from .files import cannot_write, check_output, resolved
from .locks import lock_file

_PREFIX: Final = ".fivtui-"
# Prefix of all temporary files.
TEMPORARY_FILES: Final = f"{_PREFIX}*.tmp"


def write_atomically(path: Path, write: Callable[[BinaryIO], None]) -> None:
    """Write a file completely or not at all; only a replaceable path may have a file already."""
    drafts = _DRAFTS.get()
    if drafts is not None:
        drafts.add(path, write)
        return
    with written_together():
        write_atomically(path, write)


@contextmanager
def written_together() -> Iterator[None]:
    """Publish all files written in the context at its end, or none if it fails."""
    with _Drafts() as drafts:
        token = _DRAFTS.set(drafts)
        try:
            yield
        finally:
            _DRAFTS.reset(token)
        drafts.publish()


def save_json(data: Any, path: Path) -> None:
    """Write data as JSON, as `write_atomically`."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, indent=2) + "\n"
    save_bytes(text.encode(), path)


def save_bytes(content: bytes, path: Path) -> None:
    """Write bytes, as `write_atomically`."""

    def write(file: BinaryIO) -> None:
        file.write(content)

    write_atomically(path, write)


class _Draft(NamedTuple):
    path: Path
    target: Path
    temporary: Path
    file: BinaryIO


class _Drafts(ExitStack):
    """Complete files under temporary names, which are removed unless they are published."""

    def __init__(self) -> None:
        super().__init__()
        self._drafts: list[_Draft] = []

    def add(self, path: Path, write: Callable[[BinaryIO], None]) -> None:
        """Write a file under a temporary name."""
        check_output(path)
        target = resolved(path)
        try:
            _remove_abandoned(target)
            temporary, file = self._opened(target)
            # Files that `write` itself writes do not belong to this set.
            token = _DRAFTS.set(None)
            try:
                write(file)
            finally:
                _DRAFTS.reset(token)
            file.flush()
            os.fsync(file.fileno())
        except OSError as error:
            raise cannot_write(path, error) from None
        self._drafts.append(_Draft(path, target, temporary, file))

    def publish(self) -> None:
        """Give the files their names."""
        # Files may have appeared under these names meanwhile.
        for draft in self._drafts:
            check_output(draft.path)
        for draft in self._drafts:
            try:
                if draft.target.exists():
                    shutil.copymode(draft.target, draft.temporary)
                if sys.platform == "win32":
                    # An open file cannot be renamed.
                    draft.file.close()
                draft.temporary.replace(draft.target)
            except OSError as error:
                raise cannot_write(draft.path, error) from None

    def _opened(self, target: Path) -> tuple[Path, BinaryIO]:
        # A new temporary file, locked where the file system has locks. Another process may take it
        # for abandoned before it is locked: then another name is tried.
        while True:
            temporary = target.with_name(f"{_stem(target)}{secrets.token_hex(8)}.tmp")
            self.callback(temporary.unlink, missing_ok=True)
            file = temporary.open("xb")
            self.callback(_close, file)
            try:
                lock_file(file.fileno())
            except (BlockingIOError, PermissionError):
                continue
            except OSError:
                return temporary, file
            if temporary.exists():
                return temporary, file


_DRAFTS: ContextVar[_Drafts | None] = ContextVar("files that appear together", default=None)


def _close(file: BinaryIO) -> None:
    # If writing failed, closing fails for the same reason.
    with suppress(OSError):
        file.close()


def _stem(target: Path) -> str:
    # Prefix of the temporary names of a target.
    return f"{_PREFIX}{hashlib.sha256(os.fsencode(target.name)).hexdigest()[:12]}-"


def _remove_abandoned(target: Path) -> None:
    # Unlocked temporary files of the target, whose process has ended.
    stem, names = _stem(target), []
    # A writable folder may be unreadable.
    with suppress(OSError), os.scandir(target.parent) as entries:
        names = [entry.name for entry in entries if entry.name.startswith(stem)]
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
