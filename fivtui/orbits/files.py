"""Attractors, continuations and basins as JSON data and as files, with units and provenance."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.io import write_table
from fivtui.model import ALL_PARAMETERS, Column, Parameters, State
from fivtui.transient import START_SPECS

from .attractor_search import Coexistence
from .basins import Basin
from .branches import DIRECTIONS, Continuation
from .explorer import AT_REST, Attractor, Kind

# What a file is called in messages.
KIND: Final = "attractor"
KINDS: Final = tuple(Kind)
_OTHERS: Final = {
    Kind.UNBOUNDED: "unbounded growth",
    Kind.UNSETTLED: "motion that did not settle in the time allowed",
}
_NUMBERS: Final = (
    Column("period", "s", "period of the limit cycle"),
    Column("half_range", "m", "half peak-to-peak of y"),
    Column("y_min", "m", "lowest point"),
    Column("y_max", "m", "highest point"),
    Column("separations", "1", "separations per period"),
    Column("separated_time", "s", "time off the belt per period"),
    Column("sticks", "1", "sticks per period"),
    Column("stick_time", "s", "time of stick per period"),
    Column("vx_max", "m/s", "greatest horizontal velocity"),
    Column("force_max", "N", "greatest contact force"),
)


def attractor_to_dict(attractor: Attractor) -> dict[str, Any]:
    """An attractor as JSON data, in SI units.

    Keys are ``kind`` and ``half_range``, and of a limit cycle ``period``, ``start`` (x, ẋ, y, ẏ at
    a separation, a lowest point or within a stick), ``y_min``, ``y_max``, ``x_abs``, ``vx_max``,
    ``force_max``, ``separations``, ``separated_time``, ``sticks`` and ``stick_time`` per period,
    and ``floquet_multipliers`` as pairs of real and imaginary part.
    """
    orbit = attractor.orbit
    data: dict[str, Any] = {"kind": str(attractor.kind), "half_range": attractor.half_range}
    if orbit is not None:
        names = ("period", "y_min", "y_max", "x_abs", "vx_max", "force_max")
        data |= {name: getattr(orbit, name) for name in names}
        data |= {
            "separations": orbit.separations,
            "separated_time": orbit.separated_time,
            "sticks": orbit.sticks,
            "stick_time": orbit.stick_time,
            "section": orbit.section.name.lower().replace("_", "-"),
            "start": list(orbit.start),
            "floquet_multipliers": [[v.real, v.imag] for v in orbit.multipliers.tolist()],
        }
    return data


def coexistence_to_dict(result: Coexistence) -> dict[str, Any]:
    """The attractors of a parameter set as JSON data.

    Keys are ``attractors``, ``coexistence``, ``escape_offset`` (``up`` and ``down``, m, or None)
    and ``warning`` (None if there is none).
    """
    return {
        "attractors": [attractor_to_dict(attractor) for attractor in result.attractors],
        "coexistence": result.coexists,
        "escape_offset": None if result.escape is None else asdict(result.escape),
        "warning": warning_of(result),
    }


def warning_of(result: Coexistence) -> str | None:
    """Warning, in one sentence, if the equilibrium coexists with another attractor.

    It also warns if a motion did not settle; None if there is nothing to warn of.
    """
    if not result.coexists:
        return None if result.settled else "some motions did not settle in the time allowed"
    others = [
        _OTHERS.get(attractor.kind, f"a {describe(attractor)}")
        for attractor in result.attractors
        if attractor.kind not in AT_REST
    ]
    beside = f"it coexists with {' and '.join(others)}"
    if result.escape is None:
        return f"the equilibrium is reached only from some starts: {beside}"
    offsets = [
        f"{value:.4g} m {where}"
        for where, value in (("above", result.escape.up), ("below", result.escape.down))
        if value is not None
    ]
    released = f"; a release from rest {' or '.join(offsets)} it leaves it" if offsets else ""
    return f"the equilibrium is stable only for small disturbances: {beside}{released}"


def warning_along(result: Continuation) -> str | None:
    """Warning of a continuation, in one sentence; None if nothing coexists."""
    if not result.coexisting:
        return None
    values = ", ".join(f"{value:.6g}" for value in result.coexisting)
    return f"a stable equilibrium coexists with vibration at {result.name} = {values}"


def warning_in(result: Basin) -> str | None:
    """Warning of a slice of basins, in one sentence; None if every motion settled."""
    for place, attractor in enumerate(result.attractors):
        if attractor.kind is Kind.UNSETTLED:
            count = int(np.count_nonzero(result.reached == place))
            return f"{count} of {result.reached.size} motions did not settle in the time allowed"
    return None


def describe(attractor: Attractor) -> str:
    """An attractor in a few words."""
    orbit = attractor.orbit
    if orbit is None:
        return str(attractor.kind)
    size = f"half peak-to-peak {attractor.half_range:.6g} m"
    return f"{attractor.kind}, period {orbit.period:.6g} s, {size}"


def continuation_to_dict(result: Continuation) -> dict[str, Any]:
    """A continuation as JSON data.

    Keys are ``parameters`` (those that do not vary), ``separation``, ``name``, ``unit``, ``points``
    (``value``, ``directions`` and the attractor) and ``coexisting``: the values at which the
    equilibrium and another attractor coexist.
    """
    return {
        "parameters": _fixed(result.parameters, (result.name,)),
        "separation": result.separation,
        "name": result.name,
        "unit": ALL_PARAMETERS[result.name].unit,
        "points": [
            {
                "value": point.value,
                "directions": list(point.directions),
                **attractor_to_dict(point.attractor),
            }
            for point in result.points
        ],
        "coexisting": result.coexisting,
    }


def basin_to_dict(result: Basin) -> dict[str, Any]:
    """A slice of basins as JSON data.

    Keys are ``parameters``, ``separation``, ``start``, ``over`` (name, unit and values of the two
    components of the start), ``attractors`` and ``reached``: for every first value a list of
    indices in ``attractors``.
    """
    return {
        **_basin_provenance(result),
        "over": [
            {"name": name, "unit": START_SPECS[name].unit, "values": axis.tolist()}
            for name, axis in zip(result.names, result.axes, strict=True)
        ],
        "attractors": [attractor_to_dict(attractor) for attractor in result.attractors],
        "reached": result.reached.tolist(),
    }


def continuation_columns(result: Continuation) -> dict[str, NDArray[Any]]:
    """A continuation by column, as in its file; ``kind`` is an index in `KINDS`."""
    points = result.points
    return {
        result.name: np.array([point.value for point in points]),
        **{name: np.array([int(name in p.directions) for p in points]) for name in DIRECTIONS},
        "kind": np.array([KINDS.index(point.attractor.kind) for point in points]),
        **{
            column.name: np.array([_value(point.attractor, column.name) for point in points])
            for column in _NUMBERS
        },
    }


def basin_columns(result: Basin) -> dict[str, NDArray[Any]]:
    """A slice of basins by column, the second component varying fastest."""
    first, second = np.meshgrid(*result.axes, indexing="ij")
    arrays = (first.ravel(), second.ravel(), result.reached.ravel())
    return dict(zip((*result.names, "attractor"), arrays, strict=True))


def save_continuation(result: Continuation, path: Path, *, force: bool = False) -> None:
    """Write a continuation as ``.csv``, ``.npz`` or ``.parquet``: a row per attractor and value.

    The column ``kind`` is an index in ``kinds``, which the file lists; ``nan`` means no value.
    Raises `InputError` if the format is unknown or its package missing, or the file cannot be
    written.
    """
    spec = ALL_PARAMETERS[result.name]
    places = tuple(Column(name, "1", f"1 if found going {name}") for name in DIRECTIONS)
    kind = Column("kind", "1", "index in kinds")
    columns = (Column(spec.name, spec.unit, spec.meaning), *places, kind, *_NUMBERS)
    header = {
        "parameters": _fixed(result.parameters, (result.name,)),
        "separation": result.separation,
        "kinds": [str(each) for each in KINDS],
    }
    write_table(path, KIND, columns, continuation_columns(result), header, force=force)


def save_basin(result: Basin, path: Path, *, force: bool = False) -> None:
    """Write a slice of basins as ``.csv``, ``.npz`` or ``.parquet``: one row per start.

    The column ``attractor`` is an index in ``attractors``, which the file lists. Raises
    `InputError` as `save_continuation` does.
    """
    specs = [START_SPECS[name] for name in result.names]
    columns = (
        *(Column(spec.name, spec.unit, spec.meaning) for spec in specs),
        Column("attractor", "1", "index in attractors"),
    )
    header = _basin_provenance(result) | {
        "attractors": [describe(attractor) for attractor in result.attractors]
    }
    write_table(path, KIND, columns, basin_columns(result), header, force=force)


def _value(attractor: Attractor, name: str) -> float:
    if name == "half_range":
        return np.nan if attractor.half_range is None else attractor.half_range
    return np.nan if attractor.orbit is None else float(getattr(attractor.orbit, name))


def _fixed(p: Parameters, varied: Sequence[str]) -> dict[str, float]:
    return {name: value for name, value in p.as_dict().items() if name not in varied}


def _basin_provenance(result: Basin) -> dict[str, Any]:
    start: State = result.start
    return {
        "parameters": result.parameters.as_dict(),
        "separation": result.separation,
        "start": list(start),
    }
