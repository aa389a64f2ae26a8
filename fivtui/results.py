"""What results have in common: how they are listed, stored, drawn, and said as a command."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from html import escape
from pathlib import Path
from typing import Any, Final, NamedTuple

from fivtui.model import ALL_PARAMETERS, Parameters, System, without_effect

PHYSICS: Final = (*ALL_PARAMETERS, "separation")
_BASE: Final = Parameters().as_dict()


class Row(NamedTuple):
    """One line of a table: a label, its value with its unit, and a note."""

    label: str
    value: str
    note: str = ""


@dataclass(frozen=True, slots=True)
class Command:
    """A command of the command line, but for the scene that it begins with.

    Attributes
    ----------
    name : str
        The command, e.g. ``"map"``.
    scene : mapping
        Fields of the scene that it computes; all others are those of the base set.
    said : sequence of str
        Names of parameters and fields of a scene that its options can say.
    words : sequence of str
        Its other options.
    needed : mapping
        Fields that the scene that it begins with must have so: no option of it can change them.
    """

    name: str
    scene: Mapping[str, Any] = field(default_factory=dict)
    said: Sequence[str] = PHYSICS
    words: Sequence[str] = ()
    needed: Mapping[str, Any] = field(default_factory=dict)


def _dict_of(result: Any) -> Any:
    return result.to_dict()


def _figure_of(result: Any) -> Any:
    return result.figure()


def _rows_of(result: Any) -> Sequence[Row]:
    return [Row(*row) for row in result._summary()]


def _no_file(_result: Any, path: Path, *, force: bool) -> None:  # noqa: ARG001
    raise TypeError(f"{path}: results of this kind have no file")


def _no_warning(_result: Any) -> None:
    return None


@dataclass(frozen=True, slots=True)
class Stored:
    """How the laboratory keeps a result in a file of its own.

    Attributes
    ----------
    suffix : str
        Of the file.
    save, load : callable
        Write a result to a path, and read it.
    size : callable
        Approximate size of the file, bytes.
    unfinished : callable
        Why a result is not to be kept; empty if it is.
    """

    suffix: str
    save: Callable[[Any, Path], None]
    load: Callable[[Path], Any]
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
    to_dict : callable
        A result as data that JSON can hold; its own ``to_dict()`` if not given.
    figure : callable
        A result as a matplotlib figure; its own ``figure()`` if not given.
    warning : callable
        What a result warns of, in one sentence, or None.
    suffixes : tuple of str
        Formats in which `save` writes it; empty if in none.
    save : callable
        Takes a result, a path and, by keyword, `force`: whether to replace a file.
    as_json : bool
        Whether the laboratory offers JSON beside them.
    stem : callable
        Ending of the file name that is proposed for a result, e.g. ``"map-F-mu"``.
    load : callable or None
        Reads a result from a file; InputError if it is none. None if it is not read.
    load_suffixes, folders : tuple of str
        Suffixes of what `load` reads, and those of them that are folders.
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
    to_dict: Callable[[Any], Any] = _dict_of
    figure: Callable[[Any], Any] = _figure_of
    warning: Callable[[Any], str | None] = _no_warning
    suffixes: tuple[str, ...] = ()
    save: Callable[..., None] = _no_file
    as_json: bool = False
    stem: Callable[[Any], str] = str
    load: Callable[[Path], Any] | None = None
    load_suffixes: tuple[str, ...] = ()
    folders: tuple[str, ...] = ()
    header: frozenset[str] = frozenset()
    json_keys: frozenset[str] = frozenset()
    json_refusal: str = ""
    command: Callable[[Any], Command] | None = None
    stored: Stored | None = None


class Comparable:
    """Base of dataclasses that are compared by value; arrays are, too, and NaN equals NaN.

    The dataclass must have ``eq=False``; a field with ``compare=False`` is left out.
    """

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        return equal_values(self, other) if type(other) is type(self) else NotImplemented

    def __hash__(self) -> int:
        # Of what is equal for certain: arrays have no hash.
        hashed = (getattr(self, name) for name in _compared(self))
        return hash((type(self), *(v for v in hashed if isinstance(v, (System, Parameters, str)))))


def _compared(record: Any) -> list[str]:
    return [each.name for each in fields(record) if each.compare]


def equal_values(first: Any, second: Any) -> bool:
    """Whether two values are equal: arrays, dataclasses and containers element by element."""
    import numpy as np

    if type(first) is not type(second):
        return not (isinstance(first, np.ndarray) or isinstance(second, np.ndarray)) and bool(
            first == second
        )
    if isinstance(first, np.ndarray):
        return first.dtype == second.dtype and np.array_equal(
            first, second, equal_nan=first.dtype.kind in "fc"
        )
    if is_dataclass(first):
        names = _compared(first)
        first, second = ([getattr(each, name) for name in names] for each in (first, second))
    elif isinstance(first, Mapping):
        if first.keys() != second.keys():
            return False
        first, second = list(first.values()), [second[key] for key in first]
    if isinstance(first, (tuple, list)):
        return len(first) == len(second) and all(map(equal_values, first, second))
    is_nan = isinstance(first, float) and math.isnan(first) and math.isnan(second)
    return is_nan or bool(first == second)


class Result(Comparable):
    """Base of what computations return: it prints in a few lines, whatever it holds.

    A result also has, where they make sense, ``to_dict()``: the object that the command line prints
    with ``--json``; ``to_columns()``: one-dimensional arrays by name, as pandas and polars take
    them; and ``figure()``: a matplotlib figure.
    """

    __slots__ = ()

    def _summary(self) -> Sequence[tuple[str, str]]:
        raise NotImplementedError

    def __repr__(self) -> str:
        rows = self._summary()
        width = max(len(name) for name, _ in rows)
        return "\n".join(
            [type(self).__name__, *(f"  {name:<{width}}  {text}" for name, text in rows)]
        )

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>"
            for name, text in self._summary()
        )
        return f"<table><caption>{type(self).__name__}</caption><tbody>{rows}</tbody></table>"


class SystemResult(Result):
    """Base of results about one system, which their first field holds."""

    __slots__ = ()

    system: System

    @property
    def parameters(self) -> Parameters:
        """The parameter set."""
        return self.system.parameters

    @property
    def separation(self) -> bool:
        """Whether separation is considered."""
        return self.system.separation


def scene_fields(scene: Any, said: Sequence[str]) -> dict[str, Any]:
    """The parameters and the fields named of a scene, or of what has attributes like one."""
    names = [name for name in said if name not in ALL_PARAMETERS]
    return {name: getattr(scene, name) for name in ("parameters", *names)}


def scene_text(system: System, *, without: Sequence[str] = ()) -> str:
    """What a system changes of the base set, and the physics, in one phrase."""
    p = system.parameters
    changed = [
        f"{name}={value:g}"
        for name, value in p.as_dict().items()
        if value != _BASE.get(name) and name not in without
    ]
    phrases = [
        f"base set with {', '.join(changed)}" if changed else "base set",
        "" if system.separation else "separation ignored",
        without_effect(p, without),
    ]
    return "; ".join(phrase for phrase in phrases if phrase)
