"""The parameter table: names, symbols, units, defaults and bounds, defined once."""

import difflib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields
from operator import attrgetter
from typing import Final, Self

from .errors import InputError
from .numbers import Interval


@dataclass(frozen=True, slots=True)
class ParameterSpec:
    """One row of the parameter table.

    Attributes
    ----------
    name : str
        Name in Python, in scene files and on the command line.
    symbol : str
        Symbol in the paper.
    unit : str
        SI unit; empty if dimensionless.
    default : float
        Value in the base set (section 2 of the paper; F, k_nl and mu from section 5.1).
    lower, upper : float
        Bounds of the allowed range.
    lower_open : bool
        Whether `lower` itself is excluded.
    meaning : str
        One phrase.
    """

    name: str
    symbol: str
    unit: str
    default: float
    lower: float
    upper: float
    lower_open: bool
    meaning: str

    @property
    def allowed(self) -> str:
        """The allowed range in words."""
        return str(self._interval)

    @property
    def _interval(self) -> Interval:
        return Interval(self.lower, self.upper, self.unit, self.lower_open)

    def check(self, value: object) -> float:
        """Return `value`, a number or its text, as a float in `unit`.

        Raises `InputError` if it is not a finite number within the bounds.
        """
        # Nearly every call, without the cost of an interval.
        if isinstance(value, float) and self.lower < value <= self.upper:
            return float(value)
        return self._interval.check(self.name, value)


# Share of the letters that a name has in common with the one suggested in its place.
_NEAR: Final = 0.6


def unknown_name(kind: str, name: str, known: Iterable[str]) -> InputError:
    """The error for an unknown name; it suggests the nearest known one.

    Parameters
    ----------
    kind : str
        What the name stands for, e.g. ``"parameter"``.
    name : str
        The unknown name.
    known : iterable of str
        The known names.
    """
    names = list(known)
    # A single letter is like every short name that has it.
    folded = {
        candidate.casefold(): candidate
        for candidate in names
        if len(candidate) > 1 or candidate.casefold() == name.casefold()
    }
    near = difflib.get_close_matches(name.casefold(), folded, n=1, cutoff=_NEAR)
    hint = f"; did you mean {folded[near[0]]}?" if near else ""
    return InputError(f"unknown {kind} {name!r}{hint} (known: {', '.join(names)})")


_STIFFNESS_MAX: Final = 1e12


def _spec(
    symbol: str,
    unit: str,
    default: float,
    bounds: tuple[float, float],
    meaning: str,
    *,
    lower_open: bool = False,
) -> float:
    # A dataclass field whose metadata becomes a row of the table.
    value: float = field(
        default=default,
        metadata={
            "symbol": symbol,
            "default": default,
            "unit": unit,
            "lower": bounds[0],
            "upper": bounds[1],
            "lower_open": lower_open,
            "meaning": meaning,
        },
    )
    return value


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters:
    """The nine parameters of the slider-belt model, in SI units (Eqs. 1 and 2).

    Every value is checked against its `ParameterSpec`, so an instance is always valid.

    Raises
    ------
    InputError
        If a value is not a finite number within its bounds.
    """

    m: float = _spec("m", "kg", 5.0, (0.0, 1e9), "mass of the slider", lower_open=True)
    k1: float = _spec(
        "k_1", "N/m", 100.0, (0.0, _STIFFNESS_MAX), "horizontal stiffness", lower_open=True
    )
    k2: float = _spec(
        "k_2", "N/m", 50.0, (0.0, _STIFFNESS_MAX), "linear contact stiffness", lower_open=True
    )
    k3: float = _spec(
        "k_3", "N/m", 60.0, (0.0, _STIFFNESS_MAX), "stiffness of the 45° coupling spring"
    )
    c1: float = _spec("c_1", "N s/m", 0.32, (0.0, 1e9), "horizontal damping")
    c2: float = _spec("c_2", "N s/m", 0.32, (0.0, 1e9), "vertical damping")
    F: float = _spec("F", "N", 80.0, (-1e9, 1e9), "preload, positive towards the belt")
    k_nl: float = _spec("k_nl", "N/m^3", 100.0, (0.0, 1e24), "cubic contact stiffness")
    mu: float = _spec("μ", "", 0.7, (0.0, 100.0), "friction coefficient")

    def __post_init__(self) -> None:
        for name, spec in PARAMETERS.items():
            object.__setattr__(self, name, spec.check(getattr(self, name)))

    def with_values(self, values: Mapping[str, object]) -> Self:
        """A copy with some values replaced, given as numbers or text by parameter name.

        Raises `InputError` if a name is unknown or a value is out of range.
        """
        merged: dict[str, float] = self.as_dict()
        for name, value in values.items():
            merged[name] = parameter_spec(name).check(value)
        return type(self)(**merged)

    def values(self) -> tuple[float, ...]:
        """Values in the order of the table."""
        return _values_of(self)

    def as_dict(self) -> dict[str, float]:
        """Values by name, in the order of the table."""
        return {name: getattr(self, name) for name in PARAMETERS}


def check_parameters(value: object) -> Parameters:
    """Return `value` if it is a `Parameters`; raise `InputError` otherwise."""
    if not isinstance(value, Parameters):
        raise InputError(
            f"parameters = {value!r}: must be a set of parameters, such as Parameters(F=80.0)"
        )
    return value


PARAMETERS: Final[Mapping[str, ParameterSpec]] = {
    f.name: ParameterSpec(name=f.name, **f.metadata) for f in fields(Parameters)
}

_values_of: Final[Callable[[Parameters], tuple[float, ...]]] = attrgetter(*PARAMETERS)


def parameter_spec(name: str) -> ParameterSpec:
    """The table row of a parameter; names are case-sensitive.

    Raises `InputError`, with the nearest name, if there is no such parameter.
    """
    if name not in PARAMETERS:
        raise unknown_name("parameter", name, PARAMETERS)
    return PARAMETERS[name]
