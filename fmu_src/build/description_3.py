"""Variables and structure of a model description of FMI 3.0, from the table of variables."""

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Final, NamedTuple
from xml.etree import ElementTree as ET

from fmu_src.slave import STATES, Role, Type, Variable, VariableTable

from .description import identity_of, type_of

_TAGS: Final = {
    Type.REAL: "Float64",
    Type.INTEGER: "Int32",
    Type.ENUMERATION: "Enumeration",
    Type.BOOLEAN: "Boolean",
}


class Indicator(NamedTuple):
    """An event indicator: name, unit, what it is, and what it depends on."""

    name: str
    unit: str
    meaning: str
    known: tuple[str, ...]


_HOLD: Final = ("x", "y", "mu", "v_belt", "k1", "k2", "k3", "c1", "k_nl", "mu_s")
# The switches of each model are zeros of its event indicators.
INDICATORS: Final[Mapping[str, Sequence[Indicator]]] = {
    "SliderBelt": (
        Indicator("event_indicator", "m", "y, where that is zero on the side of the mode", ("y",)),
        Indicator("event_indicator_slip", "m/s", "v_belt - vx in slip, 1 else", ("vx", "v_belt")),
        Indicator("event_indicator_forward", "N", "mu_s P - f in stick, 1 else", _HOLD),
        Indicator("event_indicator_backward", "N", "mu_s P + f in stick, 1 else", _HOLD),
    ),
    "BrakeActuator": (),
}


def add_time(variables: ET.Element, reference: int) -> None:
    """Add the independent variable; FMI 3.0."""
    ET.SubElement(
        variables,
        "Float64",
        name="time",
        valueReference=str(reference),
        causality="independent",
        variability="continuous",
        unit="s",
    )


def add_variable(
    variables: ET.Element, reference: int, variable: Variable, table: VariableTable
) -> None:
    """Add a variable of a table; FMI 3.0."""
    attributes = identity_of(variable, reference)
    if variable.variability == "continuous":
        attributes["intermediateUpdate"] = "true"
    if variable.unit:
        attributes |= {"unit": variable.unit, "displayUnit": variable.unit}
    for name, bound in (("min", variable.lower), ("max", variable.upper)):
        if math.isfinite(bound):
            attributes[name] = repr(bound) if variable.type is Type.REAL else str(int(bound))
    if variable.nominal is not None:
        attributes["nominal"] = repr(variable.nominal)
    if variable.derivative_of:
        attributes["derivative"] = str(table.references[variable.derivative_of])
    if variable.settable:
        boolean = variable.type is Type.BOOLEAN
        attributes["start"] = str(variable.start).lower() if boolean else repr(variable.start)
    if variable.items:
        attributes["declaredType"] = type_of(variable)
    ET.SubElement(variables, _TAGS[variable.type], attributes)


def model_structure_3(
    table: VariableTable, indicators: Sequence[Indicator], order: Sequence[str] = STATES
) -> ET.Element:
    """``ModelStructure`` of FMI 3.0; the references of `indicators` follow on that of the time.

    `order` is that in which states are exchanged.
    """
    structure = ET.Element("ModelStructure")
    states = {v.derivative_of for v in table.variables if v.derivative_of}

    def add(tag: str, variable: Variable, known: Sequence[str]) -> None:
        ET.SubElement(
            structure,
            tag,
            valueReference=str(table.references[variable.name]),
            dependencies=" ".join(str(table.references[name]) for name in known),
            dependenciesKind=" ".join("dependent" for _ in known),
        )

    outputs = [v for v in table.variables if v.role is Role.OUTPUT]
    for variable in outputs:
        add("Output", variable, (*known_in_exchange(variable, states), *_parameters_of(variable)))
    # Derivatives in the order in which the slave exchanges states.
    derivatives = [v for v in table.variables if v.derivative_of]
    for variable in sorted(derivatives, key=lambda v: order.index(v.derivative_of)):
        known = (*variable.varies_with, *_parameters_of(variable))
        add("ContinuousStateDerivative", variable, known)
    for variable in table.variables:
        if variable.role is Role.OUTPUT or variable.derivative_of:
            add("InitialUnknown", variable, variable.starts_from)
    for reference, indicator in enumerate(indicators, start=len(table.variables) + 1):
        known = indicator.known
        ET.SubElement(
            structure,
            "EventIndicator",
            valueReference=str(reference),
            dependencies=" ".join(str(table.references[name]) for name in known),
            dependenciesKind=" ".join("dependent" for _ in known),
        )
    return structure


def known_in_exchange(output: Variable, states: Collection[str]) -> tuple[str, ...]:
    """States and inputs that an output depends on where the importer knows the states, too."""
    own = (output.name,) if output.name in states else _FROM_STATES.get(output.name, ())
    return (*own, *output.depends_on)


def _parameters_of(variable: Variable) -> tuple[str, ...]:
    """Parameters that an output or derivative depends on directly: known in FMI 3.0 alone."""
    return _FROM_PARAMETERS.get(variable.name, ())


_FROM_STATES: Final = {
    "P": ("y",),
    "friction_slider": ("x", "vx", "y"),
    "friction_belt": ("x", "vx", "y"),
    "switching": ("y",),
}
_FROM_PARAMETERS: Final = {
    "P": ("k2", "k_nl"),
    "friction_slider": ("k1", "k2", "k3", "c1", "k_nl", "mu_s", "v_s"),
    "friction_belt": ("k1", "k2", "k3", "c1", "k_nl", "mu_s", "v_s"),
    "ax": ("m", "k1", "k2", "k3", "c1", "k_nl", "mu_s", "v_s"),
    "ay": ("m", "k2", "k3", "c2", "k_nl"),
    "F_rate": ("tau", "gain"),
}
