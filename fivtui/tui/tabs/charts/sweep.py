"""Computation and charts of the sweep tab. Imports no Textual."""

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.charts import Backdrop, Chart, Guide, NearestPoint, Trace
from fivtui.model import ALL_PARAMETERS, InputError, System
from fivtui.scene import Scene
from fivtui.transient import CONSIDERED, IGNORED, START_SPECS, resolve_start
from fivtui.tui.session import (
    FIELDS,
    base_scene,
    check_drawable,
    plain_names,
    symbol_of,
)

from .map_shades import graded, value_scale

if TYPE_CHECKING:
    from fivtui.sweeps import Rows, Study, Sweep

FloatArray = NDArray[np.float64]

EXAMPLE: Final = "F=10:120:56"
# Larger sweeps are asked for twice; the largest still fit into memory.
ASKED_FROM: Final = 10_000
_MOST: Final = 10_000_000
# Members per part, by which the chart grows, and the most parts.
_PIECE: Final = 16
_PARTS: Final = 500
_CASES: Final = {True: f"separation {CONSIDERED}", False: f"separation {IGNORED}"}
_OUTPUTS: Final = {"y_abs": "peak", "y_half_range": "±y 2nd half"}
# By plotted output and separation.
_MARKS: Final = ({True: "●", False: "○"}, {True: "◆", False: "◇"})


@dataclass(frozen=True, slots=True, eq=False)
class SweepPoints:
    """Outputs of a sweep over one variable."""

    name: str
    values: dict[tuple[str, bool], tuple[FloatArray, FloatArray]]
    limits: dict[bool, float] = dataclasses.field(default_factory=dict)


def sweep_request(scene: Scene, text: str) -> "Study":
    """Parse one or two ``--vary`` ranges, or the name of a sweep; covers both separation cases."""
    from fivtui.sweeps import SWEEP_PRESETS, parse_design, study_of

    preset = SWEEP_PRESETS.get(text.strip())
    varied = plain_names(text).split() if preset is None else preset.varied
    try:
        design = parse_design(varied, "product")
    except InputError as error:
        raise InputError(str(error).replace("--vary ", "")) from None
    for name in design.axes:
        if name not in ALL_PARAMETERS:
            raise InputError(f"{name}: must be a parameter: {', '.join(ALL_PARAMETERS)}")
    # The greatest ẋ says which belts are always faster.
    more = ("vx_max",) if "v_belt" in design.axes else ()
    study = study_of(scene, design, cases=tuple(_CASES), outputs=(*_OUTPUTS, *more))
    check_drawable(study)
    if study.members > _MOST:
        raise InputError(
            f"{study.members} runs: must be at most {_MOST} here; fivtui sweep --out writes more"
        )
    return study


def sweep_parts(study: "Study", progress: Callable[[float], bool]) -> Iterator["Rows"]:
    """Compute a sweep in parts; raises `Cancelled` when `progress` returns False."""
    from fivtui.sweeps import compute_rows

    members = study.members
    piece = max(_PIECE, members // _PARTS)
    for first in range(0, members, piece):
        last = min(first + piece, members)

        def within(fraction: float, first: int = first, last: int = last) -> bool:
            return progress((first + fraction * (last - first)) / members)

        yield compute_rows(study, first, last, within)


def sweep_of(study: "Study", parts: Sequence["Rows"]) -> "Sweep":
    """A sweep of the rows computed so far."""
    from fivtui.sweeps import Sweep, joined

    return Sweep(study, joined(list(parts)))


def grid_chart(result: "Sweep", case: bool, now: tuple[float, float] | None) -> Chart:
    """A sweep over two variables as shades, of the peak or else the first output.

    If separation `case` was not computed, the other one is shown.
    """
    from fivtui.sweeps import OUTPUTS, VARIABLES

    study, rows = result.study, result.table
    first, second = study.design.axes
    output = next((name for name in _OUTPUTS if name in study.outputs), study.outputs[0])
    shown = case if case in study.cases else study.cases[0]
    own = rows.separation == shown
    x, column = np.unique(rows.numbers[first][own], return_inverse=True)
    y, row = np.unique(rows.numbers[second][own], return_inverse=True)
    values = np.full((x.size, y.size), np.nan)
    values[column, row] = rows.numbers[output][own]
    levels, shades = graded(values)
    label = _label(OUTPUTS[output].meaning, OUTPUTS[output].unit)
    here = () if now is None else (_point(*now),)
    return Chart(
        _label(symbol_of(first), VARIABLES[first].unit),
        _label(symbol_of(second), VARIABLES[second].unit),
        here,
        backdrop=Backdrop(x, y, levels, shades, values, label, value_scale(levels, shades, values)),
        note=f"{label}, {_CASES[shown]}",
    )


def _point(x: float, y: float) -> Trace:
    return Trace("now", np.array([x]), np.array([y]), look="points", ordered=False, mark="◆")


def points_of(result: "Sweep") -> SweepPoints:
    """The plotted outputs of a sweep over one variable: peak, half peak-to-peak; or the first."""
    study, rows = result.study, result.table
    (name,) = study.design.axes
    along = rows.numbers[name]
    order = np.argsort(along, kind="stable")
    drawn = [output for output in _OUTPUTS if output in study.outputs] or study.outputs[:1]
    values = {}
    for case in sorted(study.cases, reverse=True):
        own = order[rows.separation[order] == case]
        for output in drawn:
            values[output, case] = along[own], rows.numbers[output][own]
    known = {case: result.fast_belt(case) for case in study.cases}
    first = rows.numbers[drawn[0]]
    limits = {case: float(first[row]) for case, row in known.items() if row is not None}
    return SweepPoints(name, values, limits)


def sweep_chart(points: SweepPoints, now: float | None) -> Chart:
    """The outputs over the swept variable, a trace per output and case; `now` is marked."""
    from fivtui.sweeps import OUTPUTS, VARIABLES

    outputs = list(dict.fromkeys(output for output, _ in points.values))
    traces = []
    for (output, case), (x, y) in points.values.items():
        name = f"{_OUTPUTS.get(output, output)}, {_CASES[case]}"
        mark = _MARKS[outputs.index(output)][case]
        traces.append(Trace(name, x, y, look="marked", mark=mark))
    guides = [] if now is None else [Guide(now, f"{now:g}")]
    guides += [
        Guide(limit, f"always faster, {_CASES[case]}", vertical=False)
        for case, limit in points.limits.items()
    ]
    first = OUTPUTS[outputs[0]]
    shown = "|y| peak, ±y 2nd half" if first.name in _OUTPUTS else first.meaning
    along = _label(symbol_of(points.name), VARIABLES[points.name].unit)
    return Chart(along, _label(shown, first.unit), tuple(traces), guides=tuple(guides), tight=False)


def _label(name: str, unit: str) -> str:
    return f"{name} ({unit})" if unit else name


def case_of(study: "Study", points: SweepPoints | None, point: NearestPoint, case: bool) -> bool:
    """Whether separation is considered at a point of a sweep's chart."""
    if points is not None:
        return list(points.values)[point.trace][1]
    return case if case in study.cases else study.cases[0]


def point_scene(study: "Study", point: NearestPoint, case: bool) -> Scene:
    """The scene of a member of a sweep."""
    values = dict(zip(study.design.axes, (point.x, point.y), strict=False))
    parameters = {name: value for name, value in values.items() if name in ALL_PARAMETERS}
    p, start = study.parameters.with_values(parameters), study.start
    moved = {name: value for name, value in values.items() if name not in ALL_PARAMETERS}
    if moved:
        state = dict(zip(START_SPECS, resolve_start(System(p, case), start), strict=True))
        start = tuple((state | moved).values())
    return dataclasses.replace(
        base_scene(), parameters=p, separation=case, start=start, t_end=study.t_end, tol=study.tol
    )


def point_texts(scene: Scene) -> dict[str, str]:
    """Field texts of a scene."""
    return {name: field.text_of(scene) for name, field in FIELDS.items()}


def count_words(result: "Sweep") -> str:
    """Number of members, and why some failed."""
    rows = result.table
    words = f"{len(rows.reasons)} transients"
    if len(rows.reasons) < result.study.members:
        words = f"{len(rows.reasons)} of {result.study.members} transients"
    if rows.failed:
        reason = next(reason for reason in rows.reasons if reason)
        words += f", {rows.failed} failed: {reason}"
    return words
