"""The global search: motions from many starts at many μ, followed until they decay or persist.

Integration steps limit the search instead of time, so that every machine gives the same result.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats.qmc import Sobol

from fivtui.batch import Batch, simulate_batch
from fivtui.kernel import Status
from fivtui.model import OnProgress, System, equilibrium
from fivtui.orbits import DecayRegion, length_scale, slowest_period
from fivtui.transient import MAX_T_END

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]

# Sobol points of starts: dimensions, smallest disturbance in characteristic lengths, and decades.
_DIMENSIONS: Final = 5
_SMALLEST: Final = 0.1
_DECADES: Final = 3.0
# Values of μ in a round; lowest and highest relative to the least known μ; starts per value, and
# starts of the scouts, which lower the least μ cheaply.
LEVELS: Final = 16
_LOWEST: Final = 0.06
_HIGHEST: Final = 0.99
STARTS: Final = 128
SCOUTS: Final = 16
_FEWEST: Final = 4
# Integration steps of a round.
_MOST_STEPS: Final = 12_000_000
# Duration of each stage: decay times of small disturbances at the fastest decay, and the minimum in
# slowest periods.
_STAGES: Final = (
    (2.5, 50.0),
    (2.5, 50.0),
    (5.0, 50.0),
    (5.0, 50.0),
    (10.0, 50.0),
    (20.0, 50.0),
    (60.0, 100.0),
)
# Decay rate, relative to the fastest eigenvalue, that is zero to rounding.
_NEUTRAL: Final = 1e-12
# Motions that need more periods than this to decay are not followed.
_MOST_PERIODS: Final = 20_000.0
# Expected steps of a round, relative to the limit.
_EXPECTED_COST: Final = 0.8
# Ratio of frequencies above which a system is stiff, and divisor of its limit of steps, as its
# steps cost more.
_STIFF: Final = 20.0
_PART_IF_STIFF: Final = 6
# Steps that every motion may take, however many motions there are.
_LEAST_LIMIT: Final = 2_000
_TOL: Final = 1e-6
# Relative extent below which a motion is at rest, even without proven decay.
_DIED_OUT: Final = 1e-9
# Growth, relative to the first extent and every length of the system, of an unbounded motion.
_UNBOUNDED: Final = 1e6
# Decay rate, relative to that of small disturbances, below which a motion persists.
_SLOW_DECAY: Final = 0.5
# Relative change of amplitude in the last stage below which a persisting motion is steady.
_STEADY: Final = 0.1
# Half peak-to-peak, relative to a cycle's, above which a motion persists at lower μ.
_STAYS: Final = 0.1
# Values of μ in a search for the least one, and number of refinements.
_BETWEEN: Final = 32
_REFINEMENTS: Final = 2


@dataclass(frozen=True, slots=True)
class Survivor:
    """A motion that did not die out: its μ, its last state, its half peak-to-peak of y, m."""

    mu: float
    state: tuple[float, float, float, float]
    half_range: float


@dataclass(frozen=True, slots=True)
class SearchRound:
    """Results of one round of the search.

    Attributes
    ----------
    levels : tuple of float
        The values of μ, ascending.
    starts : int
        Number of motions.
    died_out : int
        Those that came to rest, or that finally decay in contact like small disturbances.
    settled : tuple of Survivor
        Those whose amplitude was steady to the end, by ascending μ.
    unbounded : tuple of Survivor
        Those that grow without bounds, with their start states.
    undecided_at : tuple of int
        Number of undecided motions at each level: the limit of steps ended them, or their amplitude
        still changed.
    steps, most_steps : int
        Integration steps of all motions, and their limit.
    horizon : float
        Duration of the longest motions, s.
    """

    levels: tuple[float, ...]
    starts: int
    died_out: int
    settled: tuple[Survivor, ...]
    unbounded: tuple[Survivor, ...]
    undecided_at: tuple[int, ...]
    steps: int
    most_steps: int
    horizon: float

    @property
    def undecided(self) -> int:
        """Number of undecided motions."""
        return sum(self.undecided_at)


class _Fate(IntEnum):
    # Status of a motion.
    MOVES = 0
    DIED_OUT = 1
    UNBOUNDED = 2
    GIVEN_UP = 3


class _Ends(NamedTuple):
    # Final states, half peak-to-peak of y, flags of the limit of steps and of unbounded growth.
    states: Floats
    sizes: Floats
    given_up: Flags
    grown: Flags


class Round:
    """One round of the search: motions from Sobol starts at evenly spaced μ, stage by stage.

    No motion is followed if damping is too small for motions to come to rest.
    """

    def __init__(
        self,
        system: System,
        top: float,
        starts: int,
        *,
        progress: OnProgress | None = None,
    ) -> None:
        self._system, self._progress = system, progress
        self._levels = (top * np.linspace(_LOWEST, _HIGHEST, LEVELS)).tolist()
        sets = [system.with_values({"mu": mu}) for mu in self._levels]
        self._regions = [_attraction(at) for at in sets]
        self._growth = np.array([region.growth for region in self._regions])
        self._period = slowest_period(system.parameters)
        self._durations = _durations(-self._growth.min(), self._period)
        fastest, decay = max(region.fastest for region in self._regions), -self._growth.min()
        stiff = fastest * self._period > _STIFF * math.tau
        self._step_limit = _MOST_STEPS // (_PART_IF_STIFF if stiff else 1)
        too_slow = sum(self._durations[:2]) > _MOST_PERIODS * self._period
        count = 0 if too_slow or decay <= _NEUTRAL * fastest else starts
        begin = [disturbed(at, count) for at in sets]
        self._begin: Floats = np.concatenate(begin)
        self._level: Indices = np.repeat(np.arange(LEVELS), count)
        scale = self._period / math.tau
        self._scale = np.array([1.0, scale, 1.0, scale])
        self._rest = np.array([region.rest for region in self._regions])
        self._length = length_scale(system)
        self._extent_at_start = self._extent(self._begin, self._level)
        self._states = self._begin.copy()
        self._sizes = np.full(len(self._begin), np.nan)
        # Logarithm of the ratio of amplitudes of two stages, and its value for the decay of small
        # disturbances.
        self._change = np.full(len(self._begin), np.nan)
        self._expected = np.zeros(LEVELS)
        self._fate = np.zeros(len(self._begin), dtype=np.int64)
        self._stage, self._steps = 0, 0

    def advance(self) -> bool:
        """Follow the moving motions for one stage; False if no stage or no motion remains."""
        moving = np.flatnonzero(self._fate == _Fate.MOVES)
        if self._stage == len(self._durations) or not moving.size:
            return False
        duration = self._durations[self._stage]
        followed = self._affordable(moving, duration)
        self._fate[np.setdiff1d(moving, followed)] = _Fate.GIVEN_UP
        if followed.size:
            self._follow(followed, duration)
        self._stage += 1
        return True

    def _follow(self, followed: Indices, duration: float) -> None:
        ends = self._run(followed, duration)
        before = self._sizes[followed]
        self._states[followed], self._sizes[followed] = ends.states, ends.sizes
        with np.errstate(divide="ignore", invalid="ignore"):
            self._change[followed] = np.log(ends.sizes / before)
        if self._stage:
            # Amplitudes are taken over the second halves of the stages.
            between = 0.25 * self._durations[self._stage - 1] + 0.75 * duration
            self._expected = self._growth * between
        self._fate[followed[self._at_rest(followed)]] = _Fate.DIED_OUT
        self._fate[followed[ends.grown]] = _Fate.UNBOUNDED
        self._fate[followed[ends.given_up]] = _Fate.GIVEN_UP

    def persisting(self, per_level: int) -> list[Survivor]:
        """Motions whose amplitude decays too slowly to die out, by ascending μ.

        At most `per_level` at each μ, those of steadiest amplitude first.
        """
        chosen: list[Survivor] = []
        for level in range(LEVELS):
            motions = np.flatnonzero(self._persists() & (self._level == level))
            order = np.argsort(np.abs(self._change[motions]), kind="stable")
            chosen += self._survivors(motions[order[:per_level]], self._states)
        return chosen

    def unbounded(self) -> list[Survivor]:
        """The motions that grow without bounds, with their start states, by ascending μ."""
        return self._survivors(np.flatnonzero(self._fate == _Fate.UNBOUNDED), self._begin)

    def result(self) -> SearchRound:
        """The results up to the current stage."""
        moving = self._fate == _Fate.MOVES
        steady = self._persists() & (np.abs(self._change) < _STEADY)
        decaying = moving & (self._change <= _SLOW_DECAY * self._expected[self._level])
        decaying &= self._sizes < 0.5 * np.abs(self._rest[self._level, 2])
        if self._stage < len(self._durations):
            steady[:] = decaying[:] = False
        undecided = (moving & ~steady & ~decaying) | (self._fate == _Fate.GIVEN_UP)
        died_out = decaying | (self._fate == _Fate.DIED_OUT)
        return SearchRound(
            levels=tuple(self._levels),
            starts=self._level.size,
            died_out=int(np.count_nonzero(died_out)),
            settled=tuple(self._survivors(np.flatnonzero(steady), self._states)),
            unbounded=tuple(self.unbounded()),
            undecided_at=tuple(np.bincount(self._level[undecided], minlength=LEVELS).tolist()),
            steps=self._steps,
            most_steps=self._step_limit,
            horizon=float(self._durations[-1]),
        )

    def _persists(self) -> Flags:
        slow = self._change > _SLOW_DECAY * self._expected[self._level]
        persists: Flags = (self._fate == _Fate.MOVES) & slow
        return persists

    def _affordable(self, moving: Indices, duration: float) -> Indices:
        # The motions that the limit of steps allows, the same number at every μ.
        if not self._steps:
            return moving
        cost = self._mean_rate * duration
        per_level = max(int((self._step_limit - self._steps) / (cost * LEVELS)), _FEWEST)
        return np.concatenate(
            [moving[self._level[moving] == level][:per_level] for level in range(LEVELS)]
        )

    def _run(self, followed: Indices, duration: float) -> _Ends:
        limit = max(_LEAST_LIMIT, 2 * (self._step_limit - self._steps) // followed.size)
        ends = self._integrate(followed, duration, limit)
        # Unused steps go to the motions that need more.
        again = np.flatnonzero(ends.given_up)
        longer_limit = (self._step_limit - self._steps) // max(again.size, 1)
        if again.size and longer_limit > 2 * limit:
            later = self._integrate(followed[again], duration, longer_limit)
            for values, longer in zip(ends, later, strict=True):
                values[again] = longer
        return ends

    def _integrate(self, followed: Indices, duration: float, limit: int) -> _Ends:
        run = simulate_batch(
            {"mu": np.array(self._levels)[self._level[followed]]},
            base=self._system.parameters,
            t_end=duration,
            tol=_TOL,
            separation=self._system.separation,
            start=self._states[followed],
            require={"final", "peak", "steady"},
            max_steps=limit,
            progress=self._progress,
        )
        steps = int(run.steps.sum())
        self._steps += steps
        self._mean_rate = max(steps, 1) / (followed.size * duration)
        large = np.maximum(self._extent_at_start[followed], self._length)
        over = np.maximum(run.peak.y_abs, run.peak.x_abs) > _UNBOUNDED * large
        return _Ends(
            run.final,
            run.steady.y_half_range,
            run.status == Status.STEP_LIMIT,
            over | (run.status == Status.OVERFLOW),
        )

    def _extent(self, states: Floats, level: Indices) -> Floats:
        # Distances from the equilibrium, with velocities scaled by the slowest frequency.
        extent: Floats = np.linalg.norm((states - self._rest[level]) * self._scale, axis=1)
        return extent

    def _at_rest(self, motions: Indices) -> Flags:
        level, states = self._level[motions], self._states[motions]
        at_rest = self._extent(states, level) <= _DIED_OUT * self._extent_at_start[motions]
        for index, region in enumerate(self._regions):
            at_level = level == index
            at_rest[at_level] |= region.contains_states(states[at_level])
        return at_rest

    def _survivors(self, motions: Indices, states: Floats) -> list[Survivor]:
        survivors = []
        for index in motions.tolist():
            x, vx, y, vy = states[index].tolist()
            mu = self._levels[self._level[index]]
            survivors.append(Survivor(mu, (x, vx, y, vy), float(self._sizes[index])))
        return survivors


def starts_within_limit(scouts: SearchRound) -> int:
    """Starts per μ within the limit of steps, estimated from the steps of scouts."""
    if not scouts.steps:
        return STARTS
    steps = scouts.steps / scouts.starts * LEVELS
    return min(STARTS, int(_EXPECTED_COST * scouts.most_steps / steps))


def least_growth(system: System, motion: Survivor, ended: SearchRound) -> float:
    """The least μ, to a thousandth of a level, from which a motion's start grows without bounds."""
    index = ended.levels.index(motion.mu)
    low = ended.levels[index - 1] if index else 0.0
    length = max(float(np.abs(motion.state).max()), length_scale(system))

    def grows(run: Batch) -> Flags:
        over: Flags = np.maximum(run.peak.y_abs, run.peak.x_abs) > _UNBOUNDED * length
        over |= run.status == Status.OVERFLOW
        return over

    return _least_holding_mu(system, motion, (low, ended.horizon), grows)


def least_staying(system: System, motion: Survivor, low: float) -> float:
    """The least μ, between `low` and the motion's, at which a motion does not die out.

    The motion's own μ if damping is too small for motions to die out.
    """
    period = slowest_period(system.parameters)
    horizon = _durations(-_attraction(system.with_values({"mu": low})).growth, period)[-1]
    if horizon > _MOST_PERIODS * period:
        return motion.mu

    def stays(run: Batch) -> Flags:
        staying: Flags = run.steady.y_half_range > _STAYS * motion.half_range
        return staying

    return _least_holding_mu(system, motion, (low, horizon), stays)


def _least_holding_mu(
    system: System,
    motion: Survivor,
    span: tuple[float, float],
    holds: Callable[[Batch], Flags],
) -> float:
    # The least μ such that `holds` is true from there up to the μ of the motion.
    (low, horizon), high = span, motion.mu
    for _ in range(_REFINEMENTS):
        mu = np.linspace(low, high, _BETWEEN + 1)
        run = simulate_batch(
            {"mu": mu[:-1]},
            base=system.parameters,
            t_end=horizon,
            tol=_TOL,
            separation=system.separation,
            start=motion.state,
            require={"peak", "steady"},
            max_steps=_MOST_STEPS // _BETWEEN,
        )
        failing = np.flatnonzero(~holds(run))
        index = int(failing[-1]) if failing.size else 0
        low, high = float(mu[index]), float(mu[index + 1]) if failing.size else low
    return high


def _attraction(system: System) -> DecayRegion:
    return DecayRegion(system, equilibrium(system))


def _durations(decay: float, period: float) -> list[float]:
    # Durations of the stages in s.
    time = 1.0 / decay if decay > 0.0 else 0.0
    return [min(max(decays * time, periods * period), MAX_T_END) for decays, periods in _STAGES]


def disturbed(system: System, count: int) -> Floats:
    """Start states around the equilibrium, shape (count, 4), m and m/s.

    Displacements are up to a size between 0.1 and 100 characteristic lengths, velocities up to
    that size times the slowest angular frequency.
    """
    # The first point of the sequence is its origin.
    points = Sobol(_DIMENSIONS, scramble=False).fast_forward(1).random(count)
    rest = equilibrium(system)
    speed = 2.0 * math.pi / slowest_period(system.parameters)
    size = length_scale(system) * _SMALLEST * 10.0 ** (_DECADES * points[:, 4])
    away: Floats = (2.0 * points[:, :4] - 1.0) * size[:, None]
    return away * [1.0, speed, 1.0, speed] + [rest.x, 0.0, rest.y, 0.0]
