"""Makes the wrapper release the interpreter before the host's process ends.

At the end of a process, the wrapper of pythonfmu destroys the counter of its uses
of the interpreter, and then decrements it in freed memory, which may abort the host. Calling the
release function that the wrapper exports before that is harmless, also more than once.
"""

import atexit
import os
import sys
from pathlib import Path
from typing import Final

_known: Final[set[str]] = set()


def release_at_exit(resources: str | None) -> None:
    """Release the wrapper's libraries when the interpreter ends, once for each library.

    Those are beside the FMU's folder of resources; a library that is not loaded, or does not export
    the function, is ignored.
    """
    # Without arguments the interpreter is embedded, and the wrapper itself releases it in time.
    if resources is None or sys.platform != "linux" or not sys.orig_argv:
        return
    # Imported here: an embedded interpreter may not find it, and does not need it.
    import ctypes

    for library in Path(resources).parent.glob("binaries/linux64/*.so"):
        path = os.path.realpath(library)
        if path in _known:
            continue
        _known.add(path)
        try:
            # Only if already loaded; keeping the library keeps the function valid.
            wrapper = ctypes.CDLL(path, mode=os.RTLD_NOLOAD | os.RTLD_LAZY)
            atexit.register(wrapper.finalizePythonInterpreter)
        except (OSError, AttributeError):
            continue
