"""The variables of a component as a table: what it serves and its model description says."""

from collections.abc import Mapping, Sequence

from fivtui.model.errors import InputError

from .variable import Type, Variable


class VariableTable:
    """Variables by value reference, which is the place in the table.

    Parameters
    ----------
    variables : sequence of Variable
        The rows.

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
        """Check a value that is to be set from outside.

        Parameters
        ----------
        reference : int
            Value reference.
        kind : Type
            Type of the FMI call.
        value : object
            The value given.

        Returns
        -------
        float or bool
            The checked value.

        Raises
        ------
        InputError
            If there is no such variable, it is not of that type or not to be set, or the value is
            not allowed.
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
