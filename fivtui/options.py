"""Options of commands, declared as fields of a dataclass, and the arguments that set them."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, fields
from typing import Any, Final, TypeVar, dataclass_transform

from .model import Interval

ANY_WHOLE: Final = Interval(-math.inf)
_OPTION: Final = "option"

Options = TypeVar("Options")


@dataclass(frozen=True, slots=True, kw_only=True)
class Option:
    """An option of the command line."""

    # E.g. --value, or --indices/--no-indices for a bool.
    flag: str
    help: str
    # The form of its value; None for a flag without one.
    metavar: str | None = None
    multiple: bool = False
    required: bool = False
    show_default: bool = False
    choices: tuple[str, ...] = ()
    # The allowed integers, for an option that takes an integer.
    integers: Interval | None = None
    # Whether the value is the name of a file to be read.
    file: bool = False
    # Values that a shell proposes.
    completions: Callable[[], Iterable[str]] | None = None
    # The field of a scene that it sets.
    setting: str = ""

    def words(self, value: Any) -> list[str]:
        """The arguments that set the option to a value, or to several values."""
        if isinstance(value, bool):
            return [self.flag.split("/")[0 if value else 1]]
        values = value if self.multiple else [value]
        return [argument for single in values for argument in (self.flag, str(single))]


def option_field(declared: Option, default: Any = None) -> Any:
    """A field that is an option; its default is empty if it may be repeated."""
    return field(default=() if declared.multiple else default, metadata={_OPTION: declared})


def option(flag: str, help: str, default: Any = None, **details: Any) -> Any:  # noqa: A002
    """A field that is an option, see `Option`."""
    return option_field(Option(flag=flag, help=help, **details), default)


@dataclass_transform(kw_only_default=True, frozen_default=True)
def declaration(of: type[Options]) -> type[Options]:
    """A dataclass whose fields are options; cheaper to define than a frozen dataclass."""
    return dataclass(kw_only=True, eq=False, repr=False)(of)


def flag(name: str, help: str) -> Any:  # noqa: A002
    """A field that is true if its flag is given."""
    return option(name, help, default=False)


def options_of(declaration: Any) -> dict[str, tuple[Option, Any]]:
    """The options, with their defaults, that the fields of a dataclass declare."""
    return {entry.name: (entry.metadata[_OPTION], entry.default) for entry in fields(declaration)}


def words_of(values: Any) -> list[str]:
    """The arguments of a command line for the options that differ from their defaults."""
    return [
        argument
        for name, (declared, default) in options_of(values).items()
        if getattr(values, name) != default
        for argument in declared.words(getattr(values, name))
    ]


def settings_of(declaration: Any) -> list[str]:
    """The fields of a scene that the options of a command set."""
    return [
        declared.setting for declared, _ in options_of(declaration).values() if declared.setting
    ]
