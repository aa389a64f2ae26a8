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
    from .core.request import Start
    from .scene import Scene

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
    except (click.Abort, Cancelled, KeyboardInterrupt):
        message, code = "cancelled", EXIT_INTERRUPTED
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
@json_option
def stability(scene: str, assignments: tuple[str, ...], as_json: bool) -> None:
    """Show equilibrium, eigenvalues, growth rate and critical friction coefficient."""
    from .core.stability import stability as judge
    from .report import print_stability
    from .results import stability_to_dict

    chosen = _scene(scene, assignments)
    verdict = judge(chosen.parameters, separation=chosen.separation)
    if as_json:
        _print_json(stability_to_dict(verdict))
    else:
        print_stability(verdict, chosen.parameters)


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
    from .runner import scene_transient
    from .verified import verified_to_dict

    scene = _changed(_scene(given["scene"], given["assignments"]), given)
    out, plot, force = given["out"], given["plot"], given["force"]
    _check_outputs(out, plot, force=force)
    stored = out is not None or plot is not None
    with Progress("transient") as progress:
        run = scene_transient(
            scene,
            samples=np.linspace(0.0, scene.t_end, given["points"]) if stored else "none",
            progress=progress,
        )
    result = run.transient
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


def _check_outputs(out: Path | None, plot: Path | None, *, force: bool) -> None:
    if out is not None:
        from .results import check_trajectory_path

        check_trajectory_path(out, force=force)
    if plot is not None:
        from .figures import check_figure_path

        check_figure_path(plot, force=force)


@fivtui.command()
@scene_argument
@set_option
@_path_option("--out", "FILE", "Write the trajectory, if required (.csv, .npz, .parquet).")
@force_option
@json_option
def run(scene: str, out: Path | None, force: bool, as_json: bool, **given: Any) -> None:
    """Compute what a scene requires: stability, transient, trajectory; nothing else."""
    from .report import Progress, print_stability, print_transient
    from .results import save_trajectory, stability_to_dict, transient_to_dict
    from .runner import run_scene
    from .verified import verified_to_dict

    chosen = _scene(scene, given["assignments"])
    if ("trajectory" in chosen.outputs) != (out is not None):
        wanted = "a file for it: --out FILE" if out is None else "no --out: it is not required"
        raise InputError(f"trajectory of the scene {chosen.name}: allowed is {wanted}")
    _check_outputs(out, None, force=force)
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
@click.option(
    "--port",
    type=click.IntRange(1, 65535),
    default=8000,
    show_default=True,
    help="Port on 127.0.0.1.",
)
def serve(port: int) -> None:
    """Show the terminal laboratory in a browser on this machine."""
    from .tui.serve import serve as start

    start(port, say=_say)


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
    if out is not None:
        check_tradeoff_path(out, force=force)
    if plot is not None:
        from .figures import check_figure_path

        check_figure_path(plot, force=force)
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
@force_option
def fmu_build(out: Path, force: bool) -> None:
    """Export the slider-belt as an FMU."""
    from fmu_src.builder import build_fmu

    build_fmu(out, force=force)
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
@force_option
@json_option
def fmu_run(fmu_file: Path, out: Path | None, force: bool, as_json: bool, **given: Any) -> None:
    """Run an FMU for co-simulation through fmpy; print its last values or write all."""
    from .fmu_run import check_run_path, run_fmu, save_fmu_run
    from .report import Progress, print_list

    if out is not None:
        check_run_path(out, force=force)
    with Progress("FMU") as progress:
        run = run_fmu(
            fmu_file,
            t_end=given["t_end"],
            output_interval=given["output_interval"],
            start_values=_assigned("--set", given["assignments"], "F=60"),
            outputs=given["outputs"] or None,
            input_csv=given["input"],
            tol=None if given["tol"] is None else parse_number("tol", given["tol"], "tol > 0"),
            progress=progress,
        )
    if out is not None:
        save_fmu_run(run, out, force=force)
        _say(f"wrote {out}")
    last = {name: column[-1].item() for name, column in run.columns.items()}
    if as_json:
        _print_json({"model": run.model, "fmi_version": run.fmi_version, "final": last})
    elif out is None:
        rows = [(name, f"{value:.10g} {run.units.get(name, '')}") for name, value in last.items()]
        print_list(f"{run.model}, FMI {run.fmi_version}: last values", rows)
