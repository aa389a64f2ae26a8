"""Options of commands, declared as fields of a dataclass, and the arguments that set them.

A scene is a parameter set with the settings of its transient, such as the horizon and the method.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, Final, TypeVar, dataclass_transform

from .model import InputError, Interval, check_known

ANY_INTEGER: Final = Interval(-math.inf)
# Groups of options in the help of commands that have many.
STUDY: Final = "Study"
SCENE: Final = "Scene"
ACCURACY: Final = "Method and accuracy"
COMPUTATION: Final = "Computation"
OUTPUT: Final = "Output"
_OPTION: Final = "option"

Options = TypeVar("Options")


@dataclass(frozen=True, slots=True, kw_only=True)
class Option:
    """An option of the command line."""

    # E.g. --value, or --indices/--no-indices for a bool.
    flag: str
    help: str
    # The form of the value in the help; None for an option without a value.
    metavar: str | None = None
    multiple: bool = False
    required: bool = False
    show_default: bool = False
    choices: tuple[str, ...] = ()
    # The allowed integers, for an option that takes an integer.
    integers: Interval | None = None
    # Whether the value is the name of an input file.
    file: bool = False
    # Values that a shell proposes.
    completions: Callable[[], Iterable[str]] | None = None
    # The setting of the scene that the option replaces, such as t_end; empty if there is none.
    setting: str = ""
    # The group in the help.
    group: str = STUDY

    def arguments(self, value: Any) -> list[str]:
        """The arguments that set the option to a value, or to several values."""
        if isinstance(value, bool):
            return [self.flag.split("/")[0 if value else 1]]
        values = value if self.multiple else [value]
        return [argument for single in values for argument in (self.flag, str(single))]


def option_field(declared: Option, default: Any = None) -> Any:
    """A dataclass field for an option; an option that may be repeated has an empty default."""
    return field(default=() if declared.multiple else default, metadata={_OPTION: declared})


def option(flag: str, help: str, default: Any = None, **details: Any) -> Any:  # noqa: A002
    """A dataclass field for an option; `details` are fields of `Option`."""
    return option_field(Option(flag=flag, help=help, **details), default)


@dataclass_transform(kw_only_default=True, frozen_default=True)
def options_class(cls: type[Options]) -> type[Options]:
    """Make a class a dataclass of options, frozen only for type checkers.

    Python takes longer to define a frozen dataclass.
    """
    return dataclass(kw_only=True, eq=False, repr=False)(cls)


def flag(name: str, help: str, **details: Any) -> Any:  # noqa: A002
    """A dataclass field for a flag, false by default."""
    return option(name, help, default=False, **details)


def declared_options(options: Any) -> dict[str, tuple[Option, Any]]:
    """The options and defaults that the fields of an options class declare, by name."""
    return {entry.name: (entry.metadata[_OPTION], entry.default) for entry in fields(options)}


def option_arguments(options: Any) -> list[str]:
    """The arguments of a command line for the options that differ from their defaults."""
    return [
        argument
        for name, (declared, default) in declared_options(options).items()
        if getattr(options, name) != default
        for argument in declared.arguments(getattr(options, name))
    ]


def value_options(options: Any) -> dict[str, tuple[str, Option]]:
    """Names and declarations of the options with a value, except settings, by flag."""
    return {
        entry.flag: (name, entry)
        for name, (entry, _) in declared_options(options).items()
        if entry.metavar is not None and not entry.setting
    }


def read_arguments(
    options: type[Options], arguments: Iterable[str]
) -> tuple[Options, Sequence[str]]:
    """The options that arguments set, except settings and flags, and arguments without option."""
    declared = value_options(options)
    values: dict[str, Any] = {}
    positional, rest = [], iter(arguments)
    for argument in rest:
        if not argument.startswith("--"):
            positional.append(argument)
            continue
        flag_name, _, text = argument.partition("=")
        check_known("option", flag_name, declared)
        if not (text := text or next(rest, "")):
            raise InputError(f"{flag_name}: must be followed by a value")
        name, entry = declared[flag_name]
        values[name] = (*values.get(name, ()), text) if entry.multiple else text
    return options(**values), positional


def declared_settings(options: Any) -> list[str]:
    """The fields of a scene that the options of a command set."""
    return [
        declared.setting for declared, _ in declared_options(options).values() if declared.setting
    ]
