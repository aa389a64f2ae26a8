"""Zones over one parameter, against eigenvalues and safe friction at independent points.

In the zone SMALL small disturbances die out, and the effect of large ones is not known. In SAFE
large ones die out as well; in KNOCK a large one causes squeal. In NONE there is no equilibrium.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from fivtui.equilibrium import critical_mu, stability
from fivtui.model import Cancelled, InputError, Parameters, System
from fivtui.safety import (
    SafeFriction,
    Zone,
    Zones,
    linear_zones,
    safe_friction,
    safe_mus,
    safety_zones,
    zones_of_safe_friction,
)

F_120 = Parameters(F=120.0)


def safe_mu_of(p: Parameters, separation: bool = True) -> float:
    return float(safe_mus(p, {}, np.array([separation]))[0])


def test_bounds_over_mu_are_safe_and_critical_mu() -> None:
    zones = safety_zones(System(F_120), "mu", 0.0, 1.5)
    assert zones.zones == (Zone.SAFE, Zone.KNOCK, Zone.SQUEALS)
    (critical,) = critical_mu(System(F_120))
    assert zones.bounds == (0.0, safe_mu_of(F_120), critical.mu, 1.5)


@pytest.mark.parametrize(("name", "high"), [("F", 150.0), ("k1", 150.0), ("c1", 0.5)])
def test_every_zone_agrees_with_the_verdict_at_its_middle(name: str, high: float) -> None:
    p = Parameters(mu=0.35)
    zones = safety_zones(System(p), name, 0.0, high)
    for index, zone in enumerate(zones.zones):
        middle = 0.5 * (zones.bounds[index] + zones.bounds[index + 1])
        p_at_middle = p.with_values({name: middle})
        assert zones.at(middle) is zone
        if not stability(p_at_middle).stable:
            assert zone is Zone.SQUEALS
        else:
            assert zone is (Zone.KNOCK if p.mu >= safe_mu_of(p_at_middle) else Zone.SAFE)


def test_bounds_over_another_parameter_are_where_mu_is_critical() -> None:
    zones = linear_zones(System(F_120), "F", 0.0, 150.0)
    assert zones.zones == (Zone.SMALL, Zone.SQUEALS, Zone.SMALL)
    for bound in zones.bounds[1:-1]:
        (critical,) = critical_mu(System(F_120.with_values({"F": bound})))
        assert critical.mu == pytest.approx(F_120.mu, rel=1e-3)


def test_zero_in_the_middle_of_a_range_does_not_decide_its_zone() -> None:
    assert linear_zones(System(Parameters(mu=0.2)), "F", -80.0, 80.0).zones == (Zone.SMALL,)
    p = Parameters(v_belt=1.0, mu_s=0.9, v_s=0.4, mu=0.3)
    assert linear_zones(System(p), "v_belt", -1.0, 1.0).zones == (Zone.SQUEALS,)


def test_a_narrow_zone_between_the_values_is_found() -> None:
    # Critical friction over the preload has a minimum; μ is just above it.
    def critical(preload: float) -> float:
        return critical_mu(System(Parameters(F=preload)))[0].mu

    minimum = minimize_scalar(
        critical, bounds=(20.0, 100.0), method="bounded", options={"xatol": 1e-9}
    )
    p, worst = Parameters(mu=minimum.fun * (1.0 + 2e-6)), float(minimum.x)
    # The initial scan has 129 values, here 1 N apart: the zone lies half way between two of them.
    low, high = worst - 10.5, worst + 117.5
    zones = linear_zones(System(p), "F", low, high)
    assert zones.zones == (Zone.SMALL, Zone.SQUEALS, Zone.SMALL)
    assert zones.at(worst) is Zone.SQUEALS
    width = zones.bounds[2] - zones.bounds[1]
    assert 0.0 < width < 0.5
    assert linear_zones(
        System(p.with_values({"mu": minimum.fun * 0.999})), "F", low, high
    ).zones == (Zone.SMALL,)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_narrow_zone_of_knocks_between_the_values_is_found(
    monkeypatch: pytest.MonkeyPatch, sign: float
) -> None:
    # The stub imitates cycles whose least μ over the preload is a parabola with its vertex in the
    # range: it differs from μ by at most 1e-6 within 0.316 N of the extremum.
    p, extremum = Parameters(mu=0.2), 71.3
    calls: list[float] = []

    def safe_mus_with_extremum(
        _p: Parameters, columns: dict[str, np.ndarray], _separation: object
    ) -> np.ndarray:
        (preload,) = columns["F"]
        calls.append(preload)
        return np.array([p.mu + sign * (1e-5 * (preload - extremum) ** 2 - 1e-6)])

    monkeypatch.setattr("fivtui.safety.zones.safe_mus", safe_mus_with_extremum)
    zones = safety_zones(System(p), "F", 50.0, 98.0)
    outside, inside = (Zone.SAFE, Zone.KNOCK) if sign > 0.0 else (Zone.KNOCK, Zone.SAFE)
    assert zones.zones == (outside, inside, outside)
    assert zones.bounds[1:3] == pytest.approx((extremum - 0.316, extremum + 0.316), abs=0.01)
    assert len(calls) < 80


def test_zones_are_not_safe_if_cycles_cannot_be_followed() -> None:
    undamped = Parameters(c1=0.0, c2=0.0)
    assert safety_zones(System(undamped), "mu", 0.0, 1.5).zones == (Zone.SMALL, Zone.SQUEALS)
    assert safety_zones(System(Parameters(k3=0.0)), "mu", 0.0, 1.5).zones == (Zone.SMALL,)
    belt = Parameters(v_belt=1.0, mu_s=0.9, v_s=0.4)
    on_belt = safety_zones(System(belt), "F", 0.0, 200.0)
    assert Zone.SAFE not in on_belt.zones
    assert Zone.KNOCK not in on_belt.zones
    # μ must not exceed μ_s.
    zones_over_mu = linear_zones(System(belt), "mu", 0.0, 1.5)
    assert zones_over_mu.at(1.0) is Zone.NONE
    assert zones_over_mu.bounds[-2] == pytest.approx(0.9, rel=1e-3)


def test_a_linear_system_is_safe_where_it_is_stable() -> None:
    linear = Parameters(k_nl=0.0)
    zones = safety_zones(System(linear, separation=False), "mu", 0.0, 1.5)
    assert zones.zones == (Zone.SAFE, Zone.SQUEALS)
    assert zones == linear_zones(System(linear, separation=False), "mu", 0.0, 1.5)


def test_zones_of_a_verdict_agree_with_those_of_continuation() -> None:
    verdict = safe_friction(F_120)
    zones, expected = (
        zones_of_safe_friction(verdict, 0.0, 1.5),
        safety_zones(System(F_120), "mu", 0.0, 1.5),
    )
    assert zones.zones == expected.zones
    assert zones.bounds == pytest.approx(expected.bounds, rel=1e-12)
    uncoupled = safe_friction(Parameters(k3=0.0))
    assert isinstance(uncoupled, SafeFriction)
    zones = zones_of_safe_friction(uncoupled, 0.0, 2.0 * uncoupled.searched_to)
    assert zones.zones == (Zone.SAFE, Zone.SMALL)
    assert zones.bounds[1] == uncoupled.searched_to


def test_values_outside_the_range_have_no_zone() -> None:
    zones = Zones("mu", (0.0, 1.0, 2.0), (Zone.SAFE, Zone.SQUEALS))
    assert [zones.at(value) for value in (-0.1, 0.0, 1.0, 2.0, 2.1)] == [
        None,
        Zone.SAFE,
        Zone.SQUEALS,
        Zone.SQUEALS,
        None,
    ]


def test_ranges_and_names_are_checked_and_zones_can_be_cancelled() -> None:
    with pytest.raises(InputError, match="range of F: must have a start below its end"):
        linear_zones(System(F_120), "F", 1.0, 1.0)
    with pytest.raises(InputError, match="unknown parameter"):
        linear_zones(System(F_120), "G", 0.0, 1.0)
    with pytest.raises(Cancelled):
        safety_zones(System(F_120), "F", 0.0, 150.0, progress=lambda _: False)
    # The computation succeeds after the cancelled one.
    assert math.isfinite(safe_mu_of(F_120))


def test_zones_above_an_unknown_safe_mu_are_not_safe() -> None:
    verdict = safe_friction(F_120)
    (cycle,) = verdict.others
    unknown = replace(verdict, safe_mu=None, unknown_above=0.1)
    zones = zones_of_safe_friction(unknown, 0.0, 1.5)
    assert zones.zones == (Zone.SAFE, Zone.SMALL, Zone.KNOCK, Zone.SQUEALS)
    assert zones.bounds[1:3] == (0.1, cycle.mu)
    zones_without_bound = zones_of_safe_friction(replace(unknown, unknown_above=0.0), 0.0, 1.5)
    assert zones_without_bound.zones == (Zone.SMALL, Zone.KNOCK, Zone.SQUEALS)
    assert zones.without_safe() == zones_without_bound
