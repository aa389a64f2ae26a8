"""Maps over two parameters: safe friction coefficients, and where a knock is enough to squeal."""

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from fivtui.equilibrium import StabilityMap, critical_mus, stability_map
from fivtui.model import (
    PARAMETERS,
    Cancelled,
    ComputationError,
    InputError,
    Parameters,
    System,
    check_always_sliding,
    system_of,
    unknown_name,
)
from fivtui.orbits import folds_of
from fivtui.results import SystemResult, scene_text
from fivtui.transient import Progress

from .escape import escape_offsets
from .searched import SearchedPoint, limits, searched_places
from .sheets import FoldSheets
from .verdict import SafeFriction, safe_friction

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
SafetyValue = Literal["safe-mu", "coexistence"]

SAFETY_VALUES: Final[tuple[SafetyValue, ...]] = get_args(SafetyValue)
# What a map of coexistence says of a point.
REGIONS: Final = ("safe", "safe for small disturbances alone", "squeals")
# What it says of points whose safe μ is not known.
NOT_KNOWN: Final = "not known"
MAX_POINTS: Final = 250_000
# Share of the global searches in the work for safe μ.
_SHARE_OF_SEARCHES: Final = 0.4


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SafetyMap(SystemResult):
    """The safe friction coefficient over two parameters, or the three regions that it bounds.

    Attributes
    ----------
    system : System
        The system, with `parameters` that do not vary and `separation`.
    names : tuple of str
        Names of the two parameters.
    axes : tuple of ndarray, shapes (n,) and (k,)
        Their values.
    value : str
        ``"safe-mu"`` or ``"coexistence"``.
    safe_mu : ndarray, shape (n, k)
        The least μ of the limit cycles that continuation found, else the critical μ; NaN where
        there is neither, or no equilibrium, or where the global search at the nearest of the points
        searched says that it is less, or not known.
    critical_mu : ndarray, shape (n, k)
        The critical friction coefficient, NaN where there is none.
    excess : ndarray, shape (n, k)
        As in `StabilityMap`: negative where the equilibrium is stable.
    escape : ndarray, shape (n, k), or None
        In a map of coexistence the least vertical displacement from rest, m, that leads to the
        other attractor, to 2 %; NaN outside the region of coexistence.
    searched : tuple of SearchedPoint
        The points at which a global search was made: corners and centre.
    """

    system: System
    names: tuple[str, str]
    axes: tuple[Floats, Floats]
    value: SafetyValue
    safe_mu: Floats
    critical_mu: Floats
    excess: Floats
    escape: Floats | None
    searched: tuple[SearchedPoint, ...] = ()

    @property
    def unknown(self) -> NDArray[np.bool_]:
        """Where safe μ is not known: the nearest global search contradicts continuation."""
        refuted = limits(self.searched, self.excess.shape) < PARAMETERS["mu"].upper
        missing = np.isnan(self.safe_mu) & ~np.isnan(self.excess)
        return missing & (refuted | ~np.isnan(self.critical_mu))

    @property
    def values(self) -> Floats:
        """The quantity mapped: the safe μ, or the index in `REGIONS`; NaN for none."""
        return self.safe_mu if self.value == "safe-mu" else self.regions

    @property
    def missing(self) -> str:
        """What it means that a point, other than of `unknown`, has no value."""
        return "none" if self.value == "safe-mu" else "no equilibrium"

    @property
    def regions(self) -> Floats:
        """Index in `REGIONS` of every point at its μ, NaN without equilibrium."""
        mu = np.full(self.excess.shape, self.parameters.mu)
        if "mu" in self.names:
            axis = self.names.index("mu")
            mu[:] = np.expand_dims(self.axes[axis], 1 - axis)
        with np.errstate(invalid="ignore"):
            found = np.where(self.excess >= 0.0, 2.0, np.where(mu >= self.safe_mu, 1.0, 0.0))
        unknown = np.isnan(self.safe_mu) & (mu > limits(self.searched, self.excess.shape))
        found[np.isnan(self.excess) | (unknown & (found == 0.0))] = np.nan
        return found

    def _summary(self) -> list[tuple[str, str]]:
        scene = scene_text(self.system, without=self.names)
        counts = [int(np.count_nonzero(self.regions == one)) for one in range(len(REGIONS))]
        known = self.safe_mu[~np.isnan(self.safe_mu)]
        span = f"{known.min():.6g} to {known.max():.6g}" if known.size else "none"
        return [
            ("scene", scene),
            *(
                (name, f"{axis[0]:g} to {axis[-1]:g}, {axis.size} values")
                for name, axis in zip(self.names, self.axes, strict=True)
            ),
            ("safe mu", f"{span}, by {basis_words(self)}"),
            *(
                (name, f"{count} of {self.excess.size} points")
                for name, count in zip(REGIONS, counts, strict=True)
            ),
        ]

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui map --value safe-mu --json`` prints."""
        from .files import safety_map_to_dict

        return safety_map_to_dict(self)

    def to_columns(self) -> dict[str, Floats]:
        """One element per point, the second parameter varying fastest; NaN for no value."""
        from .files import safety_map_columns

        return safety_map_columns(self)

    def figure(self) -> "Figure":
        """Matplotlib figure of the map."""
        from .figure import safety_map_figure

        return safety_map_figure(self)


def safety_map(
    parameters: Parameters | None,
    over: Mapping[str, Sequence[float] | Floats],
    value: str = "safe-mu",
    *,
    separation: bool = True,
    progress: Progress | None = None,
) -> SafetyMap:
    """Map the safe friction coefficient, or where a knock is enough to squeal.

    At 9 × 9 points limit cycles are followed from the Hopf point, at the corners and the centre a
    global search is made as by `safe_friction`, and all folds are followed from point to point over
    the whole map. Where that search says that the safe μ is less, or not known, it is not known at
    the points that are nearest to it either. At a fold whose cycles attract from a torus on only,
    the fold counts.

    Parameters
    ----------
    parameters : Parameters or None
        The parameters that do not vary; those of the base set if None.
    over : mapping of str to sequence of float
        Two parameters and the values of each, in SI units.
    value : str
        ``"safe-mu"``, or ``"coexistence"``: three regions (safe, safe for small disturbances
        alone, squeals) and in the second the least vertical displacement from rest that leads to
        the other attractor, by transients.
    separation : bool
        Whether separation is considered.
    progress : callable, optional
        Called with the fraction done; cancels the map by returning False.

    Returns
    -------
    SafetyMap
        The map.

    Raises
    ------
    InputError
        If `over` has not two parameters, a name is unknown, a value is out of range, the map has
        more than 250 000 points, or the safe μ is wanted over μ.
    ComputationError
        If a number overflows.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import Parameters, safety_map
    >>> found = safety_map(None, {"F": [80.0, 120.0], "k_nl": [50.0, 100.0]})
    >>> found.safe_mu.round(3).tolist()
    [[0.278, 0.278], [0.278, 0.278]]
    """
    system = system_of(parameters, separation)
    p = system.parameters
    if value not in SAFETY_VALUES:
        raise unknown_name("map value", value, SAFETY_VALUES)
    check_always_sliding(p, f"maps of {value}; critical-mu and growth-rate are known", over)
    if value == "safe-mu" and "mu" in over:
        raise InputError(
            "safe-mu over mu: must be over two other parameters, as it does not depend on mu"
        )
    total = int(np.prod([len(values) for values in over.values()]))
    if total > MAX_POINTS:
        raise InputError(f"over: {total} points; must be at most {MAX_POINTS}")
    plain = stability_map(p, over, "unstable-modes", separation=separation)
    critical = critical_over(plain)
    share = 1.0 if value == "safe-mu" else 0.5

    def tell(fraction: float) -> None:
        if progress is not None and not progress(fraction):
            raise Cancelled

    varied = {
        name: axis for name, axis in zip(plain.names, plain.axes, strict=True) if name != "mu"
    }
    verdicts, least, sizes = _folds(system, varied, lambda done: tell(share * done))
    shape = critical.shape
    if "mu" in plain.names:
        axis = plain.names.index("mu")
        least, sizes = (np.broadcast_to(np.expand_dims(a, axis), shape) for a in (least, sizes))
        verdicts = {
            (*place[:axis], index, *place[axis:]): verdict
            for place, verdict in verdicts.items()
            for index in range(shape[axis])
        }
    safe = np.fmin(least, critical)
    safe[np.isnan(plain.excess)] = np.nan
    searched = tuple(
        SearchedPoint(place, verdict.limit_of(safe[place])) for place, verdict in verdicts.items()
    )
    safe[safe > limits(searched, shape)] = np.nan
    result = SafetyMap(
        system=system,
        names=plain.names,
        axes=plain.axes,
        value=next(known for known in SAFETY_VALUES if known == value),
        safe_mu=safe,
        critical_mu=critical,
        excess=plain.excess,
        escape=None,
        searched=searched,
    )
    if value == "coexistence":
        escape = np.full(shape, np.nan)
        inside = (result.regions == 1.0) & ~np.isnan(sizes)
        grids = np.meshgrid(*plain.axes, indexing="ij")
        columns = {name: grid[inside] for name, grid in zip(plain.names, grids, strict=True)}
        escape[inside] = escape_offsets(
            system,
            columns,
            sizes[inside],
            tell=lambda done: tell(share + (1.0 - share) * done),
        )
        result = replace(result, escape=escape)
    if progress is not None:
        progress(1.0)
    return result


def basis_words(result: SafetyMap) -> str:
    """What the safe μ of a map rest on, in one phrase."""
    words = "continuation"
    if result.searched:
        words += f", and a global search at {len(result.searched)} points"
    count = int(np.count_nonzero(result.unknown))
    if count:
        words += f"; not known at {count} points near those where the search found less"
    return words


def critical_over(plain: StabilityMap) -> Floats:
    """Critical friction coefficients at the points of a map, NaN where there is none."""
    grids = np.meshgrid(*plain.axes, indexing="ij")
    varied = {name: grid.ravel() for name, grid in zip(plain.names, grids, strict=True)}
    found = critical_mus(plain.parameters, varied, np.full(grids[0].size, plain.separation))
    found = found.reshape(plain.excess.shape)
    found[np.isnan(plain.excess)] = np.nan
    return found


def _folds(
    system: System, varied: Mapping[str, Floats], tell: Callable[[float], None]
) -> tuple[dict[tuple[int, ...], SafeFriction], Floats, Floats]:
    # Verdicts of global searches by place; at every point the least μ of a fold, and its size.
    p, separation = system.parameters, system.separation
    shape = tuple(values.size for values in varied.values())
    damped = p.c1 > 0.0 or p.c2 > 0.0 or "c1" in varied or "c2" in varied
    bent = separation or p.k_nl > 0.0 or "k_nl" in varied
    if not damped or not bent:
        # Linear, or nothing dies out: eigenvalues say all.
        return {}, np.full(shape, np.nan), np.full(shape, np.nan)
    verdicts: dict[tuple[int, ...], SafeFriction] = {}
    places = searched_places(shape)
    for count, place in enumerate(places):
        tell(_SHARE_OF_SEARCHES * count / len(places))
        values = {
            name: float(axis[at]) for (name, axis), at in zip(varied.items(), place, strict=True)
        }
        with contextlib.suppress(ComputationError):
            verdicts[place] = safe_friction(p.with_values(values), separation=separation)
    seeds = [
        (place, fold)
        for place, verdict in verdicts.items()
        for curve in verdict.basis.branches
        for fold in folds_of(curve)
    ]
    sheets = FoldSheets(
        system,
        varied,
        tell=lambda done: tell(_SHARE_OF_SEARCHES + (1.0 - _SHARE_OF_SEARCHES) * done),
        seeds=seeds,
    )
    return verdicts, *sheets.least()
