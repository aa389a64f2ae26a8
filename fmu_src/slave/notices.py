"""Messages of an instance: to the host's log, and always to standard error.

Hosts show the log only if debug logging is on. The wrappers never free a logged text, so an
instance logs few different ones, and equal ones are one object.
"""

import logging
import sys
from contextlib import suppress
from typing import Final

# Without a handler of the host's own, Python prints warnings and errors to standard error.
LOGGER: Final = "fivtui.fmu"
_PRINTED: Final = 20
_DIFFERENT: Final = 1000
_UNPRINTED: Final = "further refusals are not printed here; switch on the FMU's debug logging"
_UNTOLD: Final = f"refused, for another reason than the first {_DIFFERENT} that were logged"


class Notices:
    """Messages of one instance, given its name."""

    def __init__(self, instance: str) -> None:
        self._instance = instance
        self._printed = 0
        self._logged: set[str] = set()

    def tell(self, level: int, text: str) -> str:
        """Print a text (a line or a traceback) to standard error, unless there were too many.

        `level` is one of Python's ``logging``. Returns the text as the wrapper's logger needs it.
        """
        if self._printed <= _PRINTED:
            self._print(level, text if self._printed < _PRINTED else _UNPRINTED)
            self._printed += 1
        if text not in self._logged:
            if len(self._logged) >= _DIFFERENT:
                text = _UNTOLD
            self._logged.add(text)
        # Hosts use the message as a format string.
        return sys.intern(text.replace("%", "%%"))

    def _print(self, level: int, text: str) -> None:
        # Exceptions of the host's handlers must not leave an entry point of the FMU, either.
        with suppress(BaseException):
            logging.getLogger(LOGGER).log(
                level, "%s: %s", self._instance, text, extra={"fmu_instance": self._instance}
            )
