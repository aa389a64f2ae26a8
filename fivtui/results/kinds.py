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
    """A command of the command line, but for the scene that it begins with."""

    name: str
    # Fields of the scene that it computes; all others are those of the base set.
    scene: Mapping[str, Any] = field(default_factory=dict)
    # Parameters and fields of a scene that its options can say, and its other options.
    said: Sequence[str] = ()
    words: Sequence[str] = ()
    # Fields that the scene that it begins with must have so: no option of it changes them.
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
    """The command with these options for a scene, or for what has attributes like one.

    Its options say parameters and settings, but for those of `varied`, which they say themselves.
    `fields` take the place of attributes of `of`; `needed` is as in `Command`.
    """
    settings = ["separation"] if options is None else settings_of(options)
    scene = {key: getattr(of, key) for key in ("parameters", *settings) if key not in fields}
    said = [key for key in (*ALL_PARAMETERS, *settings) if key not in varied]
    words = [] if options is None else words_of(options)
    return Command(name, scene | fields, said, words, needed or {})


def _rows_of(result: Any) -> Sequence[Row]:
    return [Row(*row) for row in result._summary()]


def listed(
    title: str, rows: Callable[[Any], Sequence[Sequence[str]]] = _rows_of
) -> Callable[[Any], None]:
    """Printing of a result as a list of its rows below a title; those of its repr by default."""

    def show(result: Any) -> None:
        from fivtui.console import print_rows_of

        print_rows_of(title, [Row(*row) for row in rows(result)])

    return show


@dataclass(frozen=True, slots=True)
class Stored:
    """How the laboratory keeps a result in a file of its own.

    Attributes
    ----------
    suffix : str
        Of the file.
    save, load : callable or None
        Write a result to a path, and read it; as `StudyKind` if not given.
    size : callable
        Approximate size of the file, bytes.
    unfinished : callable
        Why a result is not to be kept; empty if it is.
    """

    suffix: str
    save: Callable[[Any, Path], None] | None = None
    load: Callable[[Path], Any] | None = None
    size: Callable[[Any], int] = lambda _result: 0
    unfinished: Callable[[Any], str] = lambda _result: ""


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyKind:
    """A kind of study: all that the command line and the laboratory do with its results.

    Attributes
    ----------
    data : str
        What a file holds, named in messages, e.g. ``"table of modes"``.
    show : callable
        Prints a result on standard output.
    rows : callable
        The figures of a result, as its table has them; those of its ``repr`` if not given.
    to_dict, figure, warning : callable
        A result as data that JSON can hold, as a matplotlib figure, and what it warns of, in one
        sentence, or None; its own if not given.
    suffixes : tuple of str
        Formats in which `save` writes it; empty if in none.
    save : callable
        Takes a result, a path and, by keyword, `force`: whether to replace a file. That of
        `TableResult` if not given.
    as_json : bool
        Whether the laboratory offers JSON beside them.
    stem : callable
        Ending of the file name that is proposed for a result, e.g. ``"map-F-mu"``.
    load : callable or None
        Reads a result from a file; InputError if it is none. None if it is not read.
    folders : tuple of str
        Suffixes of folders that `load` reads.
    header, json_keys : frozenset of str
        Keys by which a table, or JSON, is recognised as of this kind.
    json_refusal : str
        Why JSON of this kind cannot be read; empty if it can.
    command : callable or None
        The command that computes what it takes: a result, or what one is of.
    stored : Stored or None
        The file in which the laboratory keeps a result between two starts.
    """

    data: str
    show: Callable[[Any], None]
    rows: Callable[[Any], Sequence[Row]] = _rows_of
    to_dict: Callable[[Any], Any] = methodcaller("to_dict")
    figure: Callable[[Any], Any] = methodcaller("figure")
    warning: Callable[[Any], str | None] = lambda result: getattr(result, "warning", None) or None
    suffixes: tuple[str, ...] = ()
    save: Callable[..., None] = save_result
    as_json: bool = False
    stem: Callable[[Any], str] = str
    load: Callable[[Path], Any] | None = None
    folders: tuple[str, ...] = ()
    header: frozenset[str] = frozenset()
    json_keys: frozenset[str] = frozenset()
    json_refusal: str = ""
    command: Callable[[Any], Command] | None = None
    stored: Stored | None = None
