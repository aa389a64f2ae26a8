"""A component: a model that FMUs are built of, with documentation and a reference run as files."""

import html
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

from fmu_src.slave import Role, VariableTable

from .description import license_text, project_license

_PYTHON_RULES: Final = """\
<h2>Rules</h2>
<p>Inputs are held from one communication point to the next (input derivatives cannot be given).
Results do not depend on the communication step.</p>
<p>A refused call (a value out of its range, a fixed parameter set while stepping, a wrong time)
changes nothing. The reason is logged and printed to standard error, and the next step returns
fmi2Discard. If the initialization is refused, outputs are NaN. A tolerance out of range is replaced
by the nearest valid one, with a warning.</p>
<p>The FMU needs Python 3.11 or newer in the process that loads it. The path to which it is
extracted may contain only ASCII letters, digits, _ . - ~ and spaces; any other character crashes
the wrapper.</p>
"""
_NATIVE_RULES: Final = """\
<h2>Rules</h2>
<p>Co-simulation: inputs are held from one communication point to the next, or change
over the next step with the given first derivatives; after that step they keep their final values.
Results do not depend on the communication step. Continuous outputs have derivatives by time, up to
the third, of the motion that follows if inputs are held, or change with the derivatives set for the
next step. At an event or a jump of an input they
are those after it.</p>
<p>Model exchange: the importer integrates, and finds switches as zeros of the event
indicators. The first is y. A belt of finite speed adds v_belt - vx in slip, and in stick mu_s P - f
and mu_s P + f, where P is the contact force and f the friction that holds the slider. An indicator
that does not apply to the mode is 1. At every switch the states are reported as changed. Outputs
"so far", such as x_peak, include the states at completed integrator steps. While the
slider sticks, f depends on the rate of v_belt. The FMU does not know this rate; therefore v_belt
can then be set only in event mode. Directional derivatives are exact at constant mode.</p>
<p>A refused call returns fmi2Discard (an invalid value or step) or fmi2Error (a call that is not
allowed), is logged, and changes nothing. A tolerance out of range is replaced by the nearest valid
one, with fmi2Warning.</p>
<p>The FMU needs only the C library.</p>
"""
# Titles of the tables of variables in the documentation.
_TITLES: Final = {
    Role.PARAMETER: "Parameters; tunable ones may change between communication steps",
    Role.INPUT: "Inputs, held from one communication point to the next",
    Role.OUTPUT: "Outputs",
    Role.LOCAL: "Local variables",
}
# Folder of an FMU for files that FMI does not define.
_EXTRA_FOLDER: Final = "extra"


class Terminal(NamedTuple):
    """Variables that tools connect as one to a terminal of another FMU."""

    meaning: str
    # Names of the variables by member name; members of equal names are connected.
    members: Mapping[str, str]


class Reference(NamedTuple):
    """A reference run: inputs and outputs by name, each with a column ``time``, s.

    Importers repeat it to test themselves. Two equal times in the inputs are a jump; outputs are
    given at all communication points.
    """

    stop_time: float
    # Communication step, s, and relative tolerance.
    step: float
    tol: float
    inputs: Mapping[str, Sequence[float]]
    outputs: Mapping[str, Sequence[float]]


@dataclass(frozen=True, slots=True)
class Component:
    """A component that FMUs can be built of."""

    # Name of the model in the FMU.
    model: str
    # Module of ``fmu_src.slave`` that pythonfmu's wrapper imports.
    entry: str
    # Modules that the FMU contains, by package; they import only the standard library, pythonfmu
    # and each other.
    modules: Mapping[str, Sequence[str]]
    variable_table: VariableTable
    # Terminals by name.
    terminals: Mapping[str, Terminal]
    # One sentence on the model.
    description: str
    # Documentation of the model, as paragraphs of HTML.
    about_html: str
    # Computes a reference run.
    reference_run: Callable[[], Reference]


def documentation_files(component: Component, *, is_native: bool) -> dict[str, bytes]:
    """The files below ``documentation/``: content by name in the FMU."""
    rules = _NATIVE_RULES if is_native else _PYTHON_RULES
    texts = {
        "index.html": _index_page(component, rules),
        "licenses/license.txt": project_license(),
    }
    if not is_native:
        texts["licenses/pythonfmu.txt"] = license_text("pythonfmu")
    return {f"documentation/{name}": text.encode() for name, text in texts.items()}


def _index_page(component: Component, rules: str) -> str:
    parts = [
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">',
        f"<title>{component.model}</title></head><body>\n<h1>{component.model}</h1>\n",
        f'<p><img src="diagram.svg" alt="{html.escape(component.description)}"></p>\n',
        component.about_html,
        _states_html(component.variable_table),
        rules,
    ]
    for role, title in _TITLES.items():
        rows = "".join(
            f"<tr><td>{v.name}</td><td>{v.variability}</td><td>{v.unit}</td>"
            f"<td>{html.escape(v.meaning)}</td>"
            f"<td>{html.escape(v.range_text)}</td></tr>\n"
            for v in component.variable_table.variables
            if v.role is role
        )
        parts.append(f"<h2>{title}</h2>\n<table>\n{rows}</table>\n" if rows else "")
    return "".join(parts) + "</body></html>\n"


def _states_html(table: VariableTable) -> str:
    states = ", ".join(v.derivative_of for v in table.variables if v.derivative_of)
    return f"<p>Continuous states, in this order: {states}.</p>\n"


def reference_files(model: str, reference: Reference) -> dict[str, bytes]:
    """A reference run as ``_in.csv``, ``_ref.csv`` and ``_ref.opt``: content by name in the FMU."""
    options = {
        "StartTime": 0.0,
        "StopTime": reference.stop_time,
        "StepSize": reference.step,
        "RelTol": reference.tol,
    }
    texts = {
        "in.csv": _csv_text(reference.inputs),
        "ref.csv": _csv_text(reference.outputs),
        "ref.opt": "".join(f"{name}, {value!r}\n" for name, value in options.items()),
    }
    return {f"{_EXTRA_FOLDER}/{model}_{name}": text.encode() for name, text in texts.items()}


def _csv_text(columns: Mapping[str, Sequence[float]]) -> str:
    # Ten digits: further digits depend on the platform's mathematical library.
    lines = [",".join(f'"{name}"' for name in columns)]
    lines += [
        ",".join(f"{value:.10g}" for value in row) for row in zip(*columns.values(), strict=True)
    ]
    return "\n".join(lines) + "\n"
