"""Zones over one parameter: safe, squeal after a knock, squeal by itself."""

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

# Values of the parameter with eigenvalues (two counts), and with branches of limit cycles.
_JUDGED: Final = 129
_JUDGED_ON_BELT: Final = 33
_CONTINUED: Final = 25
# Refinements of a bound between zones: to an eighth, and by bisection.
_EIGHTHS: Final = 4
_HALVES: Final = 10
# Searches for a zone between two values: refinements to an eighth, and golden sections.
_APPROACHES: Final = 3
_LOOKS: Final = 12
_GOLDEN: Final = 0.5 * (math.sqrt(5.0) - 1.0)
# Lowest computed value above the low end, relative to the range.
_FROM_END: Final = 1e-3
# Distance of two bounds, relative to the range, below which they are equal.
_EQUAL_BOUNDS: Final = 1e-4


class Zone(StrEnum):
    """Response to disturbances at a value of the parameter."""

    SAFE = "safe"
    KNOCK = "squeals after a knock"
    SQUEALS = "squeals by itself"
    SMALL = "small disturbances die out"
    NONE = "not possible"


@dataclass(frozen=True, slots=True)
class Zones:
    """Zones along one parameter, all else equal."""

    name: str
    bounds: tuple[float, ...]
    zones: tuple[Zone, ...]

    def at(self, value: float) -> Zone | None:
        """The zone of a value, None outside the range."""
        if not self.bounds[0] <= value <= self.bounds[-1]:
            return None
        inside = sum(bound <= value for bound in self.bounds[1:-1])
        return self.zones[inside]

    def without_safe(self) -> "Zones":
        """The same zones with ``SMALL`` instead of ``SAFE``."""
        return _merge_zones(
            self.name,
            self.bounds,
            [Zone.SMALL if zone is Zone.SAFE else zone for zone in self.zones],
        )


def _merge_zones(name: str, bounds: Sequence[float], zones: Sequence[Zone]) -> Zones:
    # Zones with equal neighbours merged.
    merged_bounds, merged_zones = [bounds[0]], [zones[0]]
    for bound, zone in zip(bounds[1:-1], zones[1:], strict=True):
        if zone is not merged_zones[-1]:
            merged_bounds.append(bound)
            merged_zones.append(zone)
    return Zones(name, (*merged_bounds, bounds[-1]), tuple(merged_zones))


def linear_zones(system: System, name: str, low: float, high: float) -> Zones:
    """Zones over a parameter by eigenvalues alone, in milliseconds."""
    return _Judge(system, name, low, high).zones()


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
    where zones meet and where the least μ of a cycle comes nearest to μ. Over μ one branch is
    enough. Cycles without connection to these branches are missed; `safe_friction` may find them.
    """
    judge = _Judge(system, name, low, high)
    if not judge.searched:
        return judge.zones()
    if name != "mu":
        return _zones_by_continuation(judge, progress)
    least = float(safe_mus(judge.p, {}, np.array([judge.separation]))[0])
    return judge.zones() if math.isnan(least) else _zones_over_mu(judge, least, least)


def searched_zones(verdict: "SafeFriction", low: float, high: float) -> Zones:
    """Zones over μ from a result of `safe_friction`, without further continuation."""
    judge = _Judge(verdict.system, "mu", low, high)
    if not judge.searched:
        return judge.zones()
    squeals = verdict.others[0].mu if verdict.others else verdict.critical_mu
    return _zones_over_mu(judge, verdict.safe_to, math.inf if squeals is None else squeals)


class _Judge:
    # Stability by eigenvalues over a range of a parameter.

    def __init__(self, system: System, name: str, low: float, high: float) -> None:
        spec = parameter_spec(name)
        if not low < high:
            raise InputError(f"range of {spec.name}: must have a start below its end")
        self.p, self.separation = p, separation = system.parameters, system.separation
        self.name, self.low, self.high = name, low, high
        # The low end itself may be out of the parameter's range.
        self.least = low + _FROM_END * (high - low)
        self.on_belt = p.v_belt is not None or spec.optional
        bent = separation or p.k_nl > 0.0 or name == "k_nl"
        damped = p.c1 > 0.0 or p.c2 > 0.0 or name in ("c1", "c2")
        self.linear = not bent and damped and not self.on_belt
        self.searched = bent and damped and not self.on_belt

    def zones_at(self, values: Floats) -> list[Zone]:
        return self._zones_and_growth(values)[0]

    def _zones_and_growth(self, values: Floats) -> tuple[list[Zone], Floats]:
        # Zones by eigenvalues, and the growth rates.
        inside = np.maximum(values, self.least)
        growth, stable, _ = judge_stability(
            self.p, {self.name: inside}, np.full(values.size, self.separation)
        )
        rest = Zone.SAFE if self.linear else Zone.SMALL
        zones = [
            Zone.NONE if math.isnan(rate) else rest if good or rate <= 0.0 else Zone.SQUEALS
            for rate, good in zip(growth.tolist(), stable.tolist(), strict=True)
        ]
        return zones, growth

    def edges(self) -> list[float]:
        # Values at which the zone by eigenvalues changes.
        if self.name == "mu" and not self.on_belt:
            critical = critical_mu(System(self.p, self.separation))
            return [change.mu for change in critical if self.low < change.mu < self.high]
        count = _JUDGED_ON_BELT if self.on_belt else _JUDGED
        values = np.linspace(self.low, self.high, count)
        zones, growth = self._zones_and_growth(values)
        zone_of = dict(zip(values.tolist(), zones, strict=True))
        for index in _local_minima(growth, zones):
            zone_of |= self._differing_zones(float(values[index - 1]), float(values[index + 1]))
        return [
            self._narrow_bound(low, high)
            for low, high in pairwise(sorted(zone_of))
            if zone_of[low] is not zone_of[high]
        ]

    def _differing_zones(self, low: float, high: float) -> dict[float, Zone]:
        # Values of a different zone near the minimum of |growth| between two values of one zone.
        for _ in range(_APPROACHES):
            values = np.linspace(low, high, 9)
            zones, growth = self._zones_and_growth(values)
            differing = [index for index in range(9) if zones[index] is not zones[0]]
            if differing:
                return {float(values[index]): zones[index] for index in differing}
            index = min(max(int(np.argmin(np.abs(growth))), 1), 7)
            low, high = float(values[index - 1]), float(values[index + 1])
        return {}

    def _narrow_bound(self, low: float, high: float) -> float:
        for _ in range(_EIGHTHS):
            values = np.linspace(low, high, 9)
            zones = self.zones_at(values)
            index = next(
                (position for position in range(8) if zones[position] is not zones[position + 1]), 0
            )
            low, high = float(values[index]), float(values[index + 1])
        return 0.5 * (low + high)

    def zones(
        self,
        between: Sequence[float] = (),
        large: Callable[[float], Zone] = lambda _value: Zone.SMALL,
    ) -> Zones:
        """Zones by eigenvalues, and by `large` where small disturbances die out.

        `large` is the zone at a value by large disturbances; it changes at the values `between`.
        """
        inside = (value for value in (*self.edges(), *between) if self.low < value < self.high)
        bounds = [self.low, *sorted(inside), self.high]
        middles = [0.5 * (begin + end) for begin, end in pairwise(bounds)]
        pairs = zip(self.zones_at(np.array(middles)), middles, strict=True)
        zones = [large(middle) if zone is Zone.SMALL else zone for zone, middle in pairs]
        return _merge_zones(self.name, bounds, zones)


def _zones_over_mu(judge: _Judge, safe: float, squeals: float) -> Zones:
    # Below `safe` no disturbance is known to lead to vibration; from `squeals` on one does. Between
    # them the effect of large disturbances is not known.
    def large(mu: float) -> Zone:
        return Zone.SAFE if mu < safe else Zone.SMALL if mu < squeals else Zone.KNOCK

    return judge.zones([safe, squeals], large)


def _local_minima(distances: Floats, zones: Sequence[object]) -> list[int]:
    # Indices of local minima of |distance| between neighbours of the same zone. The distance may
    # reach zero between the points: it is at most half of a neighbour's.
    sizes = np.abs(distances)
    return [
        index
        for index in range(1, sizes.size - 1)
        if zones[index - 1] is zones[index] is zones[index + 1]
        and sizes[index - 1] > sizes[index] <= sizes[index + 1]
        and 2.0 * sizes[index] <= max(sizes[index - 1], sizes[index + 1])
    ]


def _zones_by_continuation(judge: _Judge, progress: OnProgress | None) -> Zones:
    # Zones by safe μ over the parameter, refined where safe μ crosses the μ of the set.
    values = np.linspace(judge.low, judge.high, _CONTINUED)
    values[0] = judge.least
    least_mus: dict[float, float] = {}
    work, p = Progress(progress), judge.p

    def least(value: float) -> float:
        if value not in least_mus:
            work.report(min(len(least_mus) / (2 * _CONTINUED), 1.0))
            column = {judge.name: np.array([value])}
            try:
                least_mus[value] = float(safe_mus(p, column, np.array([judge.separation]))[0])
            except InputError:
                # Scaled by m, k1 and F the remaining parameters are out of range.
                least_mus[value] = math.nan
        return least_mus[value]

    def zone(value: float) -> Zone:
        at = least(value)
        return Zone.SMALL if math.isnan(at) else Zone.KNOCK if p.mu >= at else Zone.SAFE

    distances = np.array([least(value) - p.mu for value in values.tolist()])
    for index in _local_minima(distances, [zone(value) for value in values.tolist()]):
        _search_zone(least, zone, p.mu, float(values[index - 1]), float(values[index + 1]))
    for ends in pairwise(sorted(least_mus)):
        low, high = ends
        for _ in range(_HALVES):
            if zone(low) is zone(high):
                break
            middle = 0.5 * (low + high)
            low, high = (middle, high) if zone(middle) is zone(low) else (low, middle)
    values_known = np.array(sorted(least_mus))
    between = [
        0.5 * (low + high)
        for low, high in pairwise(values_known.tolist())
        if zone(low) is not zone(high)
    ]
    # Without a zone of knocks the loss of stability gives the same bound twice.
    edges, near = judge.edges(), _EQUAL_BOUNDS * (judge.high - judge.low)
    between = [value for value in between if all(abs(value - edge) > near for edge in edges)]
    return judge.zones(
        between, lambda value: zone(float(values_known[np.argmin(np.abs(values_known - value))]))
    )


def _search_zone(
    least: Callable[[float], float],
    zone: Callable[[float], Zone],
    mu: float,
    low: float,
    high: float,
) -> None:
    # Golden-section search for a value of a different zone where safe μ comes nearest to μ.
    zone_at_low = zone(low)
    for _ in range(_LOOKS):
        first, second = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
        if zone(first) is not zone_at_low or zone(second) is not zone_at_low:
            return
        nearer = abs(least(first) - mu) < abs(least(second) - mu)
        low, high = (low, second) if nearer else (first, high)
