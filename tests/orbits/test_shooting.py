"""Periodic orbits found by shooting, against identities and transients."""

import numpy as np
import pytest

from fivtui import Parameters, simulate
from fivtui.model import Mode, State, System
from fivtui.model.errors import ComputationError
from fivtui.orbits.curves.flow import FloatArray
from fivtui.orbits.shooting import PeriodicOrbit, Section, shoot
from fivtui.transient import Start, Transient
from tests.support.kernels import INTERPRETED

# A set at which a limit cycle coexists with the stable equilibrium.
COEXISTENCE = Parameters(F=120.0)


def separation_times(run: Transient) -> FloatArray:
    # Separations and reattachments alternate; a run that starts off the belt first reattaches.
    first_separation = 0 if run.first_mode is Mode.CONTACT else 1
    return run.switch_times[first_separation::2]


def guess_cycle(p: Parameters, t_end: float, start: Start = "static") -> tuple[State, float]:
    # State and period: the state at the second-last separation of a transient, and the time from it
    # to the last one.
    run = simulate(p, t_end=t_end, start=start, samples="dense", kernel="interpreted")
    assert run.solution is not None
    before, after = separation_times(run)[-2:]
    state = run.solution([before])
    return (float(state.x[0]), float(state.vx[0]), 0.0, float(state.vy[0])), float(after - before)


@pytest.fixture(scope="module")
def base_orbit() -> PeriodicOrbit:
    return shoot(System(Parameters()), *guess_cycle(Parameters(), 100.0), Section.LIFT_OFF)


def test_the_base_scene_settles_on_the_known_cycle(base_orbit: PeriodicOrbit) -> None:
    assert base_orbit.period == pytest.approx(1.3264574885, abs=1e-10)
    assert base_orbit.start[2] == 0.0
    assert base_orbit.start[3] == pytest.approx(16.6114178, abs=1e-7)
    assert base_orbit.residual < 1e-11
    assert base_orbit.separations == 1
    assert base_orbit.stable


def test_without_a_compiled_kernel_the_orbit_is_the_same(base_orbit: PeriodicOrbit) -> None:
    with INTERPRETED:
        orbit = shoot(System(Parameters()), base_orbit.start, base_orbit.period, Section.LIFT_OFF)
    assert orbit.period == pytest.approx(base_orbit.period, rel=1e-12)
    assert orbit.multipliers == pytest.approx(base_orbit.multipliers, abs=1e-9)


def test_a_long_transient_ends_on_the_orbit(base_orbit: PeriodicOrbit) -> None:
    run = simulate(Parameters(), t_end=1200.0, kernel="interpreted")
    assert base_orbit.half_range == pytest.approx(run.steady.y_half_range, rel=1e-6)
    share = base_orbit.separated_time / base_orbit.period
    later_run = simulate(
        Parameters(),
        t_end=100.0 * base_orbit.period,
        start=base_orbit.start,
        kernel="interpreted",
    )
    assert later_run.events.separated_time / later_run.t_end == pytest.approx(share, rel=1e-9)
    assert later_run.final.vy == pytest.approx(base_orbit.start[3], rel=1e-9)


def test_the_decay_of_a_transient_is_that_of_the_largest_multiplier(
    base_orbit: PeriodicOrbit,
) -> None:
    # The distance from the orbit, from lift-off to lift-off, falls like |λ|ⁿ.
    run = simulate(Parameters(), t_end=300.0, samples="dense", kernel="interpreted")
    assert run.solution is not None
    states = run.solution(separation_times(run)[100:200])
    deviations = np.stack([states.x, states.vx, states.vy], axis=1) - np.delete(base_orbit.start, 2)
    # A complex pair of multipliers makes deviations oscillate: compare the greatest ones of the
    # first and of the last 20 periods.
    window = 20
    early, late = np.abs(deviations[:window]).max(), np.abs(deviations[-window:]).max()
    measured_multiplier = (late / early) ** (1.0 / (len(deviations) - window))
    assert measured_multiplier == pytest.approx(np.abs(base_orbit.multipliers[0]), abs=2e-3)


def test_the_coexisting_cycle_is_large_and_attracts() -> None:
    orbit = shoot(System(COEXISTENCE), *guess_cycle(COEXISTENCE, 400.0), Section.LIFT_OFF)
    assert orbit.half_range == pytest.approx(7.44345, abs=1e-5)
    assert orbit.stable


@pytest.mark.parametrize(
    ("p", "start"),
    [
        (Parameters(), "static"),
        (COEXISTENCE, "static"),
        # From the static start this motion would come to rest.
        (Parameters(mu=0.3), (0.0, 0.0, 1.5, 3.0)),
    ],
)
def test_the_product_of_the_multipliers_is_the_contraction_of_volume(
    p: Parameters, start: Start
) -> None:
    # Liouville: the divergence of the field is −(c1 + c2)/m everywhere; one multiplier is 1.
    orbit = shoot(System(p), *guess_cycle(p, 200.0, start), Section.LIFT_OFF)
    contraction = np.exp(-(p.c1 + p.c2) / p.m * orbit.period)
    assert np.prod(orbit.multipliers) == pytest.approx(contraction, rel=1e-11)


def test_a_guess_of_two_periods_finds_the_orbit_of_one_period(base_orbit: PeriodicOrbit) -> None:
    orbit = shoot(System(Parameters()), base_orbit.start, 2.0 * base_orbit.period, Section.LIFT_OFF)
    assert orbit.period == pytest.approx(base_orbit.period, rel=1e-10)
    assert orbit.multipliers == pytest.approx(base_orbit.multipliers, abs=1e-8)


def test_shooting_that_converges_to_the_equilibrium_raises_an_error() -> None:
    with pytest.raises(ComputationError, match="converged to the equilibrium"):
        shoot(System(Parameters(mu=0.2)), (0.01, 0.0, -0.64, 0.0), 1.0, Section.LOWEST_POINT)


def test_shooting_without_an_orbit_nearby_raises_an_error() -> None:
    with pytest.raises(ComputationError, match="no periodic orbit"):
        shoot(System(Parameters(mu=0.0)), (3.0, 0.0, 0.0, 9.0), 1.3, Section.LIFT_OFF)
