"""The global search: its starts, how it classifies motions, and its limit of steps.

Motions are followed in stages. A motion persists while its amplitude decays too slowly to die out.
It has settled if its amplitude was steady in the last stage.
"""

import numpy as np
import pytest
from scipy.stats.qmc import Sobol

from fivtui import Parameters, simulate
from fivtui.model import System
from fivtui.safety import search
from fivtui.safety.search import (
    LEVELS,
    SCOUT_STARTS,
    STARTS,
    RunningRound,
    SearchRound,
    disturbed_states,
    least_unbounded_mu,
    starts_within_limit,
)


def run_to_end(motions: RunningRound) -> SearchRound:
    while motions.advance():
        pass
    return motions.result()


def test_starts_are_around_the_equilibrium_in_all_directions() -> None:
    points = Sobol(5, scramble=False).random(256)[1:]
    starts = disturbed_states(System(Parameters(F=0.0)), points)
    assert np.all(np.sign(starts).min(axis=0) == -1.0)
    assert np.all(np.sign(starts).max(axis=0) == 1.0)
    # Sizes span orders of magnitude. A few are smaller still, or zero, by their direction.
    y_sizes = np.sort(np.abs(starts[:, 2]))
    least, median, greatest = y_sizes[5], np.median(y_sizes), y_sizes[-1]
    assert greatest > 10.0 * median
    assert median > 10.0 * least


def test_persistent_and_decaying_motions_are_distinguished() -> None:
    p = Parameters(F=120.0)
    result = run_to_end(RunningRound(System(p), mu_limit=0.32, starts=32))
    assert result.died_out + len(result.settled) + result.undecided == result.starts
    # Limit cycles exist from the fold at μ = 0.2779 on.
    levels = {motion.mu for motion in result.settled}
    assert levels == {mu for mu in result.levels if mu > 0.278}
    settled_motion = result.settled[-1]
    continued = simulate(
        p.with_values({"mu": settled_motion.mu}), start=settled_motion.state, t_end=50.0
    )
    assert continued.steady.y_half_range == pytest.approx(settled_motion.half_range, rel=1e-3)


def test_persistent_motions_are_sorted_by_change_of_amplitude() -> None:
    # The steadiest motion is that whose amplitude changed least from the stage before.
    motions = RunningRound(System(Parameters(F=120.0)), mu_limit=0.32, starts=32)
    assert motions.advance()
    assert motions.advance()
    highest_mu = motions.result().levels[-1]
    steadiest, *rest = (
        motion for motion in motions.persistent_motions(32) if motion.mu == highest_mu
    )
    assert len(rest) > 3
    assert [motion for motion in motions.persistent_motions(1) if motion.mu == highest_mu] == [
        steadiest
    ]
    # All motions reach the cycle; the steadiest is nearest to it.
    while motions.advance():
        pass
    cycle = motions.persistent_motions(1)[-1].half_range
    distances = [abs(motion.half_range - cycle) for motion in (steadiest, *rest)]
    assert distances[0] < 0.1 * max(distances)


def test_unbounded_growth_is_found_with_its_least_friction() -> None:
    p = Parameters(F=1000.0)
    result = run_to_end(RunningRound(System(p), mu_limit=3.0, starts=8))
    motion = result.unbounded[0]
    mu = least_unbounded_mu(System(p), motion, result)
    assert 1.0 < mu <= motion.mu


def test_motions_stopped_by_the_limit_of_steps_are_undecided(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(search, "_MAX_STEPS", 200_000)
    p = Parameters(c1=0.01, c2=0.01)
    result = run_to_end(RunningRound(System(p), mu_limit=0.27, starts=4))
    assert result.undecided > 0.5 * result.starts
    # The limit of the round is `_MAX_STEPS`, less if the system is stiff. The sum of steps may
    # exceed it: a motion may use twice its share.
    assert result.steps < 3 * result.most_steps
    assert len(result.levels) == len(result.undecided_at) == LEVELS


def test_the_number_of_starts_follows_from_the_steps_of_scouts() -> None:
    for p, fewer in ((Parameters(), False), (Parameters(c1=0.03, c2=0.03), True)):
        scouts = run_to_end(RunningRound(System(p), mu_limit=0.27, starts=SCOUT_STARTS))
        starts = starts_within_limit(scouts)
        assert SCOUT_STARTS < starts <= STARTS
        assert (starts < STARTS) is fewer
        assert scouts.steps * starts / SCOUT_STARTS <= scouts.most_steps
