"""The global search: motions from many starts at many μ, of which those that stay are examined.

Its limit is a number of integration steps, never a time, so that the answer is the same everywhere.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fivtui.batch import Batch, simulate_batch
from fivtui.kernel import Status
from fivtui.model import Parameters, equilibrium
from fivtui.orbits import Attraction, length_scale, slowest_period
from fivtui.transient import MAX_T_END, Progress

from .starts import disturbed

Floats = NDArray[np.float64]
Places = NDArray[np.int64]
Flags = NDArray[np.bool_]

# Values of μ in a round, and starts at each.
LEVELS: Final = 16
_STARTS: Final = 128
_FEWEST: Final = 4
# Integration steps of all rounds together, and of one of them.
MOST_STEPS: Final = 16_000_000
_STEPS_A_ROUND: Final = 12_000_000
# Horizons of the stages, in decay times of small disturbances; at least this many periods.
_STAGES: Final = (5.0, 20.0, 80.0)
_PERIODS: Final = 100.0
_STEPS_A_PERIOD: Final = 16.0
# Decay slower than this part of the fastest motion is rounding.
_NEUTRAL: Final = 1e-12
# Motions that need more periods than this to decay are not followed.
_MOST_PERIODS: Final = 20_000.0
# The part of the motions that a later stage is expected to have left.
_LEFT: Final = 0.15
# Motion this many times as fast as the slowest period takes steps that cost more: there are fewer.
_STIFF: Final = 20.0
_PART_IF_STIFF: Final = 6
# Steps of a motion, however many there are.
_LEAST_LIMIT: Final = 2_000
_TOL: Final = 1e-6
# Motion that has decayed to this part of its first extent is at rest, if decay is not proven.
_DIED_OUT: Final = 1e-9
# Motion beyond this many times its first extent and every length of the system is unbounded.
_UNBOUNDED: Final = 1e6
# A motion whose half peak-to-peak is above this part of a cycle's stays.
_STAYS: Final = 0.1
# Values of μ at which the least one is looked for, and how often between two of them.
_BETWEEN: Final = 32
_REFINEMENTS: Final = 2
# Half peak-to-peak that changes by less than this part from one stage to the next has settled.
_SETTLED: Final = 1e-3


@dataclass(frozen=True, slots=True)
class Survivor:
    """A motion that did not die out: its μ, its last state, its half peak-to-peak of y, m."""

    mu: float
    state: tuple[float, float, float, float]
    half_range: float


@dataclass(frozen=True, slots=True)
class SearchRound:
    """What became of the motions of one round of the search.

    Attributes
    ----------
    levels : tuple of float
        The values of μ.
    starts : int
        Number of motions.
    died_out : int
        Those that came to rest.
    settled : tuple of Survivor
        Those whose amplitude does not change any more, by ascending μ.
    unbounded : tuple of Survivor
        Those that grow without bounds, with their start states.
    undecided : int
        Those of which neither is known: the limit of steps ended them, or they change slowly.
    steps : int
        Integration steps of all.
    horizon : float
        Duration of the longest motions, s.
    """

    levels: tuple[float, ...]
    starts: int
    died_out: int
    settled: tuple[Survivor, ...]
    unbounded: tuple[Survivor, ...]
    undecided: int
    steps: int
    horizon: float


def search_round(
    p: Parameters, top: float, most: int, *, separation: bool, progress: Progress | None
) -> SearchRound:
    """Follow motions from Sobol starts at evenly spaced μ below `top`, for at most `most` steps.

    No motion is followed where damping is so small that none would come to rest.
    Raises `Cancelled` if `progress` returned False, `ComputationError` if there is no equilibrium.
    """
    most = min(most, _STEPS_A_ROUND)
    return _Round(p, top, most, progress, separation=separation).result()


def least_growth(p: Parameters, one: Survivor, found: SearchRound, *, separation: bool) -> float:
    """The least μ, to a thousandth of a level, from which a motion's start grows without bounds."""
    place = found.levels.index(one.mu)
    low = found.levels[place - 1] if place else 0.0
    length = max(float(np.abs(one.state).max()), length_scale(p, separation=separation))

    def grown(run: Batch) -> Flags:
        over: Flags = np.maximum(run.peak.y_abs, run.peak.x_abs) > _UNBOUNDED * length
        over |= run.status == Status.OVERFLOW
        return over

    return _least(p, one, (low, found.horizon), grown, separation=separation)


def least_staying(p: Parameters, one: Survivor, low: float, *, separation: bool) -> float:
    """The least μ, between `low` and its own, at which a motion does not die out.

    Its own where damping is so small that no motion would.
    """
    at = p.with_values({"mu": low})
    region = Attraction(at, equilibrium(at, separation=separation), separation=separation)
    horizon = _horizons(-region.growth, slowest_period(p))[-1]
    if horizon > _MOST_PERIODS * slowest_period(p):
        return one.mu

    def stays(run: Batch) -> Flags:
        staying: Flags = run.steady.y_half_range > _STAYS * one.half_range
        return staying

    return _least(p, one, (low, horizon), stays, separation=separation)


def _least(
    p: Parameters,
    one: Survivor,
    span: tuple[float, float],
    holds: Callable[[Batch], Flags],
    *,
    separation: bool,
) -> float:
    # The least μ from which on, up to its own, something holds of the motion from a state.
    (low, horizon), high = span, one.mu
    for _ in range(_REFINEMENTS):
        mu = np.linspace(low, high, _BETWEEN + 1)
        run = simulate_batch(
            {"mu": mu[:-1]},
            base=p,
            t_end=horizon,
            tol=_TOL,
            separation=separation,
            start=one.state,
            require={"peak", "steady"},
            max_steps=_STEPS_A_ROUND // _BETWEEN,
        )
        failing = np.flatnonzero(~holds(run))
        last = int(failing[-1]) if failing.size else 0
        low, high = float(mu[last]), float(mu[last + 1]) if failing.size else low
    return high


def _horizons(decay: float, period: float) -> list[float]:
    # Durations of the stages, s.
    time = 1.0 / decay if decay > 0.0 else 0.0
    return [min(max(stage * time, _PERIODS * period), MAX_T_END) for stage in _STAGES]


class _Ends(NamedTuple):
    # Final states, half peak-to-peak of y, whether the limit of steps was met, and whether motion
    # grew without bounds.
    states: Floats
    sizes: Floats
    given_up: Flags
    grown: Flags


class _Round:
    # Motions by their index, in the order of μ, and what becomes of them.

    def __init__(
        self,
        p: Parameters,
        top: float,
        most: int,
        progress: Progress | None,
        *,
        separation: bool,
    ) -> None:
        self._most = most
        self._p, self._separation, self._progress = p, separation, progress
        self._levels = [top * (place + 0.5) / LEVELS for place in range(LEVELS)]
        sets = [p.with_values({"mu": mu}) for mu in self._levels]
        self._regions = [
            Attraction(one, equilibrium(one, separation=separation), separation=separation)
            for one in sets
        ]
        period = slowest_period(p)
        decay = max(-region.growth for region in self._regions)
        fastest = max(region.fastest for region in self._regions)
        if fastest * period > _STIFF * math.tau:
            self._most = most = most // _PART_IF_STIFF
        self._horizons = _horizons(decay, period)
        periods = (self._horizons[0] + _LEFT * sum(self._horizons[1:])) / period
        count = int(np.clip(most / (LEVELS * _STEPS_A_PERIOD * periods), _FEWEST, _STARTS))
        if decay <= _NEUTRAL * fastest or self._horizons[0] > _MOST_PERIODS * period:
            count = 0
        self._begin = np.concatenate([disturbed(one, count, separation=separation) for one in sets])
        self._level = np.repeat(np.arange(LEVELS), count)
        self._scale = np.array([1.0, period / math.tau, 1.0, period / math.tau])
        self._rest = np.array([region.rest for region in self._regions])
        self._first = self._extent(self._begin, self._level)
        self._steps = 0

    def result(self) -> SearchRound:
        alive = np.arange(self._level.size)
        states, sizes = self._begin, np.full(alive.size, np.inf)
        settled: dict[int, Survivor] = {}
        unbounded: dict[int, Survivor] = {}
        undecided = 0
        for horizon in self._horizons:
            kept = self._affordable(alive, horizon)
            undecided += alive.size - kept.size
            alive, states, before = alive[kept], states[kept], sizes[kept]
            if not alive.size:
                break
            states, sizes, given_up, grown = self._run(alive, states, horizon)
            undecided += int(np.count_nonzero(given_up))
            stays = ~(given_up | grown | self._died_out(alive, states))
            same = stays & (np.abs(sizes - before) < _SETTLED * sizes)
            unbounded |= self._survivors(alive, grown, self._begin[alive], sizes)
            settled |= self._survivors(alive, same, states, sizes)
            left = stays & ~same
            alive, states, sizes = alive[left], states[left], sizes[left]
        undecided += alive.size
        return SearchRound(
            levels=tuple(self._levels),
            starts=self._level.size,
            died_out=self._level.size - len(settled) - len(unbounded) - undecided,
            settled=tuple(settled[place] for place in sorted(settled)),
            unbounded=tuple(unbounded[place] for place in sorted(unbounded)),
            undecided=undecided,
            steps=self._steps,
            horizon=self._horizons[-1],
        )

    def _affordable(self, alive: Places, horizon: float) -> Places:
        # Those of the motions, the same number at every μ, whose steps the limit allows.
        if not self._steps:
            return np.arange(alive.size)
        cost = self._mean_rate * horizon
        most = max(int((self._most - self._steps) / (cost * LEVELS)), _FEWEST)
        turn = np.zeros(alive.size, dtype=np.int64)
        for level in range(LEVELS):
            here = self._level[alive] == level
            turn[here] = np.arange(np.count_nonzero(here))
        return np.flatnonzero(turn < most)

    def _run(self, alive: Places, states: Floats, horizon: float) -> _Ends:
        limit = max(_LEAST_LIMIT, (self._most - self._steps) // alive.size)
        ends = self._integrate(alive, states, horizon, limit)
        # What the others have left over goes to the motions of many steps.
        again = np.flatnonzero(ends.given_up)
        more = (self._most - self._steps) // max(again.size, 1)
        if again.size and more > 2 * limit:
            later = self._integrate(alive[again], states[again], horizon, more)
            for one, other in zip(ends, later, strict=True):
                one[again] = other
        return ends

    def _integrate(self, alive: Places, states: Floats, horizon: float, limit: int) -> _Ends:
        run = simulate_batch(
            {"mu": np.array(self._levels)[self._level[alive]]},
            base=self._p,
            t_end=horizon,
            tol=_TOL,
            separation=self._separation,
            start=states,
            require={"final", "peak", "steady"},
            max_steps=limit,
            progress=self._progress,
        )
        steps = int(run.steps.sum())
        self._steps += steps
        self._mean_rate = max(steps, 1) / (alive.size * horizon)
        large = np.maximum(self._first[alive], length_scale(self._p, separation=self._separation))
        over = np.maximum(run.peak.y_abs, run.peak.x_abs) > _UNBOUNDED * large
        return _Ends(
            run.final,
            run.steady.y_half_range,
            run.status == Status.STEP_LIMIT,
            over | (run.status == Status.OVERFLOW),
        )

    def _extent(self, states: Floats, level: Places) -> Floats:
        # Distances from the equilibrium, with velocities scaled by the slowest frequency.
        extent: Floats = np.linalg.norm((states - self._rest[level]) * self._scale, axis=1)
        return extent

    def _died_out(self, alive: Places, states: Floats) -> Flags:
        level = self._level[alive]
        at_rest = self._extent(states, level) <= _DIED_OUT * self._first[alive]
        for place, region in enumerate(self._regions):
            here = level == place
            at_rest[here] |= region.hold(states[here])
        return at_rest

    def _survivors(
        self, alive: Places, chosen: Flags, states: Floats, sizes: Floats
    ) -> dict[int, Survivor]:
        found = {}
        for at in np.flatnonzero(chosen).tolist():
            x, vx, y, vy = states[at].tolist()
            place = int(alive[at])
            mu = self._levels[self._level[place]]
            found[place] = Survivor(mu, (x, vx, y, vy), float(sizes[at]))
        return found
