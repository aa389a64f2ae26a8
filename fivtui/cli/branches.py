"""The command for branches of limit cycles, and for their boundaries over two parameters."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from fivtui.model import InputError, parameter_spec

from .arguments import option, times_words
from .completion import PARAMETER_VALUES
from .deliver import check_outputs, show, warn, write
from .group import commands
from .options import (
    force_option,
    ignore_option,
    json_option,
    output_option,
    progress_bar,
    scene_argument,
    scene_of,
    set_option,
)

if TYPE_CHECKING:
    from fivtui.model import OnProgress
    from fivtui.scene import Scene

_Range = tuple[float, float]


@commands.command()
@scene_argument
@set_option
@ignore_option
@option(
    "--vary",
    shell_complete=PARAMETER_VALUES,
    metavar="NAME[=LOW:HIGH]",
    help="The parameter, and its range; a tenth to ten times its value if not given.",
)
@option(
    "--from",
    "origin",
    metavar="hopf|cycle|FILE",
    help="Begin at the Hopf point nearest to the scene (the default), at a limit cycle that it "
    "settles on, or at one of its cycles in a file: a branch, or attractors as JSON.",
)
@option(
    "--doubled",
    is_flag=True,
    help="Follow the branch of twice the period that begins at the first period doubling instead.",
)
@option(
    "--curve",
    metavar="hopf|fold|touch",
    help="Follow Hopf points, folds or cycles that touch y = 0 over two parameters instead.",
)
@option(
    "--over",
    "ranges",
    shell_complete=PARAMETER_VALUES,
    multiple=True,
    metavar="NAME[=LOW:HIGH]",
    help="A parameter of --curve, and its range; give it twice.",
)
@output_option("--out", "FILE", "Write what is followed (.csv, .npz, .parquet).")
@output_option("--plot", "FILE", "Draw it (.png, .svg, .pdf).")
@force_option
@json_option
def branch(scene: str, assignments: tuple[str, ...], **given: Any) -> None:
    """Follow a branch of limit cycles along a parameter, stable and unstable.

    Folds, the first touch of y = 0, period doublings and tori are located on the way. A branch that
    is not connected to the one followed is not found. With --curve, follow Hopf points, folds or
    first touches over two parameters.
    """
    chosen = scene_of(
        scene,
        assignments,
        ignore_separation=given["ignore_separation"],
        varied=(given["vary"] or "", *given["ranges"]),
        centred=True,
    )
    kind, compute = _boundary(chosen, given) if given["curve"] else _branch(chosen, given)
    out, plot, force = given["out"], given["plot"], given["force"]
    check_outputs(kind, out, plot, force=force)
    with progress_bar("branch") as progress:
        result = compute(progress)
    warn(kind, result)
    write(kind, result, out, plot, force=force)
    show(kind, result, as_json=given["as_json"])


_Computation = tuple[str, Callable[["OnProgress"], Any]]


def _branch(scene: "Scene", given: Mapping[str, Any]) -> _Computation:
    from fivtui.orbits import branch as compute

    if given["vary"] is None:
        raise InputError("--vary: must be given, or --curve with --over twice")
    if given["ranges"]:
        raise InputError("--over: must be given with --curve")
    origin = _origin(given["origin"])
    name, ends = _range("--vary", given["vary"])
    low, high = (None, None) if ends is None else ends
    return "branch", lambda progress: compute(
        scene.parameters,
        name,
        low=low,
        high=high,
        origin=origin,
        doubled=given["doubled"],
        separation=scene.separation,
        progress=progress,
    )


def _boundary(scene: "Scene", given: Mapping[str, Any]) -> _Computation:
    from fivtui.orbits import BOUNDARIES, boundary as compute

    curve = given["curve"]
    if curve not in BOUNDARIES:
        raise InputError(f"--curve {curve}: must be {', '.join(BOUNDARIES[:-1])} or touch")
    for flag, name in (("--vary", "vary"), ("--from", "origin")):
        if given[name] is not None:
            raise InputError(f"{flag}: must be given without --curve")
    if given["doubled"]:
        raise InputError("--doubled: must be given without --curve")
    if len(given["ranges"]) != 2:
        raise InputError(f"--over: given {times_words(len(given['ranges']))}; must be given twice")
    over = dict(_range("--over", text) for text in given["ranges"])
    if len(over) != 2:
        raise InputError(f"--over: {next(iter(over))} is given twice; must be two parameters")
    return "boundary", lambda progress: compute(
        scene.parameters, curve, over, separation=scene.separation, progress=progress
    )


def _origin(text: str | None) -> Literal["hopf", "cycle"] | Path:
    from fivtui.io import check_regular

    if text is None or text == "hopf":
        return "hopf"
    if text == "cycle":
        return "cycle"
    path = Path(text)
    if not path.suffix:
        raise InputError(f"--from {text}: must be hopf, cycle or a file")
    check_regular(path)
    return path


def _range(flag: str, text: str) -> tuple[str, _Range | None]:
    name, equals, ends = (part.strip() for part in text.partition("="))
    spec = parameter_spec(name)
    if not equals:
        return name, None
    parts = ends.split(":")
    if len(parts) != 2:
        raise InputError(f"{flag} {text}: must be NAME or NAME=LOW:HIGH, e.g. {flag} mu=0:2")
    low, high = (spec.check(part.strip()) for part in parts)
    return name, (low, high)
