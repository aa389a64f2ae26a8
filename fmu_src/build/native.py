"""What a native FMU holds: the binary that installation compiled, and its model description."""

import platform
import sys
from collections.abc import Mapping, Sequence
from typing import Final
from xml.etree import ElementTree as ET

from fivtui.model import InputError, check_known
from fmu_src.slave import Type

from .component import Component
from .cross import TARGETS, compiled_for
from .description import (
    AUTHOR,
    GENERATION,
    add_type,
    as_text,
    complete_variable,
    identity_of,
    model_structure,
    start_description,
    type_definitions,
)
from .description_3 import (
    INDICATORS,
    build_description,
    exchange_dependencies,
    native_description_3,
)
from .native_text import MODELS, NATIVE, build_name, guid_of, sources

_DESCRIPTION: Final = "modelDescription.xml"
_REASON: Final = NATIVE / "native.txt"
# This machine in `TARGETS`, by `sys.platform` and processor.
_HERE: Final[Mapping[tuple[str, str], str]] = {
    ("linux", "x86_64"): "linux64",
    ("linux", "aarch64"): "aarch64-linux",
    ("darwin", "x86_64"): "darwin64",
    ("darwin", "arm64"): "aarch64-darwin",
    ("win32", "amd64"): "win64",
    ("win32", "arm64"): "aarch64-windows",
}
_LOG_CATEGORIES: Final = {
    "logStatusWarning": "Log messages with fmi2Warning status.",
    "logStatusDiscard": "Log messages with fmi2Discard status.",
    "logStatusError": "Log messages with fmi2Error status.",
    "logAll": "Log all messages.",
}
_SHARED: Final = {
    "needsExecutionTool": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
    "providesDirectionalDerivative": "true",
}
_INTERFACES: Final[Mapping[str, Mapping[str, str]]] = {
    "ModelExchange": {**_SHARED, "completedIntegratorStepNotNeeded": "true"},
    "CoSimulation": {
        **_SHARED,
        "canHandleVariableCommunicationStepSize": "true",
        "canInterpolateInputs": "true",
    },
}


def why_no_native() -> str | None:
    """Why no native FMU can be built here; None if one can."""
    try:
        for model in MODELS:
            _binary(model)
    except InputError as error:
        return str(error)
    return None


def native_content(
    component: Component, fmi: str, platforms: Sequence[str], *, with_sources: bool
) -> dict[str, bytes]:
    """The binaries, the text in C if asked for, and the model description: content by name.

    The binary that installation compiled serves this platform, which is meant by no `platforms`;
    for others they are compiled now. Raises `InputError` where there is no binary, or it was
    compiled from another text, and `ComputationError` if one cannot be compiled.
    """
    content: dict[str, bytes] = {}
    model, names = component.model, platforms or [_platform_name()]
    for name in names:
        check_known("platform", name, TARGETS)
    # Those of x86 first: a folder in which importers for ARM look, too, is theirs.
    for name in sorted(names, key=lambda name: bool(TARGETS[name].older)):
        target = TARGETS[name]
        binary = _binary(model) if name == _HERE.get(_machine()) else compiled_for(model, name)
        folders = (target.folders[0], target.older) if fmi == "2" else target.folders[1:]
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


def _platform_name() -> str:
    """Name of this platform."""
    if _machine() not in _HERE:
        raise InputError(
            f"a native FMU for {', '.join(_machine())}: there is none; build the Python flavour"
        )
    return _HERE[_machine()]


def _binary(model: str) -> bytes:
    advice = "install fivtui anew, or build the Python flavour"
    file = NATIVE / f"{model}{TARGETS[_platform_name()].suffix}"
    if not file.is_file():
        why = _REASON.read_text(encoding="utf-8").strip() if _REASON.is_file() else "not installed"
        raise InputError(f"the native FMU is not compiled: {why}; {advice}")
    binary = file.read_bytes()
    if build_name().encode() not in binary:
        raise InputError(f"the native FMU is compiled from another text; {advice}")
    return binary


def native_description(component: Component, *, with_sources: bool = False) -> bytes:
    """The model description of a native FMU: co-simulation and model exchange, FMI 2.0.

    With sources it names the files to compile.
    """
    table = component.table
    states = {v.derivative_of for v in table.variables if v.derivative_of}
    identity = {
        "fmiVersion": "2.0",
        "modelName": component.model,
        "guid": guid_of(component.model),
        **GENERATION,
        "numberOfEventIndicators": str(len(INDICATORS[component.model])),
        "description": component.description,
        **AUTHOR,
    }
    types = type_definitions(table, add_type)
    root = start_description(identity, _INTERFACES, table, types, _LOG_CATEGORIES)
    if with_sources:
        for element in root[: len(_INTERFACES)]:
            files = ET.SubElement(element, "SourceFiles")
            for name in sources(component.model):
                if name.endswith(".c"):
                    ET.SubElement(files, "File", name=name)
    variables = ET.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(table.variables):
        element = ET.SubElement(variables, "ScalarVariable", identity_of(variable, reference))
        ET.SubElement(element, (Type.INTEGER if variable.value_names else variable.type).value)
        complete_variable(element, variable, table)
    root.append(model_structure(table, lambda v: exchange_dependencies(v, states)))
    return as_text(root)
