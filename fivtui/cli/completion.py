"""Shell completion of the values of options."""

from collections.abc import Callable, Iterable
from typing import Final

import click

from fivtui.model import ALL_PARAMETERS, PARAMETERS

Completer = Callable[[click.Context, click.Parameter, str], list[str]]


def names_of(known: Callable[[], Iterable[str]], end: str = "") -> Completer:
    """A completer that proposes the known names, each followed by `end`."""

    def complete(_context: click.Context, _param: click.Parameter, typed: str) -> list[str]:
        return [f"{name}{end}" for name in known() if name.startswith(typed)]

    return complete


def _starts() -> Iterable[str]:
    from fivtui.transient import START_SPECS

    return START_SPECS


def _methods() -> Iterable[str]:
    from fivtui.transient import ALL_METHODS

    return ALL_METHODS


def _quantities() -> Iterable[str]:
    from fivtui.transient import QUANTITIES

    return QUANTITIES


def _sweeps() -> Iterable[str]:
    from fivtui.sweeps import SWEEP_PRESETS

    return SWEEP_PRESETS


SET_VALUES: Final = names_of(lambda: ALL_PARAMETERS, "=")
PARAMETER_VALUES: Final = names_of(lambda: PARAMETERS, "=")
PARAMETER_NAMES: Final = names_of(lambda: ALL_PARAMETERS)
START_VALUES: Final = names_of(_starts, "=")
VARIED_VALUES: Final = names_of(lambda: (*ALL_PARAMETERS, *_starts()), "=")
SCATTERED_VALUES: Final = names_of(lambda: (*ALL_PARAMETERS, *_starts()), "~")
ERROR_VALUES: Final = names_of(_quantities, "=")
METHOD_NAMES: Final = names_of(_methods)
SWEEP_PRESET_NAMES: Final = names_of(_sweeps)
