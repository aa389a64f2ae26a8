"""Open input files, which must be regular files of limited size."""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, Final

from fivtui.model import InputError

# Greatest sizes of tables, 4 GiB, and of files written by hand, 1 MiB, in bytes.
MAX_TABLE: Final = 4 << 30
MAX_TEXT: Final = 1 << 20
# Units of sizes for messages.
_UNITS: Final = ((1 << 30, "GiB"), (1 << 20, "MiB"), (1, "bytes"))


def check_regular(path: Path, *, limit: int = MAX_TABLE) -> None:
    """Raise `InputError` unless the path is a regular, readable file of at most `limit` bytes."""
    with open_regular(path, limit=limit):
        pass


@contextmanager
def open_regular(path: Path, *, limit: int = MAX_TABLE) -> Iterator[BinaryIO]:
    """Open a regular file of at most `limit` bytes.

    An `OSError` on opening or in the body of the context becomes an `InputError`.
    """
    try:
        with _open_nonblocking(path) as file:
            _check_status(path, os.fstat(file.fileno()), limit)
            yield file
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None


def _open_nonblocking(path: Path) -> BinaryIO:
    # A non-blocking open, because opening a pipe without a writer would wait for ever.
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


def _check_status(path: Path, status: os.stat_result, limit: int) -> None:
    if not stat.S_ISREG(status.st_mode):
        raise InputError(f"{path}: must be a regular file, not a pipe or a device")
    if status.st_size > limit:
        raise _size_error(path, limit)


def _size_error(path: Path, limit: int) -> InputError:
    unit_size, unit = next((unit_size, unit) for unit_size, unit in _UNITS if limit >= unit_size)
    return InputError(f"{path}: must be of at most {limit / unit_size:g} {unit}")


def is_folder(path: Path) -> bool:
    """Whether the path is an existing folder."""
    return os.path.isdir(path)  # noqa: PTH112, which raises for a name too long


def path_exists(path: Path) -> bool:
    """Whether the path is an existing file, folder or device."""
    return os.path.exists(path)  # noqa: PTH110, which raises for a name too long


def read_bytes(path: Path, *, limit: int = MAX_TABLE) -> bytes:
    """Read a regular file of at most `limit` bytes; raises the errors of `open_regular`."""
    with open_regular(path, limit=limit) as file:
        # Some files, such as those of /proc, are longer than their reported size.
        content = file.read(limit + 1)
    if len(content) > limit:
        raise _size_error(path, limit)
    return content
