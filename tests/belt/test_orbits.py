"""Limit cycles on a belt of finite speed: attractors and multipliers.

An `Explorer` follows the motion of one parameter set from a start to its attractor. `UNIT_MASS` is
a mass without coupling with m, k1, k2 and F of 1, mu = 0.5 and mu_s = 1.
"""

import json
import math

import numpy as np
import pytest

from fivtui import Parameters, attractors, simulate
from fivtui.cli import run
from fivtui.model import System
from fivtui.model.slider_belt import accelerations, equilibrium
from fivtui.orbits import DecayRegion, Explorer, continuation
from fivtui.orbits.explorer import Attractor, Kind, _cycle_attractor
from fivtui.orbits.report import print_attractors
from fivtui.orbits.rest import sticks_forever
from fivtui.orbits.shooting import PeriodicOrbit, Section
from fivtui.transient import Start

from .test_motion import CYCLE_PERIOD, UNIT_MASS


def reach_orbit(p: Parameters, start: Start) -> PeriodicOrbit:
    orbit = Explorer(System(p)).reach(start).orbit
    assert orbit is not None
    return orbit


def test_a_mass_on_a_belt_settles_on_the_cycle_in_closed_form() -> None:
    p = UNIT_MASS.with_values({"c2": 0.1})
    orbit = reach_orbit(p, (0.0, 0.2, -1.0, 0.0))
    assert orbit.period == pytest.approx(CYCLE_PERIOD, rel=1e-12)
    assert (orbit.section, orbit.sticks, orbit.start[1]) == (Section.STICK, 1, 0.2)
    assert orbit.stick_time == pytest.approx(5.0, rel=1e-12)
    # The stick removes horizontal deviations; vertically the slider is a damped oscillator.
    assert orbit.multipliers[2] == 0.0
    vertical_decay = math.exp(-p.c2 / (2.0 * p.m) * CYCLE_PERIOD)
    assert np.abs(orbit.multipliers[:2]) == pytest.approx(vertical_decay, rel=1e-9)


def test_multipliers_are_eigenvalues_of_differences_of_the_return_map() -> None:
    p = Parameters(v_belt=1.0, mu_s=0.9, v_s=0.4)
    orbit = reach_orbit(p, "static")
    assert orbit.stable
    assert (orbit.sticks, orbit.separations) == (1, 1)
    columns = []
    # Deviations of x, y and ẏ: the orbit begins in a stick, where ẋ is the belt speed.
    for column in (0, 2, 3):
        final_states = []
        for size in (-1e-6, 1e-6):
            start = list(orbit.start)
            start[column] += size
            final_states.append(simulate(p, t_end=orbit.period, tol=1e-13, start=start).final)
        low, high = (np.array([end.x, end.y, end.vy]) for end in final_states)
        columns.append((high - low) / 2e-6)
    values = np.linalg.eigvals(np.array(columns).T)
    # A deviation along the orbit has the multiplier 1, which `multipliers` omits; the stick adds 0.
    along_orbit, *across_orbit = values[np.argsort(np.abs(values - 1.0))]
    assert along_orbit == pytest.approx(1.0, abs=1e-6)
    assert np.sort(across_orbit) == pytest.approx(np.sort(orbit.multipliers[:2].real), abs=1e-6)
    assert orbit.multipliers[2] == 0.0


@pytest.mark.whole
def test_two_stick_slip_cycles_coexist() -> None:
    p = Parameters(v_belt=0.4, mu=0.3, mu_s=0.5, v_s=0.4, c1=10.0)
    x, _, y, _ = Explorer(System(p)).rest
    small, large = reach_orbit(p, (x, 0.0, y + 0.01, 0.0)), reach_orbit(p, (x, 0.0, y + 1.0, 0.0))
    assert (small.separations, large.separations) == (0, 1)
    assert small.multipliers[2] == large.multipliers[2] == 0.0
    assert small.half_range == pytest.approx(0.0387832, rel=1e-5)
    assert {_cycle_attractor(cycle).kind for cycle in (small, large)} == {Kind.STICK_SLIP_CYCLE}


def test_on_a_belt_at_rest_the_slider_sticks_for_ever() -> None:
    p = Parameters(v_belt=0.0)
    result = attractors(p)
    assert [attractor.kind for attractor in result.attractors] == [Kind.STICK]
    assert (result.coexists, result.others, result.escape) == (False, (), None)
    assert "sticks to the belt at rest" in str(result)
    assert Attractor(Kind.STICK).half_range == 0.0
    # The energy of the vertical motion decides which starts stick for ever.
    x, y = -0.1, -0.67
    fastest = next(
        v for v in np.arange(10.0, 0.0, -0.01) if sticks_forever(p, (x, 0.0, y, float(v)))
    )
    assert fastest > 0.5
    run = simulate(p, t_end=30.0, start=(x, 0.0, y, float(fastest)))
    assert run.events.transitions == {}
    assert not sticks_forever(p, (x, 0.0, 0.1, 0.0))


@pytest.mark.parametrize("v_s", [None, 0.5])
def test_motion_decays_everywhere_in_the_region_of_proven_decay(v_s: float | None) -> None:
    p = Parameters(v_belt=2.0, mu=0.2, mu_s=0.4, v_s=v_s, c1=3.0, c2=3.0)
    point = equilibrium(System(p))
    region = DecayRegion(System(p), point)
    assert region.radius > 0.0
    rng = np.random.default_rng(5)
    states = region.rest + rng.normal(size=(2000, 4)) * [1.0, 5.0, 1.0, 5.0]
    modal = region._modal
    sizes = np.linalg.norm((states - region.rest) @ modal.T, axis=1)
    states = region.rest + (states - region.rest) * (0.999 * region.radius / sizes)[:, None]
    assert region.contains_states(states).all()
    assert (states[:, 2] < 0.0).all()
    assert (states[:, 1] < 2.0).all()
    for x, vx, y, vy in states.tolist():
        q = modal @ (np.array([x, vx, y, vy]) - region.rest)
        ax, ay = accelerations(p, (x, vx, y, vy), point.mode)
        q_rate = modal @ np.array([vx, ax, vy, ay])
        # |q|² falls: this is half of its rate.
        assert float((np.conj(q) @ q_rate).real) < 0.0


@pytest.mark.whole
def test_continuation_follows_cycles_along_the_speed_of_the_belt() -> None:
    result = continuation(UNIT_MASS.with_values({"c2": 0.2}), "v_belt", [0.2, 0.4])
    # With c1 = 0 a mass that oscillates more slowly than the belt does not settle.
    cycles = [point for point in result.points if point.attractor.kind is Kind.STICK_SLIP_CYCLE]
    assert [point.value for point in cycles] == [0.2, 0.4]
    for point in cycles:
        slip = 2.0 * (math.pi - math.atan(0.5 / point.value))
        orbit = point.attractor.orbit
        assert orbit is not None
        assert orbit.period == pytest.approx(1.0 / point.value + slip, rel=1e-11)
    assert np.nansum(result.to_columns()["sticks"]) == 2.0


def test_the_command_prints_multipliers_and_sticks(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["attractors", "--set", "v_belt=1", "--start", "static", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["kind"] == "stick-slip limit cycle"
    assert (data["sticks"], data["section"]) == (1, "stick")
    assert data["floquet_multipliers"][2] == [0.0, 0.0]
    assert run(["attractors", "--vary", "v_s=0.1:0.4:2"]) == 2
    assert "v_belt = none: must have a value to vary v_s" in capsys.readouterr().err


def test_sticks_of_a_cycle_are_printed_in_a_column_beside_their_time(
    capsys: pytest.CaptureFixture[str],
) -> None:
    cycle = Explorer(System(Parameters(v_belt=1.0, mu_s=0.9, v_s=0.4))).reach("static")
    orbit = cycle.orbit
    assert orbit is not None
    print_attractors([cycle])
    rows = capsys.readouterr().out.split("\n")
    share = f"({orbit.stick_time / orbit.period:.1%})"
    assert any("sticks" in row and "time of stick s" in row for row in rows)
    assert any(f" {orbit.sticks} " in row and share in row for row in rows)
