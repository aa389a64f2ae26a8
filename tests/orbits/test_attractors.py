"""Attractors: coexistence, basins and continuation, against transients and eigenvalues.

Where attractors coexist, the start decides which of them motion reaches. The escape offset is the
least displacement of y from rest, up or down, from which motion does not return to rest. A
continuation follows attractors along a parameter, in the directions up and down.
"""

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st

from fivtui import Parameters, simulate, stability
from fivtui.model import System
from fivtui.model.errors import ComputationError, InputError
from fivtui.model.slider_belt import equilibrium
from fivtui.orbits import explorer
from fivtui.orbits.attractor_continuation import BranchPoint, Continuation, continuation
from fivtui.orbits.attractor_search import Coexistence, coexistence, find_attractors
from fivtui.orbits.basins import EscapeOffset, basin, escape_offset
from fivtui.orbits.decay import DecayRegion
from fivtui.orbits.explorer import Attractor, Explorer, Kind
from fivtui.orbits.shooting import PeriodicOrbit
from fivtui.transient import Transient, integrate
from tests.support.kernels import INTERPRETED
from tests.support.strategies import moderate_parameters

# A set at which a limit cycle coexists with the stable equilibrium.
COEXISTENCE = Parameters(F=120.0)


@pytest.fixture(scope="module")
def base_coexistence() -> Coexistence:
    return coexistence(System(COEXISTENCE))


def test_a_stable_equilibrium_is_found_to_coexist_with_a_separating_limit_cycle(
    base_coexistence: Coexistence,
) -> None:
    assert stability(COEXISTENCE).stable
    assert [attractor.kind for attractor in base_coexistence.attractors] == [
        Kind.EQUILIBRIUM,
        Kind.SEPARATING_CYCLE,
    ]
    assert base_coexistence.attractors[1].half_range == pytest.approx(7.44, abs=5e-3)
    assert base_coexistence.coexists


def test_an_offset_of_a_tenth_dies_out_and_one_of_three_tenths_does_not(
    base_coexistence: Coexistence,
) -> None:
    assert base_coexistence.escape is not None
    assert base_coexistence.escape.up is not None
    assert 0.1 < base_coexistence.escape.up < 0.3
    assert base_coexistence.escape.down is not None
    assert base_coexistence.escape.down > 0.1
    rest = equilibrium(System(COEXISTENCE))

    def late_half_range(displacement: float) -> float:
        start = (rest.x, 0.0, rest.y + displacement, 0.0)
        run = simulate(COEXISTENCE, t_end=1500.0, tol=1e-9, start=start, kernel="compiled")
        return run.steady.y_half_range

    for displacement in (base_coexistence.escape.up, -base_coexistence.escape.down):
        assert late_half_range(0.999 * displacement) < 1e-6
        assert late_half_range(1.001 * displacement) == pytest.approx(7.44345, abs=1e-2)


def test_the_limit_cycle_of_the_base_scene_is_its_only_attractor() -> None:
    result = coexistence(System(Parameters()))
    (cycle,) = result.attractors
    assert cycle.kind is Kind.SEPARATING_CYCLE
    assert cycle.orbit is not None
    assert cycle.orbit.period == pytest.approx(1.3264574885, abs=1e-10)
    assert cycle.orbit.start[3] == pytest.approx(16.6114178, abs=1e-7)
    assert not result.coexists
    assert result.escape is None
    assert escape_offset(System(Parameters())) is None


def test_with_separation_ignored_the_cycle_keeps_contact() -> None:
    (cycle,) = find_attractors(System(Parameters(), separation=False)).attractors
    run = simulate(Parameters(), t_end=1200.0, separation=False, kernel="compiled")
    assert cycle.kind is Kind.CONTACT_CYCLE
    assert cycle.half_range == pytest.approx(run.steady.y_half_range, rel=1e-6)


def test_both_kernels_find_the_same_attractor() -> None:
    compiled, interpreted = (
        Explorer(System(COEXISTENCE), kernel=kernel).reach("static")
        for kernel in ("compiled", "interpreted")
    )
    assert interpreted.equals(compiled)


def test_without_a_compiled_kernel_motions_are_followed_interpreted() -> None:
    weak_friction = Parameters(F=120.0, mu=0.2)
    with INTERPRETED:
        assert Explorer(System(weak_friction)).reach("static") == Attractor(Kind.EQUILIBRIUM)


def test_linear_motion_without_separation_grows_without_bounds_or_dies_out() -> None:
    linear = Parameters(k_nl=0.0)
    for mu, kind in ((1.2, Kind.UNBOUNDED), (0.9, Kind.EQUILIBRIUM)):
        (attractor,) = find_attractors(
            System(linear.with_values({"mu": mu}), separation=False)
        ).attractors
        assert attractor == Attractor(kind)


def test_a_slider_lifted_off_the_belt_can_be_knocked_into_a_cycle() -> None:
    p = Parameters(F=-10.0)
    rest, cycle = find_attractors(System(p)).attractors
    assert rest == Attractor(Kind.EQUILIBRIUM)
    run = simulate(p, t_end=1500.0, start=(0.1, 0.0, 5.0, 0.0), kernel="compiled")
    assert cycle.half_range == pytest.approx(run.steady.y_half_range, rel=1e-6)


@settings(max_examples=20)
@given(moderate_parameters(), st.tuples(*[st.floats(-1.0, 1.0)] * 4))
def test_in_the_region_of_proven_decay_motion_dies_out(
    p: Parameters, direction: tuple[float, float, float, float]
) -> None:
    point = equilibrium(System(p))
    region = DecayRegion(System(p), point)
    assume(p.F > 1.0 and region.radius > 0.0 and np.linalg.norm(direction) > 0.1)
    assert stability(p).stable
    rest = np.array([point.x, 0.0, point.y, 0.0])
    # The start is at the edge of the region, found by bisection of the distance from rest.
    distance, too_far = 0.0, 1e3
    for _ in range(60):
        middle = 0.5 * (distance + too_far)
        x, vx, y, vy = (rest + middle * np.array(direction)).tolist()
        if region.contains((x, vx, y, vy)):
            distance = middle
        else:
            too_far = middle
    start = rest + distance * np.array(direction)
    decay = -stability(p).growth_rate
    assume(0.01 < decay < 100.0)
    run = simulate(p, t_end=12.0 / decay, tol=1e-9, start=start.tolist(), kernel="compiled")
    final_state = np.array([run.final.x, run.final.vx, run.final.y, run.final.vy])
    assert run.events.separations == 0
    assert np.linalg.norm(final_state - rest) < 0.1 * np.linalg.norm(start - rest)


def test_a_slice_of_the_basins_agrees_with_transients() -> None:
    point = equilibrium(System(COEXISTENCE))
    offsets = np.array([-0.3, -0.05, 0.05, 0.3])
    result = basin(COEXISTENCE, {"y0": point.y + offsets, "vy0": [0.0, 2.0]})
    kinds = np.array([attractor.kind for attractor in result.attractors])[result.reached]
    reaches_equilibrium = kinds == Kind.EQUILIBRIUM
    assert reaches_equilibrium.tolist() == [
        [False, False],
        [True, False],
        [True, False],
        [False, False],
    ]
    assert result.start == (point.x, 0.0, point.y, 0.0)


def test_fixed_components_of_a_start_can_be_set() -> None:
    over = {"x0": [0.0, 5.0], "vx0": [0.0]}
    assert basin(Parameters(), over, start="static").start[0] != 0.0
    result = basin(COEXISTENCE, over, start=(0.0, 0.0, 3.0, 0.0))
    assert result.start == (0.0, 0.0, 3.0, 0.0)
    assert result.reached.shape == (2, 1)


@pytest.fixture(scope="module")
def found_directions() -> dict[float, dict[Kind, tuple[str, ...]]]:
    result = continuation(Parameters(), "mu", [0.2, 0.3, 0.4, 0.5])
    assert result.coexisting == [0.3, 0.4]
    directions_by_value: dict[float, dict[Kind, tuple[str, ...]]] = {}
    for point in result.points:
        directions_by_value.setdefault(point.value, {})[point.attractor.kind] = point.directions
    return directions_by_value


def test_coexistence_shows_as_hysteresis_up_and_down_a_parameter(
    found_directions: dict[float, dict[Kind, tuple[str, ...]]],
) -> None:
    both_ways = ("up", "down")
    assert found_directions[0.2] == {Kind.EQUILIBRIUM: both_ways}
    assert found_directions[0.3] == {Kind.EQUILIBRIUM: ("up",), Kind.SEPARATING_CYCLE: ("down",)}
    assert found_directions[0.4] == {Kind.EQUILIBRIUM: ("up",), Kind.SEPARATING_CYCLE: ("down",)}
    assert found_directions[0.5] == {Kind.SEPARATING_CYCLE: both_ways}


def test_a_start_on_an_attractor_reaches_that_attractor(
    base_coexistence: Coexistence,
) -> None:
    explorer = Explorer(System(COEXISTENCE))
    cycle = base_coexistence.attractors[1]
    assert cycle.orbit is not None
    assert explorer.reach(cycle.orbit.start).equals(cycle)
    assert explorer.reach(explorer.rest) == Attractor(Kind.EQUILIBRIUM)


@pytest.mark.parametrize(
    ("over", "message"),
    [
        ({"y0": [0.0]}, "two different ones"),
        ({"y0": [0.0], "z0": [0.0]}, "unknown start value 'z0'"),
        ({"y0": [0.0], "vy0": [np.nan]}, "not a finite number"),
        ({"y0": [], "vy0": [1.0]}, "one or more numbers"),
        ({"y0": np.zeros(2000), "vy0": np.zeros(2000)}, "4000000 starts"),
    ],
)
def test_a_wrong_slice_is_refused(over: dict[str, list[float]], message: str) -> None:
    with pytest.raises(InputError, match=message):
        basin(COEXISTENCE, over)


def test_a_wrong_continuation_is_refused() -> None:
    with pytest.raises(InputError, match="unknown parameter"):
        continuation(COEXISTENCE, "nu", [1.0, 2.0])
    with pytest.raises(InputError, match="two or more different"):
        continuation(COEXISTENCE, "mu", [1.0, 1.0])
    with pytest.raises(InputError, match="must be from 0"):
        continuation(COEXISTENCE, "mu", [-1.0, 1.0])


def test_unsettled_motions_are_reported_and_are_no_coexistence() -> None:
    rest, unsettled = Attractor(Kind.EQUILIBRIUM), Attractor(Kind.UNSETTLED)
    result = Coexistence(
        System(COEXISTENCE), (rest, unsettled), reached=(0, 1), stable=True, escape=None
    )
    assert not result.coexists
    assert result.warning == "some motions did not settle in the time allowed"
    points = tuple(BranchPoint(0.5, ("up",), attractor) for attractor in (rest, unsettled))
    assert Continuation(System(COEXISTENCE), "mu", np.array([0.5]), points).coexisting == []


def test_growth_without_bounds_beside_the_equilibrium_gives_a_warning() -> None:
    pair = (Attractor(Kind.EQUILIBRIUM), Attractor(Kind.UNBOUNDED))
    offset = EscapeOffset(0.5, None)
    result = Coexistence(System(COEXISTENCE), pair, reached=(1, 0), stable=True, escape=offset)
    message = result.warning
    assert message is not None
    assert "with unbounded growth; no return after a release at rest 0.5 m above it" in message


@pytest.mark.parametrize("fails", [True, False])
def test_shooting_runs_once_in_every_leg_if_it_fails_or_finds_a_distant_orbit(
    fails: bool, base_coexistence: Coexistence, monkeypatch: pytest.MonkeyPatch
) -> None:
    cycle = base_coexistence.attractors[1].orbit
    assert cycle is not None
    distant_orbit = dataclasses.replace(cycle, start=(1e3, 0.0, 0.0, 0.0))
    legs: list[object] = []
    legs_at_calls: list[int] = []

    def shoot(*_: object, **__: object) -> PeriodicOrbit:
        legs_at_calls.append(len(legs))
        if fails:
            raise ComputationError("no orbit", "none")
        return distant_orbit

    def integrate_leg(*args: Any, **options: Any) -> Transient:
        legs.append(None)
        return integrate(*args, **options)

    monkeypatch.setattr(explorer, "shoot", shoot)
    monkeypatch.setattr(explorer, "integrate", integrate_leg)
    # The explorer integrates motions in legs of equal duration. In each leg on the cycle the states
    # at separations repeat, so that after it the explorer shoots: it solves for a periodic orbit.
    assert Explorer(System(COEXISTENCE)).reach(cycle.start, max_legs=5) == Attractor(Kind.UNSETTLED)
    assert legs_at_calls == [1, 2, 3, 4, 5]


def test_without_damping_motion_does_not_settle() -> None:
    undamped = Parameters(c1=0.0, c2=0.0, mu=0.0)
    start = (0.0, 0.0, -0.5, 0.0)
    assert Explorer(System(undamped)).reach(start) == Attractor(Kind.UNSETTLED)


def test_progress_rises_to_one() -> None:
    fractions: list[float] = []

    def record(fraction: float) -> bool:
        fractions.append(fraction)
        return True

    assert isinstance(coexistence(System(COEXISTENCE), progress=record).escape, EscapeOffset)
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0
