"""The system under study: parameters, contact and tables over time."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Self

from .errors import InputError
from .over_time import TimeTable
from .parameters import Parameters, check_parameters


@dataclass(frozen=True, slots=True)
class System:
    """A slider on a belt.

    Attributes
    ----------
    parameters : Parameters
        The parameter set.
    separation : bool
        Whether separation is considered.
    over_time : mapping of str to TimeTable
        Tables of the parameters that change with time.
    """

    parameters: Parameters
    separation: bool = True
    over_time: Mapping[str, TimeTable] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "separation", check_separation(self.separation))

    def with_values(self, values: Mapping[str, object]) -> Self:
        """A copy with other values of some parameters, see `Parameters.with_values`."""
        return type(self)(self.parameters.with_values(values), self.separation, self.over_time)


def check_separation(value: object) -> bool:
    """Return `value` as a bool; raise `InputError` unless it is one of Python or NumPy."""
    if type(value).__name__ not in ("bool", "bool_"):
        raise InputError(f"separation = {value!r}: must be True or False")
    return bool(value)


def system_of(parameters: Parameters | None, separation: bool) -> System:
    """The system of a parameter set, or of the base set if None; checks the type of the set."""
    return System(Parameters() if parameters is None else check_parameters(parameters), separation)
