"""Branches of limit cycles as JSON data and as files, with units and provenance."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.io import read_bytes, save_json, write_table
from fivtui.model import ALL_PARAMETERS, Column, InputError, Parameters, System
from fivtui.orbits.columns import (
    MEASURES,
    MULTIPLIERS,
    multiplier_values,
    state_columns,
    state_values,
)

from .events import End, EventKind
from .result import BranchEvent, CycleBranch, CyclePoint
from .saved import BRANCH

_CYCLE: Final = (
    *MEASURES,
    Column("stable", "1", "1 if stable"),
    *MULTIPLIERS,
    *state_columns("of a state on the cycle"),
    Column("event", "1", "index in events"),
)
EVENTS: Final = ("none", *EventKind)
# Key of the set's own value of the parameter that varies, in stored branches.
_OWN: Final = "own_value"


def branch_to_dict(result: CycleBranch) -> dict[str, Any]:
    """A branch of limit cycles as JSON data.

    Keys are ``parameter`` (the one that varies) and ``unit``, ``parameters`` (the others),
    ``separation``, ``range``, ``from``, ``doubled``, ``points`` (``value``, ``period``, ``y_min``,
    ``y_max``, ``stable``, ``multipliers`` as pairs of real and imaginary part, ``start``),
    ``events`` (``kind``, ``value``, ``period``, ``y_min``, ``y_max``, and of a Hopf point
    ``direction``) and
    ``ends``: why the branch ends at the first and at the last point.
    """
    return {
        "parameter": result.name,
        "unit": ALL_PARAMETERS[result.name].unit,
        **_branch_provenance(result),
        "points": [
            asdict(point)
            | {
                "start": list(point.start),
                "multipliers": [[value.real, value.imag] for value in point.multipliers],
            }
            for point in result.points
        ],
        "events": [
            {name: value for name, value in asdict(event).items() if value != ""}
            for event in result.events
        ],
    }


def branch_columns(result: CycleBranch) -> dict[str, NDArray[Any]]:
    """A branch of limit cycles by column, as in its file; ``event`` is an index in `EVENTS`."""
    points = result.points
    met = {(event.value, event.period): EVENTS.index(event.kind) for event in result.events}
    return {
        result.name: np.array([point.value for point in points]),
        **{each.name: np.array([getattr(p, each.name) for p in points]) for each in MEASURES},
        "stable": np.array([int(point.stable) for point in points]),
        **multiplier_values([point.multipliers for point in points]),
        **state_values([point.start for point in points]),
        "event": np.array([met.get((point.value, point.period), 0) for point in points]),
    }


def save_branch(result: CycleBranch, path: Path, *, force: bool = False) -> None:
    """Write a branch of limit cycles as ``.csv``, ``.npz`` or ``.parquet``: a row per cycle.

    The column ``event`` is an index in ``event_kinds``, which the file lists; beside them what
    happens along the branch, Hopf points included, with values and periods.
    Raises `InputError` if the format is unknown or its package missing, or the file cannot be
    written.
    """
    spec = ALL_PARAMETERS[result.name]
    columns = (Column(spec.name, spec.unit, spec.meaning), *_CYCLE)
    header = _branch_provenance(result) | {
        "event_kinds": [str(each) for each in EVENTS],
        "events": [event_words(event) for event in result.events],
        "event_values": [event.value for event in result.events],
        "event_periods": [event.period for event in result.events],
    }
    write_table(path, BRANCH, columns, branch_columns(result), header, force=force)


def store_branch(result: CycleBranch, path: Path) -> None:
    """Write all of a branch as JSON; replaces a file."""
    own = result.parameters.as_dict()[result.name]
    save_json({**branch_to_dict(result), _OWN: own}, path, force=True)


def restore_branch(path: Path) -> CycleBranch:
    """Read a branch from JSON, that of ``fivtui branch --json`` too.

    What that does not say, the set's own value of the parameter that varies, is then that of the
    first point. Raises `InputError` for a table, or if the file is damaged.
    """
    if path.suffix.lower() != ".json":
        raise InputError(f"{path}: a branch is read from JSON alone, which branch --json prints")
    try:
        said = json.loads(read_bytes(path))
        name = str(said["parameter"])
        points = tuple(
            CyclePoint(
                **each
                | {
                    "start": tuple(each["start"]),
                    "multipliers": tuple(complex(*pair) for pair in each["multipliers"]),
                }
            )
            for each in said["points"]
        )
        events = tuple(
            BranchEvent(**each | {"kind": EventKind(each["kind"])}) for each in said["events"]
        )
        first, last = (End(each) for each in said["ends"])
        own = said.get(_OWN, points[0].value)
        low, high = (float(each) for each in said["range"])
        return CycleBranch(
            System(
                Parameters().with_values({**said["parameters"], name: own}),
                bool(said["separation"]),
            ),
            name,
            low,
            high,
            said["from"],
            points,
            events,
            (first, last),
            bool(said["doubled"]),
        )
    except (InputError, ValueError, KeyError, TypeError, IndexError):
        raise InputError(f"{path}: damaged") from None


def event_words(event: BranchEvent) -> str:
    """An event of a branch in words, e.g. ``"hopf, subcritical"``."""
    return f"{event.kind}, {event.direction}" if event.direction else str(event.kind)


def warning_on(result: CycleBranch) -> str | None:
    """Warning of a branch, in one sentence, if it was not followed to an end of its own."""
    places = zip(result.ends, (result.points[0], result.points[-1]), strict=True)
    cut = [
        f"{end} at {result.name} = {point.value:.6g}"
        for end, point in places
        if end in (End.LOST, End.LONG)
    ]
    return f"the branch {' and '.join(cut)}" if cut else None


def _branch_provenance(result: CycleBranch) -> dict[str, Any]:
    return {
        "parameters": {
            name: value
            for name, value in result.parameters.as_dict().items()
            if name != result.name
        },
        "separation": result.separation,
        "range": [result.low, result.high],
        "from": result.origin,
        "doubled": result.doubled,
        "ends": [str(end) for end in result.ends],
    }
