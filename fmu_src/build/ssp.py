"""An SSP archive (SSP 1.0) of the slider-belt coupled with its brake actuator.

SSP is a format for coupled FMUs: a ZIP archive of the FMUs and of the connections between them.
"""

import zipfile
from pathlib import Path
from typing import BinaryIO, Final
from xml.etree import ElementTree as ET

from fivtui.io import check_output, check_suffix, output_path, temporary_folder, write_atomically
from fmu_src.slave import Role, Type

from .builder import PYTHON, ZIP_DATE, build_fmu
from .components import COMPONENTS

SUFFIX: Final = ".ssp"
_NAMESPACE: Final = "http://ssp-standard.org/SSP1/SystemStructure"
# ElementTree writes the namespace of an element in braces before its name.
_SSD: Final = "{" + _NAMESPACE + "Description}"
_SSC: Final = "{" + _NAMESPACE + "Common}"
# The connected input of each component; its other ports are all outputs of type Real. Other inputs
# are no ports, so that they keep their start values: hosts overwrite that of an input port. The
# actuator comes first: its initial preload does not depend on the contact force, so hosts that
# initialize in this order start the slider under that preload.
_INPUTS: Final = {"brake-actuator": "P", "slider-belt": "F"}
_CONNECTIONS: Final = (
    ("brake-actuator", "F", "slider-belt", "F"),
    ("slider-belt", "P", "brake-actuator", "P"),
)


def build_ssp(path: str | Path, *, flavour: str = PYTHON, force: bool = False) -> Path:
    """Build an SSP archive of the slider-belt coupled with the brake actuator.

    Parameters
    ----------
    path : str or Path
        The ``.ssp`` file to write.
    flavour : "python" or "native"
        Flavour of both FMUs; see `build_fmu`.
    force : bool
        Whether to replace an existing file.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the flavour is unknown or its binary was not compiled; if the name does not end in
        ``.ssp``; if the folder cannot be written, or the file exists and `force` is not set.

    Examples
    --------
    >>> from fivtui import build_ssp
    >>> build_ssp("pressed.ssp").name
    'pressed.ssp'
    """
    target = output_path(path, force=force)
    check_suffix(target, "system", (SUFFIX,))
    check_output(target)
    content = {"SystemStructure.ssd": _system_structure()}
    with temporary_folder() as folder:
        for component in COMPONENTS:
            file = folder / _fmu_name(component)
            fmu = build_fmu(file, component=component, flavour=flavour)
            content[_fmu_path(component)] = fmu.read_bytes()

    def write(file: BinaryIO) -> None:
        with zipfile.ZipFile(file, "w") as archive:
            for name, data in content.items():
                archive.writestr(zipfile.ZipInfo(name, ZIP_DATE), data)

    write_atomically(target, write)
    return Path(path)


def _element_name(component: str) -> str:
    return component.replace("-", "_")


def _fmu_name(component: str) -> str:
    return f"{_element_name(component)}.fmu"


def _fmu_path(component: str) -> str:
    return f"resources/{_fmu_name(component)}"


def _system_structure() -> bytes:
    for prefix, suffix in (("ssd", "Description"), ("ssc", "Common")):
        ET.register_namespace(prefix, f"{_NAMESPACE}{suffix}")
    root = ET.Element(
        f"{_SSD}SystemStructureDescription", name="brake", version="1.0", generationTool="fivtui"
    )
    system = ET.SubElement(root, f"{_SSD}System", name="brake")
    elements = ET.SubElement(system, f"{_SSD}Elements")
    for component, connected_input in _INPUTS.items():
        element = ET.SubElement(
            elements,
            f"{_SSD}Component",
            name=_element_name(component),
            type="application/x-fmu-sharedlibrary",
            source=_fmu_path(component),
        )
        connectors = ET.SubElement(element, f"{_SSD}Connectors")
        for variable in COMPONENTS[component].variable_table.variables:
            is_output = variable.role is Role.OUTPUT and variable.type is Type.REAL
            if not is_output and variable.name != connected_input:
                continue
            connector = ET.SubElement(
                connectors, f"{_SSD}Connector", name=variable.name, kind=variable.role.value
            )
            ET.SubElement(connector, f"{_SSC}{variable.type.value}")
    connections = ET.SubElement(system, f"{_SSD}Connections")
    for source, output, target, input_port in _CONNECTIONS:
        ET.SubElement(
            connections,
            f"{_SSD}Connection",
            startElement=_element_name(source),
            startConnector=output,
            endElement=_element_name(target),
            endConnector=input_port,
        )
    ET.SubElement(root, f"{_SSD}DefaultExperiment", startTime="0.0", stopTime="100.0")
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"
