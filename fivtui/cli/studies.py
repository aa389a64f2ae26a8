"""Commands for sweeps, trade-offs, stress tests and the paper.

The paper is *Nonlinear friction-induced vibration of a slider-belt system*.
"""

from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fivtui.model import InputError
from fivtui.sweeps import SweepOptions
from fivtui.tradeoffs import TradeoffOptions

from .arguments import option
from .command import Call, command
from .deliver import Outputs
from .group import commands
from .options import (
    folder_option,
    force_option,
    json_option,
    parse_error_targets,
    print_text,
    print_written_files,
    progress_bar,
)

if TYPE_CHECKING:
    from fivtui.sweeps import Engine


@command(
    SweepOptions,
    out="Write the rows (.csv, .parquet); continues a stopped sweep.",
    plot="Draw amplitudes over the one or two quantities varied (.png, .svg, .pdf).",
    in_parts=True,
)
def sweep(call: Call[SweepOptions]) -> None:
    """Compute many transients over parameters or starts.

    With --out, rows are stored piece by piece: if the sweep is stopped, the same command continues
    it. A member that cannot be computed gets a row that says why.
    """
    from fivtui.sweeps import (
        SweepProgress,
        check_memory_limit,
        load_sweep,
        parse_design,
        scene_study,
        sweep_in_memory,
        sweep_to_file,
        varied_texts,
    )

    options, out = call.options, call.outputs.out
    varied = varied_texts(options.preset, options.varied)
    scene = call.scene(varied=varied)
    if options.both and options.ignore_separation:
        raise InputError("--both: must be given without --ignore-separation")
    study = scene_study(
        scene,
        parse_design(varied, options.design, options.count, options.seed, options.starts),
        # Separation considered and ignored.
        cases=(True, False) if options.both else None,
        outputs=options.outputs,
    )
    # --out is not written at the end: the rows are stored there while they are computed.
    outputs = replace(call.outputs, out=None)
    reads_rows = out is None or outputs.plot is not None or outputs.as_json
    if reads_rows:
        check_memory_limit(study)
    outputs.check("sweep")
    if outputs.plot is not None:
        from fivtui.sweeps import check_drawable

        check_drawable(study)
    with (
        choose_engine(options.scheduler, options.workers) as engine,
        SweepProgress(study.members) as progress,
    ):
        if out is None:
            result = sweep_in_memory(study, engine, progress=progress)
        else:
            written = sweep_to_file(study, out, engine, size=options.piece, progress=progress)
    if out is not None:
        print_written_files(out, note=str(written))
        if not reads_rows:
            if written.failure is not None:
                raise written.failure
            return
        result = load_sweep(study, out)
    if outputs.plot is not None:
        outputs.write("sweep", result)
    if outputs.as_json or out is None:
        outputs.show("sweep", result)
    outputs.check_computed("sweep", result)


def choose_engine(scheduler: str | None, workers: int | None) -> AbstractContextManager["Engine"]:
    """What computes the members of a study: processes (``--workers``) or a dask cluster."""
    if scheduler is not None:
        from fivtui.sweeps import cluster_engine

        if workers is not None:
            raise InputError(
                "--workers: must be given without --scheduler; the cluster has workers already"
            )
        return cluster_engine(scheduler)
    from fivtui.sweeps import local_engine

    return nullcontext(local_engine(workers))


@command(
    TradeoffOptions,
    out="Write error and CPU time of every setting.",
    plot="Draw error against CPU time (.png, .svg, .pdf).",
    metavar="FILE.csv",
)
def tradeoff(call: Call[TradeoffOptions]) -> None:
    """Measure error against CPU time for every method.

    Each method runs the scene at several settings on this machine.
    """
    from fivtui.tradeoffs import measure_tradeoff

    # The report names the cheapest setting that meets each error target.
    targets, thorough = parse_error_targets(call.options.targets), call.options.thorough
    scene = call.scene()
    call.outputs.compute_and_deliver(
        "trade-off",
        lambda progress: replace(
            measure_tradeoff(scene, thorough=thorough, progress=progress), targets=targets
        ),
    )


@commands.command()
@json_option
def extremes(as_json: bool) -> None:
    """Stress-test every method on scenes that break solvers.

    Each result is right or wrong, compared with a solution in quadruple precision, or refused: the
    method itself reports that it cannot continue or needs too many steps.
    """
    from fivtui.assessment import run_stress_tests

    Outputs(as_json=as_json).compute_and_deliver("extremes", run_stress_tests)


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
def figures(numbers: tuple[str, ...], out: Path, formats: tuple[str, ...]) -> None:
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
            progress=progress,
        )
    for files in written:
        print_written_files(*files.pictures, *files.data)


@commands.command()
@option("--markdown", is_flag=True, help="Print a Markdown table.")
@option(
    "--verdict",
    type=click.Choice(["holds", "does-not-hold", "not-testable"]),
    help="Print only the claims with this verdict.",
)
@json_option
def claims(markdown: bool, verdict: str | None, as_json: bool) -> None:
    """Check every testable statement of the paper.

    Lists section, stated value, computed value and verdict of each.
    """
    from fivtui.paper import check_claims, claims_markdown

    if markdown and as_json:
        raise InputError("--markdown: must be given without --json")
    with progress_bar("claims") as progress:
        checked = check_claims(progress=progress)
    if verdict is not None:
        checked = [claim for claim in checked if claim.verdict == verdict.replace("-", " ")]
    if markdown:
        print_text(claims_markdown(checked))
    else:
        Outputs(as_json=as_json).show("claims", checked)
