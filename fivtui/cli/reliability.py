"""The command for uncertainty studies.

A study draws samples of the scattered parameters. A member is one parameter set to be computed: a
sample, or a mixture of two for Sobol indices. Members are stored in pieces (`in_parts`) while they
are computed, so that a stopped study can continue.
"""

from dataclasses import replace

from fivtui.model import InputError
from fivtui.reliability import UncertaintyOptions

from .command import Call, command
from .options import print_note, print_written_files
from .studies import choose_engine


@command(
    UncertaintyOptions,
    out="Write the members (.csv, .parquet); continues a stopped study.",
    plot="Draw histograms, Sobol indices and samples (.png, .svg, .pdf).",
    in_parts=True,
)
def uncertainty(call: Call[UncertaintyOptions]) -> None:
    """Estimate how likely squeal is where parameters scatter.

    Sobol indices say which parameters drive it. Probabilities, quantiles and indices have 95 %
    intervals from independent scramblings of the design. The scene's table [scatter], e.g.
    mu = "normal:0.4:0.04", gives distributions, and [correlation], e.g. mu.F = -0.3, correlations
    of the normal scores (a Gaussian copula). With --out, the same command continues a study that
    was stopped.
    """
    from fivtui.reliability import (
        DEFAULT_OUTPUTS,
        DEFAULT_SAMPLES,
        FIRST_SAMPLES,
        MembersFile,
        UncertaintyProgress,
        check_until,
        compute_uncertainty,
        parse_inputs,
        scattered_study,
    )
    from fivtui.scene import find_scene

    options, out = call.options, call.outputs.out
    if options.samples is not None and options.until is not None:
        raise InputError(
            "--samples: must be given without --until, which sets the number of samples"
        )
    scene = call.scene(varied=[*options.varied, *dict(find_scene(call.scene_name).scatter)])
    # If a greatest error is given, the samples are doubled from `FIRST_SAMPLES` until it is met.
    greatest_error = None if options.until is None else check_until(options.until)
    study = scattered_study(
        scene,
        parse_inputs(options.varied),
        design=options.design,
        samples=options.samples or (DEFAULT_SAMPLES if greatest_error is None else FIRST_SAMPLES),
        seed=options.seed,
        repeats=options.repeats,
        indices=options.indices,
        outputs=options.outputs or DEFAULT_OUTPUTS,
    )
    if scene.correlation and options.indices is None:
        print_note("inputs are correlated: no Sobol indices, which require independent inputs")
    # --out is not written at the end: the members are stored there while they are computed.
    outputs = replace(call.outputs, out=None)
    outputs.check("uncertainty")
    with (
        choose_engine(options.scheduler, options.workers) as engine,
        UncertaintyProgress(study.members) as progress,
    ):
        result = compute_uncertainty(
            study,
            engine,
            until=greatest_error,
            file=None if out is None else MembersFile(out, options.piece),
            progress=progress,
            on_estimates=progress.show_estimates,
        )
    if out is not None:
        print_written_files(out, note=f"{result.study.members} members")
    outputs.finish("uncertainty", result)
