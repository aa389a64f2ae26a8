"""The parameter table: the only source of names, symbols, units, defaults and bounds."""

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import Final, Self

from .errors import InputError
from .numbers import Interval


@dataclass(frozen=True, slots=True)
class ParameterSpec:
    """What a parameter is: everything that a form, a file format or a table needs of it.

    Attributes
    ----------
    name : str
        Name in Python, in scene files and on the command line.
    symbol : str
        Symbol as in the paper.
    unit : str
        SI unit; empty when dimensionless.
    default : float
        Value in the base set (section 2 of the paper; F, k_nl and mu of section 5.1).
    lower, upper : float
        Bounds of the allowed range.
    lower_open : bool
        Whether `lower` itself is excluded.
    meaning : str
        One phrase in the field's terms.
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
        """The allowed range in words, for forms and messages: ``from 0 to 100``."""
        return str(self._interval)

    @property
    def _interval(self) -> Interval:
        return Interval(self.lower, self.upper, self.unit, self.lower_open)

    def check(self, value: object) -> float:
        """Return `value` as a float inside the bounds.

        Parameters
        ----------
        value : object
            A number, or text that reads as one.

        Returns
        -------
        float
            The checked value, in `unit`.

        Raises
        ------
        InputError
            If `value` is not a number, not finite or out of bounds.
        """
        # Nearly every call, without the cost of an interval.
        if isinstance(value, float) and self.lower < value <= self.upper:
            return float(value)
        return self._interval.check(self.name, value)


def unknown_name(kind: str, name: str, known: Iterable[str]) -> InputError:
    """An error for a name that is not known, with the nearest one that is.

    Parameters
    ----------
    kind : str
        What the name stands for, e.g. ``"parameter"``.
    name : str
        The name given.
    known : iterable of str
        The names allowed.

    Returns
    -------
    InputError
        To be raised by the caller.
    """
    names = list(known)
    folded = {candidate.casefold(): candidate for candidate in names}
    near = difflib.get_close_matches(name.casefold(), folded, n=1, cutoff=0.5)
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
    # A dataclass field whose metadata becomes the table row: name and default are said once.
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

    Every value is checked against its `ParameterSpec`; an instance is always valid.

    Raises
    ------
    InputError
        If a value is not a finite number inside its bounds.
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
    k_nl: float = _spec("k_nl", "N/m^3", 100.0, (0.0, 1e15), "cubic contact stiffness")
    mu: float = _spec("μ", "", 0.7, (0.0, 100.0), "friction coefficient")

    def __post_init__(self) -> None:
        for name, spec in PARAMETERS.items():
            object.__setattr__(self, name, spec.check(getattr(self, name)))

    def with_values(self, values: Mapping[str, object]) -> Self:
        """A copy with some values replaced.

        Parameters
        ----------
        values : mapping of str to number or text
            New values by parameter name.

        Returns
        -------
        Self
            The checked copy.

        Raises
        ------
        InputError
            If a name is unknown or a value is not allowed.
        """
        merged: dict[str, float] = self.as_dict()
        for name, value in values.items():
            merged[name] = parameter_spec(name).check(value)
        return type(self)(**merged)

    def as_dict(self) -> dict[str, float]:
        """Values by name, in the table's order."""
        return {name: getattr(self, name) for name in PARAMETERS}


def check_parameters(value: object) -> Parameters:
    """The value itself if it is a parameter set; `InputError` if it is none."""
    if not isinstance(value, Parameters):
        raise InputError(
            f"parameters = {value!r}: must be a set of parameters, such as Parameters(F=80.0)"
        )
    return value


PARAMETERS: Final[Mapping[str, ParameterSpec]] = {
    f.name: ParameterSpec(name=f.name, **f.metadata) for f in fields(Parameters)
}


def parameter_spec(name: str) -> ParameterSpec:
    """The table row of a parameter.

    Parameters
    ----------
    name : str
        Parameter name, case-sensitive (``F``, ``k_nl``, ``mu`` …).

    Returns
    -------
    ParameterSpec
        Its row.

    Raises
    ------
    InputError
        If there is no parameter of that name; the nearest name is suggested.
    """
    if name not in PARAMETERS:
        raise unknown_name("parameter", name, PARAMETERS)
    return PARAMETERS[name]
