"""A belt that runs backward, at a constant negative speed."""

from typing import Any, Final

import numpy as np
import pytest

from fivtui import InputError, Parameters, branch, simulate, simulate_batch, stability
from fivtui.equilibrium import growth_rate
from fivtui.equilibrium.scan import mode_scan
from fivtui.model import ComputationError, Mode, System, equilibrium
from fivtui.orbits import coexistence, transients_phrase
from fivtui.orbits.decay import DecayRegion
from fivtui.orbits.explorer import Kind

START: Final = (0.0, 0.0, -0.5, 3.0)
FRICTION: Final[list[dict[str, float]]] = [
    {"v_belt": -2.0},
    {"v_belt": -1.0, "mu_s": 0.9},
    {"v_belt": -0.3, "mu_s": 0.9, "v_s": 0.4},
]


def accelerations(p: Parameters, z: Any) -> list[float]:
    """Rates of change of (x, ẋ, y, ẏ) in contact, sliding on a belt that the slider outruns."""
    x, vx, y, vy = z
    assert p.v_belt is not None
    assert vx > p.v_belt
    mu = p.mu
    if p.mu_s is not None and p.v_s is not None:
        mu += (p.mu_s - p.mu) * np.exp(-(vx - p.v_belt) / p.v_s)
    force, coupling = -p.k2 * y - p.k_nl * y**3, 0.5 * p.k3 * (x - y)
    ax = (-mu * force - p.c1 * vx - p.k1 * x - coupling) / p.m
    return [vx, ax, vy, (force - p.F - p.c2 * vy + coupling) / p.m]


@pytest.mark.parametrize("friction", FRICTION)
def test_all_methods_and_both_fmus_agree(friction: dict[str, float]) -> None:
    p = Parameters(**friction)
    run = simulate(p, t_end=3.0, start=START)
    assert run.events.sticks > 0
    for method, options, tolerance in (
        ("rk4", {"step": 2e-3}, 1e-5),
        ("scipy-dop853", {"tol": 1e-11}, 1e-7),
        ("fmu-native", {}, 1e-9),
        ("fmu", {}, 1e-9),
        ("taylor", {"kernel": "interpreted"}, 1e-9),
    ):
        other: Any = simulate(p, t_end=3.0, start=START, method=method, **options)
        assert list(other.final) == pytest.approx(list(run.final), abs=tolerance), method
        assert other.events.transitions == run.events.transitions, method
    batch = simulate_batch({"v_belt": [friction["v_belt"]] * 9}, base=p, t_end=3.0, start=START)
    assert set(batch.to_columns()["y_abs"].tolist()) == {run.peak.y_abs}


@pytest.mark.parametrize("friction", FRICTION)
def test_stability_is_that_of_numerical_derivatives(friction: dict[str, float]) -> None:
    p = Parameters(**friction)
    result = stability(p)
    point = result.equilibrium
    rest = np.array([point.x, 0.0, point.y, 0.0])
    assert point.mode is Mode.BACKWARD
    assert accelerations(p, rest) == pytest.approx([0.0] * 4, abs=1e-12)
    steps = 1e-5 * np.eye(4)
    matrix = np.array(
        [(np.array(accelerations(p, rest + d)) - accelerations(p, rest - d)) / 2e-5 for d in steps]
    ).T
    assert result.growth_rate == pytest.approx(np.linalg.eigvals(matrix).real.max(), abs=1e-7)


def test_constant_friction_has_no_critical_mu_up_to_the_last_equilibrium() -> None:
    p = Parameters(v_belt=-1.0)
    result = stability(p)
    assert (result.critical_mu, result.linear_critical_mu, result.coalescence.mu) == (
        (),
        None,
        None,
    )
    # Above a/h = 13/3 the balance of forces is not unique.
    scan = mode_scan(System(p), 6.0)
    assert scan.mu[-1] == pytest.approx(13.0 / 3.0, abs=6.0 / 240)
    assert scan.eigenvalues.real.max() < 0.0
    with pytest.raises(ComputationError, match="no unique equilibrium: the belt runs backward"):
        equilibrium(System(p.with_values({"mu": 4.4})))


def test_falling_friction_has_critical_values_of_zero_growth() -> None:
    p = Parameters(v_belt=-2.0, mu_s=0.9, v_s=0.4)
    result = stability(p)
    (mu,), (speed,) = result.critical_mu, result.critical_speed
    assert (mu.becomes, speed.becomes) == ("stable", "stable")
    assert -2.0 < speed.v_belt < 0.0
    for name, value in (("mu", mu.mu), ("v_belt", speed.v_belt)):
        below, at, above = (
            growth_rate(System(p.with_values({name: factor * value})))
            for factor in (0.99, 1.0, 1.01)
        )
        assert below > 0.0 > above
        assert at == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("friction", [*FRICTION[:1], {"v_belt": -2.0, "mu_s": 0.9, "v_s": 0.4}])
def test_motion_decays_in_the_region_of_proven_decay(friction: dict[str, float]) -> None:
    system = System(Parameters(**friction))
    region = DecayRegion(system, equilibrium(system))
    assert region.offset > 0.0
    x, _, y, _ = region.rest.tolist()
    start = (x, 0.0, y + 0.99 * region.offset, 0.0)
    run = simulate(system.parameters, t_end=100.0, start=start)
    assert run.steady.y_half_range < region.offset
    assert run.events.transitions == {}


def test_searches_find_rest_and_name_a_command_that_takes_such_belts() -> None:
    result = coexistence(System(Parameters(v_belt=-1.0)))
    assert [attractor.kind for attractor in result.attractors] == [Kind.EQUILIBRIUM]
    assert "(fivtui attractors --vary mu=0.2:1:9 follows" in transients_phrase(result)


def test_branches_refuse_it_in_one_line() -> None:
    for p, options in (
        (Parameters(v_belt=-1.0), {"name": "mu"}),
        (Parameters(v_belt=1.0), {"name": "v_belt", "low": -1.0, "high": 2.0}),
    ):
        with pytest.raises(InputError, match="v_belt = -1: must not be negative for branches"):
            branch(p, **options)
