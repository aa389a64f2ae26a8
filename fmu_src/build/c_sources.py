"""The C files of the native FMUs, and the tables of variables generated for them.

A unit is the name of a C file without its suffix. The build hook imports this module, so it imports
only the standard library.
"""

import hashlib
import uuid
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from fivtui.kernel import equation_headers
from fivtui.model import ALL_PARAMETERS
from fmu_src.slave import ACTUATOR_TABLE, SLIDER_BELT_TABLE, Type, Variable, VariableTable

# Tables of variables by model identifier, which is also the name of the binary.
MODELS: Final[Mapping[str, VariableTable]] = {
    "SliderBelt": SLIDER_BELT_TABLE,
    "BrakeActuator": ACTUATOR_TABLE,
}
# Units of each model besides the shared ones; the first is the model itself.
UNITS: Final[Mapping[str, tuple[str, ...]]] = {
    # "processor" chooses between builds of the stepping unit by what the processor can do.
    "SliderBelt": ("slider_belt", "processor"),
    "BrakeActuator": ("brake_actuator",),
}
SHARED_UNITS: Final = (
    *("cosimulation", "derivatives", "exchange", "experiment", "instance", "state", "values"),
    *("fmi3", "fmi3_values", "fmi3_absent", "intermediate"),
)
# Unit that computes the Taylor steps. It is compiled once for each instruction set, and the unit
# ``processor`` chooses what the processor supports.
STEPPING_UNIT: Final = "stepping"
_PACKAGE_FOLDER: Final = Path(__file__).parents[1]
# Folders of the C files: the FMI functions, and the kernel.
NATIVE: Final = _PACKAGE_FOLDER / "native"
KERNEL: Final = _PACKAGE_FOLDER.parent / "fivtui" / "kernel"
# Length of the hash of the sources, BUILD in ``state.c``.
_HASH_DIGITS: Final = 32
# Greatest order of derivatives of outputs by time.
OUTPUT_DERIVATIVE_ORDER: Final = 3
_C_KINDS: Final = {
    Type.REAL: "REAL",
    Type.INTEGER: "INTEGER",
    Type.ENUMERATION: "INTEGER",
    Type.BOOLEAN: "BOOLEAN",
}


def sources(model: str) -> dict[str, str]:
    """All C files of the binary of a model, by file name."""
    other_units = {unit for name, units in UNITS.items() if name != model for unit in units}
    other_files = {f"{unit}{end}" for unit in other_units for end in (".c", "_table.h")}
    texts = {**_all_sources(), **generated_files()}
    return {name: text for name, text in sorted(texts.items()) if name not in other_files}


def _all_sources() -> dict[str, str]:
    # All C files of all models, except ``build.h``, which has their hash.
    files = [*NATIVE.glob("*.[ch]"), *KERNEL.glob("*.h")]
    texts = {file.name: file.read_text(encoding="utf-8") for file in files}
    for model, table in MODELS.items():
        texts[f"{UNITS[model][0]}_table.h"] = _table_header(table)
    texts |= equation_headers()
    return dict(sorted(texts.items()))


def generated_files() -> dict[str, str]:
    """Generated files: tables of variables, model equations, and identifiers of the build."""
    names = {"BUILD_NAME": sources_hash()}
    names |= {f"{units[0].upper()}_GUID": model_guid(model) for model, units in UNITS.items()}
    lines = [f'#define {name} "{value}"\n' for name, value in names.items()]
    comment = "/* Identifiers of the sources that the binaries are compiled from. */\n\n"
    texts = {name: text for name, text in _all_sources().items() if name.endswith("_table.h")}
    texts |= equation_headers()
    return {**texts, "build.h": comment + "".join(lines)}


def reproducible_options(library: str) -> list[str]:
    """Options of zig's linker by which two links of a library give the same bytes."""
    if library.endswith(".dylib"):
        # Otherwise its name contains its build folder.
        return [f"-Wl,-install_name,@rpath/{library}"]
    # Otherwise it contains the time.
    return ["-Wl,-Brepro"] if library.endswith(".dll") else []


def sources_hash() -> str:
    """A hash of the C sources: binaries and saved states from other sources are refused."""
    content = "\0".join(f"{name}\0{text}" for name, text in _all_sources().items())
    return hashlib.sha256(content.encode()).hexdigest()[:_HASH_DIGITS]


def model_guid(model: str) -> str:
    """The GUID of a model's FMU, which depends on the sources alone."""
    return f"{{{uuid.uuid5(uuid.NAMESPACE_OID, f'{model} {sources_hash()}')}}}"


def _table_header(table: VariableTable) -> str:
    names = [f"    V_{variable.name}," for variable in table.variables]
    rows = [_table_row(variable) for variable in table.variables]
    return "\n".join(
        (
            "/* Generated from the table of variables in fmu_src/slave. */",
            "",
            '#include "component.h"',
            "",
            "enum {",
            *names,
            "    VARIABLE_COUNT",
            "};",
            "",
            f"enum {{ OUTPUT_DERIVATIVE_ORDER = {OUTPUT_DERIVATIVE_ORDER} }};",
            "",
            *_parameter_references(table),
            "static const Variable TABLE[VARIABLE_COUNT] = {",
            *rows,
            "};",
            "",
        )
    )


def _parameter_references(table: VariableTable) -> list[str]:
    # The value references of the kernel's parameters, in its order, as a C array.
    names = {variable.name for variable in table.variables}
    if not names.issuperset(ALL_PARAMETERS):
        return []
    columns = ", ".join(f"V_{name}" for name in ALL_PARAMETERS)
    return [f"static const uint32_t PARAMETER_REFERENCES[] = {{{columns}}};", ""]


def _table_row(v: Variable) -> str:
    # The fields of `Variable` in ``component.h``.
    numbers = [_c_number(value) for value in (v.start, v.lower, v.upper)]
    flags = (str(int(v.variability == "continuous")), str(int(v.total)))
    role = "TUNABLE" if v.tunable else v.role.name
    fields = (f'"{v.name}"', _C_KINDS[v.type], role, *numbers, f'"{v.range_text}"')
    return f"    {{{', '.join((*fields, _c_number(v.nominal or 1.0), *flags))}}},"


def _c_number(value: float) -> str:
    number = float(value)
    if number in (float("inf"), float("-inf")):
        return "__builtin_inf()" if number > 0.0 else "-__builtin_inf()"
    return repr(number)
