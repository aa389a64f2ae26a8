"""Modes, maps and stability as JSON data and as files, with units and provenance."""

import json
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.io import (
    Columns,
    Header,
    check_finite,
    read_bytes,
    read_columns,
    read_header,
    write_table,
)
from fivtui.model import ALL_PARAMETERS, PARAMETERS, Column, InputError, Parameters

from .eigenvalues import Stability
from .map import StabilityMap, stability_map
from .modes import VibrationMode
from .scan import ModeScan, mode_scan, scan_top

_EIGENVALUES: Final = 4


def modes_over_mu(found: Stability) -> ModeScan:
    """Eigenvalues over evenly spaced μ, from 0 to beyond μ and every critical one.

    Raises `ComputationError` if there is no equilibrium at one of them.
    """
    return mode_scan(found.system, scan_top(found))


def save_modes(found: Stability, scan: ModeScan, path: Path, *, force: bool = False) -> None:
    """Write the eigenvalues over μ as ``.csv``, ``.npz`` or ``.parquet``.

    Columns are ``mu``, and ``sigma_1``, ``omega_1`` to ``sigma_4``, ``omega_4``: real and imaginary
    parts. Raises `InputError` if the format is unknown or its package missing, or the file cannot
    be written.
    """
    mu = PARAMETERS["mu"]
    columns = [Column("mu", mu.unit, mu.meaning)]
    for number in range(1, _EIGENVALUES + 1):
        columns.append(Column(f"sigma_{number}", "1/s", f"real part of eigenvalue {number}"))
        columns.append(Column(f"omega_{number}", "rad/s", f"imaginary part of eigenvalue {number}"))
    header = {
        "parameters": found.parameters.as_dict(),
        "separation": found.separation,
        "critical_mu": [critical.mu for critical in found.critical_mu],
    }
    write_table(path, "table of modes", columns, scan.to_columns(), header, force=force)


FloatArray = NDArray[np.float64]

# Column of every quantity of a map.
MAP_COLUMNS: Final = {
    "growth-rate": Column("growth_rate", "1/s", "growth rate"),
    "critical-mu": Column("critical_mu", "", "critical friction coefficient"),
    "unstable-modes": Column("unstable_modes", "", "unstable modes"),
}


def map_to_dict(result: StabilityMap) -> dict[str, Any]:
    """A stability map as JSON data.

    Keys are ``parameters`` (those that do not vary), ``separation``, ``over`` (name, unit and
    values of the two that do), ``value``, ``unit``, and ``values``: one list for every value of the
    first parameter, None where there is no value.
    """
    column = MAP_COLUMNS[result.value]
    rows = [[None if np.isnan(v) else v for v in row] for row in result.values.tolist()]
    return {
        **_provenance(result),
        "over": [
            {"name": name, "unit": ALL_PARAMETERS[name].unit, "values": axis.tolist()}
            for name, axis in zip(result.names, result.axes, strict=True)
        ],
        "value": result.value,
        "unit": column.unit,
        "values": rows,
    }


def map_columns(result: StabilityMap) -> dict[str, FloatArray]:
    """The points of a map by column, the second parameter varying fastest."""
    first, second = np.meshgrid(*result.axes, indexing="ij")
    names = (*result.names, MAP_COLUMNS[result.value].name)
    arrays = (first.ravel(), second.ravel(), result.values.ravel())
    return dict(zip(names, arrays, strict=True))


def save_map(result: StabilityMap, path: Path, *, force: bool = False) -> None:
    """Write a map: one row per point, the second parameter varying fastest, ``nan`` for no value.

    Raises `InputError` if the format is unknown or the file cannot be written; see `save_modes`.
    """
    value = MAP_COLUMNS[result.value]
    specs = [ALL_PARAMETERS[name] for name in result.names]
    columns = [*(Column(spec.name, spec.unit, spec.meaning) for spec in specs), value]
    write_table(path, "map", columns, map_columns(result), _provenance(result), force=force)


def load_map(path: Path) -> StabilityMap:
    """Read a map from a file of `save_map`, or from the JSON that ``fivtui map --json`` prints.

    The stability boundary is computed anew. Raises `InputError` if the file is not a map.
    """
    plain = path.suffix.lower() == ".json"
    content = read_bytes(path) if plain else b""
    values, said = ({}, {}) if plain else (read_columns(path, "map"), read_header(path, "map"))
    try:
        return _from_dict(json.loads(content)) if plain else _from_columns(values, said)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise InputError(f"{path}: not a map, or damaged") from None


def _from_dict(data: Mapping[str, Any]) -> StabilityMap:
    (first, rows), (second, columns) = (
        (str(axis["name"]), np.array(axis["values"], dtype=float)) for axis in data["over"]
    )
    values = np.array(data["values"], dtype=float)
    return _map((first, rows), (second, columns), str(data["value"]), values, data)


def _from_columns(columns: Columns, said: Header) -> StabilityMap:
    first, second, last = columns
    value = {column.name: name for name, column in MAP_COLUMNS.items()}[last]
    size = int(np.argmax(columns[first] != columns[first][0])) or columns[first].size
    shape = (columns[first].size // size, size)
    rows, line = columns[first].reshape(shape), columns[second].reshape(shape)
    if not (np.all(rows == rows[:, :1]) and np.all(line == line[:1])):
        raise InputError("the points do not form a grid")
    values = columns[last].reshape(shape)
    return _map((first, rows[:, 0]), (second, line[0]), value, values, said)


def _map(
    rows: tuple[str, FloatArray],
    columns: tuple[str, FloatArray],
    value: str,
    values: FloatArray,
    said: Mapping[str, Any],
) -> StabilityMap:
    p = Parameters().with_values(said["parameters"])
    computed = stability_map(p, dict((rows, columns)), value, separation=bool(said["separation"]))
    if values.shape != computed.values.shape:
        raise InputError(f"{values.shape} values for {computed.values.shape} points")
    return replace(computed, values=values)


def _provenance(result: StabilityMap) -> dict[str, Any]:
    fixed = {k: v for k, v in result.parameters.as_dict().items() if k not in result.names}
    return {"parameters": fixed, "separation": result.separation}


def stability_to_dict(stability: Stability) -> dict[str, Any]:
    """A stability analysis as JSON data, in SI units.

    Keys are ``equilibrium``, ``eigenvalues`` as pairs of real and imaginary part, ``growth_rate``,
    ``stable``, ``critical_mu``, ``critical_speed``, ``linear_critical_mu``, ``modes``, ``margin``
    and ``coalescence``; frequencies in Hz, angular frequencies in rad/s. Raises `ComputationError`
    if a number is not finite.
    """
    point = stability.equilibrium
    data = {
        "equilibrium": {"x": point.x, "y": point.y, "P": point.P},
        "eigenvalues": [[value.real, value.imag] for value in stability.eigenvalues.tolist()],
        "growth_rate": stability.growth_rate,
        "stable": stability.stable,
        "critical_mu": [asdict(critical) for critical in stability.critical_mu],
        "critical_speed": [asdict(critical) for critical in stability.critical_speed],
        "linear_critical_mu": stability.linear_critical_mu,
        "modes": [_mode_to_dict(mode) for mode in stability.modes],
        "margin": asdict(stability.margin),
        "coalescence": asdict(stability.coalescence),
    }
    check_finite(data, "", "use parameters of less extreme size")
    return data


def _mode_to_dict(mode: VibrationMode) -> dict[str, Any]:
    x, y = mode.shape
    return {
        "frequency": mode.frequency,
        "angular_frequency": mode.angular_frequency,
        "growth_rate": mode.growth_rate,
        "damping_ratio": mode.damping_ratio,
        "shape": {"x": [x.real, x.imag], "y": [y.real, y.imag]},
    }
