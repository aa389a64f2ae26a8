"""The tasks of `fivtui attractors`: what each computes."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

from fivtui.model import ALL_PARAMETERS, InputError, OnProgress
from fivtui.orbits import Explorer, basin, coexistence, continuation
from fivtui.ranges import parse_range, parse_ranges
from fivtui.scene import Scene
from fivtui.studies import study
from fivtui.transient import START_SPECS, Start

from .arguments import times_words
from .deliver import check_outputs, warn, write
from .options import progress_bar

_BASIN_RANGES: Final = 2


class Task(NamedTuple):
    """A computation of attractors, and the kind of study that its result is of."""

    kind: str
    compute: Callable[[Scene, OnProgress], Any]


def choose_task(vary: str | None, ranges: Sequence[str], start: Start | None) -> Task:
    """The task that ``--vary``, ``--basin`` and ``--start`` ask for; by default the search."""
    if vary is not None:
        if ranges or start is not None:
            raise InputError("--vary: must be given without --basin and --start")
        return _along(vary)
    if ranges:
        return _slice(ranges, start)
    return SEARCH if start is None else _from(start)


def _along(text: str) -> Task:
    along = parse_range("--vary", text, ALL_PARAMETERS)

    def compute(scene: Scene, progress: OnProgress) -> Any:
        return continuation(
            scene.parameters,
            along.name,
            along.values(),
            separation=scene.separation,
            progress=progress,
        )

    return Task("branches", compute)


def _slice(texts: Sequence[str], start: Start | None) -> Task:
    ranges = parse_ranges("--basin", texts, START_SPECS)
    if len(ranges) != _BASIN_RANGES:
        raise InputError(f"--basin: given {times_words(len(ranges))}; must be given twice")

    def compute(scene: Scene, progress: OnProgress) -> Any:
        over = {each.name: each.values() for each in ranges}
        return basin(
            scene.parameters, over, separation=scene.separation, start=start, progress=progress
        )

    return Task("basin", compute)


def _from(start: Start) -> Task:
    def compute(scene: Scene, _progress: OnProgress) -> Any:
        return Explorer(scene.system).reach(start)

    return Task("attractor", compute)


def _search(scene: Scene, progress: OnProgress) -> Any:
    return coexistence(scene.system, progress=progress)


SEARCH: Final = Task("attractors", _search)


def carry_out(
    task: Task,
    scene: Scene,
    *,
    out: Path | None = None,
    plot: Path | None = None,
    force: bool = False,
    quiet: bool = False,
) -> dict[str, Any]:
    """Compute, print, write and draw a task; return its result as data for JSON."""
    if not study(task.kind).suffixes and (out is not None or plot is not None):
        raise InputError("--out and --plot: must be given with --vary or --basin")
    check_outputs(task.kind, out, plot, force=force)
    with progress_bar("attractors") as progress:
        result = task.compute(scene, progress)
    if not quiet:
        study(task.kind).show(result)
    warn(task.kind, result)
    write(task.kind, result, out, plot, force=force)
    data: dict[str, Any] = study(task.kind).to_dict(result)
    return data
