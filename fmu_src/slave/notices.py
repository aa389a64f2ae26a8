"""What an instance tells its user: for the host's log, and on standard error in any case.

Hosts show the log only if debug logging is on. The wrappers never free a text that they have
logged, so an instance logs few different ones, and equal ones are one object.
"""

import logging
import sys
from contextlib import suppress
from typing import Final

# Without a handler of the host's own, Python prints warnings and errors to standard error.
LOGGER: Final = "fivtui.fmu"
_PRINTED: Final = 20
_DIFFERENT: Final = 1000
_UNPRINTED: Final = "what else is refused is not printed here; switch the FMU's debug logging on"
_UNTOLD: Final = f"refused, for another reason than the first {_DIFFERENT} that were logged"


class Notices:
    """What one instance tells its user.

    Parameters
    ----------
    instance : str
        Name of the instance.
    """

    def __init__(self, instance: str) -> None:
        self._instance = instance
        self._printed = 0
        self._logged: set[str] = set()

    def tell(self, level: int, text: str) -> str:
        """Print a line to standard error, if there were not too many.

        Parameters
        ----------
        level : int
            Of Python's ``logging``.
        text : str
            A line, or a traceback.

        Returns
        -------
        str
            The text as it can be given to the wrapper's logger.
        """
        if self._printed <= _PRINTED:
            self._print(level, text if self._printed < _PRINTED else _UNPRINTED)
            self._printed += 1
        if text not in self._logged:
            if len(self._logged) >= _DIFFERENT:
                text = _UNTOLD
            self._logged.add(text)
        # The message is a format to the host.
        return sys.intern(text.replace("%", "%%"))

    def _print(self, level: int, text: str) -> None:
        # No exception may leave an entry point of the FMU, not even one of the host's handlers.
        with suppress(BaseException):
            logging.getLogger(LOGGER).log(
                level, "%s: %s", self._instance, text, extra={"fmu_instance": self._instance}
            )
