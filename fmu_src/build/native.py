"""Files of a native FMU: binaries, C files if wanted, and the model description.

FMUs have two flavours: native ones are compiled from C, Python ones contain modules for Python.
"""

import platform
import sys
from collections.abc import Mapping, Sequence
from typing import Final
from xml.etree import ElementTree as ET

from fivtui.model import InputError, check_known

from .c_sources import MODELS, NATIVE, model_guid, sources, sources_hash
from .component import Component
from .cross_compilation import compile_binary
from .description import (
    about_attributes,
    add_type,
    common_attributes,
    model_structure,
    new_description,
    set_type_attributes,
    type_definitions,
    xml_bytes,
)
from .description_3 import (
    INDICATORS,
    build_description,
    dependencies_in_exchange,
    native_description_3,
)
from .platforms import HOSTS, PLATFORMS

_DESCRIPTION: Final = "modelDescription.xml"
_ADVICE: Final = "take the Python flavour (--flavour python; for runs, --method fmu)"
# Contains the reason if the compilation at installation failed.
_FAILURE_FILE: Final = NATIVE / "native.txt"
_LOG_CATEGORIES: Final = {
    "logStatusWarning": "Log messages with the status Warning.",
    "logStatusDiscard": "Log messages with the status Discard.",
    "logStatusError": "Log messages with the status Error.",
    "logAll": "Log all messages.",
}
_CAPABILITIES: Final = {
    "needsExecutionTool": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
    "providesDirectionalDerivative": "true",
}
# The two interfaces of a native FMU, with their capability flags.
_INTERFACES: Final[Mapping[str, Mapping[str, str]]] = {
    "ModelExchange": {**_CAPABILITIES, "completedIntegratorStepNotNeeded": "false"},
    "CoSimulation": {
        **_CAPABILITIES,
        "canHandleVariableCommunicationStepSize": "true",
        "canInterpolateInputs": "true",
        # Calls return up to the third derivative. OMSimulator takes the declared order also for
        # that of the inputs, which is 1.
        "maxOutputDerivativeOrder": "1",
    },
}


def native_failure() -> str | None:
    """The reason why native FMUs cannot be built here; None if they can be built."""
    try:
        for model in MODELS:
            _read_binary(model)
    except InputError as error:
        return str(error)
    return None


def native_files(
    component: Component, fmi: str, platforms: Sequence[str], *, with_sources: bool
) -> dict[str, bytes]:
    """The binaries, the C files if `with_sources`, and the model description: content by name.

    The binary compiled at installation is used for the host, the default of `platforms`; binaries
    for others are compiled now. Raises `InputError` if the host's binary is missing or compiled
    from other sources, and `ComputationError` if a compilation fails.
    """
    content: dict[str, bytes] = {}
    model, platform_names = component.model, platforms or [_host_platform()]
    for name in platform_names:
        check_known("platform", name, PLATFORMS)
    # x86 platforms first: a binary for ARM is also put into the folder of x86, where importers on
    # ARM look for it, but never replaces the x86 binary.
    for name in sorted(platform_names, key=lambda name: not PLATFORMS[name].is_x86):
        target = PLATFORMS[name]
        is_host = name == HOSTS.get(_machine())
        binary = _read_binary(model) if is_host else compile_binary(model, name)
        folder_2, folder_3 = target.folders
        folders = (folder_2, target.x86_folder) if fmi == "2" else (folder_3,)
        for folder in filter(None, folders):
            content.setdefault(f"binaries/{folder}/{model}{target.suffix}", binary)
    if with_sources:
        for name, text in sources(component.model).items():
            content[f"sources/{name}"] = text.encode()
    if fmi == "2":
        content[_DESCRIPTION] = native_description(component, with_sources=with_sources)
        return content
    if with_sources:
        content["sources/buildDescription.xml"] = build_description(component)
    content[_DESCRIPTION] = native_description_3(component, _LOG_CATEGORIES)
    return content


def _machine() -> tuple[str, str]:
    return sys.platform, platform.machine().lower()


def _host_platform() -> str:
    """Name in `PLATFORMS` of the platform of this machine."""
    if _machine() not in HOSTS:
        raise InputError(f"no native FMU supports {', '.join(_machine())}; {_ADVICE}")
    return HOSTS[_machine()]


def _read_binary(model: str) -> bytes:
    advice = f"install fivtui anew, or {_ADVICE}"
    file = NATIVE / f"{model}{PLATFORMS[_host_platform()].suffix}"
    if not file.is_file():
        reason = "not installed"
        if _FAILURE_FILE.is_file():
            reason = _FAILURE_FILE.read_text(encoding="utf-8").strip()
        raise InputError(f"the native FMU is not compiled: {reason}; {advice}")
    binary = file.read_bytes()
    # Every binary contains the hash of its sources.
    if sources_hash().encode() not in binary:
        raise InputError(f"the native FMU is compiled from other sources; {advice}")
    return binary


def native_description(component: Component, *, with_sources: bool = False) -> bytes:
    """The model description of a native FMU: co-simulation and model exchange, FMI 2.0.

    `with_sources` lists the files to compile.
    """
    table = component.variable_table
    states = {v.derivative_of for v in table.variables if v.derivative_of}
    root_attributes = {
        "fmiVersion": "2.0",
        "modelName": component.model,
        "guid": model_guid(component.model),
        "numberOfEventIndicators": str(len(INDICATORS[component.model])),
        "description": component.description,
        **about_attributes(),
    }
    types = type_definitions(table, add_type)
    root = new_description(root_attributes, _INTERFACES, table, types, _LOG_CATEGORIES)
    if with_sources:
        for element in root[: len(_INTERFACES)]:
            files = ET.SubElement(element, "SourceFiles")
            for name in sources(component.model):
                if name.endswith(".c"):
                    ET.SubElement(files, "File", name=name)
    variables = ET.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(table.variables):
        element = ET.SubElement(variables, "ScalarVariable", common_attributes(variable, reference))
        ET.SubElement(element, variable.type.value)
        set_type_attributes(element, variable, table)
    root.append(model_structure(table, lambda v: dependencies_in_exchange(v, states)))
    return xml_bytes(root)
