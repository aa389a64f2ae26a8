"""The command for branches of limit cycles, and for their boundaries over two parameters."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from fivtui.model import InputError
from fivtui.orbits import BranchOptions

from .arguments import times_text
from .command import Call, command

if TYPE_CHECKING:
    from fivtui.scene import Scene

# Example of a range in messages.
_EXAMPLE: Final = "mu=0:2"
# The kind of a study, and its computation with the argument `progress`.
_PreparedStudy = tuple[str, Callable[..., Any]]


@command(
    BranchOptions,
    out="Write the branch or the boundary (.csv, .npz, .parquet).",
    plot="Draw the branch or the boundary (.png, .svg, .pdf).",
)
def branch(call: Call[BranchOptions]) -> None:
    """Follow a branch of limit cycles along a parameter.

    Its cycles may be stable or unstable. Folds, period doublings, tori and the first cycle that
    touches y = 0, where the slider begins to leave the belt, are located on the way. A branch that
    is not connected to the one followed is not found. With --curve, follow Hopf points, folds or
    first touches over two parameters.
    """
    options = call.options
    varied = options.over if options.vary is None else (options.vary, *options.over)
    # Where --set changes a varied parameter, the branch begins near that value.
    scene = call.scene(varied=varied, begins_at_value=True)
    prepare = _prepare_boundary if options.curve else _prepare_branch
    kind, compute = prepare(scene, options)
    call.outputs.compute_and_deliver(kind, compute, label="branch")


def _prepare_branch(scene: "Scene", options: BranchOptions) -> _PreparedStudy:
    from fivtui.orbits import branch as compute
    from fivtui.ranges import parse_ends

    if options.vary is None:
        raise InputError("--vary: must be given, or --curve with --over twice")
    if options.over:
        raise InputError("--over: must be given with --curve")
    origin = _read_origin(options.origin)
    name, ends = parse_ends(options.vary, _EXAMPLE, flag="--vary")
    low, high = (None, None) if ends is None else ends
    return "branch", partial(
        compute,
        scene.parameters,
        name,
        low=low,
        high=high,
        origin=origin,
        # Follow the cycles of twice the period from the first period doubling.
        doubled=options.doubled,
        separation=scene.separation,
    )


def _prepare_boundary(scene: "Scene", options: BranchOptions) -> _PreparedStudy:
    from fivtui.orbits import BOUNDARIES, boundary as compute
    from fivtui.ranges import parse_ends

    curve = options.curve
    if curve not in BOUNDARIES:
        *kinds, final_kind = BOUNDARIES
        raise InputError(f"--curve {curve}: must be {', '.join(kinds)} or {final_kind}")
    for flag, is_given in (
        ("--vary", options.vary is not None),
        ("--from", options.origin is not None),
        ("--doubled", options.doubled),
    ):
        if is_given:
            raise InputError(f"{flag}: must be given without --curve")
    if len(options.over) != 2:
        raise InputError(f"--over: given {times_text(len(options.over))}; must be given twice")
    over = dict(parse_ends(text, _EXAMPLE, flag="--over") for text in options.over)
    if len(over) != 2:
        raise InputError(f"--over: {next(iter(over))} is given twice; must be two parameters")
    return "boundary", partial(compute, scene.parameters, curve, over, separation=scene.separation)


def _read_origin(text: str | None) -> Literal["hopf", "cycle"] | Path:
    # Where the branch begins: a Hopf point, a limit cycle that transients of the scene reach, or a
    # cycle in a file.
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
