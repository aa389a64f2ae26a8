"""Stability maps as plain data and in files, with units and provenance."""

from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np

from . import __version__
from .core.columns import Column
from .core.parameters import PARAMETERS
from .core.stability_map import StabilityMap
from .files import write_atomically
from .formats import columns_format

# Name of the column in files, unit and meaning of every value of a map.
MAP_COLUMNS: Final = {
    "growth-rate": Column("growth_rate", "1/s", "growth rate"),
    "critical-mu": Column("critical_mu", "", "critical friction coefficient"),
    "unstable-modes": Column("unstable_modes", "", "unstable modes"),
}


def map_to_dict(result: StabilityMap) -> dict[str, Any]:
    """A stability map as data that JSON can hold.

    Parameters
    ----------
    result : StabilityMap
        The map.

    Returns
    -------
    dict
        ``parameters`` (those that do not vary), ``separation``, ``over`` (name, unit and values of
        the two that do), ``value``, ``unit``, and ``values``: a list for every value of the first
        parameter, None where there is no value.
    """
    column = MAP_COLUMNS[result.value]
    rows = [[None if np.isnan(v) else v for v in row] for row in result.values.tolist()]
    return {
        **_provenance(result),
        "over": [
            {"name": name, "unit": PARAMETERS[name].unit, "values": axis.tolist()}
            for name, axis in zip(result.names, result.axes, strict=True)
        ],
        "value": result.value,
        "unit": column.unit,
        "values": rows,
    }


def save_map(result: StabilityMap, path: Path, *, force: bool = False) -> None:
    """Write a map: a row a point, the second parameter varying fastest, ``nan`` for no value.

    Parameters
    ----------
    result : StabilityMap
        The map.
    path : Path
        The file; its suffix ``.csv``, ``.npz`` or ``.parquet`` says the format.
    force : bool
        Whether a file that exists may be replaced.

    Raises
    ------
    InputError
        If the format is unknown or needs a package that is not installed, or the file cannot be
        written.
    """
    form = columns_format(path, "map")
    value = MAP_COLUMNS[result.value]
    specs = [PARAMETERS[name] for name in result.names]
    columns = [*(Column(spec.name, spec.unit, spec.meaning) for spec in specs), value]
    first, second = np.meshgrid(*result.axes, indexing="ij")
    arrays = (first.ravel(), second.ravel(), result.values.ravel())
    values = {column.name: array for column, array in zip(columns, arrays, strict=True)}
    provenance = {"fivtui": __version__, **_provenance(result)}

    def write(file: BinaryIO) -> None:
        form.write(file, columns, values, provenance)

    write_atomically(path, write, force=force)


def _provenance(result: StabilityMap) -> dict[str, Any]:
    fixed = {k: v for k, v in result.parameters.as_dict().items() if k not in result.names}
    return {"parameters": fixed, "separation": result.separation}
