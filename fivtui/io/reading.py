"""Input files: regular ones of bounded size."""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, Final

from fivtui.model import InputError

# Greatest sizes of tables, and of files written by hand, that are read into memory.
MAX_TABLE: Final = 4 << 30
MAX_TEXT: Final = 1 << 20
_UNITS: Final = ((1 << 30, "GiB"), (1 << 20, "MiB"), (1, "bytes"))


def check_regular(path: Path, *, limit: int = MAX_TABLE) -> None:
    """Raise `InputError` unless a regular, readable file of at most `limit` bytes is there."""
    with opened(path, limit=limit):
        pass


@contextmanager
def opened(path: Path, *, limit: int = MAX_TABLE) -> Iterator[BinaryIO]:
    """Open a regular file of at most `limit` bytes; failures, also of reading, are `InputError`."""
    try:
        with _open(path) as file:
            _check(path, os.fstat(file.fileno()), limit)
            yield file
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None


def _open(path: Path) -> BinaryIO:
    # Non-blocking: opening a pipe without a writer would wait for ever.
    def opener(name: str, flags: int) -> int:
        handle = os.open(name, flags | getattr(os, "O_NONBLOCK", 0))
        if stat.S_ISDIR(os.fstat(handle).st_mode):
            os.close(handle)
            raise InputError(f"{path}: is a folder, not a file")
        return handle

    try:
        return open(path, "rb", opener=opener)
    except InputError:
        raise
    except ValueError:
        raise InputError(f"{path}: not the name of a file") from None


def _check(path: Path, status: os.stat_result, limit: int) -> None:
    if not stat.S_ISREG(status.st_mode):
        raise InputError(f"{path}: must be a regular file, not a pipe or a device")
    if status.st_size > limit:
        raise _too_large(path, limit)


def _too_large(path: Path, limit: int) -> InputError:
    size, unit = next((size, unit) for size, unit in _UNITS if limit >= size)
    return InputError(f"{path}: must be of at most {limit / size:g} {unit}")


def is_folder(path: Path) -> bool:
    """Whether there is a folder of that name."""
    return os.path.isdir(path)  # noqa: PTH112, which raises for a name too long


def is_there(path: Path) -> bool:
    """Whether a file, folder or device of that name exists."""
    return os.path.exists(path)  # noqa: PTH110, which raises for a name too long


def read_bytes(path: Path, *, limit: int = MAX_TABLE) -> bytes:
    """The content of a regular file of at most `limit` bytes; errors as `opened`."""
    with opened(path, limit=limit) as file:
        # Some files, such as those of /proc, are longer than their reported size.
        content = file.read(limit + 1)
    if len(content) > limit:
        raise _too_large(path, limit)
    return content
