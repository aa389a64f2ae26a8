"""Standard output and standard error that handle failures to write.

A failure of standard output, such as a full disk, is reported in one line; one of standard error is
ignored.
"""

import io
import os
import select
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final, TextIO

from fivtui.model import ComputationError

# File descriptors.
_STDOUT: Final = 1
_STDERR: Final = 2
_ADVICE: Final = "make room there, or write to a file with --out where a command has it"


class ReaderGone(Exception):
    """The program that reads standard output has closed it: exit without a message."""


class _GuardedRaw(io.RawIOBase):
    # A stream whose first failure to write raises an error, unless it is `silent`. After a failure
    # all data are dropped, so that flushing at exit does not fail again.
    def __init__(self, stream: io.RawIOBase, *, silent: bool) -> None:
        self._stream = stream
        self._silent = silent
        self._failed = False

    def writable(self) -> bool:
        return True

    def isatty(self) -> bool:
        return self._stream.isatty()

    def fileno(self) -> int:
        return self._stream.fileno()

    def write(self, data: object) -> int:
        size = memoryview(data).nbytes  # type: ignore[arg-type]
        if self._failed:
            return size
        try:
            while (written := self._stream.write(data)) is None:  # type: ignore[arg-type]
                # A non-blocking pipe is full.
                select.select([], [self._stream], [])
            return written
        except OSError as error:
            self._failed = True
            if self._silent:
                return size
            if isinstance(error, BrokenPipeError):
                raise ReaderGone from None
            raise ComputationError(
                f"standard output: cannot be written: {error.strerror or error}", _ADVICE
            ) from None


@contextmanager
def guarded_streams() -> Iterator[None]:
    """Guard standard output and error while the context lasts.

    A failure of standard output raises `ComputationError` or `ReaderGone`, one of standard error
    is ignored. Characters that the encoding of standard output lacks become ``?``.
    """
    original = sys.stdout, sys.stderr
    try:
        sys.stdout = _guard_stream(sys.stdout, _STDOUT, "replace", silent=False)
        sys.stderr = _guard_stream(sys.stderr, _STDERR, "backslashreplace", silent=True)
        yield
    finally:
        # Standard output is flushed by the caller, who reports a failure.
        sys.stderr.flush()
        sys.stdout, sys.stderr = original


def _guard_stream(stream: TextIO | None, descriptor: int, errors: str, *, silent: bool) -> TextIO:
    if stream is None:
        # The process began with a closed stream: keep its descriptor from the next opened file.
        return _null_stream(descriptor)
    # With PYTHONUNBUFFERED the buffer itself is the raw stream. Where pytest captures output, it
    # may be in memory, without a raw stream.
    buffer = getattr(stream, "buffer", None)
    raw = getattr(buffer, "raw", buffer)
    if not isinstance(raw, io.RawIOBase):
        return stream
    stream.flush()
    # Standard error, the silent stream, shows every line at once.
    return io.TextIOWrapper(
        io.BufferedWriter(_GuardedRaw(raw, silent=silent)),
        encoding=stream.encoding,
        errors=errors,
        line_buffering=silent or stream.isatty(),
    )


def _null_stream(descriptor: int) -> TextIO:
    # A stream on a descriptor that drops all data.
    null_descriptor = os.open(os.devnull, os.O_WRONLY)
    # Files are opened on the lowest free descriptor, which may be this one.
    if null_descriptor != descriptor:
        os.dup2(null_descriptor, descriptor)
        os.close(null_descriptor)
    return os.fdopen(descriptor, "w", encoding="utf-8", closefd=False)
