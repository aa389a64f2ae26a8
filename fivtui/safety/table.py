"""Safe μ of many parameter sets: continued for each, or by polynomials fitted to folds.

The polynomials are of the groups that vary, in cells that are split until the error that is
measured at folds that the fit has not seen is small enough, or there are too many folds.
"""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.equilibrium import critical_mus
from fivtui.model import Cancelled, ComputationError, Parameters
from fivtui.transient import Progress

from .least import GROUPS, MADE_OF, groups_of, least_of

Floats = NDArray[np.float64]

# Folds of a table, beyond which no cell is split.
MOST_FOLDS: Final = 600
# Error of μ at which cells are not split.
_WANTED: Final = 2e-5
# Total degree of the polynomials, by the number of groups that vary.
_DEGREES: Final = (0, 8, 6, 4, 3, 3)
# Folds that a polynomial is fitted to, and that it is tried at, over its coefficients.
_FITTED: Final = 1.5
_TRIED: Final = 0.75
_FEWEST_TRIED: Final = 5
_LEAST_CUBIC: Final = 1e-9
_BLOCK: Final = 1 << 16


@dataclass(frozen=True, slots=True)
class SafeCell:
    """A box of a table: its corners, and the coefficients of its Chebyshev polynomials."""

    low: tuple[float, ...]
    high: tuple[float, ...]
    coefficients: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class SafeTable:
    """Safe μ over the groups that vary.

    Attributes
    ----------
    names : tuple of str
        The groups that vary, see `GROUPS`; the last one, k_nl F²/k1³, by its logarithm.
    separation : bool
        Whether separation is considered.
    cells : tuple of SafeCell
        The boxes.
    folds : int
        Number of folds that were continued.
    error : float
        Greatest error of μ at those that no polynomial was fitted to.
    """

    names: tuple[str, ...]
    separation: bool
    cells: tuple[SafeCell, ...]
    folds: int
    error: float

    def at(self, groups: Floats) -> Floats:
        """Safe μ at groups, shape (n, 5), clipped to the boxes; NaN where groups are."""
        x = _coordinates(groups)[:, [GROUPS.index(name) for name in self.names]]
        known = ~np.isnan(x).any(axis=1)
        low = np.min([cell.low for cell in self.cells], axis=0)
        high = np.max([cell.high for cell in self.cells], axis=0)
        inside = np.clip(x, low, high)
        found = np.full(len(x), np.nan)
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
            "folds": self.folds,
            "error": self.error,
            "cells": [
                [list(cell.low), list(cell.high), list(cell.coefficients)] for cell in self.cells
            ],
        }

    @classmethod
    def from_dict(cls, data: Any) -> "SafeTable":
        """The table in data of `to_dict`."""
        return cls(
            tuple(map(str, data["groups"])),
            bool(data["separation"]),
            tuple(SafeCell(*(tuple(map(float, part)) for part in cell)) for cell in data["cells"]),
            int(data["folds"]),
            float(data["error"]),
        )


def safe_mus(
    p: Parameters,
    varied: Mapping[str, Floats],
    separation: NDArray[np.bool_],
    table: SafeTable | None = None,
    progress: Progress | None = None,
) -> Floats:
    """Safe μ of n parameter sets by continuation from the Hopf point, shape (n,).

    Parameters
    ----------
    p : Parameters
        The parameters that do not vary.
    varied : mapping of str to ndarray, shape (n,)
        The others, by name; μ is not used.
    separation : ndarray of bool, shape (n,)
        Whether separation is considered.
    table : SafeTable, optional
        Where safe μ is taken from; without, every set that differs is continued.
    progress : callable, optional
        Called with the fraction done; cancels the work by returning False.

    Returns
    -------
    ndarray
        The least of the critical μ and of those at which a limit cycle of the branch that begins
        there attracts; NaN where there is no critical μ.

    Raises
    ------
    Cancelled
        If `progress` returned False.
    """
    groups = groups_of(p, varied, separation.size)
    if table is not None:
        critical = critical_mus(p, varied, separation)
        return np.where(np.isnan(critical), np.nan, np.minimum(table.at(groups), critical))
    different, place = np.unique(np.column_stack([groups, separation]), axis=0, return_inverse=True)
    found = np.full(len(different), np.nan)
    for row, (*group, considered) in enumerate(different.tolist()):
        if progress is not None and not progress(row / len(different)):
            raise Cancelled
        if group[0] == group[0]:
            found[row] = least_of(tuple(group), separation=bool(considered))
    return found[place.ravel()]


def safe_table(
    p: Parameters,
    ranges: Mapping[str, tuple[float, float]],
    *,
    separation: bool,
    progress: Progress | None = None,
) -> SafeTable | None:
    """A table of safe μ over ranges of parameters; None where nothing but μ varies.

    Parameters
    ----------
    p : Parameters
        The parameters that do not vary.
    ranges : mapping of str to (float, float)
        Least and greatest value of the others.
    separation : bool
        Whether separation is considered.
    progress : callable, optional
        Called with a fraction of the greatest number of folds; cancels by returning False.

    Raises
    ------
    ComputationError
        If folds cannot be continued in the ranges.
    Cancelled
        If `progress` returned False.
    """
    names = tuple(name for name in GROUPS if set(MADE_OF[name]) & ranges.keys())
    if not names:
        return None
    return _Builder(p, ranges, names, progress, separation=separation).result()


class _Builder:
    # A table under way: cells with their errors, the worst of which is split next.

    def __init__(
        self,
        p: Parameters,
        ranges: Mapping[str, tuple[float, float]],
        names: tuple[str, ...],
        progress: Progress | None,
        *,
        separation: bool,
    ) -> None:
        self._separation, self._progress = separation, progress
        self._names, self._places = names, [GROUPS.index(name) for name in names]
        corners = np.array(list(itertools.product(*ranges.values())))
        varied = dict(zip(ranges, corners.T, strict=True))
        if "F" in varied:
            # Without preload there is no safe μ.
            least = varied["F"][varied["F"] > 0.0].max(initial=0.0) * np.sqrt(_LEAST_CUBIC)
            varied["F"] = np.maximum(varied["F"], least)
        x = _coordinates(groups_of(p, varied, len(corners)))
        if np.isnan(x).any():
            raise ComputationError(
                "there is no safe μ in the ranges", "let F and k3 be above 0 in all of them"
            )
        self._fixed = x[0]
        self._low, self._high = (end(x[:, self._places], axis=0) for end in (np.min, np.max))
        self._exponents = _exponents(len(names))
        self._folds = 0

    def result(self) -> SafeTable:
        cells = [self._cell(self._low, self._high)]
        while self._folds + self._cost < MOST_FOLDS:
            worst = max(range(len(cells)), key=lambda place: cells[place][1])
            cell, error, axis = cells[worst]
            if error <= _WANTED:
                break
            low, high = np.array(cell.low), np.array(cell.high)
            middle_high, middle_low = high.copy(), low.copy()
            middle_high[axis] = middle_low[axis] = 0.5 * (low[axis] + high[axis])
            cells[worst : worst + 1] = [
                self._cell(low, middle_high), self._cell(middle_low, high)
            ]  # fmt: skip
        return SafeTable(
            self._names,
            self._separation,
            tuple(cell for cell, _, _ in cells),
            self._folds,
            max(error for _, error, _ in cells),
        )

    @property
    def _cost(self) -> int:
        fitted, tried = self._counts()
        return 2 * (fitted + tried)

    def _counts(self) -> tuple[int, int]:
        count = len(self._exponents)
        return int(np.ceil(_FITTED * count)), max(int(_TRIED * count), _FEWEST_TRIED)

    def _cell(self, low: Floats, high: Floats) -> tuple[SafeCell, float, int]:
        # A cell, its error, and the axis along which it is to be split.
        fitted, tried = self._counts()
        unit = _points(fitted + tried, len(self._names))
        values = np.array([self._fold(low + (high - low) * 0.5 * (x + 1.0)) for x in unit])
        known = ~np.isnan(values)
        fits = np.arange(len(values)) < fitted
        if np.count_nonzero(known & fits) < len(self._exponents):
            raise ComputationError(
                "limit cycles cannot be followed in a part of the ranges",
                "scatter less, or leave out safe_mu",
            )
        basis = _basis(unit, self._exponents)
        use = known & fits
        coefficients = np.linalg.lstsq(basis[use], values[use], rcond=None)[0]
        test = known & ~fits
        error = np.abs(basis[test] @ coefficients - values[test]).max(initial=0.0)
        # The highest degrees say along which axis the polynomial lacks most.
        top = self._exponents.sum(axis=1) >= self._exponents.sum(axis=1).max() - 1
        weight = (np.abs(coefficients[top, None]) * self._exponents[top]).sum(axis=0)
        cell = SafeCell(tuple(low.tolist()), tuple(high.tolist()), tuple(coefficients.tolist()))
        return cell, float(error), int(weight.argmax())

    def _fold(self, x: Floats) -> float:
        if self._progress is not None and not self._progress(self._folds / MOST_FOLDS):
            raise Cancelled
        self._folds += 1
        coordinates = self._fixed.copy()
        coordinates[self._places] = x
        *others, cubic = coordinates.tolist()
        return least_of((*others, float(np.exp(cubic))), separation=self._separation)


def _coordinates(groups: Floats) -> Floats:
    x = groups.copy()
    x[:, -1] = np.log(np.maximum(x[:, -1], _LEAST_CUBIC))
    return x


def _exponents(count: int) -> NDArray[np.int64]:
    degree = _DEGREES[count]
    powers = itertools.product(range(degree + 1), repeat=count)
    return np.array([each for each in powers if sum(each) <= degree])


def _points(count: int, size: int) -> Floats:
    # Points in the cube from -1 to 1, the denser the nearer to its faces; always the same.
    from scipy.stats import qmc

    if size == 1:
        first = int(np.ceil(count * _FITTED / (_FITTED + _TRIED)))
        nodes = -np.cos(np.pi * (np.arange(first) + 0.5) / first)
        between = -np.cos(np.pi * (np.arange(count - first) + 1.0) / (count - first + 1.0))
        return np.concatenate([nodes, between])[:, None]
    shares = qmc.Sobol(size, scramble=True, rng=0).random(1 << (count - 1).bit_length())[:count]
    points: Floats = -np.cos(np.pi * shares)
    return points


def _basis(x: Floats, exponents: NDArray[np.int64]) -> Floats:
    degree = int(exponents.max(initial=0))
    found = np.ones((len(x), len(exponents)))
    for axis in range(x.shape[1]):
        terms = np.polynomial.chebyshev.chebvander(x[:, axis], degree)
        found *= terms[:, exponents[:, axis]]
    return found


def _evaluated(cell: SafeCell, x: Floats) -> Floats:
    low, high = np.array(cell.low), np.array(cell.high)
    exponents, coefficients = _exponents(len(low)), np.array(cell.coefficients)
    unit = 2.0 * (x - low) / np.where(high > low, high - low, 1.0) - 1.0
    found = np.zeros(len(unit))
    for first in range(0, len(unit), _BLOCK):
        some = slice(first, first + _BLOCK)
        # Term by term: the order of a matrix product's sums depends on how many rows there are.
        for term, coefficient in zip(_basis(unit[some], exponents).T, coefficients, strict=True):
            found[some] += coefficient * term
    return found
