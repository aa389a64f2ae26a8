"""Safe μ of many parameter sets: by continuation for every set, or by polynomials fitted to folds.

Safe μ is the least μ of a stable limit cycle on the branch from the Hopf point, at most the
critical μ. The branch usually folds there: a fold here is one safe μ computed by continuation.
Groups are the dimensionless groups of the parameters.

If one group varies, its range is split into cells until the error at test folds is small enough, or
the limit of folds is reached. If several groups vary, one polynomial is fitted to folds at random
parameters, so that it is most accurate where these are likely.
"""

import itertools
from collections.abc import Mapping, Sequence
from typing import Final

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

from .hopf_branch import GROUP_PARAMETERS, GROUPS, dimensionless_groups, least_cycle_mu

Floats = NDArray[np.float64]

# Greatest number of folds of a table.
MAX_FOLDS: Final = 512
# Error of μ at which a table is accurate enough.
_TARGET_ERROR: Final = 2e-5
# Values of polynomials along one group are clipped to the range of μ.
_MU_RANGE: Final = (0.0, PARAMETERS["mu"].upper)
# Over one group: degree of the polynomial of a cell, and its folds for the fit and for the test.
_CELL_DEGREE: Final = 8
_FIT_NODES: Final = 14
_TEST_NODES: Final = 6
# Over several groups: the total degrees that are tried, and the limit of coefficients per fold.
_TOTAL_DEGREES: Final = range(1, 7)
_MAX_COEFFICIENTS_PER_FOLD: Final = 0.5
# Over several groups: how far the box reaches beyond the coordinates of the folds, and the limits
# of the polynomial beyond their safe μ, each relative to the range of these.
_MARGIN: Final = 0.25
# One fold in this many is for the test; number of folds of the first fit.
_TEST_EVERY: Final = 3
_FIRST_FOLDS: Final = 128
# Quantile of the errors that selects the degree.
_QUANTILE: Final = 0.95
# A direction whose spread, relative to the widest, is below this does not vary.
_FLAT_SPREAD: Final = 1e-6
# Lower bound of a stiffness before its logarithm.
_LEAST_STIFFNESS: Final = 1e-9
# Number of points whose polynomials are evaluated together: bounds the memory.
_BLOCK_SIZE: Final = 1 << 16


class SafeCell(msgspec.Struct, frozen=True, array_like=True):
    """A box of a table with its polynomial; files store it as a list.

    `low` and `high` are the corners of the box. Values of the polynomial are clipped to `least` and
    `greatest`; `degree` is its total degree, `coefficients` are those of products of Chebyshev
    polynomials.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    least: float
    greatest: float
    degree: int
    coefficients: tuple[float, ...]


class SafeTable(msgspec.Struct, frozen=True):
    """Safe μ over the dimensionless groups that vary.

    `groups` names them; `separation` is whether the slider may leave the belt. A coordinate of a
    cell is a weighted sum of the groups less their values at `centre`, with logarithms in place of
    stiffnesses; `directions` has a row of weights for each coordinate. `folds` is the number of
    folds; `errors` are errors of μ at test folds, ascending.
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
        """The greatest error at test folds."""
        return self.errors[-1]

    @property
    def usual_error(self) -> float:
        """The 95 % quantile of the errors at test folds."""
        return float(np.quantile(self.errors, _QUANTILE))

    def at(self, groups: Floats) -> Floats:
        """Safe μ at groups of shape (n, 5), clipped to the boxes; NaN where groups are NaN."""
        points = _coordinates(groups)[:, [GROUPS.index(name) for name in self.groups]]
        points = points - np.array(self.centre)
        # Explicit sums: rounding in a matrix product depends on the number of rows.
        positions = np.stack(
            [
                sum(points[:, column] * weight for column, weight in enumerate(weights))
                for weights in self.directions
            ],
            axis=1,
        )
        defined = ~np.isnan(positions).any(axis=1)
        low = np.min([cell.low for cell in self.cells], axis=0)
        high = np.max([cell.high for cell in self.cells], axis=0)
        positions = np.clip(positions, low, high)
        mu = np.full(len(positions), np.nan)
        for cell in self.cells:
            # A face of two cells belongs to the second: both agree within the error.
            in_cell = defined & ((positions >= cell.low) & (positions <= cell.high)).all(axis=1)
            if in_cell.any():
                mu[in_cell] = _evaluate_cell(cell, positions[in_cell])
        return mu


def safe_mus(
    p: Parameters,
    varied: Mapping[str, Floats],
    separation: NDArray[np.bool_],
    table: SafeTable | None = None,
    progress: OnProgress | None = None,
) -> Floats:
    """Safe μ of n parameter sets by continuation from the Hopf point or a table, shape (n,).

    `varied` has columns of the parameters that differ from `p`; `separation` says for each set
    whether the slider may leave the belt.
    """
    groups = dimensionless_groups(p, varied, separation.size)
    if table is not None:
        critical = critical_mus(p, varied, separation)
        return np.where(np.isnan(critical), np.nan, np.minimum(table.at(groups), critical))
    # Sets of equal groups have the same safe μ: follow one branch for all of them.
    rows, row_of_set = np.unique(np.column_stack([groups, separation]), axis=0, return_inverse=True)
    mu, work = np.full(len(rows), np.nan), Progress(progress)
    for row, (*group, considers_separation) in enumerate(rows.tolist()):
        work.report(row / len(rows))
        if not np.isnan(group[0]):
            mu[row] = least_cycle_mu(tuple(group), separation=bool(considers_separation))
    return mu[row_of_set.ravel()]


def safe_table(
    system: System,
    ranges: Mapping[str, tuple[float, float]],
    draws: Mapping[str, Floats],
    *,
    progress: OnProgress | None = None,
) -> SafeTable | None:
    """A table of safe μ over parameters with ranges and random draws; None if only μ varies."""
    names = tuple(name for name in GROUPS if set(GROUP_PARAMETERS[name]) & ranges.keys())
    if not names:
        return None
    p, folds = system.parameters, _Folds(names, progress, separation=system.separation)
    if len(names) == 1:
        return _table_over_one_group(p, ranges, folds)
    return _table_over_groups(p, draws, folds)


class _Folds:
    # Computes safe μ by continuation at coordinates, and counts these folds. `names` are the groups
    # that vary, `indices` their positions among all groups.

    def __init__(
        self, names: tuple[str, ...], progress: OnProgress | None, *, separation: bool
    ) -> None:
        self.names, self.separation = names, separation
        self.indices = [GROUPS.index(name) for name in names]
        self.count = 0
        self._work = Progress(progress)

    def mu_at(self, coordinates: Floats) -> float:
        self._work.report(self.count / MAX_FOLDS)
        self.count += 1
        group = coordinates.copy()
        group[_IS_LOGARITHMIC] = np.exp(group[_IS_LOGARITHMIC])
        # Rounding may make a damping of zero negative.
        return least_cycle_mu(tuple(np.maximum(group, 0.0).tolist()), separation=self.separation)

    def build_table(
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
    # A table of cells along one group; the cell with the greatest error is split next.
    corners = np.array(list(itertools.product(*ranges.values())))
    varied = dict(zip(ranges, corners.T, strict=True))
    if "F" in varied:
        # Safe μ needs a preload. The group of k_nl is proportional to F²: at the least load it is
        # _LEAST_STIFFNESS times its value at the greatest.
        least_load = varied["F"].max(initial=0.0) * np.sqrt(_LEAST_STIFFNESS)
        varied["F"] = np.maximum(varied["F"], least_load)
    points = _coordinates(dimensionless_groups(p, varied, len(corners)))
    if not np.isfinite(points).all():
        raise _undefined_error()
    (index,) = folds.indices
    # Positions of the folds in a cell, scaled to -1 .. 1.
    scaled = _fit_and_test_nodes(_FIT_NODES, _TEST_NODES)

    def fit_cell(low: float, high: float) -> tuple[SafeCell, Floats]:
        nodes = np.repeat(points[:1], len(scaled), axis=0)
        nodes[:, index] = low + (high - low) * 0.5 * (scaled + 1.0)
        values = np.array([folds.mu_at(node) for node in nodes])
        is_fit = np.arange(len(scaled)) < _FIT_NODES
        limits = ((low,), (high,), *_MU_RANGE)
        return _fit_cell(scaled[:, None], values, is_fit, _CELL_DEGREE, limits)

    cells = [fit_cell(float(points[:, index].min()), float(points[:, index].max()))]
    while folds.count + 2 * len(scaled) <= MAX_FOLDS:
        worst = max(range(len(cells)), key=lambda position: cells[position][1].max())
        cell, errors = cells[worst]
        if errors.max() <= _TARGET_ERROR:
            break
        (low,), (high,) = cell.low, cell.high
        middle = 0.5 * (low + high)
        cells[worst : worst + 1] = [fit_cell(low, middle), fit_cell(middle, high)]
    all_errors = np.concatenate([errors for _, errors in cells])
    return folds.build_table(np.zeros(1), np.ones((1, 1)), [cell for cell, _ in cells], all_errors)


def _table_over_groups(p: Parameters, draws: Mapping[str, Floats], folds: _Folds) -> SafeTable:
    # A table of one polynomial in the independent directions in which the groups vary.
    size = next(iter(draws.values())).size
    points = _coordinates(dimensionless_groups(p, draws, size))
    points = points[~np.isnan(points).any(axis=1)][:MAX_FOLDS]
    if not len(points):
        raise _undefined_error()
    varying = points[:, folds.indices]
    centre = varying.mean(axis=0)
    _, spreads, directions = np.linalg.svd(varying - centre, full_matrices=False)
    directions = directions[spreads > _FLAT_SPREAD * spreads[0]]
    positions = (varying - centre) @ directions.T
    box_margin = _MARGIN * np.ptp(positions, axis=0)
    low, high = positions.min(axis=0) - box_margin, positions.max(axis=0) + box_margin
    scaled = 2.0 * (positions - low) / (high - low) - 1.0
    corners = (tuple(low.tolist()), tuple(high.tolist()))
    values = np.zeros(0)
    count = min(_FIRST_FOLDS, len(points))
    while True:
        values = np.append(values, [folds.mu_at(node) for node in points[len(values) : count]])
        is_fit = np.arange(count) % _TEST_EVERY > 0
        max_coefficients = _MAX_COEFFICIENTS_PER_FOLD * np.count_nonzero(is_fit)
        # Far from all draws a polynomial may have any value: clip it.
        least, greatest = float(np.nanmin(values[is_fit])), float(np.nanmax(values[is_fit]))
        mu_margin = _MARGIN * (greatest - least)
        limits = (*corners, least - mu_margin, greatest + mu_margin)
        cells = [
            _fit_cell(scaled[:count], values, is_fit, degree, limits)
            for degree in _TOTAL_DEGREES
            if degree == 1 or len(_chebyshev_degrees(len(directions), degree)) <= max_coefficients
        ]
        cell, errors = min(cells, key=lambda pair: float(np.quantile(pair[1], _QUANTILE)))
        if errors.max() <= _TARGET_ERROR or count == len(points):
            return folds.build_table(centre, directions, [cell], errors)
        count = min(2 * count, len(points))


def _undefined_error() -> ComputationError:
    # Without a load, or without the stiffness k3 that couples x and y, groups are NaN.
    return ComputationError(
        "there is no safe μ in the ranges", "let F and k3 be above 0 in all of them"
    )


def _fit_cell(
    scaled: Floats,
    values: Floats,
    is_fit: NDArray[np.bool_],
    degree: int,
    limits: tuple[tuple[float, ...], tuple[float, ...], float, float],
) -> tuple[SafeCell, Floats]:
    # Fit a cell at coordinates scaled to -1 .. 1 within `limits`; return it and its test errors.
    degrees = _chebyshev_degrees(scaled.shape[1], degree)
    fitted, tested = ~np.isnan(values) & is_fit, ~np.isnan(values) & ~is_fit
    if np.count_nonzero(fitted) < len(degrees) or not tested.any():
        raise ComputationError(
            "limit cycles cannot be followed in a part of the ranges",
            "scatter less, or leave out safe_mu",
        )
    products = _chebyshev_products(scaled, degrees)
    coefficients = np.linalg.lstsq(products[fitted], values[fitted], rcond=None)[0]
    errors = np.abs(np.clip(products[tested] @ coefficients, *limits[2:]) - values[tested])
    return SafeCell(*limits, degree, tuple(coefficients.tolist())), errors


# Groups that are stiffnesses, whose logarithms are the coordinates.
_IS_LOGARITHMIC: Final = np.array([name.startswith("k") for name in GROUPS])


def _coordinates(groups: Floats) -> Floats:
    # The groups, with logarithms in place of stiffnesses.
    points = groups.copy()
    points[:, _IS_LOGARITHMIC] = np.log(np.maximum(points[:, _IS_LOGARITHMIC], _LEAST_STIFFNESS))
    return points


def _fit_and_test_nodes(fit_count: int, test_count: int) -> Floats:
    # Chebyshev nodes for the fit, then nodes between them for the test.
    nodes = -np.cos(np.pi * (np.arange(fit_count) + 0.5) / fit_count)
    between = -np.cos(np.pi * (np.arange(test_count) + 1.0) / (test_count + 1.0))
    return np.concatenate([nodes, between])


def _chebyshev_degrees(variable_count: int, total_degree: int) -> NDArray[np.int64]:
    # Degrees by variable, one row for each product of Chebyshev polynomials up to a total degree.
    rows = itertools.product(range(total_degree + 1), repeat=variable_count)
    return np.array([row for row in rows if sum(row) <= total_degree])


def _chebyshev_products(scaled: Floats, degrees: NDArray[np.int64]) -> Floats:
    # Values of the products at points, one row for each point.
    max_degree = int(degrees.max(initial=0))
    products = np.ones((len(scaled), len(degrees)))
    for axis in range(scaled.shape[1]):
        terms = np.polynomial.chebyshev.chebvander(scaled[:, axis], max_degree)
        products *= terms[:, degrees[:, axis]]
    return products


def _evaluate_cell(cell: SafeCell, positions: Floats) -> Floats:
    low, high = np.array(cell.low), np.array(cell.high)
    degrees = _chebyshev_degrees(len(low), cell.degree)
    scaled = 2.0 * (positions - low) / np.where(high > low, high - low, 1.0) - 1.0
    mu = np.zeros(len(scaled))
    for first in range(0, len(scaled), _BLOCK_SIZE):
        block = slice(first, first + _BLOCK_SIZE)
        # Row by row: rounding in a matrix product depends on the number of rows.
        product_rows = _chebyshev_products(scaled[block], degrees).T
        for product_row, coefficient in zip(product_rows, cell.coefficients, strict=True):
            mu[block] += coefficient * product_row
    return np.clip(mu, cell.least, cell.greatest)
