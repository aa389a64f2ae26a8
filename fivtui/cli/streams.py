"""Standard output and error whose failures are reported in one line, or ignored."""

import io
import os
import select
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final, TextIO

from fivtui.model import ComputationError

_ADVICE: Final = "make room there, or write to a file with --out where a command has it"


class ReaderGone(Exception):
    """The reader of standard output has closed it (a broken pipe): exit without a message."""


class _GuardedRaw(io.RawIOBase):
    # A stream whose first failure is reported in one line, or ignored if `silent`. Later writes are
    # dropped, so that the exit of the process does not fail again.
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
    before = sys.stdout, sys.stderr
    try:
        sys.stdout = _guard_stream(sys.stdout, 1, "replace", silent=False)
        sys.stderr = _guard_stream(sys.stderr, 2, "backslashreplace", silent=True)
        yield
    finally:
        sys.stderr.flush()
        sys.stdout, sys.stderr = before


def _guard_stream(stream: TextIO | None, number: int, errors: str, *, silent: bool) -> TextIO:
    if stream is None:
        # Otherwise the next opened file would get the descriptor of the closed stream.
        return _null_stream(number)
    # No buffer with PYTHONUNBUFFERED; no raw stream where pytest captures.
    buffer = getattr(stream, "buffer", None)
    raw = getattr(buffer, "raw", buffer)
    if not isinstance(raw, io.RawIOBase):
        return stream
    stream.flush()
    return io.TextIOWrapper(
        io.BufferedWriter(_GuardedRaw(raw, silent=silent)),
        encoding=stream.encoding,
        errors=errors,
        line_buffering=silent or stream.isatty(),
    )


def _null_stream(number: int) -> TextIO:
    handle = os.open(os.devnull, os.O_WRONLY)
    if handle != number:
        os.dup2(handle, number)
        os.close(handle)
    return os.fdopen(number, "w", encoding="utf-8", closefd=False)
