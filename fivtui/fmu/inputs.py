"""Checked inputs of an FMU run: start values, and inputs over time from a CSV file."""

import math
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.io import read_csv
from fivtui.model import InputError, Interval, check_known, unknown_name_error

from .instance import FmuFile

TIME: Final = "time"
NON_NUMERIC_TYPES: Final = ("String", "Binary")
# Variables of the slider-belt FMU: the belt's speed, and the flag that enables it.
_BELT_SPEED: Final = "v_belt"
_FINITE_BELT: Final = "finite_belt"
# Texts of Boolean values.
_BOOLEANS: Final = {"true": True, "1": True, "false": False, "0": False}


def check_start_values(fmu: FmuFile, start_values: Mapping[str, object]) -> dict[str, Any]:
    """Check start values against the model description; return them in the types of the variables.

    Raises `InputError` if a name is unknown or a value out of range.
    """
    settable = {
        v.name: v
        for v in fmu.description.modelVariables
        if v.causality in ("parameter", "structuralParameter", "input")
        or (v.initial in ("exact", "approx") and v.variability != "constant")
    }
    values = {}
    for name, value in start_values.items():
        check_known("variable to be set", name, settable)
        values[name] = _check_start_value(settable[name], value)
    return values


def _check_start_value(variable: Any, value: object) -> Any:
    if variable.type == "Boolean":
        boolean = _BOOLEANS.get(str(value).strip().lower())
        if boolean is None:
            raise InputError(f"{variable.name} = {value}: must be true or false")
        return boolean
    if variable.type in NON_NUMERIC_TYPES or variable.shape:
        return value
    lower, upper = (
        float(limit) if limit is not None else bound
        for limit, bound in ((variable.min, -math.inf), (variable.max, math.inf))
    )
    number = Interval(lower, upper, variable.unit or "").check(variable.name, value)
    if variable.type in ("Real", "Float32", "Float64"):
        return number
    if not number.is_integer():
        raise InputError(f"{variable.name} = {number:g}: must be a whole number")
    return int(number)


def enable_belt_speed(
    fmu: FmuFile, start_values: Mapping[str, Any], columns: Collection[str]
) -> dict[str, Any]:
    """Add the flag of a finite belt speed to the start values if a belt speed is set.

    `columns` are the inputs that follow a table. If the FMU has no such flag, nothing is added.
    """
    names = {v.name for v in fmu.description.modelVariables}
    sets_speed = _BELT_SPEED in start_values or _BELT_SPEED in columns
    flag = {_FINITE_BELT: True} if sets_speed and _FINITE_BELT in names else {}
    return {**flag, **start_values}


def read_signals(
    fmu: FmuFile, path: Path, start_values: Mapping[str, Any]
) -> tuple[NDArray[Any], set[str]]:
    """Read values of inputs over time from a CSV file with a column ``time``, s.

    Inputs without a column keep their start value. Returns a structured array with ``time`` and all
    scalar inputs in every row, and the names of the columns in the file. Raises `InputError` if the
    file is not such a table, or a value is out of range.
    """
    inputs = {
        v.name: v
        for v in fmu.description.modelVariables
        if v.causality == "input" and v.type not in NON_NUMERIC_TYPES and not v.shape
    }
    table = _read_table(path)
    for name in table:
        if name != TIME and name not in inputs:
            raise unknown_name_error(f"input in {path}:", name, inputs)
    if TIME not in table:
        raise InputError(f"{path}: there is no column {TIME}")
    if np.any(np.diff(table[TIME]) < 0.0):
        raise InputError(f"{path}: the times must ascend")
    csv_columns = set(table)
    column_types: list[tuple[str, type]] = [(TIME, float)]
    for name, variable in inputs.items():
        if name not in table:
            value = start_values.get(name, variable.start)
            table[name] = np.full(table[TIME].size, float(_check_start_value(variable, value or 0)))
        elif variable.type != "Boolean":
            for extreme in (table[name].min(), table[name].max()):
                _check_start_value(variable, float(extreme))
        column_types.append((name, bool if variable.type == "Boolean" else float))
    signals = np.empty(table[TIME].size, dtype=column_types)
    for name, _ in column_types:
        signals[name] = table[name]
    return signals, csv_columns


def _read_table(path: Path) -> dict[str, NDArray[Any]]:
    table = read_csv(path)
    if not table or not next(iter(table.values())).size:
        raise InputError(f"{path}: must have a row of column names and at least one row of numbers")
    for name, values in table.items():
        for number in values[~np.isfinite(values)]:
            raise InputError(f"{path}: {name} = {number:g}: not a finite number")
    return table
