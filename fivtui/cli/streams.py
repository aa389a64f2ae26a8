"""Standard output and error that fail as commands do: one line, or in silence."""

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
    """The reader of standard output has gone: nobody is left to tell anything."""


class _Raw(io.RawIOBase):
    # The stream below, whose first failure is told in our words, or not at all; what is written
    # after it goes nowhere, so that nothing fails a second time when the process ends.
    def __init__(self, below: io.RawIOBase, *, silent: bool) -> None:
        self._below = below
        self._silent = silent
        self._failed = False

    def writable(self) -> bool:
        return True

    def isatty(self) -> bool:
        return self._below.isatty()

    def fileno(self) -> int:
        return self._below.fileno()

    def write(self, data: object) -> int:
        size = memoryview(data).nbytes  # type: ignore[arg-type]
        if self._failed:
            return size
        try:
            while (written := self._below.write(data)) is None:  # type: ignore[arg-type]
                # A pipe that does not wait is full.
                select.select([], [self._below], [])
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
    """Have standard output and error fail as a command does, for as long as the context lasts.

    A failure of standard output is a `ComputationError`, or `ReaderGone`; one of standard error is
    not told. What the encoding of standard output lacks is written as ``?``.
    """
    before = sys.stdout, sys.stderr
    try:
        sys.stdout = _guarded(sys.stdout, 1, "replace", silent=False)
        sys.stderr = _guarded(sys.stderr, 2, "backslashreplace", silent=True)
        yield
    finally:
        sys.stderr.flush()
        sys.stdout, sys.stderr = before


def _guarded(stream: TextIO | None, number: int, errors: str, *, silent: bool) -> TextIO:
    if stream is None:
        # A closed stream's number would go to the next file that is opened.
        return _nowhere(number)
    # There is no buffer where PYTHONUNBUFFERED is set; where a test took the stream, no raw one.
    buffer = getattr(stream, "buffer", None)
    below = getattr(buffer, "raw", buffer)
    if not isinstance(below, io.RawIOBase):
        return stream
    stream.flush()
    return io.TextIOWrapper(
        io.BufferedWriter(_Raw(below, silent=silent)),
        encoding=stream.encoding,
        errors=errors,
        line_buffering=silent or stream.isatty(),
    )


def _nowhere(number: int) -> TextIO:
    handle = os.open(os.devnull, os.O_WRONLY)
    if handle != number:
        os.dup2(handle, number)
        os.close(handle)
    return os.fdopen(number, "w", encoding="utf-8", closefd=False)
