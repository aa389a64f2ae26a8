"""Maps over two parameters: safe friction coefficients, and regions where a knock causes squeal."""

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
from .result import MAP_VALUES, SAFETY_VALUES, StabilityMap
from .searched import SearchedPoint, limits, searched_indices
from .sheets import FoldSheets
from .stability import check_map, check_points, map_value, stability_map

Floats = NDArray[np.float64]
MAX_POINTS: Final = 250_000
# Share of the global searches in the progress of safe μ.
_SHARE_OF_SEARCHES: Final = 0.4


def safety_map(
    parameters: Parameters | None,
    over: Mapping[str, Sequence[float] | Floats],
    value: str = "safe-mu",
    *,
    separation: bool = True,
    progress: OnProgress | None = None,
) -> StabilityMap:
    """Map the safe friction coefficient, or the regions where a knock causes squeal.

    At 9 × 9 points limit cycles are followed from the Hopf point. At the corners and the centre
    `safe_friction` makes a global search. All folds are followed from point to point over the map.
    If a search finds a lower safe μ, or none, the nearest points of the map have no known safe μ.
    A fold counts even if its cycles attract only beyond a torus bifurcation.

    Parameters
    ----------
    parameters : Parameters or None
        The parameters that do not vary; those of the base set if None.
    over : mapping of str to sequence of float
        Two parameters and the values of each, in SI units.
    value : str
        ``"safe-mu"``, or ``"coexistence"``: three regions (safe, safe for small disturbances
        alone, squeals). In the second, transients give the least vertical displacement from rest
        that leads to the other attractor.
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
    kind = map_value(value, SAFETY_VALUES)
    check_always_sliding(p, f"maps of {value}; critical-mu and growth-rate are known", over)
    check_map(kind, list(over))
    check_points(math.prod(len(values) for values in over.values()), MAX_POINTS)
    plain = stability_map(p, over, "unstable-modes", separation=separation)
    critical = _critical_over(plain)
    share = 1.0 if value == "safe-mu" else 0.5
    work = Progress(progress)
    varied = {
        name: axis for name, axis in zip(plain.names, plain.axes, strict=True) if name != "mu"
    }
    verdicts, least, sizes = _folds(system, varied, work.part(0.0, share))
    shape = critical.shape
    if "mu" in plain.names:
        axis = plain.names.index("mu")
        least, sizes = (np.broadcast_to(np.expand_dims(a, axis), shape) for a in (least, sizes))
        verdicts = {
            (*indices[:axis], index, *indices[axis:]): verdict
            for indices, verdict in verdicts.items()
            for index in range(shape[axis])
        }
    safe = np.fmin(least, critical)
    safe[np.isnan(plain.excess)] = np.nan
    searched = tuple(
        SearchedPoint(indices, verdict.limit_of(safe[indices]))
        for indices, verdict in verdicts.items()
    )
    safe[safe > limits(searched, shape)] = np.nan
    quantities = {"safe_mu": safe, "critical_mu": critical}
    if kind == "coexistence":
        regions = _regions_of(plain, safe, searched)
        escape = np.full(shape, np.nan)
        inside = (regions == 1.0) & ~np.isnan(sizes)
        escape[inside] = escape_offsets(
            system,
            {name: mesh[inside] for name, mesh in plain.grid.meshes().items()},
            sizes[inside],
            work=work.part(share, 1.0),
        )
        quantities |= {"region": regions, "escape_offset": escape}
    work.advance(1.0)
    return replace(plain, value=kind, quantities=quantities, searched=searched)


def compute_map(
    parameters: Parameters | None,
    over: Mapping[str, Sequence[float] | Floats],
    value: str,
    *,
    separation: bool = True,
    progress: OnProgress | None = None,
) -> StabilityMap:
    """A map of any value, by `stability_map` or `safety_map`."""
    compute = safety_map if map_value(value, MAP_VALUES) in SAFETY_VALUES else stability_map
    return compute(parameters, over, value, separation=separation, progress=progress)


def _regions_of(plain: StabilityMap, safe_mu: Floats, searched: Sequence[SearchedPoint]) -> Floats:
    """Index in `REGIONS` of every point of a map, NaN where it is not known."""
    mu = plain.grid.meshes().get("mu", np.full(plain.excess.shape, plain.parameters.mu))
    with np.errstate(invalid="ignore"):
        regions = np.where(plain.excess >= 0.0, 2.0, np.where(mu >= safe_mu, 1.0, 0.0))
    unknown = np.isnan(safe_mu) & (mu > limits(searched, plain.excess.shape))
    regions[np.isnan(plain.excess) | (unknown & (regions == 0.0))] = np.nan
    return regions


def _critical_over(plain: StabilityMap) -> Floats:
    """Critical friction coefficients at the points of a map, NaN where there is none."""
    varied = {name: mesh.ravel() for name, mesh in plain.grid.meshes().items()}
    separation = np.full(plain.grid.size, plain.separation)
    critical = critical_mus(plain.parameters, varied, separation).reshape(plain.grid.shape)
    critical[np.isnan(plain.excess)] = np.nan
    return critical


def _folds(
    system: System, varied: Mapping[str, Floats], work: Progress
) -> tuple[dict[tuple[int, ...], SafeFriction], Floats, Floats]:
    # Verdicts of global searches by indices; for every point the least fold's μ and half range.
    p, separation = system.parameters, system.separation
    shape = tuple(values.size for values in varied.values())
    damped = p.c1 > 0.0 or p.c2 > 0.0 or "c1" in varied or "c2" in varied
    bent = separation or p.k_nl > 0.0 or "k_nl" in varied
    if not damped or not bent:
        # A linear or an undamped system has no folds: eigenvalues decide.
        return {}, np.full(shape, np.nan), np.full(shape, np.nan)
    verdicts: dict[tuple[int, ...], SafeFriction] = {}
    points = searched_indices(shape)
    for count, indices in enumerate(points):
        work.report(_SHARE_OF_SEARCHES * count / len(points))
        values = {
            name: float(axis[at]) for (name, axis), at in zip(varied.items(), indices, strict=True)
        }
        with contextlib.suppress(ComputationError):
            verdicts[indices] = safe_friction(p.with_values(values), separation=separation)
    seeds = [
        (indices, fold)
        for indices, verdict in verdicts.items()
        for curve in verdict.basis.branches
        for fold in stabilising_folds(curve)
    ]
    sheets = FoldSheets(
        system,
        varied,
        work=work.part(_SHARE_OF_SEARCHES, 1.0),
        seeds=seeds,
    )
    return verdicts, *sheets.lowest_folds()
