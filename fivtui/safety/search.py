"""The global search: motions from many starts at many μ, followed until they decay or persist.

A search has rounds. The levels of a round are values of μ below the least μ at which an attractor
is known so far. A round follows its motions in stages of growing duration. The search is limited by
integration steps, not by time: every machine gives the same result.
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
from fivtui.orbits import DecayRegion, length_scale, reference_equilibrium, slowest_period
from fivtui.ranges import log_spaced
from fivtui.transient import MAX_T_END

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]

# Starts are Sobol points of five dimensions: direction of the state, and size of the disturbance.
START_DIMENSIONS: Final = 5
# Least and greatest size of a disturbance, in characteristic lengths.
_LEAST_SIZE: Final = 0.1
_GREATEST_SIZE: Final = 100.0
# Number of levels; the lowest and the highest, relative to the least μ of a known attractor.
LEVELS: Final = 16
_LOWEST_LEVEL: Final = 0.06
_HIGHEST_LEVEL: Final = 0.99
# Starts per level in full rounds, and in cheap scout rounds before them.
STARTS: Final = 128
SCOUT_STARTS: Final = 16
# Least number of motions per level that are followed near the limit of steps.
_MIN_MOTIONS: Final = 4
# Limit of integration steps of a round.
_MAX_STEPS: Final = 12_000_000
# Two durations of each stage, of which the longer one applies: in decay times of small disturbances
# at the level with the fastest decay, and in slowest periods.
_STAGES: Final = (
    (2.5, 50.0),
    (2.5, 50.0),
    (5.0, 50.0),
    (5.0, 50.0),
    (10.0, 50.0),
    (20.0, 50.0),
    (60.0, 100.0),
)
# Decay rates up to this value, relative to the fastest eigenvalue, count as zero: rounding.
_ZERO_DECAY: Final = 1e-12
# Motions are not followed if their decay takes longer than this, in slowest periods.
_PERIOD_LIMIT: Final = 20_000.0
# Share of the limit of steps that the starts of a round are planned to use.
_PLANNED_SHARE: Final = 0.8
# A system is stiff above this ratio of its highest to its lowest frequency.
_STIFF_RATIO: Final = 20.0
# Cost of a step of a stiff system in steps of others: its limit of steps is smaller by this factor.
_STIFF_STEP_COST: Final = 6
# Least limit of steps of one motion in a stage.
_MIN_STEP_LIMIT: Final = 2_000
_TOL: Final = 1e-6
# An extent is the distance of a state from the equilibrium. A motion counts as at rest, even
# without a proof of decay, if its extent is at most this fraction of that of its start.
_REST_EXTENT: Final = 1e-9
# A motion is unbounded above this multiple of its start extent and of the characteristic length.
_UNBOUNDED_GROWTH: Final = 1e6
# Decay rate, relative to that of small disturbances, below which a motion persists.
_SLOW_DECAY: Final = 0.5
# Relative change of amplitude in the last stage below which a persistent motion is steady.
_STEADY_CHANGE: Final = 0.1
# A motion persists at a lower μ if its half range is above this fraction of that at its own μ.
_PERSISTENT_SIZE: Final = 0.1
# Search for a least μ: intervals of μ in a refinement, and number of refinements.
_REFINED_INTERVALS: Final = 32
_REFINEMENTS: Final = 2
_Y: Final = 2


@dataclass(frozen=True, slots=True)
class Survivor:
    """A motion that did not die out: μ, state, and half peak-to-peak of y in m."""

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
        Number of motions that came to rest, or finally decay in contact like small disturbances.
    settled : tuple of Survivor
        Motions whose amplitude was steady in the last stage, by ascending μ.
    unbounded : tuple of Survivor
        Motions that grow without bounds, with their start states.
    undecided_at : tuple of int
        Number of undecided motions at each level: stopped by the limit of steps, or with an
        amplitude that still changes.
    steps, most_steps : int
        Integration steps of all motions, and their limit.
    horizon : float
        Duration of the last stage, s.
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
    # What has become of a motion in the search; `STOPPED` is by the limit of steps.
    MOVING = 0
    DIED_OUT = 1
    UNBOUNDED = 2
    STOPPED = 3


class _StageResults(NamedTuple):
    # Final states of motions in a stage, half peak-to-peak of y, and flags of their fates.
    states: Floats
    half_ranges: Floats
    stopped: Flags
    unbounded: Flags


class RunningRound:
    """One round of the search: motions from Sobol starts at evenly spaced μ, stage by stage.

    Each level below `mu_limit` has the same number of starts. If damping is too small for motions
    to come to rest, the round has no motions.
    """

    def __init__(
        self,
        system: System,
        mu_limit: float,
        starts: int,
        *,
        progress: OnProgress | None = None,
    ) -> None:
        self._system, self._progress = system, progress
        self._levels = (mu_limit * np.linspace(_LOWEST_LEVEL, _HIGHEST_LEVEL, LEVELS)).tolist()
        systems = [system.with_values({"mu": mu}) for mu in self._levels]
        self._regions = [_decay_region(at_mu) for at_mu in systems]
        self._growth_rates = np.array([region.growth for region in self._regions])
        self._slowest_period = slowest_period(system.parameters)
        fastest_decay = -self._growth_rates.min()
        self._durations = _stage_durations(fastest_decay, self._slowest_period)
        fastest_frequency = max(region.fastest for region in self._regions)
        is_stiff = fastest_frequency * self._slowest_period > _STIFF_RATIO * math.tau
        self._step_limit = _MAX_STEPS // (_STIFF_STEP_COST if is_stiff else 1)
        # Small disturbances fall below 1 % in the first two stages, five decay times or longer.
        decay_duration = sum(self._durations[:2])
        is_too_slow = decay_duration > _PERIOD_LIMIT * self._slowest_period
        decays = fastest_decay > _ZERO_DECAY * fastest_frequency
        count = starts if decays and not is_too_slow else 0
        # The first point of the sequence is its origin.
        points = Sobol(START_DIMENSIONS, scramble=False).fast_forward(1).random(count)
        starts_by_level = [disturbed_states(at_mu, points) for at_mu in systems]
        self._starts: Floats = np.concatenate(starts_by_level)
        self._level_of: Indices = np.repeat(np.arange(LEVELS), count)
        velocity_weight = self._slowest_period / math.tau
        self._weights = np.array([1.0, velocity_weight, 1.0, velocity_weight])
        self._rest_states = np.array([region.rest for region in self._regions])
        self._length_scale = length_scale(system)
        self._start_extents = self._extents(self._starts, self._level_of)
        self._states = self._starts.copy()
        self._half_ranges = np.full(len(self._starts), np.nan)
        # Logarithm of the ratio of amplitudes in the last two stages, by motion, and its value for
        # small disturbances, by level.
        self._log_ratios = np.full(len(self._starts), np.nan)
        self._expected_log_ratios = np.zeros(LEVELS)
        self._fates = np.zeros(len(self._starts), dtype=np.int64)
        # Index of the next stage, and integration steps so far.
        self._stage, self._steps = 0, 0

    def advance(self) -> bool:
        """Follow the moving motions for one stage; return False if no stage or motion remains."""
        moving = np.flatnonzero(self._fates == _Fate.MOVING)
        if self._stage == len(self._durations) or not moving.size:
            return False
        duration = self._durations[self._stage]
        followed = self._within_step_limit(moving, duration)
        self._fates[np.setdiff1d(moving, followed)] = _Fate.STOPPED
        if followed.size:
            self._follow(followed, duration)
        self._stage += 1
        return True

    def _follow(self, followed: Indices, duration: float) -> None:
        # Follow motions for a stage, and determine their fates.
        results = self._run_stage(followed, duration)
        previous_half_ranges = self._half_ranges[followed]
        self._states[followed], self._half_ranges[followed] = results.states, results.half_ranges
        with np.errstate(divide="ignore", invalid="ignore"):
            self._log_ratios[followed] = np.log(results.half_ranges / previous_half_ranges)
        if self._stage:
            # A half range is that of the second half of a stage, whose middle is at 3/4 of the
            # stage: add the rest of the previous stage and 3/4 of this one.
            time_between = 0.25 * self._durations[self._stage - 1] + 0.75 * duration
            self._expected_log_ratios = self._growth_rates * time_between
        self._fates[followed[self._rest_flags(followed)]] = _Fate.DIED_OUT
        self._fates[followed[results.unbounded]] = _Fate.UNBOUNDED
        self._fates[followed[results.stopped]] = _Fate.STOPPED

    def persistent_motions(self, per_level: int) -> list[Survivor]:
        """Motions whose amplitude decays too slowly to die out, by ascending μ.

        At each μ the steadiest ones, at most `per_level`.
        """
        survivors: list[Survivor] = []
        for level in range(LEVELS):
            motions = np.flatnonzero(self._persistent_flags() & (self._level_of == level))
            order = np.argsort(np.abs(self._log_ratios[motions]), kind="stable")
            survivors += self._survivors(motions[order[:per_level]], self._states)
        return survivors

    def unbounded_motions(self) -> list[Survivor]:
        """The motions that grow without bounds, with their start states, by ascending μ."""
        return self._survivors(np.flatnonzero(self._fates == _Fate.UNBOUNDED), self._starts)

    def result(self) -> SearchRound:
        """The results up to the current stage."""
        moving = self._fates == _Fate.MOVING
        steady = self._persistent_flags() & (np.abs(self._log_ratios) < _STEADY_CHANGE)
        expected = self._expected_log_ratios[self._level_of]
        decaying = moving & (self._log_ratios <= _SLOW_DECAY * expected)
        # A motion about the equilibrium stays in contact if its peak-to-peak is below the distance
        # of the equilibrium from y = 0.
        decaying &= self._half_ranges < 0.5 * np.abs(self._rest_states[self._level_of, _Y])
        if self._stage < len(self._durations):
            # Only the last stage is long enough to tell.
            steady[:] = decaying[:] = False
        undecided = (moving & ~steady & ~decaying) | (self._fates == _Fate.STOPPED)
        died_out = decaying | (self._fates == _Fate.DIED_OUT)
        return SearchRound(
            levels=tuple(self._levels),
            starts=self._level_of.size,
            died_out=int(np.count_nonzero(died_out)),
            settled=tuple(self._survivors(np.flatnonzero(steady), self._states)),
            unbounded=tuple(self.unbounded_motions()),
            undecided_at=tuple(np.bincount(self._level_of[undecided], minlength=LEVELS).tolist()),
            steps=self._steps,
            most_steps=self._step_limit,
            horizon=float(self._durations[-1]),
        )

    def _persistent_flags(self) -> Flags:
        # Whether motions decay more slowly than small disturbances.
        expected = self._expected_log_ratios[self._level_of]
        decays_slowly = self._log_ratios > _SLOW_DECAY * expected
        persists: Flags = (self._fates == _Fate.MOVING) & decays_slowly
        return persists

    def _within_step_limit(self, moving: Indices, duration: float) -> Indices:
        # As many motions as the limit of steps allows, the same number at every μ.
        if not self._steps:
            return moving
        steps_per_motion = self._step_rate * duration
        affordable = int((self._step_limit - self._steps) / (steps_per_motion * LEVELS))
        per_level = max(affordable, _MIN_MOTIONS)
        return np.concatenate(
            [moving[self._level_of[moving] == level][:per_level] for level in range(LEVELS)]
        )

    def _run_stage(self, followed: Indices, duration: float) -> _StageResults:
        # A motion may use twice its share of the steps that are left.
        limit = max(_MIN_STEP_LIMIT, 2 * (self._step_limit - self._steps) // followed.size)
        results = self._integrate_motions(followed, duration, limit)
        # Unused steps are available to motions that the limit stopped.
        stopped = np.flatnonzero(results.stopped)
        larger_limit = (self._step_limit - self._steps) // max(stopped.size, 1)
        if stopped.size and larger_limit > 2 * limit:
            repeated_results = self._integrate_motions(followed[stopped], duration, larger_limit)
            for values, repeated_values in zip(results, repeated_results, strict=True):
                values[stopped] = repeated_values
        return results

    def _integrate_motions(self, followed: Indices, duration: float, limit: int) -> _StageResults:
        run = simulate_batch(
            {"mu": np.array(self._levels)[self._level_of[followed]]},
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
        # Steps of one motion per second of its time.
        self._step_rate = max(steps, 1) / (followed.size * duration)
        scales = np.maximum(self._start_extents[followed], self._length_scale)
        unbounded = np.maximum(run.peak.y_abs, run.peak.x_abs) > _UNBOUNDED_GROWTH * scales
        return _StageResults(
            run.final,
            run.steady.y_half_range,
            run.status == Status.STEP_LIMIT,
            unbounded | (run.status == Status.OVERFLOW),
        )

    def _extents(self, states: Floats, levels: Indices) -> Floats:
        # Distances from the equilibrium; velocities are divided by the slowest angular frequency.
        deviations = (states - self._rest_states[levels]) * self._weights
        extents: Floats = np.linalg.norm(deviations, axis=1)
        return extents

    def _rest_flags(self, motions: Indices) -> Flags:
        # Whether motions are at rest, or are proven to decay.
        levels, states = self._level_of[motions], self._states[motions]
        at_rest = self._extents(states, levels) <= _REST_EXTENT * self._start_extents[motions]
        for level, region in enumerate(self._regions):
            at_level = levels == level
            at_rest[at_level] |= region.contains_states(states[at_level])
        return at_rest

    def _survivors(self, motions: Indices, states: Floats) -> list[Survivor]:
        # Motions with their μ and half ranges, and states of `states`.
        survivors = []
        for index in motions.tolist():
            x, vx, y, vy = states[index].tolist()
            mu = self._levels[self._level_of[index]]
            survivors.append(Survivor(mu, (x, vx, y, vy), float(self._half_ranges[index])))
        return survivors


def starts_within_limit(scouts: SearchRound) -> int:
    """Number of starts per level within the limit of steps, estimated from a scout round."""
    if not scouts.steps:
        return STARTS
    steps_per_start = scouts.steps / scouts.starts * LEVELS
    return min(STARTS, int(_PLANNED_SHARE * scouts.most_steps / steps_per_start))


def least_unbounded_mu(system: System, motion: Survivor, search_round: SearchRound) -> float:
    """The least μ from which on a motion grows without bounds, to 1/1000 of the level spacing."""
    index = search_round.levels.index(motion.mu)
    lower_mu = search_round.levels[index - 1] if index else 0.0
    scale = max(float(np.abs(motion.state).max()), length_scale(system))

    def grows(run: Batch) -> Flags:
        unbounded: Flags = np.maximum(run.peak.y_abs, run.peak.x_abs) > _UNBOUNDED_GROWTH * scale
        unbounded |= run.status == Status.OVERFLOW
        return unbounded

    return _least_mu_where(system, motion, grows, lower_mu, search_round.horizon)


def least_persistent_mu(system: System, motion: Survivor, low: float) -> float:
    """The least μ, from `low` up to that of a motion, at which the motion does not die out.

    The μ of the motion if damping is too small for motions to die out.
    """
    period = slowest_period(system.parameters)
    horizon = _stage_durations(-_decay_region(system.with_values({"mu": low})).growth, period)[-1]
    if horizon > _PERIOD_LIMIT * period:
        return motion.mu

    def persists(run: Batch) -> Flags:
        persistent: Flags = run.steady.y_half_range > _PERSISTENT_SIZE * motion.half_range
        return persistent

    return _least_mu_where(system, motion, persists, low, horizon)


def _least_mu_where(
    system: System,
    motion: Survivor,
    condition: Callable[[Batch], Flags],
    low: float,
    horizon: float,
) -> float:
    # The least μ from `low` on such that the condition is true from it up to the μ of the motion.
    high = motion.mu
    for _ in range(_REFINEMENTS):
        mus = np.linspace(low, high, _REFINED_INTERVALS + 1)
        run = simulate_batch(
            {"mu": mus[:-1]},
            base=system.parameters,
            t_end=horizon,
            tol=_TOL,
            separation=system.separation,
            start=motion.state,
            require={"peak", "steady"},
            max_steps=_MAX_STEPS // _REFINED_INTERVALS,
        )
        false_indices = np.flatnonzero(~condition(run))
        if not false_indices.size:
            return low
        index = int(false_indices[-1])
        low, high = float(mus[index]), float(mus[index + 1])
    return high


def _decay_region(system: System) -> DecayRegion:
    return DecayRegion(system, equilibrium(system))


def _stage_durations(decay_rate: float, period: float) -> list[float]:
    # Durations of the stages, s.
    decay_time = 1.0 / decay_rate if decay_rate > 0.0 else 0.0
    return [
        min(max(decay_times * decay_time, periods * period), MAX_T_END)
        for decay_times, periods in _STAGES
    ]


def disturbed_states(system: System, points: Floats) -> Floats:
    """Start states around the equilibrium, shape (n, 4), m and m/s, for n points of the unit cube.

    The size of a disturbance is between 0.1 and 100 characteristic lengths. It limits displacements
    and, times the slowest angular frequency, velocities.
    """
    rest = reference_equilibrium(system)
    frequency = 2.0 * math.pi / slowest_period(system.parameters)
    unit_states, unit_sizes = points[:, :4], points[:, 4]
    sizes = length_scale(system) * log_spaced(_LEAST_SIZE, _GREATEST_SIZE, unit_sizes)
    disturbances: Floats = (2.0 * unit_states - 1.0) * sizes[:, None]
    return disturbances * [1.0, frequency, 1.0, frequency] + [rest.x, 0.0, rest.y, 0.0]
