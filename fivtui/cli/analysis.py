"""Commands for stability, stability maps and attractors.

A scene is a parameter set with the settings of its transient, such as the start and the method. A
belt of finite speed has a value of `v_belt`; any other belt is always faster than the slider.
"""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from fivtui.maps import MapOptions
from fivtui.model import ALL_PARAMETERS, PARAMETERS, InputError
from fivtui.options import flag, option, options_class
from fivtui.transient import SETTINGS, START_SPECS, setting

from .arguments import times_text
from .command import Call, command
from .options import print_json, progress_bar

if TYPE_CHECKING:
    from fivtui.scene import Scene


@options_class
class StabilityOptions:
    """Options of ``fivtui stability``."""

    # The flag sets the scene's `separation` to False.
    ignore_separation: bool = setting("separation")
    attractors: bool = flag(
        "--attractors",
        "Also list the limit cycles at this μ, and the least displacements upwards and downwards "
        "from which the slider does not return to the equilibrium.",
    )
    no_search: bool = flag(
        "--no-search", "Eigenvalues only: do not search for the safe friction coefficient."
    )


@command(
    StabilityOptions,
    out="Write the eigenvalues over μ (.csv, .npz, .parquet).",
    plot="Draw frequencies and growth rates over μ (.png, .svg, .pdf).",
)
def stability(call: Call[StabilityOptions]) -> None:
    """Print eigenvalues, critical friction and safe friction.

    Eigenvalues of the linearised equilibrium predict the motion after small disturbances. A stable
    equilibrium may coexist with a large limit cycle. Continuation and a global search look for one
    below the critical μ; --no-search omits this.
    """
    from fivtui.equilibrium import stability as compute

    scene, outputs = call.scene(), call.outputs
    outputs.check("stability")
    result = compute(scene.parameters, separation=scene.separation)
    data = result.to_dict()
    outputs.write("stability", result)
    print_tables = not outputs.as_json
    if print_tables:
        outputs.show("stability", result)
    if not call.options.no_search:
        data |= _report_safe_friction(scene, call)
    if call.options.attractors:
        coexisting = _find_attractors(scene)
        if print_tables:
            outputs.show("attractors", coexisting)
        outputs.warn("attractors", coexisting)
        data |= coexisting.to_dict()
    if not print_tables:
        print_json(data)


def _report_safe_friction(scene: "Scene", call: Call[Any]) -> dict[str, Any]:
    # Compute and print the friction that is safe; returns its entries in the JSON of `stability`.
    if scene.parameters.v_belt is not None:
        from fivtui.console import print_list
        from fivtui.orbits import transients_phrase

        # On a belt of finite speed there is no search for the safe friction: transients show what
        # motions there are at the friction of the scene.
        coexisting = _find_attractors(scene)
        verdict = transients_phrase(coexisting)
        if not call.outputs.as_json:
            # The verdict begins with the name of its row.
            print_list("", [("transients", verdict.removeprefix("transients "))])
        return {"safe_mu": None, "safe_mu_basis": {"verdict": verdict, **coexisting.to_dict()}}
    from fivtui.safety import safe_friction

    with progress_bar("safe friction") as progress:
        safe = safe_friction(scene.parameters, separation=scene.separation, progress=progress)
    if not call.outputs.as_json:
        call.outputs.show("safe-friction", safe)
    return safe.to_dict()


def _find_attractors(scene: "Scene") -> Any:
    from fivtui.orbits import coexistence

    with progress_bar("attractors") as progress:
        return coexistence(scene.system, progress=progress)


@options_class
class AttractorsOptions:
    """Options of ``fivtui attractors``."""

    start: str | None = setting(
        "start",
        "Find the attractor that this start (m, m/s) reaches, and no others.",
        # The option sets the start of this search, not that of the scene.
        for_scene=False,
    )
    vary: str | None = option(
        "--vary",
        "Continue all attractors along a parameter, upwards and downwards.",
        metavar="NAME=START:STOP:COUNT[:log]",
        completions=lambda: (f"{name}=" for name in PARAMETERS),
    )
    basin: tuple[str, ...] = option(
        "--basin",
        "Basins of attraction over two of x0, vx0, y0, vy0 (give it twice); --start sets the "
        "others.",
        metavar="NAME=START:STOP:COUNT",
        multiple=True,
        completions=lambda: (f"{name}=" for name in START_SPECS),
    )


@command(
    AttractorsOptions,
    out="Write the branches or the basins (.csv, .npz, .parquet).",
    plot="Draw the branches or the basins (.png, .svg, .pdf).",
)
def attractors(call: Call[AttractorsOptions]) -> None:
    """Find coexisting attractors: equilibrium and limit cycles.

    Without --vary, --basin and --start, motions from several starts around the equilibrium are
    followed until they settle. Limit cycles are confirmed by shooting, with Floquet multipliers.
    """
    from fivtui.studies import study

    kind, compute = _attractor_study(call.options)
    vary = call.options.vary
    scene = call.scene(varied=() if vary is None else (vary,))
    outputs = call.outputs
    has_files = bool(study(kind).suffixes)
    if not has_files and (outputs.out is not None or outputs.plot is not None):
        raise InputError("--out and --plot: must be given with --vary or --basin")
    outputs.compute_and_deliver(kind, partial(compute, scene), label="attractors")


# Computes a study of a scene, with the argument `progress`.
_StudyFunction = Callable[..., Any]


def _attractor_study(options: AttractorsOptions) -> tuple[str, _StudyFunction]:
    # The kind of study that the options ask for, and its computation.
    from fivtui.orbits import Explorer, basin, coexistence, continuation
    from fivtui.ranges import parse_range, parse_ranges

    start = None if options.start is None else SETTINGS["start"].read(options.start)
    if options.vary is not None:
        if options.basin or start is not None:
            raise InputError("--vary: must be given without --basin and --start")
        varied = parse_range("--vary", options.vary, ALL_PARAMETERS)
        name, values = varied.name, varied.values()
        return "branches", lambda scene, progress: continuation(
            scene.parameters, name, values, separation=scene.separation, progress=progress
        )
    if options.basin:
        ranges = parse_ranges("--basin", options.basin, START_SPECS)
        if len(ranges) != 2:
            raise InputError(f"--basin: given {times_text(len(ranges))}; must be given twice")
        axes = {axis.name: axis.values() for axis in ranges}
        return "basin", lambda scene, progress: basin(
            scene.parameters, axes, separation=scene.separation, start=start, progress=progress
        )
    if start is not None:
        return "attractor", lambda scene, **_: Explorer(scene.system).reach(start)
    return "attractors", lambda scene, progress: coexistence(scene.system, progress=progress)


@command(
    MapOptions,
    name="map",
    out="Write the map (.csv, .npz, .parquet).",
    plot="Draw the map (.png, .svg, .pdf).",
)
def map_parameters(call: Call[MapOptions]) -> None:
    """Map stability or safe friction over two parameters.

    --value safe-mu is the least μ of the limit cycles that continuation finds, else the critical μ.
    A global search for further cycles is made at the corners and the centre only.
    --value coexistence has three regions: safe, safe for small disturbances alone, and squealing.
    In the second it adds the least vertical displacement from which the slider does not return to
    rest.
    """
    from fivtui.maps import MAP_VALUES, check_map, compute_map, parse_map_value
    from fivtui.ranges import parse_ranges

    value = call.options.value
    ranges = parse_ranges("--over", call.options.over, ALL_PARAMETERS)
    axis_values = {axis.name: axis.values() for axis in ranges}
    check_map(parse_map_value(value, MAP_VALUES), tuple(axis_values))
    scene = call.scene(varied=call.options.over)
    call.outputs.compute_and_deliver(
        "map",
        partial(compute_map, scene.parameters, axis_values, value, separation=scene.separation),
    )
