"""Entry points that never raise: an exception would corrupt the wrapper's reference counts."""

import traceback
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

from fivtui.model.errors import ComputationError, InputError

_Method = TypeVar("_Method", bound=Callable[..., Any])


def guarded(fallback: Callable[..., object]) -> Callable[[_Method], _Method]:
    """Decorator for an entry point: instead of raising it calls ``self.refuse(call, why)``.

    It then returns `fallback` of its arguments. `why` is the message of an `InputError` or
    `ComputationError`, else a traceback.
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
    """Fallback for calls that return None."""
