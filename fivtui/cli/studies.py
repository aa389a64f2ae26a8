"""Commands for sweeps, trade-offs, stress tests and the paper."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fivtui.model import InputError

from .arguments import Whole, option
from .completion import METHOD_NAMES, SWEEP_PRESET_NAMES, VARIED_VALUES
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
    piece_option,
    progress_bar,
    put,
    say_without_effect,
    say_written,
    scene_argument,
    scene_of,
    scheduler_option,
    set_option,
    start_of,
    start_option,
    t_end_option,
    tol_option,
    workers_option,
)

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from fivtui.sweeps import Engine


@commands.command()
@scene_argument
@set_option
@option(
    "--vary",
    "varied",
    multiple=True,
    metavar="NAME=START:STOP:COUNT[:log]",
    shell_complete=VARIED_VALUES,
    help="Vary a parameter, or x0, vx0, y0, vy0 of the start; may be repeated. NAME=V1,V2,… gives "
    "single values; designs random and sobol take NAME=START:STOP[:log].",
)
@option(
    "--preset",
    metavar="NAME",
    shell_complete=SWEEP_PRESET_NAMES,
    help="Vary as a sweep that comes with the program: peak-over-belt-speed.",
)
@option(
    "--design",
    "kind",
    type=click.Choice(["product", "list", "random", "sobol"]),
    default="product",
    show_default=True,
    help="product: all combinations; list: values side by side; random, sobol: --count points "
    "between START and STOP.",
)
@option("--count", type=Whole(), metavar="N", help="Number of points of random and sobol.")
@option("--seed", type=Whole(), metavar="S", help="Seed of random and sobol.  [default: 0]")
@ignore_option
@option("--both", is_flag=True, help="Compute each member with separation considered and ignored.")
@t_end_option
@tol_option
@error_option(
    "Error target in place of --tol: refine each member until the error of QUANTITY is below R. "
    "QUANTITY: final (state), peak or half_range (half peak-to-peak over the second half of the "
    "run)."
)
@start_option("Start state, m and m/s.")
@option(
    "--method",
    metavar="NAME",
    help="taylor, or a run of the FMU for each member: fmu, fmu-native.  [default: the scene's]",
    shell_complete=METHOD_NAMES,
)
@over_time_option
@option(
    "--output",
    "outputs",
    multiple=True,
    metavar="NAME",
    help="Compute this output only (y_abs, y_half_range, separations, sticks, growth_rate, stable, "
    "…); may be repeated.",
)
@workers_option
@scheduler_option
@piece_option
@output_option(
    "--out",
    "FILE",
    "Write the rows (.csv, .parquet); a stopped sweep continues.",
    in_parts=True,
)
@output_option(
    "--plot", "FILE", "Draw amplitudes over the one or two names varied (.png, .svg, .pdf)."
)
@force_option
@json_option
def sweep(**given: Any) -> None:
    """Compute many transients over parameters or starts.

    With --out, rows are stored piece by piece: if the sweep is stopped, the same command continues
    it. A member that cannot be computed gets a row that says why.
    """
    from contextlib import ExitStack
    from dataclasses import replace

    from fivtui.scene import read_over_time
    from fivtui.sweeps import (
        SweepProgress,
        check_in_memory,
        load_sweep,
        parse_cases,
        parse_design,
        study_of,
        sweep_in_memory,
        sweep_to_file,
        varied_texts,
    )

    varied = varied_texts(given["preset"], given["varied"])
    scene = scene_of(given["scene"], given["assignments"], over_time=True)
    if given["over_time"] is not None:
        scene = replace(scene, over_time=read_over_time(given["over_time"]))
    say_without_effect(scene, varied, given["assignments"])
    study = study_of(
        scene,
        parse_design(varied, given["kind"], given["count"], given["seed"]),
        cases=parse_cases(ignored=given["ignore_separation"], both=given["both"]),
        start=None if given["start"] is None else start_of(given["start"]),
        t_end=given["t_end"],
        tol=given["tol"],
        accuracy=error_targets_of(given["error_targets"]),
        outputs=given["outputs"],
        method=given["method"],
    )
    out, plot, force, as_json = (given[name] for name in ("out", "plot", "force", "as_json"))
    if out is None or plot is not None or as_json:
        check_in_memory(study)
    check_outputs("sweep", None, plot, force=force)
    if plot is not None:
        from fivtui.sweeps import check_drawable

        check_drawable(study)
    with ExitStack() as stack:
        engine = stack.enter_context(engine_of(given["scheduler"], given["workers"]))
        progress = stack.enter_context(SweepProgress(study.members))
        if out is None:
            result = sweep_in_memory(study, engine, progress=progress)
        else:
            written = sweep_to_file(
                study, out, engine, size=given["piece"], force=force, progress=progress
            )
    if out is not None:
        say_written(out, note=str(written))
        if plot is not None or as_json:
            result = load_sweep(study, out)
    if plot is not None:
        write("sweep", result, None, plot, force=force)
    if as_json or out is None:
        show("sweep", result, as_json=as_json)


def engine_of(scheduler: str | None, workers: int | None) -> "AbstractContextManager[Engine]":
    """The engine of ``--scheduler`` or ``--workers``."""
    if scheduler is not None:
        from fivtui.sweeps import cluster_engine

        if workers is not None:
            raise InputError(
                "--workers: must be given without --scheduler, whose cluster has its own"
            )
        return cluster_engine(scheduler)
    from contextlib import nullcontext

    from fivtui.sweeps import local_engine

    return nullcontext(local_engine(workers))


@commands.command()
@scene_argument
@set_option
@ignore_option
@t_end_option
@start_option("Start state, m and m/s.")
@option(
    "--thorough", is_flag=True, help="More settings: about two minutes instead of seven seconds."
)
@error_option(
    "Error target: name the cheapest setting whose error of QUANTITY is below R. QUANTITY: final "
    "(state), peak, half_range (half peak-to-peak over the second half of the run) or events "
    "(times of separation and reattachment, s)."
)
@output_option("--out", "FILE.csv", "Write error and CPU time of every setting.")
@output_option("--plot", "FILE", "Draw error against CPU time (.png, .svg, .pdf).")
@force_option
@json_option
def tradeoff(scene: str, assignments: tuple[str, ...], **given: Any) -> None:
    """Measure error against CPU time for every method.

    Each method runs the scene at several settings on this machine.
    """
    from dataclasses import replace

    from fivtui.tradeoffs import measure_tradeoff
    from fivtui.transient import check_horizon

    out, plot, force = given["out"], given["plot"], given["force"]
    targets = error_targets_of(given["error_targets"])
    chosen = scene_of(scene, assignments, ignore_separation=given["ignore_separation"])
    if given["t_end"] is not None:
        chosen = replace(chosen, t_end=check_horizon(given["t_end"]))
    if given["start"] is not None:
        chosen = replace(chosen, start=start_of(given["start"]))
    check_outputs("trade-off", out, plot, force=force)
    with progress_bar("trade-off") as progress:
        measured = measure_tradeoff(chosen, thorough=given["thorough"], progress=progress)
    result = replace(measured, targets=targets)
    write("trade-off", result, out, plot, force=force)
    show("trade-off", result, as_json=given["as_json"])


@commands.command()
@json_option
def extremes(as_json: bool) -> None:
    """Stress-test every method on scenes that break solvers.

    Each result is compared with a solution in quadruple precision: right, wrong, or refused where
    the method itself reports that it cannot go on or needs too many steps.
    """
    from fivtui.assessment import run_stress_tests

    with progress_bar("extremes") as progress:
        found = run_stress_tests(progress=progress)
    show("extremes", found, as_json=as_json)


@commands.command()
@click.argument("numbers", nargs=-1, metavar="[N ...]")
@folder_option("Folder for the pictures and their data.")
@option(
    "--format",
    "formats",
    multiple=True,
    metavar="NAME",
    help="pdf, svg or png; may be repeated.  [default: pdf and png]",
)
@force_option
def figures(numbers: tuple[str, ...], out: Path, formats: tuple[str, ...], force: bool) -> None:
    """Draw the paper's figures 2 to 16.

    N is a number or a range such as 3-9; all are drawn without it. The data of each picture go to
    a CSV file beside it, with units and parameters.
    """
    from fivtui.paper import DEFAULT_FORMATS, figure_numbers, save_figures

    with progress_bar("figures") as progress:
        written = save_figures(
            figure_numbers(numbers),
            out,
            formats=formats or DEFAULT_FORMATS,
            force=force,
            progress=progress,
        )
    for files in written:
        say_written(*files.pictures, *files.data)


@commands.command()
@option("--markdown", is_flag=True, help="Print a Markdown table.")
@json_option
def claims(markdown: bool, as_json: bool) -> None:
    """Check every testable statement of the paper.

    Lists section, stated value, computed value and verdict of each.
    """
    from fivtui.paper import check_claims, claims_markdown

    if markdown and as_json:
        raise InputError("--markdown: must be given without --json")
    with progress_bar("claims") as progress:
        checked = check_claims(progress=progress)
    if markdown:
        put(claims_markdown(checked))
    else:
        show("claims", checked, as_json=as_json)
