"""Loading of compiled kernels in the background.

To import this module costs nothing: numba, and with it the compiler, is imported by the thread.
"""

import atexit
import threading
from importlib import import_module
from typing import Any, Final

from fivtui.model import ComputationError

# A process that ends within this time never starts the compiler.
_DELAY_S: Final = 0.25


class _Stopped(BaseException):
    """The process ends while the compiler is at work."""


class KernelLoader:
    """Loads a module of kernels once, from numba's cache on disk or by compiling it.

    Parameters
    ----------
    name : str
        The module, in `fivtui.kernel`.

    Attributes
    ----------
    failure : str or None
        Why there are no kernels, if loading them failed.
    """

    def __init__(self, name: str) -> None:
        self.failure: str | None = None
        self._name = name
        self._module: Any = None
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._wanted_now = threading.Event()
        self._done = threading.Event()
        self._stopping = False

    @property
    def ready(self) -> bool:
        """Whether the kernels are loaded."""
        return self._module is not None

    @property
    def loading(self) -> bool:
        """Whether they are being loaded or compiled."""
        return self._thread is not None and not self._done.is_set()

    @property
    def awaited(self) -> bool:
        """Whether somebody waits for them."""
        return self._wanted_now.is_set() and self.loading

    def start(self) -> None:
        """Load the kernels in the background, a moment from now.

        From the cache on disk that takes half a second, without it several. It never fails:
        `failure` tells.
        """
        with self._lock:
            if self._thread is None and not self._stopping:
                self._thread = threading.Thread(
                    target=self._load, name=f"kernels-{self._name}", daemon=True
                )
                atexit.register(self._stop)
                self._thread.start()

    def wait(self, seconds: float) -> bool:
        """Wait for the kernels, but not for long.

        Parameters
        ----------
        seconds : float
            The longest wait.

        Returns
        -------
        bool
            Whether they are loaded, or cannot be: `module` does not wait any more.
        """
        self._wanted_now.set()
        self.start()
        return self._done.wait(seconds)

    def module(self) -> Any:
        """The kernels; waits until they are loaded.

        Returns
        -------
        module
            In `fivtui.kernel`.

        Raises
        ------
        ComputationError
            If they cannot be had.
        """
        if self._module is None:
            self._wanted_now.set()
            self.start()
            self._done.wait()
        if self._module is None:
            raise ComputationError(
                f"the compiled kernels cannot be loaded: {self.failure}",
                "use the interpreted kernel, or mend the installation of numba",
            )
        return self._module

    def _load(self) -> None:
        self._wanted_now.wait(_DELAY_S)
        try:
            if self._stopping:
                raise _Stopped
            self._module = self._imported()
        except _Stopped:
            self.failure = "the process is ending"
        except Exception as error:  # noqa: BLE001, whatever stops a compiler is to be reported
            first_line = next(iter(str(error).splitlines()), "")
            self.failure = f"{type(error).__name__}: {first_line}"
        self._done.set()

    def _imported(self) -> Any:
        # The package settles how numba starts: it comes first.
        from fivtui import kernel as kernels  # isort: skip

        from numba.core.event import Listener, install_listener

        loader, own = self, threading.get_ident()

        class Brake(Listener):
            def on_start(self, _event: Any) -> None:
                if loader._stopping and threading.get_ident() == own:
                    raise _Stopped

            def on_end(self, _event: Any) -> None:
                pass

        with install_listener("numba:run_pass", Brake()):
            return import_module(f"{kernels.__name__}.{self._name}")

    def _stop(self) -> None:
        # The compiler must have left LLVM before the process takes that down; it looks at
        # `_stopping` after every pass.
        self._stopping = True
        self._wanted_now.set()
        if self._thread is not None:
            self._thread.join()


# The two kernels: one run, and many at a time in the lanes of vector registers.
single = KernelLoader("single")
lanes = KernelLoader("lanes")
