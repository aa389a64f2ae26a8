"""Kinds of studies: what the command line and the laboratory do with each kind of result."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from operator import methodcaller
from pathlib import Path
from typing import Any, Final

from fivtui.io import FORMATS
from fivtui.model import ALL_PARAMETERS
from fivtui.options import settings_of, words_of

from .base import Row
from .tables import save_result

# Formats of tables.
TABLES: Final = tuple(FORMATS)


@dataclass(frozen=True, slots=True)
class Command:
    """A command of the command line without the scene it begins with."""

    name: str
    # Fields of the scene that it computes; other fields are those of the base set.
    scene: Mapping[str, Any] = field(default_factory=dict)
    # Parameters and fields of a scene that its options can set, and its remaining arguments.
    settable: Sequence[str] = ()
    arguments: Sequence[str] = ()
    # Fields that the scene it begins with must have, as no option of the command sets them.
    needed: Mapping[str, Any] = field(default_factory=dict)


def command_for(
    name: str,
    of: Any,
    options: Any = None,
    *,
    varied: Collection[str] = (),
    needed: Mapping[str, Any] | None = None,
    **fields: Any,
) -> Command:
    """The command with these options for a scene, or an object with the same attributes.

    Its options set parameters and settings except those of `varied`, which other options set.
    `fields` replace attributes of `of`; `needed` is as in `Command`.
    """
    settings = ["separation"] if options is None else settings_of(options)
    scene = {key: getattr(of, key) for key in ("parameters", *settings) if key not in fields}
    settable = [key for key in (*ALL_PARAMETERS, *settings) if key not in varied]
    arguments = [] if options is None else words_of(options)
    return Command(name, scene | fields, settable, arguments, needed or {})


def _rows_of(result: Any) -> Sequence[Row]:
    return [Row(*row) for row in result._summary()]


def listed(
    title: str | Callable[[Any], str], rows: Callable[[Any], Sequence[Sequence[str]]] = _rows_of
) -> Callable[[Any], None]:
    """A function that prints a result as a title and rows; by default the rows of its repr."""

    def show(result: Any) -> None:
        from fivtui.console import print_list

        print_list(title if isinstance(title, str) else title(result), rows(result))

    return show


@dataclass(frozen=True, slots=True)
class Stored:
    """How the laboratory stores a result in a file; `StudyKind` has the defaults."""

    suffix: str
    save: Callable[[Any, Path], None] | None = None
    load: Callable[[Path], Any] | None = None
    # Approximate size of the file, bytes.
    size: Callable[[Any], int] = lambda _result: 0
    # Why a result must not be stored; empty if it may be.
    unfinished: Callable[[Any], str] = lambda _result: ""


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyKind:
    """A kind of study: all that the command line and the laboratory do with its results."""

    # What a file holds, named in messages, e.g. "table of modes".
    data: str
    # Prints a result on standard output.
    show: Callable[[Any], None]
    # Rows of the table of a result; by default those of its repr.
    rows: Callable[[Any], Sequence[Row]] = _rows_of
    # A result as data for JSON, as a matplotlib figure, and its warning.
    to_dict: Callable[[Any], Any] = methodcaller("to_dict")
    figure: Callable[[Any], Any] = methodcaller("figure")
    warning: Callable[[Any], str | None] = lambda result: getattr(result, "warning", None) or None
    # Formats that `save` writes; `save` takes a result, a path and, by keyword, `force`.
    suffixes: tuple[str, ...] = ()
    save: Callable[..., None] = save_result
    # Whether the laboratory also offers JSON.
    as_json: bool = False
    # Ending of the file name that is proposed for a result, e.g. "map-F-mu".
    stem: Callable[[Any], str] = str
    # Reads a result from a file, or from a folder with one of these suffixes.
    load: Callable[[Path], Any] | None = None
    folders: tuple[str, ...] = ()
    # Keys by which a table, or JSON, is recognised as of this kind.
    header: frozenset[str] = frozenset()
    json_keys: frozenset[str] = frozenset()
    # Why JSON of this kind cannot be read; empty if it can.
    json_refusal: str = ""
    # The command that computes its argument: a result, or the request for one.
    command: Callable[[Any], Command] | None = None
    # The file in which the laboratory stores a result between two starts.
    stored: Stored | None = None
