"""Stability over two parameters: growth rate, critical μ or unstable modes of a million points.

Everything is closed form on arrays: the equilibrium as in `model.equilibrium`, the characteristic
quartic by its resolvent cubic, the boundary by Routh–Hurwitz. Work goes in chunks, so that little
more memory is needed than the map itself.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from .critical import boundary
from .errors import Cancelled, ComputationError, InputError
from .parameters import PARAMETERS, Parameters, parameter_spec, unknown_name
from .quartic import rightmost_real_part

FloatArray = NDArray[np.float64]
MapValue = Literal["growth-rate", "critical-mu", "unstable-modes"]
Progress = Callable[[float], bool]

MAP_VALUES: Final[tuple[MapValue, ...]] = get_args(MapValue)
MAX_POINTS: Final = 100_000_000
# A chunk's arrays stay in the processor's cache.
_CHUNK: Final = 8192
_MOST_ITERATIONS: Final = 200
_CONVERGED: Final = 4.0 * np.finfo(float).eps


@dataclass(frozen=True, slots=True)
class StabilityMap:
    """A value over two parameters.

    Attributes
    ----------
    parameters : Parameters
        The other parameters.
    separation : bool
        Whether separation was considered.
    names : tuple of str
        Names of the two parameters.
    axes : tuple of ndarray, shapes (n,) and (k,)
        Their values.
    value : str
        ``"growth-rate"`` (1/s), ``"critical-mu"`` or ``"unstable-modes"``.
    values : ndarray, shape (n, k)
        The value at every point. NaN where there is none: no critical friction coefficient in the
        allowed range of μ, or no equilibrium (F < 0 lifts the slider and k3 = 0 holds it not).
    excess : ndarray, shape (n, k)
        Relative excess of μ h k_t over its value on the stability boundary: negative where the
        equilibrium is stable, zero on the boundary, NaN where there is no equilibrium; −1 where
        there is no friction coupling.
    """

    parameters: Parameters
    separation: bool
    names: tuple[str, str]
    axes: tuple[FloatArray, FloatArray]
    value: MapValue
    values: FloatArray
    excess: FloatArray


def stability_map(
    p: Parameters,
    over: Mapping[str, Sequence[float] | FloatArray],
    value: str = "growth-rate",
    *,
    separation: bool = True,
    progress: Progress | None = None,
) -> StabilityMap:
    """Compute a value over two parameters.

    Parameters
    ----------
    p : Parameters
        The parameters that do not vary.
    over : mapping of str to sequence of float
        Two parameters and the values of each, in SI units.
    value : str
        ``"growth-rate"``: greatest real part of the eigenvalues, 1/s; ``"critical-mu"``: the
        friction coefficient above which the equilibrium is unstable; ``"unstable-modes"``: how
        many modes grow, 0 or 1.
    separation : bool
        Whether separation is considered; matters for F < 0 alone.
    progress : callable, optional
        Called with the fraction done; the map is cancelled when it returns False.

    Returns
    -------
    StabilityMap
        Agrees with `stability` of every point to rounding.

    Raises
    ------
    InputError
        If `over` has not two parameters, a name is unknown, a value is not allowed, or the map has
        more than 100 000 000 points.
    ComputationError
        If a number overflows.
    Cancelled
        If `progress` returned False.
    """
    if value not in MAP_VALUES:
        raise unknown_name("map value", value, MAP_VALUES)
    if len(over) != 2:
        raise InputError(f"over: {len(over)} parameters given; allowed are two different ones")
    (first, rows), (second, columns) = ((name, _axis(name, over[name])) for name in over)
    shape = (rows.size, columns.size)
    total = rows.size * columns.size
    if total > MAX_POINTS:
        raise InputError(f"over: {total} points; allowed are {MAX_POINTS}")
    values, excess = np.empty(total), np.empty(total)
    for start in range(0, total, _CHUNK):
        if progress is not None and not progress(start / total):
            raise Cancelled
        place = np.arange(start, min(start + _CHUNK, total))
        row, column = np.divmod(place, columns.size)
        points = _Points(p, {first: rows[row], second: columns[column]}, separation)
        with np.errstate(all="ignore"):
            values[place] = points.evaluate(value)
            excess[place] = points.excess()
        _check(points, value, values[place])
    if progress is not None:
        progress(1.0)
    return StabilityMap(
        parameters=p,
        separation=separation,
        names=(first, second),
        axes=(rows, columns),
        value=next(known for known in MAP_VALUES if known == value),
        values=values.reshape(shape),
        excess=excess.reshape(shape),
    )


def _axis(name: str, values: Sequence[float] | FloatArray) -> FloatArray:
    spec = parameter_spec(name)
    axis = np.array(values, dtype=float)
    if axis.ndim != 1 or axis.size == 0:
        raise InputError(f"over: {name}: allowed are one or more numbers")
    for extreme in (axis.min(), axis.max()):
        spec.check(float(extreme))
    return axis


class _Points:
    # Many parameter sets at once: arrays of one length, and how they behave at their equilibria.

    def __init__(self, p: Parameters, varied: Mapping[str, FloatArray], separation: bool) -> None:
        size = next(iter(varied.values())).size
        self.m, self.k1, self.k2, self.k3, self.c1, self.c2, self.F, self.k_nl, self.mu = (
            varied.get(name, np.full(size, getattr(p, name))) for name in PARAMETERS
        )
        self.h = 0.5 * self.k3
        self.a = self.k1 + self.h
        damping = self.c1 + self.c2
        self.share = np.divide(self.c1, damping, out=np.full(size, 0.5), where=damping > 0.0)
        self.lifted = (self.F < 0.0) if separation else np.zeros(size, dtype=bool)
        with np.errstate(all="ignore"):
            held = self.h * self.k1 / self.a
            self.nowhere = self.lifted & ((held == 0.0) | ~np.isfinite(self.F / held))
            self.kt = np.where(self.lifted, 0.0, self.tangent(self.mu))

    def evaluate(self, value: str) -> FloatArray:
        if value == "critical-mu":
            found = self.critical_mu()
        elif value == "growth-rate":
            found = self.growth_rate()
        else:
            found = (self.excess() > 0.0).astype(float)
        found[self.nowhere] = np.nan
        return found

    def growth_rate(self) -> FloatArray:
        b = self.kt + self.h
        # In units of this frequency every coefficient is of order one.
        stiffness = self.a + b
        scale = np.sqrt(self.m * stiffness)
        coupling = self.h * (self.h - self.mu * self.kt)
        found = rightmost_real_part(
            self.c1 / scale,
            self.a / stiffness,
            self.c2 / scale,
            b / stiffness,
            coupling / stiffness / stiffness,
        )
        return found * np.sqrt(stiffness / self.m)

    def excess(self) -> FloatArray:
        left = self.mu * self.h * self.kt
        right = self.boundary(self.kt)
        relative = np.divide(left, right, out=np.zeros_like(left), where=right > 0.0) - 1.0
        relative[self.nowhere] = np.nan
        return relative

    def boundary(self, kt: FloatArray) -> FloatArray:
        return boundary(
            m=self.m, k1=self.k1, k3=self.k3, c1=self.c1, c2=self.c2, kt=kt, share=self.share
        )

    def tangent(self, mu: FloatArray) -> FloatArray:
        y = self._deflection(mu)
        return self.k2 + 3.0 * self.k_nl * y * y

    def _coefficients(self, mu: FloatArray) -> tuple[FloatArray, FloatArray]:
        friction = 1.0 + mu * self.h / self.a
        return friction * self.k_nl, friction * self.k2 + self.h * self.k1 / self.a

    def _deflection(self, mu: FloatArray) -> FloatArray:
        # The cubic of `model.equilibrium`, on arrays.
        alpha, beta = self._coefficients(mu)
        scale = np.sqrt(3.0 * alpha / beta)
        linear = -self.F / beta
        curved = scale * np.abs(linear) > 1e-4
        cubic = -2.0 / scale * np.sinh(np.arcsinh(1.5 * self.F / beta * scale) / 3.0)
        y = np.where(curved, cubic, linear)
        return y - (alpha * y * y * y + beta * y + self.F) / (3.0 * alpha * y * y + beta)

    def critical_mu(self) -> FloatArray:
        # Newton on the excess, which grows along μ; where it leaves the bracket, the bracket is
        # halved on a logarithmic scale.
        low, high = np.zeros_like(self.m), np.full_like(self.m, PARAMETERS["mu"].upper)
        without = self.lifted | (self.k3 == 0.0)
        without |= (self._excess(low)[0] >= 0.0) | (self._excess(high)[0] < 0.0)
        with np.errstate(all="ignore"):
            mu = np.clip(self.boundary(self.k2) / (self.h * self.k2), 0.0, high)
        for _ in range(_MOST_ITERATIONS):
            value, slope = self._excess(mu)
            below = value < 0.0
            low, high = np.where(below, mu, low), np.where(below, high, mu)
            new = mu - value / slope
            outside = ~((new > low) & (new < high))
            middle = np.where(low > 0.0, np.sqrt(low * high), 0.5 * (low + high))
            new = np.where(outside, middle, new)
            moved = np.abs(new - mu) > _CONVERGED * mu
            mu = new
            if not np.any(moved & (high - low > _CONVERGED * high) & ~without):
                break
        return np.where(without, np.nan, mu)

    def _excess(self, mu: FloatArray) -> tuple[FloatArray, FloatArray]:
        # μ − boundary/(h k_t) and its derivative by μ; k_t follows μ by the equilibrium.
        y = self._deflection(mu)
        alpha, beta = self._coefficients(mu)
        kt = self.k2 + 3.0 * self.k_nl * y * y
        by_mu = -(self.h / self.a) * (self.k_nl * y * y + self.k2) * y
        turn = 6.0 * self.k_nl * y * by_mu / (3.0 * alpha * y * y + beta)
        spread = self.share * (1.0 - self.share)
        detuning = kt + self.h - self.a
        bound = self.boundary(kt)
        by_kt = 2.0 * spread * detuning + self.share * self.c1 * self.c2 / self.m
        left = self.h * kt
        return mu - bound / left, 1.0 - (by_kt - bound / kt) / left * turn


def _check(points: _Points, value: str, found: FloatArray) -> None:
    # NaN means "none"; an overflow must not pass for it.
    if not np.all(np.isfinite(points.kt[~points.nowhere])) or (
        value == "growth-rate" and not np.all(np.isfinite(found[~points.nowhere]))
    ):
        raise ComputationError(
            "a number of the map is out of the range of numbers",
            "use parameters of less extreme size",
        )
