"""Commands for stability, stability maps and attractors."""

from typing import TYPE_CHECKING, Any

from .arguments import option
from .completion import PARAMETER_VALUES, START_VALUES
from .deliver import check_outputs, show, write
from .group import commands
from .options import (
    force_option,
    ignore_option,
    json_option,
    output_option,
    print_json,
    progress_bar,
    say,
    scene_argument,
    scene_of,
    set_option,
    start_of,
    start_option,
)

if TYPE_CHECKING:
    from fivtui.scene import Scene


@commands.command()
@scene_argument
@set_option
@ignore_option
@option(
    "--attractors",
    is_flag=True,
    help="Also list the limit cycles at this μ, with the offset that leaves the equilibrium.",
)
@option(
    "--no-search",
    is_flag=True,
    help="Eigenvalues alone: no search for the friction that is safe.",
)
@output_option("--out", "FILE", "Write the eigenvalues over μ (.csv, .npz, .parquet).")
@output_option("--plot", "FILE", "Draw frequencies and growth rates over μ (.png, .svg, .pdf).")
@force_option
@json_option
def stability(scene: str, assignments: tuple[str, ...], **given: Any) -> None:
    """Print eigenvalues, modes, critical friction coefficient, and the friction that is safe.

    Eigenvalues are of the equilibrium, linearised there: they say what small disturbances do. A
    stable equilibrium may coexist with a large limit cycle: how far below the critical μ one was
    found, by continuation and a global search, is said after them (--no-search leaves that out).
    """
    from fivtui.equilibrium import stability as judge

    chosen = scene_of(scene, assignments, ignore_separation=given["ignore_separation"])
    out, plot, force, as_json = (given[name] for name in ("out", "plot", "force", "as_json"))
    check_outputs("stability", out, plot, force=force)
    result = judge(chosen.parameters, separation=chosen.separation)
    data = result.to_dict()
    write("stability", result, out, plot, force=force)
    if not as_json:
        show("stability", result)
    if not given["no_search"]:
        data |= _safe_friction(chosen, quiet=as_json)
    if given["attractors"]:
        from .attractor_tasks import SEARCH, carry_out

        data |= carry_out(SEARCH, chosen, quiet=as_json)
    if as_json:
        print_json(data)


def _safe_friction(chosen: "Scene", *, quiet: bool) -> dict[str, Any]:
    # What `stability` adds to its JSON of disturbances of any size.
    if chosen.parameters.v_belt is not None:
        return _reached(chosen, quiet=quiet)
    from fivtui.safety import safe_friction

    with progress_bar("safe friction") as progress:
        safe = safe_friction(chosen.parameters, separation=chosen.separation, progress=progress)
    if not quiet:
        show("safe-friction", safe)
    return safe.to_dict()


def _reached(chosen: "Scene", *, quiet: bool) -> dict[str, Any]:
    # The same on a belt of finite speed: what transients reach at this friction, and no other.
    from fivtui.orbits import coexistence, reached_words

    with progress_bar("attractors") as progress:
        found = coexistence(chosen.system, progress=progress)
    said = reached_words(found)
    if not quiet:
        say(said)
    return {"safe_mu": None, "safe_mu_basis": {"verdict": said, **found.to_dict()}}


@commands.command()
@scene_argument
@set_option
@start_option("Find the attractor that this start (m, m/s) reaches, and no others.")
@option(
    "--vary",
    shell_complete=PARAMETER_VALUES,
    metavar="NAME=START:STOP:COUNT[:log]",
    help="Continue all attractors along a parameter, upwards and downwards.",
)
@option(
    "--basin",
    "ranges",
    shell_complete=START_VALUES,
    multiple=True,
    metavar="NAME=START:STOP:COUNT",
    help="Basins of attraction over two of x0, vx0, y0, vy0 (give it twice); --start sets the "
    "others.",
)
@output_option("--out", "FILE", "Write the branches or the basins (.csv, .npz, .parquet).")
@output_option("--plot", "FILE", "Draw the branches or the basins (.png, .svg, .pdf).")
@force_option
@json_option
def attractors(scene: str, assignments: tuple[str, ...], **given: Any) -> None:
    """Find coexisting attractors: equilibrium and limit cycles.

    Without --vary, --basin and --start, motions from several starts around the equilibrium are
    followed until they settle. Limit cycles are confirmed by shooting, with Floquet multipliers.
    """
    from .attractor_tasks import carry_out, choose_task

    start = None if given["start"] is None else start_of(given["start"])
    data = carry_out(
        choose_task(given["vary"], given["ranges"], start),
        scene_of(scene, assignments, varied=() if given["vary"] is None else (given["vary"],)),
        out=given["out"],
        plot=given["plot"],
        force=given["force"],
        quiet=given["as_json"],
    )
    if given["as_json"]:
        print_json(data)


@commands.command("map")
@scene_argument
@set_option
@ignore_option
@option(
    "--over",
    "ranges",
    shell_complete=PARAMETER_VALUES,
    multiple=True,
    required=True,
    metavar="NAME=START:STOP:COUNT[:log]",
    help="A parameter and its values; give it twice.",
)
@option(
    "--value",
    default="growth-rate",
    show_default=True,
    metavar="growth-rate|critical-mu|unstable-modes|safe-mu|coexistence",
    help="Value computed at every point.",
)
@output_option("--out", "FILE", "Write the map (.csv, .npz, .parquet).")
@output_option("--plot", "FILE", "Draw the map (.png, .svg, .pdf).")
@force_option
@json_option
def map_over(scene: str, assignments: tuple[str, ...], **given: Any) -> None:
    """Map stability, or the friction that is safe, over two parameters.

    safe-mu is the least μ of the limit cycles that continuation finds, else the critical μ.
    coexistence has three regions: safe, safe for small disturbances alone (with the least vertical
    displacement from rest that escapes), and squealing.
    """
    from fivtui.maps import MAP_VALUES, check_map, compute_map, map_value
    from fivtui.model import ALL_PARAMETERS
    from fivtui.ranges import parse_ranges

    chosen = scene_of(
        scene,
        assignments,
        ignore_separation=given["ignore_separation"],
        varied=given["ranges"],
    )
    over = {
        each.name: each.values() for each in parse_ranges("--over", given["ranges"], ALL_PARAMETERS)
    }
    out, plot, force = given["out"], given["plot"], given["force"]
    check_map(map_value(given["value"], MAP_VALUES), tuple(over))
    check_outputs("map", out, plot, force=force)
    with progress_bar("map") as progress:
        result = compute_map(
            chosen.parameters,
            over,
            given["value"],
            separation=chosen.separation,
            progress=progress,
        )
    write("map", result, out, plot, force=force)
    show("map", result, as_json=given["as_json"])
