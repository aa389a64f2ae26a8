"""Run uncertainty studies in memory or into a file, up to a number of samples or to an error.

The members of a study are those of a scattered sweep, which an engine computes in pieces. A study
up to an error doubles its samples in stages; each stage keeps the members of the one before.
"""

from collections.abc import Callable, Generator, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fivtui.distributions import Distribution
from fivtui.io import is_replaceable, output_path
from fivtui.model import ComputationError, InputError, OnProgress, Parameters, check_names
from fivtui.scene import Scene
from fivtui.sweeps import (
    VIBRATES,
    Engine,
    Rows,
    ScatterKind,
    Study,
    Sweep,
    SweepPiece,
    check_memory_limit,
    load_sweep,
    local_engine,
    read_stored_studies,
    sweep_in_memory,
    sweep_to_file,
)
from fivtui.transient import DEFAULT_T_END, DEFAULT_TOL, Start

from .request import (
    DEFAULT_OUTPUTS,
    DEFAULT_REPEATS,
    DEFAULT_SAMPLES,
    SAFE_MU,
    add_safe_table,
    as_distributions,
    check_until,
    scattered_study,
)
from .result import Uncertainty, evaluate, event_flags, scattered_design
from .statistics import probability_from_counts

Floats = NDArray[np.float64]
# Called with the number of members and the estimates so far as text.
EstimatesCallback = Callable[[int, str], object]


class MembersFile(NamedTuple):
    """The file for the members of a study, and the number of members in a piece."""

    out: Path
    piece: int | None


def uncertainty(
    parameters: Parameters | None = None,
    *,
    vary: Mapping[str, Distribution | str],
    correlations: Mapping[tuple[str, str], float] = MappingProxyType({}),
    design: ScatterKind = "sobol",
    samples: int = DEFAULT_SAMPLES,
    until: float | None = None,
    seed: int = 0,
    repeats: int = DEFAULT_REPEATS,
    indices: bool | None = None,
    outputs: Iterable[str] = DEFAULT_OUTPUTS,
    separation: bool = True,
    start: Start = "static",
    t_end: float = DEFAULT_T_END,
    tol: float = DEFAULT_TOL,
    progress: OnProgress | None = None,
    workers: int | None = None,
) -> Uncertainty:
    """Estimate how likely squeal is if parameters scatter, and the influence of each parameter.

    Parameters
    ----------
    parameters : Parameters, optional
        The parameters that do not scatter; the base set by default.
    vary : mapping of str to Distribution or str
        Distributions of parameters, and of ``x0``, ``vx0``, ``y0``, ``vy0`` of the start,
        truncated at the bounds of the parameters. As text ``uniform:LOW:HIGH``,
        ``normal:MEAN:SD``, ``lognormal:MEAN:SD`` (of the quantity, not of its logarithm),
        ``triangular:LOW:MODE:HIGH``, ``beta:LOW:HIGH:A:B``. Any other of `scipy.stats` is
        ``NAME:SHAPE:…:LOC:SCALE``.
    correlations : mapping of (str, str) to float
        Correlations of the normal scores of two names (a Gaussian copula).
    design : "sobol" or "lhs"
        Scrambled Sobol sequences, or Latin hypercubes.
    samples : int
        Number of samples, rounded up to a power of two in every scrambling.
    until : float, optional
        Double the samples until the error of every probability, its distance to the farther end of
        its 95 % interval, is at most this.
    seed : int
        Seed of the first scrambling; those of the others follow.
    repeats : int
        Number of independent scramblings; intervals are computed from their differences.
    indices : bool, optional
        Whether Sobol indices are computed; by default if inputs are not correlated.
    outputs : iterable of str
        Quantities besides the growth rate: ``critical_mu``, ``safe_mu``, and those of `sweep`;
        ``vibrates`` adds the probability that the run ends in vibration.
    separation, start, t_end, tol
        As in `simulate`. The static start is at rest under the preload, before the belt moves.
    progress : callable, optional
        Called with the fraction done; cancels the study by returning False.
    workers : int, optional
        Number of threads; all processors by default.

    Returns
    -------
    Uncertainty
        Probabilities, quantiles and Sobol indices with 95 % intervals.

    Raises
    ------
    InputError
        If an argument is wrong.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import uncertainty
    >>> result = uncertainty(vary={"mu": "uniform:0:1"}, outputs=["critical_mu"])
    >>> round(result.probabilities["unstable"].value, 3)
    0.561
    """
    scene = Scene(
        name="uncertainty",
        description="",
        parameters=Parameters() if parameters is None else parameters,
        separation=separation,
        start=start,
        t_end=t_end,
        tol=tol,
    )
    study = scattered_study(
        scene,
        as_distributions(vary),
        correlations=tuple((a, b, value) for (a, b), value in correlations.items()),
        design=design,
        samples=samples,
        seed=seed,
        repeats=repeats,
        indices=indices,
        outputs=check_names("outputs", outputs),
    )
    return compute_uncertainty(study, local_engine(workers), until=until, progress=progress)


def compute_uncertainty(
    study: Study,
    engine: Engine,
    *,
    until: float | None = None,
    file: MembersFile | None = None,
    progress: OnProgress | None = None,
    on_estimates: EstimatesCallback | None = None,
) -> Uncertainty:
    """Compute a scattered sweep and return its result.

    If `until` is given, samples are doubled until the error of every probability is at most that.
    """
    if on_estimates is not None and SAFE_MU in study.outputs:
        on_estimates(study.members, "following branches of limit cycles")
    # The table of safe μ has no share of the progress, but can be cancelled.
    cancel_check = None if progress is None else lambda _fraction: progress(0.0)
    study = add_safe_table(study, cancel_check)
    if until is None:
        return evaluate(_compute_sweep(study, _with_reports(engine, on_estimates), file, progress))
    tolerance = check_until(until)
    if scattered_design(study).kind != "sobol":
        raise InputError("until: must be given with the design sobol, whose points can be added to")
    study, stored_rows, file = _resume_stage(study, file)
    while True:
        reporting_engine = _with_reports(_with_stored_rows(engine, stored_rows), on_estimates)
        result = evaluate(_compute_sweep(study, reporting_engine, file, progress))
        if result.error <= tolerance:
            return result
        if result.missing.get(VIBRATES, 0) > 2.0 * tolerance * study.members:
            raise ComputationError(
                f"{result.missing[VIBRATES]} of {study.members} members are undecided between rest "
                f"and vibration: the error of their probability cannot be {tolerance:g}",
                "allow a larger error, or follow the runs for longer (--t-end)",
            )
        # The file of a stage is replaced when the file of the next stage is complete.
        stored_rows, study = result.sweep.table, _double_samples(result, tolerance)
        file = None if file is None else file._replace(out=output_path(file.out, force=True))


def _double_samples(result: Uncertainty, tolerance: float) -> Study:
    # The study of the next stage; `ComputationError` if it does not fit in memory.
    study = _with_count(result.study, 2 * result.scatter.count)
    try:
        check_memory_limit(study)
    except InputError:
        further_advice = ", or leave out Sobol indices" if result.scatter.indices else ""
        raise ComputationError(
            f"the error of the probabilities is {result.error:.2g} with {result.scatter.samples} "
            f"samples, not {tolerance:g}",
            f"allow a larger error{further_advice}",
        ) from None
    return study


def _with_count(study: Study, count: int) -> Study:
    # The study with `count` points in every scrambling.
    return replace(study, design=replace(scattered_design(study), count=count))


def _resume_stage(
    study: Study, file: MembersFile | None
) -> tuple[Study, Rows | None, MembersFile | None]:
    # Resume an earlier run of the same study. Returns the study of the last stage of that run, the
    # rows of its last complete stage, if any, and the file, which a larger stage may replace.
    if file is None or is_replaceable(file.out):
        # A user who lets the file be replaced starts from the beginning.
        return study, None, file
    complete, incomplete = (
        _same_but_for_count(study, stored_study) for stored_study in read_stored_studies(file.out)
    )
    latest = incomplete or complete
    if latest is None:
        return study, None, file
    rows = None if complete is None else load_sweep(complete, file.out).table
    may_replace = complete is not None and complete != latest
    return latest, rows, file._replace(out=output_path(file.out, force=may_replace))


def _same_but_for_count(study: Study, stored_study: Study | None) -> Study | None:
    # `stored_study` if it differs from the study at most in the number of samples, else None.
    if stored_study is None:
        return None
    try:
        resized_study = _with_count(study, scattered_design(stored_study).count)
    except InputError:
        return None
    return stored_study if stored_study == resized_study else None


def _compute_sweep(
    study: Study, engine: Engine, file: MembersFile | None, progress: OnProgress | None
) -> Sweep:
    check_memory_limit(study)
    if file is None:
        return sweep_in_memory(study, engine, progress=progress)
    sweep_to_file(study, file.out, engine, size=file.piece, progress=progress)
    return load_sweep(study, file.out)


def _with_stored_rows(engine: Engine, stored_rows: Rows | None) -> Engine:
    # An engine that takes the first members from stored rows and computes the rest.
    if stored_rows is None:
        return engine

    def compute(study: Study, pieces: Iterable[SweepPiece]) -> Generator[tuple[SweepPiece, Rows]]:
        pending = list(pieces)
        stored = [piece for piece in pending if piece.stop <= stored_rows.members]
        for piece in stored:
            yield piece, stored_rows.part(piece.first, piece.stop)
        yield from engine(study, pending[len(stored) :])

    return compute


def _with_reports(engine: Engine, on_estimates: EstimatesCallback | None) -> Engine:
    # An engine that reports the probabilities of all rows so far.
    if on_estimates is None:
        return engine

    def compute(study: Study, pieces: Iterable[SweepPiece]) -> Generator[tuple[SweepPiece, Rows]]:
        scatter = scattered_design(study)
        # Numbers of hits and of samples in each scrambling, by event.
        totals: dict[str, tuple[Floats, Floats]] = {}
        zeros = np.zeros(scatter.repeats)
        for piece, rows in engine(study, pieces):
            members = np.arange(piece.first, piece.stop)
            # The members of a point: its samples, then those for Sobol indices. Points of all
            # scramblings alternate.
            point, index_in_point = np.divmod(members, scatter.point_members)
            for name, flags in event_flags(study, rows.numbers).items():
                is_counted = (index_in_point < scatter.point_samples) & ~np.isnan(flags)
                scrambling = point[is_counted] % scatter.repeats
                new_hits = np.bincount(scrambling, flags[is_counted], scatter.repeats)
                new_samples = np.bincount(scrambling, minlength=scatter.repeats)
                hits, samples = totals.get(name, (zeros, zeros))
                totals[name] = (hits + new_hits, samples + new_samples)
            on_estimates(study.members, _probability_text(totals))
            yield piece, rows

    return compute


def _probability_text(totals: Mapping[str, tuple[Floats, Floats]]) -> str:
    texts = []
    for name, (hits, samples) in totals.items():
        if samples.all():
            estimate = probability_from_counts(hits, samples)
            texts.append(f"P({name}) = {estimate.value:.4g} ± {estimate.error:.1g}")
    return ", ".join(texts)
