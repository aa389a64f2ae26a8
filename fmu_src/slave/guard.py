"""Entry points that no exception leaves: one would corrupt the wrapper's reference counts."""

import traceback
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

from fivtui.model.errors import ComputationError, InputError

_Method = TypeVar("_Method", bound=Callable[..., Any])


def guarded(fallback: Callable[..., object]) -> Callable[[_Method], _Method]:
    """Make a method an entry point that refuses instead of raising.

    Parameters
    ----------
    fallback : callable
        What a refused call returns, given its arguments.

    Returns
    -------
    callable
        The decorator. Its class has a method ``refuse(call, why)``, which is given the name of the
        entry point and a line, or a traceback where there is a defect.
    """

    def decorate(method: _Method) -> _Method:
        @wraps(method)
        def call(self: Any, /, *args: Any) -> Any:
            try:
                return method(self, *args)
            except (InputError, ComputationError) as error:
                why = str(error)
            except BaseException:  # noqa: BLE001
                why = traceback.format_exc()
            self.refuse(method.__name__, why)
            return fallback(*args)

        return cast("_Method", call)

    return decorate


def nothing(*_: object) -> None:
    """What a refused call returns that returns nothing."""
