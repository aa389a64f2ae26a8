"""Model description of a native FMU for FMI 3.0, and build description of its C files."""

from collections.abc import Collection, Mapping, Sequence
from typing import Final, NamedTuple
from xml.etree import ElementTree as ET

from fmu_src.slave import Role, Type, Variable, VariableTable

from .c_sources import OUTPUT_DERIVATIVE_ORDER, model_guid, sources
from .component import Component
from .description import (
    about_attributes,
    common_attributes,
    new_description,
    type_definitions,
    type_name,
    value_attributes,
    xml_bytes,
)

# XML elements of variables, by type.
_TAGS: Final = {
    Type.REAL: "Float64",
    Type.INTEGER: "Int32",
    Type.ENUMERATION: "Enumeration",
    Type.BOOLEAN: "Boolean",
}


class Indicator(NamedTuple):
    """An event indicator: name, unit, meaning and dependencies."""

    name: str
    unit: str
    meaning: str
    depends_on: tuple[str, ...]


# What the limits of stick depend on: the force f that holds a sticking slider on the belt stays
# between -mu_s P and mu_s P.
_STICK_DEPENDENCIES: Final = ("x", "y", "mu", "v_belt", "k1", "k2", "k3", "c1", "k_nl", "mu_s")
# Event indicators by model: their zeros are its switches.
INDICATORS: Final[Mapping[str, Sequence[Indicator]]] = {
    "SliderBelt": (
        Indicator(
            "event_indicator",
            "m",
            "y, which changes its sign at separation and reattachment",
            ("y",),
        ),
        Indicator(
            "event_indicator_slip", "m/s", "v_belt - vx in slip, otherwise 1", ("vx", "v_belt")
        ),
        Indicator(
            "event_indicator_forward", "N", "mu_s P - f in stick, otherwise 1", _STICK_DEPENDENCIES
        ),
        Indicator(
            "event_indicator_backward",
            "N",
            "mu_s P + f in stick, otherwise 1",
            _STICK_DEPENDENCIES,
        ),
    ),
    "BrakeActuator": (),
}


_CAPABILITIES: Final = {
    "needsExecutionTool": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canGetAndSetFMUState": "true",
    "canSerializeFMUState": "true",
    "providesDirectionalDerivatives": "true",
    "providesAdjointDerivatives": "true",
}
_INTERFACES: Final[Mapping[str, Mapping[str, str]]] = {
    "ModelExchange": {**_CAPABILITIES, "needsCompletedIntegratorStep": "true"},
    "CoSimulation": {
        **_CAPABILITIES,
        "canHandleVariableCommunicationStepSize": "true",
        "maxOutputDerivativeOrder": str(OUTPUT_DERIVATIVE_ORDER),
        "hasEventMode": "true",
        "mightReturnEarlyFromDoStep": "true",
        "providesIntermediateUpdate": "true",
        "canReturnEarlyAfterIntermediateUpdate": "true",
    },
}


def native_description_3(component: Component, categories: Mapping[str, str]) -> bytes:
    """The model description: co-simulation with event mode, and model exchange.

    `categories` are log categories with their descriptions.
    """
    table, indicators = component.variable_table, INDICATORS[component.model]
    root_attributes = {
        "fmiVersion": "3.0",
        "modelName": component.model,
        "instantiationToken": model_guid(component.model),
        "description": component.description,
        **about_attributes(),
    }
    types = type_definitions(
        table, lambda group, name: ET.SubElement(group, "EnumerationType", name=name)
    )
    root = new_description(root_attributes, _INTERFACES, table, types, categories)
    variables = ET.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(table.variables):
        ET.SubElement(variables, _TAGS[variable.type], _attributes(variable, reference, table))
    count = len(table.variables)
    time = {"name": "time", "valueReference": str(count), "causality": "independent"}
    ET.SubElement(variables, "Float64", time, variability="continuous", unit="s")
    for reference, indicator in enumerate(indicators, start=count + 1):
        ET.SubElement(
            variables,
            "Float64",
            name=indicator.name,
            valueReference=str(reference),
            description=f"event indicator: {indicator.meaning}",
            causality="local",
            variability="continuous",
            initial="calculated",
            unit=indicator.unit,
        )
    root.append(_model_structure(table, indicators))
    return xml_bytes(root)


def _attributes(variable: Variable, reference: int, table: VariableTable) -> dict[str, str]:
    attributes = common_attributes(variable, reference)
    if variable.variability == "continuous":
        attributes["intermediateUpdate"] = "true"
    derivative_of = variable.derivative_of and str(table.references[variable.derivative_of])
    attributes |= value_attributes(variable, derivative_of)
    if variable.value_names:
        attributes["declaredType"] = type_name(variable)
    return attributes


def _model_structure(table: VariableTable, indicators: Sequence[Indicator]) -> ET.Element:
    # The value reference of the time follows those of the table, then come the event indicators.
    structure = ET.Element("ModelStructure")
    states = {v.derivative_of for v in table.variables if v.derivative_of}

    def add(tag: str, reference: int, names: Sequence[str]) -> None:
        ET.SubElement(
            structure,
            tag,
            valueReference=str(reference),
            dependencies=" ".join(str(table.references[name]) for name in names),
            dependenciesKind=" ".join("dependent" for _ in names),
        )

    for reference, variable in enumerate(table.variables):
        if variable.role is Role.OUTPUT:
            names = (*dependencies_in_exchange(variable, states), *_direct_parameters(variable))
            add("Output", reference, names)
    for reference, variable in enumerate(table.variables):
        if variable.derivative_of:
            names = (*variable.rate_depends_on, *_direct_parameters(variable))
            add("ContinuousStateDerivative", reference, names)
    for reference, variable in enumerate(table.variables):
        if variable.role is Role.OUTPUT or variable.derivative_of:
            add("InitialUnknown", reference, variable.start_depends_on)
    for reference, indicator in enumerate(indicators, start=len(table.variables) + 1):
        add("EventIndicator", reference, indicator.depends_on)
    return structure


def dependencies_in_exchange(output: Variable, states: Collection[str]) -> tuple[str, ...]:
    """States and inputs that an output depends on in model exchange.

    `Variable.depends_on` has the inputs only, as for co-simulation, where states are not visible.
    """
    used_states = (output.name,) if output.name in states else _FROM_STATES.get(output.name, ())
    return (*used_states, *output.depends_on)


def _direct_parameters(variable: Variable) -> tuple[str, ...]:
    """Parameters that an output or derivative depends on directly, which only FMI 3.0 lists."""
    return _FROM_PARAMETERS.get(variable.name, ())


# States on which outputs depend, and parameters on which outputs and state derivatives depend. The
# friction forces are that of the belt on the slider and its reaction on the belt. `switching` is
# the switching function y: its sign changes at separation and reattachment.
_FROM_STATES: Final = {
    "P": ("y",),
    "friction_slider": ("x", "vx", "y"),
    "friction_belt": ("x", "vx", "y"),
    "switching": ("y",),
    "x_peak": ("x",),
    "y_peak": ("y",),
    "vx_max": ("vx",),
    "P_min": ("y",),
    "P_max": ("y",),
}
_FROM_PARAMETERS: Final = {
    **dict.fromkeys(("P", "P_min", "P_max"), ("k2", "k_nl")),
    "friction_slider": ("k1", "k2", "k3", "c1", "k_nl", "mu_s", "v_s"),
    "friction_belt": ("k1", "k2", "k3", "c1", "k_nl", "mu_s", "v_s"),
    "ax": ("m", "k1", "k2", "k3", "c1", "k_nl", "mu_s", "v_s"),
    "ay": ("m", "k2", "k3", "c2", "k_nl"),
    "F_rate": ("tau", "gain"),
}


def build_description(component: Component) -> bytes:
    """The build description: the C files to compile."""
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    build = ET.SubElement(root, "BuildConfiguration", modelIdentifier=component.model)
    files = ET.SubElement(build, "SourceFileSet", language="C11")
    for name in sources(component.model):
        if name.endswith(".c"):
            ET.SubElement(files, "SourceFile", name=name)
    return xml_bytes(root)
