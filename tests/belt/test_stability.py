"""Tests of the stability of sliding on a belt of finite speed."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

from fivtui import Parameters, stability, stability_map, sweep
from fivtui.equilibrium import belt
from fivtui.equilibrium.belt import critical_mu_on_belt, critical_speeds
from fivtui.equilibrium.eigenvalues import growth_and_stability
from fivtui.model import System, field
from fivtui.model.errors import ComputationError
from fivtui.model.field import depends_on_speed, friction_coefficient
from fivtui.model.slider_belt import State, accelerations, equilibrium, jacobian

from .test_model import belts

# Without coupling only the motion along the belt can lose stability.
UNCOUPLED = Parameters(
    k3=0.0, c1=10.0, c2=5.0, mu=0.3, mu_s=0.5, v_s=0.4, v_belt=0.4, F=80.0, k_nl=100.0
)
# Unstable at small and at large mu, stable between two critical values.
TWO_CRITICAL_MUS = Parameters(
    k3=75.4, c1=8.025, c2=1.26, F=52.4, k_nl=187.0, mu=0.2, v_belt=0.868, mu_s=0.719, v_s=0.635
)
# F < 0: the contact is in tension, with separation ignored.
THREE_CRITICAL_SPEEDS = Parameters(
    m=4.911,
    k1=135.3,
    k2=66.63,
    k3=85.12,
    c1=0.02,
    c2=1.264,
    F=-33.59,
    k_nl=0.0,
    mu=0.9177,
    mu_s=1.9584,
    v_s=0.1144,
    v_belt=0.6293,
)


def test_without_coupling_the_critical_speed_is_that_in_closed_form() -> None:
    expected = 0.4 * math.log(80.0 * (0.5 - 0.3) / (10.0 * 0.4))
    (critical,) = stability(UNCOUPLED).critical_speed
    assert critical.v_belt == pytest.approx(expected, rel=1e-14)
    assert critical.becomes == "stable"
    for factor in (0.999, 1.001):
        neighbour = UNCOUPLED.with_values({"v_belt": expected * factor})
        assert stability(neighbour).stable == (factor > 1.0)
    assert stability(UNCOUPLED.with_values({"c1": 100.0})).critical_speed == ()
    assert stability(UNCOUPLED.with_values({"v_s": None})).critical_speed == ()


def test_with_coupling_critical_speeds_are_where_the_growth_rate_changes_sign() -> None:
    coupled = UNCOUPLED.with_values({"k3": 60.0, "mu": 0.2, "mu_s": 0.4})
    critical_speed = stability(coupled).critical_speed
    assert critical_speed
    for critical in critical_speed:
        before, after = (
            stability(coupled.with_values({"v_belt": critical.v_belt * factor}))
            for factor in (1.0 - 1e-6, 1.0 + 1e-6)
        )
        assert before.growth_rate * after.growth_rate < 0.0
        assert after.stable == (critical.becomes == "stable")


def test_every_critical_mu_is_listed_where_friction_falls_with_the_speed() -> None:
    # Stability is lost by falling friction at small μ and by mode coupling at large μ.
    p = TWO_CRITICAL_MUS
    critical_values = stability(p).critical_mu
    mus = np.linspace(0.0, 0.719, 201)
    stable = [growth_and_stability(System(p.with_values({"mu": float(mu)})))[1] for mu in mus]
    changes = [
        (float(mus[n]), float(mus[n + 1]), "stable" if stable[n + 1] else "unstable")
        for n in range(200)
        if stable[n] != stable[n + 1]
    ]
    assert len(critical_values) == len(changes) == 2
    for critical, (low, high, becomes) in zip(critical_values, changes, strict=True):
        assert low <= critical.mu <= high
        assert critical.becomes == becomes


def test_critical_mus_that_nearly_merge_are_both_listed() -> None:
    # With less damping there is no critical μ; the gap between the two falls with the root of the
    # excess of c1 over that limit.
    p = TWO_CRITICAL_MUS
    merging_c1 = 7.677906964971566
    assert critical_mu_on_belt(System(p.with_values({"c1": merging_c1 - 1e-9}))) == ()
    gaps = []
    for excess in (1e-5, 1e-7, 1e-9):
        neighbour = p.with_values({"c1": merging_c1 + excess})
        first, second = critical_mu_on_belt(System(neighbour))
        assert (first.becomes, second.becomes) == ("stable", "unstable")
        gaps.append(second.mu - first.mu)
        between = neighbour.with_values({"mu": 0.5 * (first.mu + second.mu)})
        assert (
            growth_and_stability(System(between))[0]
            < 0.0
            < growth_and_stability(System(neighbour))[0]
        )
    # The excess falls by 100 each time, the gap by its root, 10.
    assert np.diff(np.log10(gaps)) == pytest.approx(-1.0, abs=0.05)


def scenes_with_falling_friction(count: int, seed: int) -> list[tuple[Parameters, bool]]:
    rng = np.random.default_rng(seed)
    scenes = []
    for number in range(count):
        uniform, mu = rng.uniform, float(rng.uniform(0.05, 1.0))
        ignored = number % 5 == 0
        p = Parameters(
            m=uniform(0.5, 6.0),
            k1=uniform(30.0, 150.0),
            k2=uniform(30.0, 100.0),
            k3=10.0 ** uniform(-1.0, 2.2) if number % 7 else 0.0,
            c1=uniform(0.0, 12.0),
            c2=uniform(0.1, 5.0),
            F=uniform(5.0, 120.0) * (-1.0 if ignored else 1.0),
            k_nl=uniform(0.0, 300.0) * (number % 2),
            mu=mu,
            mu_s=mu * uniform(1.0, 3.0),
            v_s=10.0 ** uniform(-1.0, 0.5),
            v_belt=10.0 ** uniform(-1.5, 0.7),
        )
        scenes.append((p, not ignored))
    return scenes


def test_on_random_scenes_all_changes_of_a_dense_scan_of_eigenvalues_are_listed() -> None:
    greatest_counts = {"mu": 0, "v_belt": 0}
    scenes = [
        *scenes_with_falling_friction(24, 7),
        (TWO_CRITICAL_MUS, True),
        (THREE_CRITICAL_SPEEDS, False),
    ]
    for p, separation in scenes:
        assert p.v_s is not None
        assert p.mu_s is not None
        critical_values = {
            "mu": [(c.mu, c.becomes) for c in critical_mu_on_belt(System(p, separation))],
            "v_belt": [(c.v_belt, c.becomes) for c in critical_speeds(System(p, separation))],
        }
        ranges = {"mu": (0.0, p.mu_s), "v_belt": (1e-6, 12.0 * p.v_s)}
        for name, listed in critical_values.items():
            grid = np.linspace(*ranges[name], 120).tolist()
            stable = [
                growth_and_stability(System(p.with_values({name: grid_value}), separation))[1]
                for grid_value in grid
            ]
            changes = [n for n in range(len(grid) - 1) if stable[n] != stable[n + 1]]
            listed_changes = [
                (value, next_stability)
                for value, next_stability in listed
                if value <= ranges[name][1]
            ]
            greatest_counts[name] = max(greatest_counts[name], len(listed_changes))
            assert len(listed_changes) == len(changes)
            for (value, next_stability), n in zip(listed_changes, changes, strict=True):
                assert grid[n] <= value <= grid[n + 1]
                assert (next_stability == "stable") == stable[n + 1]
                highest = ranges[name][1]
                before, after = (
                    growth_and_stability(System(p.with_values({name: neighbour}), separation))[0]
                    for neighbour in (value * (1.0 - 1e-9), min(value * (1.0 + 1e-9), highest))
                )
                assert before * after < 0.0
                assert (after < 0.0) == (next_stability == "stable")
    assert greatest_counts == {"mu": 2, "v_belt": 3}


def test_without_coupling_the_critical_mu_is_that_in_closed_form() -> None:
    expected = 0.5 - 10.0 * 0.4 / (80.0 * math.exp(-1.0))
    (critical,) = critical_mu_on_belt(System(UNCOUPLED))
    assert critical.mu == pytest.approx(expected, rel=1e-14)
    assert critical.becomes == "stable"
    # The relative effect of weak coupling is the ratio of its stiffness to the contact's.
    (weak,) = critical_mu_on_belt(System(UNCOUPLED.with_values({"k3": 6e-11})))
    assert weak.mu == pytest.approx(expected, rel=1e-11)
    assert weak.becomes == "stable"
    (speed,) = critical_speeds(System(UNCOUPLED.with_values({"k3": 6e-11})))
    assert speed.v_belt == pytest.approx(critical_speeds(System(UNCOUPLED))[0].v_belt, rel=1e-11)
    # A vertical motion without damping is never asymptotically stable.
    undamped = UNCOUPLED.with_values({"c2": 0.0})
    assert (critical_mu_on_belt(System(undamped)), critical_speeds(System(undamped))) == ((), ())
    assert stability(undamped).stable is False


@pytest.mark.parametrize(
    "values",
    [
        {"c1": 3e-13, "c2": 3e-10},
        {"c1": 0.0, "c2": 0.0},
        {"F": 8e-11},
        {"F": 0.0},
        {"v_s": 1e-12},
        {"v_s": 1e9, "v_belt": 1e-12},
        {"k_nl": 1e24, "F": 1e9},
        {"mu_s": 0.2},
        {"mu": 0.0, "mu_s": 100.0, "m": 1e9},
    ],
)
def test_extreme_parameters_give_ascending_positive_critical_values(
    values: dict[str, float],
) -> None:
    p = UNCOUPLED.with_values({"k3": 60.0, "mu": 0.2, **values})
    for result in (
        [c.mu for c in critical_mu_on_belt(System(p, separation=False))],
        [c.v_belt for c in critical_speeds(System(p, separation=False))],
    ):
        assert result == sorted(set(result))
        assert all(0.0 < value < math.inf for value in result)


@given(belts())
@settings(max_examples=30)
def test_the_linearisation_is_the_derivative_of_the_accelerations(p: Parameters) -> None:
    p = p.with_values({"v_belt": 0.2 + (p.v_belt or 0.0), "F": 10.0 + p.F})
    point = equilibrium(System(p))
    x, y = point.x, point.y
    matrix, step = np.array(jacobian(p, y, point.mode)), 1e-6
    assert accelerations(p, (x, 0.0, y, 0.0), point.mode) == pytest.approx((0.0, 0.0), abs=1e-9)
    for column in range(4):
        side_accelerations = []
        for offset in (-step, step):
            state = [x, 0.0, y, 0.0]
            state[column] += offset
            moved_state: State = (state[0], state[1], state[2], state[3])
            side_accelerations.append(np.array(accelerations(p, moved_state, point.mode)))
        slope = (side_accelerations[1] - side_accelerations[0]) / (2.0 * step)
        scale = 1.0 + np.abs(matrix).max()
        assert slope.tolist() == pytest.approx(matrix[[1, 3], column].tolist(), abs=1e-6 * scale)


def test_narrow_ranges_of_stability_are_listed() -> None:
    # Little vertical damping leaves a narrow range between self-excitation by friction and flutter.
    p = UNCOUPLED.with_values({"k3": 60.0, "mu": 0.2, "mu_s": 1.5, "c1": 1.0})
    widths = []
    for c2 in (1e-3, 1e-5, 1e-7):
        first, second = critical_speeds(System(p.with_values({"c2": c2})))[:2]
        assert (first.becomes, second.becomes) == ("stable", "unstable")
        widths.append(second.v_belt - first.v_belt)
    assert np.diff(np.log10(widths)) == pytest.approx(-2.0, abs=0.05)


def test_another_friction_law_gives_its_own_critical_speeds(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    original_law = friction_coefficient

    def rising_law(p: Any, speed: Any) -> Any:
        return original_law(p, speed) + 0.05 * speed

    for module in (field, belt):
        monkeypatch.setattr(module, "friction_coefficient", rising_law)
    for p in (
        TWO_CRITICAL_MUS,
        TWO_CRITICAL_MUS.with_values({"mu_s": None}),
        TWO_CRITICAL_MUS.with_values({"mu_s": 0.3}),
    ):
        assert depends_on_speed(p)
        listed = critical_speeds(System(p))
        assert listed
        for critical in listed:
            before, after = (
                growth_and_stability(System(p.with_values({"v_belt": critical.v_belt * factor})))[0]
                for factor in (1.0 - 1e-6, 1.0 + 1e-6)
            )
            assert before * after < 0.0
            assert (after < 0.0) == (critical.becomes == "stable")
        speeds = np.geomspace(1e-3, 1e4, 400).tolist()
        stable = [
            growth_and_stability(System(p.with_values({"v_belt": speed})))[1] for speed in speeds
        ]
        assert np.count_nonzero(np.diff(stable)) == len(listed)


def test_constant_friction_has_the_critical_mu_of_a_belt_that_is_always_faster() -> None:
    assert stability(Parameters(v_belt=1.0)).critical_mu == stability(Parameters()).critical_mu


@pytest.mark.parametrize("friction", [{}, {"mu_s": 1.0, "v_s": 0.5}])
def test_on_a_belt_at_rest_nothing_has_a_value_that_follows_from_sliding(
    friction: dict[str, float],
) -> None:
    p = Parameters(v_belt=0.0, **friction)
    with pytest.raises(ComputationError, match="no equilibrium of sliding: the belt is at rest"):
        stability(p)
    with pytest.raises(ComputationError, match="no equilibrium of sliding: the belt is at rest"):
        critical_mu_on_belt(System(p))
    result = sweep(p, vary={"v_belt": [0.0, 0.5]}, outputs=["critical_mu", "stable"])
    at_rest, moving = result.rows
    assert at_rest[2:5] == [None, None, "failed"]
    assert "the belt is at rest" in at_rest[5]
    assert moving[4:] == ["done", ""]
    over = {"v_belt": [0.0, 0.5], "F": [40.0, 80.0]}
    assert np.isnan(stability_map(p, over, "critical-mu").values[0]).all()
    growth = stability_map(p, over, "growth-rate").values
    assert np.isnan(growth).tolist() == [[True, True], [False, False]]
