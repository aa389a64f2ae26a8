"""Designs: the points of a sweep, which are computed from their indices.

A point is a value for each varied name. An axis has the values of one name: a range or a list.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from fivtui.model import InputError, Interval, check_known
from fivtui.ranges import log_spaced, parse_range
from fivtui.transient import VARIABLES

DesignKind = Literal["product", "list", "random", "sobol"]
DESIGN_KINDS: Final[Mapping[str, str]] = {
    "product": "all combinations of values, the last name varying fastest",
    "list": "the first value of each name, then the second value of each, and so on",
    "random": "points drawn uniformly between the ends",
    "sobol": "points of a scrambled Sobol sequence between the ends",
}

# Limit of points: there are up to two members per point, and their indices have 63 bits.
MAX_MEMBERS: Final = 2**62
# Seeds are below this.
SEED_LIMIT: Final = 2**62
_STARTS: Final = Interval(1, 100_000)
# Bits of a coordinate of a Sobol point; they limit the number of points.
SOBOL_BITS: Final = 32
MAX_SOBOL: Final = 2**SOBOL_BITS
# Number of cached Sobol sequences.
_CACHED_SEQUENCES: Final = 128
# Bits of a random number of the Philox generator, numbers in its block, and bits in the mantissa of
# a double.
_WORD_BITS: Final = 64
_PHILOX_BLOCK: Final = 4
_MANTISSA_BITS: Final = 53


@dataclass(frozen=True, slots=True)
class Range:
    """Values from one end to the other, evenly spaced.

    Parameters
    ----------
    start, stop : float
        First and last value; either may be the smaller one.
    count : int, optional
        Number of values, both ends included; not given in a random or Sobol design.
    log : bool
        Whether the spacing is logarithmic; both ends are then above 0.

    Raises
    ------
    InputError
        If an end is not finite, or `count` or `log` does not fit the ends.

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

    def interpolate(self, steps: NDArray[np.float64], last_step: int = 1) -> NDArray[np.float64]:
        """Interpolate: step 0 is at `start`, `last_step` at `stop`; shape (n,)."""
        if self.log:
            values = log_spaced(self.start, self.stop, steps, last_step)
        else:
            values = self.start + (self.stop - self.start) * (steps / last_step)
        low, high = sorted((self.start, self.stop))
        return np.clip(values, low, high)

    def values_at(self, indices: NDArray[np.int64]) -> NDArray[np.float64]:
        """Values at indices 0 to count - 1, shape (n,); the ends are exact."""
        last_index = max((self.count or 1) - 1, 1)
        values = self.interpolate(indices.astype(float), last_index)
        values[indices == 0] = self.start
        values[indices == last_index] = self.stop
        return values


Axis = Range | tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Design:
    """The points of a sweep.

    Parameters
    ----------
    axes : mapping of str to Range or sequence of float
        Values by name: parameters, and ``x0``, ``vx0``, ``y0``, ``vy0`` of the start.
    kind : "product", "list", "random" or "sobol"
        All combinations, the first values of all names, then the second and so on, or random or
        Sobol points between the ends of ranges.
    count : int, optional
        Number of points of a random or Sobol design.
    seed : int, optional
        Seed of a random or Sobol design and of `starts`, 0 or more; 0 by default.
    starts : int, optional
        Number of random starts around the equilibrium at every point, in the box that the search
        for safe friction uses: adds the share of them that ends in vibration, see `sweep`.

    Attributes
    ----------
    size : int
        Number of points.

    Raises
    ------
    InputError
        If a name is unknown, a value is out of bounds, or an axis does not fit the kind.

    Examples
    --------
    >>> from fivtui import Design, Range
    >>> Design({"F": Range(20.0, 80.0, 3), "mu": (0.1, 0.2)}).size
    6
    """

    axes: Mapping[str, Axis]
    kind: DesignKind = "product"
    count: int | None = None
    seed: int | None = None
    starts: int | None = None
    size: int = field(init=False)

    def __post_init__(self) -> None:
        check_known("design", self.kind, DESIGN_KINDS)
        if not self.axes:
            raise InputError("sweep: nothing varies; at least one name must vary")
        axes = {name: _check_axis(name, axis) for name, axis in self.axes.items()}
        object.__setattr__(self, "axes", axes)
        sampled = self.kind in ("random", "sobol")
        if self.starts is not None:
            _STARTS.check("starts", self.starts)
        if sampled or self.starts is not None:
            object.__setattr__(self, "seed", 0 if self.seed is None else self.seed)
        if self.seed is not None and not 0 <= self.seed < SEED_LIMIT:
            raise InputError(f"seed = {self.seed}: must be from 0 to {SEED_LIMIT - 1}")
        size = self._sampled_size() if sampled else self._listed_size()
        if size > MAX_MEMBERS:
            raise InputError(f"sweep: {size} members; must be at most {MAX_MEMBERS}")
        object.__setattr__(self, "size", size)

    def _listed_size(self) -> int:
        if self.count is not None or (self.seed is not None and self.starts is None):
            raise InputError(f"count and seed must not be given for the design {self.kind}")
        counts = {name: _value_count(name, axis) for name, axis in self.axes.items()}
        if self.kind == "list":
            if len(set(counts.values())) > 1:
                counts_text = ", ".join(f"{name} has {count}" for name, count in counts.items())
                raise InputError(f"list: must have equally many values of each name; {counts_text}")
            return next(iter(counts.values()))
        size = 1
        for count in counts.values():
            size *= count
        return size

    def _sampled_size(self) -> int:
        for name, axis in self.axes.items():
            if not isinstance(axis, Range) or axis.count is not None:
                low, high = _axis_ends(axis)
                raise InputError(
                    f"{name}: must be two ends without a count for the design {self.kind}: "
                    f"give Range({low:g}, {high:g})"
                )
        limit = MAX_SOBOL if self.kind == "sobol" else MAX_MEMBERS
        if self.count is None or not 1 <= self.count <= limit:
            value = ": must be given," if self.count is None else f" = {self.count}: must be"
            raise InputError(f"count{value} from 1 to {limit} for the design {self.kind}")
        return self.count

    def columns(self, indices: NDArray[np.int64]) -> dict[str, NDArray[np.float64]]:
        """Values by name at ascending indices without gaps, shape (n,) each; indices may repeat."""
        if self.kind in ("random", "sobol"):
            points = self._unit_points(int(indices[0]), int(indices[-1]) + 1)
            fractions = points[indices - indices[0]].T
            return {
                name: axis.interpolate(fraction)
                for (name, axis), fraction in zip(self._ranges(), fractions, strict=True)
            }
        if self.kind == "list":
            return {name: _axis_values(axis, indices) for name, axis in self.axes.items()}
        shape = [_value_count(name, axis) for name, axis in self.axes.items()]
        indices_by_axis = np.unravel_index(indices, shape)
        return {
            name: _axis_values(axis, axis_indices.astype(np.int64))
            for (name, axis), axis_indices in zip(self.axes.items(), indices_by_axis, strict=True)
        }

    def _ranges(self) -> Iterator[tuple[str, Range]]:
        return ((name, axis) for name, axis in self.axes.items() if isinstance(axis, Range))

    def _unit_points(self, first: int, stop: int) -> NDArray[np.float64]:
        # Random or Sobol points `first` to `stop` - 1 in the unit cube, a row each.
        dimensions, seed = len(self.axes), self.seed or 0
        if self.kind == "sobol":
            # Directions are slow to compute, so limit them to those that the points need.
            directions = sobol_directions(dimensions, seed, (self.size - 1).bit_length())
            return sobol_points(directions, first, stop)
        return random_points(seed, dimensions, first, stop)


def _axis_ends(axis: Axis) -> tuple[float, float]:
    return (axis.start, axis.stop) if isinstance(axis, Range) else (axis[0], axis[-1])


def _check_axis(name: str, axis: object) -> Axis:
    check_known("name", name, VARIABLES)
    spec = VARIABLES[name]
    if isinstance(axis, Range):
        return Range(spec.check(axis.start), spec.check(axis.stop), axis.count, axis.log)
    values = np.asarray(axis)
    if values.ndim != 1 or values.size == 0:
        raise InputError(
            f"{name}: must be a range, or one or more values; for a distribution, its draws with "
            "design='list', or use `uncertainty`"
        )
    return tuple(spec.check(value) for value in values.tolist())


def _value_count(name: str, axis: Axis) -> int:
    if not isinstance(axis, Range):
        return len(axis)
    if axis.count is None:
        raise InputError(f"{name}: the count must be given")
    return axis.count


def _axis_values(axis: Axis, indices: NDArray[np.int64]) -> NDArray[np.float64]:
    if isinstance(axis, Range):
        return axis.values_at(indices)
    return np.array([axis[index] for index in indices.tolist()])


def random_points(seed: int, dimensions: int, first: int, stop: int) -> NDArray[np.float64]:
    """Random points `first` to `stop` - 1 in the unit cube, a row each."""
    # Philox computes its numbers from a key and a counter, so it can skip to any point.
    generator = np.random.Philox(key=seed)
    blocks, skipped = divmod(first * dimensions, _PHILOX_BLOCK)
    generator.advance(blocks)
    raw_numbers = generator.random_raw(skipped + (stop - first) * dimensions)[skipped:]
    mantissas = (raw_numbers >> np.uint64(_WORD_BITS - _MANTISSA_BITS)).astype(np.float64)
    fractions = mantissas * 2.0**-_MANTISSA_BITS
    return fractions.reshape(stop - first, dimensions)


@lru_cache(maxsize=_CACHED_SEQUENCES)
def sobol_directions(dimensions: int, seed: int, bits: int) -> NDArray[np.uint64]:
    """Scrambled direction numbers for the first 2^`bits` points of a Sobol sequence.

    Row 0 is point 0, row k + 1 the direction number of bit k; `sobol_points` uses them.
    """
    # Point i is point 0 XOR the direction numbers at the set bits of the Gray code of i. The Gray
    # code of 2^k has the bits k and k − 1: point 2^k, point 0 and the direction number of bit k − 1
    # give that of bit k.
    from scipy.stats import qmc

    engine = qmc.Sobol(dimensions, scramble=True, bits=SOBOL_BITS, rng=seed)

    def draw_point() -> NDArray[np.uint64]:
        point: NDArray[np.float64] = engine.random(1)[0]
        return (point * 2.0**SOBOL_BITS).astype(np.uint64)

    origin = draw_point()
    rows = [origin]
    for bit in range(bits):
        if bit > 1:
            # Skip the points between 2^(bit − 1) and 2^bit.
            engine.fast_forward(2 ** (bit - 1) - 1)
        previous = rows[-1] if bit else np.zeros_like(origin)
        rows.append(draw_point() ^ origin ^ previous)
    return np.array(rows)


def sobol_points(directions: NDArray[np.uint64], first: int, stop: int) -> NDArray[np.float64]:
    """Points `first` to `stop` - 1 of a Sobol sequence, multiples of 2^-32 from 0, a row each."""
    index = np.arange(first, stop, dtype=np.uint64)
    gray = index ^ (index >> np.uint64(1))
    points = np.repeat(directions[:1], stop - first, axis=0)
    for bit, direction in enumerate(directions[1:]):
        has_bit = (gray >> np.uint64(bit) & np.uint64(1)).astype(bool)
        points[has_bit] ^= direction
    return points.astype(np.float64) * 2.0**-SOBOL_BITS


def parse_design(
    texts: Sequence[str],
    kind: DesignKind,
    count: int | None = None,
    seed: int | None = None,
    starts: int | None = None,
) -> Design:
    """Parse the texts of ``--vary``.

    They are ``NAME=START:STOP:COUNT[:log]`` or ``NAME=V1,V2,…``; in random and Sobol designs
    ``NAME=START:STOP[:log]``. Raises `InputError` as `Design`, or if a text has another form.
    """
    axes: dict[str, Axis] = {}
    for text in texts:
        name, axis = _parse_axis(text, sampled=kind in ("random", "sobol"))
        if name in axes:
            raise InputError(f"--vary {text}: {name} is given twice")
        axes[name] = axis
    return Design(axes, kind, count, seed, starts)


def _parse_axis(text: str, *, sampled: bool) -> tuple[str, Axis]:
    name, equals, values = text.partition("=")
    if equals and values and ":" not in values and not sampled:
        name = name.strip()
        check_known("parameter", name, VARIABLES)
        return name, tuple(VARIABLES[name].check(part.strip()) for part in values.split(","))
    named_range = parse_range("--vary", text, VARIABLES, counted=not sampled)
    return named_range.name, Range(
        named_range.start, named_range.stop, None if sampled else named_range.count, named_range.log
    )
