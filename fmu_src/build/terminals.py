"""Terminals and icons of an FMU: groups of variables to connect as one, and its pictures.

FMI 3.0 defines the folder, and FMI 2.0.4 allows it.
"""

from importlib.resources import files
from typing import Final
from xml.etree import ElementTree as ET

from .component import Component
from .description import xml_bytes

_FOLDER: Final = "terminalsAndIcons"
# Opposite corners of the coordinate system, which the icon fills.
_CORNERS: Final = {"x1": "-100.0", "y1": "-100.0", "x2": "100.0", "y2": "100.0"}


def pictures_and_terminals(component: Component, fmi: str) -> dict[str, bytes]:
    """The icon, the figure of the documentation, and the terminals: content by name in the FMU."""
    icon = _picture(component, "icon.png")
    content = {
        f"{_FOLDER}/{_FOLDER}.xml": _terminals(component),
        f"{_FOLDER}/icon.png": icon,
        f"{_FOLDER}/icon.svg": _picture(component, "icon.svg"),
        "documentation/diagram.svg": _picture(component, "diagram.svg"),
    }
    return content if fmi == "3" else content | {"model.png": icon}


def _picture(component: Component, name: str) -> bytes:
    return files("fmu_src.build").joinpath("pictures", f"{component.model}_{name}").read_bytes()


def _terminals(component: Component) -> bytes:
    root = ET.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    graphics = ET.SubElement(root, "GraphicalRepresentation")
    ET.SubElement(graphics, "CoordinateSystem", _CORNERS, suggestedScalingFactorTo_mm="0.1")
    ET.SubElement(graphics, "Icon", _CORNERS)
    terminals = ET.SubElement(root, "Terminals")
    for name, terminal in component.terminals.items():
        element = ET.SubElement(
            terminals, "Terminal", name=name, matchingRule="plug", description=terminal.meaning
        )
        for member, variable in terminal.members.items():
            ET.SubElement(
                element,
                "TerminalMemberVariable",
                variableName=variable,
                memberName=member,
                variableKind="signal",
            )
    return xml_bytes(root)
