"""Folds of limit cycles over a grid of parameter sets, each found from that of a neighbour."""

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.equilibrium import lowest_critical_mu
from fivtui.model import ComputationError, Progress, System
from fivtui.orbits import FoldOrbit, branch, fold_near, folds_of

Floats = NDArray[np.float64]
Place = tuple[int, ...]

# Values of an axis at which whole branches are followed, to find the folds there are.
_ANCHORS: Final = 9
# Branches are followed up to this many times the critical μ.
_REACH: Final = 1.5
_SHARE_OF_ANCHORS: Final = 0.2
# Folds of one parameter set whose μ and amplitude differ by less than these parts are the same, and
# one that is guessed so near to a known one is not looked for.
_SAME: Final = 1e-3
_NEAR: Final = 0.01
_MOST_FOLDS: Final = 8
# A step to the next point that fails is made in this many parts.
_PARTS: Final = 4


@dataclass(frozen=True, slots=True, eq=False)
class _Reached:
    # A fold at a point, and whence in which direction it was found.
    fold: FoldOrbit
    before: FoldOrbit | None = None
    direction: Place | None = None

    def guess(self, direction: Place) -> Floats:
        """Unknowns at the next point in a direction: extrapolated along a straight way."""
        here = self.fold.unknowns
        if self.before is None or self.direction != direction:
            return here
        return 2.0 * here - self.before.unknowns


class FoldSheets:
    """The folds of limit cycles along μ at every point of a grid."""

    def __init__(
        self,
        system: System,
        over: Mapping[str, Floats],
        *,
        work: Progress,
        seeds: Iterable[tuple[Place, FoldOrbit]] = (),
    ) -> None:
        self._system, self._over, self._work = system, dict(over), work
        self._shape = tuple(values.size for values in over.values())
        self._directions = [
            tuple(sign if axis == one else 0 for axis in range(len(self._shape)))
            for sign in (1, -1)
            for one in range(len(self._shape))
        ]
        self._found: dict[Place, list[FoldOrbit]] = {}
        self._waiting: deque[tuple[Place, _Reached]] = deque()
        for place, fold in seeds:
            self._add(place, _Reached(fold))

    def least(self) -> tuple[Floats, Floats]:
        """The least μ of a fold at every point, NaN without one, and its half peak-to-peak, m."""
        self._anchor()
        total, done = int(np.prod(self._shape)), 0
        while self._waiting:
            place, reached = self._waiting.popleft()
            done += 1
            # How many folds a point has is not known before.
            self._work.report(_SHARE_OF_ANCHORS + (1.0 - _SHARE_OF_ANCHORS) * done / (done + total))
            for direction in self._directions:
                self._step(place, reached, direction)
        mu, sizes = np.full(self._shape, np.nan), np.full(self._shape, np.nan)
        for place, folds in self._found.items():
            first = min(folds, key=lambda fold: fold.mu)
            mu[place], sizes[place] = first.mu, first.half_range
        return mu, sizes

    def _anchor(self) -> None:
        # Branches from the Hopf points at a few points of the grid.
        chosen = [
            np.unique(np.linspace(0, size - 1, min(size, _ANCHORS)).round().astype(int)).tolist()
            for size in self._shape
        ]
        places = list(product(*chosen))
        for count, place in enumerate(places):
            self._work.report(_SHARE_OF_ANCHORS * count / len(places))
            system = self._set(place)
            critical = lowest_critical_mu(system)
            if critical is None:
                continue
            at = system.parameters.with_values({"mu": critical})
            try:
                found = branch(
                    at, "mu", low=0.0, high=_REACH * critical, separation=system.separation
                )
            except ComputationError:
                continue
            for fold in folds_of(found):
                self._add(place, _Reached(fold))

    def _set(self, at: Sequence[float]) -> System:
        # The system at a place that may be between two points.
        values = {}
        for (name, axis), index in zip(self._over.items(), at, strict=True):
            below = int(index)
            share = index - below
            values[name] = float(axis[below])
            if share:
                values[name] += share * float(axis[below + 1] - axis[below])
        return self._system.with_values(values)

    def _step(self, place: Place, reached: _Reached, direction: Place) -> None:
        there = tuple(index + change for index, change in zip(place, direction, strict=True))
        if not all(0 <= index < size for index, size in zip(there, self._shape, strict=True)):
            return
        guess = reached.guess(direction)
        expected = (float(guess[-1]), float(guess[-2]), reached.fold.amplitude)
        if any(_alike(_features(fold), expected, _NEAR) for fold in self._found.get(there, ())):
            return
        before, fold = reached.fold, fold_near(self._set(there), reached.fold, guess)
        if fold is None:
            before, fold = self._in_parts(place, reached.fold, direction)
        if fold is not None:
            self._add(there, _Reached(fold, before, direction))

    def _in_parts(
        self, place: Place, fold: FoldOrbit, direction: Place
    ) -> tuple[FoldOrbit, FoldOrbit | None]:
        # The last fold on the way from a point to the next and the one there, if it is reached.
        before, here = fold, fold
        for part in range(1, _PARTS + 1):
            share = part / _PARTS
            middle = [index + share * way for index, way in zip(place, direction, strict=True)]
            found = fold_near(self._set(middle), here, 2.0 * here.unknowns - before.unknowns)
            if found is None:
                return here, None
            before, here = here, found
        # What is extrapolated from is a whole step back.
        return fold, here

    def _add(self, place: Place, reached: _Reached) -> None:
        folds = self._found.setdefault(place, [])
        features = _features(reached.fold)
        if len(folds) < _MOST_FOLDS and not any(
            _alike(_features(fold), features, _SAME) for fold in folds
        ):
            folds.append(reached.fold)
            self._waiting.append((place, reached))


def _features(fold: FoldOrbit) -> tuple[float, float, float]:
    return fold.mu, float(fold.unknowns[-2]), fold.amplitude


def _alike(one: tuple[float, ...], other: tuple[float, ...], part: float) -> bool:
    return all(abs(a - b) <= part * max(abs(a), abs(b)) for a, b in zip(one, other, strict=True))
