"""The variables of an FMU: name, type, range and meaning of each, and the table of them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

from fivtui.model.errors import InputError
from fivtui.model.numbers import parse_number
from fivtui.model.parameters import PARAMETERS


class Type(StrEnum):
    """FMI type of a variable."""

    REAL = "Real"
    INTEGER = "Integer"
    ENUMERATION = "Enumeration"
    BOOLEAN = "Boolean"


class Role(StrEnum):
    """FMI causality of a variable."""

    PARAMETER = "parameter"
    INPUT = "input"
    OUTPUT = "output"
    LOCAL = "local"


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """One variable of the FMU.

    Attributes
    ----------
    name : str
        Name in the model description.
    type : Type
        FMI type.
    role : Role
        Parameter (fixed), input, output or local.
    meaning : str
        One phrase.
    unit : str
        SI unit, "1" if dimensionless, empty if the type has no units.
    start : float or bool
        Value before any is set; of outputs, before the motion begins.
    lower, upper : float
        Bounds of the allowed range, infinite if there is none.
    allowed : str
        The allowed range in words; empty if it cannot be set.
    nominal : float or None
        Typical size.
    discrete : bool
        Whether it changes only at switches.
    depends_on : tuple of str
        Inputs it depends on directly, at a communication point.
    starts_from : tuple of str
        Parameters and inputs that its initial value depends on.
    derivative_of : str
        Name of the variable whose derivative it is; empty if none.
    varies_with : tuple of str
        States and inputs that it depends on as a derivative.
    items : tuple of str
        Names of the values 0, 1, … of an enumeration.
    """

    name: str
    type: Type
    role: Role
    meaning: str
    unit: str = ""
    start: float | bool = 0.0
    lower: float = -math.inf
    upper: float = math.inf
    allowed: str = ""
    nominal: float | None = None
    discrete: bool = False
    depends_on: tuple[str, ...] = ()
    starts_from: tuple[str, ...] = ()
    derivative_of: str = ""
    varies_with: tuple[str, ...] = ()
    items: tuple[str, ...] = ()

    @property
    def settable(self) -> bool:
        """Whether a host may set it."""
        return self.role in (Role.PARAMETER, Role.INPUT)

    @property
    def variability(self) -> str:
        """FMI variability."""
        if self.role is Role.PARAMETER:
            return "fixed"
        return "discrete" if self.discrete else "continuous"

    @property
    def initial(self) -> str | None:
        """FMI initial; inputs have none."""
        if self.role is Role.INPUT:
            return None
        return "exact" if self.role is Role.PARAMETER else "calculated"

    def check(self, value: object) -> float | bool:
        """Return a valid value as a float or bool; `InputError` if it is out of range."""
        if self.name in PARAMETERS:
            return PARAMETERS[self.name].check(value)
        if self.type is Type.BOOLEAN:
            return bool(value)
        number = parse_number(self.name, value, self.allowed)
        if not self.lower <= number <= self.upper:
            raise InputError(f"{self.name} = {number:g}: must be {self.allowed}")
        return number


class VariableTable:
    """The variables of a component; the value reference is the index in the table.

    Attributes
    ----------
    variables : tuple of Variable
        The rows.
    references : mapping of str to int
        Value references by name.
    """

    def __init__(self, variables: Sequence[Variable]) -> None:
        self.variables: tuple[Variable, ...] = tuple(variables)
        self.references: Mapping[str, int] = {v.name: i for i, v in enumerate(self.variables)}

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
