"""The tasks of `fivtui attractors`: what each computes, prints, writes and draws."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from fivtui.io import check_table_path
from fivtui.model import InputError
from fivtui.orbits import (
    Explorer,
    attractor_to_dict,
    basin,
    basin_figure,
    basin_to_dict,
    coexistence,
    coexistence_to_dict,
    continuation,
    continuation_figure,
    continuation_to_dict,
    print_attractors,
    print_basin,
    print_coexistence,
    print_continuation,
    save_basin,
    save_continuation,
    warning_along,
    warning_in,
    warning_of,
)
from fivtui.plotting import check_figure_path, save_figure
from fivtui.ranges import parse_range, parse_ranges
from fivtui.scene import Scene
from fivtui.transient import START_SPECS, Start

from .options import progress_bar

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Progress = Callable[[float], bool]

_BASIN_RANGES: Final = 2


@dataclass(frozen=True, slots=True)
class Task:
    """A computation of attractors, and functions that take its result.

    `save` and `figure` are None where there is nothing to write or draw.
    """

    compute: Callable[[Scene, Progress], Any]
    to_dict: Callable[[Any], dict[str, Any]]
    show: Callable[[Any], None]
    warning: Callable[[Any], str | None]
    save: Callable[..., None] | None = None
    figure: "Callable[[Any], Figure] | None" = None


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
    along = parse_range("--vary", text)

    def compute(scene: Scene, progress: Progress) -> Any:
        return continuation(
            scene.parameters,
            along.name,
            along.values(),
            separation=scene.separation,
            progress=progress,
        )

    return Task(
        compute,
        continuation_to_dict,
        print_continuation,
        warning_along,
        save_continuation,
        continuation_figure,
    )


def _slice(texts: Sequence[str], start: Start | None) -> Task:
    ranges = parse_ranges("--basin", texts, START_SPECS)
    if len(ranges) != _BASIN_RANGES:
        raise InputError(f"--basin: given {len(ranges)} times; must be given twice")

    def compute(scene: Scene, progress: Progress) -> Any:
        over = {each.name: each.values() for each in ranges}
        return basin(
            scene.parameters, over, separation=scene.separation, start=start, progress=progress
        )

    return Task(compute, basin_to_dict, print_basin, warning_in, save_basin, basin_figure)


def _from(start: Start) -> Task:
    def compute(scene: Scene, _progress: Progress) -> Any:
        return Explorer(scene.parameters, separation=scene.separation).reach(start)

    return Task(compute, attractor_to_dict, lambda found: print_attractors([found]), lambda _: None)


def _search(scene: Scene, progress: Progress) -> Any:
    return coexistence(scene.parameters, separation=scene.separation, progress=progress)


SEARCH: Final = Task(_search, coexistence_to_dict, print_coexistence, warning_of)


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
    if task.save is None and (out is not None or plot is not None):
        raise InputError("--out and --plot: must be given with --vary or --basin")
    if out is not None:
        check_table_path(out, "attractor", force=force)
    if plot is not None:
        check_figure_path(plot, force=force)
    with progress_bar("attractors") as progress:
        result = task.compute(scene, progress)
    if not quiet:
        task.show(result)
    if (warning := task.warning(result)) is not None:
        click.echo(f"warning: {warning}", err=True)
    if out is not None and task.save is not None:
        task.save(result, out, force=force)
        click.echo(f"wrote {out}", err=True)
    if plot is not None and task.figure is not None:
        save_figure(task.figure(result), plot, force=force)
        click.echo(f"wrote {plot}", err=True)
    return task.to_dict(result)
