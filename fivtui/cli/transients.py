"""Commands that run one scene.

The paper is *Nonlinear friction-induced vibration of a slider-belt system*.
"""

from functools import partial
from typing import TYPE_CHECKING, Any

from fivtui.model import InputError
from fivtui.options import options_class
from fivtui.transient import SimulateOptions, setting

from .command import Call, NoOptions, command
from .deliver import Outputs
from .options import print_json, print_note, print_written_files, progress_bar
from .paths import check_distinct_from_scene

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fivtui.scene import Scene, SceneTransient
    from fivtui.transient import Transient


@command(
    SimulateOptions,
    out="Write the trajectory (.csv, .npz, .parquet).",
    plot="Draw P, x and y over time (.png, .svg, .pdf).",
)
def simulate(call: Call[SimulateOptions]) -> None:
    """Compute one transient: peaks, separations, final state.

    With --error, a finer run verifies the result. If the two runs diverge, the command fails (exit
    status 3), but prints the part of the transient that is verified.
    """
    scene, options, outputs = call.scene(), call.options, call.outputs
    outputs.check("run")
    needs_samples = outputs.out is not None or outputs.plot is not None
    if not needs_samples and options.points != SimulateOptions.points:
        raise InputError("--points: must be given with --out or --plot")
    points = options.points if needs_samples else 0
    simulation = _simulate(scene, outputs, points, "transient", options.sensitivities)
    _print_note_if_stiff(simulation.transient)
    # Files hold the transient alone, tables also its estimated errors.
    outputs.write("run", simulation.transient)
    outputs.show("simulation", simulation)


def _simulate(
    scene: "Scene", outputs: Outputs, points: int, label: str, sensitivities: "Sequence[str]" = ()
) -> "SceneTransient":
    # Compute a transient with samples at equidistant points, 0 for none. If the runs that verify it
    # diverge, print the transient that ends before that time and is verified.
    import numpy as np

    from fivtui.scene import DivergenceError, scene_transient

    with progress_bar(label) as progress:
        try:
            return scene_transient(
                scene,
                samples=np.linspace(0.0, scene.t_end, points) if points else "none",
                progress=progress,
                sensitivities=sensitivities,
            )
        except DivergenceError as error:
            if error.before is not None:
                outputs.show("simulation", error.before)
            raise


def _print_note_if_stiff(result: "Transient") -> None:
    from fivtui.transient import find_stiffness

    # A linear system is solved exactly, without steps that stiffness could shorten.
    if result.method == "taylor" and result.stats.kernel != "exact":
        stiff = find_stiffness(result.system, t_end=result.t_end)
        if stiff is not None:
            print_note(f"{stiff}; this took {result.stats.steps} steps, try --method scipy-lsoda")


@command(
    NoOptions,
    out="Write the trajectory, if the scene asks for it (.csv, .npz, .parquet).",
)
def run(call: Call[NoOptions]) -> None:
    """Compute the outputs that a scene asks for.

    They are its `outputs`: stability, transient and trajectory; nothing else is computed.
    """
    from fivtui.equilibrium import stability

    # Parameters of the scene may follow tables over time.
    scene, outputs = call.scene(tables=True), call.outputs
    if not scene.outputs:
        raise InputError(f"scene {scene.name}: outputs must name what is to be computed")
    has_trajectory = "trajectory" in scene.outputs
    if has_trajectory and outputs.out is None:
        raise InputError(f"scene {scene.name}: its trajectory must have a file: --out FILE")
    if outputs.out is not None and not has_trajectory:
        raise InputError(f"scene {scene.name}: requires no trajectory; --out must not be given")
    outputs.check("run")
    results: dict[str, Any] = {}
    data: dict[str, Any] = {"scene": scene.name}
    if "stability" in scene.outputs:
        results["stability"] = stability(scene.parameters, separation=scene.separation)
        data["stability"] = results["stability"].to_dict()
    if has_trajectory or "transient" in scene.outputs:
        points = SimulateOptions.points if has_trajectory else 0
        results["simulation"] = simulation = _simulate(scene, outputs, points, scene.name)
        data["transient"] = simulation.transient.to_dict()
        if simulation.verified is not None:
            data["accuracy"] = simulation.verified.to_dict()
        outputs.write("run", simulation.transient)
    if outputs.as_json:
        print_json(data)
    else:
        for kind, result in results.items():
            outputs.show(kind, result)


@command(NoOptions, out="Folder for the FMU and the picture.", folder=True, json=False)
def compare(call: Call[NoOptions]) -> None:
    """Run a scene natively and as an FMU, in both contact cases.

    Separation is considered (Case 1) and ignored (Case 2). Builds the FMU, prints one table of
    peaks, separations, time off the belt, agreement and time taken, and draws the paper's figures
    10 to 12 as one picture.
    """
    from fivtui.scene import compare as compare_runs, comparison_files, print_comparison

    folder = call.outputs.path
    check_distinct_from_scene(comparison_files(folder), call.scene_name)
    with progress_bar("native and FMU") as progress:
        result = compare_runs(call.scene(), folder, progress=progress)
    print_comparison(result)
    print_written_files(result.fmu, result.figure)


@options_class
class AccuracyOptions:
    """Options of ``fivtui accuracy``."""

    ignore_separation: bool = setting("separation")
    t_end: str | None = setting("t_end")
    tol: str | None = setting("tol")


@command(AccuracyOptions)
def accuracy(call: Call[AccuracyOptions]) -> None:
    """Show how many digits of a transient can be trusted.

    Compares it with a run whose tolerance is 100 times finer. If --tol is 1e-11 or less, that
    tolerance is 100 times coarser, and the difference is the error of the coarser run. The key
    "finer" of --json names the tolerance or step of the second run. Shows how a small error grows
    along the run, and estimates the largest Lyapunov exponent: whether errors decay, stay bounded
    or grow in the long run.
    """
    from fivtui.assessment import accuracy as compute

    call.outputs.compute_and_deliver("accuracy", partial(compute, call.scene()))
