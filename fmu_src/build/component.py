"""A component: all that the builder needs to make an FMU of it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from fmu_src.slave import VariableTable

from .reference import Reference

_PYTHON: Final = """\
<p>The FMU needs Python 3.11 or newer in the process that loads it. On Linux a process never unloads
the wrapper's library: for thousands of runs in one process extract the FMU once and load it from
that folder.</p>
"""
_FOLDER: Final = """\
<p>The path to which it is extracted may hold ASCII letters, digits, _ . - ~ and spaces; any other
character crashes the wrapper.</p>
"""
_RULES: Final = f"""\
<h2>Rules</h2>
<p>Inputs are held from one communication point to the next (input derivatives cannot be given).
Results do not depend on the communication step.</p>
<p>What is refused (a value out of its range, a fixed parameter while stepping, a wrong time) is
logged, also on standard error, and changes nothing; the next step then returns fmi2Discard. Outputs
are NaN where the initialization was refused. A tolerance out of range is replaced by the nearest
possible one, with a warning.</p>
{_PYTHON}{_FOLDER}"""
EXCHANGE_RULES: Final = f"""\
<h2>Rules</h2>
<p>The importer integrates, and finds separation and reattachment as zeros of the event indicator
y. Inputs may vary continuously.</p>
<p>What is refused (a value out of its range, a fixed parameter in continuous time) is logged,
also on standard error, and changes nothing; the next update of the discrete states then asks to end
the simulation. FMU states cannot be saved.</p>
{_PYTHON}"""


@dataclass(frozen=True, slots=True)
class Component:
    """A component that FMUs can be built of.

    Attributes
    ----------
    model : str
        Name of the model in the FMU.
    entry : str
        Module of ``fmu_src.slave`` that the wrapper imports.
    modules : mapping of str to sequence of str
        Modules that the FMU carries, by package; they import the standard library, pythonfmu and
        each other alone.
    table : VariableTable
        Its variables.
    about, rules : str
        Documentation of the model and of its calls, in HTML.
    reference : callable
        Computes a reference run.
    wrapper : str
        The package that exports the FMU.
    """

    model: str
    entry: str
    modules: Mapping[str, Sequence[str]]
    table: VariableTable
    about: str
    reference: Callable[[], Reference]
    rules: str = _RULES
    wrapper: str = "pythonfmu"
