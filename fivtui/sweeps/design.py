"""Designs: which members a sweep has, each computed from its index, none stored."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from fivtui.model import PARAMETERS, InputError, ParameterSpec, unknown_name
from fivtui.transient import START_SPECS

Kind = Literal["product", "list", "random", "sobol"]
KINDS: Final[Mapping[str, str]] = {
    "product": "every value with every other, the last name varying fastest",
    "list": "first values together, then second values, and so on",
    "random": "points drawn uniformly between the ends",
    "sobol": "points of a scrambled Sobol sequence between the ends",
}

MAX_MEMBERS: Final = 2**62
# Of the generator of Sobol points: so many bits a coordinate, and so many points.
_SOBOL_BITS: Final = 32
MAX_SOBOL: Final = 2**_SOBOL_BITS
# A call of the counter-based generator gives this many numbers of 64 bits, of which a double
# keeps this many.
_PHILOX_WORDS: Final = 4
_MANTISSA: Final = 53

VARIABLES: Final[Mapping[str, ParameterSpec]] = {**PARAMETERS, **START_SPECS}


@dataclass(frozen=True, slots=True)
class Range:
    """Values from one end to the other.

    Parameters
    ----------
    start, stop : float
        First and last value; the last may be the smaller one.
    count : int or None
        How many values, both ends included; None for any value between the ends.
    log : bool
        Whether they are evenly spaced on a logarithmic scale.

    Raises
    ------
    InputError
        If an end is not a finite number, the count is not positive, a single value has two ends,
        or a logarithmic range does not stay above zero.

    Examples
    --------
    >>> from fivtui import Range, sweep
    >>> sweep(vary={"F": Range(20.0, 80.0, 3)}, outputs=["stable"]).table.numbers["F"].tolist()
    [20.0, 50.0, 80.0]
    """

    start: float
    stop: float
    count: int | None = None
    log: bool = False

    def __post_init__(self) -> None:
        if not np.all(np.isfinite((self.start, self.stop))):
            raise InputError(f"range {self}: both ends must be finite")
        if self.count is not None and self.count < 1:
            raise InputError(f"range {self}: count must be at least 1")
        if self.count == 1 and self.start != self.stop:
            raise InputError(f"range {self}: both ends must be the same where count is 1")
        if self.log and min(self.start, self.stop) <= 0.0:
            raise InputError(f"range {self}: both ends must be above 0 where log is True")

    def __str__(self) -> str:
        count = "" if self.count is None else f":{self.count}"
        return f"{self.start:g}:{self.stop:g}{count}{':log' if self.log else ''}"

    def between(self, share: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values at shares of the way, 0 to 1, from `start` to `stop`.

        Parameters
        ----------
        share : ndarray, shape (n,)
            The shares.

        Returns
        -------
        ndarray, shape (n,)
            The values; never beyond the ends.
        """
        if self.log:
            values = self.start * (self.stop / self.start) ** share
        else:
            values = self.start + (self.stop - self.start) * share
        low, high = sorted((self.start, self.stop))
        return np.clip(values, low, high)

    def at(self, places: NDArray[np.int64]) -> NDArray[np.float64]:
        """Values at places 0 to count - 1.

        Parameters
        ----------
        places : ndarray of int, shape (n,)
            The places.

        Returns
        -------
        ndarray, shape (n,)
            The values; the first and the last are `start` and `stop` exactly.
        """
        last = max((self.count or 1) - 1, 1)
        values = self.between(places / last)
        values[places == 0] = self.start
        values[places == last] = self.stop
        return values


Axis = Range | tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Design:
    """Which points a sweep has.

    Parameters
    ----------
    axes : mapping of str to Range or sequence of float
        What varies, by name in `VARIABLES`: parameters, and components of the start.
    kind : str
        A name in `KINDS`. In a random or Sobol design a range has no count.
    count : int, optional
        How many points of a random or Sobol design.
    seed : int, optional
        Of a random or Sobol design, 0 or more; 0 if not given.

    Attributes
    ----------
    size : int
        How many points.

    Raises
    ------
    InputError
        If a name is unknown, a value is out of bounds, or the axes do not suit the kind.

    Examples
    --------
    >>> from fivtui import Design, Range
    >>> Design({"F": Range(20.0, 80.0, 3), "mu": (0.1, 0.2)}).size
    6
    """

    axes: Mapping[str, Axis]
    kind: Kind = "product"
    count: int | None = None
    seed: int | None = None
    size: int = field(init=False)

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise unknown_name("design", self.kind, KINDS)
        if not self.axes:
            raise InputError("sweep: nothing varies; must vary one or more names")
        axes = {name: _checked(name, axis) for name, axis in self.axes.items()}
        object.__setattr__(self, "axes", axes)
        sampled = self.kind in ("random", "sobol")
        if sampled:
            object.__setattr__(self, "seed", 0 if self.seed is None else self.seed)
        size = self._sampled_size() if sampled else self._listed_size()
        if size > MAX_MEMBERS:
            raise InputError(f"sweep: {size} members; must be at most {MAX_MEMBERS}")
        object.__setattr__(self, "size", size)

    def _listed_size(self) -> int:
        if self.count is not None or self.seed is not None:
            raise InputError(f"count and seed are for random and sobol, not for {self.kind}")
        counts = {name: _length(name, axis) for name, axis in self.axes.items()}
        if self.kind == "list":
            if len(set(counts.values())) > 1:
                listed = ", ".join(f"{name} has {count}" for name, count in counts.items())
                raise InputError(f"list: must have as many values of each name; {listed}")
            return next(iter(counts.values()))
        size = 1
        for count in counts.values():
            size *= count
        return size

    def _sampled_size(self) -> int:
        for name, axis in self.axes.items():
            if not isinstance(axis, Range) or axis.count is not None:
                raise InputError(
                    f"{name}: must be two ends without a count for the design {self.kind}"
                )
        most = MAX_SOBOL if self.kind == "sobol" else MAX_MEMBERS
        if self.count is None or not 1 <= self.count <= most:
            raise InputError(
                f"count = {self.count}: must be from 1 to {most} for the design {self.kind}"
            )
        if self.seed is None or not 0 <= self.seed < MAX_MEMBERS:
            raise InputError(f"seed = {self.seed}: must be from 0 to {MAX_MEMBERS - 1}")
        return self.count

    def columns(self, indices: NDArray[np.int64]) -> dict[str, NDArray[np.float64]]:
        """The values at some points.

        Parameters
        ----------
        indices : ndarray of int, shape (n,)
            The points, 0 to size - 1, ascending by 0 or 1.

        Returns
        -------
        dict of str to ndarray, shape (n,)
            Values by name.
        """
        if self.kind in ("random", "sobol"):
            points = self._unit_points(int(indices[0]), int(indices[-1]) + 1)
            shares = points[indices - indices[0]].T
            return {
                name: axis.between(share)
                for (name, axis), share in zip(self._ranges(), shares, strict=True)
            }
        if self.kind == "list":
            return {name: _values(axis, indices) for name, axis in self.axes.items()}
        shape = [_length(name, axis) for name, axis in self.axes.items()]
        places = np.unravel_index(indices, shape)
        return {
            name: _values(axis, place.astype(np.int64))
            for (name, axis), place in zip(self.axes.items(), places, strict=True)
        }

    def _ranges(self) -> Iterator[tuple[str, Range]]:
        return ((name, axis) for name, axis in self.axes.items() if isinstance(axis, Range))

    def _unit_points(self, first: int, last: int) -> NDArray[np.float64]:
        size, seed = len(self.axes), self.seed or 0
        if self.kind == "sobol":
            # Bits are kept for as many points as there are, and no more: they cost time to find.
            directions = _sobol_directions(size, seed, (self.size - 1).bit_length())
            return _sobol_points(directions, first, last)
        return _random_points(seed, size, first, last)


def _checked(name: str, axis: object) -> Axis:
    if name not in VARIABLES:
        raise unknown_name("name", name, VARIABLES)
    spec = VARIABLES[name]
    if isinstance(axis, Range):
        return Range(spec.check(axis.start), spec.check(axis.stop), axis.count, axis.log)
    values = np.asarray(axis)
    if values.ndim != 1 or values.size == 0:
        raise InputError(f"{name}: must be a range, or one or more values")
    return tuple(spec.check(value) for value in values.tolist())


def _length(name: str, axis: Axis) -> int:
    if not isinstance(axis, Range):
        return len(axis)
    if axis.count is None:
        raise InputError(f"{name}: the number of values is missing")
    return axis.count


def _values(axis: Axis, places: NDArray[np.int64]) -> NDArray[np.float64]:
    if isinstance(axis, Range):
        return axis.at(places)
    return np.array([axis[place] for place in places.tolist()])


def _random_points(seed: int, size: int, first: int, last: int) -> NDArray[np.float64]:
    # Philox is a function of key and counter: any point can be drawn alone.
    generator = np.random.Philox(key=seed)
    blocks, ahead = divmod(first * size, _PHILOX_WORDS)
    generator.advance(blocks)
    words = generator.random_raw(ahead + (last - first) * size)[ahead:]
    units = (words >> np.uint64(64 - _MANTISSA)).astype(np.float64) * 2.0**-_MANTISSA
    return units.reshape(last - first, size)


@lru_cache(maxsize=4)
def _sobol_directions(size: int, seed: int, bits: int) -> NDArray[np.uint64]:
    # Point i is the exclusive or of point 0 and the directions at the set bits of i's Gray code:
    # points 0, 1, 2, 4, 8, … tell all directions. Row 0 holds point 0, row k + 1 direction k.
    from scipy.stats import qmc

    engine = qmc.Sobol(size, scramble=True, bits=_SOBOL_BITS, rng=seed)

    def draw() -> NDArray[np.uint64]:
        point: NDArray[np.float64] = engine.random(1)[0]
        return (point * 2.0**_SOBOL_BITS).astype(np.uint64)

    origin = draw()
    rows = [origin]
    for bit in range(bits):
        if bit > 1:
            engine.fast_forward(2 ** (bit - 1) - 1)
        earlier = rows[-1] if bit else np.zeros_like(origin)
        rows.append(draw() ^ origin ^ earlier)
    return np.array(rows)


def _sobol_points(directions: NDArray[np.uint64], first: int, last: int) -> NDArray[np.float64]:
    index = np.arange(first, last, dtype=np.uint64)
    gray = index ^ (index >> np.uint64(1))
    points = np.repeat(directions[:1], last - first, axis=0)
    for bit, direction in enumerate(directions[1:]):
        chosen = (gray >> np.uint64(bit) & np.uint64(1)).astype(bool)
        points[chosen] ^= direction
    return points.astype(np.float64) * 2.0**-_SOBOL_BITS
