"""The command for branches of limit cycles, and for their boundaries over two parameters."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from fivtui.model import InputError
from fivtui.orbits import BranchOptions

from .arguments import times_text
from .command import Call, command

if TYPE_CHECKING:
    from fivtui.model import OnProgress
    from fivtui.scene import Scene

# Example of a range in messages.
_EXAMPLE: Final = "mu=0:2"
# The kind of a study, and its computation.
_PreparedStudy = tuple[str, Callable[["OnProgress"], Any]]


@command(
    BranchOptions,
    out="Write the branch or the boundary (.csv, .npz, .parquet).",
    plot="Draw the branch or the boundary (.png, .svg, .pdf).",
)
def branch(call: Call[BranchOptions]) -> None:
    """Follow a branch of limit cycles along a parameter.

    Its cycles may be stable or unstable. Folds, the first touch of y = 0, period doublings and tori
    are located on the way. A branch that is not connected to the one followed is not found. With
    --curve, follow Hopf points, folds or first touches over two parameters.
    """
    options = call.options
    scene = call.scene(varied=(options.vary or "", *options.over), centred=True)
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
    return "branch", lambda progress: compute(
        scene.parameters,
        name,
        low=low,
        high=high,
        origin=origin,
        doubled=options.doubled,
        separation=scene.separation,
        progress=progress,
    )


def _prepare_boundary(scene: "Scene", options: BranchOptions) -> _PreparedStudy:
    from fivtui.orbits import BOUNDARIES, boundary as compute
    from fivtui.ranges import parse_ends

    curve = options.curve
    if curve not in BOUNDARIES:
        raise InputError(f"--curve {curve}: must be {', '.join(BOUNDARIES[:-1])} or touch")
    for flag, value in (
        ("--vary", options.vary),
        ("--from", options.origin),
        ("--doubled", options.doubled or None),
    ):
        if value is not None:
            raise InputError(f"{flag}: must be given without --curve")
    if len(options.over) != 2:
        raise InputError(f"--over: given {times_text(len(options.over))}; must be given twice")
    over = dict(parse_ends(text, _EXAMPLE, flag="--over") for text in options.over)
    if len(over) != 2:
        raise InputError(f"--over: {next(iter(over))} is given twice; must be two parameters")
    return "boundary", lambda progress: compute(
        scene.parameters, curve, over, separation=scene.separation, progress=progress
    )


def _read_origin(text: str | None) -> Literal["hopf", "cycle"] | Path:
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
