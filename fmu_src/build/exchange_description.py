"""The model description of the model-exchange FMU (FMI 3.0), from the table of variables."""

import hashlib
import math
import uuid
from collections.abc import Collection, Mapping, Sequence
from typing import Final
from xml.etree import ElementTree as ET

from fmu_src.slave import STATES, TIME_REFERENCE, Role, Type, Variable, VariableTable

from .description import TIMESTAMP, unit_definitions

_TAGS: Final = {Type.REAL: "Float64", Type.BOOLEAN: "Boolean"}
_INDICATOR: Final = "switching"


def exchange_description(
    xml: bytes, content: Mapping[str, bytes], table: VariableTable, description: str
) -> bytes:
    """Complete the model description that pythonfmu3 wrote.

    The instantiation token follows from `content`, the other files of the FMU by name;
    `description` is one sentence on the model.
    """
    given = ET.fromstring(xml).attrib  # noqa: S314
    model = given["modelName"]
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=model,
        instantiationToken="",
        description=description,
        author="The fivtui developers",
        license="MIT",
        generationTool=f"fivtui with {given['generationTool']}",
        generationDateAndTime=TIMESTAMP,
        variableNamingConvention="structured",
    )
    ET.SubElement(root, "ModelExchange", modelIdentifier=model)
    root.append(unit_definitions(table))
    log = ET.SubElement(root, "LogCategories")
    ET.SubElement(log, "Category", name="logStatusError", description="Calls that are refused.")
    ET.SubElement(root, "DefaultExperiment", startTime="0.0", stopTime="100.0", tolerance="1e-10")
    variables = ET.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(table.variables):
        _add_variable(variables, reference, variable, table)
    ET.SubElement(
        variables,
        "Float64",
        name="time",
        valueReference=str(TIME_REFERENCE),
        causality="independent",
        variability="continuous",
        unit="s",
    )
    root.append(_model_structure(table))
    digest = hashlib.sha256(ET.tostring(root))
    for name in sorted(content):
        digest.update(f"\0{name}\0".encode() + content[name])
    token = uuid.uuid5(uuid.NAMESPACE_OID, digest.hexdigest())
    root.set("instantiationToken", f"{{{token}}}")
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"


def _add_variable(
    variables: ET.Element, reference: int, variable: Variable, table: VariableTable
) -> None:
    attributes = {
        "name": variable.name,
        "valueReference": str(reference),
        "description": variable.meaning,
        "causality": variable.role.value,
        "variability": variable.variability,
    }
    if variable.initial is not None:
        attributes["initial"] = variable.initial
    if variable.unit:
        attributes |= {"unit": variable.unit, "displayUnit": variable.unit}
    for name, bound in (("min", variable.lower), ("max", variable.upper)):
        if math.isfinite(bound):
            attributes[name] = repr(bound)
    if variable.nominal is not None:
        attributes["nominal"] = repr(variable.nominal)
    if variable.derivative_of:
        attributes["derivative"] = str(table.references[variable.derivative_of])
    if variable.settable:
        boolean = variable.type is Type.BOOLEAN
        attributes["start"] = str(variable.start).lower() if boolean else repr(variable.start)
    ET.SubElement(variables, _TAGS[variable.type], attributes)


def _model_structure(table: VariableTable) -> ET.Element:
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
        add("Output", variable, known_in_exchange(variable, states))
    # Derivatives in the order in which the slave exchanges states.
    derivatives = [v for v in table.variables if v.derivative_of]
    for variable in sorted(derivatives, key=lambda v: STATES.index(v.derivative_of)):
        add("ContinuousStateDerivative", variable, variable.varies_with)
    for variable in table.variables:
        if variable.role is Role.OUTPUT or variable.derivative_of:
            add("InitialUnknown", variable, variable.starts_from)
    indicator = table.variables[table.references[_INDICATOR]]
    add("EventIndicator", indicator, ("y",))
    return structure


def known_in_exchange(output: Variable, states: Collection[str]) -> tuple[str, ...]:
    """States and inputs that an output depends on where the importer knows the states, too."""
    own = (output.name,) if output.name in states else _FROM_STATES.get(output.name, ())
    return (*own, *output.depends_on)


_FROM_STATES: Final = {
    "P": ("y",),
    "friction_slider": ("y",),
    "friction_belt": ("y",),
    "switching": ("y",),
}
