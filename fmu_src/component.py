"""What the builder needs to know of a component that it makes an FMU of."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from .reference import Reference
from .table import VariableTable


@dataclass(frozen=True, slots=True)
class Component:
    """A component.

    Attributes
    ----------
    model : str
        Name of the model, which is that of the slave's class.
    entry : str
        Module of ``fmu_src`` that the wrapper imports.
    modules : mapping of str to sequence of str
        Modules that the FMU carries, by package; each imports the standard library, pythonfmu and
        each other alone.
    table : VariableTable
        Its variables.
    about : str
        What is said of it in the documentation: equations, ports and limits, in HTML.
    reference : callable
        Computes a reference run.
    """

    model: str
    entry: str
    modules: Mapping[str, Sequence[str]]
    table: VariableTable
    about: str
    reference: Callable[[], Reference]
