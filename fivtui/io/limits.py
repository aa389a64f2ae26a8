"""Errors from limits of the operating system: disk space, file sizes, open files."""

import errno
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from fivtui.model import ComputationError

_FREE_SPACE: Final = "free space on the disk"
_FEWER_FILES: Final = "close files, or raise the limit on open files (ulimit -n)"
# Advice by error number of the operating system.
_ADVICE: Final[Mapping[int, str]] = {
    errno.ENOSPC: _FREE_SPACE,
    errno.EDQUOT: _FREE_SPACE,
    errno.EFBIG: "raise the limit on the size of files (ulimit -f)",
    errno.EMFILE: _FEWER_FILES,
    errno.ENFILE: _FEWER_FILES,
    errno.EROFS: "choose a folder that can be written",
    errno.EIO: "check the disk",
}


def system_limit_error(error: OSError, subject: str = "") -> ComputationError | None:
    """The error for a limit of the system; None if the error has another cause.

    The message begins with `subject`, by default the path in the error.
    """
    advice = _ADVICE.get(error.errno or 0)
    if advice is None:
        return None
    subject = subject or str(error.filename or "a file")
    return ComputationError(f"{subject}: {error.strerror}", advice)


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Make a temporary folder; errors from system limits become `ComputationError`."""
    try:
        with tempfile.TemporaryDirectory(prefix="fivtui-") as folder:
            yield Path(folder)
    except OSError as error:
        location = f"the folder for temporary files, {tempfile.gettempdir()}"
        raise system_limit_error(error, location) or error from None
