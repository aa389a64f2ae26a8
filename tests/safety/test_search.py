"""The global search: its starts, what becomes of motions, and its limit of work."""

import numpy as np
import pytest

from fivtui import Parameters, simulate
from fivtui.safety.search import LEVELS, least_growth, search_round
from fivtui.safety.starts import disturbed


def test_starts_are_around_the_equilibrium_in_all_directions() -> None:
    starts = disturbed(Parameters(F=0.0), 255, separation=True)
    assert np.all(np.sign(starts).min(axis=0) == -1.0)
    assert np.all(np.sign(starts).max(axis=0) == 1.0)
    size = np.abs(starts[:, 2])
    assert size.max() > 10.0 * np.median(size) > 100.0 * np.sort(size)[5]


def test_motions_that_stay_are_told_from_those_that_die_out() -> None:
    p = Parameters(F=120.0)
    found = search_round(p, 0.32, 4_000_000, separation=True, progress=None)
    assert found.died_out + len(found.settled) + found.undecided == found.starts
    levels = {one.mu for one in found.settled}
    assert levels == {mu for mu in found.levels if mu > 0.278}
    one = found.settled[-1]
    late = simulate(p.with_values({"mu": one.mu}), start=one.state, t_end=50.0)
    assert late.steady.y_half_range == pytest.approx(one.half_range, rel=1e-3)


def test_growth_without_bounds_is_found_with_the_friction_from_which_it_is() -> None:
    p = Parameters(F=1000.0)
    found = search_round(p, 3.0, 500_000, separation=True, progress=None)
    one = found.unbounded[0]
    mu = least_growth(p, one, found, separation=True)
    assert 1.0 < mu <= one.mu


def test_the_limit_of_steps_ends_motions() -> None:
    found = search_round(Parameters(m=1e-6), 0.2, 50_000, separation=True, progress=None)
    assert found.undecided > 0
    assert found.steps < 500_000
    assert len(found.levels) == LEVELS
