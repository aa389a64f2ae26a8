"""Zones over one parameter: safe, squeals after a knock, squeals by itself.

Eigenvalues give the zones for small disturbances; safe μ, the least μ of limit cycles, gives those
for large ones. A bound is a value at which the zone changes.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.equilibrium import critical_mu, judge_stability
from fivtui.model import InputError, OnProgress, Progress, System, parameter_spec

from .table import safe_mus

if TYPE_CHECKING:
    from .verdict import SafeFriction

Floats = NDArray[np.float64]

# Number of values of the parameter at which eigenvalues are computed, with a belt that is always
# faster than the slider. It is even: a symmetric range of F has no value 0, at which eigenvalues
# decide nothing.
_EIGENVALUE_POINTS: Final = 128
# The same number with a belt of finite speed, on which eigenvalues take longer.
_EIGENVALUE_POINTS_ON_BELT: Final = 32
# Number of values of the parameter at which branches of limit cycles are followed.
_BRANCH_POINTS: Final = 25
# Eigenvalues of many values are computed together. A refinement splits an interval into this many.
_INTERVALS: Final = 8
# Refinements of a bound of zones, and of an interval that may hide a zone.
_BOUND_REFINEMENTS: Final = 4
_ZONE_REFINEMENTS: Final = 3
# Branches are computed one by one: bisections of a bound, and golden-section steps to a zone.
_BISECTIONS: Final = 10
_GOLDEN_SECTIONS: Final = 12
_GOLDEN_RATIO: Final = 0.5 * (math.sqrt(5.0) - 1.0)
# Distance of the lowest computed value from the low end, relative to the range.
_END_OFFSET: Final = 1e-3
# Distance of two bounds, relative to the range, up to which they are the same.
_BOUND_TOLERANCE: Final = 1e-4


class Zone(StrEnum):
    """Response to disturbances at a value of the parameter."""

    SAFE = "safe"
    KNOCK = "squeals after a knock"
    SQUEALS = "squeals by itself"
    SMALL = "small disturbances die out"
    # There is no equilibrium, or eigenvalues decide nothing.
    NONE = "not possible"


@dataclass(frozen=True, slots=True)
class Zones:
    """Zones along one parameter with all other parameters fixed.

    `bounds` are ascending, with both ends of the range; `zones` are those between them.
    """

    name: str
    bounds: tuple[float, ...]
    zones: tuple[Zone, ...]

    def at(self, value: float) -> Zone | None:
        """The zone of a value, None outside the range."""
        if not self.bounds[0] <= value <= self.bounds[-1]:
            return None
        return self.zones[sum(bound <= value for bound in self.bounds[1:-1])]

    def without_safe(self) -> "Zones":
        """The same zones with ``SMALL`` instead of ``SAFE``."""
        return _merge_zones(
            self.name,
            self.bounds,
            [Zone.SMALL if zone is Zone.SAFE else zone for zone in self.zones],
        )


def _merge_zones(name: str, bounds: Sequence[float], zones: Sequence[Zone]) -> Zones:
    # Merge neighbouring equal zones.
    merged_bounds, merged_zones = [bounds[0]], [zones[0]]
    for bound, zone in zip(bounds[1:-1], zones[1:], strict=True):
        if zone is not merged_zones[-1]:
            merged_bounds.append(bound)
            merged_zones.append(zone)
    return Zones(name, (*merged_bounds, bounds[-1]), tuple(merged_zones))


def linear_zones(system: System, name: str, low: float, high: float) -> Zones:
    """Zones over a parameter by eigenvalues alone, computed in milliseconds."""
    return _EigenvalueZones(system, name, low, high).zones()


def safety_zones(
    system: System,
    name: str,
    low: float,
    high: float,
    *,
    progress: OnProgress | None = None,
) -> Zones:
    """Zones over a parameter by eigenvalues and continuation.

    Limit cycles are followed from the Hopf point at 25 values of the parameter. Values are added
    at the bounds of zones, and where the least μ of a cycle is nearest to μ. Over μ one branch is
    enough. Cycles that these branches do not contain are missed; `safe_friction` may find them.
    """
    linear = _EigenvalueZones(system, name, low, high)
    if not linear.may_have_cycles:
        return linear.zones()
    if name != "mu":
        return _zones_by_continuation(linear, progress)
    safe_mu = float(safe_mus(linear.p, {}, np.array([linear.separation]))[0])
    return linear.zones() if math.isnan(safe_mu) else _zones_over_mu(linear, safe_mu, safe_mu)


def zones_of_safe_friction(result: "SafeFriction", low: float, high: float) -> Zones:
    """Zones over μ from a result of `safe_friction`, without further continuation."""
    linear = _EigenvalueZones(result.system, "mu", low, high)
    if not linear.may_have_cycles:
        return linear.zones()
    squeal_mu = result.others[0].mu if result.others else result.critical_mu
    return _zones_over_mu(linear, result.safe_to, math.inf if squeal_mu is None else squeal_mu)


class _EigenvalueZones:
    # Zones by eigenvalues over a range of a parameter.

    def __init__(self, system: System, name: str, low: float, high: float) -> None:
        spec = parameter_spec(name)
        if not low < high:
            raise InputError(f"range of {spec.name}: must have a start below its end")
        self.p, self.separation = p, separation = system.parameters, system.separation
        self.name, self.low, self.high = name, low, high
        # The low end itself may be outside the range of the parameter.
        self.lower_value = low + _END_OFFSET * (high - low)
        # Optional parameters are those of a belt of finite speed.
        self.on_belt = p.v_belt is not None or spec.optional
        nonlinear = separation or p.k_nl > 0.0 or name == "k_nl"
        damped = p.c1 > 0.0 or p.c2 > 0.0 or name in ("c1", "c2")
        self.is_linear = not nonlinear and damped and not self.on_belt
        self.may_have_cycles = nonlinear and damped and not self.on_belt

    def zones_at(self, values: Floats) -> list[Zone]:
        return self._zones_and_growth(values)[0]

    def _zones_and_growth(self, values: Floats) -> tuple[list[Zone], Floats]:
        # Zones by eigenvalues, and growth rates, 1/s.
        allowed_values = np.maximum(values, self.lower_value)
        growth, stabilities, _ = judge_stability(
            self.p, {self.name: allowed_values}, np.full(values.size, self.separation)
        )
        decay_zone = Zone.SAFE if self.is_linear else Zone.SMALL
        zones = [
            Zone.NONE if math.isnan(rate) else decay_zone if stable or rate <= 0.0 else Zone.SQUEALS
            for rate, stable in zip(growth.tolist(), stabilities.tolist(), strict=True)
        ]
        return zones, growth

    def bounds(self) -> list[float]:
        # Values at which the zone by eigenvalues changes.
        if self.name == "mu" and not self.on_belt:
            critical = critical_mu(System(self.p, self.separation))
            return [change.mu for change in critical if self.low < change.mu < self.high]
        count = _EIGENVALUE_POINTS_ON_BELT if self.on_belt else _EIGENVALUE_POINTS
        values = np.linspace(self.low, self.high, count)
        zones, growth = self._zones_and_growth(values)
        zone_at = dict(zip(values.tolist(), zones, strict=True))
        for index in _local_minima(growth, zones):
            zone_at |= self._zones_between(float(values[index - 1]), float(values[index + 1]))
        return [
            self._find_bound(low, high)
            for low, high in pairwise(sorted(zone_at))
            if zone_at[low] is not zone_at[high]
        ]

    def _zones_between(self, low: float, high: float) -> dict[float, Zone]:
        # Values in a different zone, near the minimum of |growth|, between two values of one zone.
        for _ in range(_ZONE_REFINEMENTS):
            values = np.linspace(low, high, _INTERVALS + 1)
            zones, growth = self._zones_and_growth(values)
            zone_at = {
                float(value): zone
                for value, zone in zip(values, zones, strict=True)
                if zone is not zones[0]
            }
            if zone_at:
                return zone_at
            middle = min(max(int(np.argmin(np.abs(growth))), 1), _INTERVALS - 1)
            low, high = float(values[middle - 1]), float(values[middle + 1])
        return {}

    def _find_bound(self, low: float, high: float) -> float:
        # The value between two of different zones at which the zone changes.
        for _ in range(_BOUND_REFINEMENTS):
            values = np.linspace(low, high, _INTERVALS + 1)
            changes = (before is not after for before, after in pairwise(self.zones_at(values)))
            index = next((index for index, change in enumerate(changes) if change), 0)
            low, high = float(values[index]), float(values[index + 1])
        return 0.5 * (low + high)

    def zones(
        self,
        changes: Sequence[float] = (),
        large_zone: Callable[[float], Zone] = lambda _value: Zone.SMALL,
    ) -> Zones:
        """Zones by eigenvalues and, where small disturbances die out, by `large_zone`.

        `large_zone` returns the zone for large disturbances; it changes at `changes`.
        """
        values = (value for value in (*self.bounds(), *changes) if self.low < value < self.high)
        bounds = [self.low, *sorted(values), self.high]
        # Not the middle, which is 0 in a symmetric range: at F = 0 eigenvalues decide nothing.
        inner = [begin + 0.45 * (end - begin) for begin, end in pairwise(bounds)]
        zones = [
            large_zone(value) if zone is Zone.SMALL else zone
            for zone, value in zip(self.zones_at(np.array(inner)), inner, strict=True)
        ]
        return _merge_zones(self.name, bounds, zones)


def _zones_over_mu(linear: _EigenvalueZones, safe_mu: float, squeal_mu: float) -> Zones:
    # Below `safe_mu` no disturbance is known to lead to vibration; from `squeal_mu` on one does.
    # Between them the effect of large disturbances is not known.
    def large_zone(mu: float) -> Zone:
        return Zone.SAFE if mu < safe_mu else Zone.SMALL if mu < squeal_mu else Zone.KNOCK

    return linear.zones([safe_mu, squeal_mu], large_zone)


def _local_minima(distances: Floats, zones: Sequence[object]) -> list[int]:
    # Indices of local minima of |distance| whose neighbours are in the same zone. Between these
    # points the distance may be zero, and a zone be hidden. This is likely only if the minimum is
    # at most half of a neighbour's |distance|.
    sizes = np.abs(distances)
    return [
        index
        for index in range(1, sizes.size - 1)
        if zones[index - 1] is zones[index] is zones[index + 1]
        and sizes[index - 1] > sizes[index] <= sizes[index + 1]
        and 2.0 * sizes[index] <= max(sizes[index - 1], sizes[index + 1])
    ]


def _zones_by_continuation(linear: _EigenvalueZones, progress: OnProgress | None) -> Zones:
    # Zones by safe μ over the parameter, refined where safe μ crosses the μ of the set.
    values = np.linspace(linear.low, linear.high, _BRANCH_POINTS)
    values[0] = linear.lower_value
    least_mus: dict[float, float] = {}
    work, p = Progress(progress), linear.p

    def least_mu(value: float) -> float:
        # Safe μ at a value of the parameter, NaN without one; stored in `least_mus`.
        if value not in least_mus:
            work.report(min(len(least_mus) / (2 * _BRANCH_POINTS), 1.0))
            column = {linear.name: np.array([value])}
            try:
                least_mus[value] = float(safe_mus(p, column, np.array([linear.separation]))[0])
            except InputError:
                # The dimensionless groups of these parameters are out of range.
                least_mus[value] = math.nan
        return least_mus[value]

    def zone_at(value: float) -> Zone:
        least = least_mu(value)
        return Zone.SMALL if math.isnan(least) else Zone.KNOCK if p.mu >= least else Zone.SAFE

    distances = np.array([least_mu(value) - p.mu for value in values.tolist()])
    for index in _local_minima(distances, [zone_at(value) for value in values.tolist()]):
        _search_between(least_mu, zone_at, p.mu, float(values[index - 1]), float(values[index + 1]))
    # Bisect between different zones; `zone_at` adds every middle to `least_mus`.
    for begin, end in pairwise(sorted(least_mus)):
        low, high = begin, end
        for _ in range(_BISECTIONS):
            if zone_at(low) is zone_at(high):
                break
            middle = 0.5 * (low + high)
            low, high = (middle, high) if zone_at(middle) is zone_at(low) else (low, middle)
    computed_values = np.array(sorted(least_mus))
    bounds = [
        0.5 * (low + high)
        for low, high in pairwise(computed_values.tolist())
        if zone_at(low) is not zone_at(high)
    ]
    # Where safe μ equals the critical μ, no zone of knocks lies between them: skip these bounds, as
    # eigenvalues give them too.
    linear_bounds, tolerance = linear.bounds(), _BOUND_TOLERANCE * (linear.high - linear.low)
    bounds = [
        bound
        for bound in bounds
        if all(abs(bound - linear_bound) > tolerance for linear_bound in linear_bounds)
    ]

    def nearest_zone(value: float) -> Zone:
        return zone_at(float(computed_values[np.argmin(np.abs(computed_values - value))]))

    return linear.zones(bounds, nearest_zone)


def _search_between(
    least_mu: Callable[[float], float],
    zone_at: Callable[[float], Zone],
    mu: float,
    low: float,
    high: float,
) -> None:
    # Golden-section search for another zone near the least |safe μ - μ|; `least_mu` stores values.
    zone_at_low = zone_at(low)
    for _ in range(_GOLDEN_SECTIONS):
        section = _GOLDEN_RATIO * (high - low)
        inner_low, inner_high = high - section, low + section
        if zone_at(inner_low) is not zone_at_low or zone_at(inner_high) is not zone_at_low:
            return
        low_is_nearer = abs(least_mu(inner_low) - mu) < abs(least_mu(inner_high) - mu)
        low, high = (low, inner_high) if low_is_nearer else (inner_low, high)
