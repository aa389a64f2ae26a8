"""Verdicts and maps of safe friction as JSON data and as files, with units and provenance."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.equilibrium import stability_map
from fivtui.io import Columns, Header, read_bytes, read_columns, read_header, write_table
from fivtui.model import PARAMETERS, Column, InputError, Parameters

from .map import REGIONS, SAFETY_VALUES, SafetyMap, critical_over
from .search import SearchRound
from .searched import SearchedPoint
from .verdict import OtherAttractor, SafeFriction
from .words import basis_rows, safety_words

Floats = NDArray[np.float64]

# What a file of a map is called in messages.
_KIND: Final = "map"
# What a map rests on, by which its files are told from those of maps of stability.
_BASIS: Final = "continuation"
_SAFE_MU: Final = Column("safe_mu", "", "safe friction coefficient")
_CRITICAL_MU: Final = Column("critical_mu", "", "critical friction coefficient")
_REGION: Final = Column("region", "", f"0 {REGIONS[0]}, 1 {REGIONS[1]}, 2 {REGIONS[2]}")
_ESCAPE: Final = Column("escape_offset", "m", "least displacement from rest that escapes")


def safe_friction_to_dict(found: SafeFriction) -> dict[str, Any]:
    """A verdict as JSON data, in SI units.

    Keys are ``safe_mu``, the least μ at which another attractor was found, else the critical μ,
    else None; ``safe_mu_not_known_above``, a μ where too little is known to say ``safe_mu``, else
    None; and ``safe_mu_basis`` with what was searched.
    """
    basis = found.basis
    offset = basis.proved_offset
    return {
        "safe_mu": found.safe_mu,
        "safe_mu_not_known_above": found.unknown_above,
        "safe_mu_basis": {
            "verdict": safety_words(found),
            "found_by": found.found_by,
            "statements": dict(basis_rows(found)),
            "others": [_other(one) for one in found.others],
            "coexisting": [
                {"period": one.period, "y_half_range": one.half_range} for one in found.coexisting
            ],
            "continuation": [
                {
                    "origin": one.origin,
                    "cycles": len(one.points),
                    "mu_min": min(point.value for point in one.points),
                    "mu_max": max(point.value for point in one.points),
                    "events": [
                        {"kind": str(event.kind), "mu": event.value, "period": event.period}
                        for event in one.events
                    ],
                }
                for one in basis.branches
            ],
            "global_search": {
                "searched_to": found.searched_to,
                "rounds": [_round(one) for one in basis.rounds],
                "unconfirmed_mu": [one.mu for one in found.others if one.kind == "other motion"],
                "growth_at_any_size_mu": basis.growth_at_any_size,
                "budget_ended": basis.budget_ended,
            },
            "proof": None
            if offset is None
            else {
                "mu": found.parameters.mu,
                "offset": None if math.isinf(offset) else offset,
                "everywhere": math.isinf(offset),
            },
            "cpu_s": basis.cpu_s,
        },
    }


def _other(one: OtherAttractor) -> dict[str, Any]:
    cycle = one.cycle
    return {
        "mu": one.mu,
        "kind": one.kind,
        "found_by": one.found_by,
        "period": None if cycle is None else cycle.period,
        "y_half_range": None if cycle is None else cycle.half_range,
    }


def _round(one: SearchRound) -> dict[str, Any]:
    return {
        "mu": list(one.levels),
        "starts": one.starts,
        "died_out": one.died_out,
        "settled": len(one.settled),
        "unbounded": len(one.unbounded),
        "undecided": one.undecided,
        "steps": one.steps,
    }


def _rows(values: Floats) -> list[list[float | None]]:
    return [[None if math.isnan(v) else v for v in row] for row in values.tolist()]


def safety_map_to_dict(result: SafetyMap) -> dict[str, Any]:
    """A map as JSON data.

    Keys are those of a map of stability, with ``basis``, ``safe_mu`` and ``critical_mu``; in a map
    of coexistence ``values`` are indices in ``regions``, and ``escape_offset`` is in m. Of the
    points of a global search ``searched`` has the indices, and ``confirmed_to`` the μ up to which
    it confirms the values. A value that is null where ``critical_mu`` is not is not known.
    """
    data = {
        **_provenance(result),
        "over": [
            {"name": name, "unit": PARAMETERS[name].unit, "values": axis.tolist()}
            for name, axis in zip(result.names, result.axes, strict=True)
        ],
        "value": result.value,
        "unit": "",
        "values": _rows(result.values),
        "critical_mu": _rows(result.critical_mu),
    }
    if result.escape is not None:
        data |= {
            "safe_mu": _rows(result.safe_mu),
            "regions": list(REGIONS),
            "escape_offset": _rows(result.escape),
        }
    return data


def safety_map_columns(result: SafetyMap) -> dict[str, Floats]:
    """The points of a map by column, the second parameter varying fastest."""
    first, second = np.meshgrid(*result.axes, indexing="ij")
    columns = dict(zip(result.names, (first.ravel(), second.ravel()), strict=True))
    columns |= {"safe_mu": result.safe_mu.ravel(), "critical_mu": result.critical_mu.ravel()}
    if result.escape is not None:
        columns |= {"region": result.regions.ravel(), "escape_offset": result.escape.ravel()}
    return columns


def save_safety_map(result: SafetyMap, path: Path, *, force: bool = False) -> None:
    """Write a map: one row per point, the second parameter varying fastest, ``nan`` for no value.

    Raises `InputError` if the format is unknown or the file cannot be written.
    """
    specs = [PARAMETERS[name] for name in result.names]
    columns = [Column(spec.name, spec.unit, spec.meaning) for spec in specs]
    columns += [_SAFE_MU, _CRITICAL_MU]
    if result.escape is not None:
        columns += [_REGION, _ESCAPE]
    header = _provenance(result)
    write_table(path, _KIND, columns, safety_map_columns(result), header, force=force)


def load_safety_map(path: Path) -> SafetyMap:
    """Read a map from a file of `save_safety_map`, or from JSON.

    Critical μ and stability are computed anew. Raises `InputError` if the file is not a map.
    """
    plain = path.suffix.lower() == ".json"
    content = read_bytes(path) if plain else b""
    columns, said = ({}, {}) if plain else (read_columns(path, _KIND), read_header(path, _KIND))
    try:
        return _from_dict(json.loads(content)) if plain else _from_columns(columns, said)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise InputError(f"{path}: not a map, or damaged") from None


def is_safety_map(path: Path) -> bool:
    """Whether a file of a map is one of safe friction."""
    if path.suffix.lower() == ".json":
        return "basis" in json.loads(read_bytes(path))
    return "basis" in read_header(path, _KIND)


def _from_dict(data: Mapping[str, Any]) -> SafetyMap:
    over = {str(axis["name"]): np.array(axis["values"], dtype=float) for axis in data["over"]}
    escape = data.get("escape_offset")
    safe = data["values"] if escape is None else data["safe_mu"]
    return _map(over, np.array(safe, dtype=float), _numbers(escape), data)


def _numbers(rows: list[list[float | None]] | None) -> Floats | None:
    return None if rows is None else np.array(rows, dtype=float)


def _from_columns(columns: Columns, said: Header) -> SafetyMap:
    first, second = list(columns)[:2]
    size = int(np.argmax(columns[first] != columns[first][0])) or columns[first].size
    shape = (columns[first].size // size, size)
    rows, line = columns[first].reshape(shape), columns[second].reshape(shape)
    if not (np.all(rows == rows[:, :1]) and np.all(line == line[:1])):
        raise InputError("the points do not form a grid")
    escape = columns.get("escape_offset")
    over = {first: rows[:, 0], second: line[0]}
    offsets = None if escape is None else escape.reshape(shape)
    return _map(over, columns["safe_mu"].reshape(shape), offsets, said)


def _map(
    over: Mapping[str, Floats], safe: Floats, escape: Floats | None, said: Mapping[str, Any]
) -> SafetyMap:
    p = Parameters().with_values(said["parameters"])
    plain = stability_map(p, over, "unstable-modes", separation=bool(said["separation"]))
    if safe.shape != plain.excess.shape:
        raise InputError(f"{safe.shape} values for {plain.excess.shape} points")
    return SafetyMap(
        system=plain.system,
        names=plain.names,
        axes=plain.axes,
        value=SAFETY_VALUES[0 if escape is None else 1],
        safe_mu=safe,
        critical_mu=critical_over(plain),
        excess=plain.excess,
        escape=escape,
        searched=tuple(
            SearchedPoint(tuple(map(int, place)), float(limit))
            for place, limit in zip(
                said.get("searched", ()), said.get("confirmed_to", ()), strict=True
            )
        ),
    )


def _provenance(result: SafetyMap) -> dict[str, Any]:
    fixed = {k: v for k, v in result.parameters.as_dict().items() if k not in result.names}
    return {
        "parameters": fixed,
        "separation": result.separation,
        "basis": _BASIS,
        "searched": [list(point.place) for point in result.searched],
        "confirmed_to": [point.limit for point in result.searched],
    }
