"""Maps over two parameters of safe μ, or of the regions where a knock causes squeal.

Below safe μ no disturbance leads to vibration: it is the least μ of the limit cycles, or the
critical μ, above which the equilibrium is unstable.

At a fold a stable and an unstable cycle meet at the least μ of both; the folds of neighbouring
points form sheets. The excess of a point is negative where its equilibrium is stable, NaN without
a verdict.
"""

import contextlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.equilibrium import critical_mus
from fivtui.model import (
    ComputationError,
    OnProgress,
    Parameters,
    Progress,
    System,
    check_always_sliding,
    system_of,
)
from fivtui.orbits import stabilising_folds
from fivtui.safety import SafeFriction, safe_friction

from .escape import escape_offsets
from .fold_sheets import FoldSheets
from .result import KNOCK_REGION, SAFE_REGION, SAFETY_VALUES, SQUEAL_REGION, StabilityMap
from .searched_points import SearchedPoint, nearest_limits, searched_indices
from .stability import check_map, check_points, parse_map_value, stability_map

Floats = NDArray[np.float64]
MAX_POINTS: Final = 250_000
# Share of the progress of `_follow_folds` that is reported for its global searches.
_SEARCH_SHARE: Final = 0.4
# Share of the progress of a map of coexistence that is reported for the folds.
_FOLD_SHARE: Final = 0.5


def safety_map(
    parameters: Parameters | None,
    over: Mapping[str, Sequence[float] | Floats],
    value: str = "safe-mu",
    *,
    separation: bool = True,
    progress: OnProgress | None = None,
) -> StabilityMap:
    """Map the safe friction coefficient, or the regions where a knock causes squeal.

    At up to 9 × 9 points limit cycles are followed from the Hopf point to their folds. At the
    corners and the centre `safe_friction` makes a global search. All folds are followed from point
    to point over the map. A search may find a lower safe μ, or leave it unknown above some μ: at
    the nearest points a safe μ above that one is not known. Folds count even if a torus bifurcation
    makes the cycles beside them unstable.

    Parameters
    ----------
    parameters : Parameters or None
        The parameters that do not vary; those of the base set if None.
    over : mapping of str to sequence of float
        Two parameters and the values of each, in SI units.
    value : str
        ``"safe-mu"``, or ``"coexistence"``: three regions (safe, safe for small disturbances
        alone, squeals). In the second region the least vertical displacement from rest that leads
        to the other attractor is found by simulation.
    separation : bool
        Whether separation is considered.
    progress : callable, optional
        Called with the fraction done; cancels the map by returning False.

    Returns
    -------
    StabilityMap
        With the quantities ``safe_mu`` and ``critical_mu``, and of coexistence ``region`` and
        ``escape_offset``.

    Raises
    ------
    InputError
        If `over` has not two parameters, a name is unknown, a value is out of range, the map has
        more than 250 000 points, or safe μ is mapped over μ.
    ComputationError
        If a number overflows.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import Parameters, safety_map
    >>> result = safety_map(None, {"F": [80.0, 120.0], "k_nl": [50.0, 100.0]})
    >>> result.safe_mu.round(3).tolist()
    [[0.278, 0.278], [0.278, 0.278]]
    """
    system = system_of(parameters, separation)
    p = system.parameters
    map_kind = parse_map_value(value, SAFETY_VALUES)
    check_always_sliding(
        p, subject=f"maps of {value}; critical-mu and growth-rate can be mapped", varied=over
    )
    check_map(map_kind, list(over))
    check_points(math.prod(len(values) for values in over.values()), MAX_POINTS)
    linear = stability_map(p, over, "unstable-modes", separation=separation)
    critical = _critical_mus(linear)
    fold_share = 1.0 if value == "safe-mu" else _FOLD_SHARE
    work = Progress(progress)
    varied = {
        name: axis for name, axis in zip(linear.names, linear.axes, strict=True) if name != "mu"
    }
    verdicts, fold_mus, fold_half_ranges = _follow_folds(
        system, varied, work.stage(0.0, fold_share)
    )
    shape = critical.shape
    if "mu" in linear.names:
        # Folds do not depend on the μ of a point: repeat them along that axis.
        axis = linear.names.index("mu")
        fold_mus, fold_half_ranges = (
            np.broadcast_to(np.expand_dims(array, axis), shape)
            for array in (fold_mus, fold_half_ranges)
        )
        verdicts = {
            (*indices[:axis], index, *indices[axis:]): verdict
            for indices, verdict in verdicts.items()
            for index in range(shape[axis])
        }
    safe_mu = np.fmin(fold_mus, critical)
    safe_mu[np.isnan(linear.excess)] = np.nan
    # Of every search, the μ up to which it confirms the safe μ that continuation gives.
    searched = tuple(
        SearchedPoint(indices, verdict.limit_of(safe_mu[indices]))
        for indices, verdict in verdicts.items()
    )
    safe_mu[safe_mu > nearest_limits(searched, shape)] = np.nan
    quantities = {"safe_mu": safe_mu, "critical_mu": critical}
    if map_kind == "coexistence":
        regions = _regions(linear, safe_mu, searched)
        escape = np.full(shape, np.nan)
        coexists = (regions == KNOCK_REGION) & ~np.isnan(fold_half_ranges)
        escape[coexists] = escape_offsets(
            system,
            {name: mesh[coexists] for name, mesh in linear.grid.meshes().items()},
            fold_half_ranges[coexists],
            work=work.stage(fold_share, 1.0),
        )
        quantities |= {"region": regions, "escape_offset": escape}
    work.advance(1.0)
    return replace(linear, value=map_kind, quantities=quantities, searched=searched)


def _regions(linear: StabilityMap, safe_mu: Floats, searched: Sequence[SearchedPoint]) -> Floats:
    """Index in `REGIONS` of every point of a map, NaN if it is not known."""
    mu = linear.grid.meshes().get("mu", np.full(linear.excess.shape, linear.parameters.mu))
    with np.errstate(invalid="ignore"):
        regions = np.where(mu >= safe_mu, float(KNOCK_REGION), float(SAFE_REGION))
        regions[linear.excess >= 0.0] = SQUEAL_REGION
    # Safe μ is NaN where neither a fold nor a critical μ exists, or the nearest search does not
    # confirm it. Up to the limit of that search every μ is safe.
    unknown = np.isnan(safe_mu) & (mu > nearest_limits(searched, linear.excess.shape))
    regions[np.isnan(linear.excess) | (unknown & (regions == SAFE_REGION))] = np.nan
    return regions


def _critical_mus(linear: StabilityMap) -> Floats:
    """Critical friction coefficients at the points of a map, NaN without one."""
    varied = {name: mesh.ravel() for name, mesh in linear.grid.meshes().items()}
    separation = np.full(linear.grid.size, linear.separation)
    critical = critical_mus(linear.parameters, varied, separation).reshape(linear.grid.shape)
    critical[np.isnan(linear.excess)] = np.nan
    return critical


def _follow_folds(
    system: System, varied: Mapping[str, Floats], work: Progress
) -> tuple[dict[tuple[int, ...], SafeFriction], Floats, Floats]:
    # Verdicts of global searches by indices of their points; μ of the lowest fold at every point,
    # and half peak-to-peak of y, m, of the cycle at that fold.
    p, separation = system.parameters, system.separation
    shape = tuple(values.size for values in varied.values())
    damped = p.c1 > 0.0 or p.c2 > 0.0 or "c1" in varied or "c2" in varied
    nonlinear = separation or p.k_nl > 0.0 or "k_nl" in varied
    if not damped or not nonlinear:
        # A linear or an undamped system has no folds: eigenvalues decide.
        return {}, np.full(shape, np.nan), np.full(shape, np.nan)
    verdicts: dict[tuple[int, ...], SafeFriction] = {}
    searched = searched_indices(shape)
    for count, indices in enumerate(searched):
        work.report(_SEARCH_SHARE * count / len(searched))
        values = {
            name: float(axis[index])
            for (name, axis), index in zip(varied.items(), indices, strict=True)
        }
        with contextlib.suppress(ComputationError):
            verdicts[indices] = safe_friction(p.with_values(values), separation=separation)
    # The folds, on the branches of cycles that the searches followed, above which cycles attract:
    # the μ of one may be safe μ.
    seeds = [
        (indices, fold)
        for indices, verdict in verdicts.items()
        for curve in verdict.basis.branches
        for fold in stabilising_folds(curve)
    ]
    sheets = FoldSheets(
        system,
        varied,
        work=work.stage(_SEARCH_SHARE, 1.0),
        seeds=seeds,
    )
    return verdicts, *sheets.lowest_folds()
