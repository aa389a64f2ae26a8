"""The command line: one function a command, everything computed elsewhere."""

import json
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NoReturn

import click

from .core.errors import Cancelled, ComputationError, InputError
from .core.parameters import PARAMETERS, parameter_spec, parse_number, unknown_name

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from .core.outcome import Transient
    from .core.request import Start
    from .scene import Scene
    from .sweeps import Engine

EXIT_INPUT: Final = 2
EXIT_COMPUTATION: Final = 3
EXIT_INTERRUPTED: Final = 130
TRACEBACK_VARIABLE: Final = "FIVTUI_TRACEBACK"
_DEBUG: Final = f"please report it, with what {TRACEBACK_VARIABLE}=1 shows"


class Commands(click.Group):
    """A group that names the nearest command when one is unknown."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command that `args` begin with."""
        if args and self.get_command(ctx, args[0]) is None:
            raise unknown_name("command", args[0], self.list_commands(ctx))
        return super().resolve_command(ctx, args)


def main(args: Sequence[str] | None = None) -> NoReturn:
    """Run a command and exit: 0 done, 2 wrong input, 3 not finished.

    Parameters
    ----------
    args : sequence of str, optional
        The arguments; those of the process if not given.
    """
    sys.exit(_run(args))


def _run(args: Sequence[str] | None) -> int:
    message, code = "", 0
    try:
        fivtui.main(args=args, prog_name="fivtui", standalone_mode=False)
        sys.stdout.flush()
    except InputError as error:
        message, code = str(error), EXIT_INPUT
    except click.ClickException as error:
        message, code = " ".join(error.format_message().split()), EXIT_INPUT
    except ComputationError as error:
        message, code = str(error), EXIT_COMPUTATION
    except MemoryError:
        message, code = "out of memory; ask for fewer points or a shorter horizon", EXIT_COMPUTATION
    except (click.Abort, Cancelled, KeyboardInterrupt) as error:
        message, code = ": ".join(filter(None, ["cancelled", str(error)])), EXIT_INTERRUPTED
    except BrokenPipeError:
        # The reader has gone: nothing more to say, and nothing to flush at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except Exception as error:
        if TRACEBACK_VARIABLE in os.environ:
            raise
        message, code = f"unexpected {type(error).__name__}: {error}; {_DEBUG}", EXIT_COMPUTATION
    if message:
        _say(f"fivtui: {message}")
    return code


def _say(message: str) -> None:
    click.echo(message, err=True)


def _print_json(data: Any) -> None:
    click.echo(json.dumps(data, ensure_ascii=False, allow_nan=False, indent=2))


def _assigned(flag: str, assignments: Sequence[str], example: str) -> dict[str, str]:
    values: dict[str, str] = {}
    for assignment in assignments:
        name, equals, text = assignment.partition("=")
        if not equals or not name.strip():
            raise InputError(f"{flag} {assignment}: allowed is NAME=VALUE, e.g. {flag} {example}")
        values[name.strip()] = text.strip()
    return values


def _scene(name: str, assignments: Sequence[str]) -> "Scene":
    from .scene import find_scene

    changes = _assigned("--set", assignments, "F=120")
    return find_scene(name).with_values(
        {parameter: parameter_spec(parameter).check(text) for parameter, text in changes.items()}
    )


def _start(text: str) -> "Start":
    if text == "static":
        return "static"
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(
            f"--start {text}: allowed is static, or four numbers x,vx,y,vy in m and m/s"
        ) from None


scene_argument = click.argument("scene", default="base", metavar="[SCENE]")
set_option = click.option(
    "--set",
    "assignments",
    multiple=True,
    metavar="NAME=VALUE",
    help=f"Change a parameter ({', '.join(PARAMETERS)}); may be repeated.",
)
json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
force_option = click.option("--force", is_flag=True, help="Replace outputs that exist.")
fmu_argument = click.argument("fmu_file", type=click.Path(path_type=Path), metavar="FILE.fmu")


def _path_option(flag: str, metavar: str, text: str, **more: Any) -> Callable[..., Any]:
    return click.option(flag, type=click.Path(path_type=Path), metavar=metavar, help=text, **more)


def error_option(text: str) -> Callable[..., Any]:
    """The option that asks for errors."""
    return click.option("--error", "wishes", multiple=True, metavar="QUANTITY=R", help=text)


@click.group(cls=Commands, invoke_without_command=True, context_settings={"max_content_width": 100})
@click.version_option(package_name="fivtui", message="%(prog)s %(version)s")
@click.pass_context
def fivtui(context: click.Context) -> None:
    """Friction-induced vibration of a slider on a belt: stability, transients, FMU.

    Without a command the terminal laboratory starts. SCENE is the name of a preset or a TOML file;
    without it the base scene of the paper is taken.
    """
    if context.invoked_subcommand is None:
        if not (sys.stdin.isatty() and sys.stdout.isatty()):
            raise InputError("the terminal laboratory needs a terminal; see fivtui --help")
        from .tui.app import run

        run()


@fivtui.command()
@scene_argument
@set_option
@click.option(
    "--attractors",
    is_flag=True,
    help="Also look for limit cycles beside the equilibrium, by transients and shooting.",
)
@json_option
def stability(scene: str, assignments: tuple[str, ...], attractors: bool, as_json: bool) -> None:
    """Show equilibrium, eigenvalues, modes, growth rate and critical friction coefficient."""
    from .core.stability import stability as judge
    from .report import print_stability
    from .results import stability_to_dict

    chosen = _scene(scene, assignments)
    verdict = judge(chosen.parameters, separation=chosen.separation)
    data = stability_to_dict(verdict)
    if not as_json:
        print_stability(verdict, chosen.parameters)
    if attractors:
        from .attractor_tasks import SEARCH, carry_out

        data |= carry_out(SEARCH, chosen, quiet=as_json)
    if as_json:
        _print_json(data)


@fivtui.command()
@scene_argument
@set_option
@click.option("--start", metavar="static|x,vx,y,vy", help="What this start alone reaches.")
@click.option(
    "--vary",
    metavar="NAME=START:STOP:COUNT[:log]",
    help="Follow the attractors along a parameter, up and down.",
)
@click.option(
    "--basin",
    "ranges",
    multiple=True,
    metavar="NAME=START:STOP:COUNT",
    help="What starts reach: give two of x0, vx0, y0, vy0; the others are --start's.",
)
@_path_option("--out", "FILE", "Write the branches or the basins (.csv, .npz, .parquet).")
@_path_option("--plot", "FILE", "Draw the branches or the basins (.png, .svg, .pdf).")
@force_option
@json_option
def attractors(scene: str, assignments: tuple[str, ...], **given: Any) -> None:
    """Find what motions end in: the equilibrium, limit cycles, or nothing.

    Limit cycles are confirmed by shooting, with their Floquet multipliers. Without an option the
    attractors around the equilibrium are listed.
    """
    from .attractor_tasks import carry_out, choose_task

    start = None if given["start"] is None else _start(given["start"])
    data = carry_out(
        choose_task(given["vary"], given["ranges"], start),
        _scene(scene, assignments),
        out=given["out"],
        plot=given["plot"],
        force=given["force"],
        quiet=given["as_json"],
    )
    if given["as_json"]:
        _print_json(data)


@fivtui.command("map")
@scene_argument
@set_option
@click.option(
    "--over",
    "ranges",
    multiple=True,
    required=True,
    metavar="NAME=START:STOP:COUNT[:log]",
    help="A parameter and its values; give two.",
)
@click.option(
    "--value",
    default="growth-rate",
    show_default=True,
    metavar="growth-rate|critical-mu|unstable-modes",
    help="What is computed at every point.",
)
@_path_option("--out", "FILE", "Write the map (.csv, .npz, .parquet).")
@_path_option("--plot", "FILE", "Write the map as a figure (.png, .svg, .pdf).")
@force_option
@json_option
def stability_map(scene: str, assignments: tuple[str, ...], **given: Any) -> None:
    """Show the stability of the equilibrium over two parameters."""
    from .core.stability_map import stability_map as compute
    from .map_results import check_map_path, map_to_dict, save_map
    from .ranges import parse_ranges
    from .report import Progress, print_map

    chosen = _scene(scene, assignments)
    over = {each.name: each.values() for each in parse_ranges("--over", given["ranges"])}
    out, plot, force = given["out"], given["plot"], given["force"]
    _check_outputs(out, plot, check_map_path, force=force)
    with Progress("map") as progress:
        result = compute(
            chosen.parameters,
            over,
            given["value"],
            separation=chosen.separation,
            progress=progress,
        )
    if out is not None:
        save_map(result, out, force=force)
        _say(f"wrote {out}")
    if plot is not None:
        from .figures import save_figure
        from .map_figure import map_figure

        save_figure(map_figure(result), plot, force=force)
        _say(f"wrote {plot}")
    if given["as_json"]:
        _print_json(map_to_dict(result))
    else:
        print_map(result)


@fivtui.command()
@scene_argument
@set_option
@click.option("--ignore-separation", is_flag=True, help="Contact never breaks (Case 2).")
@click.option("--t-end", metavar="S", help="Horizon in seconds.")
@click.option("--method", metavar="NAME", help="taylor, rk4, scipy-dop853, …: see fivtui methods.")
@click.option("--tol", metavar="R", help="Relative tolerance, 1e-13 to 1e-2.")
@click.option("--step", metavar="S", help="Step of rk4, communication step of fmu.")
@error_option("Choose tol or step for an error of final, peak, half_range or events (s).")
@click.option("--start", metavar="static|x,vx,y,vy", help="Start state, m and m/s.")
@click.option(
    "--points",
    type=click.IntRange(2, 10_000_000),
    default=5001,
    show_default=True,
    help="Points of a written trajectory.",
)
@_path_option("--out", "FILE", "Write the trajectory (.csv, .npz, .parquet).")
@_path_option("--plot", "FILE", "Write P, x and y over time (.png, .svg, .pdf).")
@force_option
@json_option
def simulate(**given: Any) -> None:
    """Compute a transient; print its extremes, events and final state."""
    import numpy as np

    from .report import Progress, print_transient
    from .results import check_trajectory_path
    from .runner import scene_transient
    from .verified import verified_to_dict

    scene = _changed(_scene(given["scene"], given["assignments"]), given)
    out, plot, force = given["out"], given["plot"], given["force"]
    _check_outputs(out, plot, check_trajectory_path, force=force)
    stored = out is not None or plot is not None
    with Progress("transient") as progress:
        run = scene_transient(
            scene,
            samples=np.linspace(0.0, scene.t_end, given["points"]) if stored else "none",
            progress=progress,
        )
    result = run.transient
    _say_if_stiff(result)
    if out is not None:
        from .results import save_trajectory

        save_trajectory(result, out, force=force)
        _say(f"wrote {out}")
    if plot is not None:
        from .figures import save_figure, transient_figure

        save_figure(transient_figure([result]), plot, force=force)
        _say(f"wrote {plot}")
    if given["as_json"]:
        from .results import transient_to_dict

        known = {} if run.verified is None else {"accuracy": verified_to_dict(run.verified)}
        _print_json({**transient_to_dict(result), **known})
    else:
        print_transient(result, run.verified)


def _changed(scene: "Scene", given: dict[str, Any]) -> "Scene":
    # The scene with what the options of `simulate` say.
    import dataclasses

    from .core.request import check_horizon

    wishes = _wishes(given["wishes"])
    fixed = given["tol"] is not None or given["step"] is not None
    if wishes and fixed:
        raise InputError("--error: not allowed beside --tol or --step, which follow from it")
    changes: dict[str, Any] = {
        name: given[name] for name in ("tol", "step", "method") if given[name] is not None
    }
    if given["t_end"] is not None:
        changes["t_end"] = check_horizon(given["t_end"])
    if given["start"] is not None:
        changes["start"] = _start(given["start"])
    if given["ignore_separation"]:
        changes["separation"] = False
    if wishes or fixed:
        changes["accuracy"] = tuple(wishes.items())
    return dataclasses.replace(scene, **changes)


def _say_if_stiff(result: "Transient") -> None:
    from .core.stiffness import stiffness

    if result.method == "taylor" and result.stats.kernel != "exact":
        stiff = stiffness(result.parameters, t_end=result.t_end, separation=result.separation)
        if stiff is not None:
            _say(f"{stiff}; this took {result.stats.steps} steps, try --method scipy-lsoda")


def _check_outputs(
    out: Path | None, plot: Path | None, check_data: Callable[..., None], *, force: bool
) -> None:
    if out is not None:
        check_data(out, force=force)
    if plot is not None:
        from .figures import check_figure_path

        check_figure_path(plot, force=force)


@fivtui.command()
@scene_argument
@set_option
@click.option(
    "--vary",
    "varied",
    multiple=True,
    required=True,
    metavar="NAME=START:STOP:COUNT[:log]",
    help="What varies: a parameter, or x0, vx0, y0, vy0 of the start; may be repeated. Also "
    "NAME=V1,V2,…; without COUNT in random and sobol.",
)
@click.option(
    "--design",
    "kind",
    type=click.Choice(["product", "list", "random", "sobol"]),
    default="product",
    show_default=True,
    help="Every value with every other, values side by side, or points between the ends.",
)
@click.option("--count", type=int, metavar="N", help="Points of random and sobol.")
@click.option("--seed", type=int, metavar="S", help="Seed of random and sobol.  [default: 0]")
@click.option("--ignore-separation", is_flag=True, help="Contact never breaks (Case 2).")
@click.option("--both", is_flag=True, help="Separation considered and ignored.")
@click.option("--t-end", metavar="S", help="Horizon in seconds.")
@click.option("--tol", metavar="R", help="Relative tolerance, 1e-13 to 1e-2.")
@click.option("--start", metavar="static|x,vx,y,vy", help="Start state, m and m/s.")
@click.option(
    "--output",
    "outputs",
    multiple=True,
    metavar="NAME",
    help="Compute only this one (y_abs, …, growth_rate, stable); may be repeated.",
)
@click.option("--workers", type=int, metavar="N", help="Threads.  [default: all processors]")
@click.option("--scheduler", metavar="ADDRESS", help="Compute on this Dask cluster.")
@click.option("--piece", type=click.IntRange(min=1), metavar="N", help="Members stored at a time.")
@_path_option("--out", "FILE", "Write the rows (.csv, .parquet); continues what was stopped.")
@_path_option("--plot", "FILE", "Draw amplitudes over one or two names (.png, .svg, .pdf).")
@force_option
@json_option
def sweep(**given: Any) -> None:
    """Compute many transients that differ in parameters, start and physics.

    With --out, rows are stored piece by piece: whatever stops the sweep, the same command
    continues it. Members that cannot be computed are rows that say why.
    """
    from contextlib import ExitStack

    from .sweep_report import SweepProgress, print_sweep
    from .sweep_request import parse_cases, parse_design, study_of
    from .sweeps import check_in_memory, load_sweep, sweep_in_memory, sweep_to_file

    scene = _scene(given["scene"], given["assignments"])
    study = study_of(
        scene,
        parse_design(given["varied"], given["kind"], given["count"], given["seed"]),
        cases=parse_cases(ignored=given["ignore_separation"], both=given["both"]),
        start=None if given["start"] is None else _start(given["start"]),
        t_end=given["t_end"],
        tol=given["tol"],
        outputs=given["outputs"],
    )
    out, plot, force, as_json = (given[name] for name in ("out", "plot", "force", "as_json"))
    if out is None or plot is not None or as_json:
        check_in_memory(study)
    if plot is not None:
        from .figures import check_figure_path
        from .sweep_figures import check_drawable

        check_figure_path(plot, force=force)
        check_drawable(study)
    with ExitStack() as stack:
        engine = stack.enter_context(_engine(given["scheduler"], given["workers"]))
        progress = stack.enter_context(SweepProgress(study.members))
        if out is None:
            result = sweep_in_memory(study, engine, progress=progress)
        else:
            written = sweep_to_file(
                study, out, engine, size=given["piece"], force=force, progress=progress
            )
    if out is not None:
        _say(f"wrote {out}: {written}")
        if plot is not None or as_json:
            result = load_sweep(study, out)
    if plot is not None:
        from .figures import save_figure
        from .sweep_figures import sweep_figure

        save_figure(sweep_figure(result), plot, force=force)
        _say(f"wrote {plot}")
    if as_json:
        _print_json({"columns": result.columns, "rows": result.rows})
    elif out is None:
        print_sweep(result, chosen=bool(given["outputs"]))


def _engine(scheduler: str | None, workers: int | None) -> "AbstractContextManager[Engine]":
    if scheduler is not None:
        from .cluster import cluster_engine

        if workers is not None:
            raise InputError("--workers: the cluster of --scheduler has its own")
        return cluster_engine(scheduler)
    from contextlib import nullcontext

    from .sweeps import local_engine

    return nullcontext(local_engine(workers))


@fivtui.command()
@scene_argument
@set_option
@_path_option("--out", "FILE", "Write the trajectory, if required (.csv, .npz, .parquet).")
@force_option
@json_option
def run(scene: str, out: Path | None, force: bool, as_json: bool, **given: Any) -> None:
    """Compute what a scene requires: stability, transient, trajectory; nothing else."""
    from .report import Progress, print_stability, print_transient
    from .results import (
        check_trajectory_path,
        save_trajectory,
        stability_to_dict,
        transient_to_dict,
    )
    from .runner import run_scene
    from .verified import verified_to_dict

    chosen = _scene(scene, given["assignments"])
    if ("trajectory" in chosen.outputs) != (out is not None):
        wanted = "a file for it: --out FILE" if out is None else "no --out: it is not required"
        raise InputError(f"trajectory of the scene {chosen.name}: allowed is {wanted}")
    _check_outputs(out, None, check_trajectory_path, force=force)
    with Progress(chosen.name) as progress:
        result = run_scene(chosen, progress=progress)
    data: dict[str, Any] = {"scene": chosen.name}
    if result.stability is not None:
        data["stability"] = stability_to_dict(result.stability)
    if result.run is not None:
        data["transient"] = transient_to_dict(result.run.transient)
        if result.run.verified is not None:
            data["accuracy"] = verified_to_dict(result.run.verified)
        if out is not None:
            save_trajectory(result.run.transient, out, force=force)
            _say(f"wrote {out}")
    if as_json:
        _print_json(data)
        return
    if result.stability is not None:
        print_stability(result.stability, chosen.parameters)
    if result.run is not None:
        print_transient(result.run.transient, result.run.verified)


@fivtui.command()
@scene_argument
@set_option
@_path_option("--out", "DIR", "Folder for the FMU and the picture.", required=True)
@force_option
def compare(scene: str, assignments: tuple[str, ...], out: Path, force: bool) -> None:
    """Run a scene natively and through the FMU, separation considered and ignored.

    Builds the FMU, prints one table of peaks, separations, time off the belt, agreement and time
    taken, and draws the paper's Figs. 10 to 12 as one picture.
    """
    from .compare import compare as run
    from .report import Progress, print_comparison

    with Progress("native and FMU") as progress:
        result = run(_scene(scene, assignments), out, force=force, progress=progress)
    print_comparison(result)
    _say(f"wrote {result.fmu} and {result.figure}")


@fivtui.command()
@click.argument("numbers", nargs=-1, metavar="[N ...]")
@_path_option("--out", "DIR", "Folder for the pictures and their data.", required=True)
@click.option(
    "--format",
    "formats",
    multiple=True,
    metavar="NAME",
    help="pdf, svg or png; may be repeated.  [default: pdf and png]",
)
@force_option
def figures(numbers: tuple[str, ...], out: Path, formats: tuple[str, ...], force: bool) -> None:
    """Draw the paper's Figs. 2 to 16, or those of the numbers N (or ranges such as 3-9).

    Beside each picture stands a CSV file with its data, their units and the parameters.
    """
    from .paper.figures import DEFAULT_FORMATS, figure_numbers, save_figures
    from .report import Progress

    with Progress("figures") as progress:
        written = save_figures(
            figure_numbers(numbers),
            out,
            formats=formats or DEFAULT_FORMATS,
            force=force,
            progress=progress,
        )
    for files in written:
        _say(f"wrote {', '.join(str(path) for path in (*files.pictures, *files.data))}")


@fivtui.command()
@click.option("--markdown", is_flag=True, help="Print a Markdown table.")
@json_option
def claims(markdown: bool, as_json: bool) -> None:
    """Hold every testable statement of the paper against the model.

    Each is shown with its section, what the paper states, what is computed, and the verdict.
    """
    from .paper.claims import check_claims, claims_to_list
    from .report import Progress, claims_markdown, print_claims

    if markdown and as_json:
        raise InputError("claims: allowed is one of --json and --markdown")
    with Progress("claims") as progress:
        checked = check_claims(progress=progress)
    if as_json:
        _print_json(claims_to_list(checked))
    elif markdown:
        click.echo(claims_markdown(checked))
    else:
        print_claims(checked)


@fivtui.command()
@scene_argument
@set_option
@click.option("--ignore-separation", is_flag=True, help="Contact never breaks (Case 2).")
@click.option("--t-end", metavar="S", help="Horizon in seconds.")
@click.option("--tol", metavar="R", help="Relative tolerance, 1e-13 to 1e-2.")
@json_option
def accuracy(scene: str, assignments: tuple[str, ...], as_json: bool, **given: Any) -> None:
    """Say how far to trust the numbers of a transient.

    Holds it against a finer run, follows how an error at the start grows, and estimates the largest
    Lyapunov exponent: whether errors decay, stay bounded or grow in the long run.
    """
    from dataclasses import replace

    from .accuracy import accuracy as judge
    from .accuracy import accuracy_to_dict
    from .report import Progress, print_accuracy

    chosen = _scene(scene, assignments)
    changes: dict[str, Any] = {
        name: parse_number(name, given[name], "a number")
        for name in ("t_end", "tol")
        if given[name] is not None
    }
    if given["ignore_separation"]:
        changes["separation"] = False
    with Progress("accuracy") as progress:
        found = judge(replace(chosen, **changes), progress=progress)
    if as_json:
        _print_json(accuracy_to_dict(found))
    else:
        print_accuracy(found)


@fivtui.command()
@json_option
def extremes(as_json: bool) -> None:
    """Try every method on scenes that break solvers: right, refused or wrong.

    Each result is held against a solution in quadruple precision. A method is refused where it says
    itself that it cannot go on, or needs more steps than the trial allows.
    """
    from .report import Progress, print_trials
    from .trials import run_trials, trials_to_dict

    with Progress("extremes") as progress:
        found = run_trials(progress=progress)
    if as_json:
        _print_json(trials_to_dict(found))
    else:
        print_trials(found)


@fivtui.command()
@scene_argument
@set_option
@click.option("--thorough", is_flag=True, help="Take about two minutes instead of seven seconds.")
@error_option("Name the cheapest setting for an error of final, peak, half_range or events (s).")
@_path_option("--out", "FILE.csv", "Write all settings measured.")
@_path_option("--plot", "FILE", "Draw error against CPU time (.png, .svg, .pdf).")
@force_option
@json_option
def tradeoff(scene: str, assignments: tuple[str, ...], **given: Any) -> None:
    """Measure what accuracy costs on this machine, for every method and setting."""
    from .report import Progress
    from .tradeoff import cheapest_to_dict, measure_tradeoff, save_tradeoff, tradeoff_to_dict
    from .tradeoff_report import check_tradeoff_path, print_tradeoff

    out, plot, force = given["out"], given["plot"], given["force"]
    wishes = _wishes(given["wishes"])
    chosen = _scene(scene, assignments)
    _check_outputs(out, plot, check_tradeoff_path, force=force)
    with Progress("trade-off") as progress:
        result = measure_tradeoff(chosen, thorough=given["thorough"], progress=progress)
    if out is not None:
        save_tradeoff(result, out, force=force)
        _say(f"wrote {out}")
    if plot is not None:
        from .figures import save_figure
        from .tradeoff_figure import tradeoff_figure

        save_figure(tradeoff_figure(result), plot, force=force)
        _say(f"wrote {plot}")
    if given["as_json"]:
        _print_json({**tradeoff_to_dict(result), **cheapest_to_dict(result, wishes)})
    else:
        print_tradeoff(result, wishes)


def _wishes(assignments: Sequence[str]) -> dict[str, float]:
    from .core.tradeoff import check_error, check_quantity

    pairs = _assigned("--error", assignments, "peak=1e-4")
    return {check_quantity(name): check_error(name, text) for name, text in pairs.items()}


@fivtui.command()
@json_option
def presets(as_json: bool) -> None:
    """List the scenes that come with the program."""
    from .presets import PRESETS
    from .scene import scene_to_dict

    if as_json:
        _print_json({name: scene_to_dict(scene) for name, scene in PRESETS.items()})
    else:
        from .report import print_list

        rows = [(name, scene.description) for name, scene in PRESETS.items()]
        print_list("Presets", rows)


@fivtui.command()
def methods() -> None:
    """List the integration methods."""
    from .report import print_list
    from .simulation import ALL_METHODS

    print_list("Methods", list(ALL_METHODS.items()))


@fivtui.group(cls=Commands)
def fmu() -> None:
    """Build, check and run the FMU (FMI 2.0 co-simulation)."""


@fmu.command("build")
@_path_option("--out", "FILE.fmu", "The FMU to write.", required=True)
@click.option("--component", default="slider-belt", help="slider-belt (default) or brake-actuator.")
@click.option("--fmi", default="2", help="2 (default), or 3: model exchange, experimental.")
@force_option
def fmu_build(out: Path, component: str, fmi: str, force: bool) -> None:
    """Export the slider-belt, or the brake actuator that presses it, as an FMU."""
    from fmu_src.builder import build_fmu

    build_fmu(out, component=component, fmi=fmi, force=force)
    _say(f"wrote {out}")


@fmu.command("system")
@_path_option("--out", "FILE.ssp", "The archive to write.", required=True)
@force_option
def fmu_system(out: Path, force: bool) -> None:
    """Export the slider-belt pressed by the brake actuator as an SSP archive."""
    from fmu_src.ssp import build_ssp

    build_ssp(out, force=force)
    _say(f"wrote {out}")


@fmu.command("check")
@fmu_argument
@json_option
def fmu_check(fmu_file: Path, as_json: bool) -> None:
    """Check that an FMU follows the standard and runs; exit 2 if it has problems."""
    from fmu_src.check import check_fmu

    problems = check_fmu(fmu_file)
    if as_json:
        _print_json({"file": str(fmu_file), "problems": problems})
    elif problems:
        click.echo("\n".join(problems))
    else:
        click.echo(f"{fmu_file}: no problems")
    if problems:
        raise InputError(f"{fmu_file} is not a sound FMU: problems found: {len(problems)}")


@fmu.command("run")
@fmu_argument
@click.option("--t-end", metavar="S", help="Stop time; by default that of the FMU.")
@click.option("--output-interval", metavar="S", help="Time between recorded points.")
@click.option(
    "--set",
    "assignments",
    multiple=True,
    metavar="NAME=VALUE",
    help="Start value of a variable of the FMU; may be repeated.",
)
@click.option("--output", "outputs", multiple=True, metavar="NAME", help="Record only this one.")
@click.option("--tol", metavar="R", help="Tolerance given to the FMU.")
@_path_option("--input", "FILE.csv", "Inputs over time: a column time, and one for each input.")
@_path_option("--out", "FILE.csv", "Write what was recorded.")
@_path_option("--events", "FILE.csv", "Write when recorded discrete variables changed.")
@force_option
@json_option
def fmu_run(fmu_file: Path, out: Path | None, force: bool, as_json: bool, **given: Any) -> None:
    """Run an FMU for co-simulation through fmpy; print its last values or write all."""
    from .fmu_run import check_run_path, run_fmu, save_fmu_events, save_fmu_run
    from .report import Progress, print_list

    events = given["events"]
    for path in (out, events):
        if path is not None:
            check_run_path(path, force=force)
    with Progress("FMU") as progress:
        run = run_fmu(
            fmu_file,
            t_end=given["t_end"],
            output_interval=given["output_interval"],
            start_values=_assigned("--set", given["assignments"], "F=60"),
            outputs=given["outputs"] or None,
            input_csv=given["input"],
            tol=given["tol"],
            progress=progress,
        )
    if out is not None:
        save_fmu_run(run, out, force=force)
        _say(f"wrote {out}")
    if events is not None:
        save_fmu_events(run, events, force=force)
        _say(f"wrote {events}")
    last = {name: column[-1].item() for name, column in run.columns.items()}
    if as_json:
        _print_json({"model": run.model, "fmi_version": run.fmi_version, "final": last})
    elif out is None:
        rows = [(name, f"{value:.10g} {run.units.get(name, '')}") for name, value in last.items()]
        print_list(f"{run.model}, FMI {run.fmi_version}: last values", rows)
