"""Kinds of studies: what the command line and the laboratory do with each kind of result.

The laboratory is the interactive program in the terminal. A scene is a parameter set with start,
horizon and the settings of a computation.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from operator import methodcaller
from pathlib import Path
from typing import Any, Final

from fivtui.io import FORMATS
from fivtui.model import ALL_PARAMETERS, ComputationError
from fivtui.options import declared_settings, option_arguments

from .base import Row
from .tables import save_result

# File suffixes of tables.
TABLE_SUFFIXES: Final = tuple(FORMATS)


@dataclass(frozen=True, slots=True)
class Command:
    """A command of the command line, without the scene that is its first argument."""

    name: str
    # The computed scene, by field; other fields have the values of the preset `base`.
    scene: Mapping[str, Any] = field(default_factory=dict)
    # Parameters and fields of a scene that options of the command can set.
    settable: Sequence[str] = ()
    # Arguments of the command that do not set the scene.
    arguments: Sequence[str] = ()
    # Values of fields that no option of the command sets, so that the scene in its first argument
    # must have them.
    scene_only: Mapping[str, Any] = field(default_factory=dict)
    # Quantities to which options give distributions: its scene must not scatter others.
    scattered: Collection[str] | None = None


def command_for(
    name: str,
    source: Any,
    options: Any = None,
    *,
    varied: Collection[str] = (),
    scene_only: Mapping[str, Any] | None = None,
    scattered: Collection[str] | None = None,
    **fields: Any,
) -> Command:
    """The command that computes `source`: a scene, or an object with attributes of the same names.

    Parameters and settings in `varied` are already in `options`. `fields` replace attributes of
    `source`; `scene_only` and `scattered` are as in `Command`.
    """
    settings = ["separation"] if options is None else declared_settings(options)
    scene = {key: getattr(source, key) for key in ("parameters", *settings) if key not in fields}
    settable = [key for key in (*ALL_PARAMETERS, *settings) if key not in varied]
    arguments = [] if options is None else option_arguments(options)
    return Command(name, scene | fields, settable, arguments, scene_only or {}, scattered)


def _repr_rows(result: Any) -> Sequence[Row]:
    return [Row(*row) for row in result._summary()]


def list_printer(
    title: str | Callable[[Any], str], rows: Callable[[Any], Sequence[Sequence[str]]] = _repr_rows
) -> Callable[[Any], None]:
    """A function that prints a result as a list under a title; by default the rows of its repr."""

    def print_rows(result: Any) -> None:
        from fivtui.console import print_list

        print_list(title if isinstance(title, str) else title(result), rows(result))

    return print_rows


@dataclass(frozen=True, slots=True)
class Storage:
    """How the laboratory stores a result; `save` and `load` are those of `StudyKind` by default."""

    suffix: str
    save: Callable[[Any, Path], None] | None = None
    load: Callable[[Path], Any] | None = None
    # Approximate size of the file, bytes.
    size: Callable[[Any], int] = lambda _result: 0
    # The reason why a result must not be stored; empty if it may be.
    reason_not_to_store: Callable[[Any], str] = lambda _result: ""


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyKind:
    """A kind of study: what the command line and the laboratory do with its results."""

    # Name of the contents of its files in messages, e.g. "table of modes".
    contents_name: str
    # Prints a result on standard output.
    show: Callable[[Any], None]
    # Rows of the table of a result; by default those of its repr.
    rows: Callable[[Any], Sequence[Row]] = _repr_rows
    # Data of a result for JSON.
    to_dict: Callable[[Any], Any] = methodcaller("to_dict")
    # The matplotlib figure of a result.
    figure: Callable[[Any], Any] = methodcaller("figure")
    # The warning of a result; None if there is none.
    warning: Callable[[Any], str | None] = lambda result: getattr(result, "warning", None) or None
    # The error of a result if nothing could be computed; None if something was.
    failure: Callable[[Any], ComputationError | None] = lambda _result: None
    # File suffixes that `save` can write.
    suffixes: tuple[str, ...] = ()
    # Writes a result to a file.
    save: Callable[..., None] = save_result
    # Whether the laboratory also offers JSON.
    as_json: bool = False
    # Part of the default file name that describes the result, e.g. "map-F-mu".
    stem: Callable[[Any], str] = str
    # Reads a result from a file, or from a folder whose suffix is in `folders`.
    load: Callable[[Path], Any] | None = None
    folders: tuple[str, ...] = ()
    # Keys in the header of a table that identify the kind.
    header_keys: frozenset[str] = frozenset()
    # Keys of a JSON object that identify the kind.
    json_keys: frozenset[str] = frozenset()
    # Why JSON of this kind cannot be read, a phrase after the name of the file; empty if it can.
    json_refusal: str = ""
    # The command that computes a given result or request.
    command: Callable[[Any], Command] | None = None
    # How the laboratory stores a result when it is closed; None if it does not.
    storage: Storage | None = None
