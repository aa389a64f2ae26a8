"""Maps of safe friction against single branches, verdicts and escape offsets; their files.

Below safe μ no disturbance leads to vibration. In the region of coexistence the equilibrium is
stable, but a knock, a large disturbance, leads to a limit cycle: squeal. The escape offset is the
least vertical displacement from rest that does so. A verdict is the result of a global search for
safe μ at one point. A fold stabilises if μ has a minimum there, beyond which cycles attract.
"""

from pathlib import Path

import numpy as np
import pytest

from fivtui import (
    Cancelled,
    ComputationError,
    InputError,
    Parameters,
    branch,
    safe_friction,
    safety_map,
    stability,
)
from fivtui.maps import StabilityMap
from fivtui.maps.result import KNOCK_REGION, SAFE_REGION, SQUEAL_REGION
from fivtui.model import System
from fivtui.orbits.basins import escape_offset
from fivtui.orbits.boundaries.fold_orbits import fold_near, stabilising_folds
from fivtui.studies import load_study, save_study


@pytest.fixture(scope="module")
def preload_map() -> StabilityMap:
    return safety_map(None, {"F": np.linspace(20.0, 140.0, 5), "k_nl": [80.0, 100.0]})


@pytest.fixture(scope="module")
def coexistence_map() -> StabilityMap:
    over = {"mu": [0.2, 0.5, 0.7, 0.9], "F": [100.0, 120.0]}
    return safety_map(None, over, "coexistence")


def test_the_safe_friction_of_each_point_is_the_least_fold_of_its_branch(
    preload_map: StabilityMap,
) -> None:
    for row, F in enumerate(preload_map.axes[0].tolist()):
        p = Parameters(F=F)
        critical = stability(p).critical_mu[0].mu
        curve = branch(p, "mu", low=0.0, high=1.5 * critical)
        least = min([critical, *(fold.mu for fold in stabilising_folds(curve))])
        assert preload_map.safe_mu[row, 1] == pytest.approx(least, rel=1e-8)
        assert preload_map.critical_mu[row, 1] == pytest.approx(critical, rel=1e-12)


@pytest.mark.parametrize(
    ("values", "over", "separation", "searched"),
    [
        ({}, {}, True, True),
        ({"c1": 0.0}, {}, True, True),
        ({"c2": 0.0}, {}, True, True),
        # Without dampers no motion decays.
        ({"c1": 0.0, "c2": 0.0}, {}, True, False),
        ({"c1": 0.0, "c2": 0.0}, {"c1": [0.1, 0.2]}, True, True),
        ({"c1": 0.0, "c2": 0.0}, {"c2": [0.1, 0.2]}, True, True),
        # The contact spring is linear.
        ({"k_nl": 0.0}, {}, False, False),
        ({"k_nl": 0.0}, {}, True, True),
        ({"k_nl": 0.0}, {"k_nl": [50.0, 100.0]}, False, True),
        ({}, {}, False, True),
    ],
)
def test_cycles_are_searched_if_motions_are_damped_and_not_linear(
    values: dict[str, float],
    over: dict[str, list[float]],
    separation: bool,
    searched: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    searches = []

    def refuse_search(p: Parameters, **_: object) -> None:
        searches.append(p)
        raise ComputationError("not searched", "this is a test")

    monkeypatch.setattr("fivtui.maps.safety.safe_friction", refuse_search)
    axes = {"F": [60.0, 80.0], **(over or {"k1": [90.0, 100.0]})}
    safety_map(Parameters(**values), axes, separation=separation)
    assert bool(searches) is searched


def test_a_fold_is_followed_over_many_points_from_few_branches() -> None:
    result = safety_map(None, {"F": np.linspace(60.0, 150.0, 46), "c1": np.array([0.32])})
    assert result.safe_mu[10, 0] == pytest.approx(0.277876613, abs=1e-8)
    assert result.safe_mu[30, 0] == pytest.approx(0.277935093, abs=1e-8)
    assert not np.isnan(result.safe_mu).any()


def test_folds_at_which_mu_has_a_maximum_do_not_bound_safe_friction() -> None:
    curve = branch(Parameters(F=30.0), "mu", low=0.0, high=0.6)
    values = [event.value for event in curve.events if event.kind == "fold"]
    assert len(values) == 2
    (fold,) = stabilising_folds(curve)
    assert fold.mu == pytest.approx(min(values), abs=1e-9)
    # Both folds meet in a cusp; beyond it there is no fold.
    assert fold_near(System(Parameters(F=44.0)), fold) is None


def test_regions_follow_from_the_friction_and_offsets_from_transients(
    coexistence_map: StabilityMap,
) -> None:
    assert coexistence_map.regions.tolist() == [
        [SAFE_REGION, SAFE_REGION],
        [KNOCK_REGION, KNOCK_REGION],
        [SQUEAL_REGION, KNOCK_REGION],
        [SQUEAL_REGION, SQUEAL_REGION],
    ]
    assert coexistence_map.escape is not None
    coexists = coexistence_map.regions == KNOCK_REGION
    assert np.array_equal(np.isnan(coexistence_map.escape), ~coexists)
    for row, column in np.argwhere(coexists).tolist():
        p = Parameters(mu=coexistence_map.axes[0][row], F=coexistence_map.axes[1][column])
        # Offsets above and below rest, both positive; the map has the lesser one.
        exact = escape_offset(System(p))
        assert exact is not None
        offsets = [offset for offset in (exact.up, exact.down) if offset is not None]
        assert coexistence_map.escape[row, column] == pytest.approx(min(offsets), rel=0.04)


def test_figures_and_text_state_the_basis_of_safe_mu(
    preload_map: StabilityMap, coexistence_map: StabilityMap
) -> None:
    for result in (preload_map, coexistence_map):
        (axes, *_) = result.figure().axes
        assert "by continuation, and a global search at" in axes.get_title()
    # The search is made at the four corners and the centre of the map.
    assert "continuation, and a global search at 5 points" in repr(preload_map)


@pytest.mark.parametrize(
    ("over", "value", "message"),
    [
        ({"F": [1.0, 2.0], "mu": [0.1, 0.2]}, "safe-mu", "does not depend on mu"),
        ({"F": [1.0, 2.0], "k1": [1.0, 2.0]}, "safe", "unknown map value"),
        ({"F": [1.0, 2.0]}, "safe-mu", "must be two"),
        ({"F": np.ones(1000), "k1": np.ones(1000)}, "safe-mu", "at most 250000"),
    ],
)
def test_maps_that_cannot_be_computed_are_refused(
    over: dict[str, list[float]], value: str, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        safety_map(None, over, value)


def test_safe_friction_without_damping_is_the_critical_friction() -> None:
    undamped = safety_map(Parameters(c1=0.0, c2=0.0), {"F": [80.0, 90.0], "k1": [90.0, 100.0]})
    assert np.array_equal(undamped.safe_mu, undamped.critical_mu)


def test_cycles_that_only_a_global_search_finds_are_in_the_map() -> None:
    # F < 0 lifts the slider: no μ is critical there, and continuation has no Hopf point to start
    # from. With k3 = 0 there is no equilibrium.
    lifted = safety_map(None, {"F": [-20.0, -10.0], "k3": [0.0, 60.0]}, "coexistence")
    assert np.isnan(lifted.safe_mu).tolist() == [[True, False], [True, False]]
    for row, F in enumerate((-20.0, -10.0)):
        searched_mu = safe_friction(Parameters(F=F)).safe_mu
        assert lifted.safe_mu[row, 1] == pytest.approx(searched_mu, rel=1e-8)
    assert lifted.regions[:, 1].tolist() == [KNOCK_REGION, KNOCK_REGION]


def test_safe_friction_is_not_known_where_the_search_does_not_confirm_continuation(
    tmp_path: Path,
) -> None:
    # With a linear contact spring large motions grow without bounds from μ = 0.61 on. A search
    # confirms safe μ only up to there, but continuation gives the critical μ, 1.02.
    over = {"F": [60.0, 80.0], "mu": [0.5, 0.7, 1.1]}
    result = safety_map(Parameters(k_nl=0.0), over, "coexistence")
    assert np.isnan(result.safe_mu).all()
    assert result.unknown.all()
    # Safe μ is not known, but every μ up to 0.61 is safe.
    assert result.regions[:, 0].tolist() == [SAFE_REGION, SAFE_REGION]
    assert np.isnan(result.regions[:, 1]).all()
    assert result.regions[:, 2].tolist() == [SQUEAL_REGION, SQUEAL_REGION]
    assert "not known at 6 points" in repr(result)
    path = tmp_path / "map.csv"
    save_study("map", result, path)
    loaded = load_study("map", path)
    assert isinstance(loaded, StabilityMap)
    # The points of the searches, with the μ up to which each confirms safe μ.
    assert loaded.searched == result.searched
    assert np.array_equal(loaded.regions, result.regions, equal_nan=True)


@pytest.mark.parametrize("stop", [0.0, 0.05, 0.5])
def test_a_map_is_cancelled(stop: float) -> None:
    over = {"F": [100.0, 120.0], "mu": [0.4, 0.5]}
    with pytest.raises(Cancelled):
        safety_map(None, over, "coexistence", progress=lambda fraction: fraction < stop)
