"""Base classes of results: comparison by value, and a summary of a few lines."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from html import escape
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from fivtui.model import Parameters, System, describe_unused

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fivtui.charts import Sheet

_BASE_VALUES: Final = Parameters().as_dict()


class Row(NamedTuple):
    """One line of a table: a label, its value with its unit, and a note."""

    label: str
    value: str
    note: str = ""


class Comparable:
    """Base of dataclasses compared by value, including arrays; NaN equals NaN.

    The dataclass must have ``eq=False``; a field with ``compare=False`` is left out.
    """

    __slots__ = ()

    def __eq__(self, value: object) -> bool:
        return equal_values(self, value) if type(value) is type(self) else NotImplemented

    def __hash__(self) -> int:
        # Arrays cannot be hashed: hash only fields of these types.
        values = [getattr(self, name) for name in _compared_fields(self)]
        hashable = [value for value in values if isinstance(value, (System, Parameters, str))]
        return hash((type(self), *hashable))


def _compared_fields(record: Any) -> list[str]:
    return [item.name for item in fields(record) if item.compare]


def equal_values(first: Any, second: Any) -> bool:
    """Whether two values are equal: arrays, dataclasses and containers element by element."""
    import numpy as np

    if type(first) is not type(second):
        has_array = isinstance(first, np.ndarray) or isinstance(second, np.ndarray)
        return not has_array and bool(first == second)
    if isinstance(first, np.ndarray):
        return first.dtype == second.dtype and np.array_equal(
            first, second, equal_nan=first.dtype.kind in "fc"
        )
    if is_dataclass(first):
        names = _compared_fields(first)
        return all(equal_values(getattr(first, name), getattr(second, name)) for name in names)
    if isinstance(first, Mapping):
        return first.keys() == second.keys() and all(
            equal_values(value, second[key]) for key, value in first.items()
        )
    if isinstance(first, (tuple, list)):
        return len(first) == len(second) and all(map(equal_values, first, second))
    are_nan = isinstance(first, float) and math.isnan(first) and math.isnan(second)
    return are_nan or bool(first == second)


class Result(Comparable):
    """Base of results of computations; their repr is a summary of a few lines.

    Most results also have ``to_dict()``: the object that the command line prints with ``--json``;
    ``to_columns()``: one-dimensional arrays by name for pandas and polars; and ``figure()``: a
    matplotlib figure.
    """

    __slots__ = ()

    @property
    def warning(self) -> str | None:
        """The warning of the result in one sentence; None if there is none."""
        return None

    def _summary(self) -> Sequence[tuple[str, ...]]:
        # Rows of the repr: a label, a value and an optional note.
        raise NotImplementedError

    def _lines(self) -> list[tuple[str, str]]:
        # Lines of the repr: a label, and its value with the note.
        return [(label, "  ".join(filter(None, texts))) for label, *texts in self._summary()]

    def __repr__(self) -> str:
        rows = self._lines()
        width = max(len(name) for name, _ in rows)
        return "\n".join(
            [type(self).__name__, *(f"  {name:<{width}}  {text}" for name, text in rows)]
        )

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>"
            for name, text in self._lines()
        )
        return f"<table><caption>{type(self).__name__}</caption><tbody>{rows}</tbody></table>"


class Plottable:
    """Base of results with a figure, which is drawn from the sheet of their charts."""

    __slots__ = ()

    def _sheet(self) -> "Sheet":
        raise NotImplementedError

    def figure(self) -> "Figure":
        """Matplotlib figure of the result, without a window; `InputError` if it has no charts."""
        from fivtui.charts import sheet_figure

        return sheet_figure(self._sheet())


class SystemResult(Result):
    """Base of results about one system; the field `system` holds it."""

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

    @property
    def _varied(self) -> tuple[str, ...]:
        # Names of the parameters that vary in the result.
        return ()

    def _system_data(self) -> dict[str, Any]:
        # The parameters that do not vary, and separation, as data for JSON.
        values = self.parameters.as_dict()
        return {
            "parameters": {name: values[name] for name in values if name not in self._varied},
            "separation": self.separation,
        }


def scene_text(system: System, *, without: Sequence[str] = ()) -> str:
    """A system as a phrase: how it differs from the base set, and parameters without an effect."""
    p = system.parameters
    differences = [
        f"{name}={value:g}"
        for name, value in p.as_dict().items()
        if value != _BASE_VALUES.get(name) and name not in without
    ]
    phrases = [
        f"base set with {', '.join(differences)}" if differences else "base set",
        "" if system.separation else "separation ignored",
        describe_unused(p, without),
    ]
    return "; ".join(phrase for phrase in phrases if phrase)
