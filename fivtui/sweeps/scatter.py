"""Scattered designs: points that follow distributions, in independent scramblings."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from fivtui.distributions import Distribution
from fivtui.model import InputError, check_known

from .design import MAX_MEMBERS, SOBOL_BITS, VARIABLES, Design, sobol_directions, sobol_points

Floats = NDArray[np.float64]
ScatterKind = Literal["sobol", "lhs"]
Correlations = tuple[tuple[str, str, float], ...]

SCATTERS: Final[Mapping[str, str]] = {
    "sobol": "points of scrambled Sobol sequences",
    "lhs": "Latin hypercubes",
}
MOST_POINTS: Final = 2**24
_LEAST_REPEATS: Final = 2
_MOST_REPEATS: Final = 256
# Number of hypercubes in the cache.
_CACHED_HYPERCUBES: Final = 128
# Offset to the middle of a cell of a Sobol sequence, since a share of 0 has no quantile.
_HALF: Final = 2.0 ** -(SOBOL_BITS + 1)
_LEAST_SHARE: Final = 2.0**-54


@dataclass(frozen=True, slots=True)
class Scatter:
    """Points that follow distributions.

    Estimates of different scramblings are independent, and their spread gives the error. For Sobol
    indices each point is a pair of points A and B, and for every name a mixed point: A with the
    value of B for that name (Saltelli 2010).

    Members are ordered by point, then scrambling, then A, B and the mixed points. With Sobol
    sequences, the members of a design are the first members of every larger design.

    Parameters
    ----------
    axes : mapping of str to Distribution
        Distributions by name: parameters, and ``x0``, ``vx0``, ``y0``, ``vy0`` of the start. They
        are truncated at the bounds of the parameters.
    kind : "sobol" or "lhs"
        Scrambled Sobol sequences, or Latin hypercubes.
    count : int
        Number of points of each scrambling, a power of two.
    seed : int
        Seed of the first scrambling; those of the others follow.
    repeats : int
        Number of scramblings, 2 to 256.
    indices : bool
        Whether the design is one for Sobol indices.
    correlations : tuple of (str, str, float)
        Correlations of the normal scores of two names (a Gaussian copula); others are 0.

    Attributes
    ----------
    size : int
        Number of members.

    Raises
    ------
    InputError
        If a name is unknown, a number is out of range, or correlations are impossible, or given
        with `indices`.
    """

    axes: Mapping[str, Distribution]
    kind: ScatterKind = "sobol"
    count: int = 1024
    seed: int = 0
    repeats: int = 16
    indices: bool = True
    correlations: Correlations = ()
    size: int = field(init=False)

    def __post_init__(self) -> None:
        check_known("design", self.kind, SCATTERS)
        if not self.axes:
            raise InputError("nothing is scattered; at least one name must be")
        object.__setattr__(
            self,
            "axes",
            {name: _bounded(name, distribution) for name, distribution in self.axes.items()},
        )
        if not 1 <= self.count <= MOST_POINTS or self.count & (self.count - 1):
            raise InputError(f"count = {self.count}: must be a power of two, at most {MOST_POINTS}")
        if not _LEAST_REPEATS <= self.repeats <= _MOST_REPEATS:
            raise InputError(
                f"repeats = {self.repeats}: must be from {_LEAST_REPEATS} to {_MOST_REPEATS}"
            )
        if not 0 <= self.seed < MAX_MEMBERS:
            raise InputError(f"seed = {self.seed}: must be from 0 to {MAX_MEMBERS - 1}")
        if self.correlations and self.indices:
            raise InputError(
                "Sobol indices: the inputs must be independent, but "
                + ", ".join(f"{first} and {second}" for first, second, _ in self.correlations)
                + " are correlated; ask for none (--no-indices)"
            )
        _triangle(tuple(self.axes), self.correlations)
        object.__setattr__(self, "size", self.count * self.repeats * self.blocks)

    @property
    def blocks(self) -> int:
        """Members of each point: 1, or for Sobol indices 2 and one for every name."""
        return len(self.axes) + 2 if self.indices else 1

    @property
    def seeds(self) -> list[int]:
        """The seeds of the scramblings."""
        return [self.seed + offset for offset in range(self.repeats)]

    @property
    def samples(self) -> int:
        """Number of members that follow the distributions."""
        return self.count * self.repeats * min(self.blocks, 2)

    def samples_of(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values of the samples among values of the first or all members, a row per scrambling.

        Points that are not complete in every scrambling are left out.
        """
        parts = self.parts_of(values)[:, :, : min(self.blocks, 2)]
        return parts.transpose(1, 0, 2).reshape(self.repeats, -1)

    def parts_of(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values by point, scrambling, and A, B or mixed point, shape (n, repeats, blocks)."""
        points = values.size // (self.repeats * self.blocks)
        complete = values[: points * self.repeats * self.blocks]
        return complete.reshape(points, self.repeats, self.blocks)

    def columns(self, indices: NDArray[np.int64]) -> dict[str, Floats]:
        """Values by name at ascending indices without gaps, shape (n,) each."""
        row = self.repeats * self.blocks
        first, stop = int(indices[0]) // row, int(indices[-1]) // row + 1
        shares = self._shares(first, stop)[indices - first * row]
        triangle = _triangle(tuple(self.axes), self.correlations)
        if triangle is not None:
            from scipy.special import ndtr, ndtri

            shares = ndtr(ndtri(shares) @ triangle.T)
        values = {}
        for (name, axis), share in zip(self.axes.items(), shares.T, strict=True):
            values[name] = np.maximum(axis.at(share), VARIABLES[name].lower)
        return values

    def _shares(self, first: int, stop: int) -> Floats:
        # Shares of all members of the points from `first` to `stop` - 1, a row each.
        size = len(self.axes)
        shares = np.empty((stop - first, self.repeats, self.blocks, size))
        for index, seed in enumerate(self.seeds):
            points = self._points(seed, first, stop)
            shares[:, index, : min(self.blocks, 2)] = points.reshape(stop - first, -1, size)
        for index in range(self.blocks - 2):
            shares[:, :, index + 2] = shares[:, :, 0]
            shares[:, :, index + 2, index] = shares[:, :, 1, index]
        return shares.reshape(-1, size)

    def _points(self, seed: int, first: int, stop: int) -> Floats:
        size = len(self.axes) * min(self.blocks, 2)
        if self.kind == "sobol":
            directions = sobol_directions(size, seed, (self.count - 1).bit_length())
            return sobol_points(directions, first, stop) + _HALF
        return _hypercube(size, self.count, seed)[first:stop]


StudyDesign = Design | Scatter


def _bounded(name: str, axis: object) -> Distribution:
    check_known("name", name, VARIABLES)
    if not isinstance(axis, Distribution):
        raise InputError(f"{name} = {axis!r}: must be a distribution, such as normal:80:8")
    spec = VARIABLES[name]
    try:
        return axis.within(spec.lower, spec.upper)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


@lru_cache(maxsize=_CACHED_HYPERCUBES)
def _hypercube(size: int, count: int, seed: int) -> Floats:
    from scipy.stats import qmc

    points: Floats = qmc.LatinHypercube(size, rng=seed).random(count)
    return np.maximum(points, _LEAST_SHARE)


@lru_cache(maxsize=8)
def _triangle(names: tuple[str, ...], correlations: Correlations) -> Floats | None:
    # Cholesky's factor of the correlations of the normal scores; None if there are none.
    matrix = np.eye(len(names))
    for first, second, value in correlations:
        for name in (first, second):
            check_known("correlated name", name, names)
        if first == second or not -1.0 < value < 1.0:
            raise InputError(
                f"correlation of {first} and {second} = {value:g}: must be of two names, between "
                "-1 and 1"
            )
        i, j = names.index(first), names.index(second)
        if matrix[i, j] != 0.0:
            raise InputError(f"correlation of {first} and {second}: given twice")
        matrix[i, j] = matrix[j, i] = value
    if not correlations:
        return None
    try:
        factor = np.linalg.cholesky(matrix).astype(np.float64)
    except np.linalg.LinAlgError:
        raise InputError(
            "correlations: no quantities can be correlated so; their matrix must be positive "
            "definite"
        ) from None
    return factor
