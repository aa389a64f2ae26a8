"""The end of the host's process: the wrapper lets go of the interpreter before its memory is gone.

When a process ends, the wrappers of pythonfmu and pythonfmu3 destroy the counter of their uses of
the interpreter, and then count down once more in freed memory, which may abort the host. Done
before, by the function that the wrapper exports for it, this is harmless, and so is its repetition.
"""

import atexit
import ctypes
import os
import sys
from pathlib import Path
from typing import Final

# Of FMI 2.0 and 3.0.
_FOLDERS: Final = ("linux64", "x86_64-linux")
_known: Final[set[str]] = set()


def let_go_in_time(resources: str | None) -> None:
    """Have the wrapper let go of the interpreter when that ends, once for each library.

    Parameters
    ----------
    resources : str or None
        The FMU's folder of resources; the libraries stand beside it. One that is not loaded, or
        does not export the function, is left alone.
    """
    # Without arguments the interpreter is embedded: there the wrapper itself ends it, in time.
    if resources is None or sys.platform != "linux" or not sys.orig_argv:
        return
    binaries = Path(resources).parent / "binaries"
    for library in (found for folder in _FOLDERS for found in (binaries / folder).glob("*.so")):
        path = os.path.realpath(library)
        if path in _known:
            continue
        _known.add(path)
        try:
            # Only what is loaded already; holding it keeps the function where it is.
            wrapper = ctypes.CDLL(path, mode=os.RTLD_NOLOAD | os.RTLD_LAZY)
            atexit.register(wrapper.finalizePythonInterpreter)
        except (OSError, AttributeError):
            continue
