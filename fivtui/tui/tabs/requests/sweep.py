"""The parser of the sweep tab's input, its computation, and points. Imports no Textual."""

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Final

from fivtui.charts import NearestPoint
from fivtui.model import ALL_PARAMETERS, InputError, System
from fivtui.scene import Scene
from fivtui.transient import START_SPECS, resolve_start
from fivtui.tui.session import FIELDS, base_scene, check_drawable, replace_symbols

if TYPE_CHECKING:
    from fivtui.sweeps import Rows, Study, Sweep

EXAMPLE: Final = "F=10:120:56"
# Most members of a sweep without confirmation, and of one that fits into memory.
MAX_UNCONFIRMED: Final = 10_000
_LIMIT: Final = 10_000_000
# The chart displays a sweep in parts: minimum members of a part, maximum number of parts.
_MIN_PART_SIZE: Final = 16
_MAX_PARTS: Final = 500
_OUTPUTS: Final = ("y_abs", "y_half_range")


def sweep_request(scene: Scene, text: str) -> "Study":
    """The sweep, in both cases of separation, of one or two ranges or the name of a sweep."""
    from fivtui.sweeps import SWEEP_PRESETS, parse_design, scene_study

    preset = SWEEP_PRESETS.get(text.strip())
    varied = replace_symbols(text).split() if preset is None else preset.varied
    try:
        design = parse_design(varied, "product")
    except InputError as error:
        raise InputError(str(error).replace("--vary ", "")) from None
    for name in design.axes:
        if name not in ALL_PARAMETERS:
            raise InputError(f"{name}: must be a parameter: {', '.join(ALL_PARAMETERS)}")
    # The greatest ẋ separates belts that are always faster than the slider.
    speed_output = ("vx_max",) if "v_belt" in design.axes else ()
    study = scene_study(scene, design, cases=(True, False), outputs=(*_OUTPUTS, *speed_output))
    check_drawable(study)
    if study.members > _LIMIT:
        raise InputError(
            f"{study.members} runs: must be at most {_LIMIT} here; for more use fivtui sweep --out"
        )
    return study


def sweep_parts(study: "Study", progress: Callable[[float], bool]) -> Iterator["Rows"]:
    """Compute a sweep in parts; raises `Cancelled` when `progress` returns False."""
    from fivtui.sweeps import compute_rows

    members = study.members
    part_size = max(_MIN_PART_SIZE, members // _MAX_PARTS)
    for start in range(0, members, part_size):
        stop = min(start + part_size, members)

        def part_progress(fraction: float, start: int = start, stop: int = stop) -> bool:
            return progress((start + fraction * (stop - start)) / members)

        yield compute_rows(study, start, stop, part_progress)


def partial_sweep(study: "Study", parts: Sequence["Rows"]) -> "Sweep":
    """A sweep of the rows computed so far."""
    from fivtui.sweeps import Sweep, concatenate

    return Sweep(study, concatenate(list(parts)))


def point_case(study: "Study", point: NearestPoint, case: bool) -> bool:
    """Whether separation is considered at a point of a sweep's chart."""
    from fivtui.sweeps import sweep_curves

    if len(study.design.axes) == 1:
        return sweep_curves(study)[point.trace][1]
    return case if case in study.cases else study.cases[0]


def point_scene(study: "Study", point: NearestPoint, case: bool) -> Scene:
    """The scene at a point of a sweep's chart."""
    values = dict(zip(study.design.axes, (point.x, point.y), strict=False))
    parameters = {name: value for name, value in values.items() if name in ALL_PARAMETERS}
    p, start = study.parameters.with_values(parameters), study.start
    start_values = {name: value for name, value in values.items() if name not in ALL_PARAMETERS}
    if start_values:
        start_state = dict(zip(START_SPECS, resolve_start(System(p, case), start), strict=True))
        start = tuple((start_state | start_values).values())
    return dataclasses.replace(
        base_scene(), parameters=p, separation=case, start=start, t_end=study.t_end, tol=study.tol
    )


def point_texts(scene: Scene) -> dict[str, str]:
    """Field texts of a scene."""
    return {name: field.text_of(scene) for name, field in FIELDS.items()}


def count_text(result: "Sweep") -> str:
    """Number of members, and why some failed."""
    table = result.table
    text = f"{len(table.reasons)} transients"
    if len(table.reasons) < result.study.members:
        text = f"{len(table.reasons)} of {result.study.members} transients"
    if table.failed:
        reason = next(reason for reason in table.reasons if reason)
        text += f", {table.failed} failed: {reason}"
    return text
