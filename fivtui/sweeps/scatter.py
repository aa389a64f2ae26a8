"""Scattered designs: points that follow distributions, in several independent scramblings.

A scrambling is one randomisation of the whole set of points.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, ClassVar, Final, Literal

import numpy as np
from numpy.typing import NDArray

from fivtui.distributions import Distribution, truncate_at_bounds
from fivtui.model import InputError, check_known
from fivtui.transient import VARIABLES

from .design import SEED_LIMIT, SOBOL_BITS, Design, sobol_directions, sobol_points

Floats = NDArray[np.float64]
ScatterKind = Literal["sobol", "lhs"]
Correlations = tuple[tuple[str, str, float], ...]

SCATTER_KINDS: Final[Mapping[str, str]] = {
    "sobol": "points of scrambled Sobol sequences",
    "lhs": "Latin hypercubes",
}
MOST_POINTS: Final = 2**24
_LEAST_REPEATS: Final = 2
_MOST_REPEATS: Final = 256
# Number of cached hypercubes.
_CACHED_HYPERCUBES: Final = 128
# Half the spacing of Sobol coordinates: offsets them from 0, at which a quantile may be infinite.
_HALF_CELL: Final = 2.0 ** -(SOBOL_BITS + 1)
# Least coordinate of a point of a Latin hypercube, for the same reason.
_MIN_COORDINATE: Final = 2.0**-54


@dataclass(frozen=True, slots=True)
class Scatter:
    """Points that follow distributions.

    Estimates from different scramblings are independent; their spread gives the error. Without
    Sobol indices a point has one member, a sample. With them it has the samples A and B, and for
    every name a mixed member: A with the value of B for that name (Saltelli 2010).

    Members are ordered by point, then scrambling, then A, B and the mixed members. With Sobol
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
        Seed of the first scrambling; the next ones have `seed` + 1, `seed` + 2, …
    repeats : int
        Number of scramblings, 2 to 256.
    indices : bool
        Whether the design is for Sobol indices.
    correlations : tuple of (str, str, float)
        Correlations of the normal scores of two names (a Gaussian copula); 0 if not given.

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
    starts: ClassVar[None] = None
    size: int = field(init=False)

    def __post_init__(self) -> None:
        check_known("design", self.kind, SCATTER_KINDS)
        if not self.axes:
            raise InputError("scatter: must have at least one name with a distribution")
        object.__setattr__(
            self,
            "axes",
            {name: truncate_at_bounds(name, axis, VARIABLES) for name, axis in self.axes.items()},
        )
        if not 1 <= self.count <= MOST_POINTS or self.count & (self.count - 1):
            raise InputError(f"count = {self.count}: must be a power of two, at most {MOST_POINTS}")
        if not _LEAST_REPEATS <= self.repeats <= _MOST_REPEATS:
            raise InputError(
                f"repeats = {self.repeats}: must be from {_LEAST_REPEATS} to {_MOST_REPEATS}"
            )
        if not 0 <= self.seed < SEED_LIMIT:
            raise InputError(f"seed = {self.seed}: must be from 0 to {SEED_LIMIT - 1}")
        if self.correlations and self.indices:
            raise InputError(
                "Sobol indices: the inputs must be independent, but "
                + ", ".join(f"{first} and {second}" for first, second, _ in self.correlations)
                + " are correlated; leave the indices out (--no-indices)"
            )
        _cholesky_factor(tuple(self.axes), self.correlations)
        object.__setattr__(self, "size", self.count * self.repeats * self.point_members)

    @property
    def point_members(self) -> int:
        """Number of members per point: 1, or for Sobol indices 2 and one for every name."""
        return len(self.axes) + 2 if self.indices else 1

    @property
    def point_samples(self) -> int:
        """Number of samples per point: its first members, drawn independently."""
        return 2 if self.indices else 1

    @property
    def seeds(self) -> list[int]:
        """The seeds of the scramblings."""
        return [self.seed + offset for offset in range(self.repeats)]

    @property
    def samples(self) -> int:
        """Number of samples: of all members but the mixed ones."""
        return self.count * self.repeats * self.point_samples

    def sample_values(self, values: NDArray[Any]) -> NDArray[Any]:
        """Select the samples from values of the first or all members; a row per scrambling.

        Points that are not complete in every scrambling are left out.
        """
        samples = self.split_values(values)[:, :, : self.point_samples]
        return samples.transpose(1, 0, 2).reshape(self.repeats, -1)

    def split_values(self, values: NDArray[Any]) -> NDArray[Any]:
        """Reshape values to (n, repeats, m) for n points with m members in every scrambling."""
        stride = self.repeats * self.point_members
        complete_points = values.size // stride
        complete = values[: complete_points * stride]
        return complete.reshape(complete_points, self.repeats, self.point_members)

    def columns(self, indices: NDArray[np.int64]) -> dict[str, Floats]:
        """Values by name at ascending indices without gaps, shape (n,) each."""
        stride = self.repeats * self.point_members
        first, stop = (int(indices[0]) // stride, int(indices[-1]) // stride + 1)
        fractions = self._fractions(first, stop)[indices - first * stride]
        factor = _cholesky_factor(tuple(self.axes), self.correlations)
        if factor is not None:
            # Correlate the normal scores of the fractions: `ndtr` is the normal distribution.
            from scipy.special import ndtr, ndtri

            fractions = ndtr(ndtri(fractions) @ factor.T)
        return {
            name: axis.at(fraction)
            for (name, axis), fraction in zip(self.axes.items(), fractions.T, strict=True)
        }

    def _fractions(self, first: int, stop: int) -> Floats:
        # Arguments of the quantile functions, for all members of points `first` to `stop` - 1.
        dims = len(self.axes)
        fractions = np.empty((stop - first, self.repeats, self.point_members, dims))
        for scrambling, seed in enumerate(self.seeds):
            points = self._points(seed, first, stop)
            fractions[:, scrambling, : self.point_samples] = points.reshape(
                stop - first, self.point_samples, dims
            )
        if self.indices:
            samples_a, samples_b = fractions[:, :, 0], fractions[:, :, 1]
            for name_index in range(dims):
                fractions[:, :, 2 + name_index] = samples_a
                fractions[:, :, 2 + name_index, name_index] = samples_b[..., name_index]
        return fractions.reshape(-1, dims)

    def _points(self, seed: int, first: int, stop: int) -> Floats:
        # Points `first` to `stop` - 1 of one scrambling in the unit cube: A, then B, in a row.
        dims = len(self.axes) * self.point_samples
        if self.kind == "sobol":
            directions = sobol_directions(dims, seed, (self.count - 1).bit_length())
            return sobol_points(directions, first, stop) + _HALF_CELL
        return _hypercube(dims, self.count, seed)[first:stop]


StudyDesign = Design | Scatter


@lru_cache(maxsize=_CACHED_HYPERCUBES)
def _hypercube(dims: int, count: int, seed: int) -> Floats:
    from scipy.stats import qmc

    points: Floats = qmc.LatinHypercube(dims, rng=seed).random(count)
    return np.maximum(points, _MIN_COORDINATE)


@lru_cache(maxsize=8)
def _cholesky_factor(names: tuple[str, ...], correlations: Correlations) -> Floats | None:
    # Cholesky factor of the correlation matrix of the normal scores; None without correlations.
    matrix = np.eye(len(names))
    for first, second, value in correlations:
        for name in (first, second):
            check_known("correlated name", name, names)
        if first == second or not -1.0 < value < 1.0:
            raise InputError(
                f"correlation of {first} and {second} = {value:g}: must be between -1 and 1, of "
                "two different names"
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
            "correlations: the matrix must be positive definite; these values contradict each other"
        ) from None
    return factor
