"""Branches of twice the period."""

import numpy as np
import pytest

from fivtui import ComputationError, Parameters, branch
from fivtui.orbits.curves import cycle_branches
from fivtui.orbits.curves.arclength import OrbitOnCurve
from fivtui.orbits.curves.branch_curve import BranchCurve
from fivtui.orbits.curves.doubling import doubled_cycle
from fivtui.orbits.curves.events import End, EventKind

from .test_cycle_branches import assert_cycle_closes, random_sets

# Found by trial: the branch of the third of these random sets has two period doublings.
*_, WITH_DOUBLINGS = random_sets(count=3, seed=5)
WITHOUT_DOUBLINGS = Parameters()


def test_a_doubled_branch_joins_both_period_doublings(monkeypatch: pytest.MonkeyPatch) -> None:
    cycle_pairs = []

    def record_cycle(curve: BranchCurve, orbit: OrbitOnCurve) -> OrbitOnCurve | None:
        cycle = doubled_cycle(curve, orbit)
        cycle_pairs.append((orbit, cycle))
        return cycle

    monkeypatch.setattr(cycle_branches, "doubled_cycle", record_cycle)
    single = branch(WITH_DOUBLINGS, "mu", low=0.0, high=10.0)
    doublings = [event for event in single.events if event.kind is EventKind.PERIOD_DOUBLING]
    assert len(doublings) == 2
    doubled_branch = branch(WITH_DOUBLINGS, "mu", low=0.0, high=10.0, doubled=True)
    assert doubled_branch.doubled
    assert doubled_branch.ends == (End.DOUBLING, End.DOUBLING)
    assert doubled_branch.events[0] == doublings[0]
    assert doubled_branch.events[-1].kind is EventKind.PERIOD_DOUBLING
    assert doubled_branch.events[-1].value == pytest.approx(doublings[1].value, abs=1e-9)
    assert doubled_branch.events[-1].period == pytest.approx(doublings[1].period, rel=1e-9)
    assert doubled_branch.points[-1].value == pytest.approx(doublings[1].value, abs=1e-4)
    assert doubled_branch.points[0].period == pytest.approx(2.0 * doublings[0].period, rel=1e-2)
    assert {point.stable for point in doubled_branch.points} == {True, False}
    for point in doubled_branch.points[3::25]:
        assert_cycle_closes(doubled_branch, point)
    # Guesses deviate from the cycle along the eigenvector of the multiplier -1, first by 0.01 of
    # the cycle's size. This guess leads to the doubled cycle. Unknowns begin with the state.
    ((orbit, cycle),) = cycle_pairs
    assert cycle is not None
    state, doubled_state = orbit.unknowns[:4], cycle.unknowns[:4]
    distance = np.linalg.norm(doubled_state - state)
    assert distance == pytest.approx(0.01 * np.abs(state).max(), rel=1e-4)


def test_a_doubled_branch_does_not_return_along_itself() -> None:
    p = Parameters(m=4.5, k1=170.0, k2=140.0, k3=28.0, c1=1.1, c2=0.6, F=180.0, k_nl=33.0)
    curve = branch(p, "mu", low=0.0, high=12.0, doubled=True)
    assert curve.ends == (End.DOUBLING, End.DOUBLING)
    kinds = [event.kind for event in curve.events]
    assert kinds == [EventKind.PERIOD_DOUBLING, EventKind.FOLD, EventKind.PERIOD_DOUBLING]


def test_a_branch_without_a_period_doubling_raises_an_error() -> None:
    with pytest.raises(ComputationError, match="no period doubling was found along mu"):
        branch(WITHOUT_DOUBLINGS, "mu", low=0.2, high=1.0, doubled=True)
