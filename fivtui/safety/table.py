"""Safe μ of many parameter sets: by continuation of every set, or by polynomials fitted to folds.

If one group varies, its range is split into cells until the error at test folds is small enough, or
the limit of folds is reached. If several groups vary, one polynomial is fitted to folds at draws of
the parameters, so that it is best where draws are likely.
"""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from fivtui.equilibrium import critical_mus
from fivtui.model import (
    PARAMETERS,
    ComputationError,
    OnProgress,
    Parameters,
    Progress,
    System,
)

from .least import GROUPS, MADE_OF, groups_of, least_of

Floats = NDArray[np.float64]

# Limit of folds of a table.
MOST_FOLDS: Final = 512
# Error of μ below which continuation stops.
_TARGET_ERROR: Final = 2e-5
# Bounds of safe μ along one group.
_BOUNDS: Final = (0.0, PARAMETERS["mu"].upper)
# Degree in a cell, number of folds for the fit, and number of folds for the test.
_DEGREE: Final = 8
_FITTED: Final = 14
_TRIED: Final = 6
# Total degrees over several groups, and largest ratio of coefficients to folds for the fit.
_DEGREES: Final = range(1, 7)
_FILLED: Final = 0.5
# Margin of the box and of safe μ beyond the fitted values, relative to their range.
_BOX_MARGIN: Final = 0.25
# One fold in this many is for the test. Folds of the first fit.
_TRY_EVERY: Final = 3
_FIRST: Final = 128
# Quantile of the errors that selects the degree.
_QUANTILE: Final = 0.95
# Spread, relative to the widest, below which a direction does not vary.
_FLAT: Final = 1e-6
_LEAST_CUBIC: Final = 1e-9
_BLOCK: Final = 1 << 16


class SafeCell(msgspec.Struct, frozen=True, array_like=True):
    """A box of a table with its polynomial, a list in files.

    `low` and `high` are its corners. Values of the polynomial are clipped to `least` and
    `greatest`; `degree` is the total degree, `coefficients` belong to the products of Chebyshev
    polynomials.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    least: float
    greatest: float
    degree: int
    coefficients: tuple[float, ...]


class SafeTable(msgspec.Struct, frozen=True):
    """Safe μ over the groups that vary.

    `groups` are those of `GROUPS` that vary, stiffnesses by their logarithms. `centre` is the
    origin of the coordinates of the cells, and `directions` has a row of weights of the groups for
    each coordinate. `folds` is the number of folds; `errors` of μ at test folds are ascending.
    """

    groups: tuple[str, ...]
    separation: bool
    centre: tuple[float, ...]
    directions: tuple[tuple[float, ...], ...]
    folds: int
    errors: tuple[float, ...]
    cells: tuple[SafeCell, ...]

    @property
    def error(self) -> float:
        """The greatest error."""
        return self.errors[-1]

    @property
    def usual_error(self) -> float:
        """The 95 % quantile of the errors at test folds."""
        return float(np.quantile(self.errors, _QUANTILE))

    def at(self, groups: Floats) -> Floats:
        """Safe μ at groups of shape (n, 5), clipped to the boxes; NaN where groups are NaN."""
        x = _coordinates(groups)[:, [GROUPS.index(name) for name in self.groups]]
        x = x - np.array(self.centre)
        # Explicit sums: the rounding of a matrix product depends on the number of rows.
        z = np.stack(
            [sum(x[:, k] * part for k, part in enumerate(row)) for row in self.directions], axis=1
        )
        defined = ~np.isnan(z).any(axis=1)
        low = np.min([cell.low for cell in self.cells], axis=0)
        high = np.max([cell.high for cell in self.cells], axis=0)
        inside = np.clip(z, low, high)
        mu = np.full(len(z), np.nan)
        for cell in self.cells:
            # A common face belongs to the last cell: both agree within the error.
            in_cell = defined & ((inside >= cell.low) & (inside <= cell.high)).all(axis=1)
            if in_cell.any():
                mu[in_cell] = _evaluate_cell(cell, inside[in_cell])
        return mu


def safe_mus(
    p: Parameters,
    varied: Mapping[str, Floats],
    separation: NDArray[np.bool_],
    table: SafeTable | None = None,
    progress: OnProgress | None = None,
) -> Floats:
    """Safe μ of n parameter sets by continuation from the Hopf point, shape (n,)."""
    groups = groups_of(p, varied, separation.size)
    if table is not None:
        critical = critical_mus(p, varied, separation)
        return np.where(np.isnan(critical), np.nan, np.minimum(table.at(groups), critical))
    rows, row_of = np.unique(np.column_stack([groups, separation]), axis=0, return_inverse=True)
    mu, work = np.full(len(rows), np.nan), Progress(progress)
    for row, (*group, considered) in enumerate(rows.tolist()):
        work.report(row / len(rows))
        if group[0] == group[0]:
            mu[row] = least_of(tuple(group), separation=bool(considered))
    return mu[row_of.ravel()]


def safe_table(
    system: System,
    ranges: Mapping[str, tuple[float, float]],
    draws: Mapping[str, Floats],
    *,
    progress: OnProgress | None = None,
) -> SafeTable | None:
    """A table of safe μ over varying parameters; None if only μ varies."""
    names = tuple(name for name in GROUPS if set(MADE_OF[name]) & ranges.keys())
    if not names:
        return None
    p, folds = system.parameters, _Folds(names, progress, separation=system.separation)
    if len(names) == 1:
        return _table_over_one_group(p, ranges, folds)
    return _table_over_groups(p, draws, folds)


class _Folds:
    # Continues folds, and counts them.

    def __init__(
        self, names: tuple[str, ...], progress: OnProgress | None, *, separation: bool
    ) -> None:
        self.names, self.separation = names, separation
        self.indices = [GROUPS.index(name) for name in names]
        self.count = 0
        self._work = Progress(progress)

    def at(self, coordinates: Floats) -> float:
        self._work.report(self.count / MOST_FOLDS)
        self.count += 1
        group = coordinates.copy()
        group[_LOG] = np.exp(group[_LOG])
        # Rounding may make a damping of 0 negative.
        return least_of(tuple(np.maximum(group, 0.0).tolist()), separation=self.separation)

    def table(
        self, centre: Floats, directions: Floats, cells: Sequence[SafeCell], errors: Floats
    ) -> SafeTable:
        return SafeTable(
            groups=self.names,
            separation=self.separation,
            centre=tuple(centre.tolist()),
            directions=tuple(map(tuple, directions.tolist())),
            folds=self.count,
            errors=tuple(np.sort(errors).tolist()),
            cells=tuple(cells),
        )


def _table_over_one_group(
    p: Parameters, ranges: Mapping[str, tuple[float, float]], folds: _Folds
) -> SafeTable:
    # Cells along the one group that varies; the cell of the greatest error is split next.
    corners = np.array(list(itertools.product(*ranges.values())))
    varied = dict(zip(ranges, corners.T, strict=True))
    if "F" in varied:
        # Safe μ needs a preload.
        least = varied["F"].max(initial=0.0) * np.sqrt(_LEAST_CUBIC)
        varied["F"] = np.maximum(varied["F"], least)
    x = _coordinates(groups_of(p, varied, len(corners)))
    _check_any(np.isfinite(x).all(axis=1))
    (index,) = folds.indices
    unit = _nodes(_FITTED, _TRIED)

    def cell(low: float, high: float) -> tuple[SafeCell, Floats]:
        nodes = np.repeat(x[:1], len(unit), axis=0)
        nodes[:, index] = low + (high - low) * 0.5 * (unit + 1.0)
        values = np.array([folds.at(node) for node in nodes])
        fits = np.arange(len(unit)) < _FITTED
        return _fit_cell(unit[:, None], values, fits, _DEGREE, ((low,), (high,), *_BOUNDS))

    cells = [cell(float(x[:, index].min()), float(x[:, index].max()))]
    while folds.count + 2 * len(unit) <= MOST_FOLDS:
        worst = max(range(len(cells)), key=lambda n: cells[n][1].max())
        box, errors = cells[worst]
        if errors.max() <= _TARGET_ERROR:
            break
        (low,), (high,) = box.low, box.high
        middle = 0.5 * (low + high)
        cells[worst : worst + 1] = [cell(low, middle), cell(middle, high)]
    all_errors = np.concatenate([errors for _, errors in cells])
    return folds.table(np.zeros(1), np.ones((1, 1)), [box for box, _ in cells], all_errors)


def _table_over_groups(p: Parameters, draws: Mapping[str, Floats], folds: _Folds) -> SafeTable:
    # One polynomial in the independent directions in which the groups vary.
    size = next(iter(draws.values())).size
    x = _coordinates(groups_of(p, draws, size))
    x = x[~np.isnan(x).any(axis=1)][:MOST_FOLDS]
    _check_any(np.ones(len(x), dtype=bool))
    varying = x[:, folds.indices]
    centre = varying.mean(axis=0)
    _, spreads, rows = np.linalg.svd(varying - centre, full_matrices=False)
    rows = rows[spreads > _FLAT * spreads[0]]
    z = (varying - centre) @ rows.T
    beyond = _BOX_MARGIN * np.ptp(z, axis=0)
    low, high = z.min(axis=0) - beyond, z.max(axis=0) + beyond
    unit = 2.0 * (z - low) / (high - low) - 1.0
    corners = (tuple(low.tolist()), tuple(high.tolist()))
    values = np.zeros(0)
    count = min(_FIRST, len(x))
    while True:
        values = np.append(values, [folds.at(node) for node in x[len(values) : count]])
        fits = np.arange(count) % _TRY_EVERY > 0
        room = _FILLED * np.count_nonzero(fits)
        # Far from all draws a polynomial may take any value: limit it.
        least, greatest = float(np.nanmin(values[fits])), float(np.nanmax(values[fits]))
        margin = _BOX_MARGIN * (greatest - least)
        box = (*corners, least - margin, greatest + margin)
        cells = [
            _fit_cell(unit[:count], values, fits, degree, box)
            for degree in _DEGREES
            if degree == 1 or len(_exponents(len(rows), degree)) <= room
        ]
        cell, errors = min(cells, key=lambda pair: float(np.quantile(pair[1], _QUANTILE)))
        if errors.max() <= _TARGET_ERROR or count == len(x):
            return folds.table(centre, rows, [cell], errors)
        count = min(2 * count, len(x))


def _check_any(defined: Any) -> None:
    if not defined.any() or not defined.all():
        raise ComputationError(
            "there is no safe μ in the ranges", "let F and k3 be above 0 in all of them"
        )


def _fit_cell(
    unit: Floats,
    values: Floats,
    fits: NDArray[np.bool_],
    degree: int,
    box: tuple[tuple[float, ...], tuple[float, ...], float, float],
) -> tuple[SafeCell, Floats]:
    # A cell, and its errors at test folds.
    exponents = _exponents(unit.shape[1], degree)
    use, test = ~np.isnan(values) & fits, ~np.isnan(values) & ~fits
    if np.count_nonzero(use) < len(exponents) or not test.any():
        raise ComputationError(
            "limit cycles cannot be followed in a part of the ranges",
            "scatter less, or leave out safe_mu",
        )
    basis = _basis(unit, exponents)
    coefficients = np.linalg.lstsq(basis[use], values[use], rcond=None)[0]
    errors = np.abs(np.clip(basis[test] @ coefficients, *box[2:]) - values[test])
    return SafeCell(*box, degree, tuple(coefficients.tolist())), errors


# Groups that are ratios of stiffnesses vary by factors.
_LOG: Final = np.array([name.startswith("k") for name in GROUPS])


def _coordinates(groups: Floats) -> Floats:
    x = groups.copy()
    x[:, _LOG] = np.log(np.maximum(x[:, _LOG], _LEAST_CUBIC))
    return x


def _nodes(fitted: int, tried: int) -> Floats:
    # Chebyshev nodes for the fit, then nodes between them for the test.
    nodes = -np.cos(np.pi * (np.arange(fitted) + 0.5) / fitted)
    between = -np.cos(np.pi * (np.arange(tried) + 1.0) / (tried + 1.0))
    return np.concatenate([nodes, between])


def _exponents(size: int, degree: int) -> NDArray[np.int64]:
    powers = itertools.product(range(degree + 1), repeat=size)
    return np.array([row for row in powers if sum(row) <= degree])


def _basis(x: Floats, exponents: NDArray[np.int64]) -> Floats:
    degree = int(exponents.max(initial=0))
    basis = np.ones((len(x), len(exponents)))
    for axis in range(x.shape[1]):
        terms = np.polynomial.chebyshev.chebvander(x[:, axis], degree)
        basis *= terms[:, exponents[:, axis]]
    return basis


def _evaluate_cell(cell: SafeCell, z: Floats) -> Floats:
    low, high = np.array(cell.low), np.array(cell.high)
    exponents = _exponents(len(low), cell.degree)
    unit = 2.0 * (z - low) / np.where(high > low, high - low, 1.0) - 1.0
    mu = np.zeros(len(unit))
    for first in range(0, len(unit), _BLOCK):
        block = slice(first, first + _BLOCK)
        # Term by term: the rounding of a matrix product depends on the number of rows.
        terms = _basis(unit[block], exponents).T
        for term, coefficient in zip(terms, cell.coefficients, strict=True):
            mu[block] += coefficient * term
    return np.clip(mu, cell.least, cell.greatest)
