"""The command for uncertainty studies."""

from typing import Any

import click

from fivtui.model import InputError, Interval

from .arguments import Whole, option
from .completion import SCATTERED_VALUES
from .deliver import check_outputs, show, warn, write
from .group import commands
from .options import (
    force_option,
    ignore_option,
    json_option,
    output_option,
    piece_option,
    say,
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
from .studies import engine_of


@commands.command()
@scene_argument
@set_option
@option(
    "--vary",
    "varied",
    multiple=True,
    required=True,
    metavar="NAME~DISTRIBUTION:…",
    shell_complete=SCATTERED_VALUES,
    help="Scatter a parameter, or x0, vx0, y0, vy0 of the start; may be repeated. "
    "uniform:LOW:HIGH, normal:MEAN:SD, lognormal:MEAN:SD (of the quantity itself), "
    "triangular:LOW:MODE:HIGH, beta:LOW:HIGH:A:B, or NAME:SHAPE:…:LOC:SCALE of scipy.stats; "
    "truncated at the bounds of the parameter.",
)
@option(
    "--samples",
    type=Whole(Interval(1)),
    metavar="N",
    help="Number of samples, rounded up to a power of two in every scrambling.  [default: 16384]",
)
@option(
    "--until",
    metavar="E",
    help="Double the samples until the 95 % interval of every probability reaches at most E from "
    "its value.",
)
@option(
    "--design",
    type=click.Choice(["sobol", "lhs"]),
    default="sobol",
    show_default=True,
    help="Scrambled Sobol sequences, or Latin hypercubes.",
)
@option(
    "--repeats",
    type=Whole(Interval(1)),
    metavar="N",
    default=16,
    show_default=True,
    help="Independent scramblings, from which intervals come.",
)
@option("--seed", type=Whole(), metavar="S", default=0, show_default=True, help="First seed.")
@option(
    "--indices/--no-indices",
    default=None,
    help="Sobol indices.  [default: unless inputs are correlated by the scene's table]",
)
@ignore_option
@t_end_option
@tol_option
@start_option("Start state, m and m/s.")
@option(
    "--output",
    "outputs",
    multiple=True,
    metavar="NAME",
    help="Compute this output only, besides the growth rate (critical_mu, safe_mu, y_half_range, "
    "P_max, …); may be repeated.",
)
@workers_option
@scheduler_option
@piece_option
@output_option(
    "--out",
    "FILE",
    "Write the members (.csv, .parquet); a stopped study continues.",
    in_parts=True,
)
@output_option("--plot", "FILE", "Draw histograms, Sobol indices and samples (.png, .svg, .pdf).")
@force_option
@json_option
def uncertainty(**given: Any) -> None:
    """Estimate how likely squeal is where parameters scatter, and what drives it.

    Probabilities, quantiles and Sobol indices have 95 % intervals from independent scramblings of
    the design. Correlations are those of the scene's table [correlation], e.g. mu.F = -0.3, of the
    normal scores (a Gaussian copula). With --out the same command continues a study that was
    stopped.
    """
    from contextlib import ExitStack

    from fivtui.reliability import (
        DEFAULT_OUTPUTS,
        DEFAULT_SAMPLES,
        FIRST_SAMPLES,
        Place,
        UncertaintyProgress,
        measured,
        parse_inputs,
        scattered_study,
        wanted_error,
    )

    if given["samples"] is not None and given["until"] is not None:
        raise InputError("--samples: must be given without --until, which decides on them")
    scene = scene_of(
        given["scene"],
        given["assignments"],
        ignore_separation=given["ignore_separation"],
        varied=given["varied"],
    )
    until = wanted_error(given["until"])
    study = scattered_study(
        scene,
        parse_inputs(given["varied"]),
        design=given["design"],
        samples=given["samples"] or (DEFAULT_SAMPLES if until is None else FIRST_SAMPLES),
        seed=given["seed"],
        repeats=given["repeats"],
        indices=given["indices"],
        outputs=given["outputs"] or DEFAULT_OUTPUTS,
        start=None if given["start"] is None else start_of(given["start"]),
        t_end=given["t_end"],
        tol=given["tol"],
    )
    if scene.correlation and given["indices"] is None:
        say("inputs are correlated: no Sobol indices, which are those of independent ones")
    out, plot, force = given["out"], given["plot"], given["force"]
    check_outputs("uncertainty", None, plot, force=force)
    with ExitStack() as stack:
        engine = stack.enter_context(engine_of(given["scheduler"], given["workers"]))
        progress = stack.enter_context(UncertaintyProgress(study.members))
        result = measured(
            study,
            engine,
            until=until,
            place=None if out is None else Place(out, given["piece"], force),
            progress=progress,
            tell=progress.tell,
        )
    if out is not None:
        say_written(out, note=f"{result.study.members} members")
    warn("uncertainty", result)
    write("uncertainty", result, None, plot, force=force)
    show("uncertainty", result, as_json=given["as_json"])
