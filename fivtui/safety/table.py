"""Safe μ of many parameter sets: continued for each, or by polynomials fitted to folds.

Where one group varies, its range is split into cells until the error that is measured at folds that
no polynomial was fitted to is small enough, or there are too many folds. Where several do, one
polynomial is fitted to folds at draws of the parameters, so that it is best where these are likely.
"""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

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

# Folds of a table at most.
MOST_FOLDS: Final = 512
# Error of μ at which no more folds are continued.
_WANTED: Final = 2e-5
# Bounds of safe μ along one group.
_BOUNDS: Final = (0.0, PARAMETERS["mu"].upper)
# Degree in a cell, folds that it is fitted to, and that it is tried at.
_DEGREE: Final = 8
_FITTED: Final = 14
_TRIED: Final = 6
# Total degrees over several groups; coefficients are at most this part of the folds fitted to.
_DEGREES: Final = range(1, 7)
_FILLED: Final = 0.5
# How far draws and their safe μ may be beyond those fitted to, over the range of these.
_BEYOND: Final = 0.25
# One fold in so many is not fitted to, but tried. The first tables have this number of folds.
_TRY_EVERY: Final = 3
_FIRST: Final = 128
# The part of the errors by which the degree is chosen.
_MOST: Final = 0.95
# Groups whose spread is this part of the widest one do not vary on their own.
_FLAT: Final = 1e-6
_LEAST_CUBIC: Final = 1e-9
_BLOCK: Final = 1 << 16


@dataclass(frozen=True, slots=True)
class SafeCell:
    """A box of a table with its polynomial.

    Attributes
    ----------
    low, high : tuple of float
        Its corners.
    least, greatest : float
        Between these safe μ is, also where the polynomial is not.
    degree : int
        Total degree.
    coefficients : tuple of float
        Those of the products of Chebyshev polynomials.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    least: float
    greatest: float
    degree: int
    coefficients: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class SafeTable:
    """Safe μ over the groups that vary.

    Attributes
    ----------
    names : tuple of str
        The groups that vary, see `GROUPS`; stiffnesses by their logarithms.
    separation : bool
        Whether separation is considered.
    centre : tuple of float
        Origin of the coordinates of the cells.
    directions : tuple of tuple of float
        For each coordinate, what of it a group has.
    cells : tuple of SafeCell
        The boxes.
    folds : int
        Number of folds that were continued.
    errors : tuple of float
        Errors of μ at those that no polynomial was fitted to, ascending.
    """

    names: tuple[str, ...]
    separation: bool
    centre: tuple[float, ...]
    directions: tuple[tuple[float, ...], ...]
    cells: tuple[SafeCell, ...]
    folds: int
    errors: tuple[float, ...]

    @property
    def error(self) -> float:
        """The greatest error."""
        return self.errors[-1]

    @property
    def usual_error(self) -> float:
        """The error that 95 % of the folds tried are within."""
        return float(np.quantile(self.errors, _MOST))

    def at(self, groups: Floats) -> Floats:
        """Safe μ at groups, shape (n, 5), moved into the boxes; NaN where groups are."""
        x = _coordinates(groups)[:, [GROUPS.index(name) for name in self.names]]
        x = x - np.array(self.centre)
        # Sums of a few products, one by one: those of a matrix product depend on how many rows.
        z = np.stack(
            [sum(x[:, k] * each for k, each in enumerate(row)) for row in self.directions], axis=1
        )
        known = ~np.isnan(z).any(axis=1)
        low = np.min([cell.low for cell in self.cells], axis=0)
        high = np.max([cell.high for cell in self.cells], axis=0)
        inside = np.clip(z, low, high)
        found = np.full(len(z), np.nan)
        for cell in self.cells:
            begin, end = np.array(cell.low), np.array(cell.high)
            # What is on a common face belongs to the last cell: both agree within the error.
            here = known & (inside >= begin).all(axis=1) & (inside <= end).all(axis=1)
            if here.any():
                found[here] = _evaluated(cell, inside[here])
        return found

    def to_dict(self) -> dict[str, Any]:
        """As data for JSON."""
        return {
            "groups": list(self.names),
            "separation": self.separation,
            "centre": list(self.centre),
            "directions": [list(row) for row in self.directions],
            "folds": self.folds,
            "errors": list(self.errors),
            "cells": [
                [
                    list(cell.low),
                    list(cell.high),
                    cell.least,
                    cell.greatest,
                    cell.degree,
                    list(cell.coefficients),
                ]
                for cell in self.cells
            ],
        }

    @classmethod
    def from_dict(cls, data: Any) -> "SafeTable":
        """The table in data of `to_dict`."""
        return cls(
            tuple(map(str, data["groups"])),
            bool(data["separation"]),
            _tuple(data["centre"]),
            tuple(map(_tuple, data["directions"])),
            tuple(
                SafeCell(
                    _tuple(low), _tuple(high), float(least), float(greatest), int(degree), _tuple(c)
                )
                for low, high, least, greatest, degree, c in data["cells"]
            ),
            int(data["folds"]),
            _tuple(data["errors"]),
        )


def _tuple(values: Any) -> tuple[float, ...]:
    return tuple(map(float, values))


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
    different, place = np.unique(np.column_stack([groups, separation]), axis=0, return_inverse=True)
    found, work = np.full(len(different), np.nan), Progress(progress)
    for row, (*group, considered) in enumerate(different.tolist()):
        work.report(row / len(different))
        if group[0] == group[0]:
            found[row] = least_of(tuple(group), separation=bool(considered))
    return found[place.ravel()]


def safe_table(
    system: System,
    ranges: Mapping[str, tuple[float, float]],
    draws: Mapping[str, Floats],
    *,
    progress: OnProgress | None = None,
) -> SafeTable | None:
    """A table of safe μ where parameters vary; None if nothing but μ does."""
    names = tuple(name for name in GROUPS if set(MADE_OF[name]) & ranges.keys())
    if not names:
        return None
    p, folds = system.parameters, _Folds(names, progress, separation=system.separation)
    if len(names) == 1:
        return _over_one(p, ranges, folds)
    return _over_several(p, draws, folds)


class _Folds:
    # Continues folds, and counts them.

    def __init__(
        self, names: tuple[str, ...], progress: OnProgress | None, *, separation: bool
    ) -> None:
        self.names, self.separation = names, separation
        self.places = [GROUPS.index(name) for name in names]
        self.count = 0
        self._work = Progress(progress)

    def at(self, coordinates: Floats) -> float:
        self._work.report(self.count / MOST_FOLDS)
        self.count += 1
        return least_of(tuple(_groups(coordinates).tolist()), separation=self.separation)


def _over_one(p: Parameters, ranges: Mapping[str, tuple[float, float]], folds: _Folds) -> SafeTable:
    # Cells along the one group that varies; the worst is split next.
    corners = np.array(list(itertools.product(*ranges.values())))
    varied = dict(zip(ranges, corners.T, strict=True))
    if "F" in varied:
        # Without preload there is no safe μ.
        least = varied["F"].max(initial=0.0) * np.sqrt(_LEAST_CUBIC)
        varied["F"] = np.maximum(varied["F"], least)
    x = _coordinates(groups_of(p, varied, len(corners)))
    _check_any(np.isfinite(x).all(axis=1))
    (place,) = folds.places
    unit = _nodes(_FITTED, _TRIED)

    def cell(low: float, high: float) -> tuple[SafeCell, Floats]:
        nodes = np.repeat(x[:1], len(unit), axis=0)
        nodes[:, place] = low + (high - low) * 0.5 * (unit + 1.0)
        values = np.array([folds.at(node) for node in nodes])
        fits = np.arange(len(unit)) < _FITTED
        return _fitted(unit[:, None], values, fits, _DEGREE, ((low,), (high,), *_BOUNDS))

    cells = [cell(float(x[:, place].min()), float(x[:, place].max()))]
    while folds.count + 2 * len(unit) <= MOST_FOLDS:
        worst = max(range(len(cells)), key=lambda n: cells[n][1].max())
        found, errors = cells[worst]
        if errors.max() <= _WANTED:
            break
        (low,), (high,) = found.low, found.high
        middle = 0.5 * (low + high)
        cells[worst : worst + 1] = [cell(low, middle), cell(middle, high)]
    errors = np.sort(np.concatenate([each for _, each in cells]))
    return SafeTable(
        folds.names,
        folds.separation,
        (0.0,),
        ((1.0,),),
        tuple(found for found, _ in cells),
        folds.count,
        tuple(errors.tolist()),
    )


def _over_several(p: Parameters, draws: Mapping[str, Floats], folds: _Folds) -> SafeTable:
    # One polynomial in the directions in which the groups vary on their own.
    size = next(iter(draws.values())).size
    x = _coordinates(groups_of(p, draws, size))
    x = x[~np.isnan(x).any(axis=1)][:MOST_FOLDS]
    _check_any(np.ones(len(x), dtype=bool))
    here = x[:, folds.places]
    centre = here.mean(axis=0)
    _, spreads, rows = np.linalg.svd(here - centre, full_matrices=False)
    rows = rows[spreads > _FLAT * spreads[0]]
    z = (here - centre) @ rows.T
    beyond = _BEYOND * np.ptp(z, axis=0)
    low, high = z.min(axis=0) - beyond, z.max(axis=0) + beyond
    unit = 2.0 * (z - low) / (high - low) - 1.0
    corners = (tuple(low.tolist()), tuple(high.tolist()))
    values = np.zeros(0)
    count = min(_FIRST, len(x))
    while True:
        values = np.append(values, [folds.at(node) for node in x[len(values) : count]])
        fits = np.arange(count) % _TRY_EVERY > 0
        room = _FILLED * np.count_nonzero(fits)
        # Where there is no draw near, a polynomial may be anything.
        least, greatest = float(np.nanmin(values[fits])), float(np.nanmax(values[fits]))
        more = _BEYOND * (greatest - least)
        box = (*corners, least - more, greatest + more)
        fitted = [
            _fitted(unit[:count], values, fits, degree, box)
            for degree in _DEGREES
            if degree == 1 or len(_exponents(len(rows), degree)) <= room
        ]
        cell, errors = min(fitted, key=lambda each: float(np.quantile(each[1], _MOST)))
        if errors.max() <= _WANTED or count == len(x):
            break
        count = min(2 * count, len(x))
    return SafeTable(
        folds.names,
        folds.separation,
        tuple(centre.tolist()),
        tuple(map(_tuple, rows.tolist())),
        (cell,),
        folds.count,
        tuple(np.sort(errors).tolist()),
    )


def _check_any(known: Any) -> None:
    if not known.any() or not known.all():
        raise ComputationError(
            "there is no safe μ in the ranges", "let F and k3 be above 0 in all of them"
        )


def _fitted(
    unit: Floats,
    values: Floats,
    fits: NDArray[np.bool_],
    degree: int,
    box: tuple[tuple[float, ...], tuple[float, ...], float, float],
) -> tuple[SafeCell, Floats]:
    # A cell, and its errors at the folds that it was not fitted to.
    exponents = _exponents(unit.shape[1], degree)
    known = ~np.isnan(values)
    if np.count_nonzero(known & fits) < len(exponents) or not (known & ~fits).any():
        raise ComputationError(
            "limit cycles cannot be followed in a part of the ranges",
            "scatter less, or leave out safe_mu",
        )
    basis = _basis(unit, exponents)
    use, test = known & fits, known & ~fits
    coefficients = np.linalg.lstsq(basis[use], values[use], rcond=None)[0]
    errors = np.abs(np.clip(basis[test] @ coefficients, *box[2:]) - values[test])
    return SafeCell(*box, degree, tuple(coefficients.tolist())), errors


# Groups that are ratios of stiffnesses vary by factors.
_LOG: Final = np.array([name.startswith("k") for name in GROUPS])


def _coordinates(groups: Floats) -> Floats:
    x = groups.copy()
    x[:, _LOG] = np.log(np.maximum(x[:, _LOG], _LEAST_CUBIC))
    return x


def _groups(coordinates: Floats) -> Floats:
    found = coordinates.copy()
    found[_LOG] = np.exp(found[_LOG])
    # A damping of 0 that rounding makes negative.
    return np.maximum(found, 0.0)


def _nodes(fitted: int, tried: int) -> Floats:
    # From -1 to 1: Chebyshev's nodes, then others.
    nodes = -np.cos(np.pi * (np.arange(fitted) + 0.5) / fitted)
    between = -np.cos(np.pi * (np.arange(tried) + 1.0) / (tried + 1.0))
    return np.concatenate([nodes, between])


def _exponents(size: int, degree: int) -> NDArray[np.int64]:
    powers = itertools.product(range(degree + 1), repeat=size)
    return np.array([each for each in powers if sum(each) <= degree])


def _basis(x: Floats, exponents: NDArray[np.int64]) -> Floats:
    degree = int(exponents.max(initial=0))
    found = np.ones((len(x), len(exponents)))
    for axis in range(x.shape[1]):
        terms = np.polynomial.chebyshev.chebvander(x[:, axis], degree)
        found *= terms[:, exponents[:, axis]]
    return found


def _evaluated(cell: SafeCell, z: Floats) -> Floats:
    low, high = np.array(cell.low), np.array(cell.high)
    exponents = _exponents(len(low), cell.degree)
    unit = 2.0 * (z - low) / np.where(high > low, high - low, 1.0) - 1.0
    found = np.zeros(len(unit))
    for first in range(0, len(unit), _BLOCK):
        some = slice(first, first + _BLOCK)
        # Term by term, for the same reason as above.
        terms = _basis(unit[some], exponents).T
        for term, coefficient in zip(terms, cell.coefficients, strict=True):
            found[some] += coefficient * term
    return np.clip(found, cell.least, cell.greatest)
