"""Run uncertainty studies: in memory or into a file, to a number of samples or to an error."""

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
    Engine,
    Rows,
    ScatterKind,
    Study,
    Sweep,
    SweepPiece,
    begun_studies,
    check_in_memory,
    load_sweep,
    local_engine,
    sweep_in_memory,
    sweep_to_file,
)
from fivtui.transient import DEFAULT_T_END, DEFAULT_TOL, Start

from .request import (
    DEFAULT_OUTPUTS,
    DEFAULT_REPEATS,
    DEFAULT_SAMPLES,
    SAFE,
    as_inputs,
    check_until,
    scattered_study,
    with_table,
)
from .result import Uncertainty, events_of, judged, scatter_of
from .statistics import probability

Floats = NDArray[np.float64]
Tell = Callable[[int, str], object]


class Place(NamedTuple):
    """A file for the members, and the members of a piece of it."""

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
    """How likely squeal is where parameters scatter, and what drives it.

    Parameters
    ----------
    parameters : Parameters, optional
        The parameters that do not scatter; the base set by default.
    vary : mapping of str to Distribution or str
        Distributions of parameters, and of ``x0``, ``vx0``, ``y0``, ``vy0`` of the start: as text
        ``uniform:LOW:HIGH``, ``normal:MEAN:SD``, ``lognormal:MEAN:SD`` (both of the quantity
        itself), ``triangular:LOW:MODE:HIGH``, ``beta:LOW:HIGH:A:B``, or ``NAME:SHAPE:…:LOC:SCALE``
        of `scipy.stats`. They are truncated at the bounds of the parameters.
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
        Number of independent scramblings, from which intervals come.
    indices : bool, optional
        Whether Sobol indices are computed; by default where inputs are not correlated.
    outputs : iterable of str
        Quantities besides the growth rate: ``critical_mu``, ``safe_mu``, and those of `sweep`.
    separation, start, t_end, tol
        As in `simulate`.
    progress : callable, optional
        Called with the fraction done; the study stops when it returns False.
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
    >>> found = uncertainty(vary={"mu": "uniform:0:1"}, outputs=["critical_mu"])
    >>> round(found.probabilities["unstable"].value, 3)
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
        as_inputs(vary),
        correlations=tuple((a, b, value) for (a, b), value in correlations.items()),
        design=design,
        samples=samples,
        seed=seed,
        repeats=repeats,
        indices=indices,
        outputs=check_names("outputs", outputs),
    )
    return measured(study, local_engine(workers), until=until, progress=progress)


def measured(
    study: Study,
    engine: Engine,
    *,
    until: float | None = None,
    place: Place | None = None,
    progress: OnProgress | None = None,
    tell: Tell | None = None,
) -> Uncertainty:
    """The result of a scattered sweep."""
    if tell is not None and SAFE in study.outputs:
        tell(study.members, "following branches of limit cycles")
    folds = None if progress is None else lambda _fraction: progress(0.0)
    study = with_table(study, folds)
    if until is None:
        return judged(_swept(study, _watched(engine, tell), place, progress))
    wanted = check_until(until)
    if scatter_of(study).kind != "sobol":
        raise InputError("until: must be given with the design sobol, whose points can be added to")
    study, known, place = _begun(study, place)
    while True:
        watched = _watched(_continued(engine, known), tell)
        found = judged(_swept(study, watched, place, progress))
        if found.error <= wanted:
            return found
        # A stage's file is there until that of the next one is complete.
        known, study = found.sweep.table, _doubled(found, wanted)
        place = None if place is None else place._replace(out=output_path(place.out, force=True))


def _doubled(found: Uncertainty, wanted: float) -> Study:
    study = _with_count(found.study, 2 * found.scatter.count)
    try:
        check_in_memory(study)
    except InputError:
        fewer_runs = ", or leave out Sobol indices" if found.scatter.indices else ""
        raise ComputationError(
            f"the error of the probabilities is {found.error:.2g} with {found.scatter.samples} "
            f"samples, not {wanted:g}",
            f"allow a larger error{fewer_runs}",
        ) from None
    return study


def _with_count(study: Study, count: int) -> Study:
    return replace(study, design=replace(scatter_of(study), count=count))


def _begun(study: Study, place: Place | None) -> tuple[Study, Rows | None, Place | None]:
    # The number of samples that an earlier run had come to, the rows of the number before, and
    # whether a file of that is to be replaced.
    if place is None or is_replaceable(place.out):
        return study, None, place
    stored, under_way = (
        found if found is not None and found == _like(study, found) else None
        for found in begun_studies(place.out)
    )
    latest = under_way or stored
    if latest is None:
        return study, None, place
    known = None if stored is None else load_sweep(stored, place.out).table
    replaced = stored is not None and stored != latest
    return latest, known, place._replace(out=output_path(place.out, force=replaced))


def _like(study: Study, other: Study) -> Study | None:
    # A study with the number of samples of another one.
    try:
        return _with_count(study, scatter_of(other).count)
    except InputError:
        return None


def _swept(study: Study, engine: Engine, place: Place | None, progress: OnProgress | None) -> Sweep:
    check_in_memory(study)
    if place is None:
        return sweep_in_memory(study, engine, progress=progress)
    sweep_to_file(study, place.out, engine, size=place.piece, progress=progress)
    return load_sweep(study, place.out)


def _continued(engine: Engine, known: Rows | None) -> Engine:
    # An engine that has the first members already.
    if known is None:
        return engine

    def continued(study: Study, pieces: Iterable[SweepPiece]) -> Generator[tuple[SweepPiece, Rows]]:
        asked = list(pieces)
        there = [piece for piece in asked if piece.last <= len(known.reasons)]
        for piece in there:
            yield piece, known.part(piece.first, piece.last)
        yield from engine(study, asked[len(there) :])

    return continued


def _watched(engine: Engine, tell: Tell | None) -> Engine:
    # An engine that tells the probabilities of what it has computed.
    if tell is None:
        return engine

    def watched(study: Study, pieces: Iterable[SweepPiece]) -> Generator[tuple[SweepPiece, Rows]]:
        scatter = scatter_of(study)
        sums: dict[str, tuple[Floats, Floats]] = {}
        for piece, rows in engine(study, pieces):
            members = np.arange(piece.first, piece.last)
            point, block = np.divmod(members, scatter.blocks)
            for name, holds in events_of(study, rows.numbers).items():
                counted = (block < 2) & ~np.isnan(holds)
                scrambling = point[counted] % scatter.repeats
                hits, counts = (
                    np.bincount(scrambling, weights, scatter.repeats)
                    for weights in (holds[counted], np.ones(scrambling.size))
                )
                before = sums.get(name, (np.zeros(1), np.zeros(1)))
                sums[name] = (before[0] + hits, before[1] + counts)
            tell(study.members, _words(sums))
            yield piece, rows

    return watched


def _words(sums: Mapping[str, tuple[Floats, Floats]]) -> str:
    parts = []
    for name, (hits, counts) in sums.items():
        if counts.all():
            found = probability(hits, counts)
            parts.append(f"P({name}) = {found.value:.4g} ± {found.error:.1g}")
    return ", ".join(parts)
