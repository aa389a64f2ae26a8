"""Commands that compute many transients, or one by many methods."""

from typing import TYPE_CHECKING, Any

import click

from fivtui.model import InputError

from .arguments import Whole, option
from .completion import VARIED_VALUES
from .group import commands
from .options import (
    check_outputs,
    error_option,
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
    wishes_of,
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
    required=True,
    metavar="NAME=START:STOP:COUNT[:log]",
    shell_complete=VARIED_VALUES,
    help="What varies: a parameter, or x0, vx0, y0, vy0 of the start; may be repeated. Also "
    "NAME=V1,V2,…; without COUNT in random and sobol.",
)
@option(
    "--design",
    "kind",
    type=click.Choice(["product", "list", "random", "sobol"]),
    default="product",
    show_default=True,
    help="Every value with every other, values side by side, or points between the ends.",
)
@option("--count", type=Whole(), metavar="N", help="Points of random and sobol.")
@option("--seed", type=Whole(), metavar="S", help="Seed of random and sobol.  [default: 0]")
@ignore_option
@option("--both", is_flag=True, help="Separation considered and ignored.")
@option("--t-end", metavar="S", help="Horizon in seconds.")
@option("--tol", metavar="R", help="Relative tolerance, 1e-13 to 1e-2.")
@error_option(
    "Choose tol, member by member, for an error of final, peak or half_range (half peak-to-peak "
    "over the second half of the run)."
)
@option("--start", metavar="static|x,vx,y,vy", help="Start state, m and m/s.")
@option(
    "--output",
    "outputs",
    multiple=True,
    metavar="NAME",
    help="Compute only this one (y_abs, …, growth_rate, stable); may be repeated.",
)
@option("--workers", type=Whole(), metavar="N", help="Threads.  [default: all processors]")
@option("--scheduler", metavar="ADDRESS", help="Compute on this Dask cluster.")
@option("--piece", type=Whole(min=1), metavar="N", help="Members stored at a time.")
@output_option(
    "--out",
    "FILE",
    "Write the rows (.csv, .parquet); continues what was stopped.",
    in_parts=True,
)
@output_option("--plot", "FILE", "Draw amplitudes over one or two names (.png, .svg, .pdf).")
@force_option
@json_option
def sweep(**given: Any) -> None:
    """Compute many transients that differ in parameters, start and physics.

    With --out, rows are stored piece by piece: whatever stops the sweep, the same command
    continues it. Members that cannot be computed are rows that say why.
    """
    from contextlib import ExitStack

    from fivtui.sweeps import (
        SweepProgress,
        check_in_memory,
        load_sweep,
        parse_cases,
        parse_design,
        print_sweep,
        study_of,
        sweep_in_memory,
        sweep_to_file,
    )

    scene = scene_of(given["scene"], given["assignments"])
    study = study_of(
        scene,
        parse_design(given["varied"], given["kind"], given["count"], given["seed"]),
        cases=parse_cases(ignored=given["ignore_separation"], both=given["both"]),
        start=None if given["start"] is None else start_of(given["start"]),
        t_end=given["t_end"],
        tol=given["tol"],
        accuracy=wishes_of(given["wishes"]),
        outputs=given["outputs"],
    )
    out, plot, force, as_json = (given[name] for name in ("out", "plot", "force", "as_json"))
    if out is None or plot is not None or as_json:
        check_in_memory(study)
    if plot is not None:
        from fivtui.plotting import check_figure_path
        from fivtui.sweeps import check_drawable

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
        say(f"wrote {out}: {written}")
        if plot is not None or as_json:
            result = load_sweep(study, out)
    if plot is not None:
        from fivtui.plotting import save_figure
        from fivtui.sweeps import sweep_figure

        save_figure(sweep_figure(result), plot, force=force)
        say(f"wrote {plot}")
    if as_json:
        print_json(result.to_dict())
    elif out is None:
        print_sweep(result, chosen=bool(given["outputs"]))


def _engine(scheduler: str | None, workers: int | None) -> "AbstractContextManager[Engine]":
    if scheduler is not None:
        from fivtui.sweeps import cluster_engine

        if workers is not None:
            raise InputError("--workers: the cluster of --scheduler has its own")
        return cluster_engine(scheduler)
    from contextlib import nullcontext

    from fivtui.sweeps import local_engine

    return nullcontext(local_engine(workers))


@commands.command()
@scene_argument
@set_option
@ignore_option
@option("--t-end", metavar="S", help="Horizon in seconds.")
@option("--start", metavar="static|x,vx,y,vy", help="Start state, m and m/s.")
@option("--thorough", is_flag=True, help="Take about two minutes instead of seven seconds.")
@error_option(
    "Name the cheapest setting for an error of final, peak, half_range (half peak-to-peak over the "
    "second half of the run) or events (s)."
)
@output_option("--out", "FILE.csv", "Write all settings measured.")
@output_option("--plot", "FILE", "Draw error against CPU time (.png, .svg, .pdf).")
@force_option
@json_option
def tradeoff(scene: str, assignments: tuple[str, ...], **given: Any) -> None:
    """Measure what accuracy costs on this machine, for every method and setting."""
    from dataclasses import replace

    from fivtui.tradeoffs import (
        cheapest_to_dict,
        check_tradeoff_path,
        measure_tradeoff,
        print_tradeoff,
        save_tradeoff,
        tradeoff_to_dict,
    )
    from fivtui.transient import check_horizon

    out, plot, force = given["out"], given["plot"], given["force"]
    wishes = wishes_of(given["wishes"])
    chosen = scene_of(scene, assignments, ignore_separation=given["ignore_separation"])
    if given["t_end"] is not None:
        chosen = replace(chosen, t_end=check_horizon(given["t_end"]))
    if given["start"] is not None:
        chosen = replace(chosen, start=start_of(given["start"]))
    check_outputs(out, plot, check_tradeoff_path, force=force)
    with progress_bar("trade-off") as progress:
        result = measure_tradeoff(chosen, thorough=given["thorough"], progress=progress)
    if out is not None:
        save_tradeoff(result, out, force=force)
        say(f"wrote {out}")
    if plot is not None:
        from fivtui.plotting import save_figure
        from fivtui.tradeoffs import tradeoff_figure

        save_figure(tradeoff_figure(result), plot, force=force)
        say(f"wrote {plot}")
    if given["as_json"]:
        print_json({**tradeoff_to_dict(result), **cheapest_to_dict(result, wishes)})
    else:
        print_tradeoff(result, wishes)


@commands.command()
@json_option
def extremes(as_json: bool) -> None:
    """Try every method on scenes that break solvers: right, refused or wrong.

    Each result is held against a solution in quadruple precision. A method is refused where it says
    itself that it cannot go on, or needs more steps than the trial allows.
    """
    from fivtui.assessment import print_trials, run_trials, trials_to_dict

    with progress_bar("extremes") as progress:
        found = run_trials(progress=progress)
    if as_json:
        print_json(trials_to_dict(found))
    else:
        print_trials(found)
