"""Read maps from tables and from JSON."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fivtui.io import Columns, Header
from fivtui.model import InputError, Parameters
from fivtui.results import axes_from_data, read_result, split_grid

from .result import COLUMNS, MAP_VALUES, SHOWN_COLUMN, FloatArray, StabilityMap
from .searched_points import SearchedPoint
from .stability import parse_map_value, stability_map


def load_map(path: Path) -> StabilityMap:
    """Read a map from a table, or from the JSON that ``fivtui map --json`` prints.

    The stability boundary is computed anew. Raises `InputError` if the file is not a map.
    """
    return read_result(path, StabilityMap.data_name, _from_data, _from_table)


def _from_data(data: Mapping[str, Any]) -> StabilityMap:
    value = parse_map_value(str(data["value"]), MAP_VALUES)
    arrays = {name: data[name] for name in COLUMNS if name in data}
    arrays[SHOWN_COLUMN[value]] = data["values"]
    quantities = {name: np.array(rows, dtype=float) for name, rows in arrays.items()}
    return _build_map(axes_from_data(data["over"]), value, quantities, data)


def _from_table(columns: Columns, header: Header) -> StabilityMap:
    over, quantities = split_grid(columns)
    # The mapped value is the last of `MAP_VALUES` whose column the table has. A table of safe μ has
    # the critical μ as well, and a table of coexistence has both of them.
    values = [value for value in MAP_VALUES if SHOWN_COLUMN[value] in quantities]
    return _build_map(over, values[-1], quantities, header)


def _build_map(
    over: Mapping[str, FloatArray],
    value: str,
    quantities: Mapping[str, FloatArray],
    header: Mapping[str, Any],
) -> StabilityMap:
    p = Parameters().with_values(header["parameters"])
    linear = stability_map(p, over, "unstable-modes", separation=bool(header["separation"]))
    for array in quantities.values():
        if array.shape != linear.grid.shape:
            raise InputError(f"{array.shape} values for {linear.grid.shape} points")
    # Points of global searches, and the μ up to which each search confirms safe μ.
    points = zip(header.get("searched", ()), header.get("confirmed_to", ()), strict=True)
    return replace(
        linear,
        value=parse_map_value(value, MAP_VALUES),
        quantities={name: quantities[name] for name in COLUMNS if name in quantities},
        searched=tuple(
            SearchedPoint(tuple(map(int, indices)), float(limit)) for indices, limit in points
        ),
    )
