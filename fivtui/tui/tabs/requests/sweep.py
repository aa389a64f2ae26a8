"""The parser of the sweep tab's input, its computation, and points. Imports no Textual.

A member is one run of a sweep. Case 1 considers separation, Case 2 ignores it.
"""

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Final

from fivtui.charts import NearestPoint
from fivtui.model import ALL_PARAMETERS, InputError, System
from fivtui.scene import Scene
from fivtui.transient import START_SPECS, resolve_start
from fivtui.tui.session import base_scene, check_drawable, replace_symbols

if TYPE_CHECKING:
    from fivtui.sweeps import Rows, Study, Sweep

EXAMPLE: Final = "F=10:120:56"
# Maximum number of members of a sweep that starts without confirmation, and of one in memory.
MAX_UNCONFIRMED: Final = 10_000
_MAX_MEMBERS: Final = 10_000_000
# The chart displays a sweep in parts: minimum number of members of a part, and number of parts.
_MIN_PART_SIZE: Final = 16
_MAX_PARTS: Final = 500
# The plotted outputs: peak and half range of y.
_OUTPUTS: Final = ("y_abs", "y_half_range")


def sweep_request(scene: Scene, text: str) -> "Study":
    """The sweep of a scene, in both cases, over one or two ranges or by the name of a preset."""
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
    # The greatest ẋ shows which belts are always faster than the slider.
    speed_output = ("vx_max",) if "v_belt" in design.axes else ()
    study = scene_study(scene, design, cases=(True, False), outputs=(*_OUTPUTS, *speed_output))
    check_drawable(study)
    if study.members > _MAX_MEMBERS:
        raise InputError(
            f"{study.members} runs: must be at most {_MAX_MEMBERS} here; "
            "for more use fivtui sweep --out"
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


def point_separation(study: "Study", point: NearestPoint, edited_separation: bool) -> bool:
    """Whether separation is considered at a point of a sweep's chart.

    A chart over one parameter shows both cases; one over two parameters shows that of the edited
    scene, `edited_separation`, if the sweep has it.
    """
    from fivtui.sweeps import sweep_curves

    if len(study.design.axes) == 1:
        _, separation = sweep_curves(study)[point.trace]
        return separation
    return edited_separation if edited_separation in study.cases else study.cases[0]


def point_scene(study: "Study", point: NearestPoint, separation: bool) -> Scene:
    """The scene at a point of a sweep's chart."""
    # Over one parameter, y is an output, which `zip` omits.
    values = dict(zip(study.design.axes, (point.x, point.y), strict=False))
    parameter_values = {name: value for name, value in values.items() if name in ALL_PARAMETERS}
    parameters, start = study.parameters.with_values(parameter_values), study.start
    # A sweep read from a file may vary components of the start state.
    start_values = {name: value for name, value in values.items() if name not in ALL_PARAMETERS}
    if start_values:
        system = System(parameters, separation)
        start_state = dict(zip(START_SPECS, resolve_start(system, start), strict=True))
        start = tuple((start_state | start_values).values())
    return dataclasses.replace(
        base_scene(),
        parameters=parameters,
        separation=separation,
        start=start,
        t_end=study.t_end,
        tol=study.tol,
    )


def count_text(result: "Sweep") -> str:
    """Number of computed members, of how many if some are missing."""
    computed, members = result.table.members, result.study.members
    return (
        f"{computed} transients" if computed == members else f"{computed} of {members} transients"
    )


def failure_text(result: "Sweep") -> str:
    """How many members failed, and why the first one did; empty if none."""
    table = result.table
    # Members that did not fail have an empty reason.
    reason = next(filter(None, table.reasons), "")
    return f"{table.failed} failed: {reason}" if table.failed else ""
