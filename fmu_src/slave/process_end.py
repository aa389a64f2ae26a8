"""Makes the wrapper release the interpreter before the host's process ends.

At the end of a process, the wrapper of pythonfmu destroys the counter of its uses
of the interpreter, and then decrements it in freed memory, which may abort the host. Calling the
release function that the wrapper exports before that is harmless, also more than once.
"""

import atexit
import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

# Paths of the wrapper's libraries; an open library could not be unloaded by its host.
_libraries: Final[set[str]] = set()


def release_at_exit(resources: str | None) -> None:
    """Release the wrapper's libraries that are still loaded when the interpreter ends.

    Those are beside the FMU's folder of resources, in the spelling of the host.
    """
    # Without arguments the interpreter is embedded, and the wrapper itself releases it in time.
    if resources is None or sys.platform != "linux" or not sys.orig_argv:
        return
    if not _libraries:
        # Imported here: an embedded interpreter may not find it, and does not need it.
        from ctypes import CDLL

        atexit.register(_release, CDLL)
    _libraries.update(map(str, Path(resources).parent.glob("binaries/linux64/*.so")))


def _release(load: Any) -> None:
    for path in _libraries:
        # A library that is not loaded, or does not export the function, is ignored.
        with suppress(OSError, AttributeError):
            load(path, mode=os.RTLD_NOLOAD | os.RTLD_LAZY).finalizePythonInterpreter()
