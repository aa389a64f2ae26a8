"""Boundaries over two parameters as JSON data and as files, with units and provenance."""

from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.io import write_table
from fivtui.model import PARAMETERS, Column
from fivtui.orbits.columns import (
    MEASURES,
    MULTIPLIERS,
    multiplier_values,
    state_columns,
    state_values,
)
from fivtui.orbits.curves.events import End

from .result import Boundary, BoundaryPoint

# What a file is called in messages.
BOUNDARY: Final = "boundary"
_MEASURES: Final = (
    *MEASURES,
    Column("lyapunov", "1/(m^2 s)", "first Lyapunov coefficient of a Hopf point"),
)
_COLUMNS: Final = (
    Column("part", "1", "number of the curve"),
    *_MEASURES,
    *MULTIPLIERS,
    *state_columns("of a state of the motion"),
)


def boundary_to_dict(result: Boundary) -> dict[str, Any]:
    """Curves over two parameters as JSON data.

    Keys are ``curve`` (what is on them), ``over`` (name, unit and range of both parameters),
    ``parameters`` (the others), ``separation`` and ``curves``: lists of ``points`` (``values``,
    ``period``, ``y_min``, ``y_max``, ``start``, of a cycle ``multipliers``, of a Hopf point
    ``lyapunov``), ``events`` (``kind``, ``values``, ``period``, ``y_min``, ``y_max``) and ``ends``.
    """
    return {
        **_provenance(result),
        "over": [
            {"name": name, "unit": PARAMETERS[name].unit, "range": list(ends)}
            for name, ends in zip(result.names, result.ranges, strict=True)
        ],
        "curves": [
            {
                "points": [_point(point) for point in curve.points],
                "events": [
                    asdict(event) | {"values": list(event.values)} for event in curve.events
                ],
                "ends": [str(end) for end in curve.ends],
            }
            for curve in result.curves
        ],
    }


def boundary_columns(result: Boundary) -> dict[str, NDArray[Any]]:
    """Curves over two parameters by column, as in their file; ``nan`` means no value."""
    rows = [(place, one) for place, curve in enumerate(result.curves) for one in curve.points]
    points = [point for _, point in rows]
    return {
        **dict(zip(result.names, np.array([point.values for point in points]).T, strict=True)),
        "part": np.array([place for place, _ in rows]),
        **{each.name: np.array([getattr(p, each.name) for p in points]) for each in _MEASURES},
        **multiplier_values([point.multipliers for point in points]),
        **state_values([point.start for point in points]),
    }


def save_boundary(result: Boundary, path: Path, *, force: bool = False) -> None:
    """Write curves over two parameters as ``.csv``, ``.npz`` or ``.parquet``: a row per point.

    The events of the curves are listed beside them. Raises `InputError` if the format is unknown or
    its package missing, or the file cannot be written.
    """
    specs = [PARAMETERS[name] for name in result.names]
    columns = (*(Column(spec.name, spec.unit, spec.meaning) for spec in specs), *_COLUMNS)
    header = _provenance(result) | {
        "over": list(result.names),
        "ranges": [list(ends) for ends in result.ranges],
        "curve_events": [str(event.kind) for event in result.events],
        "curve_event_values": [list(event.values) for event in result.events],
        "ends": [[str(end) for end in curve.ends] for curve in result.curves],
    }
    write_table(path, BOUNDARY, columns, boundary_columns(result), header, force=force)


def warning_on(result: Boundary) -> str | None:
    """Warning, in one sentence, if a curve was not followed to an end of its own."""
    cut = []
    for curve in result.curves:
        for end, point in zip(curve.ends, (curve.points[0], curve.points[-1]), strict=True):
            if end in (End.LOST, End.LONG):
                at = zip(result.names, point.values, strict=True)
                cut.append(f"{end} at {', '.join(f'{name} = {value:.6g}' for name, value in at)}")
    return f"a curve {' and '.join(cut)}" if cut else None


def _point(point: BoundaryPoint) -> dict[str, Any]:
    data: dict[str, Any] = {
        "values": list(point.values),
        "period": point.period,
        "y_min": point.y_min,
        "y_max": point.y_max,
        "start": list(point.start),
    }
    if point.multipliers:
        data["multipliers"] = [[value.real, value.imag] for value in point.multipliers]
    else:
        data["lyapunov"] = point.lyapunov
    return data


def _provenance(result: Boundary) -> dict[str, Any]:
    return {
        "curve": result.kind,
        "parameters": {
            name: value
            for name, value in result.parameters.as_dict().items()
            if name not in result.names
        },
        "separation": result.separation,
    }
