"""Limit cycles in files: branches, stored without loss and read, and attractors as JSON."""

import json
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from fivtui.io import FORMATS, output_path, read_bytes, read_columns, read_header, save_json
from fivtui.model import ALL_PARAMETERS, InputError, Parameters, State, System
from fivtui.results import from_data, read_result
from fivtui.transient import START_SPECS

from .events import End
from .result import BranchEvent, CycleBranch, CyclePoint, Origin

# Key in stored branches: the value of the varied parameter in the parameter set, which is not among
# the stored `parameters`.
_SET_VALUE_KEY: Final = "own_value"
# Kind of file that messages name.
_FILE_KIND: Final = "branch"
_JSON: Final = ".json"


def store_branch(result: CycleBranch, path: Path) -> None:
    """Write a branch without loss as JSON; replaces an existing file."""
    value = result.parameters.as_dict()[result.name]
    save_json({**result.to_dict(), _SET_VALUE_KEY: value}, output_path(path, force=True))


def restore_branch(path: Path) -> CycleBranch:
    """Read a branch from JSON, stored or printed by ``fivtui branch --json``.

    Printed branches lack the parameter set's value of the parameter that varies; the value of the
    first point replaces it. Raises `InputError` for a table, or if the file is damaged.
    """
    return read_result(path, CycleBranch.data_name, _branch_from_data)


def _branch_from_data(data: Mapping[str, Any]) -> CycleBranch:
    name = str(data["parameter"])
    points = from_data(data["points"], tuple[CyclePoint, ...])
    value = data.get(_SET_VALUE_KEY, points[0].value)
    p = Parameters().with_values({**data["parameters"], name: value})
    low, high = from_data(data["range"], tuple[float, float])
    return CycleBranch(
        System(p, bool(data["separation"])),
        name,
        low,
        high,
        from_data(data["from"], Origin),
        points,
        from_data(data["events"], tuple[BranchEvent, ...]),
        from_data(data["ends"], tuple[End, End]),
        bool(data["doubled"]),
    )


class _SavedCycles(NamedTuple):
    # Parameters that do not vary; empty in files of attractors.
    fixed: Mapping[str, float]
    # The parameter that varies, and whether separation was considered; None in files of attractors.
    name: str | None
    separation: bool | None
    # Value of the varied parameter, a state of the cycle, and its period.
    cycles: Sequence[tuple[float, State, float]]


def read_cycle(path: Path, system: System) -> tuple[State, float]:
    """Read a limit cycle of a system from a file: a state near the cycle, and its period."""
    suffix, suffixes = path.suffix.lower(), (*FORMATS, _JSON)
    if suffix not in suffixes:
        raise InputError(f"{path}: the suffix must be one of {', '.join(suffixes)}")
    saved = _read_json(path) if suffix == _JSON else _read_table(path)
    _check_same_system(saved, system, path)
    if saved.name is None:
        _, state, period = saved.cycles[0]
        return state, period
    value = getattr(system.parameters, saved.name)
    values = [cycle_value for cycle_value, _, _ in saved.cycles]
    for (begin, end), (first, second) in zip(pairwise(values), pairwise(saved.cycles), strict=True):
        if (begin - value) * (end - value) <= 0.0:
            return interpolate_cycle(first, second, value)
    raise InputError(
        f"{saved.name} = {value:g}: must be from {min(values):g} to {max(values):g}, where {path} "
        "has cycles"
    )


def _check_same_system(saved: _SavedCycles, system: System, path: Path) -> None:
    # Raise `InputError` unless a file has cycles of a system, apart from the varied parameter.
    values = system.parameters.as_dict()
    # Files of attractors have no parameters to compare.
    names = {**values, **saved.fixed} if saved.fixed else {}
    for name in names:
        if name != saved.name and saved.fixed.get(name) != values.get(name):
            value_of_set, value_in_file = (
                _value_text(parameters.get(name)) for parameters in (values, saved.fixed)
            )
            raise InputError(f"{name} = {value_of_set}: must be {value_in_file}, as in {path}")
    if saved.separation is not None and saved.separation != system.separation:
        required = "considered" if saved.separation else "ignored"
        raise InputError(f"separation: must be {required}, as in {path}")


def interpolate_cycle(
    begin: tuple[float, State, float], end: tuple[float, State, float], value: float
) -> tuple[State, float]:
    """State and period at a value of the parameter, linear between two cycles."""
    share = (value - begin[0]) / (end[0] - begin[0]) if end[0] != begin[0] else 0.0
    first, second = (np.array([*state, period]) for _, state, period in (begin, end))
    x, vx, y, vy, period = (first + share * (second - first)).tolist()
    return (x, vx, y, vy), period


def _value_text(value: float | None) -> str:
    return "none" if value is None else f"{value:g}"


def _read_table(path: Path) -> _SavedCycles:
    header = read_header(path, _FILE_KIND)
    # Of all tables only those of branches have this key.
    if "event_kinds" not in header:
        raise InputError(f"{path}: must be a branch of limit cycles")
    fixed = header["parameters"]
    columns = read_columns(path, _FILE_KIND)
    name = next(name for name in columns if name in ALL_PARAMETERS)
    # The columns x0, vx0, y0 and vy0.
    states = np.stack([columns[start_name] for start_name in START_SPECS], axis=1).tolist()
    cycles = [
        (value, (x, vx, y, vy), period)
        for value, (x, vx, y, vy), period in zip(
            columns[name].tolist(), states, columns["period"].tolist(), strict=True
        )
    ]
    return _SavedCycles(fixed, name, bool(header["separation"]), cycles)


def _read_json(path: Path) -> _SavedCycles:
    try:
        data = json.loads(read_bytes(path))
        return _cycles_from_json(data)
    except (ValueError, RecursionError, TypeError, KeyError, IndexError, AttributeError):
        raise InputError(f"{path}: must have limit cycles, as branch or attractor") from None


def _cycles_from_json(data: Any) -> _SavedCycles:
    if "parameter" in data:
        cycles = [(float(cycle["value"]), *_cycle_from_json(cycle)) for cycle in data["points"]]
        return _SavedCycles(data["parameters"], data["parameter"], data["separation"], cycles)
    attractors = data.get("attractors", [data])
    # Attractors without a period are no limit cycles. Unpacking fails if there is no cycle.
    (state, period), *_ = [_cycle_from_json(cycle) for cycle in attractors if "period" in cycle]
    # No parameter varies: its value 0 is not used.
    return _SavedCycles({}, None, None, [(0.0, state, period)])


def _cycle_from_json(data: Any) -> tuple[State, float]:
    x, vx, y, vy = map(float, data["start"])
    return (x, vx, y, vy), float(data["period"])
