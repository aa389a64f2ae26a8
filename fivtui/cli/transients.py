"""Commands that run one scene."""

from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fivtui.model import InputError, Interval, parse_number

from .arguments import Whole, option
from .completion import METHOD_NAMES, PARAMETER_NAMES
from .deliver import check_outputs, show, write
from .group import commands
from .options import (
    error_option,
    error_targets_of,
    folder_option,
    force_option,
    ignore_option,
    json_option,
    output_option,
    over_time_option,
    print_json,
    progress_bar,
    say,
    say_without_effect,
    say_written,
    scene_argument,
    scene_of,
    set_option,
    start_of,
    start_option,
    t_end_option,
    tol_option,
)
from .paths import check_in_folder

if TYPE_CHECKING:
    from collections.abc import Iterator

    from fivtui.scene import Scene
    from fivtui.transient import Transient


@commands.command()
@scene_argument
@set_option
@ignore_option
@t_end_option
@option(
    "--method",
    metavar="NAME",
    help="Integration method: taylor, rk4, scipy-dop853, … (see fivtui methods).",
    shell_complete=METHOD_NAMES,
)
@tol_option
@option("--step", metavar="S", help="Step of rk4, or communication step of fmu, s.")
@error_option(
    "Error target in place of --tol or --step: refine until the error of QUANTITY is below R. "
    "QUANTITY: final (state), peak, half_range (half peak-to-peak over the second half of the run) "
    "or events (times of separation and reattachment, s)."
)
@start_option("Start state, m and m/s; static: at rest at the equilibrium of μ = 0.")
@option(
    "--sensitivity",
    "sensitivities",
    multiple=True,
    metavar="NAME",
    help="Add derivatives of final state and peaks by this parameter; may be repeated.",
    shell_complete=PARAMETER_NAMES,
)
@option(
    "--points",
    type=Whole(Interval(2, 10_000_000)),
    metavar="N",
    default=5001,
    show_default=True,
    help="Points of the trajectory written or drawn.",
)
@over_time_option
@output_option("--out", "FILE", "Write the trajectory (.csv, .npz, .parquet).")
@output_option("--plot", "FILE", "Draw P, x and y over time (.png, .svg, .pdf).")
@force_option
@json_option
def simulate(**given: Any) -> None:
    """Compute one transient: peaks, separations, final state.

    Where two runs that verify an error target part, the command fails (exit status 3), but prints
    what is verified up to then.
    """
    import numpy as np

    from fivtui.scene import scene_transient

    scene = changed_scene(scene_of(given["scene"], given["assignments"], over_time=True), given)
    out, plot, force = given["out"], given["plot"], given["force"]
    check_outputs("run", out, plot, force=force)
    stored = out is not None or plot is not None
    with progress_bar("transient") as progress, _shown_before_parting(as_json=given["as_json"]):
        run = scene_transient(
            scene,
            samples=np.linspace(0.0, scene.t_end, given["points"]) if stored else "none",
            progress=progress,
            sensitivities=given["sensitivities"],
        )
    _say_if_stiff(run.transient)
    write("run", run.transient, out, plot, force=force)
    show("simulation", run, as_json=given["as_json"])


@contextmanager
def _shown_before_parting(*, as_json: bool) -> "Iterator[None]":
    # Of two runs that part, what is verified before they do is printed.
    from fivtui.scene import PartedError

    try:
        yield
    except PartedError as error:
        if error.before is not None:
            show("simulation", error.before, as_json=as_json)
        raise


def changed_scene(scene: "Scene", given: dict[str, Any]) -> "Scene":
    """The scene with the options of `simulate` applied."""
    import dataclasses

    from fivtui.transient import check_horizon

    targets = error_targets_of(given["error_targets"])
    fixed = given["tol"] is not None or given["step"] is not None
    if targets and fixed:
        raise InputError("--error: must be given without --tol and --step, which follow from it")
    changes: dict[str, Any] = {
        name: given[name] for name in ("tol", "step", "method") if given[name] is not None
    }
    if given["t_end"] is not None:
        changes["t_end"] = check_horizon(given["t_end"])
    if given["start"] is not None:
        changes["start"] = start_of(given["start"])
    if given["ignore_separation"]:
        changes["separation"] = False
    if given.get("over_time") is not None:
        from fivtui.scene import read_over_time

        changes["over_time"] = read_over_time(given["over_time"])
    if targets or fixed:
        changes["accuracy"] = tuple(targets.items())
    changed = dataclasses.replace(scene, **changes)
    say_without_effect(changed)
    return changed


def _say_if_stiff(result: "Transient") -> None:
    from fivtui.transient import find_stiffness

    if result.method == "taylor" and result.stats.kernel != "exact":
        stiff = find_stiffness(result.system, t_end=result.t_end)
        if stiff is not None:
            say(f"{stiff}; this took {result.stats.steps} steps, try --method scipy-lsoda")


@commands.command()
@scene_argument
@set_option
@output_option(
    "--out", "FILE", "Write the trajectory, if the scene asks for it (.csv, .npz, .parquet)."
)
@force_option
@json_option
def run(scene: str, out: Path | None, force: bool, as_json: bool, **given: Any) -> None:
    """Compute the outputs that a scene asks for.

    They are its `outputs`: stability, transient and trajectory; nothing else is computed.
    """
    from fivtui.scene import run_scene

    chosen = scene_of(scene, given["assignments"], over_time=True)
    say_without_effect(chosen)
    if ("trajectory" in chosen.outputs) != (out is not None):
        wanted = (
            "its trajectory must have a file: --out FILE"
            if out is None
            else "requires no trajectory; --out must not be given"
        )
        raise InputError(f"scene {chosen.name}: {wanted}")
    check_outputs("run", out, None, force=force)
    with progress_bar(chosen.name) as progress, _shown_before_parting(as_json=as_json):
        result = run_scene(chosen, progress=progress)
    data: dict[str, Any] = {"scene": chosen.name}
    if result.stability is not None:
        data["stability"] = result.stability.to_dict()
    if result.run is not None:
        data["transient"] = result.run.transient.to_dict()
        if result.run.verified is not None:
            data["accuracy"] = result.run.verified.to_dict()
        write("run", result.run.transient, out, None, force=force)
    if as_json:
        print_json(data)
        return
    if result.stability is not None:
        show("stability", result.stability)
    if result.run is not None:
        show("simulation", result.run)


@commands.command()
@scene_argument
@set_option
@folder_option("Folder for the FMU and the picture.")
@force_option
def compare(scene: str, assignments: tuple[str, ...], out: Path, force: bool) -> None:
    """Run a scene natively and as an FMU, in both contact cases.

    Separation is considered (Case 1) and ignored (Case 2). Builds the FMU, prints one table of
    peaks, separations, time off the belt, agreement and time taken, and draws the paper's figures
    10 to 12 as one picture.
    """
    from fivtui.scene import compare as run, comparison_files, print_comparison

    check_in_folder(comparison_files(out), scene)
    with progress_bar("native and FMU") as progress:
        result = run(scene_of(scene, assignments), out, force=force, progress=progress)
    print_comparison(result)
    say_written(result.fmu, result.figure)


@commands.command()
@scene_argument
@set_option
@ignore_option
@t_end_option
@tol_option
@json_option
def accuracy(scene: str, assignments: tuple[str, ...], as_json: bool, **given: Any) -> None:
    """Show how many digits of a transient can be trusted.

    Compares it with a finer run, shows how a small error grows along the run, and estimates the
    largest Lyapunov exponent: whether errors decay, stay bounded or grow in the long run.
    """
    from dataclasses import replace

    from fivtui.assessment import accuracy as judge

    chosen = scene_of(scene, assignments)
    changes: dict[str, Any] = {
        name: parse_number(name, given[name], "a number")
        for name in ("t_end", "tol")
        if given[name] is not None
    }
    if given["ignore_separation"]:
        changes["separation"] = False
    with progress_bar("accuracy") as progress:
        found = judge(replace(chosen, **changes), progress=progress)
    show("accuracy", found, as_json=as_json)
