"""The model description of a native FMU for FMI 3.0, and the description of how it is built."""

from collections.abc import Mapping
from typing import Final
from xml.etree import ElementTree as ET

from .component import Component
from .description import (
    TIMESTAMP,
    add_log_and_experiment,
    as_text,
    type_of,
    unit_definitions,
)
from .description_3 import INDICATORS, add_time, add_variable, model_structure_3
from .native_text import guid_of, sources

_SHARED: Final = {
    "needsExecutionTool": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canGetAndSetFMUState": "true",
    "canSerializeFMUState": "true",
    "providesDirectionalDerivatives": "true",
    "providesAdjointDerivatives": "true",
}
_INTERFACES: Final[Mapping[str, Mapping[str, str]]] = {
    "ModelExchange": {
        "needsCompletedIntegratorStep": "false",
    },
    "CoSimulation": {
        "canHandleVariableCommunicationStepSize": "true",
        "hasEventMode": "true",
        "mightReturnEarlyFromDoStep": "true",
        "providesIntermediateUpdate": "true",
        "canReturnEarlyAfterIntermediateUpdate": "true",
    },
}


def native_description_3(component: Component, categories: Mapping[str, str]) -> bytes:
    """The model description: co-simulation with event mode, and model exchange.

    `categories` are those of messages, with what they are.
    """
    table = component.table
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=component.model,
        instantiationToken=guid_of(component.model),
        description=component.description,
        author="The fivtui developers",
        license="MIT",
        generationTool="fivtui",
        generationDateAndTime=TIMESTAMP,
        variableNamingConvention="structured",
    )
    for interface, capabilities in _INTERFACES.items():
        ET.SubElement(root, interface, {**_SHARED, **capabilities}, modelIdentifier=component.model)
    root.append(unit_definitions(table))
    types = ET.Element("TypeDefinitions")
    for variable in table.variables:
        if variable.items:
            kind = ET.SubElement(types, "EnumerationType", name=type_of(variable))
            for value, name in enumerate(variable.items):
                ET.SubElement(kind, "Item", name=name, value=str(value))
    if len(types):
        root.append(types)
    add_log_and_experiment(root, categories)
    variables = ET.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(table.variables):
        add_variable(variables, reference, variable, table)
    count = len(table.variables)
    add_time(variables, count)
    indicators = INDICATORS[component.model]
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
    order = [v.derivative_of for v in table.variables if v.derivative_of]
    root.append(model_structure_3(table, indicators, order))
    return as_text(root)


def build_description(component: Component) -> bytes:
    """How the text in C is built."""
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    build = ET.SubElement(root, "BuildConfiguration", modelIdentifier=component.model)
    files = ET.SubElement(build, "SourceFileSet", language="C11")
    for name in sources(component.model):
        if name.endswith(".c"):
            ET.SubElement(files, "SourceFile", name=name)
    return as_text(root)
