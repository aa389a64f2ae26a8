"""Convert trade-offs to JSON and CSV, and read them.

A row is a setting of a method with its measured error and CPU time.
"""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from fivtui.io import Columns, Header, check_suffix, save_csv
from fivtui.model import Column, Parameters
from fivtui.results import Table, read_result, to_data
from fivtui.scene import Scene
from fivtui.transient import QUANTITIES, Deviation
from fivtui.version import __version__

from .measure import Feature, Tradeoff
from .settings import MeasuredSetting, Setting, cheapest, pareto_front

_KIND: Final = "trade-off"
_TEXT_COLUMNS: Final = ("method", "kernel", "setting", "failure", "pareto")
_UNITS: Final = {"cpu_s": "s", "error_events": "s"}


def tradeoff_to_dict(result: Tradeoff) -> dict[str, Any]:
    """Convert a trade-off to data for JSON; null where there is no value.

    Keys of the scene: ``parameters``, ``separation`` (whether the slider may leave the belt),
    ``start`` and ``t_end``. ``floor`` has the uncertainty of the reference run by quantity.

    ``rows`` have ``method``, ``kernel`` (compiled or interpreted code, if the method has both),
    ``setting``, ``cpu_s``, ``steps`` and ``failure``. Errors are ``error_final``, ``error_peak``,
    ``error_half_range`` and ``error_events`` (s). ``separations`` and, on a belt of finite speed,
    ``sticks`` are their numbers less those of the reference. ``pareto`` lists the quantities for
    which the row is on the Pareto front.

    ``features`` have CPU times and steps of runs with and without a feature, such as separation.
    With error targets also ``cheapest``, a list of ``quantity``, ``error`` and ``row`` (null if no
    row reached the target).
    """
    start, rows = result.scene.start, _rows(result)
    data = {
        "parameters": result.scene.parameters.as_dict(),
        "separation": result.scene.separation,
        "start": start if isinstance(start, str) else list(start),
        "t_end": result.scene.t_end,
        "floor": {name: _finite_or_none(result.floor.of(name)) for name in QUANTITIES},
        "rows": rows,
        "features": to_data(result.features),
    }
    if result.targets:
        rows_by_setting: dict[Any, Any] = dict(zip(result.rows, rows, strict=True))
        data["cheapest"] = [
            {
                "quantity": quantity,
                "error": error,
                "row": rows_by_setting.get(cheapest(result.rows, quantity, error)),
            }
            for quantity, error in result.targets.items()
        ]
    return data


def tradeoff_table(result: Tradeoff) -> Table:
    """The measured settings as a table; NaN or empty text where there is no value."""
    rows = _rows(result)
    columns = {name: [row[name] for row in rows] for name in rows[0]}
    columns["pareto"] = [" ".join(names) for names in columns["pareto"]]
    return {
        Column(name, _UNITS.get(name, ""), ""): np.array(
            [value or "" for value in values], dtype=str
        )
        if name in _TEXT_COLUMNS
        else np.array(values, dtype=np.int64 if name == "steps" else np.float64)
        for name, values in columns.items()
    }


def pareto_fronts(result: Tradeoff) -> dict[str, list[MeasuredSetting]]:
    """The Pareto front of each quantity, see `pareto_front`."""
    return {name: pareto_front(result.rows, name, result.floor.of(name)) for name in QUANTITIES}


def _rows(result: Tradeoff) -> list[dict[str, Any]]:
    # The measured settings as data for JSON.
    fronts, has_belt = pareto_fronts(result), result.scene.parameters.v_belt is not None
    return [
        {
            "method": row.setting.method,
            "kernel": row.setting.kernel or None,
            "setting": row.setting.text,
            "cpu_s": row.cpu_s,
            "steps": row.steps,
            **{f"error_{name}": _error(row, name) for name in QUANTITIES},
            "separations": None if row.error is None else row.error.separations,
            **({"sticks": None if row.error is None else row.error.sticks} if has_belt else {}),
            "failure": row.failure or None,
            "pareto": [name for name in QUANTITIES if row in fronts[name]],
        }
        for row in result.rows
    ]


def save_tradeoff(result: Tradeoff, path: Path) -> None:
    """Write a trade-off as CSV, a row for each setting; raises as `write_atomically`."""
    data = tradeoff_to_dict(result)
    keys = ("parameters", "separation", "start", "t_end", "floor", "features")
    header = {"fivtui": __version__, **{key: data[key] for key in keys}}
    rows = [{**row, "pareto": " ".join(row["pareto"])} for row in data["rows"]]
    columns = {name: [row[name] for row in rows] for name in rows[0]}
    save_csv(path, _KIND, columns, header)


def load_tradeoff(path: Path) -> Tradeoff:
    """Read a file of ``fivtui tradeoff --json`` or ``--out``; it lacks the reference run.

    Raises `InputError` if the file is not a trade-off.
    """
    check_suffix(path, _KIND, (".csv", ".json"))

    def from_data(data: Mapping[str, Any]) -> Tradeoff:
        return _tradeoff_from_data(path.stem, data)

    def from_table(columns: Columns, header: Header) -> Tradeoff:
        return _tradeoff_from_data(path.stem, {**header, "rows": _row_dicts(columns)})

    # In a CSV file, cells without a value are empty.
    return read_result(path, _KIND, from_data, from_table, texts=_TEXT_COLUMNS, missing=True)


def _row_dicts(columns: Columns) -> list[dict[str, Any]]:
    rows = zip(*columns.values(), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in rows]


def _tradeoff_from_data(name: str, data: Mapping[str, Any]) -> Tradeoff:
    start = data.get("start", "static")
    scene = Scene(
        name=name,
        description="",
        parameters=Parameters().with_values(data["parameters"]),
        separation=bool(data.get("separation", True)),
        start="static" if start == "static" else [float(value) for value in start],
        t_end=float(data["t_end"]),
    )
    floor = {quantity: _value_or_infinity(data["floor"][quantity]) for quantity in QUANTITIES}
    return Tradeoff(
        scene=scene,
        reference=None,
        floor=Deviation(**floor, separations=0, sticks=0),
        rows=[_row_from_data(row) for row in data["rows"]],
        features=[Feature(**feature) for feature in data.get("features", [])],
    )


def _row_from_data(data: Mapping[str, Any]) -> MeasuredSetting:
    knob, _, value = str(data["setting"]).partition("=")
    setting = Setting(str(data["method"]), data["kernel"] or "", knob, float(value))
    failure = data["failure"] or ""
    error = None
    if not failure:
        errors = {name: _value_or_infinity(data[f"error_{name}"]) for name in QUANTITIES}
        separations, sticks = int(data["separations"]), int(data.get("sticks", 0))
        error = Deviation(**errors, separations=separations, sticks=sticks)
    return MeasuredSetting(setting, float(data["cpu_s"]), int(data["steps"]), error, failure)


def _value_or_infinity(value: float | None) -> float:
    return math.inf if value is None or math.isnan(value) else value


def _error(row: MeasuredSetting, quantity: str) -> float | None:
    return None if row.error is None else _finite_or_none(row.error.of(quantity))


def _finite_or_none(value: float) -> float | None:
    return value if math.isfinite(value) else None
