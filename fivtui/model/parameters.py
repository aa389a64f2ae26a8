"""The parameter table: names, symbols, units, defaults and bounds, defined once.

The paper is "Nonlinear friction-induced vibration of a slider-belt system".
"""

import difflib
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, fields
from operator import attrgetter
from typing import Any, Final, Self

from .columns import Column
from .errors import InputError
from .field import DERIVATIVE_STEP
from .numbers import Interval

_STIFFNESS_MAX: Final = 1e12
# Smaller values are set to zero: the square of 1e-200, for example, would underflow.
_MIN_SIZE: Final = 1e-12


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
        Value in the base set (section 2 of the paper; F, k_nl and mu from section 5.1). An optional
        parameter is none in the base set; its default is the first value that an editor offers.
    lower, upper : float
        Bounds of the allowed range.
    meaning : str
        Meaning of the parameter in one phrase.
    optional : bool
        Whether it may be none.
    """

    name: str
    symbol: str
    unit: str
    default: float
    lower: float
    upper: float
    meaning: str
    optional: bool = False

    @property
    def allowed(self) -> str:
        """Description of the allowed range."""
        return str(self._interval)

    @property
    def column(self) -> Column:
        """The column of its values in a table."""
        return Column(self.name, self.unit, self.meaning)

    @property
    def _interval(self) -> Interval:
        return Interval(self.lower, self.upper, self.unit, optional=self.optional)

    @property
    def _number_interval(self) -> Interval:
        return Interval(self.lower, self.upper, self.unit)

    def check(self, value: object) -> float:
        """Return `value`, a number or its text, as a float in `unit`.

        Raises `InputError` if it is not a finite number within the bounds.
        """
        # Fast path for floats within the bounds.
        if isinstance(value, float) and self.lower <= value <= self.upper:
            return float(value)
        return self._number_interval.check(self.name, value)

    def read(self, value: object) -> float | None:
        """As `check`, but None or the text ``none`` gives None where the parameter is optional."""
        if self.optional and (value is None or (isinstance(value, str) and value == NONE_TEXT)):
            return None
        return self._interval.check(self.name, value) if self.optional else self.check(value)


# Text for an optional parameter that is not set.
NONE_TEXT: Final = "none"
# Minimum similarity of a suggested name to the unknown one.
_MIN_SIMILARITY: Final = 0.6


def unknown_name_error(kind: str, name: str, allowed: Iterable[str]) -> InputError:
    """The error for an unknown name; it suggests the nearest known one."""
    names = list(allowed)
    # A single letter would match every short name that contains it.
    candidates = {
        candidate.casefold(): candidate
        for candidate in names
        if len(candidate) > 1 or candidate.casefold() == name.casefold()
    }
    matches = difflib.get_close_matches(name.casefold(), candidates, n=1, cutoff=_MIN_SIMILARITY)
    hint = f"; did you mean {candidates[matches[0]]}?" if matches else ""
    return InputError(f"unknown {kind} {name!r}{hint} (known: {', '.join(names)})")


def check_known(kind: str, name: str, allowed: Collection[str]) -> None:
    """Raise `InputError` unless a name is one of those allowed."""
    if name not in allowed:
        raise unknown_name_error(kind, name, allowed)


def _spec(
    symbol: str, unit: str, default: float, bounds: tuple[float, float], meaning: str
) -> float:
    # A dataclass field; its metadata become a `ParameterSpec`.
    row = {"symbol": symbol, "unit": unit, "default": default, "meaning": meaning}
    entry: float = field(default=default, metadata=row | {"lower": bounds[0], "upper": bounds[1]})
    return entry


def _optional_spec(
    symbol: str, unit: str, first_value: float, bounds: tuple[float, float], meaning: str
) -> float | None:
    # A field of an optional parameter, None by default; editors first offer `first_value`.
    required: Any = _spec(symbol, unit, first_value, bounds, meaning)
    entry: float | None = field(default=None, metadata={**required.metadata, "optional": True})
    return entry


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters:
    """The parameters of the slider-belt model in SI units: nine of the paper, three of the belt.

    Every value is checked against its `ParameterSpec`, so an instance is always valid. A value
    below 1e-12 in size is set to zero if zero is allowed. Without `v_belt` the belt is always
    faster than the slider, and `mu_s` and `v_s` have no effect.

    Raises
    ------
    InputError
        If a value is not a finite number within its bounds, or `mu_s` is below `mu`.
    """

    m: float = _spec("m", "kg", 5.0, (_MIN_SIZE, 1e9), "mass of the slider")
    k1: float = _spec("k_1", "N/m", 100.0, (_MIN_SIZE, _STIFFNESS_MAX), "horizontal stiffness")
    k2: float = _spec("k_2", "N/m", 50.0, (_MIN_SIZE, _STIFFNESS_MAX), "linear contact stiffness")
    k3: float = _spec(
        "k_3", "N/m", 60.0, (0.0, _STIFFNESS_MAX), "stiffness of the 45° coupling spring"
    )
    c1: float = _spec("c_1", "N s/m", 0.32, (0.0, 1e9), "horizontal damping")
    c2: float = _spec("c_2", "N s/m", 0.32, (0.0, 1e9), "vertical damping")
    F: float = _spec("F", "N", 80.0, (-1e9, 1e9), "preload, positive towards the belt")
    k_nl: float = _spec("k_nl", "N/m^3", 100.0, (0.0, 1e24), "cubic contact stiffness")
    mu: float = _spec("μ", "", 0.7, (0.0, 100.0), "friction coefficient")
    v_belt: float | None = _optional_spec(
        "v_belt",
        "m/s",
        1.0,
        (-1e9, 1e9),
        "speed of the belt, negative if it runs backward; none: always faster than the slider",
    )
    mu_s: float | None = _optional_spec(
        "μ_s", "", 0.9, (0.0, 100.0), "static friction coefficient, at least μ; none: μ"
    )
    v_s: float | None = _optional_spec(
        "v_s",
        "m/s",
        0.4,
        (_MIN_SIZE, 1e9),
        "sliding speed over which friction falls from μ_s to μ; none: at once",
    )

    def __post_init__(self) -> None:
        for name, spec in PARAMETERS.items():
            value = spec.check(getattr(self, name))
            object.__setattr__(self, name, value if abs(value) >= _MIN_SIZE else 0.0)
        for name, spec in BELT_PARAMETERS.items():
            if getattr(self, name) is not None:
                value = spec.check(getattr(self, name))
                object.__setattr__(self, name, value if abs(value) >= _MIN_SIZE else 0.0)
        if self.mu_s is not None and self.mu_s < self.mu:
            raise InputError(f"mu_s = {self.mu_s:g}: must be none, or at least mu = {self.mu:g}")

    @property
    def mu_static(self) -> float:
        """Static friction coefficient: `mu_s`, or `mu` if that is None."""
        return self.mu if self.mu_s is None else self.mu_s

    @property
    def speed_law(self) -> float | None:
        """`v_s` where friction depends on the sliding speed; None where it is constant."""
        return self.v_s if self.mu_static != self.mu else None

    def with_values(self, values: Mapping[str, object]) -> Self:
        """A copy with some values replaced, given as numbers or text by parameter name.

        Raises `InputError` if a name is unknown or a value is out of range.
        """
        values_by_name: dict[str, Any] = {**self.as_dict()}
        for name, value in values.items():
            values_by_name[name] = parameter_spec(name).read(value)
        return type(self)(**values_by_name)

    def with_inputs(self, values: Mapping[str, float]) -> Self:
        """A copy with values at an instant, which are not checked: tables are."""
        sizes = {name: value if abs(value) >= _MIN_SIZE else 0.0 for name, value in values.items()}
        return self.replaced(**sizes)

    def perturbed(self, changes: Mapping[str, float]) -> Self:
        """A copy, not checked, whose imaginary parts are `changes` times `DERIVATIVE_STEP`.

        For derivatives by a complex step, see `fivtui.model.field.derivative`.
        """
        return self.replaced(
            **{
                name: complex(value, changes.get(name, 0.0) * DERIVATIVE_STEP)
                for name, value in self.as_dict().items()
            }
        )

    def linearised(self, **values: float) -> Self:
        """A copy with a linear contact spring and other values, which are not checked."""
        return self.replaced(k_nl=0.0, **values)

    def replaced(self, **values: Any) -> Self:
        """A copy with other values, of any type of number, which are not checked."""
        copy = object.__new__(type(self))
        for name in ALL_PARAMETERS:
            object.__setattr__(copy, name, values.get(name, getattr(self, name)))
        return copy

    def values(self) -> tuple[float, ...]:
        """Values of the nine parameters of the paper, in the order of the table."""
        return _get_values(self)

    def as_dict(self) -> dict[str, float]:
        """Values by name, in the order of the table, without parameters that are None."""
        values = {name: getattr(self, name) for name in ALL_PARAMETERS}
        return {name: value for name, value in values.items() if value is not None}


def check_parameters(value: object) -> Parameters:
    """Return `value` if it is a `Parameters`; raise `InputError` otherwise."""
    if isinstance(value, Parameters):
        return value
    hint = ""
    if isinstance(value, str):
        hint = (
            f"; a preset or a scene file is find_scene({value!r}), with parameters, separation, "
            "start and t_end"
        )
    elif isinstance(getattr(value, "parameters", None), Parameters):
        hint = "; a scene has parameters, separation, start and t_end"
    raise InputError(
        f"parameters = {value!r}: must be a set of parameters, such as Parameters(F=80.0){hint}"
    )


def check_names(argument: str, names: Iterable[str]) -> tuple[str, ...]:
    """Names as a tuple; raises `InputError` if they are a text rather than a list."""
    if isinstance(names, str):
        raise InputError(f"{argument} = {names!r}: must be a list of names, such as [{names!r}]")
    return tuple(names)


def check_always_sliding(p: Parameters, subject: str, varied: Collection[str] = ()) -> None:
    """Raise `InputError` if the belt has a finite speed, which `subject` does not support.

    `varied` are the names of parameters that vary.
    """
    if p.v_belt is not None or "v_belt" in varied:
        speed = "v_belt" if p.v_belt is None else f"v_belt = {p.v_belt:g}"
        raise InputError(f"{speed}: must be none for {subject}")


def unused_parameters(p: Parameters, varied: Collection[str] = ()) -> dict[str, str]:
    """Which of `mu_s` and `v_s` are set but have no effect, each with what it requires.

    `varied` are the names of parameters that vary.
    """
    names = [name for name in ("mu_s", "v_s") if getattr(p, name) is not None or name in varied]
    if p.v_belt is None and "v_belt" not in varied:
        return dict.fromkeys(names, "v_belt")
    friction_falls = p.mu_static > p.mu or bool({"mu", "mu_s"} & {*varied})
    return {"v_s": "mu_s greater than mu"} if "v_s" in names and not friction_falls else {}


def describe_unused(p: Parameters, varied: Collection[str] = ()) -> str:
    """A phrase on parameters that have no effect; empty if there are none."""
    unused = unused_parameters(p, varied)
    if not unused:
        return ""
    verb = "has" if len(unused) == 1 else "have"
    return f"{' and '.join(unused)} {verb} no effect without {next(iter(unused.values()))}"


def check_varied_are_used(p: Parameters, varied: Collection[str]) -> None:
    """Raise `InputError` if a varied parameter has no effect."""
    if {*unused_parameters(p, varied)} & {*varied}:
        raise InputError(f"{describe_unused(p, varied)}, which must be given")


_SPECS: Final = [ParameterSpec(name=f.name, **f.metadata) for f in fields(Parameters)]
# The nine parameters of the paper, always numbers, and those of a finite belt, which may be none.
PARAMETERS: Final[Mapping[str, ParameterSpec]] = {s.name: s for s in _SPECS if not s.optional}
BELT_PARAMETERS: Final[Mapping[str, ParameterSpec]] = {s.name: s for s in _SPECS if s.optional}
ALL_PARAMETERS: Final[Mapping[str, ParameterSpec]] = {**PARAMETERS, **BELT_PARAMETERS}


def number_spec(name: str) -> ParameterSpec:
    """The table row of a parameter that is always a number, so not one of the belt.

    Raises `InputError`, with the nearest name, if there is no such parameter.
    """
    spec = parameter_spec(name)
    if spec.optional:
        raise unknown_name_error("parameter", name, PARAMETERS)
    return spec


_get_values: Final[Callable[[Parameters], tuple[float, ...]]] = attrgetter(*PARAMETERS)


def parameter_spec(name: str) -> ParameterSpec:
    """The table row of a parameter; names are case-sensitive.

    Raises `InputError`, with the nearest name, if there is no such parameter.
    """
    check_known("parameter", name, ALL_PARAMETERS)
    return ALL_PARAMETERS[name]
