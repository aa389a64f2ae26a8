"""Variables of an FMU as FMI describes them: name, type, causality, range and dependencies."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from enum import StrEnum
from typing import Final

from fivtui.model.errors import InputError
from fivtui.model.numbers import Interval, parse_number

DIMENSIONLESS: Final = "1"


class Type(StrEnum):
    """FMI type of a variable."""

    REAL = "Real"
    INTEGER = "Integer"
    ENUMERATION = "Enumeration"
    BOOLEAN = "Boolean"


class Role(StrEnum):
    """FMI causality of a variable: what a host may do with it."""

    PARAMETER = "parameter"
    INPUT = "input"
    OUTPUT = "output"
    LOCAL = "local"


@dataclass(frozen=True, slots=True)
class Variable:
    """One variable of the FMU."""

    name: str
    role: Role
    meaning: str
    # SI unit; "1" if dimensionless, empty if the type has no units.
    unit: str = ""
    _: KW_ONLY
    type: Type = Type.REAL
    # Value before a host sets another; for outputs, before the motion begins.
    start: float | bool = 0.0
    lower: float = -math.inf
    upper: float = math.inf
    # Whether a parameter may change between communication steps, and at events.
    tunable: bool = False
    # Typical size.
    nominal: float | None = None
    # Whether it changes only where the mode changes.
    discrete: bool = False
    # Whether it summarises the motion so far, such as a peak; computed only when a host reads it.
    total: bool = False
    # Inputs that an output depends on at the same time.
    depends_on: Sequence[str] = ()
    # Parameters and inputs that the initial value depends on.
    start_depends_on: Sequence[str] = ()
    # Name of the state that this variable is the derivative of; empty if none.
    derivative_of: str = ""
    # States and inputs that the derivative of a state depends on.
    rate_depends_on: Sequence[str] = ()
    # Names of the values 0, 1, … of an enumeration.
    value_names: Sequence[str] = ()

    @property
    def _interval(self) -> Interval | None:
        # None if every finite number is allowed.
        unit = "" if self.unit == DIMENSIONLESS else self.unit
        return Interval(self.lower, self.upper, unit) if self.lower > -math.inf else None

    @property
    def range_text(self) -> str:
        """The allowed range as a phrase; empty if the variable cannot be set."""
        if not self.settable:
            return ""
        if self.type is Type.BOOLEAN:
            return "true or false"
        return str(self._interval or f"a finite number of {self.unit}")

    @property
    def settable(self) -> bool:
        """Whether a host may set the variable."""
        return self.role in (Role.PARAMETER, Role.INPUT)

    @property
    def variability(self) -> str:
        """FMI variability."""
        if self.role is Role.PARAMETER:
            return "tunable" if self.tunable else "fixed"
        return "discrete" if self.discrete else "continuous"

    @property
    def initial(self) -> str | None:
        """FMI initial; inputs have none."""
        if self.role is Role.INPUT:
            return None
        return "exact" if self.role is Role.PARAMETER else "calculated"

    def check(self, value: object) -> float | bool:
        """Return a valid value as a float or bool; `InputError` if it is out of range."""
        # Fast path: most values are floats in the range.
        if isinstance(value, float) and self.lower <= value <= self.upper and math.isfinite(value):
            return value
        if self.type is Type.BOOLEAN:
            return bool(value)
        if self._interval is None:
            return parse_number(self.name, value, self.range_text)
        return self._interval.check(self.name, value)


class VariableTable:
    """The variables of a component; the value reference is the index in the table."""

    def __init__(self, variables: Sequence[Variable]) -> None:
        self.variables: tuple[Variable, ...] = tuple(variables)
        self.references: Mapping[str, int] = {
            variable.name: index for index, variable in enumerate(self.variables)
        }

    def check_settable(self, reference: int, kind: Type, value: object) -> float | bool:
        """Check a value that a host sets by an FMI call of type `kind`.

        Raises `InputError` if there is no such variable, it is of another type or cannot be set, or
        the value is out of range.
        """
        if not 0 <= reference < len(self.variables):
            raise InputError(
                f"value reference {reference}: must be from 0 to {len(self.variables) - 1}"
            )
        variable = self.variables[reference]
        if not variable.settable:
            raise InputError(f"{variable.name} is an output and cannot be set")
        if variable.type is not kind:
            raise InputError(f"{variable.name} is of type {variable.type}, not {kind}")
        return variable.check(value)
