"""An SSP archive (SSP 1.0) of the slider-belt coupled with its brake actuator.

SSP is a format for coupled FMUs: a ZIP archive of the FMUs and of the connections between them.
"""

import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final
from xml.etree import ElementTree as ET

from fivtui.io import check_output, check_suffix, output_path, temporary_folder, write_atomically
from fmu_src.slave import Role, Type, Variable

from .builder import NATIVE, ZIP_DATE, build_fmu
from .components import COMPONENTS
from .description import about_attributes, base_exponents, type_name, xml_bytes

SUFFIX: Final = ".ssp"
_NAMESPACES: Final = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "oms": "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd",
}
# ElementTree writes the namespace of an element in braces before its name.
_SSD, _SSC, _SSV, _OMS = (f"{{{uri}}}" for uri in _NAMESPACES.values())
_SYSTEM: Final = "brake"
# The connected input of each component. The actuator comes first: its initial preload does not
# depend on the contact force, so hosts that initialize in this order start the slider under that
# preload.
_INPUTS: Final = {"brake-actuator": "P", "slider-belt": "F"}
_CONNECTIONS: Final = (
    ("brake-actuator", "F", "slider-belt", "F"),
    ("slider-belt", "P", "brake-actuator", "P"),
)
# How OMSimulator couples the components: fixed steps, s. It ignores the tolerances at fixed steps,
# but reads them.
_MASTER: Final = {
    "description": "oms-ma",
    "stepSize": "0.001",
    "absoluteTolerance": "0.0001",
    "relativeTolerance": "0.0001",
}


def build_ssp(
    path: str | Path,
    *,
    fmi: str = "2",
    flavour: str = NATIVE,
    ports: bool = False,
    force: bool = False,
) -> Path:
    """Build an SSP archive of the slider-belt coupled with the brake actuator.

    Parameters
    ----------
    path : str or Path
        The ``.ssp`` file to write.
    fmi : "2" or "3"
        Version of FMI of both FMUs; libcosim and fmpy couple those of FMI 2.0 only.
    flavour : "native" or "python"
        Flavour of both FMUs; see `build_fmu`.
    ports : bool
        Whether the system has ports: the inputs that are not connected, and all outputs. All
        parameters are connectors then. libcosim and ecos refuse a system with ports.
    force : bool
        Whether to replace an existing file.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If version or flavour is unknown, or the binary was not compiled; if the name does not end
        in ``.ssp``; if the folder cannot be written, or the file exists and `force` is not set.

    Examples
    --------
    >>> from fivtui import build_ssp
    >>> build_ssp("pressed.ssp").name
    'pressed.ssp'
    """
    target = output_path(path, force=force)
    check_suffix(target, "system", (SUFFIX,))
    check_output(target)
    content = {"SystemStructure.ssd": _system_structure(ports=ports)}
    with temporary_folder() as folder:
        for component in COMPONENTS:
            file = folder / _fmu_name(component)
            fmu = build_fmu(file, component=component, fmi=fmi, flavour=flavour)
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


def _system_structure(*, ports: bool) -> bytes:
    for prefix, uri in _NAMESPACES.items():
        ET.register_namespace(prefix, uri)
    about = about_attributes()
    about["fileversion"] = about.pop("version")
    del about["variableNamingConvention"]
    root = ET.Element(f"{_SSD}SystemStructureDescription", about, name=_SYSTEM, version="1.0")
    system = ET.SubElement(root, f"{_SSD}System", name=_SYSTEM)
    system_ports = list(_system_ports()) if ports else []
    if ports:
        _add_connectors(system, [variable for _, variable in system_ports])
        _add_start_values(system, [v for _, v in system_ports if v.role is Role.INPUT])
    elements = ET.SubElement(system, f"{_SSD}Elements")
    for component in _INPUTS:
        element = ET.SubElement(
            elements,
            f"{_SSD}Component",
            name=_element_name(component),
            type="application/x-fmu-sharedlibrary",
            source=_fmu_path(component),
        )
        _add_connectors(element, _connected_variables(component, ports=ports))
    connections = ET.SubElement(system, f"{_SSD}Connections")
    for source, output, target, input_port in _CONNECTIONS:
        _connect(connections, (source, output), (target, input_port))
    for component, variable in system_ports:
        ends = ("", variable.name), (component, variable.name)
        _connect(connections, *(ends if variable.role is Role.INPUT else reversed(ends)))
    annotations = ET.SubElement(system, f"{_SSD}Annotations")
    annotation = ET.SubElement(annotations, f"{_SSC}Annotation", type="org.openmodelica")
    simulation = ET.SubElement(
        ET.SubElement(annotation, f"{_OMS}Annotations"), f"{_OMS}SimulationInformation"
    )
    ET.SubElement(simulation, f"{_OMS}FixedStepMaster", _MASTER)
    variables = [v for name in _INPUTS for v in _connected_variables(name, ports=ports)]
    _add_enumerations(root, variables)
    _add_units(root, variables)
    ET.SubElement(root, f"{_SSD}DefaultExperiment", startTime="0.0", stopTime="100.0")
    return xml_bytes(root)


def _system_ports() -> Iterator[tuple[str, Variable]]:
    """Free inputs and all outputs, with their components."""
    for component, connected_input in _INPUTS.items():
        for variable in COMPONENTS[component].variable_table.variables:
            is_free_input = variable.role is Role.INPUT and variable.name != connected_input
            if is_free_input or variable.role is Role.OUTPUT:
                yield component, variable


def _connected_variables(component: str, *, ports: bool) -> list[Variable]:
    """The variables that are connectors of a component.

    Without ports these are the connected input, and outputs of type Real: hosts overwrite other
    inputs, and libcosim refuses enumerations.
    """
    variables = COMPONENTS[component].variable_table.variables
    if ports:
        return [v for v in variables if v.role is not Role.LOCAL]
    connected_input = _INPUTS[component]
    return [
        v
        for v in variables
        if v.name == connected_input or (v.role is Role.OUTPUT and v.type is Type.REAL)
    ]


def _add_connectors(parent: ET.Element, variables: list[Variable]) -> None:
    connectors = ET.SubElement(parent, f"{_SSD}Connectors")
    for variable in variables:
        connector = ET.SubElement(
            connectors, f"{_SSD}Connector", name=variable.name, kind=variable.role.value
        )
        kind = ET.SubElement(connector, f"{_SSC}{variable.type.value}")
        if variable.unit:
            kind.set("unit", variable.unit)
        if variable.value_names:
            kind.set("name", type_name(variable))


def _add_start_values(system: ET.Element, inputs: list[Variable]) -> None:
    bindings = ET.SubElement(system, f"{_SSD}ParameterBindings")
    binding = ET.SubElement(bindings, f"{_SSD}ParameterBinding")
    values = ET.SubElement(binding, f"{_SSD}ParameterValues")
    parameter_set = ET.SubElement(values, f"{_SSV}ParameterSet", version="1.0", name="start")
    parameters = ET.SubElement(parameter_set, f"{_SSV}Parameters")
    for variable in inputs:
        parameter = ET.SubElement(parameters, f"{_SSV}Parameter", name=variable.name)
        ET.SubElement(parameter, f"{_SSV}Real", value=repr(variable.start))


def _connect(connections: ET.Element, *ends: tuple[str, str]) -> None:
    """Add a connection; an end without a component is a port of the system."""
    attributes: dict[str, str] = {}
    for side, (component, connector) in zip(("start", "end"), ends, strict=True):
        if component:
            attributes[f"{side}Element"] = _element_name(component)
        attributes[f"{side}Connector"] = connector
    ET.SubElement(connections, f"{_SSD}Connection", attributes)


def _add_enumerations(root: ET.Element, variables: list[Variable]) -> None:
    if enumerations := [v for v in variables if v.value_names]:
        group = ET.SubElement(root, f"{_SSD}Enumerations")
        for variable in enumerations:
            element = ET.SubElement(group, f"{_SSC}Enumeration", name=type_name(variable))
            for value, name in enumerate(variable.value_names):
                ET.SubElement(element, f"{_SSC}Item", name=name, value=str(value))


def _add_units(root: ET.Element, variables: list[Variable]) -> None:
    units = ET.SubElement(root, f"{_SSD}Units")
    for unit in dict.fromkeys(v.unit for v in variables if v.unit):
        element = ET.SubElement(units, f"{_SSC}Unit", name=unit)
        ET.SubElement(element, f"{_SSC}BaseUnit", base_exponents(unit))
