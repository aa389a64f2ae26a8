"""Folds of limit cycles over a grid of parameter sets, continued from point to point.

At a fold a stable and an unstable cycle meet at the least μ of both. The folds of neighbouring
points form sheets, of which the lowest gives safe μ.
"""

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.equilibrium import lowest_critical_mu
from fivtui.model import ComputationError, Progress, System
from fivtui.orbits import FoldOrbit, branch, fold_near, stabilising_folds

Floats = NDArray[np.float64]
# Indices along the axes of the grid.
Point = tuple[int, ...]
# Indices of the period and of μ, the last two unknowns of a fold.
_PERIOD, _MU = -2, -1

# Number of points along an axis at which branches are followed to find folds.
_BRANCH_POINTS: Final = 9
# Upper end of a branch, relative to the critical μ.
_UPPER_END: Final = 1.5
# Share of the progress that is reported for the branches.
_BRANCH_SHARE: Final = 0.2
# Relative tolerance within which two folds of a parameter set are equal.
_EQUALITY_TOLERANCE: Final = 1e-3
# A neighbour is skipped if it has a fold within this relative distance of the extrapolated one.
_NEARBY_TOLERANCE: Final = 0.01
# Upper bound of the folds of a point.
_MAX_FOLDS: Final = 8
# A failed step to a neighbour is repeated in this many smaller steps.
_SMALL_STEPS: Final = 4


@dataclass(frozen=True, slots=True, eq=False)
class _ReachedFold:
    # A fold at a point, the fold from which it was reached, and the direction of that step. A
    # direction is a unit vector of the grid: 1 or -1 along one axis, 0 along the others.
    fold: FoldOrbit
    previous: FoldOrbit | None = None
    direction: Point | None = None

    def guess(self, direction: Point) -> Floats:
        """Unknowns of the fold at the next point, extrapolated if the direction is unchanged."""
        unknowns = self.fold.unknowns
        if self.previous is None or self.direction != direction:
            return unknowns
        return 2.0 * unknowns - self.previous.unknowns


class FoldSheets:
    """The folds of limit cycles along μ at every point of a grid.

    `over` has the axes of the grid by name. `seeds` are folds known at points, given by indices.
    """

    def __init__(
        self,
        system: System,
        over: Mapping[str, Floats],
        *,
        work: Progress,
        seeds: Iterable[tuple[Point, FoldOrbit]] = (),
    ) -> None:
        self._system, self._over, self._work = system, dict(over), work
        self._shape = tuple(values.size for values in over.values())
        self._directions = [
            tuple(sign if axis == varied_axis else 0 for axis in range(len(self._shape)))
            for sign in (1, -1)
            for varied_axis in range(len(self._shape))
        ]
        self._folds: dict[Point, list[FoldOrbit]] = {}
        self._queue: deque[tuple[Point, _ReachedFold]] = deque()
        for point, fold in seeds:
            self._add_fold(point, _ReachedFold(fold))

    def lowest_folds(self) -> tuple[Floats, Floats]:
        """Least μ of the folds at every point (NaN without fold) and its half peak-to-peak, m."""
        self._follow_branches()
        point_count, fold_count = int(np.prod(self._shape)), 0
        while self._queue:
            point, reached = self._queue.popleft()
            fold_count += 1
            # The number of folds is unknown in advance: the fraction approaches one.
            fraction = fold_count / (fold_count + point_count)
            self._work.report(_BRANCH_SHARE + (1.0 - _BRANCH_SHARE) * fraction)
            for direction in self._directions:
                self._extend_to_neighbour(point, reached, direction)
        mus, half_ranges = np.full(self._shape, np.nan), np.full(self._shape, np.nan)
        for point, folds in self._folds.items():
            lowest = min(folds, key=lambda fold: fold.mu)
            mus[point], half_ranges[point] = lowest.mu, lowest.half_range
        return mus, half_ranges

    def _follow_branches(self) -> None:
        # Find folds by branches from the Hopf points at some points of the grid.
        axis_indices = [
            np.unique(
                np.linspace(0, size - 1, min(size, _BRANCH_POINTS)).round().astype(int)
            ).tolist()
            for size in self._shape
        ]
        points = list(product(*axis_indices))
        for count, point in enumerate(points):
            self._work.report(_BRANCH_SHARE * count / len(points))
            system = self._system_at(point)
            try:
                critical = lowest_critical_mu(system)
                if critical is None:
                    continue
                cycles = branch(
                    system.parameters.with_values({"mu": critical}),
                    "mu",
                    low=0.0,
                    high=_UPPER_END * critical,
                    separation=system.separation,
                )
            except ComputationError:
                continue
            for fold in stabilising_folds(cycles):
                self._add_fold(point, _ReachedFold(fold))

    def _system_at(self, indices: Sequence[float]) -> System:
        # The system at fractional indices, by linear interpolation of the axes.
        values = {}
        for (name, axis), index in zip(self._over.items(), indices, strict=True):
            below = int(index)
            share = index - below
            values[name] = float(axis[below])
            if share:
                values[name] += share * float(axis[below + 1] - axis[below])
        return self._system.with_values(values)

    def _extend_to_neighbour(self, point: Point, reached: _ReachedFold, direction: Point) -> None:
        # Continue a fold from a point to its neighbour in a direction.
        neighbour = tuple(index + change for index, change in zip(point, direction, strict=True))
        if not all(0 <= index < size for index, size in zip(neighbour, self._shape, strict=True)):
            return
        guess = reached.guess(direction)
        mu, period = float(guess[_MU]), float(guess[_PERIOD])
        expected_features = (mu, period, reached.fold.amplitude)
        if any(
            _are_close(_features(fold), expected_features, _NEARBY_TOLERANCE)
            for fold in self._folds.get(neighbour, ())
        ):
            return
        fold = fold_near(self._system_at(neighbour), reached.fold, guess)
        if fold is None:
            fold = self._follow_in_small_steps(point, reached.fold, direction)
        if fold is not None:
            self._add_fold(neighbour, _ReachedFold(fold, reached.fold, direction))

    def _follow_in_small_steps(
        self, point: Point, fold: FoldOrbit, direction: Point
    ) -> FoldOrbit | None:
        # The fold at the neighbour of a point in a direction; None if a step fails.
        previous, current = fold, fold
        for step in range(1, _SMALL_STEPS + 1):
            share = step / _SMALL_STEPS
            indices = [
                index + share * change for index, change in zip(point, direction, strict=True)
            ]
            successor = fold_near(
                self._system_at(indices), current, 2.0 * current.unknowns - previous.unknowns
            )
            if successor is None:
                return None
            previous, current = current, successor
        return current

    def _add_fold(self, point: Point, reached: _ReachedFold) -> None:
        # Add a fold to those of a point, and queue it for its neighbours, unless it is known.
        folds = self._folds.setdefault(point, [])
        features = _features(reached.fold)
        if len(folds) < _MAX_FOLDS and not any(
            _are_close(_features(fold), features, _EQUALITY_TOLERANCE) for fold in folds
        ):
            folds.append(reached.fold)
            self._queue.append((point, reached))


def _features(fold: FoldOrbit) -> tuple[float, float, float]:
    # μ, period and amplitude.
    return fold.mu, float(fold.unknowns[_PERIOD]), fold.amplitude


def _are_close(first: tuple[float, ...], second: tuple[float, ...], tol: float) -> bool:
    return all(abs(a - b) <= tol * max(abs(a), abs(b)) for a, b in zip(first, second, strict=True))
