"""Model descriptions, the XML files that FMI requires of an FMU.

For a Python FMU pythonfmu writes the description, and `complete_description` completes it. Native
FMUs have descriptions of this project: `native.py` and `description_3.py` compose them from
functions here.
"""

import hashlib
import math
import os
import time
import uuid
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Final
from xml.etree import ElementTree as ET

from fivtui.model import InputError
from fivtui.taylor import DEFAULT_TOL
from fivtui.version import __version__
from fmu_src.slave import Role, Type, Variable, VariableTable

TOOL: Final = f"fivtui {__version__}"
_DATE: Final = "generationDateAndTime"
# The factors of units such as N s/m, with their exponents of the SI base units kg, m and s. FMI has
# an attribute for each base unit, in this order.
_BASE_EXPONENTS: Final = {
    "kg": {"kg": 1},
    "m": {"m": 1},
    "s": {"s": 1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "1": {},
}
# Units that engineers use, with their factors: display value = factor times SI value.
_DISPLAY_UNITS: Final = {
    "kg": ("g", 1e3),
    "m": ("mm", 1e3),
    "m/s": ("mm/s", 1e3),
    "m/s^2": ("mm/s^2", 1e3),
    "s": ("ms", 1e3),
    "N": ("kN", 1e-3),
    "N/m": ("N/mm", 1e-3),
    "N/m^3": ("N/mm^3", 1e-9),
    "N/s": ("kN/s", 1e-3),
    "N s/m": ("N s/mm", 1e-3),
}
# SI units that tools display in the unit above by default.
_CONVERTED_UNITS: Final = ("m", "N", "N/m", "N/s")


def complete_description(xml: bytes, content: Mapping[str, bytes], table: VariableTable) -> bytes:
    """Complete the model description that pythonfmu wrote.

    This adds units, bounds, types, derivatives, dependencies, initial unknowns, author, licence and
    date, and a GUID from a hash of `content`, the other files of the FMU by name.
    """
    root = ET.fromstring(xml)  # noqa: S314
    wrapper = root.get("generationTool")
    root.attrib |= about_attributes() | {"generationTool": f"{TOOL} with {wrapper}"}
    # Elements have a fixed order: the first is the interface, then come units and types.
    root.insert(1, unit_definitions(table))
    for types in type_definitions(table, add_type):
        root.insert(2, types)
    for element, variable in zip(_find_child(root, "ModelVariables"), table.variables, strict=True):
        set_type_attributes(element, variable, table)
    root.remove(_find_child(root, "ModelStructure"))
    root.append(model_structure(table, lambda v: v.depends_on))
    # The GUID is a hash of the description without it and the date, and of the other files.
    date = root.attrib.pop(_DATE)
    root.set("guid", "")
    digest = hashlib.sha256(ET.tostring(root))
    for name in sorted(content):
        digest.update(f"\0{name}\0".encode() + content[name])
    root.set("guid", f"{{{uuid.uuid5(uuid.NAMESPACE_OID, digest.hexdigest())}}}")
    root.set(_DATE, date)
    return xml_bytes(root)


def about_attributes() -> dict[str, str]:
    """Attributes of a description on author, licence, version, tool and date, in every version."""
    return {
        "author": "The fivtui developers",
        "version": __version__,
        "copyright": next(line for line in project_license().splitlines() if "(c)" in line),
        "license": "MIT",
        "generationTool": TOOL,
        _DATE: build_date(),
        "variableNamingConvention": "structured",
    }


def project_license() -> str:
    """The licence of fivtui, which is installed or runs from its source folder."""
    try:
        return license_text("fivtui")
    except PackageNotFoundError:
        return (Path(__file__).parents[2] / "LICENSE").read_text(encoding="utf-8")


def license_text(package: str) -> str:
    """The licence of an installed package."""
    for file in distribution(package).files or ():
        if file.name == "LICENSE":
            return Path(str(file.locate())).read_text(encoding="utf-8")
    raise LookupError(f"the installed {package} has no licence file")


def build_date() -> str:
    """Date and time of the build, UTC; those of ``SOURCE_DATE_EPOCH`` if it is set."""
    text = os.environ.get("SOURCE_DATE_EPOCH") or str(int(time.time()))
    try:
        return f"{datetime.fromtimestamp(int(text), UTC):%Y-%m-%dT%H:%M:%SZ}"
    except (ValueError, OverflowError, OSError):
        raise InputError(f"SOURCE_DATE_EPOCH = {text}: must be seconds since 1970") from None


def xml_bytes(root: ET.Element) -> bytes:
    """A model description as the bytes of its file, indented."""
    for element in root.iter():
        element.text = element.tail = None
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"


def _find_child(element: ET.Element, name: str) -> ET.Element:
    child = element.find(name)
    if child is None:
        raise LookupError(f"pythonfmu wrote no {name} element")
    return child


def unit_definitions(table: VariableTable) -> ET.Element:
    """``UnitDefinitions`` of the variables' units, with base and display units; FMI 2.0 and 3.0."""
    definitions = ET.Element("UnitDefinitions")
    for unit in dict.fromkeys(v.unit for v in table.variables if v.unit):
        element = ET.SubElement(definitions, "Unit", name=unit)
        ET.SubElement(element, "BaseUnit", base_exponents(unit))
        for name, factor in display_units(unit).items():
            ET.SubElement(element, "DisplayUnit", name=name, factor=repr(factor))
    return definitions


def type_definitions(
    table: VariableTable, add_type: Callable[[ET.Element, str], ET.Element]
) -> list[ET.Element]:
    """``TypeDefinitions``, made by `add_type`, as the only item of a list; empty if not needed."""
    definitions = ET.Element("TypeDefinitions")
    for variable in table.variables:
        if variable.value_names:
            enumeration = add_type(definitions, type_name(variable))
            for value, name in enumerate(variable.value_names):
                ET.SubElement(enumeration, "Item", name=name, value=str(value))
    return [definitions] if len(definitions) else []


def add_type(definitions: ET.Element, name: str) -> ET.Element:
    """Add the type of an enumeration, and return the element of its items; FMI 2.0."""
    return ET.SubElement(ET.SubElement(definitions, "SimpleType", name=name), "Enumeration")


def type_name(variable: Variable) -> str:
    """Name of the type of an enumeration."""
    # A type must not have the name of a variable.
    return f"{variable.name}_type"


def common_attributes(variable: Variable, reference: int) -> dict[str, str]:
    """Attributes of a variable that do not depend on its type, in every FMI version."""
    attributes = {
        "name": variable.name,
        "valueReference": str(reference),
        "description": variable.meaning,
        "causality": variable.role.value,
        "variability": variable.variability,
    }
    if variable.initial is not None:
        attributes["initial"] = variable.initial
    return attributes


def new_description(
    root_attributes: Mapping[str, str],
    interfaces: Mapping[str, Mapping[str, str]],
    table: VariableTable,
    types: Sequence[ET.Element],
    categories: Mapping[str, str],
) -> ET.Element:
    """A model description without variables; `categories` are log categories, described by name."""
    root = ET.Element("fmiModelDescription", dict(root_attributes))
    for interface, capabilities in interfaces.items():
        identifier = root_attributes["modelName"]
        ET.SubElement(root, interface, dict(capabilities), modelIdentifier=identifier)
    root.append(unit_definitions(table))
    root.extend(types)
    log = ET.SubElement(root, "LogCategories")
    for name, description in categories.items():
        ET.SubElement(log, "Category", name=name, description=description)
    experiment = {"startTime": 0.0, "stopTime": 100.0, "stepSize": 0.01, "tolerance": DEFAULT_TOL}
    ET.SubElement(root, "DefaultExperiment", {n: repr(v) for n, v in experiment.items()})
    return root


def set_type_attributes(element: ET.Element, variable: Variable, table: VariableTable) -> None:
    """Set type, unit, bounds, derivative and start in the child of a ``ScalarVariable``."""
    (type_element,) = element
    # pythonfmu has no enumerations and describes them as integers.
    type_element.tag = variable.type.value
    if variable.value_names:
        type_element.set("declaredType", type_name(variable))
    derivative_of = variable.derivative_of and _index_text(table, variable.derivative_of)
    for name, text in value_attributes(variable, derivative_of).items():
        type_element.set(name, text)


def value_attributes(variable: Variable, derivative_of: str) -> dict[str, str]:
    """Attributes of unit, bounds, typical size, derivative and start, in every version of FMI.

    `derivative_of` refers to the state whose derivative the variable is; empty if there is none.
    """
    attributes: dict[str, str] = {}
    if variable.unit:
        attributes |= {"unit": variable.unit, "displayUnit": variable.unit}
    if variable.unit in _CONVERTED_UNITS:
        attributes["displayUnit"] = _DISPLAY_UNITS[variable.unit][0]
    for name, bound in (("min", variable.lower), ("max", variable.upper)):
        if math.isfinite(bound):
            attributes[name] = repr(bound) if variable.type is Type.REAL else str(int(bound))
    if variable.nominal is not None:
        attributes["nominal"] = repr(variable.nominal)
    if derivative_of:
        attributes["derivative"] = derivative_of
    if variable.settable:
        is_boolean = variable.type is Type.BOOLEAN
        attributes["start"] = str(variable.start).lower() if is_boolean else repr(variable.start)
    return attributes


def _index_text(table: VariableTable, name: str) -> str:
    # FMI 2.0 refers to variables by indices that begin with 1.
    return str(table.references[name] + 1)


def model_structure(
    table: VariableTable, get_dependencies: Callable[[Variable], Sequence[str]]
) -> ET.Element:
    """``ModelStructure`` of FMI 2.0; `get_dependencies` returns the dependencies of an output."""
    structure = ET.Element("ModelStructure")
    outputs = [v for v in table.variables if v.role is Role.OUTPUT]
    derivatives = [v for v in table.variables if v.derivative_of]
    unknowns = [v for v in table.variables if v.role is Role.OUTPUT or v.derivative_of]
    _add_unknowns(structure, "Outputs", [(v, get_dependencies(v)) for v in outputs], table)
    _add_unknowns(structure, "Derivatives", [(v, v.rate_depends_on) for v in derivatives], table)
    _add_unknowns(structure, "InitialUnknowns", [(v, v.start_depends_on) for v in unknowns], table)
    return structure


def _add_unknowns(
    structure: ET.Element,
    tag: str,
    unknowns: Sequence[tuple[Variable, Sequence[str]]],
    table: VariableTable,
) -> None:
    group = ET.SubElement(structure, tag)
    for variable, names in unknowns:
        ET.SubElement(
            group,
            "Unknown",
            index=_index_text(table, variable.name),
            dependencies=" ".join(
                _index_text(table, name) for name in sorted(names, key=table.references.__getitem__)
            ),
            dependenciesKind=" ".join("dependent" for _ in names),
        )


def base_exponents(unit: str) -> dict[str, str]:
    """Exponents of the SI base units in a unit as XML attributes, without zeros.

    `unit` consists of factors separated by spaces, then divisors each after a slash; "^" precedes
    an exponent. Raises `KeyError` if a factor is not a unit of this model.
    """
    total: Counter[str] = Counter()
    numerator, *divisors = unit.split("/")
    for sign, factors in ((1, numerator.split()), (-1, divisors)):
        for factor in factors:
            name, _, power = factor.partition("^")
            for base, exponent in _BASE_EXPONENTS[name].items():
                total[base] += sign * exponent * int(power or 1)
    return {base: str(exponent) for base, exponent in total.items() if exponent}


def display_units(unit: str) -> dict[str, float]:
    """Display units of an SI unit with their factors, the SI unit itself first."""
    factors = {unit: 1.0}
    if unit in _DISPLAY_UNITS:
        display_unit, factor = _DISPLAY_UNITS[unit]
        factors[display_unit] = factor
    return factors
