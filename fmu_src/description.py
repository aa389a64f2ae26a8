"""The model description: what pythonfmu writes, completed from the table of variables."""

import hashlib
import math
import uuid
from collections.abc import Mapping, Sequence
from typing import Final
from xml.etree import ElementTree as ET

from .units import base_exponents, display_units
from .variable import Role, Type, Variable
from .variables import REFERENCES, VARIABLES

# An FMU of the same content is the same file, whenever it is built.
_TIMESTAMP: Final = "1980-01-01T00:00:00Z"


def completed(xml: bytes, content: Mapping[str, bytes]) -> bytes:
    """Complete a model description.

    Parameters
    ----------
    xml : bytes
        The model description written by pythonfmu.
    content : mapping of str to bytes
        All other files of the FMU by name; the GUID follows from them.

    Returns
    -------
    bytes
        The model description with units, bounds, dependencies, initial unknowns and a fixed GUID.
    """
    root = ET.fromstring(xml)  # noqa: S314
    root.set("generationDateAndTime", _TIMESTAMP)
    root.set("generationTool", f"fivtui with {root.get('generationTool')}")
    root.insert(1, _unit_definitions())
    for element, variable in zip(_child(root, "ModelVariables"), VARIABLES, strict=True):
        _complete_variable(_child(element, variable.type.value), variable)
    root.remove(_child(root, "ModelStructure"))
    root.append(_model_structure())
    root.set("guid", "")
    digest = hashlib.sha256(ET.tostring(root))
    for name in sorted(content):
        digest.update(f"\0{name}\0".encode() + content[name])
    root.set("guid", f"{{{uuid.uuid5(uuid.NAMESPACE_OID, digest.hexdigest())}}}")
    for element in root.iter():
        element.text = element.tail = None
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"


def _child(element: ET.Element, name: str) -> ET.Element:
    found = element.find(name)
    if found is None:
        raise LookupError(f"pythonfmu wrote no {name} element")
    return found


def _unit_definitions() -> ET.Element:
    definitions = ET.Element("UnitDefinitions")
    for unit in dict.fromkeys(v.unit for v in VARIABLES if v.unit):
        element = ET.SubElement(definitions, "Unit", name=unit)
        exponents = {base: str(exponent) for base, exponent in base_exponents(unit).items()}
        ET.SubElement(element, "BaseUnit", exponents)
        for name, factor in display_units(unit).items():
            ET.SubElement(element, "DisplayUnit", name=name, factor=repr(factor))
    return definitions


def _complete_variable(element: ET.Element, variable: Variable) -> None:
    if variable.unit:
        element.set("unit", variable.unit)
        element.set("displayUnit", variable.unit)
    number = _integer if variable.type is Type.INTEGER else repr
    for name, bound in (("min", variable.lower), ("max", variable.upper)):
        if math.isfinite(bound):
            element.set(name, number(bound))
    if variable.nominal is not None:
        element.set("nominal", repr(variable.nominal))
    if variable.settable:
        boolean = variable.type is Type.BOOLEAN
        element.set("start", str(variable.start).lower() if boolean else repr(variable.start))


def _integer(value: float) -> str:
    return str(int(value))


def _model_structure() -> ET.Element:
    structure = ET.Element("ModelStructure")
    for tag, attribute in (("Outputs", "depends_on"), ("InitialUnknowns", "starts_from")):
        group = ET.SubElement(structure, tag)
        for variable in VARIABLES:
            if variable.role is Role.OUTPUT:
                known: Sequence[str] = getattr(variable, attribute)
                ET.SubElement(
                    group,
                    "Unknown",
                    index=str(REFERENCES[variable.name] + 1),
                    dependencies=" ".join(
                        str(i + 1) for i in sorted(REFERENCES[name] for name in known)
                    ),
                    dependenciesKind=" ".join("dependent" for _ in known),
                )
    return structure
