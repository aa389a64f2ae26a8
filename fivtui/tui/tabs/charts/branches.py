"""The chart of the branches tab. Imports no Textual."""

import dataclasses
import math
from collections.abc import Mapping
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from fivtui.charts import Chart, Guide, Trace
from fivtui.model import ALL_PARAMETERS, InputError, parameter_spec
from fivtui.orbits import CycleBranch, CyclePoint, EventKind
from fivtui.scene import Scene
from fivtui.tui.session import base_scene, plain_names

FloatArray = NDArray[np.float64]

EXAMPLE: Final = "μ=0.2:1"
Origin = Literal["hopf", "cycle"]
_MARKS: Final[Mapping[EventKind, str]] = {
    EventKind.HOPF: "H",
    EventKind.TOUCH: "T",
    EventKind.FOLD: "F",
    EventKind.PERIOD_DOUBLING: "P",
    EventKind.TORUS: "N",
    EventKind.BRANCH: "B",
    EventKind.STICK: "S",
    EventKind.REVERSE_SLIP: "R",
    EventKind.ORDER: "O",
}
_NAMES: Final[Mapping[EventKind, str]] = {EventKind.HOPF: "Hopf"}
# Dashes along a branch, in shares of the size of the chart.
_DASH: Final = 0.02
_EACH: Final = 8
# Periods of an orbit that is run.
_PERIODS: Final = 20


def parse_branch(text: str) -> tuple[str, tuple[float, float] | None]:
    """The parameter and its range in text such as ``μ=0.2:1``; the range may be missing."""
    name, equals, ends = (part.strip() for part in plain_names(text).partition("="))
    spec = parameter_spec(name)
    if not equals:
        return name, None
    parts = ends.split(":")
    if len(parts) != 2:
        raise InputError(f"{text}: must be NAME or NAME=LOW:HIGH, e.g. {EXAMPLE}")
    low, high = (spec.check(part.strip()) for part in parts)
    return name, (low, high)


def event_name(kind: EventKind) -> str:
    """What happens at a point of a branch, as charts call it."""
    return _NAMES.get(kind, str(kind).replace("-", " "))


def branch_chart(result: CycleBranch, now: float | None) -> Chart:
    """Half peak-to-peak over the parameter: stable cycles full, unstable ones dashed, events.

    `now` is the edited value of the parameter.
    """
    values = np.array([point.value for point in result.points])
    heights = np.array([point.half_range for point in result.points])
    stable = np.array([point.stable for point in result.points])
    sizes = max(float(np.ptp(values)), 1e-300), max(float(heights.max()), 1e-300)
    full = Trace("stable", *_pieces(values, heights, stable), ordered=False, mark="●")
    dashed = Trace(
        "unstable", *_dashed(*_pieces(values, heights, ~stable), sizes), ordered=False, mark="○"
    )
    events = [
        Trace(
            event_name(kind),
            np.array([event.value for event in met]),
            np.array([0.5 * (event.y_max - event.y_min) for event in met]),
            look="points",
            ordered=False,
            mark=_MARKS[kind],
        )
        for kind in _MARKS
        if (met := [event for event in result.events if event.kind is kind])
    ]
    spec = ALL_PARAMETERS[result.name]
    label = f"{spec.symbol} ({spec.unit})" if spec.unit else spec.symbol
    guides = () if now is None else (Guide(now, "now"),)
    note = f"{len(result.points)} limit cycles"
    return Chart(label, "±y (m)", (full, dashed, *events), guides, note=note, tight=False)


def _pieces(
    x: FloatArray, y: FloatArray, chosen: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    # The parts of a curve of which one end at least is chosen, with gaps between them.
    parts: list[tuple[FloatArray, FloatArray]] = []
    edges = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]])))
    for begin, end in edges.reshape(-1, 2).tolist():
        piece = slice(begin, min(end + 1, x.size))
        parts += [(x[piece], y[piece]), (np.array([np.nan]), np.array([np.nan]))]
    if not parts:
        return np.empty(0), np.empty(0)
    return (
        np.concatenate([part[0] for part in parts[:-1]]),
        np.concatenate([part[1] for part in parts[:-1]]),
    )


def _dashed(
    x: FloatArray, y: FloatArray, sizes: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    # The same curve with every second dash left out.
    if x.size < 2:
        return x, y
    steps = np.hypot(np.diff(x) / sizes[0], np.diff(y) / sizes[1])
    along = np.concatenate([[0.0], np.cumsum(np.where(np.isfinite(steps), steps, 0.0))])
    fine = np.linspace(0.0, along[-1], max(math.ceil(along[-1] / _DASH * _EACH), 2))
    there = (np.interp(fine, along, values) for values in (x, y))
    shown = (fine / _DASH).astype(int) % 2 == 0
    across, up = (np.where(shown, values, np.nan) for values in there)
    return across, up


def nearest_cycle(result: CycleBranch, x: float, y: float) -> CyclePoint:
    """The limit cycle that is nearest to a point of the chart."""
    values = np.array([point.value for point in result.points])
    heights = np.array([point.half_range for point in result.points])
    sizes = max(float(np.ptp(values)), 1e-300), max(float(heights.max()), 1e-300)
    away = np.hypot((values - x) / sizes[0], (heights - y) / sizes[1])
    return result.points[int(away.argmin())]


def orbit_scene(result: CycleBranch, point: CyclePoint) -> Scene:
    """The scene that begins on a limit cycle of a branch and lasts twenty of its periods."""
    return dataclasses.replace(
        base_scene(),
        parameters=result.parameters.with_values({result.name: point.value}),
        separation=result.separation,
        start=point.start,
        t_end=float(f"{_PERIODS * point.period:.6g}"),
    )
